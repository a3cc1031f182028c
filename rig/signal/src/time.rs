//! Instants and durations in integer nanoseconds, parsed exactly from decimals with units.

use std::fmt;
use std::ops::{Add, AddAssign, Mul, Neg, Sub};

/// An instant: nanoseconds since the origin of the trace (the moment recording began).
///
/// Range ±292 years, at whose ends all arithmetic stops: a plan's absurd duration neither panics nor wraps.
/// Never derived from floating point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Time(i64);

/// A duration in nanoseconds, negative where an interval runs backwards.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Span(i64);

/// Why a text is no duration, with the byte at which it went wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParseTimeError {
    /// Nothing to read.
    Empty,
    /// A number was expected at this byte.
    Number(usize),
    /// The number at this byte has no unit behind it.
    MissingUnit(usize),
    /// The word at this byte is no unit of time.
    UnknownUnit(usize),
    /// The number at this byte is finer than one nanosecond.
    TooFine(usize),
    /// The duration does not fit into ±292 years.
    TooLarge,
}

impl fmt::Display for ParseTimeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => write!(f, "a duration is missing"),
            Self::Number(_) => write!(f, "a number is expected here"),
            Self::MissingUnit(_) => write!(f, "a unit is missing: ns, us, ms, s, min, h or d"),
            Self::UnknownUnit(_) => write!(f, "no unit of time: use ns, us, ms, s, min, h or d"),
            Self::TooFine(_) => write!(f, "finer than one nanosecond"),
            Self::TooLarge => write!(f, "longer than 292 years"),
        }
    }
}

impl std::error::Error for ParseTimeError {}

impl ParseTimeError {
    /// The byte of the text at which reading stopped.
    pub fn offset(&self) -> usize {
        match self {
            Self::Empty | Self::TooLarge => 0,
            Self::Number(at) | Self::MissingUnit(at) | Self::UnknownUnit(at) | Self::TooFine(at) => *at,
        }
    }
}

impl Time {
    /// The origin of the trace.
    pub const ZERO: Time = Time(0);
    /// Later than every instant that can be recorded.
    pub const MAX: Time = Time(i64::MAX);
    /// Earlier than every instant that can be recorded.
    pub const MIN: Time = Time(i64::MIN);

    /// The instant `nanos` nanoseconds after the origin.
    pub const fn from_nanos(nanos: i64) -> Self {
        Time(nanos)
    }

    /// Nanoseconds since the origin.
    pub const fn as_nanos(self) -> i64 {
        self.0
    }

    /// The instant `span` later, held at the ends of the range.
    pub const fn saturating_add(self, span: Span) -> Self {
        Time(self.0.saturating_add(span.0))
    }
}

impl Span {
    /// No time at all.
    pub const ZERO: Span = Span(0);
    /// The longest duration.
    pub const MAX: Span = Span(i64::MAX);

    /// `n` nanoseconds.
    pub const fn from_nanos(n: i64) -> Self {
        Span(n)
    }

    /// `n` microseconds.
    pub const fn from_micros(n: i64) -> Self {
        Span(n.saturating_mul(1_000))
    }

    /// `n` milliseconds.
    pub const fn from_millis(n: i64) -> Self {
        Span(n.saturating_mul(1_000_000))
    }

    /// `n` seconds.
    pub const fn from_secs(n: i64) -> Self {
        Span(n.saturating_mul(1_000_000_000))
    }

    /// The duration in nanoseconds.
    pub const fn as_nanos(self) -> i64 {
        self.0
    }

    /// Whether the duration is below zero.
    pub const fn is_negative(self) -> bool {
        self.0 < 0
    }

    /// Reads a duration such as `100 ms`, `100.3ms`, `-2 us` or `1 min 30 s`.
    ///
    /// The number is an exact decimal with optional `_` between digits; units are ns, us (or µs), ms, s,
    /// min, h and d. What is finer than one nanosecond is refused, never rounded.
    ///
    /// # Errors
    /// [`ParseTimeError`] with the byte of the first fault.
    pub fn parse(text: &str) -> Result<Span, ParseTimeError> {
        parse(text)
    }
}

fn parse(text: &str) -> Result<Span, ParseTimeError> {
    let bytes = text.as_bytes();
    let mut at = skip_spaces(bytes, 0);
    if at == bytes.len() {
        return Err(ParseTimeError::Empty);
    }
    let mut sign = 1i128;
    if bytes[at] == b'-' || bytes[at] == b'+' {
        if bytes[at] == b'-' {
            sign = -1;
        }
        at = skip_spaces(bytes, at + 1);
    }
    let mut total = 0i128;
    loop {
        let number_at = at;
        let (mantissa, decimals, after) = decimal(bytes, at)?;
        at = skip_spaces(bytes, after);
        let unit_at = at;
        while at < bytes.len() && !bytes[at].is_ascii_digit() && !bytes[at].is_ascii_whitespace() {
            at += 1;
        }
        if unit_at == at {
            return Err(ParseTimeError::MissingUnit(number_at));
        }
        let scale: i128 = match &text[unit_at..at] {
            "ns" => 1,
            "us" | "µs" | "μs" => 1_000,
            "ms" => 1_000_000,
            "s" => 1_000_000_000,
            "min" => 60_000_000_000,
            "h" => 3_600_000_000_000,
            "d" => 86_400_000_000_000,
            _ => return Err(ParseTimeError::UnknownUnit(unit_at)),
        };
        let divisor = 10i128.pow(decimals);
        let scaled = mantissa.checked_mul(scale).ok_or(ParseTimeError::TooLarge)?;
        if scaled % divisor != 0 {
            return Err(ParseTimeError::TooFine(number_at));
        }
        total = total.checked_add(scaled / divisor).ok_or(ParseTimeError::TooLarge)?;
        at = skip_spaces(bytes, at);
        if at == bytes.len() {
            break;
        }
    }
    i64::try_from(sign * total).map(Span).map_err(|_| ParseTimeError::TooLarge)
}

