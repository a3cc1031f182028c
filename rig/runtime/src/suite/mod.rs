//! Many plans: their files, their cases, and several cases at once.

pub mod board_instrument;
pub(crate) mod case_export;
pub mod case_files;
pub mod describe;
pub mod file_source;
pub mod instrument_file;
pub(crate) mod plant_programs;
pub(crate) mod ports;
pub mod real_boards;
pub mod suites;

use crate::application::{blocks, modules};
use crate::codes;
use crate::suite::case_files::{CaseFiles, OtherProgram};
pub use crate::suite::file_source::{Disk, FileSource, beside, load, load_program};
use crate::suite::plant_programs::{BoardPrograms, ReadPrograms};
use document::{Diagnostic, SourceFile};
use drivers::file::{
    BoardFile, ModuleTerminal, ModuleTerminalKind, Subject as BoardSubject, SubjectPort, SubjectPortKind,
    Terminals, UnknownSubject, read_with_programs,
};
use drivers::sensor::SensorCurve;
use plans::plan::{GlobalChecks, PlanText};
use plans::steps::ProgramRef;
use plans::steps::Stimulus;
use plans::{Case, Plan};
use profile::{AnalogueMode, ChannelAddresses, ConfiguredModule, PortKind, Profile, Reference, SerialMedia};
use signal::{Address, Area, Unit};
use std::ops::Range;
use std::sync::Arc;

/// The terminals of a board file's subject.
///
/// # Errors
/// [`UnknownSubject`] with the names that exist.
pub fn terminals(subject: &BoardSubject) -> Result<Terminals, UnknownSubject> {
    let (_, reference) = subject_of(subject)?;
    Ok(terminals_of(reference))
}

fn terminals_of(reference: &'static Reference) -> Terminals {
    let inputs =
        profile::inputs(reference).map(|input| Address::bit(Area::Input, input.byte * 8 + input.bit));
    let outputs =
        profile::outputs(reference).map(|output| Address::bit(Area::Output, output.byte * 8 + output.bit));
    let ports = reference.ports.iter().map(|port| SubjectPort {
        names: [port.name, port.node].map(str::to_owned),
        kind: match port.kind {
            PortKind::Serial(media) => SubjectPortKind::Serial { rs232: media == SerialMedia::Both },
            PortKind::Can => SubjectPortKind::Can,
            other => SubjectPortKind::Other(other.to_string()),
        },
    });
    let modules = catalogue::modules().iter().map(|module| module.reference.clone());
    Terminals {
        inputs: inputs.collect(),
        outputs: outputs.collect(),
        ports: ports.collect(),
        modules: modules.collect(),
    }
}

/// The terminals of modules: `M2.Q0` is the first output of the second module of the list. A list that the controller refuses has
/// none; whoever configures the controller reports why. Analogue channels that are not used have none either.
fn module_terminals(reference: &'static Reference, modules: &[ConfiguredModule<'_>]) -> Vec<ModuleTerminal> {
    let places = reference.module_addresses(modules).unwrap_or_default();
    let mut terminals = Vec::new();
    for ((number, configured), place) in (1..).zip(modules).zip(&places) {
        let mut add = |letter,
                       channels: Option<ChannelAddresses>,
                       kind: &dyn Fn(usize) -> Option<ModuleTerminalKind>| {
            for (channel, address) in channels.into_iter().flat_map(|all| all.iter()).enumerate() {
                let Some(kind) = kind(channel) else { continue };
                terminals.push(ModuleTerminal {
                    name: format!("M{number}.{letter}{channel}"),
                    address,
                    kind,
                });
            }
        };
        let level = |_| Some(ModuleTerminalKind::Level);
        let number = |mode: &AnalogueMode| match mode.unit == Unit::new("degC") {
            true => ModuleTerminalKind::Temperature(SensorCurve::of_mode(&mode.name)),
            false => ModuleTerminalKind::Number(mode.unit.clone()),
        };
        add("I", place.digital_inputs, &level);
        add("IW", place.analogue_inputs, &|input| configured.input(input).map(|it| number(it.mode)));
        add("Q", place.digital_outputs, &level);
        add("QW", place.analogue_outputs, &|output| configured.output(output).map(|it| number(it.mode)));
    }
    terminals
}

