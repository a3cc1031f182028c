//! One case from its plan to its record.

use crate::application::{assign, compile};
use crate::bundle::Bundle;
use crate::check::{self, Looked};
use crate::clock::{Clock, HostClock, LateClock, VirtualClock};
use crate::configure::{configuration, initial_state};
use crate::coverage::{Collector, Covered};
use crate::executor::{Executor, Limits, Parts, Ran};
use crate::needs::{Unmet, unmet};
use crate::operator::Operator;
use crate::prepare::{Bench, Prepared, prepare};
use crate::recorder::Recorder;

use crate::schedule::Schedule;
use crate::stepping::Stepper;
use crate::store::MemoryStore;
use crate::subject::{Model, Subject};
use crate::suite::nobody;
use crate::tasks::Tasks;
use crate::{describe, inputs, lanes, refusal, spill};
use controller::{Command, Config, Effects, LoadError, Part, State};
use document::{Diagnostic, Joined, SourceFile};
use drivers::file::{BoardFile, build};
use plans::Case;
use plans::judge::{Judge, Outcome};
use plans::plan::{Guards, ProgramRef};
use profile::{Profile, Reference};
use record::{CaseRecord, CaseStatus, RigTiming, StepRecord, TaskFigures, Verdict};
use signal::{SignalId, Span, Time, Trace, Value, When};
use std::borrow::Cow;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// The memory that a trace takes before it goes on in a file, in bytes: enough for the traces of all but the longest
/// cases, and little enough that a day takes no more than an hour does.
pub const DEFAULT_TRACE_MEMORY: usize = 1 << 20;

/// What a case is run on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClockKind {
    /// From event to event.
    Virtual,
    /// On the host's clock.
    Real,
    /// Virtual, with waits that end up to this late by a seeded amount.
    Late(Span),
}

/// How cases are run.
#[derive(Clone, Copy, Debug)]
pub struct RunOptions<'a> {
    /// The clock.
    pub clock: ClockKind,
    /// The longest that the application runs on at a stretch. Never shows in the trace.
    pub slice: Span,
    /// How late the rig may be.
    pub late: Span,
    /// A case ends when a claim is lost.
    pub fail_fast: bool,
    /// Bytes of memory that a trace may take before it goes on in a temporary file. Never shows in what comes of it.
    pub trace_memory: usize,
    /// Whether to note what of the program runs. Slower; never shows in the trace.
    pub coverage: bool,
    /// Becomes TRUE when the user wants the run to end.
    pub interrupt: &'a AtomicBool,
    /// Who can be asked, if somebody is there.
    pub operator: Option<&'a dyn Operator>,
}

/// The least that a rig without real-time priority can be asked to keep on the host's clock.
pub const DEFAULT_LATE: Span = Span::from_millis(20);

impl<'a> RunOptions<'a> {
    /// On this clock, with nothing special.
    pub fn new(clock: ClockKind, interrupt: &'a AtomicBool) -> Self {
        RunOptions {
            clock,
            slice: Span::MAX,
            late: DEFAULT_LATE,
            fail_fast: false,
            trace_memory: DEFAULT_TRACE_MEMORY,
            coverage: false,
            interrupt,
            operator: None,
        }
    }
}

/// A case with the files that it is made of.
#[derive(Clone, Debug)]
pub struct CaseFiles {
    /// Name of the case in the run.
    pub name: String,
    /// What the command line gives for the plan's parameters.
    pub given: Vec<(String, String)>,
    /// The plan.
    pub plan: SourceFile,
    /// The plan and what it includes: the places of the case count through all of them.
    pub joined: Joined,
    /// The sources of the program.
    pub sources: Vec<SourceFile>,
    /// The programs that steps bring to the controller, each once.
    pub others: Vec<OtherProgram>,
    /// The board.
    pub board: BoardFile,
    /// Text of the board file, empty for the default board.
    pub board_text: String,
    /// What suites and the board claim of every case.
    pub guards: Vec<Arc<Guards>>,
    /// The controller.
    pub profile: Profile,
    /// Its reference.
    pub reference: &'static Reference,
    /// The seed of everything that is left to chance.
    pub seed: u64,
}

impl CaseFiles {
    /// The case with what suites and the board claim of it.
    ///
    /// # Errors
    /// Two alarms of one name.
    pub fn guarded<'c>(&self, case: &'c Case) -> Result<Cow<'c, Case>, Vec<Diagnostic>> {
        let mut case = Cow::Borrowed(case);
        for guards in &self.guards {
            guards.attach(case.to_mut())?;
        }
        Ok(case)
    }
}

