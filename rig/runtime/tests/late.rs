//! The executor on a clock whose waits end late: what runs on the host's clock, without the host.

use crate::common::{Library, events};
use record::{CaseRecord, Verdict};
use scanrig_runtime::case::rejudge;
use scanrig_runtime::suite::Job;
use scanrig_runtime::{CaseResult, ClockKind, RunOptions};
use signal::{Span, Value};
use std::sync::atomic::AtomicBool;

const WORST: Span = Span::from_micros(50);
const EXACT: ClockKind = ClockKind::Virtual;
const LATE: ClockKind = ClockKind::Late(WORST);

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

/// What is wrong with a run on the late clock beside one in virtual time.
fn compare(exact: &CaseResult, late: &CaseResult) -> Option<String> {
    let record = &late.record;
    if exact.record.verdict == Verdict::Pass && record.verdict > Verdict::Inconclusive {
        return Some(show(record));
    }
    let (exact, late) = (exact.trace.as_ref()?, late.trace.as_ref()?);
    let (exact_events, late_events) = (events(exact), events(late));
    if exact_events.len() != late_events.len() {
        return Some(format!(
            "{}: {} events, {} when late",
            record.name,
            exact_events.len(),
            late_events.len()
        ));
    }
    let end = exact.find("step:end").and_then(|end| exact_events.iter().find(|event| event.signal == end));
    let end = end.map(|end| end.at.earliest);
    let fits = |(exact, late): (&signal::Event, &signal::Event)| {
        let same = (exact.signal, exact.value, exact.cause) == (late.signal, late.value, late.cause);
        let inside = late.at.earliest <= exact.at.earliest && exact.at.latest <= late.at.latest;
        // The end of a case waits for as long as a mark was late, and that of its teardown as well: each wait may end late.
        let waits = if end.is_some_and(|end| exact.at.earliest >= end) { 3 } else { 1 };
        same && inside && late.at.latest - late.at.earliest <= Span::from_nanos(waits * WORST.as_nanos())
    };
    let (exact, late) = exact_events.iter().zip(&late_events).find(|pair| !fits(*pair))?;
    Some(format!("{}: {exact:?} in virtual time, {late:?} when late", record.name))
}

#[test]
fn lateness_widens_intervals_and_nothing_else() {
    let library = Library::sample();
    let (mut wrong, mut passed) = (Vec::new(), 0);
    for job in &library.jobs {
        let (exact, late) = (run(&library, job, EXACT, WORST), run(&library, job, LATE, WORST));
        wrong.extend(compare(&exact, &late));
        passed += usize::from(late.record.verdict == Verdict::Pass);
        // What was recorded gives the same verdicts again, also where instants are intervals.
        if let Some(trace) = &late.trace {
            let again = rejudge::judge_gathered(library.plans[job.plan].plan.text(), trace).unwrap();
            if (&again.claims, again.verdict, again.end_ns)
                != (&late.record.claims, late.record.verdict, late.record.end_ns)
            {
                wrong.push(format!("{}: the trace gives other verdicts", job.name));
            }
        }
    }
    assert!(wrong.is_empty(), "{} of {}:\n{}", wrong.len(), library.jobs.len(), wrong.join("\n"));
    // The comparison is worth something only where claims are not all inconclusive.
    assert!(passed * 3 > library.jobs.len(), "only {passed} of {} cases pass", library.jobs.len());
}

#[test]
fn lateness_follows_from_the_seed() {
    let library = Library::load();
    let running = library.jobs.iter().filter(|job| library.case(job).refusal.is_none());
    let jobs = running.step_by(library.jobs.len() / 12);
    for job in jobs {
        let hash = |seed| run(&library, &Job { seed, ..job.clone() }, LATE, WORST).record.trace_sha256;
        assert_eq!(hash(7), hash(7), "{}", job.name);
        assert_ne!(hash(7), hash(8), "{}", job.name);
        for seed in [7, 8] {
            let job = Job { seed, ..job.clone() };
            let exact = run(&library, &job, EXACT, WORST);
            assert_eq!(compare(&exact, &run(&library, &job, LATE, WORST)), None);
        }
    }
}

// A host that is late is the rig's error, never the controller's HALT.
#[test]
fn a_rig_that_is_too_late_is_in_error_and_its_controller_is_not() {
    let library = Library::load();
    let plan = |job: &&Job| job.name.ends_with("watchdog/fallback[under]");
    let job = library.jobs.iter().find(plan).expect("a case with a cycle just below its watchdog");
    let result = run(&library, job, LATE, Span::from_micros(10));
    assert_eq!(result.record.verdict, Verdict::Error);
    assert!(
        result.record.reason.contains("late") && result.record.reason.contains("10 us"),
        "{}",
        result.record.reason
    );
    assert!(result.record.timing.overruns > 0 && result.record.timing.late_max_ns > 10_000);
    let trace = result.trace.unwrap();
    let state = trace.find("state").unwrap();
    let halt = Value::Int(controller::State::Halt.number());
    assert!(events(&trace).iter().all(|event| event.signal != state || event.value != halt));
    assert_eq!(result.record.tasks.iter().map(|task| task.watchdogs).sum::<u64>(), 0);
}
