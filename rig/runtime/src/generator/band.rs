//! Values between two ends, each the float that is nearest to the exact one.

use signal::Decimal;

/// Most digits after the point of an end that is kept exactly.
const MOST_DIGITS: i32 = 18;
/// Largest whole number that a float holds with all its neighbours.
const WHOLE: u128 = 1 << 53;

/// The values from one end to another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Band {
    from: f64,
    to: f64,
    /// Both ends as whole numbers of `1 / scale`, where they have so few digits.
    exact: Option<(i128, i128, u128)>,
}

impl Band {
    /// From one number to another.
    pub fn new(from: Decimal, to: Decimal) -> Band {
        let whole = |digits: i32| {
            let (from, to) = (from.shifted(digits).as_whole()?, to.shifted(digits).as_whole()?);
            let small = |number: i128| number.unsigned_abs() < 1 << 62;
            let scale = 10u128.checked_pow(u32::try_from(digits).ok()?)?;
            (small(from) && small(to)).then_some((from, to, scale))
        };
        let digits = (0..=MOST_DIGITS)
            .find(|digits| from.shifted(*digits).is_whole() && to.shifted(*digits).is_whole());
        Band { from: from.as_f64(), to: to.as_f64(), exact: digits.and_then(whole) }
    }

    /// From a float to a number.
    pub fn from_float(from: f64, to: f64) -> Band {
        Band { from, to, exact: None }
    }

    /// The first end.
    pub const fn from(&self) -> f64 {
        self.from
    }

    /// The other end.
    pub const fn to(&self) -> f64 {
        self.to
    }

    /// The value at `part / whole` of the way, which is at most 1.
    pub fn at(&self, part: u128, whole: u128) -> f64 {
        let divisor = common_divisor(part, whole).max(1);
        let (part, whole) = (part / divisor, whole / divisor);
        self.exactly(part, whole).unwrap_or_else(|| {
            let part = quotient(part, whole);
            (self.from + (self.to - self.from) * part).clamp(self.from.min(self.to), self.from.max(self.to))
        })
    }

    fn exactly(&self, part: u128, whole: u128) -> Option<f64> {
        let (from, to, scale) = self.exact?;
        let (part, rest) = (i128::try_from(part).ok()?, i128::try_from(whole - part).ok()?);
        let above = from.checked_mul(rest)?.checked_add(to.checked_mul(part)?)?;
        let below = whole.checked_mul(scale)?;
        let divisor = common_divisor(above.unsigned_abs(), below).max(1);
        let size = quotient(above.unsigned_abs() / divisor, below / divisor);
        Some(if above < 0 { -size } else { size })
    }
}

/// The float nearest to a quotient.
pub fn quotient(above: u128, below: u128) -> f64 {
    if above < WHOLE && below < WHOLE {
        // Both are floats, and a division rounds once.
        return above as f64 / below as f64;
    }
    // Digit by digit until there are more than a float has; whatever is left then breaks a tie.
    let (mut quotient, mut rest) = (above / below, above % below);
    let mut halvings = 0;
    while quotient < WHOLE << 3 && rest != 0 {
        // The divisor is below 2^127, or else this would not be reached with ends of 62 bits.
        rest <<= 1;
        quotient <<= 1;
        if rest >= below {
            rest -= below;
            quotient |= 1;
        }
        halvings += 1;
    }
    libm::ldexp((quotient | u128::from(rest != 0)) as f64, -halvings)
}

/// The greatest common divisor; 0 only of 0 and 0.
fn common_divisor(mut a: u128, mut b: u128) -> u128 {
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn band(from: &str, to: &str) -> Band {
        let decimal = |text: &str| Decimal::split(text).unwrap().0;
        Band::new(decimal(from), decimal(to))
    }

    #[test]
    fn values_are_what_their_decimals_read_as() {
        let tenths = band("0", "0.7");
        let values: Vec<f64> = (0..=7).map(|n| tenths.at(n, 7)).collect();
        assert_eq!(values, [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7]);
        let down = band("1.1", "-1.1");
        assert_eq!(
            (0..=11).map(|n| down.at(2 * n, 22)).collect::<Vec<f64>>(),
            [1.1, 0.9, 0.7, 0.5, 0.3, 0.1, -0.1, -0.3, -0.5, -0.7, -0.9, -1.1]
        );
        // An hour in nanoseconds: 3.6 * 10^12 parts.
        assert_eq!(band("4", "20").at(2_250_000_000_000, 3_600_000_000_000), 14.0);
    }

    #[test]
    fn large_quotients_round_once() {
        // 2^53 + 1 is no float: a tie that goes to the even one. A part more, and it goes up.
        let tie = (1u128 << 53) + 1;
        assert_eq!(quotient(tie, 1), (1u64 << 53) as f64);
        assert_eq!(quotient(tie * (1 << 60) + 1, 1 << 60), ((1u64 << 53) + 2) as f64);
        assert_eq!(quotient(1, 1 << 100), libm::ldexp(1.0, -100));
    }

    proptest! {
        #[test]
        fn a_quotient_is_the_nearest_float(above in 0u128..1 << 100, below in 1u128..1 << 60) {
            let found = quotient(above, below);
            // Twice as far from both neighbours, in whole numbers where that is possible.
            let next = |up: bool| f64::from_bits(if up { found.to_bits() + 1 } else { found.to_bits().saturating_sub(1) });
            prop_assume!(found >= 1.0);
            let distance = |float: f64| {
                // float = m * 2^e exactly; |above * 2^k - float * below * 2^k| in floats is enough to compare.
                let (mantissa, exponent) = libm::frexp(float);
                let mantissa = libm::ldexp(mantissa, 53) as i128;
                let exponent = exponent - 53;
                let (left, right) = if exponent < 0 {
                    ((above as i128).checked_mul(1i128.checked_shl(exponent.unsigned_abs())?)?, mantissa.checked_mul(below as i128)?)
                } else {
                    (above as i128, mantissa.checked_mul(below as i128)?.checked_mul(1i128 << exponent)?)
                };
                Some((left - right).unsigned_abs())
            };
            if let (Some(own), Some(up), Some(down)) = (distance(found), distance(next(true)), distance(next(false))) {
                // Each distance has its own power of two only at the border of two of them.
                if found.to_bits() & 0xF_FFFF_FFFF_FFFF > 1 {
                    prop_assert!(own <= up && own <= down);
                }
            }
        }
    }
}
