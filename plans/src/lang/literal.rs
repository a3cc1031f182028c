//! Values of signals as a plan writes them: `true`, `42`, `"16#0010"`, `"T#500ms"`, `"24 V"`, `"RUNNING"`.

use std::fmt;

use document::{Data, Findings, Node};
use signal::{Decimal, Quantity, QuantityFault, Span, Unit, Value};

use crate::codes;

/// A value as written; what a label or a unit means is known when the signal is.
#[derive(Clone, Debug, PartialEq)]
pub enum Literal {
    /// A value that needs no signal to be understood.
    Value(Value),
    /// A number with a unit; durations are among them. Without a unit a number that no [`Value`] holds exactly.
    Measure {
        /// The number as written.
        number: Decimal,
        /// The unit as written, as in `V` or `degC`; [`Unit::NONE`] for none.
        unit: Unit,
    },
    /// A word: the label of a state.
    Label(String),
}

/// Why a text is no value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LiteralFault {
    /// Nothing to read.
    #[error("the value is empty")]
    Empty,
    /// The digits do not suit the base, are more than 64 bits of a base other than ten, or are too many.
    #[error(
        "the digits do not suit the base, or are too many: a number has at most 30, in base 2, 8 and 16 at most 64 bits"
    )]
    Digits,
    /// After `T#` stands no duration.
    #[error("a duration is expected after `T#`, as in `T#500ms`")]
    Duration,
    /// Neither a number, a word nor any other value.
    #[error(
        "no value: write a number, TRUE, 16#0010, T#500ms, a quantity such as `24 V` or the name of a state"
    )]
    Unreadable,
    /// A date, a list or a table.
    #[error("a value is a Boolean, a number or a text")]
    Kind,
}

impl LiteralFault {
    /// What to write in its place.
    pub const fn help(self) -> &'static str {
        match self {
            LiteralFault::Empty | LiteralFault::Unreadable => {
                "write a number such as 42 or 1.5, true, \"16#0010\", \"T#500ms\", \"24 V\" or a state such as \"RUNNING\""
            }
            LiteralFault::Digits => {
                "round it: write at most 30 digits, as in 0.12345678901234567890123456789; a number such as \"16#FF\" has digits of its base and at most 64 bits"
            }
            LiteralFault::Duration => "write \"T#500ms\", or \"500 ms\"",
            LiteralFault::Kind => {
                "write true, a number such as 42, or a text in quotes such as \"24 V\" or \"RUNNING\""
            }
        }
    }
}

impl Literal {
    /// TRUE.
    pub const TRUE: Literal = Literal::Value(Value::Bool(true));

    /// The value, where no signal is needed to know it: what a variable is given. A duration is the nanoseconds that it holds; a
    /// number that no value holds exactly is the nearest float, or none where it has over 64 bits.
    pub fn value(&self) -> Option<Value> {
        match self {
            Literal::Value(value) => Some(*value),
            Literal::Measure { number, unit } if unit.is_none() => match number.as_whole() {
                Some(whole) => match i64::try_from(whole) {
                    Ok(whole) => Some(Value::Int(whole)),
                    Err(_) => u64::try_from(whole).ok().map(Value::Word),
                },
                None => Some(Value::Real(number.as_f64())),
            },
            Literal::Measure { .. } => self
                .quantity()
                .and_then(|quantity| quantity.as_span())
                .map(|span| Value::Int(span.as_nanos())),
            Literal::Label(_) => None,
        }
    }

    /// The number with its unit, if it is one with a unit.
    pub fn quantity(&self) -> Option<Quantity> {
        match self {
            Literal::Measure { number, unit } => Some(Quantity { number: *number, unit: unit.clone() }),
            _ => None,
        }
    }

    /// The number with its unit, also of one without; `None` for a Boolean, a state and what is no finite number.
    pub fn as_quantity(&self) -> Option<Quantity> {
        let number = match self {
            Literal::Value(Value::Bool(_)) | Literal::Label(_) => None,
            Literal::Value(value) => match value.as_int() {
                Some(whole) => Some(Decimal::from(whole)),
                None => value.as_real().and_then(Decimal::from_f64),
            },
            Literal::Measure { .. } => return self.quantity(),
        };
        number.map(|number| Quantity { number, unit: Unit::NONE })
    }

