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
pub enum Done {
    /// It ran, or was found not to apply.
    Case(Box<CaseResult>),
    /// Something is wrong with the user's files.
    Findings(Vec<Diagnostic>),
    /// It was left out because the run ended before it.
    Skipped(Box<CaseRecord>),
}

/// What happens while jobs run, with the place of the job.
#[derive(Debug)]
pub enum Happened {
    /// The job begins: told at once, so that several jobs at a time come in any order.
    Begun(usize),
    /// The job has ended: told at once, and its result later.
    Ended(usize),
    /// What became of the job, in the order of the jobs.
    Done(usize, Done),
    /// Nothing, for a while: whoever shows progress shows that time passes.
    Idle,
}

/// How long nothing happens before that is told.
const IDLE: Duration = Duration::from_millis(100);

/// Runs jobs, several at once, and hands each result to `each` in the order of the jobs.
pub fn run(
    plans: &[LoadedPlan],
    jobs: &[Job],
    at_once: usize,
    fail_fast: bool,
    options: &RunOptions<'_>,
    each: &mut dyn FnMut(usize, Done),
) {
    watch(plans, jobs, at_once, fail_fast, options, &mut |happened| {
        if let Happened::Done(place, done) = happened {
            each(place, done);
        }
    });
}

/// What a worker tells.
enum Told {
    Begun,
    Done(Done),
}

/// As [`run`], and tells when jobs begin and end.
pub fn watch(
    plans: &[LoadedPlan],
    jobs: &[Job],
    at_once: usize,
    fail_fast: bool,
    options: &RunOptions<'_>,
    tell: &mut dyn FnMut(Happened),
) {
    let next = AtomicUsize::new(0);
    let stop = AtomicBool::new(false);
    let (send, receive) = mpsc::sync_channel::<(usize, Told)>(at_once * 2);
    std::thread::scope(|scope| {
        for _ in 0..at_once.clamp(1, jobs.len().max(1)) {
            let send = send.clone();
            let (next, stop) = (&next, &stop);
            scope.spawn(move || {
                loop {
                    let place = next.fetch_add(1, Ordering::Relaxed);
                    let Some(job) = jobs.get(place) else { return };
                    let ended = stop.load(Ordering::Relaxed) || options.interrupt.load(Ordering::Relaxed);
                    if !ended && send.send((place, Told::Begun)).is_err() {
                        return;
                    }
                    let done = if ended { skipped(plans, job) } else { run_job(plans, job, options) };
                    // Here and not where the results are taken, or else the next job would have begun.
                    if fail_fast && !passed(&done) {
                        stop.store(true, Ordering::Relaxed);
                    }
                    if send.send((place, Told::Done(done))).is_err() {
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
        loop {
            let (place, done) = match receive.recv_timeout(IDLE) {
                Ok((place, Told::Done(done))) => (place, done),
                Ok((place, Told::Begun)) => {
                    tell(Happened::Begun(place));
                    continue;
                }
                Err(RecvTimeoutError::Timeout) => {
                    tell(Happened::Idle);
                    continue;
                }
                Err(RecvTimeoutError::Disconnected) => break,
            };
            if !matches!(done, Done::Skipped(_)) {
                tell(Happened::Ended(place));
            }
            waiting[place] = Some(done);
            while let Some(done) = waiting.get_mut(handed).and_then(Option::take) {
                tell(Happened::Done(handed, done));
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
    record.turn = job.turn;
    if let Some(loaded) = plans.get(job.plan) {
        record.plan.clone_from(&loaded.plan.path);
        record.title.clone_from(&loaded.plan.title);
    }
    Done::Skipped(Box::new(record))
}

fn run_job(plans: &[LoadedPlan], job: &Job, options: &RunOptions<'_>) -> Done {
    let Some(loaded) = plans.get(job.plan) else { return Done::Findings(Vec::new()) };
    // What the plan leaves to chance is drawn anew in each turn.
    let case = match loaded.plan.case_with(job.case, job.seed) {
        Ok(case) => case,
        Err(found) => return Done::Findings(found),
    };
    let files = match loaded.files(&case, job) {
        Ok(files) => files,
        Err(found) => return Done::Findings(found),
    };
    match run_case(&case, &files, options) {
        Ok(mut result) => {
            result.record.turn = job.turn;
            Done::Case(Box::new(result))
        }
        Err(found) => Done::Findings(found),
    }
}
