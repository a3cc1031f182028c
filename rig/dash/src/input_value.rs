//! Values as people type them.

use crate::show;
use control::{Signal, SignalKind, Span, Value, WireValue};

/// What is to be typed.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ExpectedInput {
    /// What the value is, where that is known.
    pub kind: Option<SignalKind>,
    /// The names of values.
    pub labels: Vec<(i64, String)>,
    /// It is a duration.
    pub duration: bool,
}

impl ExpectedInput {
    /// A level.
    pub fn level() -> ExpectedInput {
        ExpectedInput { kind: Some(SignalKind::Bool), ..ExpectedInput::default() }
    }

    /// What the place of an input or output takes: a level, or the counts of a word.
    pub fn at(address: &str) -> ExpectedInput {
        let is_word = ["%IW", "%QW"].iter().any(|word| address.starts_with(word));
        let kind = if is_word { SignalKind::Int } else { SignalKind::Bool };
        ExpectedInput { kind: Some(kind), ..ExpectedInput::default() }
    }

    /// A value of this signal.
    pub fn of(signal: &Signal) -> ExpectedInput {
        ExpectedInput {
            kind: Some(signal.kind),
            labels: signal.labels.clone(),
            duration: signal.unit == show::NANOSECONDS,
        }
    }
}

/// A value: `TRUE`, `on`, `12`, `16#FF`, `0.5`, `250 ms`, or a name that the value has.
///
/// # Errors
/// What it should look like.
pub fn value(text: &str, expected: &ExpectedInput) -> Result<WireValue, String> {
    let text = text.trim();
    if let Some((number, _)) = expected.labels.iter().find(|(_, label)| label.eq_ignore_ascii_case(text)) {
        return Ok(WireValue(Value::Int(*number)));
    }
    let (found, wanted) = match expected.kind {
        Some(SignalKind::Bool) => (boolean(text), "TRUE or FALSE, 1 or 0"),
        Some(_) if expected.duration => {
            (duration(text), "a duration, as in 250 ms or T#1.5s, or a number of nanoseconds")
        }
        Some(SignalKind::Int | SignalKind::State | SignalKind::Word) => {
            (integer(text), "a whole number, as in 12, 16#FF or 2#1010")
        }
        Some(SignalKind::Real) => (real(text), "a number, as in 0.5"),
        None => {
            let found = match text.to_ascii_uppercase().as_str() {
                "TRUE" | "FALSE" => boolean(text),
                _ => integer(text).or_else(|| real(text)),
            };
            (found, "TRUE, FALSE or a number")
        }
    };
    found.map(WireValue).ok_or_else(|| format!("`{text}` is not a valid value: type {wanted}"))
}

/// A duration as people or Structured Text write it, with one unit.
fn duration(text: &str) -> Option<Value> {
    let plain = match text.split_once('#') {
        Some((ty, rest)) if ["T", "TIME", "LTIME"].iter().any(|known| known.eq_ignore_ascii_case(ty)) => rest,
        _ => text,
    };
    let span = Span::parse(plain).ok().map(|span| Value::Int(span.as_nanos()));
    span.or_else(|| integer(text))
}

fn boolean(text: &str) -> Option<Value> {
    match text.to_ascii_uppercase().as_str() {
        "TRUE" | "1" | "ON" | "HIGH" => Some(Value::Bool(true)),
        "FALSE" | "0" | "OFF" | "LOW" => Some(Value::Bool(false)),
        _ => None,
    }
}

/// A whole number as Structured Text writes it.
fn integer(text: &str) -> Option<Value> {
    let plain = text.replace('_', "");
    let Some((base, digits)) = plain.split_once('#') else {
        let signed = plain.parse().map(Value::Int);
        return signed.or_else(|_| plain.parse().map(Value::Word)).ok();
    };
    let base = base.parse().ok().filter(|base| [2, 8, 10, 16].contains(base))?;
    // A sign after the base is not one of a number's.
    let digits = Some(digits).filter(|digits| !digits.starts_with(['+', '-']))?;
    let word = u64::from_str_radix(digits, base).ok()?;
    Some(i64::try_from(word).map_or(Value::Word(word), Value::Int))
}

fn real(text: &str) -> Option<Value> {
    text.parse().ok().filter(|number: &f64| number.is_finite()).map(Value::Real)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_taken_as_people_type_them() {
        let labels = vec![(2, "RUNNING".to_owned())];
        for (text, kind, read) in [
            ("on", Some(SignalKind::Bool), Some(Value::Bool(true))),
            (" 0 ", Some(SignalKind::Bool), Some(Value::Bool(false))),
            ("2", Some(SignalKind::Bool), None),
            ("16#ff", Some(SignalKind::Word), Some(Value::Int(255))),
            ("2#1010_0001", Some(SignalKind::Word), Some(Value::Int(161))),
            ("16#-1", Some(SignalKind::Word), None),
            ("16#FFFF_FFFF_FFFF_FFFF", Some(SignalKind::Word), Some(Value::Word(u64::MAX))),
            ("99999999999999999999", Some(SignalKind::Int), None),
            ("running", Some(SignalKind::State), Some(Value::Int(2))),
            ("5", Some(SignalKind::Real), Some(Value::Real(5.0))),
            ("inf", Some(SignalKind::Real), None),
            ("-7", None, Some(Value::Int(-7))),
            ("0.5", None, Some(Value::Real(0.5))),
            ("true", None, Some(Value::Bool(true))),
            ("", None, None),
        ] {
            let expected = ExpectedInput { kind, labels: labels.clone(), duration: false };
            assert_eq!(value(text, &expected).ok(), read.map(WireValue), "{text}");
        }
        let error = value("maybe", &ExpectedInput::level()).unwrap_err();
        assert_eq!(error, "`maybe` is not a valid value: type TRUE or FALSE, 1 or 0");
        let expected = ExpectedInput { kind: Some(SignalKind::Int), labels: Vec::new(), duration: true };
        for (text, nanos) in [
            ("250 ms", Some(250_000_000)),
            ("T#1.5s", Some(1_500_000_000)),
            ("ltime#3us", Some(3_000)),
            ("12", Some(12)),
            ("16#10", Some(16)),
            ("T#", None),
            ("soon", None),
        ] {
            assert_eq!(
                value(text, &expected).ok(),
                nanos.map(|nanos| WireValue(Value::Int(nanos))),
                "{text}"
            );
        }
    }
}
