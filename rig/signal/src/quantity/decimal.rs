//! Exact decimal numbers.

use std::cmp::Ordering;
use std::fmt;
use std::num::NonZeroU64;

use super::{QuantityError, QuantityFault};

/// An exact decimal number: `mantissa` times ten to the power of `exponent`.
///
/// The mantissa does not end in 0, so that equal numbers are equal in their parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Decimal {
    mantissa: i128,
    exponent: i32,
}

/// Most digits of a written number: leaves room for a unit's factor.
const MAX_DIGITS: usize = 30;
/// Largest power of ten of a written number; floats end a little above.
const MAX_EXPONENT: i32 = 330;

impl Decimal {
    /// Nothing.
    pub const ZERO: Decimal = Decimal { mantissa: 0, exponent: 0 };

    /// `mantissa` times ten to the power of `exponent`.
    pub fn new(mut mantissa: i128, mut exponent: i32) -> Decimal {
        if mantissa == 0 {
            return Decimal::ZERO;
        }
        while mantissa % 10 == 0 {
            mantissa /= 10;
            exponent = exponent.saturating_add(1);
        }
        Decimal { mantissa, exponent }
    }

    /// The shortest decimal number that is read as this float; `None` for infinities and NaN.
    pub fn from_f64(real: f64) -> Option<Decimal> {
        let text = format!("{real:e}");
        Decimal::split(&text).ok().filter(|(_, rest)| rest.is_empty()).map(|(number, _)| number)
    }

    /// Reads a number such as `-0.37`, `60_000` or `1.5e-3` and gives what stands after it, without the blanks
    /// between: `"0.37 ms"` is 0.37 and `"ms"`.
    ///
    /// # Errors
    /// [`QuantityError`]: no number stands in front, or one of over 30 digits or beyond what floats hold.
    pub fn split(text: &str) -> Result<(Decimal, &str), QuantityError> {
        let start = text.trim_start();
        let place = |rest: &str| text.len() - rest.len();
        if start.is_empty() {
            return Err(QuantityFault::Empty.at(text.len()));
        }
        let (negative, number) = match start.strip_prefix('-') {
            Some(rest) => (true, rest.trim_start()),
            None => (false, start.strip_prefix('+').unwrap_or(start).trim_start()),
        };
        let (magnitude, rest) = unsigned(number).map_err(|fault| fault.at(place(number)))?;
        let mantissa = if negative { -magnitude.mantissa } else { magnitude.mantissa };
        Ok((Decimal { mantissa, ..magnitude }, rest.trim_start()))
    }

    /// The number, if it is whole and has at most 38 digits.
    pub fn as_whole(self) -> Option<i128> {
        self.mantissa.checked_mul(10i128.checked_pow(u32::try_from(self.exponent).ok()?)?)
    }

    /// Whether nothing stands after the point.
    pub const fn is_whole(self) -> bool {
        self.exponent >= 0
    }

    /// The nearest float.
    pub fn as_f64(self) -> f64 {
        // Floats are read from texts with a single rounding; multiplying by a power of ten would round twice.
        format!("{}e{}", self.mantissa, self.exponent).parse().unwrap_or(f64::NAN)
    }

    /// The nearest float, without allocating; `None` where the number is too long for that.
    pub fn nearest(self) -> Option<f64> {
        // Both the digits and a power of ten up to the 22nd are exact floats: one operation rounds once.
        const POWERS: [f64; 23] = [
            1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17,
            1e18, 1e19, 1e20, 1e21, 1e22,
        ];
        let power = *POWERS.get(usize::try_from(self.exponent.unsigned_abs()).ok()?)?;
        if self.mantissa.unsigned_abs() > 1 << 53 {
            return None;
        }
        let digits = self.mantissa as f64;
        Some(if self.exponent < 0 { digits / power } else { digits * power })
    }

    /// Whether it is below 0.
    pub const fn is_negative(self) -> bool {
        self.mantissa < 0
    }