    /// Reads a value of the file; reports what is wrong with it.
    pub(crate) fn read(node: &Node, out: &mut Findings) -> Option<Literal> {
        match Literal::of(node) {
            Ok(literal) => Some(literal),
            Err(fault) => {
                out.bad(codes::VALUE, node, format!("the value does not read: {fault}"), fault.help());
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
            Data::Float(text) => match Decimal::split(text) {
                Ok((number, "")) => Ok(plain(text, number)),
                Err(error) if error.fault == QuantityFault::TooLarge => Err(LiteralFault::Digits),
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
        match Decimal::split(text) {
            Ok((number, "")) => return Ok(plain(text, number)),
            Ok(_) => {
                return Quantity::parse(text).map(Literal::from).map_err(|_| LiteralFault::Unreadable);
            }
            Err(error) if error.fault == QuantityFault::TooLarge => return Err(LiteralFault::Digits),
            Err(_) => {}
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
            Ok(Literal::from(Quantity::from(span)))
        }
        "BOOL" | "SINT" | "INT" | "DINT" | "LINT" | "USINT" | "UINT" | "UDINT" | "ULINT" | "BYTE"
        | "WORD" | "DWORD" | "LWORD" | "REAL" | "LREAL" => match rest.split_once('#') {
            // A typed literal may have a base, but not one more type.
            Some((base @ ("2" | "8" | "16"), digits)) => prefixed(base, digits),
            Some(_) => Err(LiteralFault::Unreadable),
            None => match Literal::parse(rest)? {
                value @ Literal::Value(_) => Ok(value),
                Literal::Measure { number, unit } if unit.is_none() => Ok(Literal::Measure { number, unit }),
                _ => Err(LiteralFault::Unreadable),
            },
        },
        _ => Err(LiteralFault::Unreadable),
    }
}

/// A number without a unit: a real one if it is written with a point or an exponent. One that neither a float nor 64 bits with a
/// sign hold stays as it is written.
fn plain(text: &str, number: Decimal) -> Literal {
    let value = match text.contains(['.', 'e', 'E']) {
        true => {
            Some(number.as_f64()).filter(|real| Decimal::from_f64(*real) == Some(number)).map(Value::Real)
        }
        false => number.as_whole().and_then(|whole| i64::try_from(whole).ok()).map(Value::Int),
    };
    value.map_or(Literal::Measure { number, unit: Unit::NONE }, Literal::Value)
}

impl From<Quantity> for Literal {
    fn from(quantity: Quantity) -> Self {
        Literal::Measure { number: quantity.number, unit: quantity.unit }
    }
}

impl fmt::Display for Literal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Literal::Value(value) => value.fmt(f),
            Literal::Measure { number, unit } if unit.is_none() => number.fmt(f),
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
    fn what_the_helps_say_to_write_reads() {
        let help = LiteralFault::Digits.help();
        let example = help.split("as in ").nth(1).and_then(|rest| rest.split(';').next()).unwrap();
        assert!(help.contains(example) && Literal::parse(example).is_ok(), "{example}");
        assert_eq!(Literal::parse(&format!("{example}0")), Err(LiteralFault::Digits));
        for example in ["42", "1.5", "true", "16#0010", "16#FF", "T#500ms", "500 ms", "24 V", "RUNNING"] {
            assert!(Literal::parse(example).is_ok(), "{example}");
        }
    }

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
        assert_eq!(value("1e3"), Value::Real(1000.0));
        for text in ["T#1s500ms", "1500 ms", "1 s 500 ms"] {
            let duration = Literal::parse(text).unwrap();
            assert_eq!(duration.value(), Some(Value::Int(1_500_000_000)), "{text}");
        }
        let volts = Literal::parse("24.0V").unwrap();
        assert_eq!((volts.to_string().as_str(), volts.value()), ("24 V", None));
        assert_eq!(Literal::parse("RUNNING"), Ok(Literal::Label("RUNNING".into())));
    }

    #[test]
    fn numbers_beyond_64_bits_and_every_float_are_what_is_written() {
        let read = |text: &str| Literal::parse(text).unwrap();
        for text in
            ["18446744073709551614", "-9223372036854775809", "18446744073709551616", "18446744073709551614.5"]
        {
            assert_eq!(read(text).to_string(), text);
            assert_eq!(Literal::of(&Node::new(0..0, Data::Float(text.into()))), Ok(read(text)));
        }
        assert_eq!(read("ULINT#18446744073709551615").value(), Some(Value::Word(u64::MAX)));
        assert_eq!(read("18446744073709551616").value(), None);
        assert_eq!(read("18446744073709551614.0").as_quantity(), read("18446744073709551614").as_quantity());
        assert_eq!(read("0.1234567890123456789").value(), Some(Value::Real(0.123_456_789_012_345_68)));
    }

    #[test]
    fn what_is_no_value_says_why() {
        assert_eq!(Literal::parse("16#GG"), Err(LiteralFault::Digits));
        assert_eq!(Literal::parse("16#+1"), Err(LiteralFault::Digits));
        assert_eq!(Literal::parse("16#10000000000000000"), Err(LiteralFault::Digits));
        assert_eq!(Literal::parse("9999999999999999999999999999999"), Err(LiteralFault::Digits));
        assert_eq!(Literal::parse("INT#5 ms"), Err(LiteralFault::Unreadable));
        assert_eq!(Literal::parse("4 .. 20 mA"), Err(LiteralFault::Unreadable));
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
