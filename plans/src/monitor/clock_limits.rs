//! Limits of times where the clock that stamped the trace may be off.
//!
//! All stamps are of one clock, so their order is certain, and of a time between two of them a part is wrong that is the same
//! for all. The durations of a plan are true time, and a clock whose rate is off by at most `e` shows between `1 - e` and `1 + e` of
//! each. So a limit of a time lies elsewhere in the clock's time by that part of itself, one of a rate is divided by it, and
//! nothing else changes: a claim is judged by its limits at their loosest and at their strictest. What holds at the strictest holds
//! by every clock, and what does not at the loosest by none.
//!
//! What was measured goes the other way: a time that the clock showed is divided, a rate by it multiplied.

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

/// How a figure depends on the clock that it was taken by.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum ClockedFigure {
    /// It is a time.
    #[default]
    Time,
    /// It is what comes in a time.
    Rate,
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
        let off = self.error.of_true(Span::from_nanos(limit)).as_nanos();
        if greatest == (self.end == LimitEnd::Loosest) {
            limit.saturating_add(off)
        } else {
            limit.saturating_sub(off)
        }
    }

    /// Limits of a figure that is a time, or one by a time such as a frequency.
    pub(crate) fn figures(self, limits: NumberLimits, figure: ClockedFigure) -> NumberLimits {
        self.widened(limits, |limit| match figure {
            ClockedFigure::Time => multiplied(self.error, (limit, limit)),
            ClockedFigure::Rate => divided(self.error, (limit, limit)),
        })
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

/// A figure that is a time, or one by a time, as it truly may be where the clock showed this. Rounded outwards.
pub(crate) fn true_figure(error: ClockError, shown: Extent, figure: ClockedFigure) -> Extent {
    match figure {
        ClockedFigure::Time => divided(error, shown),
        ClockedFigure::Rate => multiplied(error, shown),
    }
}

/// From `1 - e` to `1 + e` of a figure.
fn multiplied(error: ClockError, extent: Extent) -> Extent {
    let part = error.part_of_true();
    moved(error, extent, (part, part))
}

/// A figure divided by `1 + e` to `1 - e`.
fn divided(error: ClockError, extent: Extent) -> Extent {
    moved(error, extent, error.parts_of_shown())
}

/// A figure that may be nearer to 0, and farther from it, by these parts of itself.
fn moved(error: ClockError, (low, high): Extent, (nearer, farther): (f64, f64)) -> Extent {
    if error.is_none() {
        return (low, high);
    }
    let off = |figure: f64, part: f64| (figure.abs() * part).next_up();
    let (least, most) = (low.reals().0, high.reals().1);
    let down = off(least, if least < 0.0 { farther } else { nearer });
    let up = off(most, if most < 0.0 { nearer } else { farther });
    // Nothing is the same by every clock, and what has no end has none.
    let moves = |near: f64| near != 0.0 && near.is_finite();
    let low = if moves(least) { Number::Real((least - down).next_down()) } else { low };
    let high = if moves(most) { Number::Real((most + up).next_up()) } else { high };
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
        assert_eq!(at(LimitEnd::Loosest).spans(limits), (999_900_000, 2_000_200_000));
        assert_eq!(at(LimitEnd::Strictest).spans(limits), (1_000_100_000, 1_999_800_000));
        assert_eq!(at(LimitEnd::Strictest).spans((0, i64::MAX)), (0, i64::MAX));
        assert_eq!(ClockLimits::default().spans(limits), limits);
        let hertz = NumberLimits { min: Some(Number::Real(49.0)), max: Some(Number::Int(51)) };
        let near = |found: NumberLimits, (min, max): (f64, f64)| {
            let found = (found.min.unwrap().as_real(), found.max.unwrap().as_real());
            assert!((found.0 - min).abs() < 1e-12 && (found.1 - max).abs() < 1e-12, "{found:?} {min} {max}");
            found
        };
        let of = |end, figure| at(end).figures(hertz, figure);
        // What comes so often in a true second comes less often in one of a clock that is fast.
        let rates = (49.0 / 1.0001, 51.0 / 0.9999);
        let found = near(of(LimitEnd::Loosest, ClockedFigure::Rate), rates);
        assert!(found.0 < rates.0 && found.1 > rates.1);
        near(of(LimitEnd::Strictest, ClockedFigure::Rate), (49.0 / 0.9999, 51.0 / 1.0001));
        near(of(LimitEnd::Loosest, ClockedFigure::Time), (49.0 * 0.9999, 51.0 * 1.0001));
        near(of(LimitEnd::Strictest, ClockedFigure::Time), (49.0 * 1.0001, 51.0 * 0.9999));
    }

    #[test]
    fn what_was_measured_goes_the_other_way() {
        let error = ClockError::MAX;
        let of = |low: f64, high: f64, figure| {
            let found = true_figure(error, (Number::Real(low), Number::Real(high)), figure);
            (found.0.as_real(), found.1.as_real())
        };
        let near = |found: (f64, f64), wanted: (f64, f64)| {
            assert!(found.0 <= wanted.0 && wanted.0 - found.0 < 1e-12, "{found:?} {wanted:?}");
            assert!(found.1 >= wanted.1 && found.1 - wanted.1 < 1e-12, "{found:?} {wanted:?}");
        };
        near(of(2.0, 3.0, ClockedFigure::Time), (2.0 / 1.1, 3.0 / 0.9));
        near(of(2.0, 3.0, ClockedFigure::Rate), (1.8, 3.3));
        // Below 0 it is the least that is farthest from it.
        near(of(-2.0, -1.0, ClockedFigure::Time), (-2.0 / 0.9, -1.0 / 1.1));
    }
}