    /// The number without its sign.
    #[must_use]
    pub fn abs(self) -> Decimal {
        Decimal { mantissa: self.mantissa.saturating_abs(), ..self }
    }

    /// The number times ten to the power of `power`.
    #[must_use]
    pub fn shifted(self, power: i32) -> Decimal {
        Decimal::new(self.mantissa, self.exponent.saturating_add(power))
    }

    /// The product; `None` where it has too many digits.
    pub fn times(self, other: Decimal) -> Option<Decimal> {
        let exponent = self.exponent.checked_add(other.exponent)?;
        Some(Decimal::new(self.mantissa.checked_mul(other.mantissa)?, exponent))
    }

    /// The sum; `None` where it has too many digits.
    pub fn plus(self, other: Decimal) -> Option<Decimal> {
        let (a, b, exponent) = aligned(self, other)?;
        Some(Decimal::new(a.checked_add(b)?, exponent))
    }

    /// The difference; `None` where it has too many digits.
    pub fn minus(self, other: Decimal) -> Option<Decimal> {
        self.plus(Decimal { mantissa: other.mantissa.checked_neg()?, ..other })
    }

    /// The greatest whole number that is not above, held at the limits of 128 bits.
    pub fn floor(self) -> i128 {
        match self.as_whole() {
            Some(whole) => whole,
            None if self.exponent >= 0 && self.mantissa < 0 => i128::MIN,
            None if self.exponent >= 0 => i128::MAX,
            // Digits that are all after the point.
            None => power_of_ten_of(self.exponent)
                .map_or(if self.mantissa < 0 { -1 } else { 0 }, |power| self.mantissa.div_euclid(power)),
        }
    }

    /// The quotient of two whole numbers as a decimal number; `None` where it has no end, or too many digits.
    pub fn quotient(over: i128, under: NonZeroU64) -> Option<Decimal> {
        let (mut rest, mut exponent, mut over) = (i128::from(under.get()), 0, over);
        let divisor = common_divisor(over, rest);
        (over, rest) = (over / divisor, rest / divisor);
        while rest > 1 {
            let (factor, by) = match (rest % 10, rest % 2, rest % 5) {
                (0, ..) => (10, 1),
                (_, 0, _) => (2, 5),
                (.., 0) => (5, 2),
                _ => return None,
            };
            rest /= factor;
            over = over.checked_mul(by)?;
            exponent -= 1;
        }
        Some(Decimal::new(over, exponent))
    }

    /// The number divided by a whole one; `None` where the quotient has no end, or too many digits.
    pub fn over(self, under: NonZeroU64) -> Option<Decimal> {
        Some(Decimal::quotient(self.mantissa, under)?.shifted(self.exponent))
    }

    /// How the quotient of two whole numbers compares with this number, exactly.
    pub fn cmp_to_quotient(self, over: i128, under: NonZeroU64) -> Ordering {
        if self.mantissa < 0 {
            let (less, over) = (self.mantissa.saturating_neg(), over.saturating_neg());
            return Decimal { mantissa: less, ..self }.cmp_to_quotient(over, under).reverse();
        }
        if over < 0 || self.exponent >= 0 && self.as_whole().is_none() {
            return Ordering::Greater;
        }
        let under = u128::from(under.get());
        let (whole, mut rest) = (over.unsigned_abs() / under, over.unsigned_abs() % under);
        let floor = self.floor().unsigned_abs();
        if floor != whole || self.exponent >= 0 {
            let order = floor.cmp(&whole);
            return if rest > 0 { order.then(Ordering::Less) } else { order };
        }
        // What stands after the point, digit by digit.
        let places = usize::try_from(self.exponent.unsigned_abs()).unwrap_or(0);
        let digits = self.mantissa.unsigned_abs().to_string();
        let digits = format!("{digits:0>places$}");
        for digit in digits[digits.len() - places..].bytes() {
            let next = rest * 10;
            rest = next % under;
            match u128::from(digit - b'0').cmp(&(next / under)) {
                Ordering::Equal => {}
                order => return order,
            }
        }
        if rest > 0 { Ordering::Less } else { Ordering::Equal }
    }
}

