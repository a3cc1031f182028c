//! One case from its plan to its record.

pub(crate) mod applicability;
pub mod capture_import;
pub(crate) mod check;
pub(crate) mod configure;
pub mod jobs;
pub mod lanes;
pub(crate) mod look_up;
pub(crate) mod needs;
pub(crate) mod refusal;
pub mod rejudge;
pub(crate) mod spill;
pub(crate) mod test_setup;
mod unused_terminals;

use crate::application::coverage::{Collector, CoveredFile};
use crate::case::configure::initial_state;
use crate::case::look_up::look_up;
use crate::case::needs::{Unmet, unmet, unmet_operator};
use crate::executor::clock::{Clock, HostClock, LateClock, VirtualClock};
use crate::executor::operator::Operator;
use crate::executor::recorder::Recorder;
use crate::executor::{Executor, ExecutorLimits, ExecutorReport, Parts};
use crate::hardware::{Hardware, in_virtual_time};
use crate::prepare::{NOT_PROMISED, PreparedCase};
use crate::scan_port::{self, ScanPort};
use crate::schedule::case_ending::{CaseEnding, EarlyEnd};
use crate::suite::case_files::CaseFiles;

use crate::case::test_setup::{TestSetup, set_up};
use crate::executor::loop_counter::LoopCounter;
use crate::executor::rig_fault::RigFault;
use crate::executor::stepping::Stepper;
use crate::schedule::Schedule;
use crate::subject::{Subject, SubjectExt};
use crate::suite::describe;
use crate::suite::nobody_to_ask;
use document::Diagnostic;
use drivers::BoardExt;
use drivers::RealtimeSettings;
use plans::Case;
use plans::judge::{CaseJudge, JudgedCase};
use record::{CaseRecord, CaseStatus, FramesKept, RigTiming, StepRecord, TaskFigures, Verdict};
use signal::{SignalId, Span, Time, Trace, Value, When};
use std::sync::Mutex;
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
    /// The real lines of the cases whose board file is theirs, if there are any.
    pub hardware: Option<&'a Hardware>,
    /// Is shown every turn of the executor.
    pub loop_counter: Option<&'a LoopCounter>,
    /// Serves the clients of a rig that is kept running.
    pub live: Option<&'a Mutex<ScanPort>>,
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
            hardware: None,
            loop_counter: None,
            live: None,
        }
    }
}

/// A case that was run, with its trace where there is one.
#[derive(Debug)]
pub struct CaseResult {
    /// The record.
    pub record: CaseRecord,
    /// The trace.
    pub trace: Option<Trace>,
    /// Its CAN frames, as `candump -L` writes them; empty where there were none.
    pub frames: String,
    /// What of the program ran, file by file, where that was asked for.
    pub coverage: Vec<CoveredFile>,
    /// What the compiler warns of in its programs.
    pub warnings: Vec<Diagnostic>,
}

