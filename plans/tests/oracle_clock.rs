//! A clock that is off, against the judgement of what truly was: no verdict may come out that a clock which is right contradicts.

use crate::oracle_values::scenario;
use proptest::prelude::*;
use record::Verdict;
use scanrig_plans::Anchor;
use scanrig_plans::judge::{CaseJudge, Scenario, StepFacts};
use scanrig_plans::lang::AnchorBase;
use scanrig_plans::steps::{StepCondition, StepWait};
use signal::{Cause, ClockError, Event, SignalId, SignalInfo, Span, Time, Trace, Value, ValueKind, When};

/// Steps of the true time, nanoseconds; the clock is off by whole thousandths, so that what it shows is whole, too.
const STEP: i64 = 1_000;
/// What the clock may be off: 1 %.
const MOST: i64 = 10;
const END: i64 = 400;
/// The end of a case that goes on for long enough that all of a window about [`END`] is seen.
const LATE_END: i64 = 600;

/// Instants of the two steps, and of the changes of the line, in true steps.
#[derive(Clone, Debug)]
struct Truth {
    marks: [i64; 2],
    line: Vec<i64>,
}

fn truths() -> impl Strategy<Value = Truth> {
    truths_until(300)
}

/// The same with changes of the line up to here.
fn truths_until(last: i64) -> impl Strategy<Value = Truth> {
    let line = proptest::collection::btree_set(1..last, 0..9);
    (0..150i64, 0..150i64, line)
        .prop_map(|(one, more, line)| Truth { marks: [one, one + more], line: line.into_iter().collect() })
}

fn claims() -> impl Strategy<Value = String> {
    let span = || (0..160i64).prop_map(|steps| format!("{steps} us"));
    let pair = || (0..160i64, 0..60i64).prop_map(|(from, more)| format!("{from} us .. {} us", from + more));
    prop_oneof![
        pair().prop_map(|within| format!("{{ rises = {{ signal = \"q\", from = \"a\", within = \"{within}\" }} }}")),
        pair().prop_map(|within| format!("{{ falls = {{ signal = \"q\", from = \"b\", within = \"{within}\" }} }}")),
        pair().prop_map(|width| format!("{{ pulse = {{ signal = \"q\", from = \"a\", which = \"every\", width = \"{width}\" }} }}")),
        pair().prop_map(|width| format!("{{ pulse = {{ signal = \"q\", level = \"low\", width = \"{width}\" }} }}")),
        pair().prop_map(|is| format!("{{ period = {{ signal = \"q\", is = \"{is}\" }} }}")),
        pair().prop_map(|within| format!("{{ happens = {{ step = \"b\", from = \"a\", within = \"{within}\" }} }}")),
        (span(), span()).prop_map(|(from, until)| format!(
            "{{ never = {{ signal = \"q\", from = \"a + {from}\", until = \"b + {until}\" }} }}"
        )),
        (span(), span()).prop_map(|(from, longer)| format!(
            "{{ never = {{ signal = \"q\", from = \"a + {from}\", pulses-longer-than = \"{longer}\" }} }}"
        )),
        (span(), span()).prop_map(|(from, longer)| format!(
            "{{ edges = {{ signal = \"q\", rising = 1, from = \"a + {from}\", pulses-longer-than = \"{longer}\" }} }}"
        )),
        (1..50i64, 0..20i64).prop_map(|(least, more)| format!(
            "{{ frequency = {{ signal = \"q\", is = \"{least} .. {} kHz\" }} }}",
            least + more
        )),
        (1..100i64, 0..20i64).prop_map(|(least, more)| format!(
            "{{ duty = {{ signal = \"q\", is = \"{least} .. {} %\" }} }}",
            least + more
        )),
        span().prop_map(|most| format!("{{ jitter = {{ signal = \"q\", max = \"{most}\" }} }}")),
        (span(), 1..80i64).prop_map(|(most, grid)| format!(
            "{{ jitter = {{ signal = \"q\", max = \"{most}\", grid = \"{grid} us\" }} }}"
        )),
        span().prop_map(|lag| format!("{{ follows = {{ signal = \"q\", leader = \"p\", within = \"{lag}\" }} }}")),
        Just("{ order = { edges = [\"q rises\", \"q falls\", \"q rises\"] } }".to_owned()),
    ]
}

