//! Short pulses: those that do not count, against an oracle that takes them out of every placement, and those that a
//! sampled channel does not see, against the verdict on the line itself.

use proptest::prelude::*;
use record::Verdict;
use scanrig_plans::judge::CaseJudge;
use signal::{Cause, Event, Sampling, SignalId, SignalInfo, Span, Time, Trace, Value, ValueKind, When};

use crate::oracle_values::scenario;

/// Nothing of the line lies before.
const ORIGIN: i64 = 20;
/// The end of the case.
pub(crate) const END: i64 = 120;

/// A change of the line before it is placed: its interval, its level.
pub(crate) type Change = (i64, i64, bool);

/// The verdict on a line whose channel is such. The step `a` comes at an instant with nothing of the line.
pub(crate) fn verdict(text: &str, line: &[Change], step: i64, sampling: Sampling) -> Verdict {
    let mut q = SignalInfo::exact("q", ValueKind::Bool);
    q.sampling = sampling;
    let marks = ["step:a", "step:start"].map(|name| SignalInfo::exact(name, ValueKind::Mark));
    let signals: Vec<SignalInfo> = std::iter::once(q).chain(marks).collect();
    let mut events: Vec<(u32, i64, i64, Value)> =
        vec![(2, 0, 0, Value::Int(1)), (1, step, step, Value::Int(1))];
    events.extend(line.iter().map(|(a, b, on)| (0, *a, *b, Value::Bool(*on))));
    events.sort_by_key(|event| (event.2, event.0 != 0));
    let mut trace = Trace::new();
    for info in &signals {
        trace.define(info.clone()).unwrap();
    }
    for (signal, a, b, value) in events {
        let at = When::within(Time::from_nanos(a), Time::from_nanos(b));
        trace.push(Event { signal: SignalId(signal), at, value, cause: Cause::Unknown }).unwrap();
    }
    let mut judge = CaseJudge::new(scenario(text), &signals).unwrap();
    let mut lost = false;
    for event in trace.events() {
        judge.feed(&event.unwrap());
        lost |= judge.failed_early();
    }
    let judged = judge.finish(When::exactly(Time::from_nanos(END)), &trace).unwrap();
    // Whoever watches is not told here that the case is over.
    let over = line.iter().any(|change| change.1 >= END);
    assert!(!lost || over || judged.verdict == Verdict::Fail, "lost early: {text} {line:?}");
    judged.verdict
}

/// The line of a first level and the lengths of its stretches, with intervals of this width.
fn line(first: bool, lengths: &[(i64, i64)]) -> Vec<Change> {
    let mut changes = vec![(0, 0, first)];
    let (mut at, mut on) = (ORIGIN, first);
    for (length, width) in lengths {
        on = !on;
        changes.push((at, at + width, on));
        at += length;
    }
    // Both ends of the intervals of one signal run forwards, as channels give them.
    for place in 1..changes.len() {
        changes[place].1 = changes[place].1.max(changes[place - 1].1);
    }
    changes
}

/// A placed line without the pulses of at most this width.
fn without_short(line: &[(i64, bool)], longest: i64) -> Vec<(i64, bool)> {
    let mut out = vec![line[0]];
    for (place, (at, on)) in line.iter().enumerate().skip(1) {
        let end = line.get(place + 1).map_or(END, |next| next.0);
        if end - at > longest && out.last().is_some_and(|(_, last)| last != on) {
            out.push((*at, *on));
        }
    }
    out
}

fn rises(line: &[(i64, bool)]) -> Vec<i64> {
    line.windows(2).filter(|pair| !pair[0].1 && pair[1].1).map(|pair| pair[1].0).collect()
}

/// Widths of pulses with their beginnings; of the last one, that lasts, none.
fn pulses(line: &[(i64, bool)]) -> Vec<(i64, Option<i64>)> {
    let begins = line.iter().enumerate().skip(1).filter(|(_, change)| change.1);
    begins.map(|(place, change)| (change.0, line.get(place + 1).map(|next| next.0 - change.0))).collect()
}