fn subject_of(subject: &BoardSubject) -> Result<(Profile, &'static Reference), UnknownSubject> {
    let profile: Profile = subject.profile.parse().map_err(|_| UnknownSubject::Profile {
        known: Profile::ALL.iter().map(|profile| profile.name().to_owned()).collect(),
    })?;
    let reference = match &subject.reference {
        None => profile.default_reference(),
        Some(name) => {
            profile.references().find(|known| known.name.eq_ignore_ascii_case(name)).ok_or_else(|| {
                UnknownSubject::Reference {
                    known: profile.references().map(|known| known.name.to_owned()).collect(),
                }
            })?
        }
    };
    Ok((profile, reference))
}

/// A plan with the files that its cases need, each read once.
#[derive(Debug)]
pub struct LoadedPlan {
    /// The plan.
    pub plan: Plan,
    /// Texts of the files that it names, by path.
    programs: Vec<SourceFile>,
    pub(crate) boards: Vec<(String, BoardFile, String)>,
    /// The files that it includes, and the tables of values that it names.
    others: Vec<SourceFile>,
    /// What the command line gives for the plan's parameters.
    given: Vec<(String, String)>,
    /// The board that the command line gives in place of the plan's own.
    pub(crate) board: Option<(BoardFile, String)>,
    /// What the suites that the plan is of claim of its cases, the outermost first.
    suites: Vec<Arc<GlobalChecks>>,
    /// What its boards claim, by the names of their files.
    board_guards: Vec<Arc<GlobalChecks>>,
}

/// What is wrong with a file that a plan names, at the place where it names it.
fn named_by(plan: &SourceFile, at: Range<usize>, found: Diagnostic) -> Diagnostic {
    let is_unread = found.code == codes::FILE_NOT_READ;
    let found = found.at(&plan.name, at, "");
    if is_unread { found.help("the path is relative to the plan") } else { found }
}

/// Reads a plan and everything that it names.
///
/// # Errors
/// Findings in the plan, its programs and its board files, with the texts that they point into.
pub fn load_plan(
    files: &dyn FileSource,
    path: &str,
    board: Option<&(BoardFile, String)>,
    parameters: &[(String, String)],
    seed: u64,
    sources: &mut Vec<SourceFile>,
) -> Result<LoadedPlan, Vec<Diagnostic>> {
    let before = sources.len();
    let text = gather(files, path, sources)?;
    // The plan itself is the first of them.
    let others = sources.iter().skip(before + 1).cloned().collect();
    let plan = plans::read_gathered(&text, parameters, seed)?;
    let file = plan.source().clone();
    let mut loaded = LoadedPlan {
        plan,
        others,
        programs: Vec::new(),
        boards: Vec::new(),
        given: parameters.to_vec(),
        board: board.cloned(),
        suites: suites::suites_of(files, path, sources)?,
        board_guards: Vec::new(),
    };
    if let Some((board, text)) = board {
        loaded.board_guards.extend(guards_of(&board.name, text)?);
    }
    let mut found = Vec::new();
    let mut board_guards = Vec::new();
    for case in loaded.plan.cases() {
        found.extend(missing_photos(files, path, &case));
        let brought =
            case.steps.iter().filter_map(|step| Some((step.stimulus.program()?, step.span.clone())));
        let own = (&case.program, loaded.plan.place_of("program"));
        for (program, at) in std::iter::once(own).chain(brought) {
            let ProgramRef::Files(names) = program else { continue };
            for name in names {
                let path = beside(path, name);
                if loaded.programs.iter().any(|known| known.name == path) {
                    continue;
                }
                match load_program(files, &path) {
                    Ok(source) => {
                        sources.push(source.clone());
                        loaded.programs.push(source);
                    }
                    Err(error) => found.push(named_by(&file, at.clone(), error)),
                }
            }
        }
        if let (Some(name), None) = (&case.board, board) {
            let path = beside(path, name);
            if loaded.boards.iter().any(|(known, ..)| *known == path) {
                continue;
            }
            match load_board(files, &path, sources) {
                Ok((board, text)) => {
                    board_guards.extend(guards_of(&board.name, &text)?);
                    loaded.boards.push((path, board, text));
                }
                Err(more) => {
                    let at = || loaded.plan.place_of("board");
                    let here = |one: Diagnostic| match one.labels.is_empty() {
                        true => named_by(&file, at(), one),
                        false => one,
                    };
                    found.extend(more.into_iter().map(here));
                }
            }
        }
        if !found.is_empty() {
            loaded.plan.joined().locate(&mut found);
            return Err(found);
        }
    }
    loaded.board_guards.extend(board_guards);
    Ok(loaded)
}

