//! A number with its unit.

use serde::{Deserialize, Serialize};
use signal::Span;
use std::fmt;

/// A number with its unit: a margin, an uncertainty, a limit.
///
/// Durations have the unit `ns` and are then exact up to 2^53 ns (104 days); they are shown in the unit
/// that reads best.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Figure {
    /// The number, in `unit`.
    #[serde(with = "crate::number::real")]
    pub value: f64,
    /// The unit as in `V`; empty for none.
    pub unit: String,
}

impl Figure {
    /// `value` in `unit`.
    pub fn new(value: f64, unit: impl Into<String>) -> Self {
        Figure { value, unit: unit.into() }
    }

    /// A duration, in nanoseconds.
    pub fn span(span: Span) -> Self {
        Figure { value: span.as_nanos() as f64, unit: "ns".to_owned() }
    }

    /// The figure as a duration, where it is one.
    pub fn as_span(&self) -> Option<Span> {
        let fits = self.value.is_finite() && self.value.abs() < i64::MAX as f64;
        (self.unit == "ns" && fits).then_some(Span::from_nanos(self.value as i64))
    }
}

impl From<Span> for Figure {
    fn from(span: Span) -> Self {
        Figure::span(span)
    }
}

impl fmt::Display for Figure {
    /// A whole number of nanoseconds as a duration (`0.4 ms`), another whole number with all its digits, anything else as number
    /// and unit with at most nine significant digits.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.as_span() {
            Some(span) if span.as_nanos() as f64 == self.value => span.fmt(f),
            _ if self.unit.is_empty() => write!(f, "{}", nine_digits(self.value)),
            _ => write!(f, "{} {}", nine_digits(self.value), self.unit),
        }
    }
}

/// The number to nine significant digits, but all of a whole one: 0.1 + 0.2 is shown as 0.3, and no count as a rounded one.
fn nine_digits(n: f64) -> f64 {
    if n.fract() == 0.0 {
        return n;
    }
    format!("{n:.8e}").parse().unwrap_or(n)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_read_as_durations() {
        assert_eq!(Figure::span(Span::from_micros(400)).to_string(), "400 us");
        assert_eq!(Figure::span(Span::from_nanos(-2_500_000)).to_string(), "-2.5 ms");
        assert_eq!(Figure::new(0.25, "V").to_string(), "0.25 V");
        assert_eq!(Figure::new(3.0, "").to_string(), "3");
        assert_eq!(Figure::new(0.1 + 0.2, "V").to_string(), "0.3 V");
        assert_eq!(Figure::new(65_535.0, "").to_string(), "65535");
        assert_eq!(Figure::new(12_345_678_901_234.0, "").to_string(), "12345678901234");
        assert_eq!(Figure::new(f64::NAN, "ns").to_string(), "NaN ns");
    }
}
