//! Ranges of quantities and of durations: `4 .. 20 mA`, `.. 5 V`, `24 V ± 10 %`.

use super::{Decimal, PlacedQuantity, Quantity, QuantityError, QuantityFault, Unit};
use crate::Span;

/// All quantities from `min` to `max`, both included; an end that is missing is open.
///
/// From [`QuantityRange::parse`] at least one end is there, both are of one kind, and `min <= max`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct QuantityRange {
    /// The smallest one.
    pub min: Option<Quantity>,
    /// The largest one.
    pub max: Option<Quantity>,
}

/// How the ends of a range are parted.
const ENDS: &str = "..";
/// How a tolerance is parted from the quantity that it is around.
const AROUND: [&str; 3] = ["±", "+-", "+/-"];

/// Whether a text is written as a range, and not as a single quantity.
pub fn is_range(text: &str) -> bool {
    text.contains(ENDS) || AROUND.iter().any(|sign| text.contains(sign))
}

impl QuantityRange {
    /// Reads `a .. b`, `.. b`, `a ..`, `x ± y` (or `+-`, `+/-`), or a single quantity, which is both ends.
    ///
    /// What stands in front without a unit has the unit of what stands after: `4 .. 20 mA`, `100 ± 0.3 ms`. A
    /// tolerance in percent is relative, unless the quantity itself is in percent: `24 V ± 10 %`, but
    /// `50 % ± 5 %` is `45 % .. 55 %`.
    ///
    /// # Errors
    /// [`QuantityError`] with the byte of the first fault in the whole text.
    pub fn parse(text: &str) -> Result<QuantityRange, QuantityError> {
        match WrittenRange::read(text)? {
            WrittenRange::Ends(min, max) => {
                if let (Some(min), Some(max)) = (&min, &max) {
                    let numbers = common(&min.quantity, &max.quantity);
                    let (low, high, _) = numbers.ok_or(QuantityFault::Units.at(max.at))?;
                    if low > high {
                        return Err(QuantityFault::Reversed.at(max.at));
                    }
                }
                let quantity = |end: Option<PlacedQuantity>| end.map(|end| end.quantity);
                Ok(QuantityRange { min: quantity(min), max: quantity(max) })
            }
            WrittenRange::Around(middle, band) => {
                QuantityRange::around(&middle.quantity, &band.quantity).map_err(|fault| fault.at(band.at))
            }
        }
    }

    /// What is at most `band` away from `middle`; `band` may be relative, as [`QuantityRange::parse`] has it.
    ///
    /// # Errors
    /// [`QuantityFault`]: the two are not of one kind, `band` is below 0, or the ends have too many digits.
    pub fn around(middle: &Quantity, band: &Quantity) -> Result<QuantityRange, QuantityFault> {
        if band.number.is_negative() {
            return Err(QuantityFault::Negative);
        }
        let relative = band.is_part() && !middle.is_part();
        let (number, width, unit) = if relative {
            let part = band.in_base().and_then(|(percent, _)| middle.number.abs().times(percent));
            (middle.number, part.ok_or(QuantityFault::TooLarge)?.shifted(-2), middle.unit.clone())
        } else {
            common(middle, band).ok_or(QuantityFault::Units)?
        };
        let end = |number: Option<Decimal>| match number {
            Some(number) => Ok(Some(Quantity { number, unit: unit.clone() })),
            None => Err(QuantityFault::TooLarge),
        };
        Ok(QuantityRange { min: end(number.minus(width))?, max: end(number.plus(width))? })
    }
}

