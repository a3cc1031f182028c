//! Words, columns and instants as `rig ctl` prints them.

use crate::output;
use control::{Signal, SignalKind};
use signal::{Span, Value};

/// Prints a piece of what goes on and on; `false` where nobody reads it any more.
pub fn print_text(text: &str) -> bool {
    output::print_piece(text)
}

/// Prints JSON for a program, on several lines.
pub fn json(value: &serde_json::Value) {
    output::print(&format!("{}\n", serde_json::to_string_pretty(value).unwrap_or_default()));
}

/// Nanoseconds as seconds, to the microsecond.
pub fn seconds(nanos: i64) -> String {
    let (sign, nanos) = (if nanos < 0 { "-" } else { "" }, nanos.unsigned_abs());
    format!("{sign}{}.{:06} s", nanos / 1_000_000_000, nanos % 1_000_000_000 / 1_000)
}

/// Nanoseconds as the duration that they are.
pub fn span(nanos: i64) -> String {
    signal::Span::from_nanos(nanos).to_string()
}

/// Per mille as per cent.
pub fn percent(per_mille: u32) -> String {
    format!("{}.{} %", per_mille / 10, per_mille % 10)
}

/// A value of a signal for a person.
pub fn value(value: Value, of: &Signal) -> String {
    if let (Value::Int(nanos), "ns") = (value, of.unit.as_str()) {
        return Span::from_nanos(nanos).to_string();
    }
    let label = match (of.kind, value.as_int()) {
        (SignalKind::State | SignalKind::Word, Some(number)) => {
            of.labels.iter().find(|(known, _)| i128::from(*known) == number).map(|(_, label)| label.clone())
        }
        _ => None,
    };
    let text = label.unwrap_or_else(|| match value {
        Value::Real(number) => short(number),
        other => other.to_string(),
    });
    let number = matches!(value, Value::Int(_) | Value::Word(_) | Value::Real(_) | Value::Measured(..));
    if number && !of.unit.is_empty() { format!("{text} {}", of.unit) } else { text }
}

/// A number with at most seven digits that count.
fn short(number: f64) -> String {
    let places = if number == 0.0 || !number.is_finite() { 0.0 } else { 6.0 - number.abs().log10().floor() };
    // Beyond these a number is written as it is: all its digits, or hundreds of zeros, help nobody.
    if !(0.0..=12.0).contains(&places) {
        return number.to_string();
    }
    let text = format!("{number:.*}", places as usize);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// A value as a field of a table for a program: levels are 0 and 1, `Z` a line that nobody drives, and empty what is not
/// known.
pub fn field(value: Value) -> String {
    match value {
        Value::Bool(on) => u8::from(on).to_string(),
        Value::Int(number) => number.to_string(),
        Value::Word(number) => number.to_string(),
        Value::Real(number) | Value::Measured(number, _) => number.to_string(),
        Value::HighZ => "Z".to_owned(),
        Value::Unknown => String::new(),
    }
}

/// A text as a field of CSV.
pub fn quoted(text: &str) -> String {
    if text.contains(['"', ',', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}

/// Rows in columns that are as wide as what is in them. The last one is not filled up.
pub fn columns(rows: &[Vec<String>]) -> String {
    let most = rows.iter().map(Vec::len).max().unwrap_or_default();
    let width = |column: usize| {
        rows.iter()
            .filter_map(|row| row.get(column))
            .map(|text| text.chars().count())
            .max()
            .unwrap_or_default()
    };
    let widths: Vec<usize> = (0..most).map(width).collect();
    let mut text = String::new();
    for row in rows {
        let mut line = String::new();
        for (place, (cell, width)) in row.iter().zip(&widths).enumerate() {
            line.push_str(if place > 0 { "  " } else { "" });
            line.push_str(cell);
            line.extend(std::iter::repeat_n(' ', width - cell.chars().count()));
        }
        text.push_str(line.trim_end());
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn instants_are_exact_and_signed() {
        assert_eq!(seconds(1_234_567_890), "1.234567 s");
        assert_eq!(seconds(-1_500_000), "-0.001500 s");
        assert_eq!(seconds(i64::MIN), "-9223372036.854775 s");
    }

    #[test]
    fn values_are_shown_with_their_labels_and_units() {
        let signal = |kind, unit: &str, labels: &[(i64, &str)]| Signal {
            number: 0,
            name: "x".to_owned(),
            kind,
            unit: unit.to_owned(),
            labels: labels.iter().map(|(number, label)| (*number, (*label).to_owned())).collect(),
            writable: false,
        };
        let state = signal(SignalKind::State, "", &[(3, "RUNNING")]);
        assert_eq!(
            (value(Value::Int(3), &state), value(Value::Int(4), &state)),
            ("RUNNING".into(), "4".into())
        );
        // A member of a system structure is a word.
        let word = signal(SignalKind::Word, "", &[(2, "PLC_R_RUNNING")]);
        assert_eq!(
            (value(Value::Word(2), &word), value(Value::Word(7), &word)),
            ("PLC_R_RUNNING".into(), "16#7".into())
        );
        let volts = signal(SignalKind::Real, "V", &[]);
        assert_eq!(value(Value::Real(0.5), &volts), "0.5 V");
        assert_eq!(value(Value::Unknown, &volts), "unknown");
        assert_eq!(value(Value::Int(1_500_000), &signal(SignalKind::Int, "ns", &[])), "1.5 ms");
        let shown = [1.5549351013608117, -2.0, 0.0, 120_000.26, 1e9, 1.0 / 3.0, 1e-20, f64::NAN].map(short);
        assert_eq!(
            shown,
            ["1.554935", "-2", "0", "120000.3", "1000000000", "0.3333333", "0.00000000000000000001", "NaN"]
        );
    }

    #[test]
    fn fields_are_what_a_spreadsheet_reads() {
        assert_eq!(field(Value::Bool(true)), "1");
        assert_eq!(field(Value::measured(3.25, 0.1)), "3.25");
        assert_eq!((field(Value::HighZ), field(Value::Unknown)), ("Z".into(), String::new()));
        assert_eq!(quoted("a \"b\", c"), "\"a \"\"b\"\", c\"");
    }
}
