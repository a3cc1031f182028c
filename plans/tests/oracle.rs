//! The judge against an oracle that tries every placement of every event on a small grid.
//!
//! A verdict may never contradict the oracle. Where the judge is exact by design, it must also agree when the
//! oracle says that the answer is open.

use std::sync::Arc;

use document::{Fields, Findings, Node, SourceFile};
use proptest::prelude::*;
use record::Verdict;
use scanrig_plans::expect::{self, Expectation, ReadContext, TraceClaim};
use scanrig_plans::judge::{CaseJudge, Scenario};
use scanrig_plans::lang::PlanNames;
use scanrig_plans::{Anchor, TOML};
use signal::{Cause, Event, SignalId, SignalInfo, Span, Time, Trace, Value, ValueKind, When};

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

pub(crate) fn claim(text: &str) -> (&'static str, Arc<dyn TraceClaim>) {
    let source = SourceFile::new("claim", format!("it = {text}"));
    let mut out = Findings::new(&source, TOML);
    let table = document::toml::parse(&source, TOML).expect("TOML");
    let entry = &table.get("it").and_then(Node::as_table).expect("a table").entries[0];
    let verb = expect::verb(&entry.key).expect("a verb");
    let inner = entry.node.as_table().expect("a table");
    let fields = Fields::check(inner, 0..1, verb.name, verb.keys, &mut out);
    let mut cx = ReadContext { out: &mut out, names: &Anything, place: 0..1 };
    let claim = (verb.read)(&fields, &mut cx);
    (verb.name, claim.unwrap_or_else(|| panic!("{text}: {:?}", out.into_vec())))
}

/// An event before it is placed: signal (0 = the line, 1 = step a, 2 = step b), its interval, its value.
#[derive(Clone, Copy, Debug)]
struct Raw {
    signal: u32,
    a: i64,
    b: i64,
    value: Value,
}

/// Instants are counted from here, so that nothing lies before the first value of the line.
const ORIGIN: i64 = 10;
/// The end of the case: later than every event can be.
const END: i64 = 200;

fn events() -> impl Strategy<Value = Vec<Raw>> {
    let line = prop::collection::vec((0i64..14, 0i64..4, prop::bool::weighted(0.1)), 0..5);
    let marks = (0i64..14, 0i64..4, 0i64..14, 0i64..4, any::<u64>());
    (line, marks, any::<bool>()).prop_map(|(mut line, marks, first)| {
        let (a, wa, b, wb, shuffle) = marks;
        // Both ends of the intervals of one signal run forwards, as channels give them.
        line.sort_by_key(|event| event.0);
        let mut raw = vec![Raw { signal: 0, a: 0, b: 0, value: Value::Bool(first) }];
        let (mut on, mut latest) = (first, 0);
        let mut rest = Vec::new();
        for (start, width, unknown) in line {
            latest = latest.max(ORIGIN + start + width);
            on = !on;
            let value = if unknown { Value::Unknown } else { Value::Bool(on) };
            rest.push(Raw { signal: 0, a: ORIGIN + start, b: latest, value });
        }
        // The marks come at any place of the trace that their instants allow: among equals, either order.
        for (signal, at, width, bit) in [(1, a, wa, shuffle & 1), (2, a.max(b), wb, shuffle >> 1 & 1)] {
            let mark = Raw { signal, a: ORIGIN + at, b: ORIGIN + at + width, value: Value::Int(1) };
            let place = if bit == 0 {
                rest.iter().position(|event| event.a >= mark.a).unwrap_or(rest.len())
            } else {
                rest.iter().position(|event| event.a > mark.a).unwrap_or(rest.len())
            };
            rest.insert(place, mark);
        }
        raw.extend(rest);
        raw
    })
}

fn trace(raw: &[Raw], signals: &[SignalInfo]) -> Trace {
    let mut trace = Trace::new();
    for info in signals {
        trace.define(info.clone()).unwrap();
    }
    for event in raw {
        let at = When { earliest: Time::from_nanos(event.a), latest: Time::from_nanos(event.b) };
        let (signal, value) = (SignalId(event.signal), event.value);
        trace.push(Event { signal, at, value, cause: Cause::Unknown }).unwrap();
    }
    trace
}