/// A claim whose window ends at this instant.
fn claim_until(which: usize, until: &str, within: i64) -> String {
    match which {
        0 => format!("{{ never = {{ signal = \"q\", from = \"a\", until = \"{until}\" }} }}"),
        1 => format!(
            "{{ stays = {{ signal = \"q\", is = true, from = \"b + 20 us\", until = \"{until}\" }} }}"
        ),
        2 => format!("{{ edges = {{ signal = \"q\", rising = 1, from = \"b\", until = \"{until}\" }} }}"),
        3 => format!(
            "{{ edges = {{ signal = \"q\", falling = \"2 ..\", from = \"a\", until = \"{until}\" }} }}"
        ),
        4 => format!("{{ value = {{ of = \"q\", is = false, when = \"{until}\" }} }}"),
        5 => format!("{{ rises = {{ signal = \"q\", from = \"a\", within = \"{within} us\" }} }}"),
        6 => format!(
            "{{ never = {{ signal = \"q\", from = \"a\", until = \"{until}\", pulses-longer-than = \"5 us\" }} }}"
        ),
        7 => format!(
            "{{ period = {{ signal = \"q\", is = \"60 us ..\", from = \"a\", until = \"{until}\" }} }}"
        ),
        _ => format!(
            "{{ name = \"m\", value-of = \"q\", take = \"max\", from = \"b\", until = \"{until}\", max = 0 }}"
        ),
    }
}

/// The verdict on what a clock shows that is fast by so many thousandths.
fn judged(truth: &Truth, text: &str, off: i64, error: ClockError) -> Verdict {
    judged_until(END, truth, text, off, error)
}

/// The same of a case with this end.
fn judged_until(end: i64, truth: &Truth, text: &str, off: i64, error: ClockError) -> Verdict {
    let trace = stamped(end, truth, off, None);
    let words = format!("{text} {truth:?}");
    verdict(scenario(text), &trace, stamp(end, off), error, &words)
}

/// What a clock shows at a true instant that is fast by so many thousandths, nanoseconds.
fn stamp(steps: i64, off: i64) -> i64 {
    steps * (STEP + off)
}

/// The trace of a case with this end. Where the clock shows `awaited` nanoseconds, a step came.
fn stamped(end: i64, truth: &Truth, off: i64, awaited: Option<i64>) -> Trace {
    let signals = [
        SignalInfo::exact("q", ValueKind::Bool),
        SignalInfo::exact("p", ValueKind::Bool),
        SignalInfo::exact("step:a", ValueKind::Mark),
        SignalInfo::exact("step:b", ValueKind::Mark),
        SignalInfo::exact("step:start", ValueKind::Mark),
        SignalInfo::exact("step:end", ValueKind::Mark),
        SignalInfo::exact("step:w", ValueKind::Mark),
    ];
    let mut events = vec![(0, 4, Value::Int(1)), (0, 0, Value::Bool(false)), (0, 1, Value::Bool(false))];
    events.extend(truth.marks.iter().zip([2, 3]).map(|(at, signal)| (*at, signal, Value::Int(1))));
    events.extend(truth.line.iter().enumerate().map(|(n, at)| (*at, 0, Value::Bool(n % 2 == 0))));
    events.extend(truth.marks.iter().enumerate().map(|(n, at)| (*at, 1, Value::Bool(n % 2 == 0))));
    events.retain(|event| event.0 <= end);
    events.push((end, 5, Value::Int(1)));
    let mut events: Vec<_> =
        events.into_iter().map(|(at, signal, value)| (stamp(at, off), signal, value)).collect();
    events.extend(awaited.map(|at| (at, 6, Value::Int(1))));
    events.sort_by_key(|event| (event.0, event.1 == 5));
    let mut trace = Trace::new();
    for info in &signals {
        trace.define(info.clone()).unwrap();
    }
    for (at, signal, value) in events {
        let at = When::exactly(Time::from_nanos(at));
        trace.push(Event { signal: SignalId(signal), at, value, cause: Cause::Unknown }).unwrap();
    }
    trace
}