impl Span {
    /// Reads a range of durations of at least 0, as [`QuantityRange::parse`] does: the shortest and the longest,
    /// both included. An end that is open is 0 or [`Span::MAX`]; a tolerance does not reach below 0.
    ///
    /// # Errors
    /// [`QuantityError`] with the byte of the first fault in the whole text.
    pub fn parse_range(text: &str) -> Result<(Span, Span), QuantityError> {
        let duration = |one: &PlacedQuantity| match one.span()? {
            span if span.is_negative() => Err(QuantityFault::Negative.at(one.at)),
            span => Ok(span),
        };
        match WrittenRange::read(text)? {
            WrittenRange::Ends(min, max) => {
                let shortest = min.as_ref().map_or(Ok(Span::ZERO), duration)?;
                let longest = max.as_ref().map_or(Ok(Span::MAX), duration)?;
                let at = max.map_or(0, |max| max.at);
                if shortest > longest { Err(QuantityFault::Reversed.at(at)) } else { Ok((shortest, longest)) }
            }
            WrittenRange::Around(middle, band) => {
                duration(&middle)?;
                let place = |fault: QuantityFault| fault.at(band.at);
                let range = QuantityRange::around(&middle.quantity, &band.quantity).map_err(place)?;
                let end = |end: Option<Quantity>| end.map_or(Ok(Span::ZERO), |end| end.span()).map_err(place);
                Ok((end(range.min)?.max(Span::ZERO), end(range.max)?))
            }
        }
    }
}

/// A range as written, every quantity with its unit.
enum WrittenRange {
    Ends(Option<PlacedQuantity>, Option<PlacedQuantity>),
    Around(PlacedQuantity, PlacedQuantity),
}

impl WrittenRange {
    fn read(text: &str) -> Result<WrittenRange, QuantityError> {
        if let Some(at) = text.find(ENDS) {
            let after = at + ENDS.len();
            let end = |text: &str, from: usize| match text.trim().is_empty() {
                true => Ok(None),
                false => PlacedQuantity::read(text, from).map(Some),
            };
            let (mut min, max) = (end(&text[..at], 0)?, end(&text[after..], after)?);
            match (&mut min, &max) {
                (None, None) => return Err(QuantityFault::NoEnds.at(at)),
                (Some(min), Some(max)) => min.lend(max),
                _ => {}
            }
            return Ok(WrittenRange::Ends(min, max));
        }
        let signs = AROUND.iter().filter_map(|sign| text.find(sign).map(|at| (at, sign.len())));
        if let Some((at, length)) = signs.min() {
            let after = at + length;
            let mut middle = PlacedQuantity::read(&text[..at], 0)?;
            let band = PlacedQuantity::read(&text[after..], after)?;
            if !band.quantity.is_part() {
                middle.lend(&band);
            }
            return Ok(WrittenRange::Around(middle, band));
        }
        let one = PlacedQuantity::read(text, 0)?;
        Ok(WrittenRange::Ends(Some(one.clone()), Some(one)))
    }
}

impl PlacedQuantity {
    /// Takes the unit of another one if it has none of its own.
    fn lend(&mut self, other: &PlacedQuantity) {
        if self.quantity.unit.is_none() {
            self.quantity.unit = other.quantity.unit.clone();
        }
    }
}

/// Both numbers in one unit, that of the first where that is exact; `None` if they are not of one kind.
fn common(a: &Quantity, b: &Quantity) -> Option<(Decimal, Decimal, Unit)> {
    if let Some(other) = b.in_unit(&a.unit) {
        return Some((a.number, other, a.unit.clone()));
    }
    let ((first, base), (second, other)) = (a.in_base()?, b.in_base()?);
    (base == other).then(|| (first, second, Unit::new(base)))
}

#[cfg(test)]
mod tests {
    use super::super::decimal::tests::any_decimal;
    use super::*;
    use QuantityFault as F;
    use proptest::prelude::*;

    fn range(text: &str) -> String {
        let range = QuantityRange::parse(text).unwrap();
        let show = |end: Option<Quantity>| end.map_or(String::from("open"), |end| end.to_string());
        format!("{} to {}", show(range.min), show(range.max))
    }

