//! Values of signals as a plan writes them: `true`, `42`, `"16#0010"`, `"T#500ms"`, `"24 V"`, `"RUNNING"`.

use std::fmt;

use document::{Data, Findings, Node};
use signal::{Span, Value};

use super::Decimal;
use crate::codes;

/// A value as written; what a label or a unit means is known when the signal is.
#[derive(Clone, Debug, PartialEq)]
pub enum Literal {
    /// A value that needs no signal to be understood. Durations are [`Value::Int`] in nanoseconds.
    Value(Value),
    /// A number with a unit.
    Measure {
        /// The number as written.
        number: f64,
        /// The unit as written, as in `V` or `degC`.
        unit: String,
    },
    /// A word: the label of a state.
    Label(String),
}

/// Why a text is no value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LiteralFault {
    /// Nothing to read.
    Empty,
    /// The digits do not fit the base or 64 bits.
    Digits,
    /// Behind `T#` stands no duration.
    Duration,
    /// Neither a number, a word nor any other value.
    Unreadable,
    /// A date, a list or a table.
    Kind,
}

impl fmt::Display for LiteralFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            LiteralFault::Empty => "the value is empty",
            LiteralFault::Digits => "the digits do not fit the base, or not into 64 bits",
            LiteralFault::Duration => "a duration is expected behind `T#`, as in `T#500ms`",
            LiteralFault::Unreadable => {
                "no value: write a number, TRUE, 16#0010, T#500ms, a quantity such as `24 V` or the name of a state"
            }
            LiteralFault::Kind => "a value is a Boolean, a number or a text",
        })
    }
}

impl Literal {
    /// TRUE.
    pub const TRUE: Literal = Literal::Value(Value::Bool(true));

    /// Reads a value of the file; reports what is wrong with it.
    pub(crate) fn read(node: &Node, out: &mut Findings) -> Option<Literal> {
        match Literal::of(node) {
            Ok(literal) => Some(literal),
            Err(fault) => {
                out.bad(codes::VALUE, node, format!("the value does not read: {fault}"), "");
                None
            }
        }
    }

    /// Reads a value of the file.
    ///
    /// # Errors
    /// [`LiteralFault`].
    pub fn of(node: &Node) -> Result<Literal, LiteralFault> {
        match &node.data {
            Data::Bool(on) => Ok(Literal::Value(Value::Bool(*on))),
            Data::Integer(number) => Ok(Literal::Value(Value::Int(*number))),
            Data::Float(text) => match text.parse::<f64>() {
                Ok(number) if number.is_finite() => Ok(Literal::Value(Value::Real(number))),
                _ => Err(LiteralFault::Unreadable),
            },
            Data::Text(text) => Literal::parse(text),
            Data::Datetime(_) | Data::Array(_) | Data::Table(_) => Err(LiteralFault::Kind),
        }
    }

    /// Reads a value written as a text.
    ///
    /// # Errors
    /// [`LiteralFault`].
    pub fn parse(text: &str) -> Result<Literal, LiteralFault> {
        let text = text.trim();
        if text.is_empty() {
            return Err(LiteralFault::Empty);
        }
        if text.eq_ignore_ascii_case("true") || text.eq_ignore_ascii_case("false") {
            return Ok(Literal::Value(Value::Bool(text.eq_ignore_ascii_case("true"))));
        }
        if text.eq_ignore_ascii_case("high impedance") {
            return Ok(Literal::Value(Value::HighZ));
        }
        if let Some((prefix, rest)) = text.split_once('#') {
            return prefixed(prefix, rest);
        }
        if let Some((number, unit)) = Decimal::split(text) {
            return numeric(text, number, unit);
        }
        let word = text.len() <= 64
            && text.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
            && text.chars().all(|c| c.is_ascii_alphanumeric() || matches!(c, '_' | '-' | ' '));
        if word { Ok(Literal::Label(text.to_owned())) } else { Err(LiteralFault::Unreadable) }
    }
}

