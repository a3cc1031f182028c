//! Limits of a number: whether what was found keeps to them, and how far it stays from them.

use super::number::distance;
use super::{Number, Truth};

/// The least and the greatest number of all placements.
pub(crate) type Extent = (Number, Number);

/// The least and the greatest number that are allowed, both included; one that is missing is no limit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NumberLimits {
    /// The least that is allowed.
    pub min: Option<Number>,
    /// The greatest that is allowed.
    pub max: Option<Number>,
}

impl NumberLimits {
    /// Whether there is a limit.
    pub(crate) fn any(&self) -> bool {
        self.min.is_some() || self.max.is_some()
    }

    /// Whether no number keeps to them.
    pub(crate) fn are_reversed(&self) -> bool {
        self.min.zip(self.max).is_some_and(|(min, max)| min.is_above(max))
    }

    /// Whether a number is within them; a NaN is not.
    pub(crate) fn allow(&self, number: Number) -> Truth {
        let known = !number.as_real().is_nan();
        let low = self.min.is_some_and(|min| number.is_below(min));
        let high = self.max.is_some_and(|max| number.is_above(max));
        Truth::of(known && !low && !high)
    }

    /// Whether a number of this extent can be within them, and whether it can be outside.
    pub(crate) fn hold(&self, (low, high): Extent) -> (bool, bool) {
        if low.as_real().is_nan() || high.as_real().is_nan() {
            return (false, true);
        }
        let can_hold =
            !self.max.is_some_and(|max| low.is_above(max)) && !self.min.is_some_and(|min| high.is_below(min));
        let can_break =
            self.min.is_some_and(|min| low.is_below(min)) || self.max.is_some_and(|max| high.is_above(max));
        (can_hold, can_break)
    }

    /// Those of the limits that a number can pass which is always within `natural`: 0 is no limit of a time (decision 62).
    #[must_use]
    pub(crate) fn passable(self, natural: NumberLimits) -> NumberLimits {
        let min = self.min.filter(|min| natural.min.is_none_or(|least| min.is_above(least)));
        let max = self.max.filter(|max| natural.max.is_none_or(|most| max.is_below(most)));
        NumberLimits { min, max }
    }

    /// How far inside its limits a number of this extent is in the worst placement, negative outside; `None` where there is no
    /// limit, or the distance is beyond every number.
    pub(crate) fn margin(&self, (low, high): Extent) -> Option<f64> {
        let above = self.min.map(|min| distance(min, low));
        let below = self.max.map(|max| distance(high, max));
        above.into_iter().chain(below).reduce(f64::min).filter(|margin| margin.is_finite())
    }
}

/// The extent of both.
pub(crate) fn widened(extent: Option<Extent>, other: Extent) -> Extent {
    extent.map_or(other, |(low, high)| (low.least(other.0), high.most(other.1)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_margin_is_that_of_the_nearest_limit_which_can_be_passed() {
        let limits = NumberLimits { min: Some(Number::ZERO), max: Some(Number::Int(1 << 62)) };
        let extent = (Number::Int((1 << 62) - 3), Number::Int((1 << 62) - 1));
        assert_eq!(limits.margin(extent), Some(1.0));
        assert_eq!(limits.margin((Number::Int(1), Number::Int(2))), Some(1.0));
        let time = NumberLimits { min: Some(Number::ZERO), max: None };
        assert_eq!(limits.passable(time).min, None);
        assert_eq!(NumberLimits::default().margin(extent), None);
        assert_eq!(limits.hold((Number::Int(1), Number::Int((1 << 62) + 1))), (true, true));
        assert_eq!(limits.hold((Number::Real(f64::NAN), Number::Int(5))), (false, true));
        assert_eq!(limits.hold((Number::Real(f64::NEG_INFINITY), Number::Int(-1))), (false, true));
    }
}
