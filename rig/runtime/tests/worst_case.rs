//! `model = "worst case"`: edges of outputs lie anywhere from their command to the documented maximum, and nothing else changes.

use crate::common::events;
use crate::texts::Texts;
use record::{CaseRecord, Verdict};
use scanrig_runtime::case::jobs::JobResult;
use scanrig_runtime::case::rejudge;
use scanrig_runtime::{CaseResult, ClockKind, RunOptions};
use signal::{Event, LoadLimits, Trace};
use std::sync::atomic::AtomicBool;

/// The output follows the variable, and there is a pulse of one cycle when it is asked for.
const PROGRAM: &str = "PROGRAM MAIN
VAR
    on : BOOL;
    blip : BOOL;
    out AT %QX0.4 : BOOL;
END_VAR
out := on OR blip;
blip := FALSE;
END_PROGRAM
";

/// A cycle of 20 us is shorter than the delay of 34 us.
const HEAD: &str = "format = 1
program = \"p.st\"
settings = { mast = { interval = \"20 us\", watchdog = \"10 ms\" } }
signals = { on = \"MAIN.on\", blip = \"MAIN.blip\", out = \"%QX0.4\", written = { image = \"%QX0.4\" } }
";

fn run_with(model: &str, rest: &str, fail_fast: bool) -> Box<CaseResult> {
    let plan = format!("{HEAD}{model}{rest}");
    let interrupt = AtomicBool::new(false);
    let options = RunOptions { fail_fast, ..RunOptions::new(ClockKind::Virtual, &interrupt) };
    let result = Texts(&[("plan.toml", &plan), ("p.st", PROGRAM)]).run(1, &options);
    let mut bytes = Vec::new();
    result.trace.as_ref().unwrap().save(&mut bytes).unwrap();
    let loaded = Trace::load(&mut bytes.as_slice(), LoadLimits::default()).unwrap();
    let again = rejudge::judge(&document::SourceFile::new("plan.toml", plan), &loaded).unwrap();
    assert_eq!((again.claims, again.model), (result.record.claims.clone(), result.record.model.clone()));
    result
}

fn exact(rest: &str) -> Box<CaseResult> {
    run_with("", rest, false)
}

fn worst(rest: &str) -> Box<CaseResult> {
    run_with("model = \"worst case\"\n", rest, false)
}

fn verdicts(record: &CaseRecord) -> Vec<Verdict> {
    record.claims.iter().map(|claim| claim.verdict).collect()
}

const ON: &str = "steps = [
  { id = \"set\", at = \"start + 1 ms\", write = { of = \"on\", value = true } },
  { id = \"commanded\", when = { signal = \"written\", edge = \"rises\", within = \"1 ms\" } },
]
ends = \"commanded + 1 ms\"
";

// io:STD-OUT-01
#[test]
fn a_claim_within_the_documented_maximum_is_open() {
    let claims = format!(
        "{ON}expect = [
          {{ rises = {{ signal = \"out\", from = \"commanded\", within = \"30 us .. 40 us\" }} }},
          {{ rises = {{ signal = \"out\", from = \"commanded\", within = \"40 us\" }} }},
          {{ rises = {{ signal = \"out\", from = \"commanded\", within = \"36 us .. 50 us\" }} }},
        ]"
    );
    let (exact, worst) = (exact(&claims).record, worst(&claims).record);
    // The fourth claim is that the step came.
    assert_eq!(verdicts(&exact)[..3], [Verdict::Pass, Verdict::Pass, Verdict::Fail]);
    assert_eq!(
        verdicts(&worst)[..3],
        [Verdict::Inconclusive, Verdict::Pass, Verdict::Fail],
        "{:?}",
        worst.claims
    );
    assert_eq!((exact.model.as_str(), worst.model.as_str()), ("", "worst case"));
}

#[test]
fn the_model_itself_goes_on_with_the_maximum() {
    let plan = "steps = [
      { id = \"set\", at = \"start + 1 ms\", write = { of = \"on\", value = true } },
      { id = \"seen\", when = { signal = \"out\", edge = \"rises\", within = \"1 ms\" } },
      { id = \"blip\", at = \"seen + 1 ms\", write = { of = \"on\", value = false } },
    ]
    expect = [{ rises = { signal = \"out\" } }]";
    let others = |result: &CaseResult| -> Vec<Event> {
        let trace = result.trace.as_ref().unwrap();
        let out = trace.find("out").unwrap();
        events(trace).into_iter().filter(|event| event.signal != out).collect()
    };
    let (exact, worst) = (exact(plan), worst(plan));
    assert_eq!(others(&exact), others(&worst));
    let latest = |result: &CaseResult| -> Vec<_> {
        let trace = result.trace.as_ref().unwrap();
        let out = trace.find("out").unwrap();
        events(trace)
            .iter()
            .filter(|event| event.signal == out)
            .map(|event| (event.at.latest, event.value))
            .collect()
    };
    assert_eq!(latest(&exact), latest(&worst));
    assert_ne!(exact.record.trace_sha256, worst.record.trace_sha256);
}

#[test]
fn a_pulse_that_a_faster_stage_shows_is_not_excluded() {
    let claims = "steps = [{ id = \"blip\", at = \"start + 1 ms\", write = { of = \"blip\", value = true } }]
    ends = \"start + 3 ms\"
    expect = [
      { never = { signal = \"out\", is = true, from = \"start\", until = \"start + 2 ms\" } },
      { never = { signal = \"out\", is = true, from = \"start + 1.5 ms\", until = \"start + 2 ms\" } },
      { edges = { signal = \"out\", rising = 0, from = \"start\", until = \"start + 2 ms\" } },
    ]";
    assert_eq!(verdicts(&exact(claims).record), [Verdict::Pass; 3]);
    let worst = worst(claims).record;
    assert_eq!(verdicts(&worst), [Verdict::Inconclusive, Verdict::Pass, Verdict::Inconclusive]);
    let reason = &worst.claims[0].reason;
    assert!(reason.contains("within the delay of its output an edge may have come out"), "{reason}");
}

#[test]
fn an_edge_that_the_end_of_the_case_cuts_off_may_have_come() {
    let claims = "steps = [
      { id = \"set\", at = \"start + 1 ms\", write = { of = \"on\", value = true } },
      { id = \"commanded\", when = { signal = \"written\", edge = \"rises\", within = \"1 ms\" } },
    ]
    ends = \"commanded + 20 us\"
    expect = [
      { never = { signal = \"out\", is = true, from = \"start\", until = \"end\" } },
      { rises = { signal = \"out\", from = \"commanded\", within = \"15 us\" } },
      { value = { of = \"out\", is = false, when = \"start\" } },
    ]";
    assert_eq!(verdicts(&exact(claims).record)[..3], [Verdict::Pass, Verdict::Fail, Verdict::Pass]);
    let worst = worst(claims).record;
    assert_eq!(
        verdicts(&worst)[..3],
        [Verdict::Inconclusive, Verdict::Inconclusive, Verdict::Pass],
        "{:?}",
        worst.claims
    );
}

#[test]
fn a_claim_that_looks_lost_ends_no_case_early() {
    let claims = format!(
        "{ON}expect = [{{ rises = {{ signal = \"out\", from = \"commanded\", within = \"20 us\" }} }}]"
    );
    let early = run_with("", &claims, true).record;
    assert!(!early.ended.is_empty(), "ended by the lost claim");
    let worst = run_with("model = \"worst case\"\n", &claims, true).record;
    assert_eq!((verdicts(&worst)[0], worst.ended.as_str()), (Verdict::Inconclusive, ""));
}

#[test]
fn a_stage_that_goes_off_late_may_never_have_gone_off_before_the_next_command() {
    let claims = "steps = [
      { id = \"blip\", at = \"start + 1 ms\", write = { of = \"blip\", value = true } },
      { id = \"set\", at = \"blip + 100 us\", write = { of = \"on\", value = true } },
    ]
    ends = \"start + 3 ms\"
    expect = [
      { rises = { signal = \"out\", from = \"set\", within = \"80 us\" } },
      { stays = { signal = \"out\", is = true, from = \"blip + 60 us\", until = \"end\" } },
      { stays = { signal = \"out\", is = true, from = \"set + 80 us\", until = \"end\" } },
    ]";
    assert_eq!(verdicts(&exact(claims).record), [Verdict::Pass, Verdict::Fail, Verdict::Pass]);
    assert_eq!(
        verdicts(&worst(claims).record),
        [Verdict::Inconclusive, Verdict::Inconclusive, Verdict::Pass]
    );
}

#[test]
fn a_fault_on_the_line_of_an_output_is_refused() {
    let claims = "needs = [\"faults\"]
    steps = [
      { id = \"set\", at = \"start + 1 ms\", write = { of = \"on\", value = true } },
      { id = \"stuck\", at = \"set + 10 us\", fault = { signal = \"out\", kind = \"stuck\", value = false } },
    ]
    ends = \"start + 3 ms\"
    expect = [{ edges = { signal = \"out\", rising = 0 } }]";
    let interrupt = AtomicBool::new(false);
    let options = RunOptions::new(ClockKind::Virtual, &interrupt);
    let refused = |model: &str| {
        let plan = format!("{HEAD}{model}{claims}");
        match Texts(&[("plan.toml", &plan), ("p.st", PROGRAM)]).done(1, &options) {
            JobResult::Findings(found) => found.iter().any(|one| one.code == "R0234"),
            _ => false,
        }
    };
    assert!(!refused("") && refused("model = \"worst case\"\n"));
}