/// Ten to the power of what `exponent` is below 0; `None` beyond 128 bits.
fn power_of_ten_of(exponent: i32) -> Option<i128> {
    10i128.checked_pow(exponent.unsigned_abs())
}

/// The greatest whole number that divides both, above 0; `b` is above 0.
fn common_divisor(a: i128, b: i128) -> i128 {
    let (mut a, mut b) = (a, b);
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a.saturating_abs().max(1)
}

/// Both mantissas for the exponent that both have then.
fn aligned(a: Decimal, b: Decimal) -> Option<(i128, i128, i32)> {
    // The exponent of 0 is free: it must not make the other number longer.
    let exponent = match (a.mantissa, b.mantissa) {
        (0, _) => b.exponent,
        (_, 0) => a.exponent,
        _ => a.exponent.min(b.exponent),
    };
    let scaled = |number: Decimal| match number.mantissa {
        0 => Some(0),
        mantissa => {
            let digits = u32::try_from(number.exponent.checked_sub(exponent)?).ok()?;
            mantissa.checked_mul(10i128.checked_pow(digits)?)
        }
    };
    Some((scaled(a)?, scaled(b)?, exponent))
}

/// A number without a sign, and the text after it.
fn unsigned(text: &str) -> Result<(Decimal, &str), QuantityFault> {
    let bytes = text.as_bytes();
    let mut at = digits_end(bytes, 0);
    if at == 0 {
        return Err(if text.is_empty() { QuantityFault::Empty } else { QuantityFault::Number });
    }
    let mut decimals = 0;
    if bytes.get(at) == Some(&b'.') {
        let point = at;
        at = digits_end(bytes, point + 1);
        if at == point + 1 {
            return Err(QuantityFault::Number);
        }
        decimals = bytes[point..at].iter().filter(|byte| byte.is_ascii_digit()).count();
    }
    let digits = || bytes[..at].iter().filter(|byte| byte.is_ascii_digit());
    if digits().count() > MAX_DIGITS {
        return Err(QuantityFault::TooLarge);
    }
    let mantissa = digits().fold(0i128, |number, digit| number * 10 + i128::from(digit - b'0'));
    let (exponent, rest) = power_of_ten(&text[at..])?;
    let decimals = i32::try_from(decimals).map_err(|_| QuantityFault::TooLarge)?;
    let number = Decimal::new(mantissa, exponent - decimals);
    if number.as_f64().is_finite() { Ok((number, rest)) } else { Err(QuantityFault::TooLarge) }
}

/// The power of ten of `e-3` at the beginning, 0 if there is none, and the text after it.
fn power_of_ten(text: &str) -> Result<(i32, &str), QuantityFault> {
    let Some(rest) = text.strip_prefix(['e', 'E']) else { return Ok((0, text)) };
    let digits = rest.strip_prefix(['+', '-']).unwrap_or(rest);
    let length = digits.bytes().take_while(u8::is_ascii_digit).count();
    if length == 0 {
        // A unit that begins with an e.
        return Ok((0, text));
    }
    let end = rest.len() - digits.len() + length;
    match rest[..end].parse::<i32>() {
        Ok(power) if power.abs() <= MAX_EXPONENT => Ok((power, &rest[end..])),
        _ => Err(QuantityFault::TooLarge),
    }
}

/// The end of the digits at `start`, with single `_` between them.
fn digits_end(bytes: &[u8], start: usize) -> usize {
    let digit = |at: usize| bytes.get(at).is_some_and(u8::is_ascii_digit);
    let mut at = start;
    while digit(at) || (at > start && bytes.get(at) == Some(&b'_') && digit(at + 1)) {
        at += 1;
    }
    at
}

