//! Conditions on values as a plan writes them: `is`, `one-of`, `min` and `max`, `near` and `tolerance`.

use std::fmt;

use document::{Fields, KeySpec, KeyType, Node};
use signal::{QuantityRange, SignalInfo, ValueKind, is_range};

use super::ReadContext;
use super::common::bad_range;
use crate::codes;
use crate::lang::Literal;
use crate::meaning::{ToleranceBand, is_high_z, number};
use crate::monitor::{Number, ValueTest};

/// The value that is wanted.
pub(super) const IS: KeySpec = KeySpec::optional(
    "is",
    KeyType::Value,
    "The value that is wanted: true, 5, \"16#0010\", \"24 V\", \"RUNNING\"; \"Z\" for a line that nobody drives; or a \
     range: \"4 .. 20 mA\", \"24 V ± 10 %\"",
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
pub enum ValueCondition {
    /// One of these.
    OneOf(Vec<Literal>),
    /// Within these, both included.
    Within { min: Option<Literal>, max: Option<Literal> },
    /// At most as far from a value as the tolerance.
    Near { middle: Literal, tolerance: Literal },
}

impl ValueCondition {
    /// It is TRUE.
    pub(super) fn is_true() -> ValueCondition {
        ValueCondition::OneOf(vec![Literal::TRUE])
    }

    /// It is this label.
    pub(super) fn label(name: &str) -> ValueCondition {
        ValueCondition::OneOf(vec![Literal::Label(name.to_owned())])
    }

    /// Reads exactly one of `is`, `one-of`, `min`/`max`; `None` with a finding if there is none or two, and
    /// `default` if there is none and there is a default.
    pub(super) fn read(
        fields: &Fields<'_>,
        default: Option<ValueCondition>,
        cx: &mut ReadContext<'_>,
    ) -> Option<ValueCondition> {
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
            return wanted(fields.get("is")?, cx);
        }
        if forms[1] {
            let list = fields.each("one-of");
            if list.is_empty() {
                if let Some(node) = fields.get("one-of") {
                    cx.out.bad(
                        codes::CLAIM,
                        node,
                        "no value is allowed: the claim can never be met",
                        "write one-of = [1, 2]",
                    );
                }
                return None;
            }
            let read: Vec<_> = list.iter().map(|node| literal(node, cx)).collect();
            return Some(ValueCondition::OneOf(read.into_iter().collect::<Option<_>>()?));
        }
        let mut limit = |key| match fields.get(key) {
            Some(node) => literal(node, cx).map(Some),
            None if fields.has(key) => None,
            None => Some(None),
        };
        let (min, max) = (limit("min"), limit("max"));
        let (min, max) = (min?, max?);
        let quantity = |limit: &Option<Literal>| limit.as_ref().and_then(Literal::as_quantity);
        let reversed = quantity(&min)
            .zip(quantity(&max))
            .is_some_and(|(low, high)| high.in_unit(&low.unit).is_some_and(|high| low.number > high));
        if reversed {
            let node = fields.get("max")?;
            let message = "`max` is below `min`: the claim can never be met";
            cx.out.bad(codes::CLAIM, node, message, "exchange them");
            return None;
        }
        Some(ValueCondition::Within { min, max })
    }

    /// The condition in the terms of a signal.
    ///
    /// # Errors
    /// Why it means nothing for this signal, one sentence.
    pub(crate) fn bind(&self, info: &SignalInfo) -> Result<ValueTest, String> {
        match self {
            ValueCondition::OneOf(list) => {
                if let [one] = list.as_slice()
                    && is_high_z(one)
                    && info.kind != ValueKind::State
                {
                    return Ok(ValueTest::HighZ);
                }
                let numbers: Result<Vec<Number>, String> = list.iter().map(|one| number(one, info)).collect();
                Ok(ValueTest::OneOf(numbers?))
            }
            ValueCondition::Within { min, max } => {
                let bind = |limit: &Option<Literal>| limit.as_ref().map(|one| number(one, info)).transpose();
                Ok(ValueTest::Range { min: bind(min)?, max: bind(max)? })
            }
            ValueCondition::Near { middle, tolerance } => {
                let around = ToleranceBand::new(middle, tolerance, info)?;
                Ok(ValueTest::Range { min: Some(around.min.into()), max: Some(around.max.into()) })
            }
        }
    }
}

impl fmt::Display for ValueCondition {
    /// `TRUE`, `one of 1, 2`, `at least 3 V`, `1 .. 5`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ValueCondition::OneOf(list) if list.len() == 1 => list[0].fmt(f),
            ValueCondition::OneOf(list) => {
                let shown: Vec<String> = list.iter().map(Literal::to_string).collect();
                write!(f, "one of {}", shown.join(", "))
            }
            ValueCondition::Within { min: Some(min), max: Some(max) } => {
                write!(f, "{min} .. {max}")
            }
            ValueCondition::Within { min: Some(min), max: None } => write!(f, "at least {min}"),
            ValueCondition::Within { min: None, max: Some(max) } => write!(f, "at most {max}"),
            ValueCondition::Within { min: None, max: None } => f.write_str("anything"),
            ValueCondition::Near { middle, tolerance } => write!(f, "{middle} ± {tolerance}"),
        }
    }
}

/// Reads `is`: a value, or a range of quantities.
fn wanted(node: &Node, cx: &mut ReadContext<'_>) -> Option<ValueCondition> {
    let Some(text) = node.as_text().filter(|text| is_range(text)) else {
        return Some(ValueCondition::OneOf(vec![literal(node, cx)?]));
    };
    match QuantityRange::parse(text) {
        Ok(QuantityRange { min, max }) => {
            Some(ValueCondition::Within { min: min.map(Literal::from), max: max.map(Literal::from) })
        }
        Err(error) => {
            let help = "write \"4 .. 20 mA\", \".. 5 V\", \"5 V ..\" or \"24 V ± 10 %\"";
            bad_range(node, "is", "range", error, help, cx);
            None
        }
    }
}

/// Reads a value.
pub(crate) fn literal(node: &Node, cx: &mut ReadContext<'_>) -> Option<Literal> {
    match Literal::of(node) {
        Ok(literal) => Some(literal),
        Err(fault) => {
            cx.out.bad(codes::VALUE, node, fault.to_string(), fault.help());
            None
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_those_of_the_state() {
        let mut info = SignalInfo::exact("state", ValueKind::State);
        info.labels = vec![(2, "RUNNING".into()), (4, "HALT".into())];
        assert_eq!(ValueCondition::label("halt").bind(&info), Ok(ValueTest::OneOf(vec![Number::Int(4)])));
        assert!(ValueCondition::label("RUNING").bind(&info).unwrap_err().contains("did you mean `RUNNING`"));
    }
}