/// Reads a plan with the files that it includes. Their texts go to `sources`.
///
/// # Errors
/// Findings in them.
pub fn gather(
    files: &dyn FileSource,
    path: &str,
    sources: &mut Vec<SourceFile>,
) -> Result<PlanText, Vec<Diagnostic>> {
    let file = load(files, path).map_err(|found| vec![found])?;
    sources.push(file.clone());
    plans::gather(&file, &mut |path| {
        let text = files.read(path)?;
        sources.push(SourceFile::new(path, text.clone()));
        Ok(text)
    })
}

/// What is wrong with a file that is there to be included.
pub fn check_included(files: &dyn FileSource, path: &str, sources: &mut Vec<SourceFile>) -> Vec<Diagnostic> {
    let file = match load(files, path) {
        Ok(file) => file,
        Err(found) => return vec![found],
    };
    sources.push(file.clone());
    plans::check_included(&file, &mut |path| {
        let text = files.read(path)?;
        sources.push(SourceFile::new(path, text.clone()));
        Ok(text)
    })
}

/// The pictures of questions that are not there.
fn missing_photos(files: &dyn FileSource, plan: &str, case: &Case) -> Vec<Diagnostic> {
    let photos = case.steps.iter().filter_map(|step| match &step.stimulus {
        Stimulus::Ask(question) => Some((question.photo.as_deref()?, step)),
        _ => None,
    });
    let missing = photos.filter_map(|(photo, step)| {
        let why = files.bytes(&beside(plan, photo)).err()?;
        let message = format!("the picture `{photo}` of the question cannot be read: {why}");
        Some(
            Diagnostic::error(codes::NO_PICTURE, message)
                .at(plan, step.span.clone(), "")
                .help("it is relative to the plan"),
        )
    });
    missing.collect()
}

/// The first question of these jobs, as what is wrong where nobody can be asked.
pub fn unanswerable(plans: &[LoadedPlan], jobs: &[Job]) -> Option<Diagnostic> {
    let job = jobs.iter().find(|job| job.asks)?;
    let loaded = plans.get(job.plan)?;
    let mut found = nobody_to_ask(&loaded.plan.case(job.case)?, &loaded.plan.source().name)?;
    loaded.plan.joined().locate(std::slice::from_mut(&mut found));
    Some(found)
}

/// What is wrong with a case that asks where nobody can be asked.
pub(crate) fn nobody_to_ask(case: &Case, plan: &str) -> Option<Diagnostic> {
    let step = case.steps.iter().find(|step| matches!(step.stimulus, Stimulus::Ask(_)))?;
    let message = format!("the step `{}` asks a person, and nobody can be asked", step.id);
    let help = "run it on a terminal, or leave the case out with --only";
    Some(Diagnostic::error(codes::NOBODY_TO_ASK, message).at(plan, step.span.clone(), "").help(help))
}

/// What a board claims of the cases that run on it, if anything.
fn guards_of(name: &str, text: &str) -> Result<Option<Arc<GlobalChecks>>, Vec<Diagnostic>> {
    let guards = GlobalChecks::of_board(&SourceFile::new(name, text))?;
    Ok((!guards.is_empty()).then(|| Arc::new(guards)))
}