impl PartialOrd for Decimal {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Decimal {
    fn cmp(&self, other: &Self) -> Ordering {
        match aligned(*self, *other) {
            Some((a, b, _)) => a.cmp(&b),
            // So far apart that the one with the larger exponent is larger, sign aside.
            None if self.exponent > other.exponent => self.mantissa.cmp(&0),
            None => 0.cmp(&other.mantissa),
        }
    }
}

impl From<i128> for Decimal {
    fn from(number: i128) -> Self {
        Decimal::new(number, 0)
    }
}

impl fmt::Display for Decimal {
    /// All digits, without zeros at the end after the point; very large and very small numbers with `e`.
    /// Reads back with [`Decimal::split`].
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let digits = self.mantissa.unsigned_abs().to_string();
        if self.mantissa < 0 {
            f.write_str("-")?;
        }
        let zeros = usize::try_from(self.exponent).unwrap_or(0);
        let decimals = usize::try_from(self.exponent.saturating_neg()).unwrap_or(0);
        if digits.len() + zeros > MAX_DIGITS || decimals >= MAX_DIGITS {
            return write!(f, "{digits}e{}", self.exponent);
        }
        if decimals == 0 {
            return write!(f, "{digits}{:0<zeros$}", "");
        }
        let padded = format!("{digits:0>width$}", width = decimals + 1);
        let (whole, part) = padded.split_at(padded.len() - decimals);
        write!(f, "{whole}.{part}")
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use proptest::prelude::*;

    fn number(text: &str) -> Decimal {
        match Decimal::split(text) {
            Ok((number, "")) => number,
            other => panic!("{text}: {other:?}"),
        }
    }

    #[test]
    fn numbers_are_exact_and_keep_what_is_behind() {
        assert_eq!(Decimal::split("0.37 ms"), Ok((Decimal::new(37, -2), "ms")));
        assert_eq!(Decimal::split(" -1.50V "), Ok((Decimal::new(-15, -1), "V ")));
        assert_eq!(Decimal::split("5eV"), Ok((Decimal::new(5, 0), "eV")));
        assert_eq!(number("60_000"), Decimal::new(6, 4));
        assert_eq!(number("1.5e-3"), Decimal::new(15, -4));
        assert_eq!(number("2E+3").as_whole(), Some(2000));
        assert_eq!(number("- 0.0"), Decimal::ZERO);
        assert_eq!(number("2.5").as_whole(), None);
        assert_eq!(number("0.1").as_f64(), 0.1);
        assert_eq!(Decimal::from_f64(0.1), Some(Decimal::new(1, -1)));
        assert_eq!(Decimal::from_f64(-1.5e300), Some(Decimal::new(-15, 299)));
        assert_eq!(Decimal::from_f64(f64::MIN_POSITIVE).map(Decimal::as_f64), Some(f64::MIN_POSITIVE));
        assert_eq!(Decimal::from_f64(f64::NAN), None);
        assert_eq!(number("24").minus(number("2.4")), Some(number("21.6")));
        assert_eq!(number("24").times(number("0.1")), Some(number("2.4")));
    }

    #[test]
    fn what_is_no_number_says_where() {
        let fault = |text: &str| Decimal::split(text).unwrap_err();
        assert_eq!(fault("  "), QuantityFault::Empty.at(2));
        assert_eq!(fault("- "), QuantityFault::Empty.at(2));
        assert_eq!(fault(" V"), QuantityFault::Number.at(1));
        assert_eq!(fault(".5"), QuantityFault::Number.at(0));
        assert_eq!(fault("-1. V"), QuantityFault::Number.at(1));
        assert_eq!(fault("1234567890123456789012345678901"), QuantityFault::TooLarge.at(0));
        assert_eq!(fault("1e309"), QuantityFault::TooLarge.at(0));
        assert_eq!(fault("1e99999999999"), QuantityFault::TooLarge.at(0));
        assert_eq!(Decimal::split("1__0"), Ok((Decimal::new(1, 0), "__0")));
    }

