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

    /// The part of a true time by which what the clock shows of it may be more or less, `e`; not less than it is.
    pub fn part_of_true(self) -> f64 {
        if self.is_none() { 0.0 } else { (self.0 as f64 / PARTS as f64).next_up() }
    }

    /// The parts of what the clock shows by which the true time may be less, `e / (1 + e)`, and more, `e / (1 - e)`; not less than
    /// they are.
    pub fn parts_of_shown(self) -> (f64, f64) {
        let part = |rest: u64| (self.0 as f64 / rest as f64).next_up();
        if self.is_none() { (0.0, 0.0) } else { (part(PARTS + self.0), part(PARTS - self.0)) }
    }

    /// How far what the clock shows of a true time may be off, either way, rounded up; at least 0. A clock that is fast by a part
    /// `e` shows `1 + e` for each second.
    pub fn of_true(self, time: Span) -> Span {
        self.part(time.as_nanos(), PARTS)
    }

    /// How far a time that the clock showed may be off, either way, rounded up; at least 0. It shows `1 + e` for each second, so
    /// of what it shows a part of at most `e / (1 - e)` is wrong.
    pub fn of(self, shown: Span) -> Span {
        self.between(shown.as_nanos(), 0)
    }

    /// The true time between two stamps, at least and at most, where the clock showed it from `least` to `most`, nanoseconds.
    pub fn true_times(self, (least, most): (i64, i64)) -> (i64, i64) {
        let (fast, slow) = (PARTS + self.0, PARTS - self.0);
        let off = |time: i64, rest: u64| self.part(time, rest).as_nanos();
        let down = off(least, if least < 0 { slow } else { fast });
        let up = off(most, if most < 0 { fast } else { slow });
        (least.saturating_sub(down), most.saturating_add(up))
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
        self.part_of((i128::from(one) - i128::from(other)).abs(), PARTS - self.0)
    }

    fn part(self, time: i64, of: u64) -> Span {
        self.part_of(i128::from(time).abs(), of)
    }

    /// The error's share, of so many parts, in a time of at least 0; rounded up.
    fn part_of(self, time: i128, of: u64) -> Span {
        let of = i128::from(of);
        let part = (time * i128::from(self.0) + of - 1) / of;
        i64::try_from(part).map_or(Span::MAX, Span::from_nanos)
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
        // 10 s / 1.0001 and 10 s / 0.9999.
        assert_eq!(ppm.true_times((10 * S, 10 * S)), (9_999_000_099, 10_001_000_101));
        assert_eq!(ppm.true_times((-10 * S, -10 * S)), (-10_001_000_101, -9_999_000_099));
        assert_eq!(ppm.of_true(Span::from_secs(-10)), Span::from_nanos(1_000_000));
        assert_eq!(ClockError::MAX.of_true(Span::MAX).as_nanos(), i64::MAX / 10 + 1);
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
            let off = (shown - time).abs();
            prop_assert!(off <= ClockError(rate).of_true(Span::from_nanos(time)).as_nanos() + 1, "{off}");
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
