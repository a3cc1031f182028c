//! Conditions on values as a plan writes them: `is`, `one-of`, `min` and `max`, `near` and `tolerance`.

use std::fmt;

use document::{Fields, KeySpec, KeyType, Node};
use signal::{Kind, SignalInfo, Value};

use super::Context;
use crate::codes;
use crate::judge::{Number, Test};
use crate::lang::Literal;

/// The value that is wanted.
pub(super) const IS: KeySpec = KeySpec::optional(
    "is",
    KeyType::Value,
    "The value that is wanted: true, 5, \"16#0010\", \"24 V\", \"RUNNING\"; \"Z\" for a line that nobody drives",
);
/// The least value.
pub(super) const MIN: KeySpec =
    KeySpec::optional("min", KeyType::Value, "The least value that is allowed, itself included");
/// The greatest value.
pub(super) const MAX: KeySpec =
    KeySpec::optional("max", KeyType::Value, "The greatest value that is allowed, itself included");
/// Several values.
pub(super) const ONE_OF: KeySpec =
    KeySpec::optional("one-of", KeyType::List(&KeyType::Value), "The values that are allowed");

/// What a value has to be, in the words of the plan.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Condition {
    /// One of these.
    OneOf(Vec<Literal>),
    /// Within these, both included.
    Within { min: Option<Literal>, max: Option<Literal> },
}

impl Condition {
    /// It is TRUE.
    pub(super) fn is_true() -> Condition {
        Condition::OneOf(vec![Literal::TRUE])
    }

    /// It is this label.
    pub(super) fn label(name: &str) -> Condition {
        Condition::OneOf(vec![Literal::Label(name.to_owned())])
    }

    /// Reads exactly one of `is`, `one-of`, `min`/`max`; `None` with a finding if there is none or two, and
    /// `default` if there is none and there is a default.
    pub(super) fn read(
        fields: &Fields<'_>,
        default: Option<Condition>,
        cx: &mut Context<'_>,
    ) -> Option<Condition> {
        let range = fields.has("min") || fields.has("max");
        let forms = [fields.has("is"), fields.has("one-of"), range];
        match forms.iter().filter(|form| **form).count() {
            0 if default.is_some() => return default,
            1 => {}
            given => {
                let message = match given {
                    0 => "no value is wanted: the claim can never fail",
                    _ => "a value is wanted in two ways at once",
                };
                let help = "give one of `is`, `one-of`, or `min` and `max`";
                cx.out.error(codes::CLAIM, cx.place.clone(), message, help);
                return None;
            }
        }
        if forms[0] {
            return Some(Condition::OneOf(vec![literal(fields.get("is")?, cx)?]));
        }
        if forms[1] {
            let list = fields.each("one-of");
            if list.is_empty() {
                if let Some(node) = fields.get("one-of") {
                    cx.out.bad(codes::CLAIM, node, "no value is allowed: the claim can never be met", "");
                }
                return None;
            }
            let read: Vec<_> = list.iter().map(|node| literal(node, cx)).collect();
            return Some(Condition::OneOf(read.into_iter().collect::<Option<_>>()?));
        }
        let mut limit = |key| match fields.get(key) {
            Some(node) => literal(node, cx).map(Some),
            None if fields.has(key) => None,
            None => Some(None),
        };
        let (min, max) = (limit("min"), limit("max"));
        let (min, max) = (min?, max?);
        if let (Some(Literal::Value(low)), Some(Literal::Value(high))) = (&min, &max)
            && low.as_real() > high.as_real()
        {
            let node = fields.get("max")?;
            let message = "`max` is below `min`: the claim can never be met";
            cx.out.bad(codes::CLAIM, node, message, "exchange them");
            return None;
        }
        Some(Condition::Within { min, max })
    }

    /// The condition in the terms of a signal.
    ///
    /// # Errors
    /// Why it means nothing for this signal, one sentence.
    pub(crate) fn bind(&self, info: &SignalInfo) -> Result<Test, String> {
        match self {
            Condition::OneOf(list) => {
                if let [one] = list.as_slice()
                    && is_high_z(one)
                    && info.kind != Kind::State
                {
                    return Ok(Test::HighZ);
                }
                let numbers: Result<Vec<Number>, String> = list.iter().map(|one| number(one, info)).collect();
                Ok(Test::OneOf(numbers?))
            }
            Condition::Within { min, max } => {
                let bind = |limit: &Option<Literal>| limit.as_ref().map(|one| number(one, info)).transpose();
                Ok(Test::Range { min: bind(min)?, max: bind(max)? })
            }
        }
    }
}