    #[test]
    fn numbers_far_apart_compare() {
        let rising = ["-1e300", "-2", "-1e-300", "0", "1e-300", "0.3", "2", "1e300"].map(number);
        for (at, low) in rising.iter().enumerate() {
            for high in &rising[at + 1..] {
                assert!(low < high, "{low} {high}");
                assert!(high > low, "{high} {low}");
            }
        }
    }

    #[test]
    fn a_quotient_compares_beyond_every_float() {
        let under = |number| NonZeroU64::new(number).unwrap();
        let order = |text: &str, over, by| number(text).cmp_to_quotient(over, under(by));
        assert_eq!(order("0.3333333333333333333333333333", 1, 3), Ordering::Less);
        assert_eq!(order("0.3333333333333333333333333334", 1, 3), Ordering::Greater);
        assert_eq!(order("-0.3333333333333333333333333334", -1, 3), Ordering::Less);
        assert_eq!(order("2.5", 5, 2), Ordering::Equal);
        assert_eq!(order("1e-300", 0, 7), Ordering::Greater);
        assert_eq!(order("1e300", i128::MAX, 1), Ordering::Greater);
        assert_eq!(order("1e-300", 1, u64::MAX), Ordering::Less);
        assert_eq!(Decimal::quotient(-5, under(8)), Some(number("-0.625")));
        assert_eq!(Decimal::quotient(0, under(3)), Some(Decimal::ZERO));
        assert_eq!(Decimal::quotient(6, under(3)), Some(number("2")));
        assert_eq!(Decimal::quotient(5, under(3)), None);
        assert_eq!(number("0.3").over(under(4)), Some(number("0.075")));
        assert_eq!(
            ["-2.5", "-0.1", "1e-60", "2.5", "-1e300"].map(|text| number(text).floor()),
            [-3, -1, 0, 2, i128::MIN]
        );
    }

    pub(crate) fn any_decimal() -> impl Strategy<Value = Decimal> {
        let mantissa = prop_oneof![any::<i16>().prop_map(i128::from), any::<i64>().prop_map(i128::from)];
        (mantissa, -6..4).prop_map(|(mantissa, exponent)| Decimal::new(mantissa, exponent))
    }

    proptest! {
        #[test]
        fn what_is_written_reads_back(a in any_decimal(), far in -300..250) {
            for a in [a, a.shifted(far)] {
                prop_assert_eq!(number(&a.to_string()), a);
                prop_assert_eq!(a.to_string().parse::<f64>().unwrap(), a.as_f64());
            }
        }

        // Against whole numbers of a fixed, fine unit.
        #[test]
        fn sums_and_order_are_those_of_whole_numbers(a in any_decimal(), b in any_decimal()) {
            let fine = |number: Decimal| number.shifted(12).as_whole().unwrap();
            prop_assert_eq!(a.cmp(&b), fine(a).cmp(&fine(b)));
            prop_assert_eq!(a.plus(b).map(fine), Some(fine(a) + fine(b)));
            prop_assert_eq!(a.minus(b).map(fine), Some(fine(a) - fine(b)));
        }

        #[test]
        fn a_quotient_compares_as_products_do(a in any_decimal(), over in any::<i64>(), under in 1u32..) {
            let under = NonZeroU64::from(std::num::NonZeroU32::new(under).unwrap());
            let product = a.times(Decimal::from(i128::from(under.get()))).unwrap();
            let order = product.cmp(&Decimal::from(i128::from(over)));
            prop_assert_eq!(a.cmp_to_quotient(i128::from(over), under), order);
            if let Some(exact) = Decimal::quotient(i128::from(over), under) {
                prop_assert_eq!(exact.cmp_to_quotient(i128::from(over), under), Ordering::Equal);
            }
        }

        #[test]
        fn no_text_panics(text in "\\PC*", near in "[-+]?[0-9._]{0,40}(e[-+]?[0-9]{0,4})? ?(V|µ)?") {
            for text in [text, near] {
                if let Err(error) = Decimal::split(&text) {
                    prop_assert!(text.is_char_boundary(error.at));
                }
            }
        }
    }
}
