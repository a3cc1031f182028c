//! Numbers and durations.

/// Why a literal cannot be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum LiteralFault {
    /// Underscores may only stand singly between digits.
    Underscore,
    /// The base is not 2, 8 or 16.
    Base,
    /// A digit that the base does not have, or none at all.
    Digit,
    /// More than 64 bits.
    TooLarge,
    /// Not of the form `T#1d2h3m4s5ms`.
    Form,
    /// Negative durations do not exist.
    Negative,
    /// Finer than a millisecond.
    TooFine,
    /// Beyond `T#4294967295ms` (controller:DT-01).
    TooLong,
}

impl LiteralFault {
    pub(crate) fn text(self) -> (&'static str, &'static str) {
        match self {
            Self::Underscore => ("an underscore is misplaced", "use single underscores between digits"),
            Self::Base => ("there is no such base", "use 2#, 8# or 16#"),
            Self::Digit => ("a digit does not exist in this base", ""),
            Self::TooLarge => ("the number does not fit into 64 bits", ""),
            Self::Form => ("this is no duration", "write it as in T#1d2h3m4s5ms, largest unit first"),
            Self::Negative => ("TIME is never negative", ""),
            Self::TooFine => ("TIME counts whole milliseconds", ""),
            Self::TooLong => {
                ("the duration is beyond the end of TIME", "the longest is T#4294967295ms, almost 50 days")
            }
        }
    }
}

/// `12`, `1_000`, `16#FF`.
pub(crate) fn number(text: &str) -> Result<i128, LiteralFault> {
    let (base, digits) = match text.split_once('#') {
        None => (10, text),
        Some(("2", digits)) => (2, digits),
        Some(("8", digits)) => (8, digits),
        Some(("16", digits)) => (16, digits),
        Some(_) => return Err(LiteralFault::Base),
    };
    if digits.starts_with('_') || digits.ends_with('_') || digits.contains("__") {
        return Err(LiteralFault::Underscore);
    }
    if digits.is_empty() {
        return Err(LiteralFault::Digit);
    }
    let mut number = 0i128;
    for digit in digits.chars().filter(|c| *c != '_') {
        let digit = digit.to_digit(base).ok_or(LiteralFault::Digit)?;
        number = number * i128::from(base) + i128::from(digit);
        if number > i128::from(u64::MAX) {
            return Err(LiteralFault::TooLarge);
        }
    }
    Ok(number)
}

/// Milliseconds of `T#1h30m`, `TIME#1.5s`, `t#500ms`.
pub(crate) fn duration(text: &str) -> Result<i64, LiteralFault> {
    // Nanoseconds hold every fraction that can be written exactly.
    const UNITS: [(&str, i128); 7] = [
        ("d", 86_400_000_000_000),
        ("h", 3_600_000_000_000),
        ("m", 60_000_000_000),
        ("s", 1_000_000_000),
        ("ms", 1_000_000),
        ("us", 1_000),
        ("ns", 1),
    ];
    let body = text.split_once('#').map_or("", |(_, body)| body).to_ascii_lowercase();
    let mut rest = match body.strip_prefix('-') {
        Some(_) => return Err(LiteralFault::Negative),
        None => body.strip_prefix('+').unwrap_or(&body),
    };
    if rest.is_empty() {
        return Err(LiteralFault::Form);
    }
    let (mut total, mut least_place, mut fraction_seen) = (0i128, None, false);
    while !rest.is_empty() {
        rest = rest.strip_prefix('_').filter(|_| least_place.is_some()).unwrap_or(rest);
        let number_end =
            rest.find(|c: char| !(c.is_ascii_digit() || c == '.' || c == '_')).ok_or(LiteralFault::Form)?;
        let (number, after) = rest.split_at(number_end);
        let unit_end = after.find(|c: char| !c.is_ascii_lowercase()).unwrap_or(after.len());
        let (unit, after) = after.split_at(unit_end);
        let place = UNITS.iter().position(|(name, _)| *name == unit).ok_or(LiteralFault::Form)?;
        // Units go down, and only the last number may have a fraction.
        if fraction_seen || least_place.is_some_and(|least| place <= least) {
            return Err(LiteralFault::Form);
        }
        least_place = Some(place);
        let (whole, fraction) = number.split_once('.').unwrap_or((number, ""));
        fraction_seen = number.contains('.');
        if fraction_seen && fraction.is_empty() || fraction.len() > 20 {
            return Err(LiteralFault::Form);
        }
        let mantissa = self::number(&format!("{whole}{fraction}"))?;
        let digits = fraction.chars().filter(char::is_ascii_digit).count() as u32;
        let scaled = mantissa * UNITS[place].1;
        let divisor = 10i128.pow(digits);
        if scaled % divisor != 0 {
            return Err(LiteralFault::TooFine);
        }
        total += scaled / divisor;
        rest = after;
    }
    if total % 1_000_000 != 0 {
        return Err(LiteralFault::TooFine);
    }
    match total / 1_000_000 {
        ms @ 0..=4_294_967_295 => Ok(ms as i64),
        _ => Err(LiteralFault::TooLong),
    }
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
        assert_eq!(number("2#12"), Err(LiteralFault::Digit));
        assert_eq!(number("3#1"), Err(LiteralFault::Base));
        assert_eq!(number("1__0"), Err(LiteralFault::Underscore));
        assert_eq!(number("18446744073709551616"), Err(LiteralFault::TooLarge));
    }

    #[test]
    fn durations() {
        // controller:DT-01 - TIME has 32 bits of milliseconds.
        assert_eq!(duration("T#1d2h3m4s5ms"), Ok(93_784_005));
        assert_eq!(duration("time#1.5s"), Ok(1_500));
        assert_eq!(duration("t#1h_30m"), Ok(5_400_000));
        assert_eq!(duration("T#90s"), Ok(90_000));
        assert_eq!(duration("T#4294967295ms"), Ok(4_294_967_295));
        assert_eq!(duration("T#4294967296ms"), Err(LiteralFault::TooLong));
        assert_eq!(duration("T#1s1m"), Err(LiteralFault::Form));
        assert_eq!(duration("T#1.5s1ms"), Err(LiteralFault::Form));
        assert_eq!(duration("T#0.5ms"), Err(LiteralFault::TooFine));
        assert_eq!(duration("T#-1s"), Err(LiteralFault::Negative));
        assert_eq!(duration("T#"), Err(LiteralFault::Form));
        assert_eq!(duration("T#5"), Err(LiteralFault::Form));
    }
}
