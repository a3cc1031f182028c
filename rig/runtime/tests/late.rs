//! The executor on a clock whose waits end late: what runs on the host's clock, without the host.

mod common;

use common::{Library, Small, events};
use record::{CaseRecord, Verdict};
use scanrig_runtime::clock::{LateClock, VirtualClock};
use scanrig_runtime::suite::Job;
use scanrig_runtime::{CaseResult, ClockKind, RunOptions};
use signal::{Span, Trace, Value};
use std::sync::atomic::AtomicBool;

const WORST: Span = Span::from_micros(50);

fn run(library: &Library, job: &Job, clock: ClockKind, late: Span) -> CaseResult {
    let interrupt = AtomicBool::new(false);
    library.run(job, &RunOptions { late, ..RunOptions::new(clock, &interrupt) })
}

fn show(record: &CaseRecord) -> String {
    let lost = record.claims.iter().filter(|claim| claim.verdict > Verdict::Pass);
    let lost: Vec<String> =
        lost.map(|claim| format!("  {}: {} ({})", claim.expected, claim.observed, claim.reason)).collect();
    format!(
        "{} (seed {}): {:?} {}\n{}",
        record.name,
        record.seed,
        record.verdict,
        record.reason,
        lost.join("\n")
    )
}

#[test]
fn lateness_makes_a_pass_inconclusive_at_worst() {
    let library = Library::load();
    let mut wrong = Vec::new();
    let mut passed = 0;
    for job in &library.jobs {
        let exact = run(&library, job, ClockKind::Virtual, Span::from_millis(20)).record;
        let late = run(&library, job, ClockKind::Late(WORST), Span::from_millis(20)).record;
        if exact.verdict == Verdict::Pass && late.verdict > Verdict::Inconclusive {
            wrong.push(show(&late));
        }
        passed += usize::from(late.verdict == Verdict::Pass);
    }
    println!("{passed} of {} cases pass on a clock that is up to {WORST} late", library.jobs.len());
    assert!(wrong.is_empty(), "{} of {}:\n{}", wrong.len(), library.jobs.len(), wrong.join("\n"));
}