/// The verdict on a trace.
fn verdict(scenario: Scenario, trace: &Trace, end: i64, error: ClockError, words: &str) -> Verdict {
    let mut judge = CaseJudge::new(scenario, trace.signals()).unwrap().by_clock(error);
    let mut lost = false;
    for event in trace.events() {
        judge.feed(&event.unwrap());
        lost |= judge.failed_early();
    }
    let verdict = judge.finish(When::exactly(Time::from_nanos(end)), trace).unwrap().verdict;
    assert!(!lost || verdict == Verdict::Fail, "lost early: {words}");
    verdict
}

/// The verdict on a step that waits for a change of the line for `within`, from so many steps after `a` on, as a rig by such a
/// clock runs it; `None` where the wait goes on at the end of the case.
fn waited(
    end: i64,
    truth: &Truth,
    (from, within): (i64, i64),
    rises: Option<bool>,
    off: i64,
    error: ClockError,
) -> Option<Verdict> {
    let began = stamp(truth.marks[0], off) + from * STEP;
    let limit = began + within * STEP;
    if limit > stamp(end, off) {
        return None;
    }
    let counts = |n: usize| rises.is_none_or(|rises| rises == n.is_multiple_of(2));
    let changes = truth.line.iter().enumerate().filter(|(n, _)| counts(*n)).map(|(_, at)| stamp(*at, off));
    let came = changes.filter(|at| (began..=limit).contains(at)).min();
    let trace = stamped(end, truth, off, came);
    let awaits = match rises {
        Some(true) => StepCondition::Rises,
        Some(false) => StepCondition::Falls,
        None => StepCondition::Changes,
    };
    let from = Anchor { base: AnchorBase::Step("a".into()), offset: Span::from_nanos(from * STEP) };
    let within = Span::from_nanos(within * STEP);
    let wait = StepWait { signal: "q".into(), awaits, from, within };
    let step = StepFacts { id: "w".into(), awaited: Some(wait), ..StepFacts::default() };
    let scenario = Scenario { steps: vec![step], ..Scenario::default() };
    Some(verdict(scenario, &trace, stamp(end, off), error, &format!("{truth:?}")))
}

