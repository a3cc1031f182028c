//! The time bases that programs and plans can read (controller:SYS-05): bits that are TRUE in the second half of
//! each period, counted from the end of the boot.

use profile::PlcRead;
use signal::{Span, Time};

/// The bits with their periods.
const BITS: [(PlcRead, Span); 3] = [
    (PlcRead::Clock10Ms, Span::from_millis(10)),
    (PlcRead::Clock100Ms, Span::from_millis(100)),
    (PlcRead::Clock1S, Span::from_secs(1)),
];

/// The time bases. Their edges are events only while somebody looks at one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Clocks {
    origin: Time,
    /// The edges up to here have come.
    at: Time,
    /// Half the shortest period that is looked at.
    half: Option<Span>,
}

impl Default for Clocks {
    fn default() -> Self {
        Clocks { origin: Time::ZERO, at: Time::ZERO, half: None }
    }
}

fn half(period: Span) -> Span {
    Span::from_nanos(period.as_nanos() / 2)
}

impl Clocks {
    /// Periods begin at `now`.
    pub(crate) fn begin(&mut self, now: Time) {
        (self.origin, self.at) = (now, now);
    }

    /// The level of a bit at `now`, or where its edges have come to if that is later.
    pub(crate) fn level(&self, bit: PlcRead, now: Time) -> bool {
        let period = BITS.iter().find(|(known, _)| *known == bit).map(|(_, period)| *period);
        let passed = (now.max(self.at) - self.origin).as_nanos();
        period.is_some_and(|period| passed / half(period).as_nanos() % 2 == 1)
    }

    /// The next edge of a bit that is looked at.
    #[inline]
    pub(crate) fn next(&self) -> Time {
        let Some(half) = self.half else { return Time::MAX };
        let passed = (self.at - self.origin).as_nanos() / half.as_nanos();
        self.origin.saturating_add(Span::from_nanos((passed + 1).saturating_mul(half.as_nanos())))
    }

    /// The edges come of the bits that somebody looks at, from `now` on.
    pub(crate) fn observe(&mut self, now: Time, observed: impl Fn(PlcRead) -> bool) {
        let shortest = BITS.iter().find(|(bit, _)| observed(*bit));
        let half = shortest.map(|(_, period)| half(*period));
        if self.half != half {
            self.half = half;
            self.at = self.at.max(now);
        }
    }

    /// The edges up to `now` have come.
    pub(crate) fn fire(&mut self, now: Time) {
        self.at = now;
    }
}
