//! Subject and board of a case, made of its files.

use crate::application::bundle::{Bundle, TaskPrograms};
use crate::application::coverage::Collector;
use crate::application::functions;
use crate::application::store::MemoryStore;
use crate::application::tasks::Tasks;
use crate::application::{assign, compile, notes};
use crate::application::{image_places, inputs, modules};
use crate::case::check::CaseOnBench;
use crate::case::configure::{configuration, initial_state};
use crate::case::unused_terminals;
use crate::codes;
use crate::prepare::{PreparedCase, TestBench, prepare};
use crate::subject::Subject;
use crate::subject::external::ExternalController;
use crate::subject::hook::Hook;
use crate::subject::model::ModelledController;
use crate::suite::case_export;
use crate::suite::case_files::CaseFiles;
use crate::suite::ports;
use controller::{Command, Config, Effects, LoadError, RelocationPart, State};
use document::{Diagnostic, SourceFile};
use drivers::External as Settings;
use drivers::file::build;
use plans::Case;
use plans::plan::DelayModel;
use plans::steps::ProgramRef;
use profile::module_indices;
use signal::{Time, Trace};
use std::sync::Arc;

/// Subject and board of a case, before power-on.
pub(crate) struct TestSetup {
    pub(crate) subject: Box<dyn Subject>,
    pub(crate) board: Box<dyn drivers::Board>,
    bundle: Vec<u8>,
    /// Those of the programs that steps bring.
    others: Vec<(ProgramRef, Vec<u8>)>,
    pub(crate) program: Option<Arc<program::Program>>,
    /// The PROGRAMs that each task runs, as the plan and the program say it.
    pub(crate) tasks: Vec<TaskPrograms>,
    /// What the controller accepts with a warning.
    pub(crate) warnings: Vec<Diagnostic>,
    /// What the compiler warns of in the case's own program and in those that steps bring.
    pub(crate) program_warnings: Vec<Diagnostic>,
}

impl TestSetup {
    pub(crate) fn prepare(
        &mut self,
        case: &Case,
        files: &CaseFiles,
        trace: Trace,
        exact: bool,
    ) -> Result<PreparedCase, Vec<Diagnostic>> {
        let modules = modules::configured(&case.settings.modules);
        let linked = modules.iter().any(|one| one.module.kind.is_link());
        let indices = module_indices(&modules);
        let modules: Vec<_> =
            indices.into_iter().zip(&modules).filter_map(|(index, one)| Some((index?, one.module))).collect();
        let mut bench = TestBench {
            modules: &modules,
            linked,
            subject: &mut *self.subject,
            board: &*self.board,
            file: &files.board,
            profile: files.profile,
            reference: files.reference,
            bundle: &self.bundle,
            others: &self.others,
            seed: files.seed,
            exact,
        };
        prepare(case, &files.plan, trace, &mut bench)
    }

    /// What is looked at before anything moves.
    pub(crate) fn on_bench<'a>(
        &'a self,
        case: &'a Case,
        files: &'a CaseFiles,
        prepared: &'a PreparedCase,
    ) -> CaseOnBench<'a> {
        CaseOnBench { case, files, subject: &*self.subject, board: &*self.board, prepared }
    }
}

/// Compiles the program and builds subject and board. A controller that is empty at the start needs no program.
pub(crate) fn set_up(
    case: &Case,
    files: &CaseFiles,
    collector: Option<Collector>,
) -> Result<TestSetup, Vec<Diagnostic>> {
    ports::check(files)?;
    if let Some(settings) = &files.board.subject.external {
        return set_up_external(case, files, settings);
    }
    let initial = initial_state(case.settings.initial);
    let none = files.sources.is_empty() && initial == State::Empty;
    let program = if none { None } else { Some(Arc::new(compile(&files.sources, files.profile)?)) };
    let mut config = configuration(&case.settings, files)?;
    config.worst_case = case.model == DelayModel::WorstCase;
    let tasks = Tasks::new(program.as_deref(), &case.settings, files.profile, &files.plan)?;
    tasks.configure(&mut config, &case.settings, program.as_deref(), &files.plan)?;
    let mut warnings = functions::warnings(&config, &case.settings, &files.plan.name);
    warnings.extend(unused_terminals::warnings(&files.board, &config, &files.plan.name));
    let tasks = tasks.programs;
    if let Some(program) = &program {
        let Some(places) = assign(program, &tasks) else {
            return Err(vec![no_such_program(program, &tasks, &files.plan)]);
        };
        let readers = tasks.iter().map(|task| task.task.as_str()).zip(&places);
        inputs::latched_for_mast(program, readers, &case.settings, &files.plan.name)?;
    }
    let warnings_of = |program: &program::Program| {
        let mut found = program.warnings.clone();
        found.extend(notes(program, files.profile));
        found.extend(image_places::warnings(program, &config, case));
        found
    };
    let mut program_warnings = program.as_deref().map_or_else(Vec::new, warnings_of);
    let mut others = Vec::new();
    let mut known = Vec::new();
    for other in &files.others {
        let program = Arc::new(compile(&other.sources, files.profile)?);
        program_warnings.extend(warnings_of(&program));
        let tasks = tasks_of_another(&program, case, &config, files)?;
        others.push((other.program.clone(), Bundle { sources: other.sources.clone(), tasks }.to_bytes()));
        known.push(program);
    }
    let bundle = match &program {
        Some(_) => Bundle { sources: files.sources.clone(), tasks: tasks.clone() }.to_bytes(),
        None => Vec::new(),
    };
    let refused = |error: &dyn std::fmt::Display| refused(files, error);
    let board = build(&files.board, files.seed).map_err(|error| refused(&error))?;
    let mut model =
        ModelledController::new(config.clone(), program.clone(), Box::new(MemoryStore::default()), collector)
            .map_err(|error| refused(&error))?;
    model.add_programs(known);
    if case.settings.firmware_invalid {
        model.damage_firmware();
    }
    if case.settings.switch_at_run == Some(false) {
        let moved = model.command(Time::ZERO, &Command::Switch(false), &mut Effects::new());
        moved.map_err(|error| refused(&error))?;
    }
    if initial != State::Empty {
        let left = if initial == State::Booting { State::Running } else { initial };
        model.commission(&bundle, left).map_err(|error| match error {
            LoadError::Relocation { part, row } => vec![beyond_table(part, row, case, files)],
            error => refused(&error),
        })?;
    }
    let of_application = program.as_ref().and_then(|_| model.application_warning(&bundle));
    warnings.extend(crate::application::tasks::warnings(&config, of_application, &files.plan));
    Ok(TestSetup {
        subject: Box::new(model),
        board,
        bundle,
        others,
        program,
        tasks,
        warnings,
        program_warnings,
    })
}

