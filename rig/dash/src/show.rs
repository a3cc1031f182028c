//! Times, numbers and values as short texts.

use control::{Signal, Span, Value, WireValue};

/// The unit of durations.
pub const NANOSECONDS: &str = "ns";

/// Digits of a number that is only looked at.
const DIGITS: usize = 4;

/// A duration in nanoseconds with four digits: `12.35 ms`.
pub fn span(nanos: i64) -> String {
    let (scale, unit) = scale(nanos);
    format!("{} {unit}", real(nanos as f64 / scale as f64, DIGITS))
}

/// The unit that fits a duration in nanoseconds, and how many there are in one.
pub fn scale(nanos: i64) -> (u64, &'static str) {
    match nanos.unsigned_abs() {
        0 => (1_000_000_000, "s"),
        1..1_000 => (1, "ns"),
        1_000..1_000_000 => (1_000, "us"),
        1_000_000..1_000_000_000 => (1_000_000, "ms"),
        _ => (1_000_000_000, "s"),
    }
}

/// An instant in nanoseconds as seconds with so many decimals.
pub fn seconds(nanos: i64, places: usize) -> String {
    let places = places.min(9);
    let step = 10_u64.pow(9 - places as u32);
    let size = nanos.unsigned_abs() / step * step;
    let sign = if nanos < 0 && size > 0 { "-" } else { "" };
    let (whole, rest) = (size / 1_000_000_000, size % 1_000_000_000);
    let digits = format!("{rest:09}");
    match &digits[..places] {
        "" => format!("{sign}{whole}"),
        places => format!("{sign}{whole}.{places}"),
    }
}

/// A real number with at most so many digits that count, without zeros at its end.
pub fn real(number: f64, digits: usize) -> String {
    if number == 0.0 || !number.is_finite() {
        return match number {
            n if n.is_nan() => "nan".to_owned(),
            n if n.is_infinite() => if n > 0.0 { "inf" } else { "-inf" }.to_owned(),
            _ => "0".to_owned(),
        };
    }
    let digits = digits.max(1);
    // Rounding comes first: 9.9999 has another size than 10.
    let rounded = format!("{number:.*e}", digits - 1);
    let Some((mantissa, size)) = rounded.split_once('e') else { return rounded };
    let size: i32 = size.parse().unwrap_or(0);
    if (-4..=9).contains(&size) {
        let places = (digits as i32 - 1 - size).max(0) as usize;
        let text = format!("{number:.places$}");
        return if text.contains('.') {
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        } else {
            text
        };
    }
    let mantissa =
        if mantissa.contains('.') { mantissa.trim_end_matches('0').trim_end_matches('.') } else { mantissa };
    format!("{mantissa}e{size}")
}

/// Per mille as per cent: `42.5 %`.
pub fn per_mille(share: u32) -> String {
    format!("{}.{} %", share / 10, share % 10)
}

/// A value without its unit, by its name where its values have names.
pub fn value(value: WireValue, labels: &[(i64, String)]) -> String {
    let number = match value.0 {
        Value::Int(n) => Some(n),
        Value::Word(n) => i64::try_from(n).ok(),
        _ => None,
    };
    if let Some((_, label)) = number.and_then(|n| labels.iter().find(|(of, _)| *of == n)) {
        return label.clone();
    }
    match value.0 {
        Value::Bool(on) => if on { "TRUE" } else { "FALSE" }.to_owned(),
        Value::Int(n) => n.to_string(),
        Value::Word(n) => n.to_string(),
        Value::Real(n) => real(n, 6),
        Value::Measured(n, by) => format!("{} +-{}", real(n, 6), real(f64::from(by), 2)),
        Value::HighZ => "high-z".to_owned(),
        Value::Unknown => "?".to_owned(),
    }
}

/// A value with its unit, of a signal that may be known.
pub fn of_signal(of: WireValue, signal: Option<&Signal>) -> String {
    signal.map_or_else(|| value(of, &[]), |signal| with_unit(of, &signal.labels, &signal.unit))
}

/// A value with its unit.
pub fn with_unit(of: WireValue, labels: &[(i64, String)], unit: &str) -> String {
    let text = value(of, labels);
    match of.0 {
        Value::HighZ | Value::Unknown | Value::Bool(_) => text,
        Value::Int(nanos) if unit == NANOSECONDS => Span::from_nanos(nanos).to_string(),
        _ if unit.is_empty() => text,
        _ => format!("{text} {unit}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_their_size_and_lose_only_digits() {
        for (number, digits, text) in [
            (0.0, 4, "0"),
            (12.0, 4, "12"),
            (120.0, 1, "120"),
            (0.000_123_456, 4, "0.0001235"),
            (0.000_000_5, 4, "5e-7"),
            (99_999.9, 4, "100000"),
            (-2.5, 4, "-2.5"),
            (1.5e12, 4, "1.5e12"),
            (f64::NEG_INFINITY, 4, "-inf"),
            (f64::NAN, 4, "nan"),
        ] {
            assert_eq!(real(number, digits), text);
        }
    }

    #[test]
    fn times_have_the_unit_that_fits() {
        assert_eq!(span(12_345_678), "12.35 ms");
        assert_eq!(span(999_999), "1000 us");
        assert_eq!(span(0), "0 s");
        assert_eq!(seconds(1_234_567_890, 3), "1.234");
        assert_eq!(seconds(-400_000, 3), "0.000");
        assert_eq!(seconds(-1_400_000, 3), "-0.001");
        assert_eq!(seconds(5_000_000_000, 0), "5");
    }

    #[test]
    fn values_go_by_their_names() {
        let labels = [(2, "RUNNING".to_owned())];
        assert_eq!(value(WireValue(Value::Int(2)), &labels), "RUNNING");
        assert_eq!(value(WireValue(Value::Word(2)), &labels), "RUNNING");
        assert_eq!(value(WireValue(Value::Int(3)), &labels), "3");
        assert_eq!(value(WireValue(Value::Measured(0.5, 0.25)), &[]), "0.5 +-0.25");
        let times = [Value::Int(1_500_000), Value::Int(0), Value::Unknown].map(WireValue);
        assert_eq!(times.map(|time| with_unit(time, &[], NANOSECONDS)), ["1.5 ms", "0 s", "?"]);
        assert_eq!(with_unit(WireValue(Value::Real(0.5)), &[], "V"), "0.5 V");
    }
}
