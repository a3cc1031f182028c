//! Numbers and texts.

/// Why a literal cannot be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SourceLiteralFault {
    /// Underscores may only stand singly between digits.
    Underscore,
    /// The base is not 2, 8 or 16.
    Base,
    /// A digit that the base does not have, or none at all.
    Digit,
    /// More than 64 bits.
    TooLarge,
    /// Beyond the largest LREAL.
    TooLargeReal,
    /// Not 0, and below the least normal magnitude of LREAL (controller:DT-01).
    TooSmallReal,
    /// Not of the form `T#1d2h3m4s5ms`.
    Duration,
    /// Negative durations do not exist.
    Negative,
    /// A TIME finer than a millisecond.
    TooFine,
    /// An LTIME finer than a nanosecond.
    FinerThanNanoseconds,
    /// Beyond `T#4294967295ms` (controller:DT-01).
    TooLong,
    /// Beyond 2^63 - 1 nanoseconds.
    TooLongLong,
    /// Not of the form `2024-02-29`.
    Date,
    /// A day that no calendar has.
    NoSuchDay,
    /// Before 1970 or after the last day of the type.
    OutsideCalendar,
    /// Not of the form `23:59:59.999`.
    TimeOfDay,
    /// A clock never shows this.
    NoSuchTime,
    /// Neither a date nor a time of day with it.
    DateAndTime,
    /// A date with a time finer than its type.
    FinerThanType,
    /// A character beyond ISO 8859-1 in a STRING.
    Character,
    /// `$` before what it does not escape.
    Escape,
    /// CHAR and WCHAR hold exactly one character.
    OneCharacter,
}

impl SourceLiteralFault {
    /// What is wrong and how to fix it.
    pub(crate) fn text(self) -> (&'static str, &'static str) {
        match self {
            Self::Underscore => ("an underscore is misplaced", "use single underscores between digits"),
            Self::Base => ("there is no such base", "use 2#, 8# or 16#"),
            Self::Digit => ("a digit does not exist in this base", "use the digits of the base before #"),
            Self::TooLarge => ("the number does not fit into 64 bits", "the largest is 18446744073709551615"),
            Self::TooLargeReal => ("the number is beyond LREAL", "the largest is about 1.797E308"),
            Self::TooSmallReal => {
                ("the number is too small for LREAL", "the least beside 0 is about 2.225E-308")
            }
            Self::Duration => ("this is no duration", "write it as in T#1d2h3m4s5ms, largest unit first"),
            Self::Negative => ("durations are never negative", "write a difference, as in a - T#5s"),
            Self::TooFine => ("TIME counts whole milliseconds", "use LTIME# for finer durations"),
            Self::FinerThanNanoseconds => ("LTIME counts whole nanoseconds", "round it"),
            Self::TooLong => (
                "the duration is beyond the end of TIME",
                "the longest is T#4294967295ms, almost 50 days; use LTIME# for longer ones",
            ),
            Self::TooLongLong => (
                "the duration is beyond the end of LTIME",
                "the longest is 9223372036854775807 ns, 292 years",
            ),
            Self::Date => ("this is no date", "write it as in D#2024-02-29"),
            Self::NoSuchDay => {
                ("there is no such day", "months go from 1 to 12, days to the end of the month")
            }
            Self::OutsideCalendar => (
                "the date is outside the range of its type",
                "dates go from 1970-01-01 to 2106-02-07, those of LDATE and LDT to 2262-04-11",
            ),
            Self::TimeOfDay => ("this is no time of day", "write it as in TOD#23:59:59.999"),
            Self::NoSuchTime => ("there is no such time of day", "the last one is 23:59:59.999"),
            Self::DateAndTime => ("this is no date with a time", "write it as in DT#2024-02-29-23:59:59"),
            Self::FinerThanType => (
                "the time is finer than its type",
                "TOD counts milliseconds, DT seconds; LTOD and LDT count nanoseconds",
            ),
            Self::Character => (
                "a STRING has no such character, only those of ISO 8859-1",
                "use a WSTRING, in double quotation marks",
            ),
            Self::Escape => (
                "$ is followed by something that it does not escape",
                "write $$ for the sign itself; $' $\" $L $N $P $R $T and hexadecimal digits have a meaning, \
                 two in a STRING and four in a WSTRING",
            ),
            Self::OneCharacter => ("this is not one character", "write one character between the marks"),
        }
    }
}