/// What is claimed, in TOML with a place for more keys, and whether it holds of a line.
type Claim = (&'static str, fn(&[(i64, bool)], i64) -> bool);

const CLAIMS: &[Claim] = &[
    (r#"{ edges = { signal = "q", rising = 1, from = "a"MORE } }"#, |line, a| {
        rises(line).iter().filter(|at| **at >= a).count() == 1
    }),
    (r#"{ edges = { signal = "q", rising = "2 ..", from = "a"MORE } }"#, |line, a| {
        rises(line).iter().filter(|at| **at >= a).count() >= 2
    }),
    (r#"{ period = { signal = "q", is = "8 ns .. 20 ns", from = "a"MORE } }"#, |line, a| {
        let edges: Vec<i64> = rises(line).into_iter().filter(|at| *at >= a).collect();
        edges.len() > 1 && edges.windows(2).all(|pair| (8..=20).contains(&(pair[1] - pair[0])))
    }),
    (
        r#"{ pulse = { signal = "q", width = "6 ns .. 12 ns", which = "every", from = "a"MORE } }"#,
        |line, a| {
            let inside: Vec<_> = pulses(line).into_iter().filter(|pulse| pulse.0 >= a).collect();
            let right = |pulse: &(i64, Option<i64>)| pulse.1.is_some_and(|width| (6..=12).contains(&width));
            !inside.is_empty() && inside.iter().all(right)
        },
    ),
    (r#"{ pulse = { signal = "q", width = "6 ns .. 12 ns", from = "a"MORE } }"#, |line, a| {
        let first = pulses(line).into_iter().find(|pulse| pulse.0 >= a);
        first.is_some_and(|pulse| pulse.1.is_some_and(|width| (6..=12).contains(&width)))
    }),
    (r#"{ frequency = { signal = "q", is = "50 MHz .. 100 MHz", from = "a"MORE } }"#, |line, a| {
        let edges: Vec<i64> = rises(line).into_iter().filter(|at| *at >= a).collect();
        let (Some(first), Some(last)) = (edges.first(), edges.last()) else { return false };
        let cycles = edges.len() as i64 - 1;
        cycles > 0 && (10 * cycles..=20 * cycles).contains(&(last - first))
    }),
    (r#"{ rises = { signal = "q", from = "a", within = "5 ns .. 30 ns"MORE } }"#, |line, a| {
        rises(line).into_iter().find(|at| *at >= a).is_some_and(|at| (5..=30).contains(&(at - a)))
    }),
    (r#"{ name = "w", width-of = "q", take = "max", max = "15 ns", from = "a"MORE }"#, |line, a| {
        let widths: Vec<i64> =
            pulses(line).into_iter().filter(|pulse| pulse.0 >= a).filter_map(|pulse| pulse.1).collect();
        widths.iter().max().is_some_and(|most| *most <= 15)
    }),
    (r#"{ name = "p", period-of = "q", max = "15 ns", from = "a"MORE }"#, |line, a| {
        let edges: Vec<i64> = rises(line).into_iter().filter(|at| *at >= a).collect();
        let (Some(first), Some(last)) = (edges.first(), edges.last()) else { return false };
        let cycles = edges.len() as i64 - 1;
        cycles > 0 && last - first <= 15 * cycles
    }),
    (r#"{ name = "t", from = "a", to = { signal = "q", edge = "rises" }, min = "9 ns"MORE }"#, |line, a| {
        rises(line).into_iter().find(|at| *at >= a).is_some_and(|at| at - a >= 9)
    }),
];

/// What must never be TRUE, or not for long.
const NEVER: Claim = (r#"{ never = { signal = "q", from = "a"MORE } }"#, |line, a| {
    line.iter()
        .enumerate()
        .all(|(place, change)| !change.1 || line.get(place + 1).map_or(END, |next| next.0) <= a)
});