impl fmt::Display for Condition {
    /// `TRUE`, `one of 1, 2`, `at least 3 V`, `1 .. 5`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Condition::OneOf(list) if list.len() == 1 => list[0].fmt(f),
            Condition::OneOf(list) => {
                let shown: Vec<String> = list.iter().map(Literal::to_string).collect();
                write!(f, "one of {}", shown.join(", "))
            }
            Condition::Within { min: Some(min), max: Some(max) } => {
                write!(f, "{min} .. {max}")
            }
            Condition::Within { min: Some(min), max: None } => write!(f, "at least {min}"),
            Condition::Within { min: None, max: Some(max) } => write!(f, "at most {max}"),
            Condition::Within { min: None, max: None } => f.write_str("anything"),
        }
    }
}

/// Reads a value.
pub(crate) fn literal(node: &Node, cx: &mut Context<'_>) -> Option<Literal> {
    match Literal::of(node) {
        Ok(literal) => Some(literal),
        Err(fault) => {
            cx.out.bad(codes::VALUE, node, fault.to_string(), "");
            None
        }
    }
}

/// Whether it stands for a line that nobody drives.
pub(crate) fn is_high_z(literal: &Literal) -> bool {
    match literal {
        Literal::Label(word) => word.eq_ignore_ascii_case("z"),
        Literal::Value(value) => matches!(value, Value::HighZ),
        Literal::Measure { .. } => false,
    }
}

/// A value as a user writes it.
pub(crate) fn show(literal: &Literal) -> String {
    literal.to_string()
}

/// A literal as a number of this signal.
///
/// # Errors
/// Why it has no meaning for the signal.
pub(crate) fn number(literal: &Literal, info: &SignalInfo) -> Result<Number, String> {
    match literal {
        Literal::Value(Value::Real(real)) => Ok(Number::Real(*real)),
        Literal::Value(value) => match value.as_int() {
            Some(n) => Ok(Number::Int(n)),
            None => Err(format!("`{value}` is no value that `{}` can be compared with", info.name)),
        },
        Literal::Label(word) => {
            match info.labels.iter().find(|(_, label)| label.eq_ignore_ascii_case(word)) {
                Some((n, _)) => Ok(Number::Int(i128::from(*n))),
                None if info.labels.is_empty() => {
                    Err(format!("`{}` has no named states, so it cannot be `{word}`", info.name))
                }
                None => {
                    let known = info.labels.iter().map(|(_, label)| label.as_str());
                    let hint = match document::suggest(word, known.clone()) {
                        Some(meant) => format!("did you mean `{meant}`?"),
                        None => format!("its states are {}", known.collect::<Vec<_>>().join(", ")),
                    };
                    Err(format!("`{}` has no state `{word}`; {hint}", info.name))
                }
            }
        }
        Literal::Measure { number, unit } => {
            let (own, base) = scale(&info.unit);
            let (given, dimension) = scale(unit);
            if base != dimension {
                let has =
                    if info.unit.is_empty() { "no unit".into() } else { format!("the unit {}", info.unit) };
                return Err(format!(
                    "`{}` has {has}; `{number} {unit}` cannot be compared with it",
                    info.name
                ));
            }
            Ok(Number::Real(if own == given { *number } else { number * given / own }))
        }
    }
}

/// The factor and the base of a unit with an SI prefix: `mA` is 1e-3 and `A`.
fn scale(unit: &str) -> (f64, &str) {
    const BASES: [&str; 9] = ["V", "A", "Hz", "W", "Pa", "m", "g", "N", "Ohm"];
    let unit = if unit == "°C" { "degC" } else { unit };
    if BASES.contains(&unit) {
        return (1.0, unit);
    }
    let prefixes = [("m", 1e-3), ("k", 1e3), ("M", 1e6), ("u", 1e-6), ("µ", 1e-6), ("n", 1e-9), ("G", 1e9)];
    for (prefix, factor) in prefixes {
        if let Some(base) = unit.strip_prefix(prefix).filter(|base| BASES.contains(base)) {
            return (factor, base);
        }
    }
    (1.0, unit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_meet_in_their_base() {
        let mut info = SignalInfo::exact("u", Kind::Real);
        info.unit = "V".into();
        let milli = Literal::Measure { number: 1500.0, unit: "mV".into() };
        assert_eq!(number(&milli, &info), Ok(Number::Real(1.5)));
        let amps = Literal::Measure { number: 1.0, unit: "A".into() };
        assert!(number(&amps, &info).is_err());
    }

    #[test]
    fn labels_are_those_of_the_state() {
        let mut info = SignalInfo::exact("state", Kind::State);
        info.labels = vec![(2, "RUNNING".into()), (4, "HALT".into())];
        assert_eq!(Condition::label("halt").bind(&info), Ok(Test::OneOf(vec![Number::Int(4)])));
        assert!(Condition::label("RUNING").bind(&info).unwrap_err().contains("did you mean `RUNNING`"));
    }
}