/// Reads a board file.
///
/// # Errors
/// Findings in it.
pub fn load_board(
    files: &dyn FileSource,
    path: &str,
    sources: &mut Vec<SourceFile>,
) -> Result<(BoardFile, String), Vec<Diagnostic>> {
    let file = load(files, path).map_err(|found| vec![found])?;
    sources.push(file.clone());
    let programs = BoardPrograms::new(files, path);
    let board = read_with_programs(&file, &terminals, &programs);
    let ReadPrograms { sources: programs, warnings, .. } = programs.into_read();
    sources.extend(programs.iter().cloned());
    let board = BoardFile { programs, warnings, ..board? };
    GlobalChecks::of_board(&file)?;
    Ok((board, file.text))
}

/// One run of one case.
#[derive(Clone, Debug)]
pub struct Job {
    /// Place of the plan.
    pub plan: usize,
    /// Number of the case in its plan.
    pub case: u64,
    /// The controller that it runs with.
    pub profile: Profile,
    /// Name of the case in the run: that of the plan, with the profile and the turn where there are several.
    pub name: String,
    /// Title of the case.
    pub title: String,
    /// The requirements that it proves, of which a row may have its own.
    pub proves: Vec<String>,
    /// The words that it can be chosen by.
    pub tags: Vec<String>,
    /// Its seed.
    pub seed: u64,
    /// Which turn it is, from 1, of a case that runs several times.
    pub turn: Option<u32>,
    /// Whether it asks a person.
    pub asks: bool,
}

impl LoadedPlan {
    /// SHA-256 of the plan with all that it is given and names, 64 hexadecimal digits: two machines that have it in
    /// common run the same cases.
    pub fn sha256(&self) -> String {
        let mut text = String::new();
        let mut add = |name: &str, part: &str| {
            // Lengths keep two parts from being read as two others.
            text.push_str(&format!("{} {} {name} {part}\n", name.len(), part.len()));
        };
        add(&self.plan.path, &self.plan.source().text);
        self.programs.iter().for_each(|source| add(&source.name, &source.text));
        for (name, board, text) in &self.boards {
            add(name, text);
            board.programs.iter().for_each(|source| add(&source.name, &source.text));
        }
        self.others.iter().for_each(|file| add(&file.name, &file.text));
        self.suites.iter().for_each(|suite| add(&suite.file().name, &suite.file().text));
        self.given.iter().for_each(|(name, value)| add(name, value));
        if let Some((board, text)) = &self.board {
            add("", text);
            board.programs.iter().for_each(|source| add("", &source.text));
        }
        crate::suite::describe::sha256(text.as_bytes())
    }

    /// What is worth knowing about the suites, and about the programs of the boards.
    pub fn suite_warnings(&self) -> impl Iterator<Item = &Diagnostic> {
        let boards = self.boards.iter().flat_map(|(_, board, _)| &board.warnings);
        self.suites.iter().flat_map(|suite| &suite.warnings).chain(boards)
    }

    /// The jobs of this plan. A case without a board file of its own runs with every profile that the plan holds
    /// for; any other with the profile of its board.
    pub fn jobs(&self, place: usize, seed: u64, repeat: u32) -> Vec<Job> {
        let mut jobs = Vec::new();
        for (number, case) in (0..).zip(self.plan.cases()) {
            let profiles = self.profiles(&case);
            let usual = profiles.first().copied().unwrap_or_default();
            for profile in profiles.iter().copied() {
                let turns = repeat.saturating_mul(case.repeat);
                for turn in 0..turns {
                    let mut name = case.name.clone();
                    if profile != usual && profiles.len() > 1 {
                        name.push_str(&format!("@{}", profile.name()));
                    }
                    if turn > 0 {
                        name.push_str(&format!("#{}", turn + 1));
                    }
                    let seed = seed.wrapping_add(u64::from(turn));
                    jobs.push(Job {
                        plan: place,
                        case: number,
                        profile,
                        name,
                        title: case.title.clone(),
                        proves: case.proves.clone(),
                        tags: case.tags.clone(),
                        seed,
                        turn: (turns > 1).then_some(turn + 1),
                        asks: case.steps.iter().any(|step| matches!(step.stimulus, Stimulus::Ask(_))),
                    });
                }
            }
        }
        jobs
    }