/// What a claim with one limit of time comes to is decided exactly where every clock decides the same: of a true time `t` such a
/// clock shows from `t (1 - e)` to `t (1 + e)`.
#[test]
fn a_limit_is_met_by_every_clock_or_open_or_met_by_none() {
    // The case starts at 0, and the line rises when the clock shows this, of a limit of 100 us at 1 %.
    let judged = |claim: &str, shown: i64, error: u64| {
        let mut trace = Trace::new();
        for info in [
            SignalInfo::exact("q", ValueKind::Bool),
            SignalInfo::exact("step:start", ValueKind::Mark),
            SignalInfo::exact("step:end", ValueKind::Mark),
        ] {
            trace.define(info).unwrap();
        }
        let events = [
            (0, 0, Value::Bool(false)),
            (0, 1, Value::Int(1)),
            (shown, 0, Value::Bool(true)),
            (2 * shown, 0, Value::Bool(false)),
            (3 * shown, 0, Value::Bool(true)),
            (1_000_000, 2, Value::Int(1)),
        ];
        for (at, signal, value) in events {
            let at = When::exactly(Time::from_nanos(at));
            trace.push(Event { signal: SignalId(signal), at, value, cause: Cause::Unknown }).unwrap();
        }
        let scenario = scenario(&format!("{{ {claim} }}"));
        verdict(scenario, &trace, 1_000_000, ClockError::from_parts(error).unwrap(), claim)
    };
    let at_10_percent = |claim: &str, shown: i64| judged(claim, shown, 100_000_000_000);
    use Verdict::{Fail, Inconclusive, Pass};
    for claim in [
        r#"rises = { signal = "q", within = "100 us" }"#,
        r#"stays = { signal = "q", is = false, until = "start + 100 us" }"#,
    ] {
        let (early, late) = if claim.contains("rises") { (Pass, Fail) } else { (Fail, Pass) };
        assert_eq!(at_10_percent(claim, 90_000 - i64::from(early == Fail)), early, "{claim}");
        assert_eq!(at_10_percent(claim, 90_001), Inconclusive, "{claim}");
        assert_eq!(at_10_percent(claim, 109_999), Inconclusive, "{claim}");
        assert_eq!(at_10_percent(claim, 110_001), late, "{claim}");
    }
    let least = r#"pulse = { signal = "q", width = "100 us .." }"#;
    let found = [89_999, 90_001, 109_999, 110_000].map(|shown| at_10_percent(least, shown));
    assert_eq!(found, [Fail, Inconclusive, Inconclusive, Pass]);
    // One period is two widths, and 10 kHz at most a period of 100 us at least.
    let most = r#"frequency = { signal = "q", max = "10 kHz" }"#;
    let found = [44_999, 45_001, 54_999, 55_001].map(|shown| at_10_percent(most, shown));
    assert_eq!(found, [Fail, Inconclusive, Inconclusive, Pass]);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(6_000))]

    #[test]
    fn no_verdict_is_another_by_a_clock_that_is_right(truth in truths(), text in claims(), off in -MOST..=MOST) {
        let error = ClockError::from_parts(10_000_000_000).unwrap();
        let (right, found) = (judged(&truth, &text, 0, ClockError::NONE), judged(&truth, &text, off, error));
        // A window that is empty by a clock which is right has no verdict.
        if matches!(found, Verdict::Pass | Verdict::Fail) && right != Verdict::Inconclusive {
            prop_assert_eq!(found, right, "{} {:?} {}", text, truth, off);
        }
        // Without a limit of time nothing is open that was not.
        if text.contains("order") || text.contains("duty") {
            prop_assert_eq!(found, right, "{} {:?} {}", text, truth, off);
        }
    }

    #[test]
    fn what_may_lie_after_the_end_of_the_case_is_not_taken_as_seen(
        truth in truths_until(500),
        which in 0..9usize,
        beyond in -15..=15i64,
        off in -MOST..=MOST,
    ) {
        let error = ClockError::from_parts(10_000_000_000).unwrap();
        let within = END - truth.marks[0] + beyond;
        let text = claim_until(which, &format!("a + {within} us"), within);
        let right = judged_until(LATE_END, &truth, &text, 0, ClockError::NONE);
        let found = judged(&truth, &text, off, error);
        if matches!(found, Verdict::Pass | Verdict::Fail) && right != Verdict::Inconclusive {
            prop_assert_eq!(found, right, "{} {:?} {}", text, truth, off);
        }
    }

    #[test]
    fn a_step_that_waits_came_in_time_by_every_clock_or_is_open(
        truth in truths_until(500),
        wait in (prop_oneof![Just(0), 0..200i64], 0..250i64),
        rises in prop_oneof![Just(Some(true)), Just(Some(false)), Just(None)],
        off in -MOST..=MOST,
    ) {
        let error = ClockError::from_parts(10_000_000_000).unwrap();
        let right = waited(LATE_END, &truth, wait, rises, 0, ClockError::NONE).unwrap();
        if let Some(found @ (Verdict::Pass | Verdict::Fail)) = waited(END, &truth, wait, rises, off, error) {
            prop_assert_eq!(found, right, "{:?} {:?} {:?} {}", truth, wait, rises, off);
        }
        // By a clock that is right nothing is open.
        prop_assert!(right != Verdict::Inconclusive);
    }
}