fn judged(raw: &[Raw], text: &str) -> Verdict {
    let signals = [
        SignalInfo::exact("q", ValueKind::Bool),
        SignalInfo::exact("step:a", ValueKind::Mark),
        SignalInfo::exact("step:b", ValueKind::Mark),
    ];
    judged_with(raw, text, &signals)
}

fn judged_with(raw: &[Raw], text: &str, signals: &[SignalInfo]) -> Verdict {
    let signals = [signals, &[SignalInfo::exact("step:start", ValueKind::Mark)]].concat();
    let start = Raw { signal: signals.len() as u32 - 1, a: 0, b: 0, value: Value::Int(1) };
    let raw: Vec<Raw> = std::iter::once(start).chain(raw.iter().copied()).collect();
    let trace = trace(&raw, &signals);
    let (verb, claim) = claim(text);
    let expectation = Expectation { name: String::new(), verb, claim, place: None };
    let scenario = Scenario { expectations: vec![expectation], ..Scenario::default() };
    let end = When::exactly(Time::from_nanos(END));
    let mut judge = CaseJudge::new(scenario.clone(), &signals).unwrap();
    let mut lost = false;
    for event in trace.events() {
        judge.feed(&event.unwrap());
        lost |= judge.failed_early();
    }
    let live = judge.finish(end, &trace).unwrap();
    let replayed = CaseJudge::new(scenario, &signals).unwrap().replay(end, &trace).unwrap();
    assert_eq!(live, replayed);
    if lost {
        assert_eq!(live.verdict, Verdict::Fail, "lost early: {text} {raw:?}");
    }
    live.verdict
}

/// An event that is placed: its instant, its place in the trace, its value.
type Placed = (i64, usize, Value);

/// The oracle: every placement in turn, as the line's events and the instants of the two steps with their
/// places. `None` if the verdict of the claim is left open by an unknown value.
fn oracle(raw: &[Raw], holds: impl Fn(&[Placed], (i64, usize), (i64, usize)) -> Option<bool>) -> Verdict {
    let (mut some, mut other) = (false, false);
    let mut times: Vec<i64> = raw.iter().map(|event| event.a).collect();
    loop {
        let line: Vec<Placed> = raw
            .iter()
            .enumerate()
            .filter(|(_, event)| event.signal == 0)
            .map(|(place, event)| (times[place], place, event.value))
            .collect();
        if line.windows(2).all(|pair| pair[0].0 <= pair[1].0) {
            let step = |signal| {
                let place = raw.iter().position(|event| event.signal == signal).unwrap();
                (times[place], place)
            };
            match holds(&line, step(1), step(2)) {
                Some(true) => some = true,
                Some(false) => other = true,
                None => (some, other) = (true, true),
            }
        }
        let Some(next) = (0..raw.len()).find(|at| times[*at] < raw[*at].b) else { break };
        times[next] += 1;
        for at in 0..next {
            times[at] = raw[at].a;
        }
    }
    match (some, other) {
        (true, false) => Verdict::Pass,
        (false, true) => Verdict::Fail,
        (true, true) => Verdict::Inconclusive,
        (false, false) => Verdict::None,
    }
}

fn known(raw: &[Raw]) -> bool {
    raw.iter().all(|event| !matches!(event.value, Value::Unknown))
}

/// Every way to fill unknown values in with one that lasts. There are more, with edges inside, so that the
/// judge may be less sure than all of these together, but never surer.
fn filled(raw: &[Raw]) -> Vec<Vec<Raw>> {
    let mut all = vec![raw.to_vec()];
    while let Some(at) = all[0].iter().position(|event| matches!(event.value, Value::Unknown)) {
        let fill = |on: bool| {
            all.iter().cloned().map(move |mut raw| {
                raw[at].value = Value::Bool(on);
                raw
            })
        };
        all = fill(false).chain(fill(true)).collect();
    }
    all
}

