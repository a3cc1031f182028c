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
