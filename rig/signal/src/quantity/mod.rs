//! Quantities with units, and ranges of them, parsed exactly from decimals.

mod error;
mod range;
mod units;

use std::cmp::Ordering;
use std::fmt;

use crate::Span;
use crate::time::{ParseTimeError, decimal, skip_spaces};

pub use error::ParseQuantityError;
pub use range::{QuantityRange, SpanRange};
pub use units::Dimension;
use units::{NANO, Unit};

/// An exact number of billionths of a base unit.
///
/// The base unit is [`Dimension::unit`]: 10 % is ten percent, not 0.1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Quantity {
    nano: i128,
    dimension: Dimension,
}

impl Quantity {
    /// `nano` billionths of the base unit of `dimension`.
    pub const fn new(nano: i128, dimension: Dimension) -> Self {
        Quantity { nano, dimension }
    }

    /// What it is a quantity of.
    pub const fn dimension(self) -> Dimension {
        self.dimension
    }

    /// Billionths of the base unit.
    pub const fn as_nano(self) -> i128 {
        self.nano
    }

    /// The number of base units, as near as a float comes.
    pub fn as_f64(self) -> f64 {
        if self.nano % NANO == 0 { (self.nano / NANO) as f64 } else { self.nano as f64 / NANO as f64 }
    }

    /// The number of base units, if it is whole.
    pub const fn as_whole(self) -> Option<i128> {
        if self.nano % NANO == 0 { Some(self.nano / NANO) } else { None }
    }

    /// The duration, for [`Dimension::Time`] within ±292 years.
    pub fn as_span(self) -> Option<Span> {
        match self.dimension {
            Dimension::Time => i64::try_from(self.nano).ok().map(Span::from_nanos),
            _ => None,
        }
    }

    /// Reads a number with its unit, such as `24 V`, `200kHz`, `-21.5 °C` or `10 %`; without a unit it is a plain
    /// number. A duration may have several parts, as in `1 min 30 s`.
    ///
    /// The number is an exact decimal with optional `_` between digits. What is finer than a billionth of the
    /// base unit is refused, never rounded.
    ///
    /// # Errors
    /// [`ParseQuantityError`] with the byte of the first fault.
    pub fn parse(text: &str) -> Result<Quantity, ParseQuantityError> {
        Scanned::read(text)?.with_unit(None)
    }
}

/// A number and its unit before they are put together: a range lends the unit of its end to its beginning.
struct Scanned {
    sign: i128,
    mantissa: i128,
    decimals: u32,
    number_at: usize,
    unit: Option<&'static Unit>,
    /// Set for a duration of which the parts have been added up already.
    whole: Option<Quantity>,
}

impl Scanned {
    fn read(text: &str) -> Result<Scanned, ParseQuantityError> {
        let bytes = text.as_bytes();
        let start = skip_spaces(bytes, 0);
        if start == bytes.len() {
            return Err(ParseQuantityError::Empty(start));
        }
        let mut number_at = start;
        let mut sign = 1;
        if bytes[start] == b'-' || bytes[start] == b'+' {
            if bytes[start] == b'-' {
                sign = -1;
            }
            number_at = skip_spaces(bytes, start + 1);
        }
        let (mantissa, decimals, after) = decimal(bytes, number_at).map_err(from_time)?;
        let unit_at = skip_spaces(bytes, after);
        let is_unit = |b: &u8| !b.is_ascii_whitespace() && !b.is_ascii_digit();
        let end = unit_at + bytes[unit_at..].iter().take_while(|b| is_unit(b)).count();
        let mut scanned = Scanned { sign, mantissa, decimals, number_at, unit: None, whole: None };
        if unit_at < end {
            let unit = Unit::find(&text[unit_at..end]).map_err(|near| match near {
                Some(unit) => ParseQuantityError::Spelling { at: unit_at, unit: unit.symbol() },
                None => ParseQuantityError::UnknownUnit(unit_at),
            })?;
            scanned.unit = Some(unit);
            if unit.dimension() == Dimension::Time {
                let span = Span::parse(text).map_err(from_time)?;
                scanned.whole = Some(Quantity::new(i128::from(span.as_nanos()), Dimension::Time));
                return Ok(scanned);
            }
        }
        let rest = skip_spaces(bytes, end);
        if rest < bytes.len() { Err(ParseQuantityError::Trailing(rest)) } else { Ok(scanned) }
    }

    /// The quantity, in the unit of another one if it has none of its own.
    fn with_unit(&self, lent: Option<&'static Unit>) -> Result<Quantity, ParseQuantityError> {
        if let Some(whole) = self.whole {
            return Ok(whole);
        }
        let (scale, dimension) =
            self.unit.or(lent).map_or((NANO, Dimension::Number), |unit| (unit.nano(), unit.dimension()));
        let too_large = ParseQuantityError::TooLarge(self.number_at);
        let scaled = self.mantissa.checked_mul(scale).ok_or(too_large)?;
        let divisor = 10i128.pow(self.decimals);
        if scaled % divisor != 0 {
            return Err(ParseQuantityError::TooFine(self.number_at));
        }
        Ok(Quantity::new(self.sign * (scaled / divisor), dimension))
    }
}

