//! The shipped library in process.

// Each test binary uses a part of it.
#![allow(dead_code)]

use plans::Case;
use scanrig_runtime::suite::{self, Disk, Job, LoadedPlan};
use scanrig_runtime::{CaseResult, RunOptions, run_case};
use signal::Trace;
use std::path::Path;

const LIBRARY: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../plans/library");

fn collect(folder: &Path, found: &mut Vec<String>) {
    let mut paths: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    for path in paths {
        if path.is_dir() {
            collect(&path, found);
        } else if path.extension().is_some_and(|ending| ending == "toml") {
            let text = std::fs::read_to_string(&path).unwrap();
            // Board files, suite files and what plans include stand beside them.
            let beside = ["common.toml", "suite.toml"].iter().any(|name| path.ends_with(name));
            if !text.contains("[board]") && !beside {
                found.push(path.to_string_lossy().into_owned());
            }
        }
    }
}

/// The plans that ship, with all their cases.
pub struct Library {
    pub plans: Vec<LoadedPlan>,
    pub jobs: Vec<Job>,
}

impl Library {
    pub fn load() -> Library {
        let (mut paths, mut sources) = (Vec::new(), Vec::new());
        collect(Path::new(LIBRARY), &mut paths);
        let load = |path: &String| {
            suite::load_plan(&Disk, path, None, &[], 1, &mut sources)
                .unwrap_or_else(|found| panic!("{found:#?}"))
        };
        let plans: Vec<LoadedPlan> = paths.iter().map(load).collect();
        let jobs = plans.iter().enumerate().flat_map(|(place, plan)| plan.jobs(place, 1, 1)).collect();
        Library { plans, jobs }
    }

    /// One case of each plan, of neighbouring plans not those in the same place: every program and every kind of step is
    /// among them, in a fraction of the time.
    pub fn sample() -> Library {
        let mut library = Library::load();
        let jobs = std::mem::take(&mut library.jobs);
        let of_one = jobs.chunk_by(|one, next| one.plan == next.plan);
        library.jobs = of_one.map(|jobs| jobs[jobs[0].plan % jobs.len()].clone()).collect();
        library
    }

    pub fn case(&self, job: &Job) -> Case {
        self.plans[job.plan].plan.case(job.case).unwrap()
    }

    pub fn run(&self, job: &Job, options: &RunOptions<'_>) -> CaseResult {
        let case = self.case(job);
        let files = self.plans[job.plan].files(&case, job).unwrap();
        run_case(&case, &files, options).unwrap_or_else(|found| panic!("{}: {found:#?}", job.name))
    }
}

/// Every event of a trace, in its order.
pub fn events(trace: &Trace) -> Vec<signal::Event> {
    trace.events().map(|event| event.unwrap()).collect()
}
