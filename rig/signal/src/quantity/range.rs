//! Ranges of quantities and of durations: `4 .. 20 mA`, `.. 5 V`, `24 V ± 10 %`.

use std::fmt;

use super::{Dimension, ParseQuantityError, Quantity, Scanned};
use crate::Span;

/// All quantities of one dimension from `min` to `max`, both included; an end that is missing is open.
///
/// From [`QuantityRange::parse`] at least one end is there, both are of one dimension, and `min <= max`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct QuantityRange {
    /// The smallest one.
    pub min: Option<Quantity>,
    /// The largest one.
    pub max: Option<Quantity>,
}

/// All durations from `min` to `max`, both included; an end that is missing is open.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct SpanRange {
    /// The shortest one.
    pub min: Option<Span>,
    /// The longest one.
    pub max: Option<Span>,
}

impl QuantityRange {
    /// Reads `a .. b`, `.. b`, `a ..`, `x ± y` or `x +- y`.
    ///
    /// A beginning without a unit has the unit of the end (`4 .. 20 mA`). A tolerance in percent is relative,
    /// unless the quantity itself is in percent: `24 V ± 10 %`, but `50 % ± 5 %` is `45 % .. 55 %`.
    ///
    /// # Errors
    /// [`ParseQuantityError`] with the byte of the first fault in the whole text.
    pub fn parse(text: &str) -> Result<QuantityRange, ParseQuantityError> {
        if let Some((left, right, right_at)) = split(text, &[".."]) {
            return ends(left, right, right_at);
        }
        if let Some((left, right, right_at)) = split(text, &["±", "+-", "+/-"]) {
            return tolerance(left, right, right_at);
        }
        // A fault in the single quantity is worth more than that there is only one.
        Quantity::parse(text)?;
        Err(ParseQuantityError::NotARange)
    }

    /// What it is a range of, by the end that is there.
    pub fn dimension(&self) -> Option<Dimension> {
        self.min.or(self.max).map(Quantity::dimension)
    }

    /// Whether the quantity is within the range; one of another dimension is not.
    pub fn contains(&self, quantity: Quantity) -> bool {
        self.min.is_none_or(|min| min <= quantity) && self.max.is_none_or(|max| quantity <= max)
    }
}

impl SpanRange {
    /// Reads a range of durations, as [`QuantityRange::parse`] does.
    ///
    /// # Errors
    /// [`ParseQuantityError`]; its `Dimension` variant if the range is one of anything else.
    pub fn parse(text: &str) -> Result<SpanRange, ParseQuantityError> {
        let range = QuantityRange::parse(text)?;
        let span = |end: Option<Quantity>| match end {
            None => Ok(None),
            Some(quantity) if quantity.dimension() == Dimension::Time => {
                quantity.as_span().map(Some).ok_or(ParseQuantityError::TooLarge(0))
            }
            Some(quantity) => Err(ParseQuantityError::Dimension {
                at: first_word(text),
                expected: Dimension::Time,
                found: quantity.dimension(),
            }),
        };
        Ok(SpanRange { min: span(range.min)?, max: span(range.max)? })
    }

    /// Whether the duration is within the range.
    pub fn contains(&self, span: Span) -> bool {
        self.min.is_none_or(|min| min <= span) && self.max.is_none_or(|max| span <= max)
    }
}

/// The text before and behind the first of the separators, and where the text behind begins.
fn split<'a>(text: &'a str, separators: &[&str]) -> Option<(&'a str, &'a str, usize)> {
    let (at, length) = separators.iter().filter_map(|s| text.find(s).map(|at| (at, s.len()))).min()?;
    Some((&text[..at], &text[at + length..], at + length))
}

/// The byte of the first character that is no space, or the end.
fn first_word(text: &str) -> usize {
    text.len() - text.trim_ascii_start().len()
}

fn ends(left: &str, right: &str, right_at: usize) -> Result<QuantityRange, ParseQuantityError> {
    let scan =
        |text: &str| if text.trim_ascii().is_empty() { Ok(None) } else { Scanned::read(text).map(Some) };
    let min = scan(left)?;
    let max = scan(right).map_err(|error| error.moved(right_at))?;
    let lent = max.as_ref().and_then(|max| max.unit);
    let min = min.map(|min| min.with_unit(lent)).transpose()?;
    let max = max.map(|max| max.with_unit(None)).transpose().map_err(|error| error.moved(right_at))?;
    let at = right_at + first_word(right);
    match (min, max) {
        (None, None) => return Err(ParseQuantityError::OpenAtBothEnds),
        (Some(min), Some(max)) if min.dimension() != max.dimension() => {
            return Err(ParseQuantityError::Dimension {
                at,
                expected: min.dimension(),
                found: max.dimension(),
            });
        }
        (Some(min), Some(max)) if min > max => return Err(ParseQuantityError::Reversed(at)),
        _ => {}
    }
    Ok(QuantityRange { min, max })
}

fn tolerance(left: &str, right: &str, right_at: usize) -> Result<QuantityRange, ParseQuantityError> {
    let middle = Scanned::read(left)?;
    let scanned = Scanned::read(right).map_err(|error| error.moved(right_at))?;
    let band = scanned.with_unit(None).map_err(|error| error.moved(right_at))?;
    let relative = band.dimension() == Dimension::Ratio;
    let middle = middle.with_unit(if relative { None } else { scanned.unit })?;
    let at = right_at + first_word(right);
    if band.as_nano() < 0 {
        return Err(ParseQuantityError::NegativeTolerance(at));
    }
    let width = if band.dimension() == middle.dimension() {
        band.as_nano()
    } else if relative {
        let hundred = 100 * super::NANO;
        let product =
            middle.as_nano().abs().checked_mul(band.as_nano()).ok_or(ParseQuantityError::TooLarge(at))?;
        if product % hundred != 0 {
            return Err(ParseQuantityError::TooFine(at));
        }
        product / hundred
    } else {
        let (expected, found) = (middle.dimension(), band.dimension());
        return Err(ParseQuantityError::Dimension { at, expected, found });
    };
    let end = |nano: Option<i128>| match nano {
        Some(nano) => Ok(Some(Quantity::new(nano, middle.dimension()))),
        None => Err(ParseQuantityError::TooLarge(at)),
    };
    Ok(QuantityRange {
        min: end(middle.as_nano().checked_sub(width))?,
        max: end(middle.as_nano().checked_add(width))?,
    })
}