fn refused(files: &CaseFiles, error: &dyn std::fmt::Display) -> Vec<Diagnostic> {
    vec![Diagnostic::error(codes::CONFIGURATION_REFUSED, error.to_string()).at(&files.plan.name, 0..0, "")]
}

/// A real controller on the board. Its program is what is in it, or what the user's command brings; the rig does not
/// read it.
fn set_up_external(
    case: &Case,
    files: &CaseFiles,
    settings: &Settings,
) -> Result<TestSetup, Vec<Diagnostic>> {
    let board = build(&files.board, files.seed).map_err(|error| refused(files, &error))?;
    let hook = if settings.load.is_empty() && settings.unload.is_empty() {
        Hook::default()
    } else {
        case_export::export_case(case, files).map_err(|error| {
            let message = format!("what `load` is given cannot be written: {error}");
            vec![Diagnostic::error(codes::NOT_EXPORTED, message).help("give the temporary folder room")]
        })?
    };
    let (initial, run) = (initial_state(case.settings.initial), case.settings.switch_at_run != Some(false));
    let subject = ExternalController::new(&files.board, settings.clone(), &*board, initial, run, hook);
    Ok(TestSetup {
        subject: Box::new(subject),
        board,
        bundle: Vec::new(),
        others: Vec::new(),
        program: None,
        tasks: Vec::new(),
        warnings: Vec::new(),
        program_warnings: Vec::new(),
    })
}

/// The PROGRAMs that each task of the controller runs of another program. The controller's tasks stay those of the
/// case.
fn tasks_of_another(
    program: &program::Program,
    case: &Case,
    config: &Config,
    files: &CaseFiles,
) -> Result<Vec<TaskPrograms>, Vec<Diagnostic>> {
    let tasks = Tasks::new(Some(program), &case.settings, files.profile, &files.plan)?;
    if tasks.configured != config.tasks {
        let name = program.files().first().map_or("", String::as_str);
        let message = format!("`{name}` configures other tasks than the case's own program");
        let found = Diagnostic::error(codes::OTHER_TASKS, message).at(name, 0..0, "");
        return Err(vec![found.help("give it the same tasks: a controller of a case keeps its tasks")]);
    }
    if assign(program, &tasks.programs).is_none() {
        return Err(vec![no_such_program(program, &tasks.programs, &files.plan)]);
    }
    Ok(tasks.programs)
}

/// The first row of the relocation table that does not fit (controller:REL-02).
fn beyond_table(part: RelocationPart, row: usize, case: &Case, files: &CaseFiles) -> Diagnostic {
    let name = case.settings.relocation[part as usize].get(row).map_or("?", String::as_str);
    let message = format!("`{name}` does not fit into the relocation table");
    let help = format!("row {}: each part has {} words", row + 1, profile::TABLE_WORDS);
    Diagnostic::error(codes::CONFIGURATION_REFUSED, message).at(&files.plan.name, 0..0, "").help(help)
}

fn no_such_program(program: &program::Program, tasks: &[TaskPrograms], plan: &SourceFile) -> Diagnostic {
    let known = program.programs();
    let missing = tasks.iter().flat_map(|task| task.named().iter().map(move |name| (&task.task, name)));
    let missing =
        missing.into_iter().find(|(_, name)| !known.iter().any(|one| one.eq_ignore_ascii_case(name)));
    let message = match missing {
        Some((task, name)) => format!("task {task} runs `{name}`, which the program does not have"),
        None => String::from("a task runs a PROGRAM that the program does not have"),
    };
    Diagnostic::error(codes::PROGRAM_NOT_FOUND, message)
        .at(&plan.name, 0..0, "")
        .help(format!("the program has {}", known.join(", ")))
}
