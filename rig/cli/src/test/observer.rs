//! What is reported while cases run.

use document::{Diagnostic, SourceFile};
use record::{CaseRecord, RunRecord};
use runtime::suite::Job;

/// Observes a run: what a terminal, a CI log or a program that reads events shows of it.
pub trait RunObserver {
    /// The run begins: the record without cases yet, and how many cases run at a time.
    fn run_started(&mut self, _run: &RunRecord, _at_once: usize) {}

    /// The job of this place begins.
    fn case_started(&mut self, _place: usize, _job: &Job) {}

    /// The job of this place has ended; its record comes in its turn.
    fn case_ended(&mut self, _place: usize) {}

    /// Something is wrong with the user's files, seen only now.
    fn found(&mut self, found: &[Diagnostic], sources: &[SourceFile]);

    /// The case of this place is judged, does not apply or was skipped. In the order of the jobs.
    fn case_finished(&mut self, _place: usize, _record: &CaseRecord) {}

    /// Nothing happened for a while.
    fn time_passes(&mut self) {}

    /// Every case is finished, and the reports are written: `page` is the path of the page.
    fn run_finished(&mut self, _run: &RunRecord, _page: Option<&str>) {}
}
