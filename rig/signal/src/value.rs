//! What a signal can be.

use std::fmt;

/// The state of a wire or terminal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Level {
    /// Driven to 0 V, or contact open on an output that loads pull down.
    Low,
    /// Driven to the supply.
    High,
    /// Not driven (high impedance).
    HighZ,
}

impl Level {
    /// The level that a Boolean drives.
    pub const fn from_bool(on: bool) -> Self {
        if on { Level::High } else { Level::Low }
    }

    /// What an input sees: only a driven 1 is TRUE.
    pub const fn is_high(self) -> bool {
        matches!(self, Level::High)
    }
}

/// A value of a signal at an instant.
#[derive(Clone, Copy, Debug)]
pub enum Value {
    /// A Boolean or a driven line.
    Bool(bool),
    /// A signed number, a small unsigned number, a state's number, or TIME in nanoseconds.
    Int(i64),
    /// A bit string or an unsigned number of up to 64 bits.
    Word(u64),
    /// A measured or computed real number, in the signal's unit.
    Real(f64),
    /// A real number that was measured, in the signal's unit, and how far the truth may lie from it, both ways: above 0
    /// and finite. See [`Value::measured`].
    Measured(f64, f32),
    /// A line that nobody drives.
    HighZ,
    /// Not known: not yet read, or its device is lost.
    Unknown,
}

/// Bits of an uncertainty's mantissa that are rounded away: it is kept to 3 %, so that one that is estimated again with
/// every reading is not another with every reading.
const ROUNDED: u32 = 18;

impl Value {
    /// A number that the truth is at most so far from; rounded up, never down. One that is as exact as it can be where
    /// nothing is known of that (0, or no number).
    pub fn measured(value: f64, uncertainty: f64) -> Value {
        let mask = (1 << ROUNDED) - 1;
        let near = uncertainty as f32;
        // The nearest float can be a little less.
        let above = if f64::from(near) < uncertainty { near.next_up() } else { near };
        let rounded = f32::from_bits(above.to_bits().saturating_add(mask) & !mask);
        let known = uncertainty > 0.0 && rounded > 0.0 && rounded.is_finite();
        if known { Value::Measured(value, rounded) } else { Value::Real(value) }
    }

    /// How far the truth may lie from a number that was measured; 0 for all others.
    #[inline]
    pub fn uncertainty(self) -> f64 {
        if let Value::Measured(_, uncertainty) = self { f64::from(uncertainty) } else { 0.0 }
    }

    /// The exact integer after a Boolean, number or bit string.
    pub fn as_int(self) -> Option<i128> {
        match self {
            Value::Bool(b) => Some(i128::from(b)),
            Value::Int(n) => Some(i128::from(n)),
            Value::Word(n) => Some(i128::from(n)),
            Value::Real(_) | Value::Measured(..) | Value::HighZ | Value::Unknown => None,
        }
    }

    /// The value as a real number, where it has one. Integers above 2^53 lose digits.
    pub fn as_real(self) -> Option<f64> {
        match self {
            Value::Real(r) | Value::Measured(r, _) => Some(r),
            other => other.as_int().map(|n| n as f64),
        }
    }

    /// The value as a truth, where it has one: numbers are true when they are not 0.
    pub fn as_bool(self) -> Option<bool> {
        match self {
            Value::Bool(b) => Some(b),
            other => other.as_int().map(|n| n != 0),
        }
    }
}

impl PartialEq for Value {
    /// Equal as values: `Int(1)`, `Word(1)` and `Bool(true)` are equal; reals are equal by bits, so that a
    /// NaN that stays the same NaN is no change. One that was measured differs where its uncertainty does.
    #[inline]
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            // The common case first: the trace compares every pushed value with the last one.
            (Value::Bool(a), Value::Bool(b)) => a == b,
            (Value::Real(a), Value::Real(b)) => a.to_bits() == b.to_bits(),
            (Value::Real(a), b) | (b, Value::Real(a)) => {
                b.as_int().is_some_and(|n| *a == n as f64 && *a as i128 == n)
            }
            (Value::Measured(a, to), Value::Measured(b, by)) => {
                a.to_bits() == b.to_bits() && to.to_bits() == by.to_bits()
            }
            (Value::HighZ, Value::HighZ) | (Value::Unknown, Value::Unknown) => true,
            (a, b) => a.as_int().is_some() && a.as_int() == b.as_int(),
        }
    }
}

impl Eq for Value {}

impl From<Level> for Value {
    fn from(level: Level) -> Self {
        match level {
            Level::Low => Value::Bool(false),
            Level::High => Value::Bool(true),
            Level::HighZ => Value::HighZ,
        }
    }
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Value::Bool(true) => f.write_str("TRUE"),
            Value::Bool(false) => f.write_str("FALSE"),
            Value::Int(n) => write!(f, "{n}"),
            Value::Word(n) => write!(f, "16#{n:X}"),
            Value::Real(r) => write!(f, "{r}"),
            Value::Measured(r, uncertainty) => {
                let places = places(*uncertainty);
                write!(f, "{r:.places$} ± {uncertainty:.places$}")
            }
            Value::HighZ => f.write_str("high impedance"),
            Value::Unknown => f.write_str("unknown"),
        }
    }
}

/// Digits after the point that a number has which is known to within this: two of the uncertainty's own count.
fn places(uncertainty: f32) -> usize {
    let mut places = 0;
    let mut digits = uncertainty;
    while digits < 9.95 && places < 12 {
        digits *= 10.0;
        places += 1;
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn what_was_measured_is_shown_as_far_as_it_is_known() {
        let shown = |value, uncertainty| Value::measured(value, uncertainty).to_string();
        assert_eq!(shown(3.300_123_4, 0.0123), "3.300 ± 0.012");
        assert_eq!(shown(1234.567, 25.0), "1235 ± 25");
        assert_eq!(shown(0.5, 1e-9), "0.5000000000 ± 0.0000000010");
        assert_eq!(shown(3.25, 0.0), "3.25");
        assert_eq!(shown(3.25, f64::NAN), "3.25");
        assert_eq!(shown(3.25, f64::INFINITY), "3.25");
    }

    #[test]
    fn a_number_that_is_known_better_is_another_event() {
        let (fine, coarse) = (Value::measured(1.0, 0.1), Value::measured(1.0, 0.2));
        assert_eq!(fine, Value::measured(1.0, 0.1));
        assert!(fine != coarse && fine != Value::Real(1.0) && Value::Int(1) != fine);
        assert_eq!((fine.as_real(), fine.as_int(), fine.as_bool()), (Some(1.0), None, None));
    }

    #[test]
    fn a_whole_number_that_no_float_is_equals_none() {
        assert!(Value::Int(1 << 60) == Value::Real((1_u64 << 60) as f64));
        assert!(Value::Int((1 << 60) + 1) != Value::Real((1_u64 << 60) as f64));
    }

    proptest! {
        #[test]
        fn an_uncertainty_is_rounded_up_and_by_little(uncertainty in prop_oneof![1e-30..1e30f64, 1e-6..1e3f64]) {
            let kept = Value::measured(0.0, uncertainty).uncertainty();
            prop_assert!(kept >= uncertainty && kept <= uncertainty * 1.04, "{uncertainty} as {kept}");
        }
    }
}
