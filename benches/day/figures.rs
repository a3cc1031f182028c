//! How long a case of so many modelled seconds takes, and what it takes: time is that of the processor, since a busy host makes
//! the wall's longer.

use scanrig_runtime::case::jobs::{JobResult, run};
use scanrig_runtime::executor::loop_counter::LoopCounter;
use scanrig_runtime::suite::{FileSource, load_plan};
use scanrig_runtime::{ClockKind, RunOptions};
use std::process::Command;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// The files of a case of so many seconds, its plan first: nothing is on disk.
pub type Files = fn(u64) -> Vec<(&'static str, String)>;

struct InMemory(Vec<(&'static str, String)>);

impl FileSource for InMemory {
    fn read(&self, path: &str) -> Result<String, String> {
        let found = self.0.iter().find(|(name, _)| *name == path);
        found.map(|(_, text)| text.clone()).ok_or_else(|| "the bench has no such file".to_owned())
    }
}

/// A figure of /proc/self/status in kilobytes; 0 where the system has none.
fn kilobytes(name: &str) -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix(name));
    line.and_then(|line| line.trim_start_matches(':').split_whitespace().next()?.parse().ok()).unwrap_or(0)
}

/// Processor time of all threads of this process, user and system; ticks of /proc are hundredths of a second.
fn processor_seconds() -> Option<f64> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    let mut fields = stat.rsplit_once(')')?.1.split_whitespace().skip(11);
    let user: f64 = fields.next()?.parse().ok()?;
    let system: f64 = fields.next()?.parse().ok()?;
    Some((user + system) / 100.0)
}

/// What one run took.
#[derive(Clone, Debug, Default)]
pub struct Figures {
    /// Of the wall, and of the processor.
    pub wall: f64,
    pub busy: f64,
    pub changes: u64,
    pub scans: u64,
    /// Turns of the executor: instants at which something happened, and slices of scans.
    pub turns: u64,
    /// Kilobytes resident at the start, and at most.
    pub start: u64,
    pub peak: u64,
    pub passed: bool,
}

impl Figures {
    /// Peak above start.
    pub fn above(&self) -> u64 {
        self.peak.saturating_sub(self.start)
    }

    pub fn line(&self) -> String {
        let Figures { wall, busy, changes, scans, turns, start, peak, passed } = self;
        format!("{wall} {busy} {changes} {scans} {turns} {start} {peak} {passed}")
    }

    fn parse(text: &str) -> Option<Figures> {
        let line = text.lines().find_map(|line| line.strip_prefix("figures "))?;
        let mut words = line.split_whitespace();
        Some(Figures {
            wall: words.next()?.parse().ok()?,
            busy: words.next()?.parse().ok()?,
            changes: words.next()?.parse().ok()?,
            scans: words.next()?.parse().ok()?,
            turns: words.next()?.parse().ok()?,
            start: words.next()?.parse().ok()?,
            peak: words.next()?.parse().ok()?,
            passed: words.next()?.parse().ok()?,
        })
    }

    fn print(&self, what: &str) {
        let each = self.busy * 1e9 / self.scans.max(1) as f64;
        println!(
            "{what}: {:.2} s of the processor, {:.2} s of the wall, {each:.0} ns a scan",
            self.busy, self.wall
        );
        println!("{what}: {} changes, {} scans, {} turns", self.changes, self.scans, self.turns);
        println!(
            "{what}: {} kB at the start, {} kB at most: {} kB above",
            self.start,
            self.peak,
            self.above()
        );
        println!("{what}: verdict {}", if self.passed { "pass" } else { "NOT pass" });
    }
}

/// Runs the case of so many modelled seconds in this process.
///
/// # Errors
/// What is wrong with its files.
pub fn measure(files: Files, seconds: u64) -> Result<Figures, String> {
    let start = kilobytes("VmRSS");
    let (began, spent) = (Instant::now(), processor_seconds());
    let mut sources = Vec::new();
    let found =
        |found: &[document::Diagnostic]| found.iter().map(|one| format!("{one:?}\n")).collect::<String>();
    let files = InMemory(files(seconds));
    let plan = files.0.first().map_or("", |(name, _)| name);
    let loaded = load_plan(&files, plan, None, &[], 1, &mut sources).map_err(|list| found(&list))?;
    let jobs = loaded.jobs(0, 1, 1);
    let (interrupt, turns) = (AtomicBool::new(false), LoopCounter::new());
    let mut options = RunOptions::new(ClockKind::Virtual, &interrupt);
    options.loop_counter = Some(&turns);
    let mut figures = Figures { start, ..Figures::default() };
    let mut trouble = String::new();
    run(&[loaded], &jobs, 1, false, &options, &mut |_, done| match done {
        JobResult::Case(result) => {
            let record = &result.record;
            figures.passed = record.verdict == record::Verdict::Pass;
            for claim in record.claims.iter().filter(|claim| claim.verdict != record::Verdict::Pass) {
                println!("{:?}: {}: {} ({})", claim.verdict, claim.expected, claim.observed, claim.reason);
            }
            if !record.reason.is_empty() {
                println!("{}", record.reason);
            }
            figures.scans = record.tasks.iter().map(|task| task.cycles).sum();
            figures.changes = result.trace.as_ref().map_or(0, signal::Trace::len);
        }
        JobResult::Findings(list) => trouble = found(&list),
        JobResult::Skipped(_) => trouble = "the case was skipped".to_owned(),
    });
    figures.wall = began.elapsed().as_secs_f64();
    figures.busy = processor_seconds().zip(spent).map_or(figures.wall, |(now, then)| now - then);
    figures.turns = turns.count();
    figures.peak = kilobytes("VmHWM");
    if trouble.is_empty() { Ok(figures) } else { Err(trouble) }
}

/// Runs a case of so many hours in a process of its own, so that its peak of memory is its own: the bench itself, with this
/// option and the seconds after it.
///
/// # Errors
/// The process did not start, or found something wrong.
pub fn measure_apart(option: &str, hours: u64) -> Result<Figures, String> {
    let program = std::env::current_exe().map_err(|error| error.to_string())?;
    let seconds = (hours * 3600).to_string();
    let output = Command::new(program)
        .args([option, &seconds])
        .output()
        .map_err(|error| format!("the bench cannot start itself: {error}"))?;
    let text = String::from_utf8_lossy(&output.stdout);
    for line in text.lines().filter(|line| !line.starts_with("figures ")) {
        println!("{line}");
    }
    let figures =
        Figures::parse(&text).ok_or_else(|| String::from_utf8_lossy(&output.stderr).into_owned())?;
    figures.print(&format!("{hours:2} h"));
    Ok(figures)
}

/// The number after an option of the command line.
pub fn seconds_after(option: &str) -> Option<u64> {
    let mut arguments = std::env::args().skip_while(|argument| argument != option).skip(1);
    arguments.next()?.parse().ok()
}

/// Prints whether a goal is met.
pub fn goal(met: bool, words: &str) -> bool {
    println!("{} {words}", if met { "met   " } else { "MISSED" });
    met
}