    #[test]
    fn ranges_are_exact() {
        for (text, same) in [
            ("4 .. 20 mA", "4 mA to 20 mA"),
            ("4mA..20mA", "4 mA to 20 mA"),
            ("-5 .. -1.5", "-5 to -1.5"),
            (".. 5 V", "open to 5 V"),
            ("5 V ..", "5 V to open"),
            ("500 mV .. 1 V", "500 mV to 1 V"),
            ("12 mA ± 1 mA", "11 mA to 13 mA"),
            ("100 ± 0.3 ms", "99.7 ms to 100.3 ms"),
            ("1 V +- 1 mV", "0.999 V to 1.001 V"),
            ("-10 +/- 1", "-11 to -9"),
            ("24 V ± 10 %", "21.6 V to 26.4 V"),
            ("-24 V ± 10 %", "-26.4 V to -21.6 V"),
            ("1000 ± 50 ppm", "999.95 to 1000.05"),
            ("50 % ± 5 %", "45 % to 55 %"),
            ("50 ± 5 %", "47.5 to 52.5"),
            ("1 h ± 5 min", "3300 s to 3900 s"),
            ("1 min .. 1 min 30 s", "1 min to 90 s"),
            ("2 .. 3 l/min", "2 l/min to 3 l/min"),
            ("5 V", "5 V to 5 V"),
        ] {
            assert_eq!(range(text), same, "{text}");
        }
        assert!(is_range("5 +- 1") && is_range(".. 5") && !is_range("-5.5 V"));
    }

    #[test]
    fn ranges_of_durations_are_exact() {
        let micros = |text: &str| {
            let (min, max) = Span::parse_range(text).unwrap();
            (min.as_nanos() / 1_000, max.as_nanos() / 1_000)
        };
        assert_eq!(micros("100 ± 0.3 ms"), (99_700, 100_300));
        assert_eq!(micros("100 .. 100.3 ms"), (100_000, 100_300));
        assert_eq!(micros("2 ms ± 5 ms"), (0, 7_000));
        assert_eq!(micros("10 ms ± 1 %"), (9_900, 10_100));
        assert_eq!(micros("1 min ± 1 s"), (59_000_000, 61_000_000));
        assert_eq!(micros(".. 5 ms").0, 0);
        assert_eq!(Span::parse_range("5 ms ..").unwrap().1, Span::MAX);
    }

    #[test]
    fn faults_name_their_place_in_the_whole_text() {
        let fault = |text: &str| QuantityRange::parse(text).unwrap_err();
        assert_eq!(fault(""), F::Empty.at(0));
        assert_eq!(fault(" .. "), F::NoEnds.at(1));
        assert_eq!(fault("4 .. 20 mA h"), F::Trailing.at(11));
        assert_eq!(fault("4 .. twenty"), F::Number.at(5));
        assert_eq!(fault("4 mA .. 20 V"), F::Units.at(8));
        assert_eq!(fault("4 mA .. 20"), F::Units.at(8));
        assert_eq!(fault("20 mA .. 4 mA"), F::Reversed.at(9));
        assert_eq!(fault("24 V ± -1 V"), F::Negative.at(8));
        assert_eq!(fault("24 V ± 1 mA"), F::Units.at(8));
        assert_eq!(fault("24 V ±"), F::Empty.at(7));
        let fault = |text: &str| Span::parse_range(text).unwrap_err();
        assert_eq!(fault("1 V .. 2 V"), F::NoTime.at(2));
        assert_eq!(fault("5 .. 6"), F::MissingUnit.at(0));
        assert_eq!(fault("5 ms .. 6 sec"), F::NoTime.at(10));
        assert_eq!(fault("-5 ms .. 6 ms"), F::Negative.at(0));
        assert_eq!(fault("6 ms .. 5 ms"), F::Reversed.at(8));
        assert_eq!(fault("5 ms ± -1 ms"), F::Negative.at(8));
        assert_eq!(fault("1 ns ± 10 %"), F::TooFine.at(8));
        assert_eq!(fault(" .. "), F::NoEnds.at(1));
    }

    proptest! {
        #[test]
        fn a_tolerance_is_the_range_of_its_ends(middle in any_decimal(), band in any_decimal()) {
            let band = band.abs();
            let (min, max) = (middle.minus(band).unwrap(), middle.plus(band).unwrap());
            let around = QuantityRange::parse(&format!("{middle} ± {band} V"));
            prop_assert_eq!(around, QuantityRange::parse(&format!("{min} .. {max} V")));
        }

        #[test]
        fn no_text_panics(text in "\\PC{0,6}(\\.\\.|±|\\+-)?[-+0-9. ]{0,30}[%Vm]?s?") {
            for error in [QuantityRange::parse(&text).err(), Span::parse_range(&text).err()].into_iter().flatten() {
                prop_assert!(text.is_char_boundary(error.at));
            }
        }
    }
}
