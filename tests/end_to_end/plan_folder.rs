//! Runs plans inside the test, without the command: for what their records say, claim by claim.

use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

use record::CaseRecord;
use runtime::case::jobs::{self, JobResult};
use runtime::suite::{self, FileSource};
use runtime::{ClockKind, RunOptions};

/// A folder of plans, with one file read otherwise than it is written.
pub struct PlanFolder {
    pub path: PathBuf,
    /// Name of the file, what stands in it once, and what is read there.
    pub changed: Option<(&'static str, &'static str, &'static str)>,
}

impl FileSource for PlanFolder {
    fn read(&self, path: &str) -> Result<String, String> {
        let text = std::fs::read_to_string(self.path.join(path)).map_err(|error| error.to_string())?;
        match self.changed {
            Some((file, from, to)) if file == path => {
                assert_eq!(text.matches(from).count(), 1, "`{from}` in {path}");
                Ok(text.replace(from, to))
            }
            _ => Ok(text),
        }
    }

    fn bytes(&self, path: &str) -> Result<Vec<u8>, String> {
        self.read(path).map(String::into_bytes)
    }
}

impl PlanFolder {
    /// The records of all cases of a plan, in order; of those that run several times, of the first turns.
    pub fn run(&self, plan: &str, turns: u32) -> Vec<CaseRecord> {
        static NEVER: AtomicBool = AtomicBool::new(false);
        let mut sources = Vec::new();
        let loaded = suite::load_plan(self, plan, None, &[], 1, &mut sources)
            .unwrap_or_else(|found| panic!("{plan}: {}", document::render(&found, &sources, false)));
        let loaded = [loaded];
        let mut jobs = loaded[0].jobs(0, 1, 1);
        jobs.retain(|job| job.turn.is_none_or(|turn| turn <= turns));
        let mut records = Vec::new();
        let options = RunOptions::new(ClockKind::Virtual, &NEVER);
        jobs::run(&loaded, &jobs, 2, false, &options, &mut |_, done| match done {
            JobResult::Case(result) => records.push(result.record),
            JobResult::Findings(found) => panic!("{plan}: {found:?}"),
            JobResult::Skipped(_) => panic!("{plan}: skipped"),
        });
        records
    }
}