/// Whether a verdict contradicts none of the oracle's.
fn agrees(verdict: Verdict, expected: Verdict) -> bool {
    verdict == expected || verdict == Verdict::Inconclusive
}

/// Segments with their value; the last one lasts.
fn segments(line: &[Placed]) -> Vec<(i64, i64, Value)> {
    let ends = line.iter().skip(1).map(|event| event.0).chain([i64::MAX]);
    line.iter().zip(ends).map(|(event, end)| (event.0, end, event.2)).collect()
}

/// Whether the line is TRUE (`Some`) at some time of the window, or may be (`None`).
fn meets(line: &[Placed], from: i64, until: i64) -> Option<bool> {
    let mut open = false;
    for (start, end, value) in segments(line) {
        if start < until && end > from {
            match value {
                Value::Bool(true) => return Some(true),
                Value::Unknown => open = true,
                _ => {}
            }
        }
    }
    if open { None } else { Some(false) }
}

/// Rising edges with their places.
fn rises(line: &[Placed]) -> Vec<(i64, usize)> {
    let rise = |pair: &&[Placed]| pair[0].2 == Value::Bool(false) && pair[1].2 == Value::Bool(true);
    line.windows(2).filter(rise).map(|pair| (pair[1].0, pair[1].1)).collect()
}

/// A count of the rising edges of the line, in place of it.
fn counted(raw: &[Raw]) -> Vec<Raw> {
    let mut count = 0;
    let number = |event: &Raw| match (event.signal, event.value) {
        (0, Value::Bool(true)) => {
            count += 1;
            Some(Raw { value: Value::Int(count), ..*event })
        }
        (0, Value::Bool(false)) if event.b == 0 => Some(Raw { value: Value::Int(0), ..*event }),
        (0, Value::Bool(false)) => None,
        _ => Some(*event),
    };
    raw.iter().filter_map(number).collect()
}

