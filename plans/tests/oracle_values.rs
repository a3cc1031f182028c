//! The judge of cycles, values and pairs of signals against an oracle that tries every placement of every event.
//!
//! A verdict may never contradict the oracle, and where all instants are exact it must be the oracle's. A measured
//! interval has to hold what is measured in every placement.

use document::{Fields, Findings, Node, SourceFile};
use proptest::prelude::*;
use record::{GuardBand, Verdict};
use scanrig_plans::expect::{self, Expectation, ReadContext};
use scanrig_plans::judge::{CaseJudge, JudgedCase, Scenario};
use scanrig_plans::lang::PlanNames;
use scanrig_plans::{Anchor, TOML, measure};
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

/// The claim, or the measurement, that a text writes.
pub(crate) fn scenario(text: &str) -> Scenario {
    let source = SourceFile::new("claim", format!("it = {text}"));
    let mut out = Findings::new(&source, TOML);
    let table = document::toml::parse(&source, TOML).expect("TOML");
    let entry = table.get("it").and_then(Node::as_table).expect("a table");
    let mut scenario = Scenario::default();
    match expect::verb(&entry.entries[0].key) {
        Some(verb) => {
            let inner = entry.entries[0].node.as_table().expect("a table");
            let fields = Fields::check(inner, 0..1, verb.name, verb.keys, &mut out);
            let mut cx = ReadContext { out: &mut out, names: &Anything, place: 0..1 };
            let claim = (verb.read)(&fields, &mut cx);
            let claim = claim.unwrap_or_else(|| panic!("{text}: {:?}", out.into_vec()));
            let expectation = Expectation { name: String::new(), verb: verb.name, claim, place: None };
            scenario.expectations.push(expectation);
        }
        None => {
            let fields = Fields::check(entry, 0..1, "measurement", measure::KEYS, &mut out);
            let mut cx = ReadContext { out: &mut out, names: &Anything, place: 0..1 };
            let taken = measure::read(&fields, GuardBand::default(), &mut cx);
            scenario.measurements.push(taken.unwrap_or_else(|| panic!("{text}: {:?}", out.into_vec())));
        }
    }
    scenario
}

/// An event before it is placed: signal (0 and 1 = the lines, 2 = step a), its interval, its value.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Raw {
    pub(crate) signal: u32,
    pub(crate) a: i64,
    pub(crate) b: i64,
    pub(crate) value: i64,
}

/// Instants are counted from here, so that nothing lies before the first values.
pub(crate) const ORIGIN: i64 = 10;
/// The end of the case: later than every event can be.
pub(crate) const END: i64 = 60;

/// A line that changes a few times: its first value and distances, widths of intervals and values.
pub(crate) type Line = (i64, Vec<(i64, i64, i64)>);

pub(crate) fn line(values: i64, most: usize) -> impl Strategy<Value = Line> {
    (0..values, prop::collection::vec((0i64..12, 0i64..4, 1..values), 0..most))
}

/// Events in the order of the trace. A value is the one before and the drawn one, so that each is a change.
pub(crate) fn raw(lines: &[(Line, i64)], step: (i64, i64), exact: bool) -> Vec<Raw> {
    let mut all = Vec::new();
    let width = |width: i64| if exact { 0 } else { width };
    for (signal, ((first, changes), values)) in (0u32..).zip(lines) {
        let mut changes = changes.clone();
        changes.sort_by_key(|change| change.0);
        all.push(Raw { signal, a: 0, b: 0, value: *first });
        let (mut value, mut latest, mut last) = (*first, 0, ORIGIN);
        for (start, wide, more) in changes {
            // Changes of one signal at one instant are hard to read in a failure and no other case.
            let a = (ORIGIN + start).max(last + 1);
            last = a;
            latest = (a + width(wide)).max(latest + 1);
            value = (value + more) % values;
            all.push(Raw { signal, a, b: latest, value });
        }
    }
    all.push(Raw { signal: 2, a: ORIGIN + step.0, b: ORIGIN + step.0 + width(step.1), value: 1 });
    // Changes become known at the end of their intervals.
    all.sort_by_key(|event| event.b);
    all
}

