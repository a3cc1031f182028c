//! The shipped library in process: every case passes, and its recorded trace alone gives every verdict again.

use crate::common::Library;
use record::{CaseRecord, Verdict};
use scanrig_runtime::case::jobs::{self, JobResult};
use scanrig_runtime::case::rejudge;
use scanrig_runtime::suite::LoadedPlan;
use scanrig_runtime::{ClockKind, RunOptions};
use signal::{LoadLimits, Trace};
use std::sync::atomic::AtomicBool;

/// What the trace of a case says of itself, after it was saved and loaded.
fn again(plan: &LoadedPlan, trace: &Trace) -> CaseRecord {
    let mut bytes = Vec::new();
    trace.save(&mut bytes).unwrap();
    let loaded = Trace::load(&mut bytes.as_slice(), LoadLimits::default()).unwrap();
    rejudge::judge_gathered(plan.plan.text(), &loaded).unwrap()
}

#[test]
fn every_case_passes_and_its_trace_says_so_again() {
    let library = Library::load();
    let interrupt = AtomicBool::new(false);
    let options = RunOptions::new(ClockKind::Virtual, &interrupt);
    let mut wrong = Vec::new();
    jobs::run(&library.plans, &library.jobs, 2, false, &options, &mut |place, done| match done {
        JobResult::Case(result) => {
            let record = &result.record;
            if record.verdict != Verdict::Pass {
                wrong.push(format!("{}: {:?} {}", record.name, record.verdict, record.reason));
            }
            // A case that is refused as it must be has no trace.
            let Some(trace) = &result.trace else { return };
            let replayed = again(&library.plans[library.jobs[place].plan], trace);
            for (claim, again) in record.claims.iter().zip(&replayed.claims) {
                if claim != again {
                    wrong.push(format!("{}: {claim:?} in the run, {again:?} again", record.name));
                }
            }
            if replayed.claims.len() != record.claims.len() || replayed.measurements != record.measurements {
                wrong.push(format!("{}: the trace gives other claims or measurements", record.name));
            }
            let facts = |record: &CaseRecord| {
                (record.verdict, record.trace_sha256.clone(), record.start_ns, record.end_ns)
            };
            if facts(&replayed) != facts(record) {
                let (run, again) = (facts(record), facts(&replayed));
                wrong.push(format!("{}: {run:?} in the run, {again:?} again", record.name));
            }
        }
        JobResult::Findings(found) => wrong.push(format!("{}: {found:#?}", library.jobs[place].name)),
        JobResult::Skipped(_) => wrong.push(format!("{}: skipped", library.jobs[place].name)),
    });
    assert!(library.jobs.len() >= 200, "the library has only {} cases", library.jobs.len());
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Every segment of a trace but the one that grows goes to the disk, and comes back for the verdicts and the lanes.
#[test]
fn a_trace_without_memory_comes_to_the_same() {
    let library = Library::sample();
    let interrupt = AtomicBool::new(false);
    let run = |trace_memory| {
        let options = RunOptions { trace_memory, ..RunOptions::new(ClockKind::Virtual, &interrupt) };
        let mut results = vec![None; library.jobs.len()];
        jobs::run(&library.plans, &library.jobs, 2, false, &options, &mut |place, done| {
            let JobResult::Case(result) = done else { panic!("{}: {done:?}", library.jobs[place].name) };
            let events = result.trace.as_ref().map_or(0, Trace::len);
            results[place] = Some((events, CaseRecord { host_ms: 0, ..result.record }));
        });
        results.into_iter().map(Option::unwrap).collect::<Vec<_>>()
    };
    let (in_memory, on_disk) = (run(usize::MAX), run(0));
    for (memory, disk) in in_memory.iter().zip(&on_disk) {
        assert_eq!(memory, disk);
    }
    // A segment then has half a kilobyte or a little more, and a change takes about six bytes.
    let long = on_disk.iter().filter(|(events, _)| *events > 400).count();
    assert!(long >= 50, "only {long} cases are longer than one segment");
}