/// `12`, `1_000`, `16#FF`.
pub(crate) fn number(text: &str) -> Result<i128, SourceLiteralFault> {
    let (base, digits) = match text.split_once('#') {
        None => (10, text),
        Some(("2", digits)) => (2, digits),
        Some(("8", digits)) => (8, digits),
        Some(("16", digits)) => (16, digits),
        Some(_) => return Err(SourceLiteralFault::Base),
    };
    underscores(digits)?;
    if digits.is_empty() {
        return Err(SourceLiteralFault::Digit);
    }
    let mut number = 0i128;
    for digit in digits.chars().filter(|c| *c != '_') {
        let digit = digit.to_digit(base).ok_or(SourceLiteralFault::Digit)?;
        number = number * i128::from(base) + i128::from(digit);
        if number > i128::from(u64::MAX) {
            return Err(SourceLiteralFault::TooLarge);
        }
    }
    Ok(number)
}

/// Single ones between digits are fine.
pub(super) fn underscores(digits: &str) -> Result<(), SourceLiteralFault> {
    let misplaced = |part: &str| part.starts_with('_') || part.ends_with('_') || part.contains("__");
    if digits.split(['.', 'e', 'E', '+', '-']).any(misplaced) {
        return Err(SourceLiteralFault::Underscore);
    }
    Ok(())
}

/// The nearest double and the nearest single of `1.5`, `1_000.0E-3`, `1e10`.
pub(crate) fn real(text: &str) -> Result<(f64, f32), SourceLiteralFault> {
    underscores(text)?;
    let plain: String = text.chars().filter(|c| *c != '_').collect();
    let (double, single) = match (plain.parse::<f64>(), plain.parse::<f32>()) {
        (Ok(double), Ok(single)) => (double, single),
        _ => return Err(SourceLiteralFault::Digit),
    };
    // The number itself may have been too small for anything but a 0.
    let mantissa = plain.split(['e', 'E']).next().unwrap_or_default();
    let zero = double == 0.0 && !mantissa.contains(|digit: char| digit.is_ascii_digit() && digit != '0');
    match double {
        _ if !double.is_finite() => Err(SourceLiteralFault::TooLargeReal),
        _ if !double.is_normal() && !zero => Err(SourceLiteralFault::TooSmallReal),
        _ => Ok((double, single)),
    }
}

/// The characters of `'text'` or `"text"`: ISO 8859-1, or UTF-16 where wide.
pub(crate) fn text(literal: &str) -> Result<(bool, Vec<u16>), SourceLiteralFault> {
    let wide = literal.starts_with('"');
    let inner = literal.get(1..literal.len().saturating_sub(1)).unwrap_or("");
    let mut units = Vec::with_capacity(inner.len());
    let mut rest = inner.chars();
    while let Some(c) = rest.next() {
        if c == '$' {
            units.push(escaped(&mut rest, wide)?);
        } else if wide {
            units.extend_from_slice(c.encode_utf16(&mut [0; 2]));
        } else {
            let unit = u8::try_from(c).map_err(|_| SourceLiteralFault::Character)?;
            units.push(u16::from(unit));
        }
    }
    Ok((wide, units))
}

