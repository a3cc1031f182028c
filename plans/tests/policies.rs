//! Recording policies: a trace that leaves changes out may leave a verdict open, and never gives another one than
//! the trace of all changes.

use std::sync::Arc;

use document::{Fields, Findings, Node, SourceFile};
use proptest::prelude::*;
use record::{GuardBand, Verdict};
use scanrig_plans::expect::{self, Expectation, ReadContext, TraceClaim};
use scanrig_plans::judge::{CaseJudge, Scenario};
use scanrig_plans::lang::PlanNames;
use scanrig_plans::{Anchor, TOML, measure};
use signal::{Cause, Event, Policy, SignalId, SignalInfo, Span, Time, Trace, Value, ValueKind, When};

/// Names without a plan around them: everything is known.
struct Anything;

impl PlanNames for Anything {
    fn anchor(&self, node: &Node, _out: &mut Findings) -> Option<Anchor> {
        Anchor::parse(node.as_text()?).ok()
    }

    fn signal(&self, node: &Node, _out: &mut Findings) -> Option<String> {
        node.as_text().map(str::to_owned)
    }

    fn at_value(&self, node: &Node, _out: &mut Findings) -> Option<(String, Option<Anchor>)> {
        Some((node.as_text()?.to_owned(), None))
    }
}

fn claim(inner: &Node, name: &str, out: &mut Findings) -> Option<(&'static str, Arc<dyn TraceClaim>)> {
    let verb = expect::verb(name)?;
    let fields = Fields::check(inner.as_table()?, 0..1, verb.name, verb.keys, out);
    Some((verb.name, (verb.read)(&fields, &mut ReadContext { out, names: &Anything, place: 0..1 })?))
}

/// The scenario of one claim or measurement.
fn scenario(text: &str) -> Scenario {
    let source = SourceFile::new("claim", format!("it = {text}"));
    let mut out = Findings::new(&source, TOML);
    let root = document::toml::parse(&source, TOML).expect("TOML");
    let table = root.get("it").and_then(Node::as_table).expect("a table");
    let mut scenario = Scenario::default();
    let first = &table.entries[0];
    match claim(&first.node, &first.key, &mut out) {
        Some((verb, claim)) => {
            scenario.expectations.push(Expectation { name: String::new(), verb, claim, place: None });
        }
        None => {
            let fields = Fields::check(table, 0..1, "measurement", measure::KEYS, &mut out);
            let mut cx = ReadContext { out: &mut out, names: &Anything, place: 0..1 };
            scenario.measurements.extend(measure::read(&fields, GuardBand::default(), &mut cx));
        }
    }
    let found = out.into_vec();
    assert!(found.is_empty(), "{text}: {found:?}");
    scenario
}

const CLAIMS: &[&str] = &[
    r#"{ value = { of = "n", is = 1, when = "a" } }"#,
    r#"{ value = { of = "n", min = 0, max = 2, when = "a + 3 ns" } }"#,
    r#"{ value = { of = "n", one-of = [0, 3], when = "end" } }"#,
    r#"{ value = { of = "n", near = 1, tolerance = 2, when = "b" } }"#,
    r#"{ equal = { left = "n", right = "m", when = "b" } }"#,
    r#"{ equal = { left = "n", right = "m", tolerance = 2, when = "a" } }"#,
    r#"{ stays = { signal = "n", min = 0, max = 3, from = "a", until = "b" } }"#,
    r#"{ stays = { signal = "n", is = 1, from = "a", until = "a + 3 ns" } }"#,
    PROMISES[0].0,
    PROMISES[1].0,
    PROMISES[2].0,
    PROMISES[3].0,
    PROMISES[4].0,
    r#"{ never = { signal = "n", is = 2, from = "a" } }"#,
    r#"{ never = { all = ["q", "r"], from = "a" } }"#,
    r#"{ never = { all = ["q", "r"], pulses-longer-than = "3 ns" } }"#,
    r#"{ rises = { signal = "n", from = "a", within = "4 ns" } }"#,
    r#"{ falls = { signal = "n", from = "a", within = "2 ns .. 6 ns" } }"#,
    r#"{ changes = { signal = "n", from = "a", within = "5 ns" } }"#,
    r#"{ rises = { signal = "q", from = "a", within = "5 ns" } }"#,
    r#"{ becomes = { signal = "n", min = 2, from = "a", within = "2 ns .. 6 ns" } }"#,
    r#"{ becomes = { signal = "n", is = 1, from = "a", within = "6 ns" } }"#,
    r#"{ edges = { signal = "q", rising = 1, from = "a", until = "b" } }"#,
    r#"{ edges = { signal = "q", rising = "1 .. 3", falling = "1 .." } }"#,
    r#"{ edges = { signal = "n", rising = "2 .." } }"#,
    r#"{ pulse = { signal = "q", width = "2 ns .. 6 ns" } }"#,
    r#"{ pulse = { signal = "q", width = ".. 6 ns", which = "every", from = "a" } }"#,
    r#"{ pulse = { signal = "q", level = "low", width = "3 ns ..", which = "every" } }"#,
    r#"{ period = { signal = "q", edge = "changes", is = "2 ns .. 9 ns" } }"#,
    r#"{ order = { edges = ["q rises", "r rises"], from = "a" } }"#,
    r#"{ order = { edges = ["n rises", "q falls"] } }"#,
    r#"{ name = "value", value-of = "n", when = "a", min = 0, max = 2 }"#,
    r#"{ name = "delay", from = "a", to = { signal = "q", edge = "rises" }, max = "5 ns" }"#,
    r#"{ name = "growth", from = "a", to = { signal = "n", edge = "changes" }, min = "2 ns" }"#,
];

