//! Runs the chosen cases, collects their records, and reports to an observer.

use super::INTERRUPT;
use super::args::{ClockChoice, TestArgs};
use super::display::TraceOn;
use super::observer::RunObserver;
use super::reporting::{ReportingArgs, SuitePart};
use crate::exit::ExitStatus;
use crate::operator::TerminalOperator;
use crate::saved_runs::provenance;
use crate::saved_runs::report_folder::ReportFolder;
use crate::{output, requirements, run_exit};
use document::{Diagnostic, SourceFile};
use record::{CaseRecord, RunRecord, Verdict};
use runtime::application::coverage::CoverageTotal;
use runtime::case::jobs::{self, JobEvent, JobResult};
use runtime::suite::real_boards;
use runtime::suite::{self, Job, LoadedPlan};
use runtime::{ClockKind, Hardware, Operator, RunOptions};
use signal::{Span, Trace};
use std::sync::atomic::Ordering;
use std::time::Instant;

/// How long a run on the host's clock takes at most to see an interrupt.
const REAL_SLICE: Span = Span::from_millis(50);

/// Runs jobs and writes the reports.
///
/// # Errors
/// How the command ends where the run could not begin; why is printed.
pub fn execute(
    args: &TestArgs,
    loaded: &[LoadedPlan],
    jobs: &[Job],
    part: SuitePart,
    sources: &[SourceFile],
    observer: &mut dyn RunObserver,
) -> Result<ExitStatus, ExitStatus> {
    let asks = jobs.iter().any(|job| job.asks);
    let operator = TerminalOperator::if_present();
    if let Some(found) = suite::unanswerable(loaded, jobs).filter(|_| operator.is_none()) {
        output::findings(&[found], sources);
        return Err(ExitStatus::UserFiles);
    }
    output::findings(real_boards::program_not_loaded(loaded).as_slice(), sources);
    let hardware = hardware(args, loaded, jobs, sources)?;
    let real = hardware.is_some() || args.clock == Some(ClockChoice::Real);
    let clock = if real { record::RunClock::Real } else { record::RunClock::Virtual };
    let folder = args
        .report
        .as_deref()
        .map(ReportFolder::new)
        .transpose()
        .map_err(|error| output::refuse("R0167", error, "name a folder that you may write to"))?;
    // One question at a time.
    let at_once = if asks { 1 } else { at_once(args, real).min(jobs.len()) };
    let mut collector = RunCollector {
        run: RunRecord::new(env!("CARGO_PKG_VERSION"), provenance::now(args.seed, clock)),
        folder,
        trace_on: args.display.trace_on,
        coverage: CoverageTotal::default(),
        reporting: args.reporting.clone(),
        began: Instant::now(),
        wrong_files: false,
        trouble: None,
    };
    collector.run.provenance.environment.extend(hardware.iter().flat_map(Hardware::facts));
    collector.run.planned = jobs.len() as u64;
    collector.run.shard = part.shard;
    collector.run.selection_sha256 = part.selection_sha256;
    observer.run_started(&collector.run, at_once);
    let operator = operator.as_ref().map(|operator| operator as &dyn Operator);
    let options = RunOptions { operator, hardware: hardware.as_ref(), ..options(args, real) };
    // What the compiler warns of in a program, once for all cases that run it.
    let mut warned: Vec<Diagnostic> = Vec::new();
    jobs::watch(loaded, jobs, at_once, args.fail_fast, &options, &mut |happened| match happened {
        JobEvent::Begun(place) => observer.case_started(place, &jobs[place]),
        JobEvent::Ended(place) => observer.case_ended(place),
        JobEvent::Idle => observer.time_passes(),
        JobEvent::Done(place, done) => {
            match &done {
                JobResult::Findings(found) => observer.found(found, sources),
                JobResult::Case(result) => {
                    let new = |one: &&Diagnostic| !warned.contains(one);
                    let new: Vec<Diagnostic> = result.warnings.iter().filter(new).cloned().collect();
                    if !new.is_empty() {
                        observer.found(&new, sources);
                        warned.extend(new);
                    }
                }
                JobResult::Skipped(_) => {}
            }
            let record = collector.collect(done, &jobs[place], loaded);
            observer.case_finished(place, record);
        }
    });
    Ok(collector.finish(observer))
}

/// Opens the real lines that the jobs run on, if they do, and says what the machine refuses them.
fn hardware(
    args: &TestArgs,
    loaded: &[LoadedPlan],
    jobs: &[Job],
    sources: &[SourceFile],
) -> Result<Option<Hardware>, ExitStatus> {
    let refused = |found: &[Diagnostic]| {
        output::findings(found, sources);
        ExitStatus::UserFiles
    };
    let Some(board) = real_boards::real_board(loaded, jobs).map_err(|found| refused(&[found]))? else {
        return Ok(None);
    };
    if args.clock == Some(ClockChoice::Virtual) {
        return Err(refused(&[runtime::hardware::in_virtual_time(board)]));
    }
    let lock = args.wait.take(board, &INTERRUPT)?;
    let hardware = Hardware::open(board).map_err(|found| refused(&found))?;
    let Some(mut hardware) = hardware.map(|hardware| hardware.with_lock(lock)) else { return Ok(None) };
    output::findings(&hardware.warnings(), sources);
    if let Err(found) = hardware.check(board.check, &INTERRUPT) {
        output::findings(found.as_slice(), sources);
        return Err(if found.is_some() { ExitStatus::Error } else { ExitStatus::Interrupted });
    }
    Ok(Some(hardware))
}