pub(crate) fn judged(raw: &[Raw], text: &str, kind: ValueKind) -> JudgedCase {
    judged_until(raw, text, kind, END)
}

/// The same for a case that ends at another instant.
pub(crate) fn judged_until(raw: &[Raw], text: &str, kind: ValueKind, end: i64) -> JudgedCase {
    let lines = ["q", "r"].map(|name| {
        let mut info = SignalInfo::exact(name, kind);
        info.sampling = signal::Sampling::Edges { resolution: Span::from_nanos(20) };
        info
    });
    let [q, r] = lines;
    let marks = ["step:a", "step:start"].map(|name| SignalInfo::exact(name, ValueKind::Mark));
    let [a, start] = marks;
    let signals = [q, r, a, start];
    let mut trace = Trace::new();
    for info in &signals {
        trace.define(info.clone()).unwrap();
    }
    let begun = Raw { signal: 3, a: 0, b: 0, value: 1 };
    for event in std::iter::once(&begun).chain(raw) {
        let at = When { earliest: Time::from_nanos(event.a), latest: Time::from_nanos(event.b) };
        let value = match (event.signal, kind) {
            (0 | 1, ValueKind::Bool) => Value::Bool(event.value != 0),
            _ => Value::Int(event.value),
        };
        trace.push(Event { signal: SignalId(event.signal), at, value, cause: Cause::Unknown }).unwrap();
    }
    let scenario = scenario(text);
    let end = When::exactly(Time::from_nanos(end));
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
    live
}

/// A line that is placed: changes with their instants.
pub(crate) type Placed = Vec<(i64, i64)>;

/// Every placement in turn: both lines and the instant of the step.
pub(crate) fn placements(raw: &[Raw], mut each: impl FnMut(&Placed, &Placed, i64)) {
    let mut times: Vec<i64> = raw.iter().map(|event| event.a).collect();
    loop {
        let line = |signal| -> Placed {
            let own = raw.iter().zip(&times).filter(|(event, _)| event.signal == signal);
            own.map(|(event, at)| (*at, event.value)).collect()
        };
        let lines = [line(0), line(1)];
        if lines.iter().all(|line| line.windows(2).all(|pair| pair[0].0 <= pair[1].0)) {
            let step = raw.iter().position(|event| event.signal == 2).unwrap();
            each(&lines[0], &lines[1], times[step]);
        }
        let Some(next) = (0..raw.len()).find(|at| times[*at] < raw[*at].b) else { break };
        times[next] += 1;
        for at in 0..next {
            times[at] = raw[at].a;
        }
    }
}

pub(crate) fn oracle(raw: &[Raw], holds: impl Fn(&Placed, &Placed, i64) -> bool) -> Verdict {
    let (mut some, mut other) = (false, false);
    placements(raw, |q, r, a| if holds(q, r, a) { some = true } else { other = true });
    match (some, other) {
        (true, false) => Verdict::Pass,
        (false, true) => Verdict::Fail,
        _ => Verdict::Inconclusive,
    }
}

/// Stretches `[start, end)` with their values; the last one lasts to the end of the case.
pub(crate) fn stretches(line: &Placed) -> Vec<(i64, i64, i64)> {
    let ends = line.iter().skip(1).map(|change| change.0).chain([END]);
    line.iter().zip(ends).map(|(change, end)| (change.0, end, change.1)).collect()
}

/// Rising edges after an instant. At the instant itself the order of the trace would decide, which is not drawn.
pub(crate) fn rises(line: &Placed, from: i64) -> Vec<i64> {
    let rise = |pair: &&[(i64, i64)]| pair[0].1 == 0 && pair[1].1 == 1 && pair[1].0 >= from;
    line.windows(2).filter(rise).map(|pair| pair[1].0).collect()
}

