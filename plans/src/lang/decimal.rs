//! Exact decimal numbers with a unit behind them.

use std::fmt;

/// An exact decimal number: `mantissa` divided by ten to the power of `decimals`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Decimal {
    /// All digits, with the sign.
    pub mantissa: i128,
    /// How many of them stand behind the point, at most 18.
    pub decimals: u32,
}

impl Decimal {
    /// Reads a number such as `-0.37` or `60_000` and what stands behind it, without the blanks between:
    /// `"0.37 ms"` gives 0.37 and `"ms"`. `None` if no number of at most 18 digits stands in front.
    pub fn split(text: &str) -> Option<(Decimal, &str)> {
        let text = text.trim();
        let bytes = text.as_bytes();
        let (mut at, mut mantissa, mut decimals, mut digits, mut point) = (0, 0i128, 0u32, 0u32, false);
        let negative = bytes.first() == Some(&b'-');
        at += usize::from(negative || bytes.first() == Some(&b'+'));
        while at < bytes.len() {
            match bytes[at] {
                digit @ b'0'..=b'9' => {
                    mantissa = mantissa * 10 + i128::from(digit - b'0');
                    digits += 1;
                    decimals += u32::from(point);
                    if digits > 18 {
                        return None;
                    }
                }
                b'_' if digits > 0 => {}
                b'.' if digits > 0 && !point && bytes.get(at + 1).is_some_and(u8::is_ascii_digit) => {
                    point = true
                }
                _ => break,
            }
            at += 1;
        }
        let mantissa = if negative { -mantissa } else { mantissa };
        (digits > 0).then(|| (Decimal { mantissa, decimals }, text[at..].trim_start()))
    }

    /// The mantissa for this many decimals, `None` where digits would be lost or the number is too large.
    pub fn scaled(self, decimals: u32) -> Option<i128> {
        if decimals >= self.decimals {
            return self.mantissa.checked_mul(10i128.checked_pow(decimals - self.decimals)?);
        }
        let divisor = 10i128.checked_pow(self.decimals - decimals)?;
        (self.mantissa % divisor == 0).then_some(self.mantissa / divisor)
    }

    /// The nearest float.
    pub fn as_f64(self) -> f64 {
        // The text is what floats are read from exactly; dividing by a power of ten would round twice.
        self.to_string().parse().unwrap_or(f64::NAN)
    }
}

impl fmt::Display for Decimal {
    /// The number without trailing zeros behind the point.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sign = if self.mantissa < 0 { "-" } else { "" };
        let magnitude = self.mantissa.unsigned_abs();
        let divisor = 10u128.pow(self.decimals.min(38));
        let (whole, part) = (magnitude / divisor, magnitude % divisor);
        if part == 0 {
            return write!(f, "{sign}{whole}");
        }
        let width = self.decimals as usize;
        let digits = format!("{part:0width$}");
        write!(f, "{sign}{whole}.{}", digits.trim_end_matches('0'))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn numbers_keep_their_units() {
        assert_eq!(Decimal::split("0.37 ms"), Some((Decimal { mantissa: 37, decimals: 2 }, "ms")));
        assert_eq!(Decimal::split("60_000"), Some((Decimal { mantissa: 60_000, decimals: 0 }, "")));
        assert_eq!(Decimal::split("-1.50V"), Some((Decimal { mantissa: -150, decimals: 2 }, "V")));
        assert_eq!(Decimal::split("ms"), None);
        assert_eq!(Decimal { mantissa: -50, decimals: 2 }.to_string(), "-0.5");
        assert_eq!(Decimal { mantissa: 125, decimals: 2 }.scaled(1), None);
    }

    proptest! {
        #[test]
        fn what_is_written_reads_back(mantissa in -999_999_999_999i128..=999_999_999_999, decimals in 0u32..6) {
            let number = Decimal { mantissa, decimals };
            let text = number.to_string();
            let (read, unit) = Decimal::split(&text).unwrap();
            prop_assert_eq!(read.scaled(6), number.scaled(6));
            prop_assert_eq!(unit, "");
        }

        #[test]
        fn no_text_panics(text in "\\PC*") {
            let _ = Decimal::split(&text);
        }
    }
}