fn text(claim: &Claim, longest: i64) -> String {
    let more = if longest > 0 { format!(", pulses-longer-than = \"{longest} ns\"") } else { String::new() };
    claim.0.replace("MORE", &more)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 600, failure_persistence: None, ..ProptestConfig::default() })]

    /// Pulses that do not count are as if they were not there, whatever is claimed of the rest.
    #[test]
    fn short_pulses_do_not_count(
        first: bool,
        lengths in prop::collection::vec((1i64..14, 0i64..3), 0..6),
        longest in 1i64..7,
        step in 12i64..40,
        exact: bool,
        which in 0..CLAIMS.len(),
    ) {
        let lengths: Vec<_> = lengths.into_iter().map(|(length, width)| (length, if exact { 0 } else { width })).collect();
        let line = line(first, &lengths);
        prop_assume!(line.iter().all(|(a, b, _)| *b < step || *a > step));
        let claim = &CLAIMS[which];
        let (mut some, mut other) = (false, false);
        let mut times: Vec<i64> = line.iter().map(|change| change.0).collect();
        loop {
            if times.windows(2).all(|pair| pair[0] <= pair[1]) {
                let placed: Vec<(i64, bool)> = times.iter().zip(&line).map(|(at, change)| (*at, change.2)).collect();
                if claim.1(&without_short(&placed, longest), step) { some = true } else { other = true }
            }
            let Some(next) = (0..line.len()).find(|at| times[*at] < line[*at].1) else { break };
            times[next] += 1;
            for at in 0..next {
                times[at] = line[at].0;
            }
        }
        let found = verdict(&text(claim, longest), &line, step, Sampling::Edges { resolution: Span::from_nanos(3) });
        let expected = match (some, other) {
            (true, false) => Verdict::Pass,
            (false, true) => Verdict::Fail,
            _ => Verdict::Inconclusive,
        };
        let exactly = exact && line.last().is_none_or(|last| END - last.0 > longest);
        let agrees = found == expected || found == Verdict::Inconclusive && !exactly;
        prop_assert!(agrees, "{found:?}, not {expected:?}: {} {line:?} {step}", text(claim, longest));
    }

    /// What a channel that is sampled does not see never makes a verdict that the line itself would not have; where
    /// the claim wants an edge to come, one that nobody saw did not.
    #[test]
    fn what_nobody_saw_turns_no_verdict(
        first: bool,
        lengths in prop::collection::vec(1i64..14, 0..9),
        period in 2i64..7,
        phase in 0i64..7,
        step in 12i64..40,
        which in 0..=CLAIMS.len(),
    ) {
        let lengths: Vec<_> = lengths.into_iter().map(|length| (length, 0)).collect();
        let line = line(first, &lengths);
        prop_assume!(line.iter().all(|(a, ..)| *a != step));
        let claim = CLAIMS.get(which).unwrap_or(&NEVER);
        let placed: Vec<(i64, bool)> = line.iter().map(|(at, _, on)| (*at, *on)).collect();
        let at = |now: i64| placed.iter().rev().find(|change| change.0 <= now).is_some_and(|change| change.1);
        let mut sampled = vec![(0, 0, first)];
        let mut last = (0, first);
        for now in (1 + phase % period..END).step_by(period as usize) {
            if at(now) != last.1 {
                sampled.push((last.0, now, at(now)));
            }
            last = (now, at(now));
        }
        let text = text(claim, 0);
        let found = verdict(&text, &sampled, step, Sampling::Sampled { period: Span::from_nanos(period) });
        let holds = claim.1(&placed, step);
        let wants_an_edge = text.contains("rises = ") || text.contains("to = ");
        match found {
            Verdict::Pass => prop_assert!(holds, "{text} {line:?} {sampled:?} {step}"),
            Verdict::Fail => prop_assert!(!holds || wants_an_edge, "{text} {line:?} {sampled:?} {step}"),
            _ => {}
        }
    }
}
