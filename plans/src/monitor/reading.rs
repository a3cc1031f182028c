//! The value of a signal at an instant: every value that some placement gives it.

use signal::Value;

use super::{TimedValue, UncertainInstant};

/// Most values that are kept; a signal that changes more often around an uncertain instant is not known.
const MOST: usize = 64;

/// A value that the signal can have at the instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    /// The change that gave it.
    pub seen: TimedValue,
    /// The placements of the instant that have it, both included, nanoseconds.
    pub low: i64,
    /// See `low`.
    pub high: i64,
}

/// Reads a signal at one instant.
#[derive(Clone, Debug)]
pub struct ValueReader {
    point: UncertainInstant,
    last: Option<TimedValue>,
    found: Vec<Candidate>,
    overflow: bool,
}

impl ValueReader {
    /// Nothing is known of the signal before its first event.
    pub fn new(point: UncertainInstant) -> Self {
        ValueReader { point: point.for_reading(), last: None, found: Vec::new(), overflow: false }
    }

    /// The next event.
    #[inline]
    pub fn see(&mut self, seen: &TimedValue) {
        self.until(seen.after(&self.point));
        self.last = Some(*seen);
    }

    /// The last value holds for instants up to `right`.
    fn until(&mut self, right: i64) {
        let seen = self.last.unwrap_or(TimedValue::NOTHING);
        let low = self.point.a.max(self.last.map_or(i64::MIN, |last| last.before(&self.point)));
        let high = self.point.b.min(right);
        if low > high {
            return;
        }
        if self.found.len() < MOST {
            self.found.push(Candidate { seen, low, high });
        } else {
            self.overflow = true;
        }
    }

    /// Whether the instant is over in every placement.
    pub fn is_past(&self) -> bool {
        self.last.is_some_and(|seen| seen.before(&self.point) > self.point.b)
    }

    /// The values when nothing comes any more, in the order of the trace.
    pub fn finish(mut self) -> Vec<Candidate> {
        self.until(i64::MAX);
        if self.overflow {
            let seen = TimedValue { value: Value::Unknown, ..self.found[0].seen };
            self.found.push(Candidate { seen, low: self.point.a, high: self.point.b });
        }
        self.found
    }
}
