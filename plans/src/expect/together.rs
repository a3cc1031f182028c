//! Several signals that must never be TRUE at once.
//!
//! The stretches in which all are TRUE begin with the last beginning and end with the first end of one
//! stretch of each. Events of different signals keep no order, so each stretch of a signal is held until no
//! stretch of another can meet it any more.

use std::collections::VecDeque;

use signal::Value;

use crate::monitor::{Finding, Monitor, TimedValue, Truth};

use super::keeps::Common;

/// Most finished stretches that one signal keeps for the others. Beyond it the oldest counts as a possible
/// breach only, so that a verdict can become inconclusive by it but never wrong.
const MOST: usize = 64;

/// A stretch in which one signal is TRUE, or not known.
#[derive(Clone, Copy, Debug)]
struct OverlapStretch {
    start: TimedValue,
    /// `None` while it lasts.
    end: Option<(i64, i64)>,
    known: bool,
}

impl OverlapStretch {
    fn latest_end(&self) -> i64 {
        self.end.map_or(i64::MAX, |end| end.1)
    }
}

/// One signal.
#[derive(Debug, Default)]
struct OverlapSignal {
    stretches: VecDeque<OverlapStretch>,
    class: Option<Truth>,
    /// No later event of the signal begins before this.
    reached: i64,
    /// How far after the newest event of the trace one of this signal can begin, nanoseconds.
    lag: i64,
}

/// The judge of several signals.
struct OverlapMonitor {
    common: Common,
    sides: Vec<OverlapSignal>,
    /// Common stretches that were found, in the order of time.
    found: Vec<(Truth, TimedValue, (i64, i64))>,
    /// The last of them, and the beginning of those that it may go on from: where some are not known, all can be
    /// one pulse.
    last: Option<(Truth, TimedValue, (i64, i64))>,
}

pub(super) fn start(common: Common, lags: Vec<i64>) -> Box<dyn Monitor> {
    let unknown = OverlapStretch { start: TimedValue::NOTHING, end: None, known: false };
    let side = |lag| OverlapSignal {
        stretches: VecDeque::from([unknown]),
        class: Some(Truth::Unknown),
        reached: i64::MIN,
        lag,
    };
    let sides = lags.into_iter().map(side).collect();
    let mut this = OverlapMonitor { common, sides, found: Vec::new(), last: None };
    let begin = TimedValue { value: signal::Value::Bool(false), ..unknown.start };
    this.common.segments.change(Truth::True, &begin);
    Box::new(this)
}

impl OverlapMonitor {
    /// The stretch at the back of a side ended: meets it with those of the other sides.
    fn ended(&mut self, side: usize) {
        let Some(over) = self.sides[side].stretches.back().copied() else { return };
        self.meet(side, 0, over.start, over.end.unwrap_or((i64::MAX, i64::MAX)), over.known);
    }

    /// Goes through the stretches of side `at` and further that have ended and meet `[start, end)`.
    fn meet(&mut self, own: usize, at: usize, start: TimedValue, end: (i64, i64), known: bool) {
        if at == self.sides.len() {
            let certain = known && start.b < end.0;
            let class = if certain { Truth::False } else { Truth::Unknown };
            self.found.push((class, start, end));
            return;
        }
        if at == own {
            return self.meet(own, at + 1, start, end, known);
        }
        for place in 0..self.sides[at].stretches.len() {
            let other = self.sides[at].stretches[place];
            let Some(other_end) = other.end else { continue };
            let both = known && other.known;
            let last = if other.start.place > start.place { other.start } else { start };
            let later = TimedValue {
                a: start.a.max(other.start.a),
                b: start.b.max(other.start.b),
                value: if both { last.value } else { Value::Unknown },
                ..last
            };
            let earlier = (end.0.min(other_end.0), end.1.min(other_end.1));
            if later.a < earlier.1 {
                self.meet(own, at + 1, later, earlier, known && other.known);
            }
        }
    }

    /// Drops stretches that nothing can meet any more.
    fn prune(&mut self) {
        for side in 0..self.sides.len() {
            while let Some(front) = self.sides[side].stretches.front() {
                let end = front.latest_end();
                let over = front.end.is_some()
                    && self.sides.iter().enumerate().all(|(at, other)| {
                        let open = other.stretches.back().filter(|last| last.end.is_none());
                        at == side || open.map_or(other.reached, |open| open.start.a) >= end
                    });
                if !over {
                    break;
                }
                self.sides[side].stretches.pop_front();
            }
        }
    }

    /// Makes room in a side: the oldest stretch may meet ones that have not ended.
    fn make_room(&mut self, side: usize) {
        if self.sides[side].stretches.len() < MOST {
            return;
        }
        let Some(oldest) = self.sides[side].stretches.pop_front() else { return };
        self.found.push((Truth::Unknown, oldest.start, oldest.end.unwrap_or((i64::MAX, i64::MAX))));
    }

    /// Hands the common stretches on. Those that overlap each other are merged by their beginnings.
    fn hand_on(&mut self) {
        for (class, start, end) in std::mem::take(&mut self.found) {
            let joined = self.last.filter(|(before, _, until)| {
                (class == Truth::Unknown || *before == Truth::Unknown) && start.a <= until.1
            });
            let begun = joined.map_or(start, |(_, begun, _)| begun);
            self.last = Some((class, begun, end));
            if joined.is_some() && self.common.weigh(Truth::Unknown, &begun, end) != Truth::True {
                self.common.segments.stray(Truth::Unknown, &begun, end);
            }
            match self.common.weigh(class, &start, end) {
                Truth::True => {}
                class => self.common.segments.stray(class, &start, end),
            }
        }
    }
}

impl Monitor for OverlapMonitor {
    fn feed(&mut self, slot: usize, seen: &TimedValue) {
        self.common.advance(seen.a);
        let watched = &self.common.watched[slot];
        // The test says what is allowed: not TRUE.
        let class = watched.test.holds(seen.value, watched.slack);
        for side in &mut self.sides {
            side.reached = side.reached.max(seen.a.saturating_sub(side.lag));
        }
        let side = &mut self.sides[slot];
        side.reached = side.reached.max(seen.a);
        if side.class == Some(class) {
            return;
        }
        let open = side.class != Some(Truth::True);
        side.class = Some(class);
        if open {
            if let Some(last) = side.stretches.back_mut() {
                last.end = Some((seen.a, seen.b));
            }
            self.ended(slot);
        }
        if class != Truth::True {
            self.make_room(slot);
            let known = class == Truth::False;
            self.sides[slot].stretches.push_back(OverlapStretch { start: *seen, end: None, known });
        }
        self.prune();
        self.hand_on();
    }

    fn lost(&mut self, now: i64) -> bool {
        let open = self.sides.iter().map(|side| side.stretches.back().filter(|last| last.end.is_none()));
        let starts: Option<Vec<i64>> =
            open.map(|open| open.filter(|open| open.known).map(|o| o.start.b)).collect();
        let shared = starts.and_then(|starts| starts.into_iter().max());
        let inside = shared.is_some_and(|start| self.common.segments.would_lose(start, now));
        self.common.claim.longer_than.is_none() && inside || self.common.lost(now)
    }

    fn finish(mut self: Box<Self>) -> Finding {
        for side in 0..self.sides.len() {
            if self.sides[side].stretches.back().is_some_and(|last| last.end.is_none()) {
                if let Some(last) = self.sides[side].stretches.back_mut() {
                    last.end = Some((self.common.end.max(last.start.b), i64::MAX));
                }
                self.ended(side);
            }
        }
        self.hand_on();
        self.common.finding(None)
    }
}