impl CaseResult {
    /// A case that did not run and has no trace.
    fn not_run(record: CaseRecord) -> CaseResult {
        CaseResult { record, trace: None, frames: String::new(), coverage: Vec::new(), warnings: Vec::new() }
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
        Some(refusal) if !files.board.subject.is_external() => {
            refusal::check(case, files, refusal).map(|()| Vec::new())
        }
        _ => look_up(case, files),
    }
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
    tracing::debug!(case = case.name, plan = files.plan.name, board = files.board.name, "a case begins");
    let outcome = step_case(case, files, options, None);
    match &outcome {
        Ok(result) => tracing::debug!(
            case = case.name,
            verdict = %result.record.verdict,
            host_ms = result.record.host_ms,
            "a case is over"
        ),
        Err(found) => tracing::debug!(case = case.name, findings = found.len(), "a case cannot be run"),
    }
    outcome
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
    if let Some(refusal) = case.refusal.as_ref().filter(|_| !files.board.subject.is_external()) {
        refusal::run(case, files, refusal, &mut record);
        record.host_ms = u64::try_from(began.elapsed().as_millis()).unwrap_or(u64::MAX);
        return Ok(CaseResult::not_run(record));
    }
    if let Some(found) = nobody_to_ask(case, &files.plan.name).filter(|_| options.operator.is_none()) {
        return Err(vec![found]);
    }
    let mut case = files.guarded(case)?;
    let collector = options.coverage.then(Collector::default);
    let mut stage = set_up(&case, files, collector.clone())?;
    let mut warnings = std::mem::take(&mut stage.program_warnings);
    files.joined.locate(&mut warnings);
    let hardware = options.hardware.filter(|hardware| hardware.name() == files.board.name);
    if let Some(hardware) = hardware {
        stage.board = Box::new(hardware.lease());
    } else if files.board.is_real() {
        return Err(vec![in_virtual_time(&files.board)]);
    }
    let missing = applicability::missing_of_own_board(&case, files, &*stage.board);
    if !missing.is_empty() {
        return Err(missing);
    }
    let lacks = unmet_operator(&case, options.operator.is_some())
        .or_else(|| unmet(&case, &*stage.subject, &*stage.board, Span::ZERO))
        .or_else(|| applicability::not_applicable_reason(&case, files, &*stage.board).map(Unmet::Power));
    if let Some(unmet) = lacks {
        match unmet {
            Unmet::Power(reason) => record.status = CaseStatus::NotApplicable { reason },
            Unmet::Instrument(reason) => {
                record.verdict = Verdict::Inconclusive;
                record.reason = reason;
            }
        }
        return Ok(CaseResult { warnings, ..CaseResult::not_run(record) });
    }
    if files.board.subject.is_external() {
        applicability::remove_unreachable_signals(case.to_mut(), files, &*stage.board);
    }
    let case = &*case;
    let mut clock = clock(options.clock, files.seed, hardware);
    let trace = Trace::with_spill(options.trace_memory, spill::temporary());
    let prepared = stage.prepare(case, files, trace, clock.is_exact())?;
    let mut found = check::claims(&stage.on_bench(case, files, &prepared));
    found.retain(Diagnostic::is_error);
    if !found.is_empty() {
        return Err(found);
    }
    // Lines that are not known to make the pulses of a step are no instrument for it.
    if let Some(warning) = prepared.warnings.iter().find(|warning| warning.code == NOT_PROMISED) {
        record.verdict = Verdict::Inconclusive;
        record.reason = format!("{}; {}", warning.message, warning.help);
        return Ok(CaseResult { warnings, ..CaseResult::not_run(record) });
    }
    let TestSetup { mut subject, mut board, program, .. } = stage;
    let initial = initial_state(case.settings.initial);
    let PreparedCase { mut trace, mut wiring, steps, probes, mut alarms, .. } = prepared;
    describe::annotate(&mut trace, case, files, &*subject, clock.name());
    describe::promises(&mut trace, &wiring, board.channels());
    describe::coverages(&mut trace, &wiring, &files.board, case);
    let mut judge = CaseJudge::new(case.scenario(), trace.signals())?.by_clock(files.board.clock.error);
    // Edges that may have come earlier are reported when they come in the model, or behind a delay: until then no claim is lost.
    let fail_fast = options.fail_fast && record.model.is_empty() && files.board.delays.is_empty();
    if !fail_fast {
        judge = judge.without_early_end();
    }
    let mut recorder = Recorder::new(trace, judge);
    for (probe, signal) in &probes {
        show(&mut recorder, *signal, subject.read(probe));
    }
    let mut schedule = Schedule::new(steps, case.ends.clone());
    let limits = ExecutorLimits {
        initial,
        late: hardware.and_then(Hardware::late).unwrap_or(options.late),
        slice: options.slice,
        horizon: hardware.map_or_else(RealtimeSettings::default, |hardware| *hardware.settings()).horizon,
        fail_fast,
        on_loss: files.board.on_loss,
        reconnect: files.board.reconnects(),
        timeout: case.timeout,
        teardown: case.teardown,
    };
    let parts = Parts {
        clock: &mut *clock,
        subject: &mut *subject,
        board: &mut *board,
        recorder: &mut recorder,
        schedule: &mut schedule,
        wiring: &mut wiring,
        alarms: &mut alarms,
        interrupt: options.interrupt,
        operator: options.operator,
        heartbeat: hardware.and_then(Hardware::heartbeat),
        loop_counter: options.loop_counter,
    };
    let mut port = options.live.map(scan_port::lock);
    let executor = Executor::new(parts, limits).serving(port.as_deref_mut(), scan_port::ExecutorRole::Case);
    let entered = hardware.map(Hardware::enter);
    let mut ran = match stepper {
        Some(stepper) => executor.stepping(stepper).run(),
        None => executor.run(),
    };
    drop(entered);
    drop(port);
    if let Err(error) = subject.unload(options.interrupt) {
        ran.fault.get_or_insert(RigFault::Hook(error));
    }
    let late = recorder.late();
    let (mut trace, judge) = recorder.into_parts();
    // How late the rig was shows only now. Steps that came later than the plan needs may have tested something else.
    let unmet = match unmet(case, &*subject, &*board, late) {
        Some(Unmet::Instrument(reason)) => Some(reason),
        _ => None,
    };
    let ending = CaseEnding {
        early: schedule.early_end(),
        not_refused: std::mem::take(&mut ran.not_refused),
        exceptions: ran.exceptions.iter().map(|stop| stop.noted(ran.start, subject.catalogue())).collect(),
        unmet,
        fault: ran.fault.as_ref().map(|fault| fault.show(board.channels()).to_string()),
    };
    ending.write_to(&mut trace);
    if ending.early == Some(EarlyEnd::Claim) {
        trace.set_note(plans::judge::LOST_NOTE, judge.lost_words());
    }
    let outcome = judge.finish(When::exactly(ran.end), &trace);
    verdict(&mut record, outcome.map_err(|error| error.to_string()), &ending, &case.expected_states());
    finish(&mut record, &ran, late, &schedule, &*subject, &trace);
    record.host_ms = u64::try_from(began.elapsed().as_millis()).unwrap_or(u64::MAX);
    // The applications leave what of them ran when they go.
    drop(subject);
    let coverage = match (&collector, &program) {
        (Some(collector), Some(program)) => collector.take(program),
        _ => Vec::new(),
    };
    let (kept, more) = ran.frames.counts();
    record.frames = (kept > 0).then_some(FramesKept { kept, more });
    let frames = ran.frames.text(board.bus_list());
    Ok(CaseResult { record, trace: Some(trace), frames, coverage, warnings })
}

