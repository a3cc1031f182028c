//! Many plans: their files, their cases, and several cases at once.

use crate::case::{CaseFiles, CaseResult, OtherProgram, RunOptions, run_case};
use document::{Diagnostic, SourceFile};
use drivers::file::{BoardFile, Subject as BoardSubject, Terminals, UnknownSubject, read as read_board};
use plans::plan::ProgramRef;
use plans::{Case, Plan};
use profile::{Profile, Reference};
use record::CaseRecord;
use signal::{Address, Area};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc;

/// Where plans, programs and board files come from: a disk, or what is built into the binary.
pub trait Files: Sync {
    /// The text of a file.
    ///
    /// # Errors
    /// Why it cannot be read.
    fn read(&self, path: &str) -> Result<String, String>;

    /// The bytes of a file, which need not be UTF-8.
    ///
    /// # Errors
    /// Why it cannot be read.
    fn bytes(&self, path: &str) -> Result<Vec<u8>, String> {
        self.read(path).map(String::into_bytes)
    }
}

/// Largest file that is read.
const LARGEST_FILE: u64 = 8 << 20;

/// The host's disk.
#[derive(Clone, Copy, Debug, Default)]
pub struct Disk;

impl Files for Disk {
    fn read(&self, path: &str) -> Result<String, String> {
        String::from_utf8(self.bytes(path)?)
            .map_err(|error| format!("it is no UTF-8 text (byte {})", error.utf8_error().valid_up_to()))
    }

    fn bytes(&self, path: &str) -> Result<Vec<u8>, String> {
        let length = std::fs::metadata(path).map_err(|error| error.to_string())?.len();
        if length > LARGEST_FILE {
            return Err(format!("it has {length} bytes, {LARGEST_FILE} is the most"));
        }
        std::fs::read(path).map_err(|error| error.to_string())
    }
}

/// A path beside another file.
pub fn beside(file: &str, path: &str) -> String {
    match file.rfind('/') {
        Some(at) if !path.starts_with('/') => format!("{}/{path}", &file[..at]),
        _ => path.to_owned(),
    }
}

/// Reads a user's file into a source.
///
/// # Errors
/// A finding with the path and the reason.
pub fn load(files: &dyn Files, path: &str) -> Result<SourceFile, Diagnostic> {
    let text = files
        .read(path)
        .map_err(|why| Diagnostic::error("R0201", format!("`{path}` cannot be read: {why}")))?;
    Ok(SourceFile::new(path, text))
}

/// Reads a file of Structured Text, in whatever encoding and wrapping it is distributed.
///
/// # Errors
/// A finding with the path and the reason.
pub fn load_program(files: &dyn Files, path: &str) -> Result<SourceFile, Diagnostic> {
    let bytes = files
        .bytes(path)
        .map_err(|why| Diagnostic::error("R0201", format!("`{path}` cannot be read: {why}")))?;
    program::source(path, &bytes)
}

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
    Terminals { inputs: inputs.collect(), outputs: outputs.collect() }
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
    boards: Vec<(String, BoardFile, String)>,
    /// What the command line gives for the plan's parameters.
    given: Vec<(String, String)>,
    /// The board that the command line gives in place of the plan's own.
    board: Option<(BoardFile, String)>,
}

/// Reads a plan and everything that it names.
///
/// # Errors
/// Findings in the plan, its programs and its board files, with the texts that they point into.
pub fn load_plan(
    files: &dyn Files,
    path: &str,
    board: Option<&(BoardFile, String)>,
    parameters: &[(String, String)],
    seed: u64,
    sources: &mut Vec<SourceFile>,
) -> Result<LoadedPlan, Vec<Diagnostic>> {
    let file = load(files, path).map_err(|found| vec![found])?;
    sources.push(file.clone());
    let plan = plans::read(&file, parameters, seed)?;
    let mut loaded = LoadedPlan {
        plan,
        programs: Vec::new(),
        boards: Vec::new(),
        given: parameters.to_vec(),
        board: board.cloned(),
    };
    let mut found = Vec::new();
    for case in loaded.plan.cases() {
        let brought =
            case.steps.iter().filter_map(|step| Some((step.stimulus.program()?, step.span.clone())));
        for (program, at) in std::iter::once((&case.program, 0..0)).chain(brought) {
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
                    Err(error) => found.push(error.at(&file.name, at.clone(), "")),
                }
            }
        }
        if let (Some(name), None) = (&case.board, board) {
            let path = beside(path, name);
            if loaded.boards.iter().any(|(known, ..)| *known == path) {
                continue;
            }
            match load_board(files, &path, sources) {
                Ok((board, text)) => loaded.boards.push((path, board, text)),
                Err(more) => found.extend(more),
            }
        }
        if !found.is_empty() {
            return Err(found);
        }
    }
    Ok(loaded)
}