/// The oracle for two lines that must never be TRUE together.
fn oracle_of_two(raw: &[Raw]) -> Verdict {
    let (mut some, mut other) = (false, false);
    let mut times: Vec<i64> = raw.iter().map(|event| event.a).collect();
    loop {
        let line = |signal| -> Vec<Placed> {
            let own = raw.iter().enumerate().filter(|(_, event)| event.signal == signal);
            own.map(|(place, event)| (times[place], place, event.value)).collect()
        };
        let lines = [line(0), line(1)];
        if lines.iter().all(|line| line.windows(2).all(|pair| pair[0].0 <= pair[1].0)) {
            let on = |line: &[Placed]| -> Vec<(i64, i64)> {
                let on = segments(line).into_iter().filter(|segment| segment.2 == Value::Bool(true));
                on.map(|segment| (segment.0, segment.1)).collect()
            };
            let meet = |a: &(i64, i64)| on(&lines[1]).iter().any(|b| a.0.max(b.0) < a.1.min(b.1).min(END));
            if on(&lines[0]).iter().any(meet) { other = true } else { some = true }
        }
        let Some(next) = (0..raw.len()).find(|at| times[*at] < raw[*at].b) else { break };
        times[next] += 1;
        for at in 0..next {
            times[at] = raw[at].a;
        }
    }
    match (some, other) {
        (true, false) => Verdict::Pass,
        (false, true) => Verdict::Fail,
        _ => Verdict::Inconclusive,
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1500, failure_persistence: None, ..ProptestConfig::default() })]

    /// `never` between two steps, whose order is the plan's.
    #[test]
    fn never_between_steps(raw in events()) {
        let expected = oracle(&raw, |line, a, b| meets(line, a.0, b.0).map(|meets| !meets));
        let text = r#"{ never = { signal = "q", from = "a", until = "b" } }"#;
        let step = |signal| *raw.iter().find(|event| event.signal == signal).unwrap();
        // Placements with the window backwards do not count; the oracle has them, so they are left out here.
        if step(1).b < step(2).a {
            prop_assert_eq!(judged(&raw, text), expected, "{:?}", raw);
        }
    }

    /// `never` in a window whose ends depend on one step.
    #[test]
    fn never_in_a_window_that_moves(raw in events(), offset in -3i64..4, length in 1i64..8) {
        let expected = oracle(&raw, |line, a, _| {
            meets(line, a.0 + offset, a.0 + offset + length).map(|meets| !meets)
        });
        let until = offset + length;
        let text = format!(r#"{{ never = {{ signal = "q", from = "a + {offset} ns", until = "a + {until} ns" }} }}"#);
        prop_assert_eq!(judged(&raw, &text), expected, "{} {:?}", text, raw);
    }

    /// `rises` with limits.
    #[test]
    fn the_first_rise(raw in events(), least in 0i64..6, width in 0i64..6) {
        let most = least + width;
        let holds = |line: &[Placed], a: (i64, usize), _: (i64, usize)| {
            let first = rises(line).into_iter().find(|(at, place)| *at > a.0 || *at == a.0 && *place > a.1);
            Some(first.is_some_and(|(at, _)| (least..=most).contains(&(at - a.0))))
        };
        let text = format!(r#"{{ rises = {{ signal = "q", from = "a", within = "{least} ns .. {most} ns" }} }}"#);
        let verdict = judged(&raw, &text);
        if known(&raw) {
            prop_assert_eq!(verdict, oracle(&raw, holds), "{} {:?}", text, raw);
        }
        for raw in filled(&raw) {
            prop_assert!(agrees(verdict, oracle(&raw, holds)), "{verdict}: {text} {raw:?}");
        }
    }

    /// `edges` in a window whose ends depend on one step, and between two.
    #[test]
    fn counted_edges(raw in events(), moving: bool, length in 1i64..9, wanted in 0u64..4) {
        let holds = |line: &[Placed], a: (i64, usize), b: (i64, usize)| {
            let until = if moving { (a.0 + length, 0) } else { b };
            if a.0 > until.0 {
                return Some(false);
            }
            let inside = |(at, place): &(i64, usize)| {
                (*at > a.0 || *at == a.0 && *place > a.1) && (*at < until.0 || *at == until.0 && *place < until.1)
            };
            Some(rises(line).iter().filter(|edge| inside(edge)).count() as u64 == wanted)
        };
        let until = if moving { format!("a + {length} ns") } else { "b".to_owned() };
        let text = format!(r#"{{ edges = {{ signal = "q", rising = {wanted}, from = "a", until = "{until}" }} }}"#);
        let step = |signal| *raw.iter().find(|event| event.signal == signal).unwrap();
        let ordered = moving || step(1).b < step(2).a;
        let verdict = judged(&raw, &text);
        if known(&raw) && ordered {
            prop_assert_eq!(verdict, oracle(&raw, holds), "{} {:?}", text, raw);
        }
        for raw in filled(&raw).iter().filter(|_| ordered) {
            prop_assert!(agrees(verdict, oracle(raw, holds)), "{verdict}: {text} {raw:?}");
        }
    }

    /// `frames`: the longest gap of a count, never wrongly; exactly where it is clear which frames are in the window.
    #[test]
    fn longest_gap(raw in events(), moving: bool, length in 1i64..9, limit in 1i64..9) {
        let raw = counted(&raw);
        let holds = |line: &[Placed], a: (i64, usize), b: (i64, usize)| {
            let until = if moving { (a.0 + length, 0) } else { b };
            let inside = |(at, place): &(i64, usize)| {
                (*at > a.0 || *at == a.0 && *place > a.1) && (*at < until.0 || *at == until.0 && *place < until.1)
            };
            let more = |pair: &&[Placed]| pair[1].2.as_int() > pair[0].2.as_int();
            let frames = line.windows(2).filter(more).map(|pair| (pair[1].0, pair[1].1)).filter(inside);
            let instants: Vec<i64> = [a.0].into_iter().chain(frames.map(|frame| frame.0)).chain([until.0]).collect();
            Some(instants.windows(2).all(|pair| pair[1] - pair[0] <= limit))
        };
        let until = if moving { format!("a + {length} ns") } else { "b".to_owned() };
        let text = format!(r#"{{ frames = {{ frame = "q", max-gap = "{limit} ns", from = "a", until = "{until}" }} }}"#);
        let step = |signal| *raw.iter().find(|event| event.signal == signal).unwrap();
        let (a, b) = (step(1), step(2));
        if !moving && a.b >= b.a {
            return Ok(());
        }
        let counter = SignalInfo::exact("q", ValueKind::Int);
        let marks = ["step:a", "step:b"].map(|mark| SignalInfo::exact(mark, ValueKind::Mark));
        let signals: Vec<SignalInfo> = [counter].into_iter().chain(marks).collect();
        let verdict = judged_with(&raw, &text, &signals);
        if known(&raw) {
            let expected = oracle(&raw, holds);
            prop_assert!(agrees(verdict, expected), "{verdict}, not {expected}: {text} {raw:?}");
            let ends = [a.a, if moving { a.a + length } else { b.a }];
            let exact = a.a == a.b && (moving || b.a == b.b);
            let clear = raw.iter().filter(|event| event.signal == 0).all(|event| {
                ends.iter().all(|end| event.b < *end || event.a > *end)
            });
            if exact && clear {
                prop_assert_eq!(verdict, expected, "{} {:?}", text, raw);
            }
        }
    }

    /// `pulse`: the first one exactly; all of them never wrongly.
    #[test]
    fn widths_of_pulses(raw in events(), every: bool, least in 0i64..6, width in 0i64..5) {
        let most = least + width;
        let expected = oracle(&raw, |line, a, _| {
            let mut found = Vec::new();
            for (at, pair) in line.windows(2).enumerate() {
                let begins = pair[0].2 == Value::Bool(false) && pair[1].2 == Value::Bool(true);
                let inside = pair[1].0 > a.0 || pair[1].0 == a.0 && pair[1].1 > a.1;
                if begins && inside {
                    found.push(line.get(at + 2).map(|end| end.0 - pair[1].0));
                }
            }
            let good = |width: &Option<i64>| width.is_some_and(|width| (least..=most).contains(&width));
            Some(!found.is_empty() && if every { found.iter().all(good) } else { good(&found[0]) })
        });
        let which = if every { "every" } else { "first" };
        let text = format!(
            r#"{{ pulse = {{ signal = "q", width = "{least} ns .. {most} ns", which = "{which}", from = "a" }} }}"#
        );
        if known(&raw) {
            let verdict = judged(&raw, &text);
            if !every || verdict != Verdict::Inconclusive {
                prop_assert_eq!(verdict, expected, "{} {:?}", text, raw);
            }
        }
    }

    /// `period`: never wrong.
    #[test]
    fn distances_of_edges(raw in events(), least in 1i64..6, width in 0i64..5) {
        let most = least + width;
        let expected = oracle(&raw, |line, a, _| {
            let inside = |(at, place): &(i64, usize)| *at > a.0 || *at == a.0 && *place > a.1;
            let edges: Vec<i64> = rises(line).into_iter().filter(inside).map(|(at, _)| at).collect();
            Some(edges.len() > 1 && edges.windows(2).all(|pair| (least..=most).contains(&(pair[1] - pair[0]))))
        });
        let text = format!(r#"{{ period = {{ signal = "q", is = "{least} ns .. {most} ns", from = "a" }} }}"#);
        if known(&raw) {
            let verdict = judged(&raw, &text);
            if verdict != Verdict::Inconclusive {
                prop_assert_eq!(verdict, expected, "{} {:?}", text, raw);
            }
        }
    }

    /// `never` of two lines at once: never wrong, and exact where all instants are.
    #[test]
    fn two_lines_at_once(
        one in prop::collection::vec((0i64..14, 0i64..4), 0..4),
        two in prop::collection::vec((0i64..14, 0i64..4), 0..4),
        exact: bool,
    ) {
        let line = |signal: u32, changes: &[(i64, i64)]| {
            let mut changes = changes.to_vec();
            changes.sort_by_key(|change| change.0);
            let mut raw = vec![Raw { signal, a: 0, b: 0, value: Value::Bool(false) }];
            let (mut on, mut latest) = (false, 0);
            for (start, width) in changes {
                latest = latest.max(ORIGIN + start + if exact { 0 } else { width });
                on = !on;
                raw.push(Raw { signal, a: ORIGIN + start, b: latest, value: Value::Bool(on) });
            }
            raw
        };
        let (one, two) = (line(0, &one), line(1, &two));
        let mut raw: Vec<Raw> = one.iter().chain(&two).copied().collect();
        // Changes become known at the end of their intervals.
        raw.sort_by_key(|event| event.b);
        let expected = oracle_of_two(&raw);
        let signals = [SignalInfo::exact("q", ValueKind::Bool), SignalInfo::exact("r", ValueKind::Bool)].map(|mut info| {
            info.sampling = signal::Sampling::Edges { resolution: Span::from_nanos(20) };
            info
        });
        let verdict = judged_with(&raw, r#"{ never = { all = ["q", "r"] } }"#, &signals);
        if exact || verdict != Verdict::Inconclusive {
            prop_assert_eq!(verdict, expected, "{:?}", raw);
        }
    }

    /// `value` at a step and at a distance from it.
    #[test]
    fn values_at_instants(raw in events(), offset in -3i64..4) {
        let expected = oracle(&raw, |line, a, _| {
            let before = |event: &&Placed| {
                let at = a.0 + offset;
                event.0 < at || event.0 == at && (offset != 0 || event.1 < a.1)
            };
            match line.iter().rev().find(before)?.2 {
                Value::Bool(on) => Some(on),
                _ => None,
            }
        });
        let text = format!(r#"{{ value = {{ of = "q", is = true, when = "a + {offset} ns" }} }}"#);
        prop_assert_eq!(judged(&raw, &text), expected, "{} {:?}", text, raw);
    }
}

/// Not a measure, a check by hand that following a long trace stays cheap: `cargo test --release -- --ignored`.
#[test]
#[ignore = "takes seconds; run by hand with --release"]
fn following_ten_million_events() {
    let mut signals: Vec<SignalInfo> =
        (0..30).map(|at| SignalInfo::exact(format!("q{at}"), ValueKind::Bool)).collect();
    signals.push(SignalInfo::exact("step:start", ValueKind::Mark));
    let expectations = (0..30).map(|at| {
        let texts = [
            format!(r#"{{ never = {{ signal = "q{at}", pulses-longer-than = "1 s" }} }}"#),
            format!(r#"{{ edges = {{ signal = "q{at}", rising = "1 .." }} }}"#),
            format!(r#"{{ rises = {{ signal = "q{at}" }} }}"#),
        ];
        let (verb, claim) = claim(&texts[at % 3]);
        Expectation { name: String::new(), verb, claim, place: None }
    });
    let scenario = Scenario { expectations: expectations.collect(), ..Scenario::default() };
    let event = |n: u32| Event {
        signal: SignalId(n % 30),
        at: When::exactly(Time::from_nanos(i64::from(n) * 100)),
        value: Value::Bool(n / 30 % 2 == 1),
        cause: Cause::Board,
    };
    let start = Event { signal: SignalId(30), value: Value::Int(1), ..event(0) };
    let mut judge = CaseJudge::new(scenario, &signals).unwrap();
    let begun = std::time::Instant::now();
    judge.feed(&start);
    (0..10_000_000).for_each(|n| judge.feed(&event(n)));
    let fed = begun.elapsed();
    let events = std::iter::once(start).chain((0..10_000_000).map(event)).map(Ok::<_, ()>);
    let end = When::exactly(Time::ZERO + Span::from_secs(2));
    let outcome = judge.finish_over(end, events, &|_| None).unwrap();
    println!("fed in {fed:?}, judged in {:?}: {}", begun.elapsed() - fed, outcome.verdict);
    assert_eq!(outcome.claims.len(), 30);
}