fn show(recorder: &mut Recorder, signal: SignalId, value: Value) {
    recorder.record(signal, When::exactly(Time::ZERO), value, signal::Cause::Controller);
}

/// Puts the judge's outcome and how the case ended into the record. The same for a run and for a trace that is judged
/// again, so that both come to the same.
pub fn verdict(
    record: &mut CaseRecord,
    outcome: Result<JudgedCase, String>,
    ending: &CaseEnding,
    expected_states: &[String],
) {
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
    ending.judge(record, expected_states);
}

fn finish(
    record: &mut CaseRecord,
    ran: &ExecutorReport,
    late: Span,
    schedule: &Schedule,
    subject: &dyn Subject,
    trace: &Trace,
) {
    record.start_ns = ran.start.unwrap_or(ran.end).as_nanos();
    record.end_ns = ran.end.as_nanos();
    record.duration_ns = ran.closed.as_nanos();
    record.trace_sha256 = describe::hex(&trace.digest());
    record.timing = RigTiming {
        late_max_ns: late.as_nanos(),
        overruns: ran.overruns,
        dropped: ran.dropped,
        horizon_ns: ran.horizon.as_nanos(),
        wakes: ran.wakes.clone(),
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
    record.tasks = subject
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

pub(crate) fn clock(kind: ClockKind, seed: u64, hardware: Option<&Hardware>) -> Box<dyn Clock> {
    if let Some(hardware) = hardware {
        return Box::new(hardware.clock());
    }
    match kind {
        ClockKind::Virtual => Box::new(VirtualClock::default()),
        ClockKind::Real => Box::new(HostClock::start()),
        ClockKind::Late(worst) => Box::new(LateClock::new(seed, worst)),
    }
}
