//! Counts out of the lines that carry them: pulses alone, with a line of direction, on a line for each direction, the two
//! phases of a quadrature, or a number that counts itself.
//!
//! Events of two lines are put into the order of their instants. Where that is not known, because intervals overlap, it
//! is not known either which way a count goes: it may be one up or one down.

use std::collections::VecDeque;

use signal::Value;

use super::TimedValue;
use super::edges::{CountedEdge, EdgeFinder, LAST};

/// How counts are carried.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PulseEncoding {
    /// Each rising edge is one up.
    Pulses,
    /// The second line is TRUE for pulses that count up, or with `inverted` for those that count down.
    Direction {
        /// Whether it is the other way round.
        inverted: bool,
    },
    /// Rising edges of the second line are one down each.
    Backwards,
    /// The second line is phase B: every edge of both is one count, up where A goes first.
    Quadrature,
    /// The signal is a number; it counts by as much as it changes.
    Number,
    /// The same of a number that is read from time to time: what it is, it is at the end of its interval.
    Read,
}

/// A change of the position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PositionChange {
    /// When.
    pub seen: TimedValue,
    /// Least and greatest number by which it counts up.
    pub up: (u64, u64),
    /// The same downwards.
    pub down: (u64, u64),
    /// One of the other direction may come before or after it.
    pub blurred: bool,
}

/// What comes next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TrackStep {
    /// A count.
    Count(PositionChange),
    /// A stretch of which nothing is known ends here.
    Unknown(TimedValue),
}

/// Most events of one line that wait for those of the other. Beyond it their order counts as unknown.
const WAITING: usize = 256;

/// Follows the lines.
#[derive(Clone, Debug)]
pub struct PositionTrack {
    carried: PulseEncoding,
    lines: [TrackLine; 2],
    /// How many of the lines carry something.
    used: usize,
}

#[derive(Clone, Debug)]
struct TrackLine {
    finder: EdgeFinder,
    /// How far after the newest event of the trace one of this line can begin, nanoseconds.
    lag: i64,
    waiting: VecDeque<TimedValue>,
    /// No later event of the line begins before this.
    reached: i64,
    /// The latest end and the greatest place of those that were taken.
    taken: Option<(i64, u64)>,
    level: Option<bool>,
}

impl PositionTrack {
    /// Nothing seen yet. Each line has its slack and its lag; the second one may be left out where one is enough.
    pub fn new(carried: PulseEncoding, first: (f64, i64), second: Option<(f64, i64)>) -> PositionTrack {
        let line = |(slack, lag): (f64, i64), edge| TrackLine {
            finder: EdgeFinder::new(edge, slack),
            lag,
            waiting: VecDeque::with_capacity(WAITING + 1),
            reached: if second.is_some() { i64::MIN } else { i64::MAX },
            taken: None,
            level: None,
        };
        let edges = match carried {
            PulseEncoding::Pulses | PulseEncoding::Backwards => [CountedEdge::Rises, CountedEdge::Rises],
            PulseEncoding::Direction { .. } => [CountedEdge::Rises, CountedEdge::Changes],
            PulseEncoding::Quadrature | PulseEncoding::Number | PulseEncoding::Read => {
                [CountedEdge::Changes, CountedEdge::Changes]
            }
        };
        let [one, other] = edges;
        let used = 1 + usize::from(second.is_some());
        PositionTrack { carried, used, lines: [line(first, one), line(second.unwrap_or((0.0, 0)), other)] }
    }

    /// The next event of a line.
    #[inline]
    pub fn see(&mut self, slot: usize, seen: &TimedValue, mut out: impl FnMut(TrackStep)) {
        match self.carried {
            PulseEncoding::Pulses | PulseEncoding::Number => return self.take(0, seen, false, &mut out),
            PulseEncoding::Read => return self.take(0, &TimedValue { a: seen.b, ..*seen }, false, &mut out),
            PulseEncoding::Direction { .. } | PulseEncoding::Backwards | PulseEncoding::Quadrature => {}
        }
        for line in &mut self.lines {
            line.reached = line.reached.max(seen.a.saturating_sub(line.lag));
        }
        let Some(line) = self.lines.get_mut(slot) else { return };
        line.reached = line.reached.max(seen.a);
        line.waiting.push_back(*seen);
        self.advance(false, &mut out);
    }

