//! Numbers as the judge compares them: exactly.
//!
//! A float is met as the decimal number that it was written as. What was worked out of whole numbers is their quotient.

use std::cmp::Ordering;
use std::num::NonZeroU64;

use signal::{Decimal, Value};

/// A number of a condition or a figure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Number {
    /// A whole number.
    Int(i128),
    /// The shortest decimal number that is read as this float; infinite where there is no limit.
    Real(f64),
    /// A decimal number that no float is the shortest for.
    Decimal(Decimal),
    /// A quotient of two whole numbers that is no decimal number.
    Quotient(i128, NonZeroU64),
}

/// From this magnitude on neighbouring floats are more than 1 apart.
const EXACT: f64 = 9_007_199_254_740_992.0;

impl Number {
    /// Nothing.
    pub const ZERO: Number = Number::Int(0);

    /// A quotient of two whole numbers; over 0 it is beyond every number.
    pub(crate) fn quotient(over: i128, under: u64) -> Number {
        let Some(divisor) = NonZeroU64::new(under) else {
            return Number::Real(if over < 0 { f64::NEG_INFINITY } else { f64::INFINITY });
        };
        match Decimal::quotient(over, divisor) {
            Some(exact) => Number::from(exact),
            None => Number::Quotient(over, divisor),
        }
    }

    /// The nearest float; of a quotient or a very large number one beside it.
    pub fn as_real(self) -> f64 {
        match self {
            Number::Int(n) => n as f64,
            Number::Real(r) => r,
            Number::Decimal(exact) => exact.as_f64(),
            Number::Quotient(over, under) => {
                let (whole, part) = split(over, under);
                whole as f64 + part
            }
        }
    }

    /// The number of a value; `None` for one that is none.
    pub fn of(value: Value) -> Option<Number> {
        match value {
            Value::Real(real) | Value::Measured(real, _) => Some(Number::Real(real)),
            other => other.as_int().map(Number::Int),
        }
    }

    /// The number as a decimal one; `None` for infinities and NaN, and for quotients.
    pub(crate) fn as_decimal(self) -> Option<Decimal> {
        match self {
            Number::Int(n) => Some(Decimal::from(n)),
            Number::Real(r) => Decimal::from_f64(r),
            Number::Decimal(exact) => Some(exact),
            Number::Quotient(..) => None,
        }
    }

    /// The floats that stand for it in a record: the nearest one, or from 2^53 on those beside it where it is none itself.
    pub(crate) fn reals(self) -> (f64, f64) {
        let near = self.as_real();
        let order = match self {
            Number::Real(_) => Ordering::Equal,
            Number::Int(n) => (near as i128).cmp(&n),
            _ if near.abs() < EXACT => Ordering::Equal,
            _ => Number::Int(near as i128).compare(self).unwrap_or(Ordering::Equal),
        };
        match order {
            Ordering::Equal => (near, near),
            Ordering::Greater => (near.next_down(), near),
            Ordering::Less => (near, near.next_up()),
        }
    }

    /// The greatest whole number that is not above, held at the limits of 128 bits.
    pub(crate) fn floor(self) -> i128 {
        match self {
            Number::Int(n) => n,
            Number::Quotient(over, under) => split(over, under).0,
            Number::Real(_) | Number::Decimal(_) => match self.as_decimal() {
                Some(exact) => exact.floor(),
                None if self.as_real() > 0.0 => i128::MAX,
                None => i128::MIN,
            },
        }
    }

    /// The least whole number that is not below, held at the limits of 128 bits.
    pub(crate) fn ceil(self) -> i128 {
        let floor = self.floor();
        match self.compare(Number::Int(floor)) {
            Some(Ordering::Greater) => floor.saturating_add(1),
            _ => floor,
        }
    }

