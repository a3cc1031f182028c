//! Keeps the edges of pulses apart when the rig is late with them.
//!
//! Of outputs that carry pulses every edge is driven: in the order in which they were asked for, each in a call of its
//! own. What is late catches up, but not at once: an edge comes no sooner after the one before it than two thirds of the
//! time that lay between the two when they were asked for, and on its own line no sooner than a quarter of the shortest
//! period that the board file promises, or a millisecond if that is less. So a pulse that is late stays a pulse, and A
//! and B of an encoder keep their order.

use host::HostInstant;
use signal::Span;

/// An edge keeps this much of its distance from the one before it, as a fraction.
const KEPT: (i64, i64) = (2, 3);
/// The longest that a level is kept for the sake of a promise: all outputs of the chip wait for it.
const LONGEST: Span = Span::from_millis(1);

/// When the outputs of a chip that carry pulses may turn.
#[derive(Debug)]
pub(super) struct PulsePace {
    /// Outputs that carry pulses.
    timed: u64,
    /// The shortest level of each.
    shortest: [Span; 64],
    /// Since when each has its level.
    since: [HostInstant; 64],
    /// When the last edge of them was asked for, and when it was driven.
    last: Option<(HostInstant, HostInstant)>,
}

impl PulsePace {
    /// For outputs that promise pulses of so many Hz, by place; 0 for none.
    pub(super) fn new(promises: impl Iterator<Item = u64>) -> PulsePace {
        let mut pace =
            PulsePace { timed: 0, shortest: [Span::ZERO; 64], since: [HostInstant::BOOT; 64], last: None };
        for (place, hz) in promises.take(64).enumerate().filter(|(_, hz)| *hz > 0) {
            pace.timed |= 1 << place;
            let quarter = Span::from_nanos(1_000_000_000 / i64::try_from(hz).unwrap_or(i64::MAX) / 4);
            pace.shortest[place] = quarter.min(LONGEST);
        }
        pace
    }

    /// Outputs that carry pulses.
    pub(super) const fn timed(&self) -> u64 {
        self.timed
    }

    /// Whether one of these outputs carries pulses.
    pub(super) const fn times(&self, flips: u64) -> bool {
        flips & self.timed != 0
    }

    /// Nothing was driven before.
    pub(super) fn begin(&mut self) {
        (self.since, self.last) = ([HostInstant::BOOT; 64], None);
    }

    /// When an image that was asked for at `asked`, and turns these outputs, may be driven.
    pub(super) fn due(&self, flips: u64, asked: HostInstant) -> HostInstant {
        let mut timed = flips & self.timed;
        let mut due = match self.last {
            Some((before, driven)) if timed != 0 => {
                let apart = (asked - before).max(Span::ZERO).as_nanos();
                driven + Span::from_nanos(apart / KEPT.1 * KEPT.0)
            }
            _ => HostInstant::BOOT,
        };
        while timed != 0 {
            let place = timed.trailing_zeros() as usize;
            timed &= timed - 1;
            due = due.max(self.since[place] + self.shortest[place]);
        }
        due
    }

    /// These outputs were turned by then, as it was asked for at `asked`.
    pub(super) fn drove(&mut self, flips: u64, asked: HostInstant, driven: HostInstant) {
        let mut timed = flips & self.timed;
        while timed != 0 {
            let place = timed.trailing_zeros() as usize;
            timed &= timed - 1;
            self.since[place] = driven;
        }
        self.last = Some((asked, driven));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const A: u64 = 1;
    const B: u64 = 1 << 63;

    fn at(nanos: i64) -> HostInstant {
        HostInstant::from_nanos(nanos)
    }

    /// 1 kHz on A and B, nothing promised of the others.
    fn pace() -> PulsePace {
        PulsePace::new((0..64).map(|place| if place == 0 || place == 63 { 1_000 } else { 0 }))
    }

    #[test]
    fn edges_that_are_late_keep_two_thirds_of_their_distance() {
        let mut pace = pace();
        assert!(pace.due(A, at(1_000_000)) <= at(1_000_000));
        // Half a millisecond late: the next one was asked for 600 us after it.
        pace.drove(A, at(1_000_000), at(1_500_000));
        assert_eq!(pace.due(A, at(1_600_000)), at(1_900_000));
        assert_eq!(pace.due(B, at(1_600_000)), at(1_900_000));
        // What carries no pulses waits for nothing.
        assert_eq!(pace.due(2, at(1_600_000)), HostInstant::BOOT);
        // On time again.
        pace.drove(A, at(1_600_000), at(1_900_000));
        assert!(pace.due(A, at(3_000_000)) < at(3_000_000));
    }

    #[test]
    fn a_level_lasts_a_quarter_of_the_promised_period_whoever_asked_for_less() {
        let mut pace = pace();
        pace.drove(A, at(10_000_000), at(10_005_000));
        assert_eq!(pace.due(A, at(10_000_000)), at(10_005_000 + 250_000));
        // The other line has its own levels.
        assert_eq!(pace.due(B, at(10_000_000)), at(10_005_000));
        pace.begin();
        assert!(pace.due(A, at(10_000_000)) <= at(10_000_000));
    }
}
