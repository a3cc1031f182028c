//! A case that is ended at a lost claim comes to the verdict that it would have come to without.

use proptest::prelude::*;
use record::Verdict;
use scanrig_plans::judge::{CaseJudge, JudgedCase, LOST_NOTE, Scenario};
use signal::{Cause, Event, SignalId, SignalInfo, Time, Trace, Value, ValueKind, When};

use crate::oracle_values::scenario;

const CLAIMS: &[&str] = &[
    r#"{ stays = { signal = "q", is = false, from = "a" } }"#,
    r#"{ stays = { signal = "q", is = false, from = "a", until = "b" } }"#,
    r#"{ never = { signal = "r", from = "a + 2 ns", until = "a + 9 ns" } }"#,
    r#"{ never = { all = ["q", "r"] } }"#,
    r#"{ edges = { signal = "q", rising = "0 .. 1", from = "a", until = "b" } }"#,
    r#"{ edges = { signal = "r", rising = "2 .." } }"#,
    r#"{ rises = { signal = "r", from = "a" } }"#,
    r#"{ rises = { signal = "q", from = "a", within = "3 ns .. 8 ns" } }"#,
    r#"{ falls = { signal = "q", from = "b", within = "8 ns" } }"#,
    r#"{ pulse = { signal = "q", width = "3 ns .. 9 ns", which = "every" } }"#,
    r#"{ period = { signal = "q", is = "4 ns .. 20 ns", from = "a" } }"#,
    r#"{ value = { of = "r", is = true, when = "b" } }"#,
    r#"{ value = { of = "r", is = true, when = "a + 4 ns" } }"#,
    r#"{ order = { edges = ["q rises", "r rises"] } }"#,
    r#"{ happens = { step = "b" } }"#,
    r#"{ name = "n", value-of = "q", take = "mean", max = "0.5" }"#,
    r#"{ name = "t", from = "a", to = { signal = "r", edge = "rises" }, max = "9 ns" }"#,
];

const END: i64 = 60;
const SIGNALS: [(&str, ValueKind); 6] = [
    ("q", ValueKind::Bool),
    ("r", ValueKind::Bool),
    ("step:a", ValueKind::Mark),
    ("step:b", ValueKind::Mark),
    ("step:start", ValueKind::Mark),
    ("step:end", ValueKind::Mark),
];

/// The claims in one scenario.
fn all(which: &[usize]) -> Scenario {
    let mut whole = Scenario::default();
    for place in which {
        let one = scenario(CLAIMS[*place]);
        whole.expectations.extend(one.expectations);
        whole.measurements.extend(one.measurements);
    }
    whole
}

/// An event: place of the signal, instant, whether TRUE.
type Change = (usize, i64, bool);

/// Judges; ends at the first claim that is lost if that is wanted, and reads the trace again.
fn judged(scenario: &Scenario, changes: &[Change], fail_fast: bool) -> (JudgedCase, bool) {
    let infos: Vec<SignalInfo> = SIGNALS.iter().map(|(name, kind)| SignalInfo::exact(*name, *kind)).collect();
    let mut trace = Trace::new();
    for info in &infos {
        trace.define(info.clone()).unwrap();
    }
    let mut judge = CaseJudge::new(scenario.clone(), &infos).unwrap();
    let (mut end, mut lost) = (END, false);
    let start: [Change; 3] = [(0, 0, false), (1, 0, false), (4, 0, true)];
    for (signal, at, on) in start.iter().chain(changes).copied().chain([(5, END, true)]) {
        if lost {
            break;
        }
        let mut push = |signal: usize, at: i64, on: bool| {
            let value = if signal < 2 { Value::Bool(on) } else { Value::Int(1) };
            let at = When::exactly(Time::from_nanos(at));
            let event = Event { signal: SignalId(signal as u32), at, value, cause: Cause::Unknown };
            if let Some(event) = trace.push(event).unwrap() {
                judge.feed(&event);
            }
        };
        push(signal, at, on);
        if fail_fast && signal != 5 && judge.failed_early() {
            (end, lost) = (at, true);
            let event = Event {
                signal: SignalId(5),
                at: When::exactly(Time::from_nanos(at)),
                value: Value::Int(1),
                cause: Cause::Unknown,
            };
            judge.feed(&trace.push(event).unwrap().unwrap());
        }
    }
    if lost {
        let words = judge.lost_words();
        trace.set_note(LOST_NOTE, words);
    }
    let end = When::exactly(Time::from_nanos(end));
    let live = judge.finish(end, &trace).unwrap();
    let again = CaseJudge::new(scenario.clone(), &infos).unwrap().replay(end, &trace).unwrap();
    assert_eq!(live, again, "a trace that is judged again");
    (live, lost)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2_000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn the_verdict_is_that_of_the_whole_case(
        which in prop::collection::vec(0..CLAIMS.len(), 1..6),
        steps in prop::collection::vec((0usize..4, 1i64..7, any::<bool>()), 0..12),
    ) {
        let (mut now, mut came) = (0, [false; 4]);
        let mut changes: Vec<Change> = Vec::new();
        for (signal, gap, on) in steps {
            now = (now + gap).min(END - 1);
            if signal < 2 || !std::mem::replace(&mut came[signal], true) {
                changes.push((signal, now, on));
            }
        }
        let scenario = all(&which);
        let (whole, _) = judged(&scenario, &changes, false);
        let (early, lost) = judged(&scenario, &changes, true);
        if !lost {
            prop_assert_eq!(whole, early);
            return Ok(());
        }
        prop_assert_eq!(early.verdict, Verdict::Fail, "{:?} {:?}", early, changes);
        prop_assert_eq!(whole.verdict, Verdict::Fail);
        // A claim is what it is in the whole case, or not judged.
        let not_judged = "not judged: the case was ended when another claim was lost";
        for (one, other) in early.claims.iter().zip(&whole.claims) {
            prop_assert!(one.verdict == other.verdict || one.reason == not_judged, "{one:?} {other:?} {changes:?}");
        }
        for (one, other) in early.measurements.iter().zip(&whole.measurements) {
            prop_assert!(one.verdict == other.verdict || one.reason == not_judged, "{one:?} {other:?} {changes:?}");
        }
    }
}