    /// How the two compare, exactly; `None` only for a NaN.
    pub fn compare(self, other: Number) -> Option<Ordering> {
        match (self, other) {
            (Number::Int(a), Number::Int(b)) => Some(a.cmp(&b)),
            (Number::Quotient(a, by), Number::Quotient(b, to)) => {
                let parts = |over: i128, under: NonZeroU64| {
                    let under = i128::from(under.get());
                    (over.div_euclid(under), over.rem_euclid(under).unsigned_abs())
                };
                let ((whole, rest), (other, left)) = (parts(a, by), parts(b, to));
                let behind = (rest * u128::from(to.get())).cmp(&(left * u128::from(by.get())));
                Some(whole.cmp(&other).then(behind))
            }
            (Number::Quotient(over, under), other) => match other.as_decimal() {
                Some(exact) => Some(exact.cmp_to_quotient(over, under).reverse()),
                None => self.as_real().partial_cmp(&other.as_real()),
            },
            (_, Number::Quotient(..)) => other.compare(self).map(Ordering::reverse),
            (Number::Real(a), Number::Real(b)) => a.partial_cmp(&b),
            (a, b) => match a.as_real().partial_cmp(&b.as_real()) {
                // What is one float can be two numbers, unless it is a whole one that is small enough.
                Some(Ordering::Equal) if !a.is_small_whole(b) => {
                    let exact = a.as_decimal().zip(b.as_decimal());
                    Some(exact.map_or(Ordering::Equal, |(a, b)| a.cmp(&b)))
                }
                order => order,
            },
        }
    }

    /// Whether both are a whole number below 2^53, where the nearest float of both is one.
    fn is_small_whole(self, other: Number) -> bool {
        matches!((self, other), (Number::Int(n), Number::Real(_)) | (Number::Real(_), Number::Int(n)) if n.unsigned_abs() < 1 << 53)
    }

    /// Whether it is less; a NaN is not.
    pub fn is_below(self, other: Number) -> bool {
        self.compare(other) == Some(Ordering::Less)
    }

    /// Whether it is more; a NaN is not.
    pub fn is_above(self, other: Number) -> bool {
        self.compare(other) == Some(Ordering::Greater)
    }

    /// The lesser of the two.
    #[must_use]
    pub(crate) fn least(self, other: Number) -> Number {
        if other.is_below(self) { other } else { self }
    }

    /// The greater of the two.
    #[must_use]
    pub(crate) fn most(self, other: Number) -> Number {
        if other.is_above(self) { other } else { self }
    }

    /// The sum; exact unless it has more than 38 digits.
    #[must_use]
    pub(crate) fn plus(self, other: Number) -> Number {
        let exact = match (self, other) {
            (Number::Int(a), Number::Int(b)) => a.checked_add(b).map(Number::Int),
            (a, b) => a.as_decimal().zip(b.as_decimal()).and_then(|(a, b)| a.plus(b)).map(Number::from),
        };
        exact.unwrap_or_else(|| Number::Real(self.as_real() + other.as_real()))
    }

    /// The difference; as the sum.
    #[must_use]
    pub(crate) fn minus(self, other: Number) -> Number {
        let exact = match (self, other) {
            (Number::Int(a), Number::Int(b)) => a.checked_sub(b).map(Number::Int),
            (a, b) => a.as_decimal().zip(b.as_decimal()).and_then(|(a, b)| a.minus(b)).map(Number::from),
        };
        exact.unwrap_or_else(|| Number::Real(self.as_real() - other.as_real()))
    }

    /// The number without its sign.
    #[must_use]
    pub(crate) fn abs(self) -> Number {
        match self {
            Number::Int(n) => Number::Int(n.saturating_abs()),
            Number::Real(r) => Number::Real(r.abs()),
            Number::Decimal(exact) => Number::Decimal(exact.abs()),
            Number::Quotient(over, under) => Number::Quotient(over.saturating_abs(), under),
        }
    }

    /// The product; as the sum.
    #[must_use]
    pub(crate) fn times(self, other: Number) -> Number {
        let exact = self.as_decimal().zip(other.as_decimal()).and_then(|(a, b)| a.times(b)).map(Number::from);
        exact.unwrap_or_else(|| Number::Real(self.as_real() * other.as_real()))
    }

    /// How far it is from the other one.
    #[must_use]
    pub(crate) fn apart(self, other: Number) -> Number {
        if self.is_below(other) { other.minus(self) } else { self.minus(other) }
    }
}

/// The greatest whole number that is not above a quotient, and what is left.
fn split(over: i128, under: NonZeroU64) -> (i128, f64) {
    let by = i128::from(under.get());
    (over.div_euclid(by), over.rem_euclid(by) as f64 / by as f64)
}

