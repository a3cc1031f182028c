//! The shipped library in process: every case passes, and its recorded trace alone gives every verdict again.

use record::{CaseRecord, Verdict};
use scanrig_runtime::suite::{self, Disk, Done, LoadedPlan};
use scanrig_runtime::{CaseResult, ClockKind, RunOptions, rejudge};
use signal::{LoadLimits, Trace};
use std::path::Path;
use std::sync::atomic::AtomicBool;

const LIBRARY: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../plans/library");

fn plans(folder: &Path, found: &mut Vec<String>) {
    let mut paths: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    for path in paths {
        if path.is_dir() {
            plans(&path, found);
        } else if path.extension().is_some_and(|ending| ending == "toml") {
            let text = std::fs::read_to_string(&path).unwrap();
            if !text.contains("[board]") {
                found.push(path.to_string_lossy().into_owned());
            }
        }
    }
}

/// What the trace of a case says of itself, after it was saved and loaded.
fn again(plan: &LoadedPlan, result: &CaseResult) -> CaseRecord {
    let mut bytes = Vec::new();
    result.trace.as_ref().unwrap().save(&mut bytes).unwrap();
    let loaded = Trace::load(&mut bytes.as_slice(), LoadLimits::default()).unwrap();
    rejudge::judge(plan.plan.source(), &loaded).unwrap()
}

#[test]
fn every_case_passes_and_its_trace_says_so_again() {
    let (mut paths, mut sources, mut jobs) = (Vec::new(), Vec::new(), Vec::new());
    plans(Path::new(LIBRARY), &mut paths);
    let loaded: Vec<LoadedPlan> = paths
        .iter()
        .map(|path| {
            suite::load_plan(&Disk, path, None, &[], 1, &mut sources)
                .unwrap_or_else(|found| panic!("{found:#?}"))
        })
        .collect();
    for (place, plan) in loaded.iter().enumerate() {
        jobs.extend(plan.jobs(place, 1, 1));
    }
    let interrupt = AtomicBool::new(false);
    let options = RunOptions::new(ClockKind::Virtual, &interrupt);
    let mut wrong = Vec::new();
    suite::run(&loaded, &jobs, 2, false, &options, &mut |place, done| match done {
        Done::Case(result) => {
            let record = &result.record;
            if record.verdict != Verdict::Pass {
                wrong.push(format!("{}: {:?} {}", record.name, record.verdict, record.reason));
            }
            let replayed = again(&loaded[jobs[place].plan], &result);
            if replayed.claims != record.claims || replayed.measurements != record.measurements {
                wrong.push(format!("{}: the trace gives other claims", record.name));
            }
            let facts = |record: &CaseRecord| {
                (record.verdict, record.trace_sha256.clone(), record.start_ns, record.end_ns)
            };
            if facts(&replayed) != facts(record) {
                wrong.push(format!(
                    "{}: {:?} in the run, {:?} again",
                    record.name,
                    facts(record),
                    facts(&replayed)
                ));
            }
        }
        Done::Findings(found) => wrong.push(format!("{}: {found:#?}", jobs[place].name)),
        Done::Skipped(_) => wrong.push(format!("{}: skipped", jobs[place].name)),
    });
    assert!(jobs.len() >= 25, "the library has only {} cases", jobs.len());
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
