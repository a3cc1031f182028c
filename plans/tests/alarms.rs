//! Alarms: their verdicts on recorded traces, held against every placement of the events, and against what is seen
//! while the case runs.

use std::sync::Arc;

use document::SourceFile;
use record::{ClaimRecord, Verdict};
use scanrig_plans::alarm::Alarm;
use scanrig_plans::judge::{CaseJudge, Scenario};
use scanrig_plans::read;
use signal::{Cause, Event, Random, SignalId, SignalInfo, Time, Trace, Value, ValueKind, When};

const START: i64 = 10;

fn alarm(text: &str) -> (Arc<Alarm>, Scenario) {
    let plan = format!("format = 1\nprogram = \"a.st\"\nalarms = [{{ name = \"heat\", {text} }}]\n");
    let plan = read(&SourceFile::new("a.toml", plan), &[], 1).unwrap_or_else(|found| panic!("{found:#?}"));
    let case = plan.case(0).unwrap();
    (case.alarms[0].clone(), case.scenario())
}

fn infos() -> Vec<SignalInfo> {
    let marks = ["step:start", "step:end"].map(|mark| SignalInfo::exact(mark, ValueKind::Mark));
    let mut infos = vec![SignalInfo::exact("t", ValueKind::Int)];
    infos.extend(marks);
    infos
}

/// The trace of `t` with these intervals and values, from 10 to `end`.
fn judge(scenario: &Scenario, events: &[(i64, i64, Value)], end: i64) -> ClaimRecord {
    let infos = infos();
    let mut trace = Trace::new();
    let ids: Vec<SignalId> = infos.iter().map(|info| trace.define(info.clone()).unwrap()).collect();
    let event = |id: SignalId, a: i64, b: i64, value| Event {
        signal: id,
        at: When::within(Time::from_nanos(a), Time::from_nanos(b)),
        value,
        cause: Cause::Unknown,
    };
    let mut all = vec![event(ids[1], START, START, Value::Int(1)), event(ids[2], end, end, Value::Int(1))];
    all.extend(events.iter().map(|(a, b, value)| event(ids[0], *a, *b, *value)));
    all.sort_by_key(|event| event.at.earliest);
    for event in all {
        trace.push(event).unwrap();
    }
    let judge = CaseJudge::new(scenario.clone(), &infos).unwrap();
    let outcome = judge.replay(When::exactly(Time::from_nanos(end)), &trace).unwrap();
    outcome.claims[0].clone()
}

fn int(at: i64, value: i64) -> (i64, i64, Value) {
    (at, at, Value::Int(value))
}

#[test]
fn a_condition_that_lasts_raises_it() {
    let (_, heat) = alarm("when = { signal = \"t\", above = 6 }, delay = \"100 ns\", hysteresis = 2");
    let passed = judge(&heat, &[int(0, 0), int(50, 7), int(149, 4)], 1_000);
    assert_eq!((passed.verdict, passed.margin.unwrap().to_string()), (Verdict::Pass, "1 ns".to_owned()));
    let record = judge(&heat, &[int(0, 0), int(50, 7), int(150, 4)], 1_000);
    assert_eq!(record.verdict, Verdict::Fail);
    assert_eq!(record.expected, "`t` is not above 6 for 100 ns");
    assert_eq!(record.observed, "above 6 for 100 ns, from 40 ns after start");
    assert_eq!(record.reason, "the alarm was raised 140 ns after start");
    // Back within the hysteresis is not back.
    let record = judge(&heat, &[int(0, 0), int(50, 7), int(100, 5), int(150, 4)], 1_000);
    assert_eq!(record.verdict, Verdict::Fail);
    // Never beyond the limit: the margin is what was left.
    let record = judge(&heat, &[int(0, 0), int(50, 6), int(500, 3)], 1_000);
    assert_eq!((record.verdict, record.margin.unwrap().value), (Verdict::Pass, 0.0));
}

#[test]
fn what_is_not_known_may_raise_it() {
    let (_, heat) = alarm("when = { signal = \"t\", above = 6 }, delay = \"100 ns\"");
    let record = judge(&heat, &[int(0, 0), (50, 50, Value::Unknown), int(200, 0)], 1_000);
    assert_eq!(record.verdict, Verdict::Inconclusive);
    assert_eq!(record.reason, "`t` is not known for a part of the case");
    let record = judge(&heat, &[int(0, 0), (50, 50, Value::Unknown), int(149, 0)], 1_000);
    assert_eq!(record.verdict, Verdict::Pass);
}

#[test]
fn the_end_of_the_case_is_the_end_of_what_lasts() {
    let (_, heat) = alarm("when = { signal = \"t\", above = 6 }, delay = \"100 ns\"");
    assert_eq!(judge(&heat, &[int(0, 7)], 109).verdict, Verdict::Pass);
    assert_eq!(judge(&heat, &[int(0, 7)], 110).verdict, Verdict::Fail);
    let (_, at_once) = alarm("when = { signal = \"t\", above = 6 }");
    assert_eq!(judge(&at_once, &[int(0, 0), int(109, 7)], 110).verdict, Verdict::Fail);
    assert_eq!(judge(&at_once, &[int(0, 7), int(5, 0)], 110).verdict, Verdict::Pass);
}

