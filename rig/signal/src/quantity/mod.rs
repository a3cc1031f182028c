//! Numbers with units, and ranges of them: the one reader of everything that a user writes with a unit.

mod decimal;
mod duration;
mod error;
mod range;
mod units;

use std::fmt;

use crate::Span;

pub use decimal::Decimal;
pub use error::{QuantityError, QuantityFault};
pub use range::{QuantityRange, is_range};
pub use units::Unit;
use units::{PERCENT, SECOND, unit_length};

/// An exact number with its unit, as written.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Quantity {
    /// The number.
    pub number: Decimal,
    /// Its unit, [`Unit::NONE`] for a plain number.
    pub unit: Unit,
}

impl Quantity {
    /// Reads a number with its unit, such as `24 V`, `200kHz`, `-21.5 °C` or `10 %`; without a unit it is a plain
    /// number. A duration may have several parts, as in `1 min 30 s`, and is in seconds then.
    ///
    /// The number is an exact decimal with optional `_` between digits. The unit may be any word of letters.
    ///
    /// # Errors
    /// [`QuantityError`] with the byte of the first fault.
    pub fn parse(text: &str) -> Result<Quantity, QuantityError> {
        PlacedQuantity::read(text, 0).map(|placed| placed.quantity)
    }

    /// The number in another unit, exactly. `None` where the two are not of one kind, or where the other is
    /// `min`, `h` or `d`, in which few numbers of seconds are decimals.
    pub fn in_unit(&self, unit: &Unit) -> Option<Decimal> {
        if self.unit == *unit {
            return Some(self.number);
        }
        let (number, base) = self.in_base()?;
        let other = unit.scale().filter(|other| other.base == base && other.factor == 1)?;
        Some(number.shifted(-other.power))
    }

    /// The number in the base unit of its kind; `None` for units that the table does not know.
    fn in_base(&self) -> Option<(Decimal, &'static str)> {
        let scale = self.unit.scale()?;
        Some((self.number.times(Decimal::from(i128::from(scale.factor)))?.shifted(scale.power), scale.base))
    }

    /// The duration, if it is one of whole nanoseconds within ±292 years.
    pub fn as_span(&self) -> Option<Span> {
        self.span().ok()
    }

    /// Whether the unit is one of time.
    pub fn is_time(&self) -> bool {
        self.unit.is_of(SECOND)
    }

    /// Whether it is a part of something: in `%` or `ppm`.
    pub fn is_part(&self) -> bool {
        self.unit.is_of(PERCENT)
    }

    fn span(&self) -> Result<Span, QuantityFault> {
        if self.unit.is_none() {
            return Err(QuantityFault::MissingUnit);
        }
        if !self.is_time() {
            return Err(QuantityFault::NoTime);
        }
        let nanos = self.in_base().ok_or(QuantityFault::TooLong)?.0.shifted(9);
        if !nanos.is_whole() {
            return Err(QuantityFault::TooFine);
        }
        let nanos = nanos.as_whole().and_then(|nanos| i64::try_from(nanos).ok());
        nanos.map(Span::from_nanos).ok_or(QuantityFault::TooLong)
    }
}

impl fmt::Display for Quantity {
    /// `24 V`, `1500 mV`, `42`. Reads back with [`Quantity::parse`].
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.unit.is_none() { self.number.fmt(f) } else { write!(f, "{} {}", self.number, self.unit) }
    }
}

/// A quantity with its places in the text.
#[derive(Clone)]
struct PlacedQuantity {
    quantity: Quantity,
    /// Where it begins.
    at: usize,
    /// Where its unit begins.
    unit_at: usize,
}

impl PlacedQuantity {
    /// Reads all of a text, which itself begins at the byte `from` of the whole.
    fn read(text: &str, from: usize) -> Result<PlacedQuantity, QuantityError> {
        let place = |rest: &str| from + text.len() - rest.len();
        let (mut placed, mut rest) = PlacedQuantity::part(text, from)?;
        if rest.is_empty() {
            return Ok(placed);
        }
        if !placed.quantity.is_time() {
            return Err(QuantityFault::Trailing.at(place(rest)));
        }
        let sign = if text.trim_start().starts_with('-') { -1 } else { 1 };
        let mut nanos = placed.span()?.as_nanos();
        while !rest.is_empty() {
            let at = place(rest);
            if !rest.starts_with(|c: char| c.is_ascii_digit()) {
                return Err(QuantityFault::Number.at(at));
            }
            let (part, after) = PlacedQuantity::part(rest, at)?;
            let sum = nanos.checked_add(sign * part.span()?.as_nanos());
            nanos = sum.ok_or(QuantityFault::TooLong.at(placed.at))?;
            rest = after;
        }
        placed.quantity = Quantity::from(Span::from_nanos(nanos));
        Ok(placed)
    }