/// A program that a step brings to the controller.
#[derive(Clone, Debug)]
pub struct OtherProgram {
    /// As the step names it.
    pub program: ProgramRef,
    /// Its sources.
    pub sources: Vec<SourceFile>,
}

/// A case that was run, with its trace where there is one.
#[derive(Debug)]
pub struct CaseResult {
    /// The record.
    pub record: CaseRecord,
    /// The trace.
    pub trace: Option<Trace>,
    /// What of the program ran, file by file, where that was asked for.
    pub coverage: Vec<Covered>,
}

impl CaseResult {
    /// A case that did not run and has no trace.
    fn not_run(record: CaseRecord) -> CaseResult {
        CaseResult { record, trace: None, coverage: Vec::new() }
    }
}

/// Looks up every name of a case on its bench, without running it. Hands back what its controller warns of.
///
/// # Errors
/// What [`run_case`] would find in the user's files.
pub fn check_case(case: &Case, files: &CaseFiles) -> Result<Vec<Diagnostic>, Vec<Diagnostic>> {
    let mut checked = check_here(case, files);
    let (Ok(found) | Err(found)) = &mut checked;
    files.joined.locate(found);
    checked
}

fn check_here(case: &Case, files: &CaseFiles) -> Result<Vec<Diagnostic>, Vec<Diagnostic>> {
    if (!case.profiles.is_empty() && !case.profiles.contains(&files.profile))
        || !files.profile.accepts(files.reference)
    {
        return Ok(check::profile(case, files).into_iter().collect());
    }
    match &case.refusal {
        Some(refusal) => refusal::check(case, files, refusal).map(|()| Vec::new()),
        None => look_up(case, files),
    }
}

/// Builds subject and board of a case and looks up its names: signals and steps as a run would have them.
pub(crate) fn lay_out(case: &Case, files: &CaseFiles) -> Result<Prepared, Vec<Diagnostic>> {
    let case = &*files.guarded(case)?;
    stage(case, files, None)?.prepare(case, files, Trace::new(), true)
}

/// Builds subject and board of a case and looks up its names.
pub(crate) fn look_up(case: &Case, files: &CaseFiles) -> Result<Vec<Diagnostic>, Vec<Diagnostic>> {
    let case = &*files.guarded(case)?;
    let mut stage = stage(case, files, None)?;
    let prepared = stage.prepare(case, files, Trace::new(), true)?;
    Judge::new(case.scenario(), prepared.trace.signals())?;
    let looked = stage.looked(case, files, &prepared);
    let found = check::claims(&looked);
    if found.iter().any(Diagnostic::is_error) {
        return Err(found);
    }
    let needs = check::needs(&looked);
    let mut warnings = stage.warnings;
    warnings.extend(prepared.warnings);
    warnings.extend(found);
    warnings.extend(needs);
    Ok(warnings)
}

/// Subject and board of a case, before power-on.
struct Stage {
    model: Model,
    board: Box<dyn drivers::Board>,
    bundle: Vec<u8>,
    /// Those of the programs that steps bring.
    others: Vec<(ProgramRef, Vec<u8>)>,
    program: Option<Arc<program::Program>>,
    /// What the controller accepts with a warning.
    warnings: Vec<Diagnostic>,
}