/// `16#..`, `T#..`, `INT#..`.
fn prefixed(prefix: &str, rest: &str) -> Result<Literal, LiteralFault> {
    let upper = prefix.to_ascii_uppercase();
    match upper.as_str() {
        "2" | "8" | "16" => {
            let radix = upper.parse().unwrap_or(10);
            let digits: String = rest.chars().filter(|c| *c != '_').collect();
            let right = digits.chars().all(|c| c.is_digit(radix));
            match u64::from_str_radix(&digits, radix) {
                Ok(word) if right => Ok(Literal::Value(Value::Word(word))),
                _ => Err(LiteralFault::Digits),
            }
        }
        "T" | "TIME" | "LT" | "LTIME" => {
            let span = Span::parse(rest).map_err(|_| LiteralFault::Duration)?;
            Ok(Literal::Value(Value::Int(span.as_nanos())))
        }
        "BOOL" | "SINT" | "INT" | "DINT" | "LINT" | "USINT" | "UINT" | "UDINT" | "ULINT" | "BYTE"
        | "WORD" | "DWORD" | "LWORD" | "REAL" | "LREAL" => match rest.split_once('#') {
            // A typed literal may have a base, but not one more type.
            Some((base @ ("2" | "8" | "16"), digits)) => prefixed(base, digits),
            Some(_) => Err(LiteralFault::Unreadable),
            None => match Literal::parse(rest)? {
                value @ Literal::Value(_) => Ok(value),
                _ => Err(LiteralFault::Unreadable),
            },
        },
        _ => Err(LiteralFault::Unreadable),
    }
}

/// A number, alone or with a unit.
fn numeric(text: &str, number: Decimal, unit: &str) -> Result<Literal, LiteralFault> {
    if unit.is_empty() {
        return Ok(Literal::Value(match number.decimals {
            0 => Value::Int(i64::try_from(number.mantissa).map_err(|_| LiteralFault::Digits)?),
            _ => Value::Real(number.as_f64()),
        }));
    }
    if let Ok(span) = Span::parse(text) {
        return Ok(Literal::Value(Value::Int(span.as_nanos())));
    }
    let known = unit.len() <= 16 && unit.chars().all(|c| c.is_alphabetic() || matches!(c, '%' | '°' | '/'));
    if !known {
        return Err(LiteralFault::Unreadable);
    }
    Ok(Literal::Measure { number: number.as_f64(), unit: unit.to_owned() })
}

impl fmt::Display for Literal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Literal::Value(value) => value.fmt(f),
            Literal::Measure { number, unit } => write!(f, "{number} {unit}"),
            Literal::Label(label) => f.write_str(label),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn values_read() {
        let value = |text| match Literal::parse(text) {
            Ok(Literal::Value(value)) => value,
            other => panic!("{text}: {other:?}"),
        };
        assert_eq!(value("TRUE"), Value::Bool(true));
        assert_eq!(value("16#FFFF"), Value::Word(0xFFFF));
        assert_eq!(value("WORD#16#00_10"), Value::Word(16));
        assert_eq!(value("-3"), Value::Int(-3));
        assert_eq!(value("INT#-3"), Value::Int(-3));
        assert_eq!(value("2.5"), Value::Real(2.5));
        assert_eq!(value("T#500ms"), Value::Int(500_000_000));
        assert_eq!(value("500 ms"), Value::Int(500_000_000));
        assert_eq!(Literal::parse("24 V"), Ok(Literal::Measure { number: 24.0, unit: "V".into() }));
        assert_eq!(Literal::parse("RUNNING"), Ok(Literal::Label("RUNNING".into())));
    }

    #[test]
    fn what_is_no_value_says_why() {
        assert_eq!(Literal::parse("16#GG"), Err(LiteralFault::Digits));
        assert_eq!(Literal::parse("16#+1"), Err(LiteralFault::Digits));
        assert_eq!(Literal::parse("16#10000000000000000"), Err(LiteralFault::Digits));
        assert_eq!(Literal::parse("T#5"), Err(LiteralFault::Duration));
        assert_eq!(Literal::parse(""), Err(LiteralFault::Empty));
        assert_eq!(Literal::parse("n @ cut"), Err(LiteralFault::Unreadable));
    }

    proptest! {
        #[test]
        fn no_text_panics(text in "\\PC*", near in "((INT|16|T)#|TRUE|[0-9.]{1,30}| |V|#){0,6}") {
            let _ = (Literal::parse(&text), Literal::parse(&near));
        }
    }
}
