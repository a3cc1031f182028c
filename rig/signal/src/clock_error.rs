//! How far a clock may be off, and what follows for the instants and durations that it measured.

use crate::{Span, Time, When};

/// The parts that a relative error is counted in.
const PARTS: u64 = 1_000_000_000_000;

/// The relative error of the rate of a clock, either way: a part of the time that it shows. By default there is none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct ClockError(u64);

impl ClockError {
    /// A clock that is right.
    pub const NONE: ClockError = ClockError(0);

    /// The greatest there is: 10 %. Beyond it there is no clock.
    pub const MAX: ClockError = ClockError(PARTS / 10);

    /// So many parts of 10^12 (25 ppm is 25 000 000); `None` above [`ClockError::MAX`].
    pub fn from_parts(parts: u64) -> Option<ClockError> {
        (parts <= ClockError::MAX.0).then_some(ClockError(parts))
    }

    /// Whether the clock is right.
    pub const fn is_none(self) -> bool {
        self.0 == 0
    }

    /// In parts of 10^12.
    pub const fn parts(self) -> u64 {
        self.0
    }

    /// The part of what the clock shows that may be wrong, not less than it is.
    pub fn part(self) -> f64 {
        if self.is_none() { 0.0 } else { (self.0 as f64 / (PARTS - self.0) as f64).next_up() }
    }

    /// How far a time that the clock showed may be off, either way, rounded up; at least 0. A clock that is fast by a part `e`
    /// shows `1 + e` for each second, so of what it shows a part of at most `e / (1 - e)` is wrong.
    pub fn of(self, shown: Span) -> Span {
        self.between(shown.as_nanos(), 0)
    }

    /// An instant as it may lie when the clock is off since `reference`, which itself may be anywhere in its interval.
    #[must_use]
    pub fn drifted(self, at: When, reference: When) -> When {
        if self.is_none() {
            return at;
        }
        let farthest = |end: Time| {
            let of = |start: Time| self.between(end.as_nanos(), start.as_nanos());
            of(reference.earliest).max(of(reference.latest))
        };
        let (before, after) = (farthest(at.earliest), farthest(at.latest));
        When::within(at.earliest.saturating_add(-before), at.latest.saturating_add(after))
    }

    /// How far the time between two stamps may be off.
    fn between(self, one: i64, other: i64) -> Span {
        let rate = i128::from(self.0);
        let rest = i128::from(PARTS) - rate;
        let distance = (i128::from(one) - i128::from(other)).abs();
        i64::try_from((distance * rate + rest - 1) / rest).map_or(Span::MAX, Span::from_nanos)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn at(earliest: i64, latest: i64) -> When {
        When::within(Time::from_nanos(earliest), Time::from_nanos(latest))
    }

    #[test]
    fn a_clock_is_off_by_a_part_of_the_time_since_the_reference() {
        const S: i64 = 1_000_000_000;
        let ppm = ClockError::from_parts(100_000_000).unwrap();
        let of = |one, other| ppm.drifted(at(one, one), at(other, other));
        // 100 ppm of 10 s is 1 ms; a clock that is fast by it shows 1 ms / 0.9999 too much: 1 000 100.01 ns.
        assert_eq!(of(12 * S, 2 * S), at(12 * S - 1_000_101, 12 * S + 1_000_101));
        // Before the reference as well.
        assert_eq!(of(2 * S, 12 * S), at(2 * S - 1_000_101, 2 * S + 1_000_101));
        assert_eq!(of(2 * S, 2 * S), at(2 * S, 2 * S));
        // A reference that may be earlier makes the distance longer.
        let latest = ppm.drifted(at(10 * S, 10 * S), at(0, 5 * S)).latest;
        assert_eq!(latest, Time::from_nanos(10 * S + 1_000_101));
        assert_eq!(ppm.of(Span::from_secs(10)), Span::from_nanos(1_000_101));
        assert_eq!(ClockError::MAX.between(i64::MIN, i64::MAX), Span::from_nanos(2_049_638_230_412_172_402));
        assert_eq!(ClockError::from_parts(PARTS / 10 + 1), None);
        assert_eq!(ClockError::NONE.drifted(at(3, 4), at(0, 0)), at(3, 4));
    }

    proptest! {
        // What the clock showed of a true time is within what is made of it.
        #[test]
        fn the_true_time_is_within(time in 0..1_000_000_000_000i64, rate in 0..=ClockError::MAX.0, part in -1.0..=1.0f64) {
            let parts = (rate as f64 * part) as i128;
            let shown = (i128::from(time) * (i128::from(PARTS) + parts) / i128::from(PARTS)) as i64;
            // What it shows is cut to a nanosecond.
            let known = ClockError(rate).drifted(at(shown, shown + 1), at(0, 0));
            prop_assert!(known.earliest.as_nanos() <= time && time <= known.latest.as_nanos(), "{known:?}");
        }

        // What came in one order stays in it: neither end of a later instant lies before that of an earlier one.
        #[test]
        fn instants_keep_their_order(one in 0..10_000_000i64, more in 0..10_000i64, from in 0..10_000_000i64, rate in 0..=ClockError::MAX.0) {
            let drifted = |time| ClockError(rate).drifted(at(time, time), at(from, from));
            let (one, other) = (drifted(one), drifted(one + more));
            prop_assert!(one.earliest <= other.earliest && one.latest <= other.latest, "{one:?} {other:?}");
        }
    }
}