    /// Reads one number with its unit, and gives what stands after it.
    fn part(text: &str, from: usize) -> Result<(PlacedQuantity, &str), QuantityError> {
        let (number, rest) = Decimal::split(text).map_err(|error| error.fault.at(error.at + from))?;
        let place = |rest: &str| from + text.len() - rest.len();
        let word = &rest[..unit_length(rest)];
        // `1s500ms`: after a unit of time the next number may follow at once.
        let letters = &word[..word.find(char::is_numeric).unwrap_or(word.len())];
        let unit = if Unit::new(letters).is_of(SECOND) { letters } else { word };
        let quantity = Quantity { number, unit: Unit::new(unit) };
        let placed = PlacedQuantity { quantity, at: place(text.trim_start()), unit_at: place(rest) };
        Ok((placed, rest[unit.len()..].trim_start()))
    }

    /// The duration that it is.
    fn span(&self) -> Result<Span, QuantityError> {
        self.quantity.span().map_err(|fault| {
            let at = if fault == QuantityFault::NoTime { self.unit_at } else { self.at };
            fault.at(at)
        })
    }
}

impl From<Span> for Quantity {
    /// The duration in seconds.
    fn from(span: Span) -> Self {
        Quantity { number: Decimal::new(i128::from(span.as_nanos()), -9), unit: Unit::new(SECOND) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn of(text: &str) -> Quantity {
        Quantity::parse(text).unwrap()
    }

    fn in_unit(text: &str, unit: &str) -> Option<String> {
        of(text).in_unit(&Unit::new(unit)).map(|number| number.to_string())
    }

    #[test]
    fn quantities_keep_their_unit() {
        for (text, same) in [
            ("200kHz", "200 kHz"),
            ("-21.5 °C", "-21.5 degC"),
            ("4.70 kΩ", "4.7 kOhm"),
            ("60_000", "60000"),
            ("10 l/min", "10 l/min"),
            ("5 m3/h", "5 m3/h"),
            ("1 min 30 s", "90 s"),
            ("1s500ms", "1.5 s"),
            ("- 1 min 30 s", "-90 s"),
            ("1.5 h", "1.5 h"),
        ] {
            assert_eq!(of(text).to_string(), same, "{text}");
        }
    }

    #[test]
    fn units_of_one_kind_convert_exactly() {
        let some = |text: &str| Some(text.to_owned());
        assert_eq!(in_unit("1500 mV", "V"), some("1.5"));
        assert_eq!(in_unit("0.3 V", "mV"), some("300"));
        assert_eq!(in_unit("200 kHz", "mHz"), some("200000000"));
        assert_eq!(in_unit("1.5 bar", "kPa"), some("150"));
        assert_eq!(in_unit("50 ppm", "%"), some("0.005"));
        assert_eq!(in_unit("1.5 min", "ms"), some("90000"));
        assert_eq!(in_unit("1.5 h", "h"), some("1.5"));
        assert_eq!(in_unit("20 °C", "degC"), some("20"));
        assert_eq!(in_unit("3 l/min", "l/min"), some("3"));
        for (text, unit) in
            [("1 V", "A"), ("90 min", "h"), ("1", "V"), ("1 V", ""), ("1 l/min", "ml/min"), ("1 l/h", "h")]
        {
            assert_eq!(in_unit(text, unit), None, "{text} in {unit}");
        }
        assert_eq!(of("2.5 min").as_span(), Some(Span::from_secs(150)));
        assert_eq!(of("0.5 ns").as_span(), None);
        assert_eq!(of("2 V").as_span(), None);
    }

    #[test]
    fn faults_name_their_place() {
        use QuantityFault as F;
        let fault = |text: &str| Quantity::parse(text).unwrap_err();
        assert_eq!(fault("  "), F::Empty.at(2));
        assert_eq!(fault("V"), F::Number.at(0));
        assert_eq!(fault("24 V 3"), F::Trailing.at(5));
        assert_eq!(fault("24 V#"), F::Trailing.at(4));
        assert_eq!(fault("24 a_word"), F::Trailing.at(4));
        assert_eq!(fault("1 s 30"), F::MissingUnit.at(4));
        assert_eq!(fault("1 s 30 V"), F::NoTime.at(7));
        assert_eq!(fault("1 min -30 s"), F::Number.at(6));
        assert_eq!(fault("1 s 0.1 ns"), F::TooFine.at(4));
    }

    fn any_quantity() -> impl Strategy<Value = Quantity> {
        let unit = prop::sample::select(vec!["", "V", "mV", "degC", "l/min", "ms", "h", "%", "m3"]);
        (decimal::tests::any_decimal(), unit)
            .prop_map(|(number, unit)| Quantity { number, unit: Unit::new(unit) })
    }

    proptest! {
        #[test]
        fn what_is_written_reads_back(quantity in any_quantity()) {
            prop_assert_eq!(Quantity::parse(&quantity.to_string()), Ok(quantity));
        }

        #[test]
        fn no_text_panics(text in "\\PC*", near in "([-+]?[0-9._]{0,32} ?(\\PC{0,2}|[mkµ]?[sVhd%]|min)){0,4}") {
            for text in [text, near] {
                match Quantity::parse(&text) {
                    Err(error) => prop_assert!(text.is_char_boundary(error.at)),
                    Ok(read) => prop_assert_eq!(Quantity::parse(&read.to_string()), Ok(read)),
                }
            }
        }
    }
}