/// Mantissa, number of decimals and the byte behind the number.
pub(crate) fn decimal(bytes: &[u8], start: usize) -> Result<(i128, u32, usize), ParseTimeError> {
    let (mut at, mut mantissa, mut decimals, mut digits, mut point) = (start, 0i128, 0u32, 0usize, false);
    while at < bytes.len() {
        match bytes[at] {
            digit @ b'0'..=b'9' => {
                // Thirty digits hold every duration in range down to far below a nanosecond.
                if digits >= 30 {
                    return Err(ParseTimeError::TooLarge);
                }
                mantissa = mantissa * 10 + i128::from(digit - b'0');
                digits += 1;
                decimals += u32::from(point);
            }
            b'_' if digits > 0 => {}
            b'.' if !point && digits > 0 => point = true,
            _ => break,
        }
        at += 1;
    }
    if digits == 0 || bytes[at - 1] == b'.' || bytes[at - 1] == b'_' {
        return Err(ParseTimeError::Number(start));
    }
    Ok((mantissa, decimals, at))
}

pub(crate) fn skip_spaces(bytes: &[u8], mut at: usize) -> usize {
    while at < bytes.len() && bytes[at].is_ascii_whitespace() {
        at += 1;
    }
    at
}

impl fmt::Display for Span {
    /// The duration in the largest unit of ns, us, ms, s that writes it with at most three digits before
    /// the point where possible, without trailing zeros: `100.25 ms`. Reads back with [`Span::parse`].
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let magnitude = self.0.unsigned_abs();
        let (scale, unit) = match magnitude {
            0..=999 => (1, "ns"),
            1_000..=999_999 => (1_000, "us"),
            1_000_000..=999_999_999 => (1_000_000, "ms"),
            _ => (1_000_000_000, "s"),
        };
        if self.0 == 0 {
            return f.write_str("0 s");
        }
        let sign = if self.0 < 0 { "-" } else { "" };
        let (whole, part) = (magnitude / scale, magnitude % scale);
        if part == 0 {
            return write!(f, "{sign}{whole} {unit}");
        }
        let width = scale.ilog10() as usize;
        let digits = format!("{part:0width$}");
        write!(f, "{sign}{whole}.{} {unit}", digits.trim_end_matches('0'))
    }
}

impl fmt::Display for Time {
    /// Seconds since the origin with nine decimals.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sign = if self.0 < 0 { "-" } else { "" };
        let magnitude = self.0.unsigned_abs();
        write!(f, "{sign}{}.{:09} s", magnitude / 1_000_000_000, magnitude % 1_000_000_000)
    }
}

impl Add<Span> for Time {
    type Output = Time;
    fn add(self, span: Span) -> Time {
        Time(self.0.saturating_add(span.0))
    }
}

impl AddAssign<Span> for Time {
    fn add_assign(&mut self, span: Span) {
        *self = *self + span;
    }
}

impl Sub<Span> for Time {
    type Output = Time;
    fn sub(self, span: Span) -> Time {
        Time(self.0.saturating_sub(span.0))
    }
}

impl Sub for Time {
    type Output = Span;
    fn sub(self, earlier: Time) -> Span {
        Span(self.0.saturating_sub(earlier.0))
    }
}

impl Add for Span {
    type Output = Span;
    fn add(self, other: Span) -> Span {
        Span(self.0.saturating_add(other.0))
    }
}

impl Sub for Span {
    type Output = Span;
    fn sub(self, other: Span) -> Span {
        Span(self.0.saturating_sub(other.0))
    }
}

impl Mul<i64> for Span {
    type Output = Span;
    fn mul(self, times: i64) -> Span {
        Span(self.0.saturating_mul(times))
    }
}

impl Neg for Span {
    type Output = Span;
    fn neg(self) -> Span {
        Span(self.0.saturating_neg())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn durations_are_exact() {
        assert_eq!(Span::parse("100.3 ms"), Ok(Span(100_300_000)));
        assert_eq!(Span::parse("0.37ms"), Ok(Span(370_000)));
        assert_eq!(Span::parse("1 min 30 s"), Ok(Span::from_secs(90)));
        assert_eq!(Span::parse("-2 µs"), Ok(Span(-2_000)));
        assert_eq!(Span::parse("1_000 ns"), Ok(Span(1_000)));
    }

    #[test]
    fn faults_name_their_place() {
        assert_eq!(Span::parse(""), Err(ParseTimeError::Empty));
        assert_eq!(Span::parse("100"), Err(ParseTimeError::MissingUnit(0)));
        assert_eq!(Span::parse("100 msec"), Err(ParseTimeError::UnknownUnit(4)));
        assert_eq!(Span::parse("0.1 ns"), Err(ParseTimeError::TooFine(0)));
        assert_eq!(Span::parse("300000 d"), Err(ParseTimeError::TooLarge));
        assert_eq!(Span::parse(". ms"), Err(ParseTimeError::Number(0)));
        assert_eq!(Span::parse("1. ms"), Err(ParseTimeError::Number(0)));
    }

    proptest! {
        #[test]
        fn what_is_written_reads_back(nanos in any::<i64>()) {
            let span = Span(nanos);
            prop_assert_eq!(Span::parse(&span.to_string()), Ok(span));
        }

        #[test]
        fn no_text_panics(text in "\\PC*") {
            let _ = Span::parse(&text);
        }
    }
}