/// Whether some placement raises it, and whether some does not: every placement of small intervals is tried.
fn placements(events: &[(i64, i64, Value)], end: i64, delay: i64) -> (bool, bool) {
    fn walk(
        events: &[(i64, i64, Value)],
        placed: &mut Vec<(i64, Value)>,
        end: i64,
        delay: i64,
        seen: &mut (bool, bool),
    ) {
        let Some(((a, b, value), rest)) = events.split_first() else {
            let raised = (0..placed.len()).any(|place| {
                let (from, value) = placed[place];
                let until = placed.get(place + 1).map_or(end, |next| next.0).min(end);
                // Neighbours of one phase were merged when the trace was made.
                value == Value::Int(7) && from < end && until >= START && until - from.max(START) >= delay
            });
            return if raised { seen.0 = true } else { seen.1 = true };
        };
        let least = placed.last().map_or(i64::MIN, |last| last.0);
        for at in (*a).max(least)..=*b {
            placed.push((at, *value));
            walk(rest, placed, end, delay, seen);
            placed.pop();
        }
    }
    let mut seen = (false, false);
    walk(events, &mut Vec::new(), end, delay, &mut seen);
    seen
}

#[test]
fn verdicts_hold_for_every_placement() {
    let mut random = Random::new(7);
    let mut verdicts = [0; 3];
    for _ in 0..3_000 {
        let delay = 1 + random.below(8) as i64;
        let (_, heat) = alarm(&format!("when = {{ signal = \"t\", above = 6 }}, delay = \"{delay} ns\""));
        let mut events = vec![int(0, 0)];
        let mut at = 8;
        for turn in 0..4 {
            at += random.below(8) as i64;
            let value = if turn % 2 == 0 { 7 } else { 0 };
            events.push((at, at + random.below(4) as i64, Value::Int(value)));
        }
        // Ends of intervals do not run backwards.
        for place in 1..events.len() {
            events[place].1 = events[place].1.max(events[place - 1].1);
        }
        let end = 40;
        let (raised, not) = placements(&events, end, delay);
        let verdict = judge(&heat, &events, end).verdict;
        let wanted = match (raised, not) {
            (true, false) => Verdict::Fail,
            (false, _) => Verdict::Pass,
            (true, true) => Verdict::Inconclusive,
        };
        // Two stretches that share an uncertain instant are judged one by one: open, but never wrong.
        let cautious = verdict == Verdict::Inconclusive && wanted != Verdict::Pass;
        assert!(verdict == wanted || cautious, "{events:?} delay {delay}: {verdict:?}, not {wanted:?}");
        verdicts[match verdict {
            Verdict::Pass => 0,
            Verdict::Fail => 1,
            _ => 2,
        }] += 1;
    }
    assert!(verdicts.iter().all(|count| *count > 100), "{verdicts:?}");
}

#[test]
fn the_watch_and_the_judge_agree_on_exact_traces() {
    let mut random = Random::new(11);
    let mut raised_ones = 0;
    for _ in 0..3_000 {
        let delay = random.below(12) as i64;
        let text = format!("when = {{ signal = \"t\", above = 6 }}, delay = \"{delay} ns\", hysteresis = 2");
        let (heat, scenario) = alarm(&text);
        let mut watch = heat.watch(&infos()[0]).unwrap();
        let mut events = vec![int(0, random.below(9) as i64)];
        let mut at = 0;
        for _ in 0..6 {
            at += 1 + random.below(12) as i64;
            if at != START {
                events.push(int(at, random.below(9) as i64));
            }
        }
        let end = at + 1 + random.below(12) as i64;
        let mut raised = None;
        let mut begun = false;
        for (at, _, value) in events.iter().copied().chain([(end, end, Value::Unknown)]) {
            let now = Time::from_nanos(at);
            if at > START && !begun {
                begun = true;
                watch.start(Time::from_nanos(START));
            }
            if raised.is_none() && watch.due().is_some_and(|due| due <= now) {
                raised = watch.due();
            }
            if at < end && (watch.see(When::exactly(now), value) | watch.pass(now)) {
                raised.get_or_insert(now);
            }
        }
        let record = judge(&scenario, &events, end);
        let wanted = if raised.is_some() { Verdict::Fail } else { Verdict::Pass };
        assert_eq!(record.verdict, wanted, "{events:?} {text} end {end}");
        if let Some(raised) = raised {
            raised_ones += 1;
            // The case that ends by it is judged the same.
            let until: Vec<_> = events.iter().copied().filter(|event| event.0 <= raised.as_nanos()).collect();
            let early = judge(&scenario, &until, raised.as_nanos());
            if delay > 0 || until.iter().all(|event| event.0 < raised.as_nanos()) {
                assert_eq!(early.verdict, Verdict::Fail, "{events:?} {text} raised {raised}");
            }
        }
    }
    assert!(raised_ones > 500);
}
