//! Many jobs, several at once, and what becomes of them in their own order.

use crate::case::{CaseResult, RunOptions, run_case};
use crate::suite::{Job, LoadedPlan};
use document::Diagnostic;
use record::CaseRecord;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::Duration;

/// What became of a job.
#[derive(Debug)]
pub enum JobResult {
    /// It ran, or was found not to apply.
    Case(Box<CaseResult>),
    /// Something is wrong with the user's files.
    Findings(Vec<Diagnostic>),
    /// It was left out because the run ended before it.
    Skipped(Box<CaseRecord>),
}

/// What happens while jobs run, with the place of the job.
#[derive(Debug)]
pub enum JobEvent {
    /// The job begins: reported at once, so that several jobs at a time come in any order.
    Begun(usize),
    /// The job has ended: reported at once, and its result later.
    Ended(usize),
    /// What became of the job, in the order of the jobs.
    Done(usize, JobResult),
    /// Nothing, for a while: whoever shows progress shows that time passes.
    Idle,
}

/// How long nothing happens before that is reported.
const IDLE: Duration = Duration::from_millis(100);

/// Runs jobs, several at once, and hands each result to `each` in the order of the jobs.
pub fn run(
    plans: &[LoadedPlan],
    jobs: &[Job],
    at_once: usize,
    fail_fast: bool,
    options: &RunOptions<'_>,
    each: &mut dyn FnMut(usize, JobResult),
) {
    watch(plans, jobs, at_once, fail_fast, options, &mut |happened| {
        if let JobEvent::Done(place, done) = happened {
            each(place, done);
        }
    });
}

/// What a worker reports.
enum WorkerEvent {
    Begun,
    Done(JobResult),
}

/// As [`run`], and reports when jobs begin and end.
pub fn watch(
    plans: &[LoadedPlan],
    jobs: &[Job],
    at_once: usize,
    fail_fast: bool,
    options: &RunOptions<'_>,
    report: &mut dyn FnMut(JobEvent),
) {
    let next = AtomicUsize::new(0);
    let stop = AtomicBool::new(false);
    let (send, receive) = mpsc::sync_channel::<(usize, WorkerEvent)>(at_once * 2);
    std::thread::scope(|scope| {
        for _ in 0..at_once.clamp(1, jobs.len().max(1)) {
            let send = send.clone();
            let (next, stop) = (&next, &stop);
            scope.spawn(move || {
                loop {
                    let place = next.fetch_add(1, Ordering::Relaxed);
                    let Some(job) = jobs.get(place) else { return };
                    let ended = stop.load(Ordering::Relaxed) || options.interrupt.load(Ordering::Relaxed);
                    if !ended && send.send((place, WorkerEvent::Begun)).is_err() {
                        return;
                    }
                    let done = if ended { skipped(plans, job) } else { run_job(plans, job, options) };
                    // Here and not where the results are taken, or else the next job would have begun.
                    if fail_fast && !passed(&done) {
                        stop.store(true, Ordering::Relaxed);
                    }
                    if send.send((place, WorkerEvent::Done(done))).is_err() {
                        return;
                    }
                }
            });
        }
        drop(send);
        // Results come in any order and are handed on in the order of the jobs.
        let mut waiting: Vec<Option<JobResult>> = Vec::new();
        waiting.resize_with(jobs.len(), || None);
        let mut handed = 0;
        loop {
            let (place, done) = match receive.recv_timeout(IDLE) {
                Ok((place, WorkerEvent::Done(done))) => (place, done),
                Ok((place, WorkerEvent::Begun)) => {
                    report(JobEvent::Begun(place));
                    continue;
                }
                Err(RecvTimeoutError::Timeout) => {
                    report(JobEvent::Idle);
                    continue;
                }
                Err(RecvTimeoutError::Disconnected) => break,
            };
            if !matches!(done, JobResult::Skipped(_)) {
                report(JobEvent::Ended(place));
            }
            waiting[place] = Some(done);
            while let Some(done) = waiting.get_mut(handed).and_then(Option::take) {
                report(JobEvent::Done(handed, done));
                handed += 1;
            }
        }
    });
}

fn passed(done: &JobResult) -> bool {
    match done {
        JobResult::Case(result) => {
            !result.record.is_judged() || result.record.verdict == record::Verdict::Pass
        }
        JobResult::Findings(_) => false,
        JobResult::Skipped(_) => true,
    }
}

fn skipped(plans: &[LoadedPlan], job: &Job) -> JobResult {
    let mut record = CaseRecord::skipped(&job.name, "the run ended before it");
    record.turn = job.turn;
    if let Some(loaded) = plans.get(job.plan) {
        record.plan.clone_from(&loaded.plan.path);
        record.title.clone_from(&loaded.plan.title);
    }
    JobResult::Skipped(Box::new(record))
}

fn run_job(plans: &[LoadedPlan], job: &Job, options: &RunOptions<'_>) -> JobResult {
    let Some(loaded) = plans.get(job.plan) else { return JobResult::Findings(Vec::new()) };
    // What the plan leaves to chance is drawn again in each turn.
    let case = match loaded.plan.case_with(job.case, job.seed) {
        Ok(case) => case,
        Err(found) => return JobResult::Findings(found),
    };
    let files = match loaded.files(&case, job) {
        Ok(files) => files,
        Err(found) => return JobResult::Findings(found),
    };
    match run_case(&case, &files, options) {
        Ok(mut result) => {
            result.record.turn = job.turn;
            JobResult::Case(Box::new(result))
        }
        Err(found) => JobResult::Findings(found),
    }
}