/// What stands after `$`. `$N` is one character, 16#0A.
fn escaped(rest: &mut std::str::Chars<'_>, wide: bool) -> Result<u16, SourceLiteralFault> {
    let first = rest.next().ok_or(SourceLiteralFault::Escape)?;
    Ok(match first {
        '$' | '\'' | '"' => first as u16,
        'L' | 'l' | 'N' | 'n' => 0x0A,
        'P' | 'p' => 0x0C,
        'R' | 'r' => 0x0D,
        'T' | 't' => 0x09,
        _ => {
            let mut unit = first.to_digit(16).ok_or(SourceLiteralFault::Escape)?;
            for _ in 1..if wide { 4 } else { 2 } {
                let digit = rest.next().and_then(|c| c.to_digit(16)).ok_or(SourceLiteralFault::Escape)?;
                unit = unit << 4 | digit;
            }
            unit as u16
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers() {
        assert_eq!(number("1_000"), Ok(1000));
        assert_eq!(number("16#FFFF_FFFF_ffff_FFFF"), Ok(i128::from(u64::MAX)));
        assert_eq!(number("2#1010"), Ok(10));
        assert_eq!(number("8#17"), Ok(15));
        assert_eq!(number("2#12"), Err(SourceLiteralFault::Digit));
        assert_eq!(number("16#"), Err(SourceLiteralFault::Digit));
        assert_eq!(number("3#1"), Err(SourceLiteralFault::Base));
        assert_eq!(number("1__0"), Err(SourceLiteralFault::Underscore));
        assert_eq!(number("18446744073709551615"), Ok(i128::from(u64::MAX)));
        assert_eq!(number("18446744073709551616"), Err(SourceLiteralFault::TooLarge));
    }

    #[test]
    fn reals() {
        assert_eq!(real("1_000.5"), Ok((1000.5, 1000.5)));
        assert_eq!(real("1E3"), Ok((1000.0, 1000.0)));
        assert_eq!(real("1.0e-3"), Ok((0.001, 0.001)));
        // The nearest single is not the nearest single of the nearest double.
        let halfway = "1.00000005960464477539062500000000000000000000000000001";
        let (double, single) = real(halfway).unwrap();
        assert_eq!((double as f32, single), (1.0, 1.000_000_1));
        assert_eq!(real("1.0E39").unwrap().1, f32::INFINITY);
        assert_eq!(real("1.0E309"), Err(SourceLiteralFault::TooLargeReal));
        for small in ["2.2250738585072011E-308", "4.9E-324", "1.0E-400"] {
            assert_eq!(real(small), Err(SourceLiteralFault::TooSmallReal), "{small}");
        }
        assert_eq!(real("2.2250738585072014E-308").unwrap().0, f64::MIN_POSITIVE);
        assert_eq!(real("0.0E-400"), Ok((0.0, 0.0)));
        assert_eq!(real("1_.0"), Err(SourceLiteralFault::Underscore));
        assert_eq!(real("1.0_E1"), Err(SourceLiteralFault::Underscore));
    }

    #[test]
    fn texts() {
        let narrow = |s: &str| {
            text(s).map(|(wide, units)| {
                assert!(!wide);
                units
            })
        };
        let wide = |s: &str| {
            text(s).map(|(wide, units)| {
                assert!(wide);
                units
            })
        };
        assert_eq!(narrow("''"), Ok(vec![]));
        assert_eq!(narrow("'a$$$'$\"b'"), Ok("a$'\"b".bytes().map(u16::from).collect()));
        assert_eq!(narrow("'$L$l$N$n$P$R$T'"), Ok(vec![10, 10, 10, 10, 12, 13, 9]));
        assert_eq!(narrow("'$41$fF\u{e9}'"), Ok(vec![0x41, 0xFF, 0xE9]));
        assert_eq!(narrow("'\u{20ac}'"), Err(SourceLiteralFault::Character));
        assert_eq!(narrow("'$4'"), Err(SourceLiteralFault::Escape));
        assert_eq!(narrow("'$x'"), Err(SourceLiteralFault::Escape));
        assert_eq!(wide("\"\u{20ac}\u{1f600}$263A\""), Ok(vec![0x20AC, 0xD83D, 0xDE00, 0x263A]));
        assert_eq!(wide("\"$41\""), Err(SourceLiteralFault::Escape));
    }
}