const END: i64 = 60;

/// Place of the signal, time since the event before, value.
type Step = (usize, i64, i64);

const SIGNALS: [&str; 7] = ["n", "m", "q", "r", "step:a", "step:b", "step:start"];

fn infos(kind: ValueKind, policies: [Policy; 2]) -> Vec<SignalInfo> {
    let info = |(place, name): (usize, &&str)| {
        let (kind, policy) = match place {
            0 | 1 => (kind, policies[0]),
            2 | 3 => (ValueKind::Bool, policies[1]),
            _ => (ValueKind::Mark, Policy::Changes),
        };
        SignalInfo { policy, ..SignalInfo::exact(*name, kind) }
    };
    SIGNALS.iter().enumerate().map(info).collect()
}

fn verdict(scenario: &Scenario, infos: &[SignalInfo], steps: &[Step]) -> Verdict {
    let mut trace = Trace::new();
    for info in infos {
        trace.define(info.clone()).unwrap();
    }
    let mut now = 0;
    let first = (0..SIGNALS.len()).filter(|place| ![4, 5].contains(place)).map(|place| (place, 0, 0));
    for (place, step, number) in first.chain(steps.iter().copied()) {
        now += step;
        let value = match infos[place].kind {
            ValueKind::Bool => Value::Bool(number > 0),
            ValueKind::Real => Value::Real(number as f64),
            _ => Value::Int(number),
        };
        let at = When::exactly(Time::from_nanos(now));
        while trace.settle(at.earliest).unwrap().is_some() {}
        trace.push(Event { signal: SignalId(place as u32), at, value, cause: Cause::Unknown }).unwrap();
    }
    while trace.settle(Time::from_nanos(END)).unwrap().is_some() {}
    let end = When::exactly(Time::from_nanos(END));
    let mut judge = CaseJudge::new(scenario.clone(), infos).unwrap();
    let mut lost = false;
    for event in trace.events() {
        judge.feed(&event.unwrap());
        lost |= judge.failed_early();
    }
    let outcome = judge.finish(end, &trace).unwrap();
    assert!(!lost || outcome.verdict == Verdict::Fail, "lost early, then {:?}", outcome.verdict);
    outcome.verdict
}