/// Changes at the very instant of the step are before or after it by the order of the trace: left out of the test.
pub(crate) fn apart_from_the_step(raw: &[Raw]) -> bool {
    let step = raw.iter().find(|event| event.signal == 2).unwrap();
    raw.iter().all(|event| event.signal == 2 || event.b < step.a || event.a > step.b)
}

pub(crate) fn check(verdict: Verdict, expected: Verdict, exact: bool) -> bool {
    if exact { verdict == expected } else { verdict == expected || verdict == Verdict::Inconclusive }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    /// `frequency` and `duty`: means over whole cycles.
    #[test]
    fn means_over_cycles(q in line(2, 6), step in (0i64..8, 0i64..3), least in 3i64..9, more in 0i64..5, exact: bool) {
        let raw = raw(&[(q, 2)], step, exact);
        prop_assume!(apart_from_the_step(&raw));
        // A mean period of `least` to `most` nanoseconds.
        let most = least + more;
        let expected = oracle(&raw, |line, _, a| {
            let rises = rises(line, a);
            let Some(cycles) = rises.len().checked_sub(1).filter(|cycles| *cycles > 0) else { return false };
            let whole = rises[cycles] - rises[0];
            (least * cycles as i64..=most * cycles as i64).contains(&whole)
        });
        let (slowest, fastest) = (1e12 / most as f64, 1e12 / least as f64);
        // In millihertz, cut beyond the limits so that the float of the text is on the safe side.
        let text = format!(
            r#"{{ frequency = {{ signal = "q", min = "{:.3} mHz", max = "{:.3} mHz", from = "a" }} }}"#,
            slowest - 0.01, fastest + 0.01
        );
        let verdict = judged(&raw, &text, ValueKind::Bool).verdict;
        prop_assert!(check(verdict, expected, exact), "{verdict} and not {expected}: {text} {raw:?}");

        let percent = least * 10;
        let duty = |line: &Placed, a: i64| {
            let rises = rises(line, a);
            let (first, last) = (*rises.first()?, *rises.last()?);
            let high = stretches(line).into_iter().filter(|(start, _, value)| *value == 1 && (first..last).contains(start));
            let high: i64 = high.map(|(start, end, _)| end - start).sum();
            (last > first).then(|| (high * 100, last - first))
        };
        let expected = oracle(&raw, |line, _, a| {
            duty(line, a).is_some_and(|(high, whole)| high <= percent * whole)
        });
        let text = format!(r#"{{ duty = {{ signal = "q", max = "{percent} %", from = "a" }} }}"#);
        let verdict = judged(&raw, &text, ValueKind::Bool).verdict;
        prop_assert!(check(verdict, expected, exact), "{verdict} and not {expected}: {text} {raw:?}");
    }

    /// `phase`: every whole cycle of one line has an edge of the other near the wanted angle.
    #[test]
    fn phases(q in line(2, 5), r in line(2, 5), step in (0i64..3, 0i64..2), exact: bool) {
        let raw = raw(&[(q, 2), (r, 2)], step, exact);
        prop_assume!(apart_from_the_step(&raw));
        // 180 deg ± 60 deg: the turn of a cycle is the cycle itself.
        let expected = oracle(&raw, |q, r, a| {
            let cycles = rises(r, a);
            let all = rises(q, i64::MIN);
            cycles.len() > 1 && cycles.windows(2).all(|pair| {
                let first = all.iter().find(|edge| **edge >= pair[0]);
                first.is_some_and(|edge| {
                    let (delay, length) = (edge - pair[0], pair[1] - pair[0]);
                    *edge < pair[1] && (120 * length..=240 * length).contains(&(delay * 360))
                })
            })
        });
        let text = r#"{ phase = { of = "q", reference = "r", is = "180 deg ± 60 deg", from = "a" } }"#;
        let verdict = judged(&raw, text, ValueKind::Bool).verdict;
        prop_assert!(check(verdict, expected, exact), "{verdict} and not {expected}: {raw:?}");
    }

    /// `settles`, with an overshoot.
    #[test]
    fn settling(q in line(4, 6), step in (0i64..8, 0i64..3), within in 1i64..10, exact: bool) {
        let raw = raw(&[(q, 4)], step, exact);
        prop_assume!(apart_from_the_step(&raw));
        let expected = oracle(&raw, |line, _, a| {
            let begun = line.iter().rev().find(|change| change.0 < a).unwrap().1;
            let late = stretches(line).iter().any(|(_, end, value)| *value != 2 && *end > a + within);
            let over = stretches(line).iter().any(|(_, end, value)| *end > a && begun < 2 && *value > 2)
                || stretches(line).iter().any(|(_, end, value)| *end > a && begun > 2 && *value < 2);
            !late && !over
        });
        let text = format!(
            r#"{{ settles = {{ signal = "q", is = 2, from = "a", within = "{within} ns", overshoot = 0.5 }} }}"#
        );
        let verdict = judged(&raw, &text, ValueKind::Int).verdict;
        // Without a step the answer is open by design.
        let begun = judged(&raw, r#"{ name = "n", value-of = "q", when = "a" }"#, ValueKind::Int).measurements[0].value;
        let stepped = begun.is_some_and(|value| value[0] == value[1] && value[0] != 2.0);
        prop_assert!(check(verdict, expected, exact && stepped), "{verdict} and not {expected}: {text} {raw:?}");
    }

    /// `follows`, with and without a lag.
    #[test]
    fn following(q in line(4, 5), r in line(4, 5), step in (0i64..4, 0i64..2), within in 0i64..5, exact: bool) {
        let raw = raw(&[(q, 4), (r, 4)], step, exact);
        prop_assume!(apart_from_the_step(&raw));
        let expected = oracle(&raw, |q, r, a| {
            let at = |line: &Placed, now: i64| line.iter().rev().find(|change| change.0 <= now).unwrap().1;
            // For how long they are apart at a stretch; what began before the window counts as it is.
            let (mut since, mut good) = (None, true);
            for now in 0..END {
                if (at(q, now) - at(r, now)).abs() > 1 {
                    let start = *since.get_or_insert(now);
                    good &= now < a || now + 1 - start <= within;
                } else {
                    since = None;
                }
            }
            good
        });
        let lag = if within > 0 { format!(r#", within = "{within} ns""#) } else { String::new() };
        let text = format!(r#"{{ follows = {{ signal = "q", leader = "r", tolerance = 1, from = "a"{lag} }} }}"#);
        let verdict = judged(&raw, &text, ValueKind::Int).verdict;
        // What lasts to the end of the case may go on: how long is not known then.
        let lasts = within > 0;
        prop_assert!(check(verdict, expected, exact && !lasts), "{verdict} and not {expected}: {text} {raw:?}");
    }

    /// What is measured of values lies within the measured interval, which is a point where all instants are exact.
    #[test]
    fn measured_values(q in line(4, 6), step in (0i64..8, 0i64..3), which in 0usize..5, exact: bool) {
        let raw = raw(&[(q, 4)], step, exact);
        prop_assume!(apart_from_the_step(&raw));
        let take = ["min", "max", "mean", "rms", "span"][which];
        let text = format!(r#"{{ name = "n", value-of = "q", take = "{take}", from = "a" }}"#);
        let [low, high] = judged(&raw, &text, ValueKind::Int).measurements[0].value.unwrap();
        let mut wrong = None;
        placements(&raw, |line, _, a| {
            let inside: Vec<(f64, f64)> = stretches(line)
                .into_iter()
                .filter(|(_, end, _)| *end > a)
                .map(|(start, end, value)| ((end - start.max(a)) as f64, value as f64))
                .collect();
            let least = inside.iter().map(|(_, value)| *value).fold(f64::INFINITY, f64::min);
            let most = inside.iter().map(|(_, value)| *value).fold(f64::NEG_INFINITY, f64::max);
            let time: f64 = inside.iter().map(|(length, _)| length).sum();
            let value = match take {
                "min" => least,
                "max" => most,
                "mean" => inside.iter().map(|(length, value)| length * value).sum::<f64>() / time,
                "rms" => (inside.iter().map(|(length, value)| length * value * value).sum::<f64>() / time).sqrt(),
                _ => most - least,
            };
            if value < low - 1e-9 || value > high + 1e-9 {
                wrong = Some((value, low, high));
            }
        });
        prop_assert!(wrong.is_none(), "{wrong:?}: {text} {raw:?}");
        prop_assert!(!exact || high - low < 1e-9, "{low} {high}: {text} {raw:?}");
    }

    /// Widths and periods one by one lie within the measured interval.
    #[test]
    fn measured_cycles(q in line(2, 7), step in (0i64..8, 0i64..3), which in 0usize..4, width: bool, exact: bool) {
        let raw = raw(&[(q, 2)], step, exact);
        prop_assume!(apart_from_the_step(&raw));
        let take = ["min", "max", "mean", "span"][which];
        let key = if width { "width-of" } else { "period-of" };
        let text = format!(r#"{{ name = "n", {key} = "q", take = "{take}", from = "a" }}"#);
        let Some([low, high]) = judged(&raw, &text, ValueKind::Bool).measurements[0].value else { return Ok(()) };
        let mut wrong = None;
        placements(&raw, |line, _, a| {
            let lengths: Vec<i64> = if width {
                let high = |stretch: &&(i64, i64, i64)| stretch.2 == 1 && stretch.0 > a && stretch.1 < END;
                stretches(line).iter().filter(high).map(|stretch| stretch.1 - stretch.0).collect()
            } else {
                rises(line, a).windows(2).map(|pair| pair[1] - pair[0]).collect()
            };
            let (Some(least), Some(most)) = (lengths.iter().min(), lengths.iter().max()) else { return };
            let value = match take {
                "min" => *least as f64,
                "max" => *most as f64,
                "mean" => lengths.iter().sum::<i64>() as f64 / lengths.len() as f64,
                _ => (most - least) as f64,
            };
            if value < low - 1e-9 || value > high + 1e-9 {
                wrong = Some((value, low, high));
            }
        });
        prop_assert!(wrong.is_none(), "{wrong:?}: {text} {raw:?}");
        prop_assert!(!exact || high - low < 1e-9, "{low} {high}: {text} {raw:?}");
    }

    /// Without a guard band a figure that is known is held against its limits by its middle, in whole numbers; what is open for
    /// another reason than the width stays so.
    #[test]
    fn guard_bands(q in line(2, 7), step in (0i64..8, 0i64..3), which in 0usize..3, least in 0i64..9, more in 0i64..5, exact: bool) {
        let raw = raw(&[(q, 2)], step, exact);
        prop_assume!(apart_from_the_step(&raw));
        let what = ["to = { signal = \"q\", edge = \"rises\" }", "width-of = \"q\"", "period-of = \"q\", take = \"max\""][which];
        let judge = |guard: &str| {
            let limits = format!("min = \"{least} ns\", max = \"{} ns\"", least + more);
            let text = format!(r#"{{ name = "n", {what}, from = "a", {limits}, guard = "{guard}" }}"#);
            judged(&raw, &text, ValueKind::Bool).measurements[0].clone()
        };
        let (guarded, unguarded) = (judge("uncertainty"), judge("none"));
        prop_assert_eq!(guarded.value, unguarded.value);
        let width_alone = guarded.reason == "a limit lies within the uncertainty";
        match guarded.value {
            Some([low, high]) if width_alone || guarded.verdict != Verdict::Inconclusive => {
                let twice = low as i64 + high as i64;
                let inside = (2 * least..=2 * (least + more)).contains(&twice);
                let expected = if inside { Verdict::Pass } else { Verdict::Fail };
                prop_assert_eq!(unguarded.verdict, expected, "{:?} {:?}", unguarded, raw);
                prop_assert!(width_alone || guarded.verdict == expected);
            }
            _ => prop_assert_eq!((guarded.verdict, guarded.reason), (unguarded.verdict, unguarded.reason)),
        }
    }
}
