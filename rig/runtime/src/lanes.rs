//! Excerpts of the trace for the record, so that reports draw without it.

use record::{CaseRecord, Lane, MAX_LANE_POINTS};
use signal::{Event, Kind, Time, Trace};

/// Signals that one case shows.
const MOST_LANES: usize = 24;

/// Points of one lane; a drawing shows no more.
const POINTS: usize = 400;

/// The part of the trace that the record keeps: from a little before the first thing that the claims look at to a
/// little behind the last, or the whole case where it is short of events.
pub fn excerpts(record: &CaseRecord, trace: &Trace) -> Vec<Lane> {
    let (from, until) = interest(record);
    let shown: Vec<usize> = trace
        .signals()
        .iter()
        .enumerate()
        .filter(|(_, info)| info.kind != Kind::Mark)
        .map(|(place, _)| place)
        .take(MOST_LANES)
        .collect();
    let mut lanes: Vec<Lane> = shown.iter().map(|place| Lane::of(&trace.signals()[*place])).collect();
    let Ok(mut events) = trace.between(from, until) else { return lanes };
    let limit = POINTS.min(MAX_LANE_POINTS);
    let mut before: Vec<Option<Event>> = Vec::new();
    let mut inside: Vec<Vec<Event>> = vec![Vec::new(); lanes.len()];
    let mut full = vec![false; lanes.len()];
    for event in events.by_ref() {
        let Ok(event) = event else { break };
        let Some(lane) = shown.iter().position(|place| *place == event.signal.0 as usize) else { continue };
        if inside[lane].len() < limit {
            inside[lane].push(event);
        } else {
            full[lane] = true;
        }
    }
    for place in &shown {
        before.push(events.before(signal::SignalId(*place as u32)));
    }
    for (lane, ((before, inside), full)) in lanes.iter_mut().zip(before.into_iter().zip(inside).zip(full)) {
        if let Some(before) = before {
            lane.push_event(&before);
        }
        for event in &inside {
            lane.push_event(event);
        }
        lane.truncated |= full;
    }
    lanes
}

/// The span of time that the claims and steps of a case look at, with a margin.
fn interest(record: &CaseRecord) -> (Time, Time) {
    let (start, end) = (record.start_ns, record.end_ns);
    let mut from = i64::MAX;
    let mut until = i64::MIN;
    let mut look = |at: i64| {
        if (start..=end).contains(&at) {
            from = from.min(at);
            until = until.max(at);
        }
    };
    for step in &record.steps {
        step.at_ns.into_iter().flatten().for_each(&mut look);
    }
    for claim in &record.claims {
        claim.deciding_ns.into_iter().flatten().for_each(&mut look);
        if let Some(window) = &claim.window {
            look(window.from_ns[0]);
            look(window.until_ns[1]);
        }
    }
    if from > until {
        (from, until) = (start, end);
    }
    let margin = ((until - from) / 20).max(1_000_000);
    let from = (from - margin).max(0);
    (Time::from_nanos(from), Time::from_nanos(until.saturating_add(margin).min(end)))
}