fn from_time(error: ParseTimeError) -> ParseQuantityError {
    match error {
        ParseTimeError::Empty => ParseQuantityError::Empty(0),
        ParseTimeError::Number(at) => ParseQuantityError::Number(at),
        ParseTimeError::MissingUnit(at) => ParseQuantityError::MissingUnit(at),
        ParseTimeError::UnknownUnit(at) => ParseQuantityError::UnknownUnit(at),
        ParseTimeError::TooFine(at) => ParseQuantityError::TooFine(at),
        ParseTimeError::TooLarge => ParseQuantityError::TooLarge(0),
    }
}

impl PartialOrd for Quantity {
    /// By size within one dimension; `None` between two.
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        (self.dimension == other.dimension).then(|| self.nano.cmp(&other.nano))
    }
}

impl From<Span> for Quantity {
    fn from(span: Span) -> Self {
        Quantity::new(i128::from(span.as_nanos()), Dimension::Time)
    }
}

impl fmt::Display for Quantity {
    /// The number in the largest unit that leaves a digit before the point, without trailing zeros: `1.5 kHz`.
    /// Reads back with [`Quantity::parse`].
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let magnitude = self.nano.unsigned_abs();
        let (scale, symbol) = units::display_unit(magnitude, self.dimension);
        let (whole, part) = (magnitude / scale, magnitude % scale);
        if self.nano < 0 {
            f.write_str("-")?;
        }
        write!(f, "{whole}")?;
        if part != 0 {
            let width = scale.ilog10() as usize;
            let digits = format!("{part:0width$}");
            write!(f, ".{}", digits.trim_end_matches('0'))?;
        }
        if symbol.is_empty() { Ok(()) } else { write!(f, " {symbol}") }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn at(text: &str) -> Quantity {
        Quantity::parse(text).unwrap()
    }

    #[test]
    fn quantities_are_exact() {
        for (text, nano, dimension) in [
            ("200 kHz", 200_000 * NANO, Dimension::Frequency),
            ("24V", 24 * NANO, Dimension::Voltage),
            ("5 mA", 5_000_000, Dimension::Current),
            ("10 %", 10 * NANO, Dimension::Ratio),
            ("50 ppm", 5_000_000, Dimension::Ratio),
            ("1500 rpm", 1500 * NANO, Dimension::RotationalSpeed),
            ("21.5 °C", 21_500_000_000, Dimension::Temperature),
            ("-21.5 degC", -21_500_000_000, Dimension::Temperature),
            ("1 min 30 s", 90 * NANO, Dimension::Time),
            ("0.1 us", 100, Dimension::Time),
            ("1.5 bar", 150_000 * NANO, Dimension::Pressure),
            ("4.7 kΩ", 4_700 * NANO, Dimension::Resistance),
            ("60_000", 60_000 * NANO, Dimension::Number),
            (" - 0.000000001 ", -1, Dimension::Number),
        ] {
            assert_eq!(Quantity::parse(text), Ok(Quantity::new(nano, dimension)), "{text}");
        }
        assert_eq!(at("0.1 V").as_f64(), 0.1);
        assert_eq!(at("42").as_whole(), Some(42));
        assert_eq!(at("42.5").as_whole(), None);
        assert_eq!(at("2 ms").as_span(), Some(Span::from_millis(2)));
        assert_eq!(at("2 V").as_span(), None);
        assert!(at("200 mV") < at("1 V"));
        assert_eq!(at("1 V").partial_cmp(&at("1 A")), None);
    }

    #[test]
    fn quantities_are_written_in_a_fitting_unit() {
        for text in
            ["1.5 kHz", "24 V", "5 mA", "0.5 %", "120 %", "1500 rpm", "-21.5 degC", "100.3 ms", "42", "0 V"]
        {
            assert_eq!(at(text).to_string(), text);
        }
    }

    #[test]
    fn faults_name_their_place() {
        use ParseQuantityError as E;
        let fault = |text: &str| Quantity::parse(text).unwrap_err();
        assert_eq!(fault("  "), E::Empty(2));
        assert_eq!(fault("V"), E::Number(0));
        assert_eq!(fault("24 Volt"), E::UnknownUnit(3));
        assert_eq!(fault("24 KHZ"), E::Spelling { at: 3, unit: "kHz" });
        assert_eq!(fault("24 V 3"), E::Trailing(5));
        assert_eq!(fault("1e3"), E::UnknownUnit(1));
        assert_eq!(fault("0.0000000001 V"), E::TooFine(0));
        assert_eq!(fault("99999999999999999999999999999 MHz"), E::TooLarge(0));
        assert_eq!(fault("300000 d"), E::TooLarge(0));
        assert_eq!(fault("1 s 30"), E::MissingUnit(4));
    }

    pub(super) fn any_quantity() -> impl Strategy<Value = Quantity> {
        let nano = prop_oneof![any::<i32>().prop_map(i128::from), any::<i64>().prop_map(i128::from)];
        (nano, prop::sample::select(Dimension::ALL.to_vec()))
            .prop_map(|(nano, dimension)| Quantity::new(nano, dimension))
    }

    proptest! {
        #[test]
        fn what_is_written_reads_back(quantity in any_quantity()) {
            prop_assert_eq!(Quantity::parse(&quantity.to_string()), Ok(quantity));
        }

        #[test]
        fn no_text_panics(text in "[-+]?[0-9._]{0,40} ?(\\PC{0,4}|[mk]?[sVA%])") {
            if let Err(error) = Quantity::parse(&text) {
                prop_assert!(error.offset() <= text.len());
                let _ = error.to_string();
            }
        }
    }
}
