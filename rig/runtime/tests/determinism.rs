//! A trace follows from plan, program and seed: neither the length of slices nor the number of jobs shows in it
//! (docs/decisions/0003-time-of-an-operation.md).

use crate::common::Library;
use scanrig_runtime::case::jobs::{self, JobResult};
use scanrig_runtime::suite::Job;
use scanrig_runtime::{ClockKind, RunOptions};
use signal::Span;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Name, hash of the trace, and end of the case.
type Facts = (String, String, i64);

fn facts(library: &Library, job: &Job, slice: Span) -> Facts {
    let interrupt = AtomicBool::new(false);
    let options = RunOptions { slice, ..RunOptions::new(ClockKind::Virtual, &interrupt) };
    let record = library.run(job, &options).record;
    // Only a case that is refused when it is checked has no trace.
    let refused = library.case(job).refusal.is_some();
    assert_eq!(record.trace_sha256.is_empty(), refused, "{}", record.name);
    (record.name, record.trace_sha256, record.end_ns)
}

/// Runs a check over the jobs on all processors.
fn on_all(jobs: &[Job], check: impl Fn(&Job) -> Option<String> + Sync) {
    let halves = jobs.split_at(jobs.len() / 2);
    let run = |jobs: &[Job]| jobs.iter().filter_map(&check).collect::<Vec<_>>();
    let wrong: Vec<String> = std::thread::scope(|scope| {
        let other = scope.spawn(|| run(halves.1));
        let mut wrong = run(halves.0);
        wrong.extend(other.join().unwrap());
        wrong
    });
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn slices_do_not_show_in_the_trace() {
    let library = Library::sample();
    let short = AtomicUsize::new(0);
    on_all(&library.jobs, |job| {
        let whole = facts(&library, job, Span::MAX);
        // At most so many turns a case: the smallest slices take millions a second, so that few cases have them.
        let fine = Span::from_nanos((whole.2 / 200_000).max(7_300));
        let mut slices = vec![fine];
        if whole.2 < 1_800_000_000 && short.fetch_add(1, Ordering::Relaxed).is_multiple_of(32) {
            slices.push(Span::from_nanos(333));
        }
        let other = slices.into_iter().find(|slice| facts(&library, job, *slice) != whole)?;
        Some(format!("{}: the trace is another one with slices of {other}", job.name))
    });
    assert!(short.load(Ordering::Relaxed) >= 3, "no case is short enough for the smallest slices");
}

#[test]
fn jobs_do_not_show_in_the_traces() {
    let library = Library::sample();
    let interrupt = AtomicBool::new(false);
    let options = RunOptions::new(ClockKind::Virtual, &interrupt);
    let traces = |at_once| {
        let mut traces = Vec::new();
        jobs::run(&library.plans, &library.jobs, at_once, false, &options, &mut |_, done| match done {
            JobResult::Case(result) => traces.push((result.record.name, result.record.trace_sha256)),
            other => panic!("{other:?}"),
        });
        traces
    };
    let one = traces(1);
    assert_eq!(one.len(), library.jobs.len());
    assert_eq!(one, traces(2));
}
