//! What suites and boards claim of every case, and alarms that end one.

use crate::texts::Texts;
use record::{ClaimOrigin, ClaimRecord, Verdict};
use scanrig_runtime::case::rejudge;
use scanrig_runtime::{CaseResult, ClockKind, RunOptions};
use signal::{Span, Value};
use std::sync::atomic::AtomicBool;

const SUITE: &str = r#"
format = 1
title = "Two lamps that exclude each other"
signals = { one = "%QX0.0", two = "%QX0.1" }
invariants = [
  { name = "never both", never = { all = ["one", "two"] } },
]
"#;

const BOARD: &str = r#"
format = 1
title = "A contact that follows"
[board]
kind = "simulated"
[[wires]]
from = "Q0"
to = "I1"
delay = "3 ms"
[[invariants]]
name = "the contact follows"
edges = { signal = "I1", rising = "1 .." }
"#;

const BOTH: &str = "PROGRAM MAIN VAR a AT %QX0.0 : BOOL; b AT %QX0.1 : BOOL; in AT %IX0.0 : BOOL; END_VAR a := in; b := in; END_PROGRAM";

fn plan(more: &str) -> String {
    format!(
        r#"
format = 1
title = "A button"
program = "lamp.st"
signals = {{ button = "%IX0.0", lamp = "%QX0.0" }}
steps = [{{ id = "press", at = "start + 1 s", pulse = {{ signal = "button", width = "1 s" }} }}]
{more}
"#
    )
}

fn run(files: &[(&str, &str)], clock: ClockKind) -> Box<CaseResult> {
    let interrupt = AtomicBool::new(false);
    Texts(files).run(1, &RunOptions::new(clock, &interrupt))
}

fn claim<'r>(result: &'r CaseResult, name: &str) -> &'r ClaimRecord {
    result.record.claims.iter().find(|claim| claim.name == name).expect("a claim")
}

#[test]
fn the_record_says_which_file_claims_what() {
    let plan = plan("board = \"bench.toml\"\nexpect = [{ rises = { signal = \"lamp\", from = \"press\" } }]");
    let files =
        [("plan.toml", plan.as_str()), ("lamp.st", BOTH), ("suite.toml", SUITE), ("bench.toml", BOARD)];
    let result = run(&files, ClockKind::Virtual);
    crate::texts::expect(&result, Verdict::Fail);
    let both = claim(&result, "never both");
    assert_eq!(
        (both.verdict, both.origin, both.line, both.guard),
        (Verdict::Fail, ClaimOrigin::Suite, 6, true)
    );
    assert_eq!(both.place_file.as_deref(), Some("suite.toml"));
    let follows = claim(&result, "the contact follows");
    assert_eq!((follows.verdict, follows.origin, follows.line), (Verdict::Pass, ClaimOrigin::Board, 10));
    assert!(!result.record.claims[0].guard && result.record.claims[0].place_file.is_none());
    // The trace holds what they claim: the files are not needed to judge it again.
    let source = document::SourceFile::new("elsewhere.toml", plan.clone());
    let again = rejudge::judge(&source, result.trace.as_ref().unwrap()).unwrap();
    assert_eq!(again.claims, result.record.claims);
}

#[test]
fn a_name_that_the_bench_does_not_have_is_shown_in_the_suite() {
    let plan = plan("expect = [{ rises = { signal = \"lamp\", from = \"press\" } }]");
    let suite = "format = 1\ninvariants = [{ never = { signal = \"MAIN.nothing\" } }]\n";
    let (loaded, jobs) = Texts(&[("plan.toml", &plan), ("lamp.st", BOTH), ("suite.toml", suite)]).load(1);
    let case = loaded.plan.case(0).unwrap();
    let files = loaded.files(&case, &jobs[0]).unwrap();
    let found = scanrig_runtime::case::check_case(&case, &files).unwrap_err();
    assert_eq!((found[0].code, found[0].labels[0].file.as_str()), ("R0104", "suite.toml"));
    assert_eq!(&suite[found[0].labels[0].span.clone()], "\"MAIN.nothing\"");
}

#[test]
fn an_alarm_ends_its_case_when_it_is_raised() {
    let alarms = r#"
alarms = [{ name = "lit too long", when = { signal = "lamp", is = true }, delay = "300 ms" }]
expect = [{ falls = { signal = "lamp", from = "press.done", within = "100 ms" } }]"#;
    let plan = plan(alarms);
    for clock in [ClockKind::Virtual, ClockKind::Late(Span::from_millis(3))] {
        let result = run(&[("plan.toml", &plan), ("lamp.st", BOTH)], clock);
        crate::texts::expect(&result, Verdict::Fail);
        let alarm = claim(&result, "lit too long");
        assert_eq!((alarm.verdict, alarm.verb.as_str()), (Verdict::Fail, "alarm"));
        // What the claim waits for did not come any more.
        assert_eq!(
            result.record.claims[0].verdict,
            Verdict::Inconclusive,
            "{}",
            result.record.claims[0].reason
        );
        assert!(
            result.record.reason.starts_with("lit too long: the alarm was raised"),
            "{}",
            result.record.reason
        );
        let trace = result.trace.as_ref().unwrap();
        let mark = trace.find("alarm:lit too long").unwrap();
        assert_eq!(trace.last(mark).unwrap().value, Value::Int(1));
        // The rest of the plan was not waited for.
        let lit = alarm.deciding_ns.unwrap()[1];
        let ended = result.record.end_ns - lit;
        assert!((300_000_000..310_000_000).contains(&ended), "{ended} ns after the rise");
        let source = document::SourceFile::new("plan.toml", plan.clone());
        let again = rejudge::judge(&source, trace).unwrap();
        assert_eq!((again.verdict, &again.claims), (Verdict::Fail, &result.record.claims));
    }
}

#[test]
fn an_alarm_that_does_not_end_its_case_fails_it_at_the_end() {
    let alarms = r#"
alarms = [{ name = "lit too long", when = { signal = "lamp", is = true }, delay = "300 ms", ends = false }]
expect = [{ falls = { signal = "lamp", from = "press.done", within = "100 ms" } }]"#;
    let plan = plan(alarms);
    let result = run(&[("plan.toml", &plan), ("lamp.st", BOTH)], ClockKind::Virtual);
    crate::texts::expect(&result, Verdict::Fail);
    assert_eq!(result.record.claims[0].verdict, Verdict::Pass);
    assert_eq!(result.record.end_ns - result.record.start_ns, 3_000_000_000);
}

#[test]
fn an_alarm_that_is_not_raised_says_how_near_it_was() {
    let plan = plan(
        "alarms = [{ name = \"lit too long\", when = { signal = \"lamp\", is = true }, delay = \"2 s\" }]",
    );
    let result = run(&[("plan.toml", &plan), ("lamp.st", BOTH)], ClockKind::Virtual);
    crate::texts::expect(&result, Verdict::Pass);
    let margin = claim(&result, "lit too long").margin.as_ref().unwrap().to_string();
    assert!(margin.starts_with("1 s") || margin.starts_with("1.0") || margin.starts_with("999"), "{margin}");
}
