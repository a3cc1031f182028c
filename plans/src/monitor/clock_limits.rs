//! Limits of times where the clock that stamped the trace may be off.
//!
//! All stamps are of one clock, so their order is certain, and of a time between two of them a part is wrong that is the same
//! for all. The durations of a plan are true time. So a limit may lie elsewhere in the clock's time by that part of itself, and
//! nothing else changes: a claim is judged by its limits at their loosest and at their strictest. What holds at the strictest holds
//! by every clock, and what does not at the loosest by none.

use signal::{ClockError, Span};

use super::{Extent, Finding, Monitor, Number, NumberLimits, TimedValue};

/// At which end limits are taken that the clock leaves open.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum LimitEnd {
    /// The widest: what does not keep to them fails.
    #[default]
    Loosest,
    /// The narrowest: what keeps to them passes.
    Strictest,
}

/// How the limits of a claim are taken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ClockLimits {
    /// What the clock may be off.
    pub(crate) error: ClockError,
    /// Which end of each limit is meant.
    pub(crate) end: LimitEnd,
}

impl ClockLimits {
    /// Least and greatest time, nanoseconds; `i64::MAX` is no limit.
    pub(crate) fn spans(self, (least, most): (i64, i64)) -> (i64, i64) {
        (self.moved(least, false), self.moved(most, true))
    }

    /// A greatest time, nanoseconds.
    pub(crate) fn most(self, most: i64) -> i64 {
        self.moved(most, true)
    }

    fn moved(self, limit: i64, greatest: bool) -> i64 {
        if limit == i64::MAX {
            return limit;
        }
        let off = self.error.of(Span::from_nanos(limit)).as_nanos();
        if greatest == (self.end == LimitEnd::Loosest) {
            limit.saturating_add(off)
        } else {
            limit.saturating_sub(off)
        }
    }

    /// Limits of a figure that is a time, or one by a time such as a frequency.
    pub(crate) fn figures(self, limits: NumberLimits) -> NumberLimits {
        self.widened(limits, |limit| by_clock(self.error, (limit, limit)))
    }

    /// Limits of how far something stands off a grid of true time, above 0: by what the clock is off in so many nanoseconds.
    pub(crate) fn of_true_grid(self, limits: NumberLimits, wanders_over: i64) -> NumberLimits {
        let off = Number::Int(i128::from(self.error.of(Span::from_nanos(wanders_over)).as_nanos()));
        self.widened(limits, |limit| match limit.is_above(Number::ZERO) {
            true => (limit.minus(off), limit.plus(off)),
            false => (limit, limit.plus(off)),
        })
    }

    fn widened(self, limits: NumberLimits, extent: impl Fn(Number) -> Extent + Copy) -> NumberLimits {
        let outward = self.end == LimitEnd::Loosest;
        NumberLimits {
            min: limits.min.map(extent).map(|(low, high)| if outward { low } else { high }),
            max: limits.max.map(extent).map(|(low, high)| if outward { high } else { low }),
        }
    }
}

/// A figure that is a time, or one by a time, with what the clock may be off. Rounded outwards.
pub(crate) fn by_clock(error: ClockError, (low, high): Extent) -> Extent {
    if error.is_none() {
        return (low, high);
    }
    let off = |near: f64| (near.abs() * error.part()).next_up();
    let (least, most) = (low.reals().0, high.reals().1);
    // Nothing is the same by every clock, and what has no end has none.
    let moves = |near: f64| near != 0.0 && near.is_finite();
    let low = if moves(least) { Number::Real((least - off(least)).next_down()) } else { low };
    let high = if moves(most) { Number::Real((most + off(most)).next_up()) } else { high };
    (low, high)
}

/// A claim at both ends of its limits.
pub(crate) struct BothEnds {
    pub(crate) loosest: Box<dyn Monitor>,
    pub(crate) strictest: Box<dyn Monitor>,
}

impl Monitor for BothEnds {
    fn feed(&mut self, slot: usize, seen: &TimedValue) {
        self.loosest.feed(slot, seen);
        self.strictest.feed(slot, seen);
    }

    fn lost(&mut self, now: i64) -> bool {
        self.loosest.lost(now)
    }

    fn finish(self: Box<Self>) -> Finding {
        let (loosest, strictest) = (self.loosest.finish(), self.strictest.finish());
        if !loosest.can_hold {
            return loosest;
        }
        let reason = match strictest.can_hold {
            // Open by the instants alone, or not open.
            true => strictest.reason.clone(),
            false => String::from("a limit lies within what the clock may be off"),
        };
        Finding {
            can_hold: true,
            can_break: strictest.can_break || !strictest.can_hold,
            beyond_help: loosest.beyond_help,
            // What decides lies in the window at its widest.
            window: loosest.window,
            reason,
            ..strictest
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_move_by_their_part_and_never_inwards_too_little() {
        let error = ClockError::from_parts(100_000_000).unwrap();
        let at = |end| ClockLimits { error, end };
        let limits = (1_000_000_000, 2_000_000_000);
        assert_eq!(at(LimitEnd::Loosest).spans(limits), (999_899_989, 2_000_200_021));
        assert_eq!(at(LimitEnd::Strictest).spans(limits), (1_000_100_011, 1_999_799_979));
        assert_eq!(at(LimitEnd::Strictest).spans((0, i64::MAX)), (0, i64::MAX));
        assert_eq!(ClockLimits::default().spans(limits), limits);
        let hertz = NumberLimits { min: Some(Number::Real(49.0)), max: Some(Number::Int(51)) };
        let loose = at(LimitEnd::Loosest).figures(hertz);
        let (min, max) = (loose.min.unwrap().as_real(), loose.max.unwrap().as_real());
        assert!(min < 49.0 / 1.0001 && min > 48.99 && max >= 51.0 * 1.0001, "{min} {max}");
    }
}