    /// Nothing comes any more.
    pub fn finish(&mut self, mut out: impl FnMut(TrackStep)) {
        self.advance(true, &mut out);
        // A line that was never observed is not known all along.
        for rest in self.lines[..self.used].iter().filter_map(|line| line.finder.rest()) {
            out(TrackStep::Unknown(TimedValue { place: LAST, ..rest.seen }));
        }
    }

    fn advance(&mut self, over: bool, out: &mut impl FnMut(TrackStep)) {
        loop {
            let fronts = [0, 1].map(|slot| self.lines[slot].waiting.front().copied());
            let slot = match fronts {
                [None, None] => return,
                [Some(_), None] => 0,
                [None, Some(_)] => 1,
                [Some(first), Some(second)] => usize::from((second.a, second.place) < (first.a, first.place)),
            };
            let (Some(seen), other) = (fronts[slot], fronts[1 - slot]) else { return };
            let full = self.lines[slot].waiting.len() > WAITING;
            let settled = other.is_some() || self.lines[1 - slot].reached > seen.b;
            if !over && !settled && !full {
                return;
            }
            let apart =
                |b: i64, place: u64, next: &TimedValue| b < next.a || b == next.a && place < next.place;
            let before = self.lines[1 - slot].taken.is_none_or(|(b, place)| apart(b, place, &seen));
            let after = other.is_none_or(|other| apart(seen.b, seen.place, &other));
            self.lines[slot].waiting.pop_front();
            self.take(slot, &seen, !before || !after || (full && !settled), out);
        }
    }

    /// Takes an event in its turn. `blurred`: it may come before or after one of the other line.
    fn take(&mut self, slot: usize, seen: &TimedValue, blurred: bool, out: &mut impl FnMut(TrackStep)) {
        let line = &mut self.lines[slot];
        let taken = line.taken.unwrap_or((i64::MIN, 0));
        line.taken = Some((taken.0.max(seen.b), taken.1.max(seen.place)));
        let old = line.finder.value();
        let found = line.finder.see(seen);
        line.level = match seen.value {
            Value::Unknown => None,
            value => Some(matches!(value, Value::Bool(true))),
        };
        let Some(found) = found else { return };
        if !found.certain {
            // Of a line of direction the level counts, whatever it was before.
            if !(matches!(self.carried, PulseEncoding::Direction { .. }) && slot == 1) {
                out(TrackStep::Unknown(found.seen));
            }
            return;
        }
        const BOTH: ((u64, u64), (u64, u64)) = ((0, 1), (0, 1));
        const UP: ((u64, u64), (u64, u64)) = ((1, 1), (0, 0));
        const DOWN: ((u64, u64), (u64, u64)) = ((0, 0), (1, 1));
        let way = |up: bool| if up { UP } else { DOWN };
        let (up, down) = match (self.carried, slot) {
            (PulseEncoding::Direction { .. }, 1) => return,
            (PulseEncoding::Pulses, _) | (PulseEncoding::Backwards, 0) => UP,
            (PulseEncoding::Backwards, _) => DOWN,
            (PulseEncoding::Direction { inverted }, _) => match self.lines[1].level {
                Some(level) if !blurred => way(level != inverted),
                _ => BOTH,
            },
            (PulseEncoding::Quadrature, _) => match (self.lines[0].level, self.lines[1].level) {
                // After an edge of A going first the levels differ, after one of B they are alike.
                (Some(a), Some(b)) if !blurred => way((a != b) == (slot == 0)),
                _ => BOTH,
            },
            (PulseEncoding::Number | PulseEncoding::Read, _) => {
                match (old.and_then(Value::as_int), seen.value.as_int()) {
                    (Some(old), Some(new)) => {
                        let by = |by: i128| u64::try_from(by).unwrap_or(0);
                        let (up, down) = (by(new - old), by(old - new));
                        ((up, up), (down, down))
                    }
                    _ => return out(TrackStep::Unknown(*seen)),
                }
            }
        };
        out(TrackStep::Count(PositionChange { seen: *seen, up, down, blurred }));
    }
}
