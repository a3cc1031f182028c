//! How fast a number changes over a window: by how much it differs between the two ends, per second.

use super::reading::{Candidate, ValueReader};
use super::{Extent, Number, TimedValue, UncertainWindow, widened};

/// Least and greatest change per second of all placements, and what it was made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedResult {
    /// Changes per second.
    pub(crate) speed: Extent,
    /// Least and greatest change.
    pub(crate) change: Extent,
    /// The last event before the end of the window.
    pub last: Option<TimedValue>,
}

/// Follows one signal.
#[derive(Clone, Debug)]
pub struct SpeedFollower {
    length: (i64, i64),
    from: ValueReader,
    until: ValueReader,
}

impl SpeedFollower {
    /// Over this window, which lasts for at least and at most so many nanoseconds.
    pub fn new(window: UncertainWindow, length: (i64, i64)) -> SpeedFollower {
        SpeedFollower { length, from: ValueReader::new(window.from), until: ValueReader::new(window.until) }
    }

    /// The next event.
    #[inline]
    pub fn see(&mut self, seen: &TimedValue) {
        self.from.see(seen);
        self.until.see(seen);
    }

    /// What came of it; `None` where the number is not known at one of the ends, or the window may have no length. Each value
    /// may be off by `slack`.
    ///
    /// While a number goes from one value to the next it may be any between the two, and every placement of both ends is
    /// taken with every value of both: the extent may be too wide, never too narrow.
    pub fn finish(self, slack: f64) -> Option<SpeedResult> {
        let SpeedFollower { length, from, until } = self;
        let until = until.finish();
        let last = until.last().map(|candidate| candidate.seen);
        let from = from.finish();
        let (begin, end) = (extent(&from, slack)?, extent(&until, slack)?);
        let change = (end.0.minus(begin.1), end.1.minus(begin.0));
        let (Ok(short @ 1..), Ok(long)) = (u64::try_from(length.0), u64::try_from(length.1)) else {
            return None;
        };
        // A change down is fastest, and so least, in the shorter time.
        let low = per_second(change.0, if change.0.is_below(Number::ZERO) { short } else { long });
        let high = per_second(change.1, if change.1.is_below(Number::ZERO) { long } else { short });
        Some(SpeedResult { speed: (low, high), change, last })
    }
}

/// A change in so many nanoseconds, per second; exact for counts.
fn per_second(change: Number, nanos: u64) -> Number {
    match change {
        Number::Int(counts) => match counts.checked_mul(1_000_000_000) {
            Some(over) => Number::quotient(over, nanos),
            None => Number::Real(counts as f64 * 1e9 / nanos as f64),
        },
        change => Number::Real(change.as_real() / (nanos as f64 / 1e9)),
    }
}

/// Least and greatest number of some candidates; `None` where one is not known.
fn extent(candidates: &[Candidate], slack: f64) -> Option<Extent> {
    let mut extent = None;
    for candidate in candidates {
        let value = candidate.seen.value;
        let number = Number::of(value).filter(|number| number.as_real().is_finite())?;
        let off = Number::Real(slack + value.uncertainty());
        extent = Some(widened(extent, (number.minus(off), number.plus(off))));
    }
    extent
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use signal::{Cause, Event, SignalId, Span, Time, Value, When};

    use crate::monitor::UncertainInstant;

    fn event(a: i64, b: i64, value: i64, place: u64) -> TimedValue {
        let at = When::within(Time::from_nanos(a), Time::from_nanos(b));
        let event = Event { signal: SignalId(0), at, value: Value::Int(value), cause: Cause::Board };
        TimedValue::of(&event, a, b, place)
    }

    fn point(a: i64, b: i64, base: u32) -> UncertainInstant {
        let at = When::within(Time::from_nanos(a), Time::from_nanos(b));
        UncertainInstant::new(at, 100, base, Span::from_nanos(1))
    }

    proptest! {
        /// Wherever events and ends lie within their intervals, the speed lies within what is found; where all of them are
        /// exact it is that.
        #[test]
        fn no_placement_has_a_speed_beyond_what_is_reported(
            steps in prop::collection::vec((1i64..6, 0i64..3, -5i64..6), 1..6),
            from in (5i64..15, 0i64..3),
            until in (18i64..30, 0i64..3),
        ) {
            let (mut at, mut value) = (0, 0);
            let mut events = vec![event(0, 0, 0, 0)];
            for (place, (gap, wide, by)) in (1..).zip(steps) {
                at += gap + 3;
                value += by;
                events.push(event(at, at + wide, value, place));
            }
            let window = UncertainWindow::new(point(from.0, from.0 + from.1, 1), point(until.0, until.0 + until.1, 2)).unwrap();
            let length = (window.until.a - window.from.b, window.until.b - window.from.a);
            let mut speed = SpeedFollower::new(window, length);
            events.iter().for_each(|seen| speed.see(seen));
            let found = speed.finish(0.0).unwrap();
            // A number is any on the way from one to the next while that may be under way.
            let values = |at: i64| {
                let mut possible = Vec::new();
                for (place, seen) in events.iter().enumerate() {
                    let next = events.get(place + 1);
                    if seen.a <= at && next.is_none_or(|next| next.b > at) {
                        possible.push(seen.value.as_real().unwrap());
                    }
                }
                possible
            };
            let mut exact = Vec::new();
            for begin in window.from.a..=window.from.b {
                for end in window.until.a..=window.until.b {
                    for old in values(begin) {
                        for new in values(end) {
                            let reported = (new - old) / ((end - begin) as f64 / 1e9);
                            let (low, high) = (found.speed.0.as_real(), found.speed.1.as_real());
                            prop_assert!(low <= reported + 1e-3 && reported - 1e-3 <= high, "{reported} {found:?}");
                            exact.push(reported);
                        }
                    }
                }
            }
            if let [only] = exact[..] {
                let far = |number: Number| (number.as_real() - only).abs();
                prop_assert!(far(found.speed.0) < 1e-3 && far(found.speed.1) < 1e-3);
            }
        }
    }
}
