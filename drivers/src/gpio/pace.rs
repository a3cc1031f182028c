//! Keeps the edges of pulses apart when the rig is late with them.
//!
//! Of outputs that carry pulses every edge is driven: in the order in which they were asked for, each in a call of its
//! own. What is late catches up, but not at once: an edge comes no sooner behind the one before it than two thirds of the
//! time that lay between the two when they were asked for, and on its own line no sooner than a quarter of the shortest
//! period that the board file promises, or a millisecond if that is less. So a pulse that is late stays a pulse, and A
//! and B of an encoder keep their order.

/// An edge keeps this much of its distance from the one before it, as a fraction.
const KEPT: (i64, i64) = (2, 3);
/// The longest that a level is kept for the sake of a promise, in nanoseconds: all outputs of the chip wait for it.
const LONGEST: i64 = 1_000_000;

/// When the outputs of a chip that carry pulses may turn. Stamps are of the monotonic clock.
#[derive(Debug)]
pub(super) struct Pace {
    /// Outputs that carry pulses.
    timed: u64,
    /// The shortest level of each, in nanoseconds.
    shortest: [i64; 64],
    /// Since when each has its level.
    since: [i64; 64],
    /// When the last edge of them was asked for, and when it was driven.
    last: Option<(i64, i64)>,
}

impl Pace {
    /// For outputs that promise pulses of so many Hz, by place; 0 for none.
    pub(super) fn new(promises: impl Iterator<Item = u64>) -> Pace {
        let mut pace = Pace { timed: 0, shortest: [0; 64], since: [0; 64], last: None };
        for (place, hz) in promises.take(64).enumerate().filter(|(_, hz)| *hz > 0) {
            pace.timed |= 1 << place;
            pace.shortest[place] = 1_000_000_000 / i64::try_from(hz).unwrap_or(i64::MAX) / 4;
            pace.shortest[place] = pace.shortest[place].min(LONGEST);
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
        (self.since, self.last) = ([0; 64], None);
    }

    /// When an image that was asked for at `asked`, and turns these outputs, may be driven.
    pub(super) fn due(&self, flips: u64, asked: i64) -> i64 {
        let mut timed = flips & self.timed;
        let mut due = match self.last {
            Some((before, driven)) if timed != 0 => {
                driven.saturating_add(asked.saturating_sub(before).max(0) / KEPT.1 * KEPT.0)
            }
            _ => i64::MIN,
        };
        while timed != 0 {
            let place = timed.trailing_zeros() as usize;
            timed &= timed - 1;
            due = due.max(self.since[place].saturating_add(self.shortest[place]));
        }
        due
    }

    /// These outputs were turned by then, as it was asked for at `asked`.
    pub(super) fn drove(&mut self, flips: u64, asked: i64, driven: i64) {
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

    /// 1 kHz on A and B, nothing promised of the others.
    fn pace() -> Pace {
        Pace::new((0..64).map(|place| if place == 0 || place == 63 { 1_000 } else { 0 }))
    }

    #[test]
    fn edges_that_are_late_keep_two_thirds_of_their_distance() {
        let mut pace = pace();
        assert!(pace.due(A, 1_000_000) <= 1_000_000);
        // Half a millisecond late: the next one was asked for 600 us behind it.
        pace.drove(A, 1_000_000, 1_500_000);
        assert_eq!(pace.due(A, 1_600_000), 1_900_000);
        assert_eq!(pace.due(B, 1_600_000), 1_900_000);
        // What carries no pulses waits for nothing.
        assert_eq!(pace.due(2, 1_600_000), i64::MIN);
        // On time again.
        pace.drove(A, 1_600_000, 1_900_000);
        assert!(pace.due(A, 3_000_000) < 3_000_000);
    }

    #[test]
    fn a_level_lasts_a_quarter_of_the_promised_period_whoever_asked_for_less() {
        let mut pace = pace();
        pace.drove(A, 10_000_000, 10_005_000);
        assert_eq!(pace.due(A, 10_000_000), 10_005_000 + 250_000);
        // The other line has its own levels.
        assert_eq!(pace.due(B, 10_000_000), 10_005_000);
        pace.begin();
        assert!(pace.due(A, 10_000_000) <= 10_000_000);
    }
}