    fn profiles(&self, case: &Case) -> Vec<Profile> {
        let fixed = match (&self.board, &case.board) {
            (Some((board, _)), _) => Some(&board.subject),
            (None, Some(name)) => {
                let path = beside(&self.plan.path, name);
                self.boards.iter().find(|(known, ..)| *known == path).map(|(_, board, _)| &board.subject)
            }
            (None, None) => None,
        };
        if let Some(subject) = fixed {
            return vec![subject.profile.parse().unwrap_or_default()];
        }
        let mut profiles = case.profiles.clone();
        // The default profile first: it has the plain name.
        profiles.sort_by_key(|profile| *profile != Profile::default());
        if profiles.is_empty() { vec![Profile::default()] } else { profiles }
    }

    /// The sources of a program.
    fn sources(&self, program: &ProgramRef) -> Vec<SourceFile> {
        match program {
            ProgramRef::Files(names) => {
                let paths = names.iter().map(|name| beside(&self.plan.path, name));
                let find = |path: String| self.programs.iter().find(|known| known.name == path).cloned();
                paths.filter_map(find).collect()
            }
            ProgramRef::Text { text, at } => vec![inside(self.plan.source(), text, *at)],
            ProgramRef::None => Vec::new(),
        }
    }

    /// The files of a job.
    ///
    /// # Errors
    /// A finding when the plan needs a program and has none.
    pub fn files(&self, case: &Case, job: &Job) -> Result<CaseFiles, Vec<Diagnostic>> {
        let mut others: Vec<OtherProgram> = Vec::new();
        for program in case.steps.iter().filter_map(|step| step.stimulus.program()) {
            if others.iter().all(|known| known.program != *program) {
                let sources = self.sources(program);
                others.push(OtherProgram { program: program.clone(), sources });
            }
        }
        let own = case.board.as_ref().and_then(|name| {
            let path = beside(&self.plan.path, name);
            self.boards.iter().find(|(known, ..)| *known == path).map(|(_, board, text)| (board, text))
        });
        let given = self.board.as_ref().map(|(board, text)| (board, text));
        let own_board = given.is_none() && own.is_some();
        let (mut board, board_text, reference) = match given.or(own) {
            Some((board, text)) => {
                let reference =
                    subject_of(&board.subject).map_or(job.profile.default_reference(), |(_, found)| found);
                (board.clone(), text.clone(), case.settings.reference.unwrap_or(reference))
            }
            None => {
                let reference = case.settings.reference.unwrap_or(job.profile.default_reference());
                let terminals = terminals_of(reference);
                (BoardFile::default_for(&terminals.inputs, &terminals.outputs), String::new(), reference)
            }
        };
        board.bind_modules(&module_terminals(reference, &modules::configured(&case.settings.modules)))?;
        let of_board = self.board_guards.iter().filter(|guards| guards.file().name == board.name);
        let guards = self.suites.iter().chain(of_board).cloned().collect();
        let mut sources = self.sources(&case.program);
        if board.subject.external.is_none() {
            // A real controller brings the names of its functions along.
            let names = || case.settings.expert.iter().map(|function| function.name.as_str());
            let others = others.iter_mut().map(|other| &mut other.sources);
            for sources in others.chain([&mut sources]).filter(|sources| !sources.is_empty()) {
                sources.extend(blocks::declarations(names()));
            }
        }
        Ok(CaseFiles {
            name: job.name.clone(),
            given: self.given.clone(),
            plan: self.plan.source().clone(),
            joined: self.plan.joined().clone(),
            sources,
            others,
            board,
            board_text,
            own_board,
            guards,
            profile: job.profile,
            reference,
            seed: job.seed,
        })
    }
}

/// A program inside a plan, as a source of its own in which every place is that of the plan. A text that is not written
/// as it is read, because of escapes, has its own places.
fn inside(plan: &SourceFile, text: &str, at: Option<usize>) -> SourceFile {
    let written = at.and_then(|at| Some((at, plan.text.get(at..at + text.len())?)));
    match written {
        Some((at, written)) if written == text => {
            let blank = |byte: u8| if byte == b'\n' { '\n' } else { ' ' };
            let before = plan.text.bytes().take(at).map(blank);
            SourceFile::new(plan.name.clone(), before.chain(text.chars()).collect::<String>())
        }
        _ => SourceFile::new(format!("{} (program-text)", plan.name), text.to_owned()),
    }
}
