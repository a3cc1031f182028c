//! What a claim came to, as it stands in the record.

use record::{ClaimRecord, Verdict};
use signal::Cause;

use super::StepFacts;
use crate::expect::Expectation;
use crate::monitor::{Finding, NotJudged};

/// The record of a claim. `silent` says that a signal of it was never observed.
pub(super) fn claim_record(
    expectation: &Expectation,
    finding: Result<Finding, NotJudged>,
    silent: Option<String>,
    writer: &dyn Fn(Cause) -> String,
) -> ClaimRecord {
    let claim = &expectation.claim;
    let expected = claim.expected();
    let name = if expectation.name.is_empty() { expected.clone() } else { expectation.name.clone() };
    let mut record = ClaimRecord {
        name,
        verb: expectation.verb.to_owned(),
        expected,
        line: expectation.place.as_ref().map_or(0, |place| place.line),
        ..ClaimRecord::default()
    };
    let finding = match finding {
        Ok(finding) => finding,
        Err(why) => {
            record.verdict = Verdict::Inconclusive;
            record.reason = why.to_string();
            record.observed = String::from("not judged");
            return record;
        }
    };
    record.verdict = finding.verdict();
    record.reason = match (record.verdict, silent) {
        (Verdict::Pass, _) => String::new(),
        (Verdict::Inconclusive, Some(silent)) => silent,
        _ => finding.reason,
    };
    record.observed = finding.observed;
    record.margin = finding.margin;
    record.uncertainty = finding.uncertainty;
    record.window = finding.window;
    record.bounds = finding.bounds;
    record.deciding_ns = finding.deciding.map(|at| [at.earliest.as_nanos(), at.latest.as_nanos()]);
    record.signal = claim.signals().into_iter().nth(finding.slot);
    record.last_writer = finding.cause.map(writer).filter(|writer| !writer.is_empty());
    let nearest = finding.nearest_miss.filter(|_| record.verdict != Verdict::Pass);
    record.nearest_miss = nearest.map(|(what, cause)| match cause.map(writer) {
        Some(writer) if !writer.is_empty() => format!("{what}, written by {writer}"),
        _ => what,
    });
    record
}

/// Who made a change, in the user's names; empty for nobody known.
pub(super) fn writer(cause: Cause, steps: &[StepFacts], note: &dyn Fn(&str) -> Option<String>) -> String {
    match cause {
        Cause::Unknown => String::new(),
        Cause::Controller => String::from("the controller"),
        Cause::Board | Cause::Gap(_) => String::from("the board"),
        Cause::Step(at) => match steps.get(usize::from(at)) {
            Some(step) => format!("step {}", step.id),
            None => format!("step {}", u32::from(at) + 1),
        },
        Cause::Port(port) => {
            let port = note(&format!("port:{port}")).unwrap_or_else(|| format!("port {port}"));
            format!("a client at {port}")
        }
        Cause::Program { task, file, line } => {
            let task = note(&format!("task:{task}")).unwrap_or_else(|| format!("task {task}"));
            match note(&format!("file:{file}")) {
                Some(file) => format!("{task} {file}:{line}"),
                None => format!("{task} line {line}"),
            }
        }
    }
}