impl Stage {
    fn prepare(
        &mut self,
        case: &Case,
        files: &CaseFiles,
        trace: Trace,
        exact: bool,
    ) -> Result<Prepared, Vec<Diagnostic>> {
        let mut bench = Bench {
            subject: &mut self.model,
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
    fn looked<'a>(&'a self, case: &'a Case, files: &'a CaseFiles, prepared: &'a Prepared) -> Looked<'a> {
        Looked { case, files, model: &self.model, board: &*self.board, prepared }
    }
}

/// Compiles the program and builds subject and board. A controller that is empty at the start needs no program.
fn stage(case: &Case, files: &CaseFiles, collector: Option<Collector>) -> Result<Stage, Vec<Diagnostic>> {
    let initial = initial_state(case.settings.initial);
    let none = files.sources.is_empty() && initial == State::Empty;
    let program = if none { None } else { Some(Arc::new(compile(&files.sources, files.profile)?)) };
    let mut config = configuration(&case.settings, files)?;
    let tasks = Tasks::new(program.as_deref(), &case.settings, files.profile, &files.plan)?;
    tasks.configure(&mut config, &case.settings, program.as_deref(), &files.plan)?;
    let warnings = crate::tasks::warnings(&config, &files.plan);
    let tasks = tasks.programs;
    if let Some(program) = &program {
        let Some(places) = assign(program, &tasks) else {
            return Err(vec![no_such_program(program, &tasks, &files.plan)]);
        };
        let readers = tasks.iter().map(|(task, _)| task.as_str()).zip(&places);
        inputs::latched_for_mast(program, readers, &case.settings, &files.plan.name)?;
    }
    let mut others = Vec::new();
    let mut known = Vec::new();
    for other in &files.others {
        let program = Arc::new(compile(&other.sources, files.profile)?);
        let tasks = tasks_of_another(&program, case, &config, files)?;
        others.push((other.program.clone(), Bundle { sources: other.sources.clone(), tasks }.to_bytes()));
        known.push(program);
    }
    let bundle = match &program {
        Some(_) => Bundle { sources: files.sources.clone(), tasks }.to_bytes(),
        None => Vec::new(),
    };
    let refused = |error: &dyn std::fmt::Display| {
        vec![Diagnostic::error("R0113", error.to_string()).at(&files.plan.name, 0..0, "")]
    };
    let board = build(&files.board, files.seed).map_err(|error| refused(&error))?;
    let mut model = Model::new(config, program.clone(), Box::new(MemoryStore::default()), collector)
        .map_err(|error| refused(&error))?;
    model.know(known);
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
    Ok(Stage { model, board, bundle, others, program, warnings })
}

/// The PROGRAMs that each task of the controller runs of another program. The controller's tasks stay those of the
/// case.
fn tasks_of_another(
    program: &program::Program,
    case: &Case,
    config: &Config,
    files: &CaseFiles,
) -> Result<Vec<(String, Vec<String>)>, Vec<Diagnostic>> {
    let tasks = Tasks::new(Some(program), &case.settings, files.profile, &files.plan)?;
    if tasks.configured != config.tasks {
        let name = program.files().first().map_or("", String::as_str);
        let message = format!("`{name}` configures other tasks than the case's own program");
        let found = Diagnostic::error("R0121", message).at(name, 0..0, "");
        return Err(vec![found.help("give it the same tasks: a controller of a case keeps its tasks")]);
    }
    if assign(program, &tasks.programs).is_none() {
        return Err(vec![no_such_program(program, &tasks.programs, &files.plan)]);
    }
    Ok(tasks.programs)
}

/// The first row of the relocation table that does not fit (controller:REL-02).
fn beyond_table(part: Part, row: usize, case: &Case, files: &CaseFiles) -> Diagnostic {
    let name = case.settings.relocation[part as usize].get(row).map_or("?", String::as_str);
    let message = format!("`{name}` does not fit into the relocation table");
    let help = format!("row {}: each part has {} words", row + 1, profile::TABLE_WORDS);
    Diagnostic::error("R0113", message).at(&files.plan.name, 0..0, "").help(help)
}

/// Runs a case. Cases that do not apply here, and cases that this instrument cannot judge, come back with the
/// reason and without a trace.
///
/// # Errors
/// Findings about the user's files: names that mean nothing, a program that does not compile.
pub fn run_case(
    case: &Case,
    files: &CaseFiles,
    options: &RunOptions<'_>,
) -> Result<CaseResult, Vec<Diagnostic>> {
    step_case(case, files, options, None)
}

/// As [`run_case`], and `stepper` is asked before each step of the plan.
///
/// # Errors
/// Those of [`run_case`].
pub fn step_case(
    case: &Case,
    files: &CaseFiles,
    options: &RunOptions<'_>,
    stepper: Option<&mut dyn Stepper>,
) -> Result<CaseResult, Vec<Diagnostic>> {
    run_here(case, files, options, stepper).map_err(|mut found| {
        files.joined.locate(&mut found);
        found
    })
}

fn run_here(
    case: &Case,
    files: &CaseFiles,
    options: &RunOptions<'_>,
    stepper: Option<&mut dyn Stepper>,
) -> Result<CaseResult, Vec<Diagnostic>> {
    let began = Instant::now();
    let mut record = describe::record_of(case, files);
    if !case.profiles.is_empty() && !case.profiles.contains(&files.profile) {
        let names: Vec<&str> = case.profiles.iter().map(|profile| profile.name()).collect();
        let reason = format!("holds for {}, the controller is {}", names.join(", "), files.profile.name());
        record.status = CaseStatus::NotApplicable { reason };
        return Ok(CaseResult::not_run(record));
    }
    if !files.profile.accepts(files.reference) {
        let reason = format!("{} is no controller of {}", files.reference.name, files.profile.name());
        record.status = CaseStatus::NotApplicable { reason };
        return Ok(CaseResult::not_run(record));
    }
    if let Some(refusal) = &case.refusal {
        refusal::run(case, files, refusal, &mut record);
        record.host_ms = u64::try_from(began.elapsed().as_millis()).unwrap_or(u64::MAX);
        return Ok(CaseResult::not_run(record));
    }
    if let Some(found) = nobody(case, &files.plan.name).filter(|_| options.operator.is_none()) {
        return Err(vec![found]);
    }
    let case = &*files.guarded(case)?;
    let collector = options.coverage.then(Collector::default);
    let mut stage = stage(case, files, collector.clone())?;
    if let Some(unmet) = unmet(case, &stage.model, &*stage.board, Span::ZERO) {
        match unmet {
            Unmet::Power(reason) => record.status = CaseStatus::NotApplicable { reason },
            Unmet::Instrument(reason) => {
                record.verdict = Verdict::Inconclusive;
                record.reason = reason;
            }
        }
        return Ok(CaseResult::not_run(record));
    }
    let mut clock = clock(options.clock, files.seed);
    let trace = Trace::with_spill(options.trace_memory, spill::temporary());
    let prepared = stage.prepare(case, files, trace, clock.is_exact())?;
    let mut found = check::claims(&stage.looked(case, files, &prepared));
    found.retain(Diagnostic::is_error);
    if !found.is_empty() {
        return Err(found);
    }
    let Stage { mut model, mut board, program, .. } = stage;
    let initial = initial_state(case.settings.initial);
    let Prepared { mut trace, mut wiring, steps, probes, mut alarms, .. } = prepared;
    describe::annotate(&mut trace, case, files, &model, clock.name());
    let mut judge = Judge::new(case.scenario(), trace.signals())?;
    if !options.fail_fast {
        judge = judge.unhurried();
    }
    let mut recorder = Recorder::new(trace, judge);
    for (probe, signal) in &probes {
        show(&mut recorder, *signal, model.read(probe));
    }
    let mut schedule = Schedule::new(steps, case.ends.clone());
    let limits = Limits {
        initial,
        late: options.late,
        slice: options.slice,
        fail_fast: options.fail_fast,
        timeout: case.timeout,
        teardown: case.teardown,
    };
    let parts = Parts {
        clock: &mut *clock,
        subject: &mut model,
        board: &mut *board,
        recorder: &mut recorder,
        schedule: &mut schedule,
        wiring: &mut wiring,
        alarms: &mut alarms,
        interrupt: options.interrupt,
        operator: options.operator,
    };
    let executor = Executor::new(parts, limits);
    let ran = match stepper {
        Some(stepper) => executor.stepping(stepper).run(),
        None => executor.run(),
    };
    let late = recorder.late();
    let (mut trace, judge) = recorder.into_parts();
    if let Some(ended) = schedule.ended_words() {
        trace.set_note("ended", ended);
    }
    if let Some(trouble) = &ran.trouble {
        trace.set_note("trouble", trouble.show(board.channels()).to_string());
    }
    // How late the rig was shows only now. Steps that came later than the plan needs may have tested something else.
    if let Some(Unmet::Instrument(reason)) = unmet(case, &model, &*board, late) {
        trace.set_note("unmet", reason);
    }
    let outcome = judge.finish(When::exactly(ran.end), &trace);
    verdict(&mut record, outcome.map_err(|error| error.to_string()), &trace);
    finish(&mut record, &ran, late, &schedule, &model, &trace);
    record.host_ms = u64::try_from(began.elapsed().as_millis()).unwrap_or(u64::MAX);
    // The applications leave what of them ran when they go.
    drop(model);
    let coverage = match (&collector, &program) {
        (Some(collector), Some(program)) => collector.take(program),
        _ => Vec::new(),
    };
    Ok(CaseResult { record, trace: Some(trace), coverage })
}

fn show(recorder: &mut Recorder, signal: SignalId, value: Value) {
    recorder.record(signal, When::exactly(Time::ZERO), value, signal::Cause::Controller);
}

/// Puts the judge's outcome and the notes of the trace into the record. The same for a run and for a trace that is
/// judged again, so that both come to the same.
pub fn verdict(record: &mut CaseRecord, outcome: Result<Outcome, String>, trace: &Trace) {
    match outcome {
        Ok(outcome) => {
            record.claims = outcome.claims;
            record.measurements = outcome.measurements;
            record.verdict = outcome.verdict;
            record.reason = outcome.reason;
        }
        Err(fault) => {
            record.verdict = Verdict::Error;
            record.reason = format!("the trace cannot be read: {fault}");
        }
    }
    record.ended = trace.note("ended").unwrap_or_default().to_owned();
    let obeyed = trace.notes().find_map(|(key, note)| Some((key.strip_prefix("refused:")?, note)));
    if let Some((step, note)) = obeyed {
        record.verdict = record.verdict.max(Verdict::Fail);
        if record.reason.is_empty() {
            record.reason = format!("step `{step}` expects a refusal: {note}");
        }
    }
    if let Some(unmet) = trace.note("unmet") {
        record.verdict = Verdict::Inconclusive;
        record.reason = unmet.to_owned();
    }
    if let Some(trouble) = trace.note("trouble") {
        record.verdict = Verdict::Error;
        record.reason = trouble.to_owned();
    }
}

fn finish(record: &mut CaseRecord, ran: &Ran, late: Span, schedule: &Schedule, model: &Model, trace: &Trace) {
    record.start_ns = ran.start.unwrap_or(ran.end).as_nanos();
    record.end_ns = ran.end.as_nanos();
    record.duration_ns = ran.closed.as_nanos();
    record.trace_sha256 = describe::hex(&trace.digest());
    record.timing = RigTiming {
        late_max_ns: late.as_nanos(),
        overruns: ran.overruns,
        dropped: ran.dropped,
        horizon_ns: 0,
    };
    for (step, planned) in schedule.steps().iter().enumerate() {
        let at = schedule.begun(step).map(|at| [at.as_nanos(), at.saturating_add(late).as_nanos()]);
        let what = record.steps.get(step).map_or_else(String::new, |known| known.what.clone());
        let phase = planned.phase.word().to_owned();
        let came = StepRecord { id: planned.id.clone(), at_ns: at, what, phase };
        match record.steps.get_mut(step) {
            Some(known) => *known = came,
            None => record.steps.push(came),
        }
    }
    for (at, text) in &ran.log {
        record.log_line(at.as_nanos(), text.clone());
    }
    record.log_dropped += ran.log_dropped;
    record.tasks = model
        .figures()
        .into_iter()
        .map(|(name, interval, figures)| TaskFigures {
            name,
            period_ns: interval.as_nanos(),
            cycles: figures.cycles,
            cycle_min_ns: figures.min.as_nanos(),
            cycle_mean_ns: figures.mean().as_nanos(),
            cycle_max_ns: figures.max.as_nanos(),
            overruns: figures.overruns,
            watchdogs: figures.exceptions,
        })
        .collect();
    record.lanes = lanes::excerpts(record, trace);
}

fn clock(kind: ClockKind, seed: u64) -> Box<dyn Clock> {
    match kind {
        ClockKind::Virtual => Box::new(VirtualClock::default()),
        ClockKind::Real => Box::new(HostClock::start()),
        ClockKind::Late(worst) => Box::new(LateClock::new(seed, worst)),
    }
}

fn no_such_program(
    program: &program::Program,
    tasks: &[(String, Vec<String>)],
    plan: &SourceFile,
) -> Diagnostic {
    let known = program.programs();
    let missing = tasks.iter().flat_map(|(task, programs)| programs.iter().map(move |name| (task, name)));
    let missing =
        missing.into_iter().find(|(_, name)| !known.iter().any(|one| one.eq_ignore_ascii_case(name)));
    let message = match missing {
        Some((task, name)) => format!("task {task} runs `{name}`, which the program does not have"),
        None => String::from("a task runs a PROGRAM that the program does not have"),
    };
    Diagnostic::error("R0114", message)
        .at(&plan.name, 0..0, "")
        .help(format!("the program has {}", known.join(", ")))
}