/// A claim that states of the signal `n` that only pulses longer than so many nanoseconds matter, and to which of its levels a value
/// belongs.
type Promise = (&'static str, i64, fn(i64) -> i64);

const PROMISES: [Promise; 5] = [
    (r#"{ stays = { signal = "n", max = 2, pulses-longer-than = "4 ns" } }"#, 4, |value| {
        i64::from(value <= 2)
    }),
    (r#"{ never = { signal = "n", is = 2, from = "a", pulses-longer-than = "2 ns" } }"#, 2, |value| {
        i64::from(value == 2)
    }),
    // Where a figure of the values is asked, or a change, each value has to last.
    (
        r#"{ name = "most", value-of = "n", take = "max", from = "a", until = "b", max = 2, pulses-longer-than = "4 ns" }"#,
        4,
        |value| value,
    ),
    (
        r#"{ name = "mean", value-of = "n", take = "mean", from = "a", until = "b", max = 2, pulses-longer-than = "4 ns" }"#,
        4,
        |value| value,
    ),
    (
        r#"{ changes = { signal = "n", from = "a", within = "3 ns .. 20 ns", pulses-longer-than = "3 ns" } }"#,
        3,
        |value| value,
    ),
];

/// Whether the signal `n` has no pulses so short that a claim says that there are none, where it is recorded at most every so
/// many nanoseconds.
fn keeps_promise(text: &str, every: i64, steps: &[Step]) -> bool {
    let promise = PROMISES.iter().find(|(claim, longest, _)| *claim == text && every <= *longest);
    let Some((_, longest, level)) = promise else { return true };
    let (mut now, mut since, mut last) = (0, i64::MIN, level(0));
    for (place, step, value) in steps {
        now += step;
        if *place == 0 && level(*value) != last {
            if now.saturating_sub(since) <= *longest {
                return false;
            }
            (since, last) = (now, level(*value));
        }
    }
    true
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]
    #[test]
    fn what_is_left_out_never_turns_a_verdict(
        steps in proptest::collection::vec((0usize..6, 0i64..5, -1i64..5), 0..14),
        deadband in prop::option::of(prop_oneof![Just(0.5), Just(1.0), Just(2.0)]),
        every in 1i64..9,
        real in any::<bool>(),
    ) {
        // Both steps come, in any place.
        let mut came = [true, true, true, true, false, false];
        let mut once = |(place, ..): &Step| *place < 4 || !std::mem::replace(&mut came[*place], true);
        let mut steps: Vec<Step> = steps.into_iter().filter(&mut once).collect();
        steps.extend([(4, 1, 1), (5, 1, 1)].into_iter().filter(&mut once));
        let kind = if real { ValueKind::Real } else { ValueKind::Int };
        let often = deadband.map_or(every, |_| i64::MAX);
        let every = Policy::AtMostEvery(Span::from_nanos(every));
        let whole = infos(kind, [Policy::Changes; 2]);
        let partly = infos(kind, [deadband.map_or(every, Policy::Deadband), every]);
        for text in CLAIMS.iter().filter(|text| keeps_promise(text, often, &steps)) {
            let scenario = scenario(text);
            let (all, some) = (verdict(&scenario, &whole, &steps), verdict(&scenario, &partly, &steps));
            prop_assert!(some == all || some == Verdict::Inconclusive, "{text}: {all:?}, then {some:?}");
        }
    }
}

/// A greatest value with the key is decided: 4 stands in the trace 2 ns after it came, and was not missed.
#[test]
fn a_figure_of_values_is_decided_where_no_value_was_too_short_to_be_recorded() {
    let infos = infos(ValueKind::Int, [Policy::AtMostEvery(Span::from_nanos(4)), Policy::Changes]);
    let steps = [(4, 5, 1), (0, 5, 3), (0, 2, 4), (0, 20, 1), (5, 3, 1)];
    let of = |take: &str, limits: &str, key: &str| {
        let text = format!(
            r#"{{ name = "n", value-of = "n", take = "{take}", from = "a", until = "b", {limits}{key} }}"#
        );
        verdict(&scenario(&text), &infos, &steps)
    };
    let key = |nanos: i64| format!(", pulses-longer-than = \"{nanos} ns\"");
    assert_eq!(of("max", "max = 4", &key(4)), Verdict::Pass);
    assert_eq!(of("max", "max = 3", &key(5)), Verdict::Fail);
    assert_eq!(of("min", "min = 0", &key(4)), Verdict::Pass);
    assert_eq!(of("span", "max = 4", &key(4)), Verdict::Pass);
    // A value that is shorter than the distance of two records may be missed.
    assert_eq!(of("max", "max = 4", &key(3)), Verdict::Inconclusive);
    assert_eq!(of("max", "max = 4", ""), Verdict::Inconclusive);
}