fn options(args: &TestArgs, real: bool) -> RunOptions<'static> {
    let kind = if real { ClockKind::Real } else { ClockKind::Virtual };
    let mut options = RunOptions {
        fail_fast: args.fail_fast,
        coverage: args.coverage,
        ..RunOptions::new(kind, &INTERRUPT)
    };
    if real {
        // Nothing may happen for minutes; an interrupt is not to wait for it.
        options.slice = REAL_SLICE;
    }
    options
}

/// How many cases run at a time. On the host's clock they would make each other late.
fn at_once(args: &TestArgs, real: bool) -> usize {
    match args.jobs {
        _ if real => 1,
        Some(jobs) => jobs.into(),
        None => std::thread::available_parallelism().map_or(1, usize::from),
    }
}

/// So many events are drawn as waves in less than a second.
const WAVES_AT_ONCE: u64 = 200_000;

/// Collects the results of a run.
struct RunCollector {
    run: RunRecord,
    folder: Option<ReportFolder>,
    trace_on: TraceOn,
    coverage: CoverageTotal,
    reporting: ReportingArgs,
    began: Instant,
    wrong_files: bool,
    trouble: Option<Diagnostic>,
}

impl RunCollector {
    /// Collects the result of a job, and returns its record.
    fn collect(&mut self, done: JobResult, job: &Job, loaded: &[LoadedPlan]) -> &CaseRecord {
        let (mut record, trace, frames) = match done {
            JobResult::Case(result) => {
                self.coverage.add(result.coverage);
                (result.record, result.trace, result.frames)
            }
            JobResult::Skipped(record) => (*record, None, String::new()),
            JobResult::Findings(found) => {
                self.wrong_files = true;
                (refused(&found, job, loaded), None, String::new())
            }
        };
        if let Some(trace) = &trace {
            self.store_trace(&mut record, trace, &frames);
        }
        // They lie beside the trace or nowhere.
        if record.trace_file.is_none() {
            record.frames = None;
        }
        self.run.push(record);
        &self.run.cases[self.run.cases.len() - 1]
    }

    fn store_trace(&mut self, record: &mut CaseRecord, trace: &Trace, frames: &str) {
        let Some(folder) = &mut self.folder else { return };
        if !self.trace_on.keeps(record) {
            return;
        }
        // Waves take the longest by far, and whoever interrupts does not wait for many: `rig report` draws them from the trace.
        let waves = trace.len() <= WAVES_AT_ONCE || !INTERRUPT.load(Ordering::Relaxed);
        let kept = folder.trace(record, trace, waves).and_then(|path| {
            if record.frames.is_some() {
                folder.frames(&path, frames)?;
            }
            Ok(path)
        });
        match kept {
            Ok(path) => record.trace_file = Some(path),
            Err(error) => self.trouble = Some(Diagnostic::error("R0167", error)),
        }
    }

    /// Writes the reports, reports the end, and returns how the command ends.
    fn finish(mut self, observer: &mut dyn RunObserver) -> ExitStatus {
        // Whoever closes standard output after the last case has read its verdict.
        let unread = output::is_unread();
        self.run.coverage =
            if self.run.shard.is_some() { self.coverage.part() } else { self.coverage.record() };
        self.run.host_ms = u64::try_from(self.began.elapsed().as_millis()).unwrap_or(u64::MAX);
        self.run.requirements = requirements::facts(&self.run);
        let page = self.reporting.write_all(&self.run, self.folder.as_ref()).unwrap_or_else(|found| {
            self.trouble = Some(found);
            None
        });
        observer.run_finished(&self.run, page.as_deref());
        if let Some(found) = self.trouble {
            output::findings(&[found], &[]);
            return ExitStatus::Error;
        }
        if unread {
            return ExitStatus::Unread;
        }
        if INTERRUPT.load(Ordering::Relaxed) {
            return ExitStatus::Interrupted;
        }
        if self.wrong_files { ExitStatus::UserFiles } else { run_exit::of(&self.run) }
    }
}

/// The record of a case that the user's files keep from running.
fn refused(found: &[Diagnostic], job: &Job, loaded: &[LoadedPlan]) -> CaseRecord {
    CaseRecord {
        name: job.name.clone(),
        plan: loaded[job.plan].plan.path.clone(),
        title: job.title.clone(),
        turn: job.turn,
        verdict: Verdict::Error,
        reason: found.first().map_or_else(String::new, |first| first.message.clone()),
        ..CaseRecord::default()
    }
}