/// From `low` up to `high`, to the nearest float or so: what is close together is subtracted exactly.
pub(crate) fn distance(low: Number, high: Number) -> f64 {
    match (low, high) {
        (Number::Int(low), Number::Int(high)) => high.saturating_sub(low) as f64,
        (low, Number::Quotient(over, under)) => {
            let (whole, part) = split(over, under);
            distance(low, Number::Int(whole)) + part
        }
        (Number::Quotient(over, under), high) => {
            let (whole, part) = split(over, under);
            distance(Number::Int(whole), high) - part
        }
        (low, high) => {
            let (from, to) = (low.as_real(), high.as_real());
            match (to - from).abs() <= (from.abs() + to.abs()) * 1e-9 {
                true => high.minus(low).as_real(),
                false => to - from,
            }
        }
    }
}

/// Whether `high` less `low`, and `off` more, is at most `limit`. Floats are met as the decimal numbers that they were written
/// as: 1 less 0.7 is 0.3.
pub(crate) fn differs_at_most(low: Number, high: Number, off: f64, limit: Number) -> bool {
    let (reached, most) = (distance(low, high) + off, limit.as_real());
    let scale = low.as_real().abs() + high.as_real().abs() + off.abs() + most.abs();
    // What a float cannot be off by.
    if (reached - most).abs() > scale * 1e-9 || !scale.is_finite() {
        return reached <= most;
    }
    !high.minus(low).plus(Number::Real(off)).is_above(limit)
}

impl From<Decimal> for Number {
    /// The same number, as a float where it is the shortest number for one.
    fn from(number: Decimal) -> Number {
        if let Some(whole) = number.as_whole() {
            return Number::Int(whole);
        }
        let near = number.as_f64();
        if Decimal::from_f64(near) == Some(number) { Number::Real(near) } else { Number::Decimal(number) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decimal(text: &str) -> Number {
        Number::from(Decimal::split(text).unwrap().0)
    }

    #[test]
    fn what_is_written_is_met_beyond_every_float() {
        let written = Decimal::from(i128::from(u64::MAX));
        assert_eq!(Number::from(written), Number::Int(i128::from(u64::MAX)));
        let (half, more) = (decimal("18446744073709551614.5"), decimal("18446744073709551614.6"));
        assert!(half.is_below(more) && half.is_above(Number::Int((1 << 64) - 2)));
        assert_eq!((half.floor(), half.ceil()), ((1 << 64) - 2, (1 << 64) - 1));
        assert_eq!(distance(half, more), 0.1);
        assert_eq!(distance(Number::Int((1 << 64) - 2), half), 0.5);
        assert_eq!(decimal("0.3"), Number::Real(0.3));
        assert_eq!(Number::Real(0.7).plus(decimal("0.3")), Number::Int(1));
        assert!(Number::Real(f64::INFINITY).is_above(Number::Int(i128::MAX)));
        assert_eq!(Number::Real(f64::NAN).compare(Number::ZERO), None);
    }

    #[test]
    fn a_quotient_lies_between_the_decimals_beside_it() {
        let third = Number::quotient(1, 3);
        assert!(third.is_above(decimal("0.3333333333333333333333")));
        assert!(third.is_below(decimal("0.3333333333333333333334")));
        assert!(third.is_below(Number::quotient(3334, 10_001)) && third.is_above(Number::quotient(-1, 3)));
        assert_eq!(Number::quotient(2, 6).compare(third), Some(Ordering::Equal));
        assert_eq!(Number::quotient(499, 10), Number::Real(49.9));
        assert_eq!(Number::quotient(1, 0), Number::Real(f64::INFINITY));
        let large = Number::quotient(1 << 100, 3);
        assert!(!Number::Int(large.reals().0 as i128).is_above(large));
        assert!(!Number::Int(large.reals().1 as i128).is_below(large));
        assert_eq!(third.reals().0, third.reals().1);
    }

    #[test]
    fn a_record_holds_what_no_float_is_between_two() {
        assert_eq!(Number::Int((1 << 60) + 1).reals(), ((1_u64 << 60) as f64, (1_u64 << 60) as f64 + 256.0));
        assert_eq!(Number::Int(1 << 60).reals().0, (1_u64 << 60) as f64);
    }

    #[test]
    fn decimals_are_met_as_they_are_written() {
        let at_most = |low, high, limit| {
            differs_at_most(Number::Real(low), Number::Real(high), 0.0, Number::Real(limit))
        };
        assert!(at_most(0.7, 1.0, 0.3) && at_most(0.1, 0.3, 0.2));
        assert!(!at_most(0.7, 1.000_000_000_1, 0.3) && !at_most(0.0, f64::NAN, 1.0));
    }
}
