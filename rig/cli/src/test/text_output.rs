//! A line a case, failures as they come and again at the end, the counts.

use super::display::{DisplayArgs, StatusLevel};
use super::observer::RunObserver;
use super::progress_display::ProgressDisplay;
use crate::output;
use document::{Diagnostic, SourceFile};
use record::{CaseRecord, RunRecord, Verdict};
use reports::text::{self, Style, details, numbered_line, summary};
use runtime::suite::Job;
use std::collections::{BTreeMap, BTreeSet};
use std::time::{Duration, Instant};

/// Prints lines on standard output; what depends on the speed of the host goes to standard error.
#[derive(Debug)]
pub struct TextOutput {
    style: Style,
    level: StatusLevel,
    slow: Duration,
    progress: ProgressDisplay,
    total: usize,
    /// Cases that run, by place: since when, and whether they were said to be slow.
    running: BTreeMap<usize, RunningCase>,
    /// Places of cases that took long and whose record is still to come.
    were_slow: BTreeSet<usize>,
    /// The lines of the cases that did not pass.
    failures: Vec<String>,
}

#[derive(Debug)]
struct RunningCase {
    name: String,
    began: Instant,
    reported: bool,
}

impl TextOutput {
    /// Lines as the command line wants them.
    pub fn new(display: &DisplayArgs) -> TextOutput {
        let progress = ProgressDisplay::new(display.progress);
        let usual = if progress.has_bar() { StatusLevel::Slow } else { StatusLevel::All };
        TextOutput {
            style: Style { color: output::color_out(), quiet: false },
            level: display.status_level.unwrap_or(usual),
            slow: display.slow,
            progress,
            total: 0,
            running: BTreeMap::new(),
            were_slow: BTreeSet::new(),
            failures: Vec::new(),
        }
    }

    fn draw(&self) {
        self.progress.draw(self.running.values().map(|case| case.name.as_str()));
    }

    /// Says once of each running case that it takes long.
    fn report_slow(&mut self) {
        for case in self.running.values_mut() {
            if !case.reported && case.began.elapsed() > self.slow && self.level >= StatusLevel::Slow {
                case.reported = true;
                let so_far = format!("> {:.3} s", case.began.elapsed().as_secs_f64());
                let line = format!("{:>12} [{so_far:>10}] {}", "SLOW", case.name);
                self.progress.above(|| output::info(&line));
            }
        }
    }

    fn print(&self, text: &str) {
        self.progress.above(|| output::print(&format!("{}\n", text.trim_end())));
    }
}

impl RunObserver for TextOutput {
    fn run_started(&mut self, run: &RunRecord, _at_once: usize) {
        self.total = usize::try_from(run.planned).unwrap_or(usize::MAX);
        self.progress.start(run.planned);
        self.draw();
    }

    fn case_started(&mut self, place: usize, job: &Job) {
        let name = text::clean(&job.name).into_owned();
        self.running.insert(place, RunningCase { name, began: Instant::now(), reported: false });
        self.draw();
    }

    fn case_ended(&mut self, place: usize) {
        // Time may not have passed since it became slow.
        self.report_slow();
        self.progress.ended();
        if self.running.remove(&place).is_some_and(|case| case.began.elapsed() > self.slow) {
            self.were_slow.insert(place);
        }
        self.draw();
    }

    fn time_passes(&mut self) {
        self.report_slow();
        self.draw();
    }

    fn found(&mut self, found: &[Diagnostic], sources: &[SourceFile]) {
        self.progress.above(|| output::findings(found, sources));
    }

    fn case_finished(&mut self, place: usize, record: &CaseRecord) {
        let line = numbered_line(record, place + 1, self.total, self.style);
        let slow = self.were_slow.remove(&place);
        if self.level >= StatusLevel::of(record, slow) {
            self.print(&line);
        }
        if record.is_judged() && record.verdict > Verdict::Pass {
            self.progress.failed();
            if self.level >= StatusLevel::Fail {
                self.print(&details(record, self.style));
            }
            let why = text::clean(&record.reason);
            let colon = if why.is_empty() { "" } else { ": " };
            self.failures.push(format!("{}{colon}{why}", line.trim_end()));
        }
        self.draw();
    }

    fn run_finished(&mut self, run: &RunRecord, page: Option<&str>) {
        self.progress.clear();
        if !run.coverage.is_empty() {
            self.print(&format!("\n{}", text::coverage(&run.coverage)));
            self.print("");
        }
        let repeats = text::repeats(run);
        if !repeats.is_empty() {
            self.print(&repeats);
        }
        self.print(&summary(run, self.style));
        // What failed long ago has scrolled away by now.
        if self.total > 1 && self.level >= StatusLevel::Fail {
            self.failures.iter().for_each(|line| self.print(line));
        }
        if let Some(page) = page {
            self.print(&format!("Report: {page}"));
        }
    }
}
