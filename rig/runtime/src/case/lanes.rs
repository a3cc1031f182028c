//! Excerpts of the trace for the record, so that reports draw without it.

use record::{CaseRecord, Lane, Verdict};
use signal::{Event, SignalId, SignalInfo, Time, Trace, ValueKind};
use std::collections::VecDeque;

/// Signals that one case shows.
const MOST_LANES: usize = 24;

/// Points of one lane; a drawing shows no more.
const POINTS: usize = 400;

/// The part of the trace that the record keeps: from a little before the first thing that claims and steps look at
/// to a little after the last. A signal with more changes than fit keeps those around the instants that decided.
pub fn excerpts(record: &CaseRecord, trace: &Trace) -> Vec<Lane> {
    let (from, until) = interest(record);
    let focus = focus(record, from);
    let mut shown: Vec<Excerpt> = Vec::new();
    for (place, info) in trace.signals().iter().enumerate() {
        if info.kind != ValueKind::Mark && shown.len() < MOST_LANES {
            let id = SignalId(place as u32);
            shown.push(Excerpt { id, before: None, kept: VecDeque::new(), dropped: false, cut: false });
        }
    }
    let mut places = vec![None; trace.signals().len()];
    for (lane, excerpt) in shown.iter().enumerate() {
        places[excerpt.id.0 as usize] = Some(lane);
    }
    let Ok(mut events) = trace.between(from, until) else { return Vec::new() };
    for (id, _) in places.iter().enumerate().filter(|(_, lane)| lane.is_none()) {
        events.forget(SignalId(id as u32));
    }
    while let Some(Ok(event)) = events.next() {
        if let Some(lane) = places.get(event.signal.0 as usize).copied().flatten() {
            shown[lane].keep(event, focus);
            if shown[lane].cut {
                events.forget(event.signal);
            }
        }
    }
    shown
        .into_iter()
        .map(|mut excerpt| {
            if !excerpt.dropped {
                excerpt.before = events.before(excerpt.id);
            }
            let info = &trace.signals()[excerpt.id.0 as usize];
            excerpt.lane(info, until)
        })
        .collect()
}

/// The changes of one signal that the record keeps.
struct Excerpt {
    id: SignalId,
    /// The change that holds at the beginning.
    before: Option<Event>,
    kept: VecDeque<Event>,
    /// Changes before the kept ones found no room.
    dropped: bool,
    /// Changes after the kept ones found no room.
    cut: bool,
}

impl Excerpt {
    /// Keeps a change. When room runs out, earlier changes make room as long as the instant that decided still lies
    /// ahead or close by; after it nothing more is kept.
    fn keep(&mut self, event: Event, focus: Option<i64>) {
        if self.kept.len() < POINTS {
            self.kept.push_back(event);
            return;
        }
        let half = self.kept[POINTS / 2].at.earliest.as_nanos();
        let ahead = focus.is_some_and(|focus| focus >= half);
        if self.cut || !ahead {
            self.cut = true;
            return;
        }
        self.before = self.kept.pop_front();
        self.dropped = true;
        self.kept.push_back(event);
    }

    fn lane(self, info: &SignalInfo, until: Time) -> Lane {
        let mut lane = Lane::of(info);
        lane.until_ns = Some(until.as_nanos());
        for event in self.before.iter().chain(&self.kept) {
            lane.push_event(event);
        }
        lane.truncated |= self.cut;
        lane
    }
}

/// The first instant that decided a claim that did not pass, or any claim where all passed: what a person looks for.
fn focus(record: &CaseRecord, from: Time) -> Option<i64> {
    let deciding = |all: bool| {
        let claims = record.claims.iter().filter(move |claim| all || claim.verdict > Verdict::Pass);
        claims.filter_map(|claim| claim.deciding_ns.map(|at| at[0])).filter(|at| *at >= from.as_nanos()).min()
    };
    deciding(false).or_else(|| deciding(true))
}

/// The span of time that the claims, measurements and steps of a case look at, with a margin.
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
            window.limit_from_ns.into_iter().chain(window.limit_until_ns).for_each(&mut look);
        }
    }
    for measurement in &record.measurements {
        measurement.from_ns.into_iter().chain(measurement.to_ns).flatten().for_each(&mut look);
    }
    if from > until {
        (from, until) = (start, end);
    }
    let margin = ((until - from) / 20).max(1_000_000);
    let from = (from - margin).max(0);
    (Time::from_nanos(from), Time::from_nanos(until.saturating_add(margin).min(end)))
}