fn write_range<T: fmt::Display>(f: &mut fmt::Formatter<'_>, min: Option<T>, max: Option<T>) -> fmt::Result {
    if let Some(min) = min {
        write!(f, "{min} ")?;
    }
    f.write_str("..")?;
    if let Some(max) = max {
        write!(f, " {max}")?;
    }
    Ok(())
}

impl fmt::Display for QuantityRange {
    /// `4 mA .. 20 mA`, `.. 5 V` or `5 V ..`. Reads back with [`QuantityRange::parse`].
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_range(f, self.min, self.max)
    }
}

impl fmt::Display for SpanRange {
    /// `100 ms .. 100.3 ms`. Reads back with [`SpanRange::parse`].
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_range(f, self.min, self.max)
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::any_quantity;
    use super::*;
    use ParseQuantityError as E;
    use proptest::prelude::*;

    fn at(text: &str) -> QuantityRange {
        QuantityRange::parse(text).unwrap()
    }

    #[test]
    fn ranges_are_exact() {
        for (text, same) in [
            ("4 .. 20 mA", "4 mA .. 20 mA"),
            ("4mA..20mA", "4 mA .. 20 mA"),
            ("-5 .. -1.5", "-5 .. -1.5"),
            (".. 5 V", ".. 5 V"),
            ("5 V ..", "5 V .."),
            ("0 .. 10 V", "0 V .. 10 V"),
            ("12 mA ± 1 mA", "11 mA .. 13 mA"),
            ("100 ± 5 ms", "95 ms .. 105 ms"),
            ("100 ms +- 0.3 ms", "99.7 ms .. 100.3 ms"),
            ("-10 +/- 1", "-11 .. -9"),
            ("24 V ± 10 %", "21.6 V .. 26.4 V"),
            ("1000 ± 10 %", "900 .. 1100"),
            ("-24 V ± 10 %", "-26.4 V .. -21.6 V"),
            ("50 % ± 5 %", "45 % .. 55 %"),
            ("1 min .. 1 min 30 s", "60 s .. 90 s"),
        ] {
            assert_eq!(at(text).to_string(), same, "{text}");
        }
        let quantity = |text| Quantity::parse(text).unwrap();
        assert!(at(".. 5 V").contains(quantity("5 V")) && !at(".. 5 V").contains(quantity("5 A")));
        let range = SpanRange::parse("100 ms .. 100.3 ms").unwrap();
        assert!(range.contains(Span::from_millis(100)) && range.contains(Span::from_micros(100_300)));
        assert!(
            !range.contains(Span::from_nanos(100_300_001)) && !range.contains(Span::from_nanos(99_999_999))
        );
    }

    #[test]
    fn faults_name_their_place_in_the_whole_text() {
        let fault = |text: &str| QuantityRange::parse(text).unwrap_err();
        let (current, voltage) = (Dimension::Current, Dimension::Voltage);
        assert_eq!(fault(""), E::Empty(0));
        assert_eq!(fault("5 V"), E::NotARange);
        assert_eq!(fault("5 Volt"), E::UnknownUnit(2));
        assert_eq!(fault(" .. "), E::OpenAtBothEnds);
        assert_eq!(fault("4 .. 20 mAh"), E::UnknownUnit(8));
        assert_eq!(fault("4 .. twenty"), E::Number(5));
        assert_eq!(fault("4 mA .. 20 V"), E::Dimension { at: 8, expected: current, found: voltage });
        assert_eq!(fault("4 mA .. 20"), E::Dimension { at: 8, expected: current, found: Dimension::Number });
        assert_eq!(fault("20 mA .. 4 mA"), E::Reversed(9));
        assert_eq!(fault("24 V ± -1 V"), E::NegativeTolerance(8));
        assert_eq!(fault("24 V ± 1 mA"), E::Dimension { at: 8, expected: voltage, found: current });
        assert_eq!(fault("24 V ±"), E::Empty(7));
        assert_eq!(fault("1 ns ± 10 %"), E::TooFine(8));
        assert_eq!(
            SpanRange::parse("1 V .. 2 V"),
            Err(E::Dimension { at: 0, expected: Dimension::Time, found: voltage })
        );
    }

    proptest! {
        #[test]
        fn what_is_written_reads_back(a in any_quantity(), b in any_quantity(), open in 0..3) {
            let b = Quantity::new(b.as_nano(), a.dimension());
            let (min, max) = if a <= b { (a, b) } else { (b, a) };
            let range = QuantityRange { min: (open != 1).then_some(min), max: (open != 2).then_some(max) };
            prop_assert_eq!(QuantityRange::parse(&range.to_string()), Ok(range));
        }

        #[test]
        fn no_text_panics(text in "\\PC{0,6}(\\.\\.|±|\\+-)?[-+0-9. ]{0,30}[%Vm]?s?") {
            if let Err(error) = QuantityRange::parse(&text) {
                prop_assert!(error.offset() <= text.len());
            }
            let _ = SpanRange::parse(&text);
        }
    }
}