/// Reads a board file.
///
/// # Errors
/// Findings in it.
pub fn load_board(
    files: &dyn Files,
    path: &str,
    sources: &mut Vec<SourceFile>,
) -> Result<(BoardFile, String), Vec<Diagnostic>> {
    let file = load(files, path).map_err(|found| vec![found])?;
    sources.push(file.clone());
    let board = read_board(&file, &terminals)?;
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
    /// Its seed.
    pub seed: u64,
}

impl LoadedPlan {
    /// The jobs of this plan. A case without a board file of its own runs with every profile that the plan holds
    /// for; any other with the profile of its board.
    pub fn jobs(&self, place: usize, seed: u64, repeat: u32) -> Vec<Job> {
        let mut jobs = Vec::new();
        for (number, case) in (0..).zip(self.plan.cases()) {
            let profiles = self.profiles(&case);
            let usual = profiles.first().copied().unwrap_or_default();
            for profile in profiles.iter().copied() {
                for turn in 0..repeat {
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
                        seed,
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
                others.push(OtherProgram { program: program.clone(), sources: self.sources(program) });
            }
        }
        let own = case.board.as_ref().and_then(|name| {
            let path = beside(&self.plan.path, name);
            self.boards.iter().find(|(known, ..)| *known == path).map(|(_, board, text)| (board, text))
        });
        let given = self.board.as_ref().map(|(board, text)| (board, text));
        let (board, board_text, reference) = match given.or(own) {
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
        Ok(CaseFiles {
            name: job.name.clone(),
            given: self.given.clone(),
            plan: self.plan.source().clone(),
            sources: self.sources(&case.program),
            others,
            board,
            board_text,
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

/// What became of a job.
#[derive(Debug)]
pub enum Done {
    /// It ran, or was found not to apply.
    Case(Box<CaseResult>),
    /// Something is wrong with the user's files.
    Findings(Vec<Diagnostic>),
    /// It was left out because the run ended before it.
    Skipped(Box<CaseRecord>),
}

/// Runs jobs, several at once, and hands each result to `each` in the order of the jobs.
pub fn run(
    plans: &[LoadedPlan],
    jobs: &[Job],
    at_once: usize,
    fail_fast: bool,
    options: &RunOptions<'_>,
    each: &mut dyn FnMut(usize, Done),
) {
    let next = AtomicUsize::new(0);
    let stop = AtomicBool::new(false);
    let (send, receive) = mpsc::sync_channel::<(usize, Done)>(at_once * 2);
    std::thread::scope(|scope| {
        for _ in 0..at_once.clamp(1, jobs.len().max(1)) {
            let send = send.clone();
            let (next, stop) = (&next, &stop);
            scope.spawn(move || {
                loop {
                    let place = next.fetch_add(1, Ordering::Relaxed);
                    let Some(job) = jobs.get(place) else { return };
                    let ended = stop.load(Ordering::Relaxed) || options.interrupt.load(Ordering::Relaxed);
                    let done = if ended { skipped(plans, job) } else { run_job(plans, job, options) };
                    // Here and not where the results are taken, or else the next job would have begun.
                    if fail_fast && !passed(&done) {
                        stop.store(true, Ordering::Relaxed);
                    }
                    if send.send((place, done)).is_err() {
                        return;
                    }
                }
            });
        }
        drop(send);
        // Results come in any order and are handed on in the order of the jobs.
        let mut waiting: Vec<Option<Done>> = Vec::new();
        waiting.resize_with(jobs.len(), || None);
        let mut handed = 0;
        for (place, done) in receive {
            waiting[place] = Some(done);
            while let Some(done) = waiting.get_mut(handed).and_then(Option::take) {
                each(handed, done);
                handed += 1;
            }
        }
    });
}

fn passed(done: &Done) -> bool {
    match done {
        Done::Case(result) => !result.record.is_judged() || result.record.verdict == record::Verdict::Pass,
        Done::Findings(_) => false,
        Done::Skipped(_) => true,
    }
}

fn skipped(plans: &[LoadedPlan], job: &Job) -> Done {
    let mut record = CaseRecord::skipped(&job.name, "the run ended before it");
    if let Some(loaded) = plans.get(job.plan) {
        record.plan.clone_from(&loaded.plan.path);
        record.title.clone_from(&loaded.plan.title);
    }
    Done::Skipped(Box::new(record))
}

fn run_job(plans: &[LoadedPlan], job: &Job, options: &RunOptions<'_>) -> Done {
    let Some(loaded) = plans.get(job.plan) else { return Done::Findings(Vec::new()) };
    let Some(case) = loaded.plan.case(job.case) else { return Done::Findings(Vec::new()) };
    let files = match loaded.files(&case, job) {
        Ok(files) => files,
        Err(found) => return Done::Findings(found),
    };
    match run_case(&case, &files, options) {
        Ok(result) => Done::Case(Box::new(result)),
        Err(found) => Done::Findings(found),
    }
}
