//! Conditions on values as a plan writes them: `is`, `one-of`, `min` and `max`, `near` and `tolerance`.

use std::fmt;

use document::{Fields, KeySpec, KeyType, Node};
use signal::{Decimal, Kind, Quantity, QuantityFault, QuantityRange, SignalInfo, Unit, Value, is_range};

use super::Context;
use super::common::bad_range;
use crate::codes;
use crate::judge::{Number, Test};
use crate::lang::Literal;

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
pub enum Condition {
    /// One of these.
    OneOf(Vec<Literal>),
    /// Within these, both included.
    Within { min: Option<Literal>, max: Option<Literal> },
    /// At most as far from a value as the tolerance.
    Near { middle: Literal, tolerance: Literal },
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
            return wanted(fields.get("is")?, cx);
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
        let quantity = |limit: &Option<Literal>| limit.as_ref().and_then(Literal::quantity);
        let reversed = match (&min, &max, quantity(&min), quantity(&max)) {
            (Some(Literal::Value(low)), Some(Literal::Value(high)), ..) => low.as_real() > high.as_real(),
            (.., Some(low), Some(high)) => high.in_unit(&low.unit).is_some_and(|high| low.number > high),
            _ => false,
        };
        if reversed {
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
            Condition::Near { middle, tolerance } => {
                let around = Around::new(middle, tolerance, info)?;
                Ok(Test::Range { min: Some(around.min.into()), max: Some(around.max.into()) })
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
            Condition::Near { middle, tolerance } => write!(f, "{middle} ± {tolerance}"),
        }
    }
}

/// Reads `is`: a value, or a range of quantities.
fn wanted(node: &Node, cx: &mut Context<'_>) -> Option<Condition> {
    let Some(text) = node.as_text().filter(|text| is_range(text)) else {
        return Some(Condition::OneOf(vec![literal(node, cx)?]));
    };
    match QuantityRange::parse(text) {
        Ok(QuantityRange { min, max }) => {
            Some(Condition::Within { min: min.map(Literal::from), max: max.map(Literal::from) })
        }
        Err(error) => {
            let help = "write \"4 .. 20 mA\", \".. 5 V\", \"5 V ..\" or \"24 V ± 10 %\"";
            bad_range(node, "is", "range", error, help, cx);
            None
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
        Literal::Measure { .. } => exact(literal, info).map(Number::from),
    }
}

/// A quantity in the unit of this signal, exactly.
fn in_unit_of(quantity: &Quantity, info: &SignalInfo) -> Result<Decimal, String> {
    let own = Unit::new(&info.unit);
    let number = if quantity.unit.is_none() {
        Some(quantity.number)
    } else if own.is_none() && quantity.is_time() {
        // A variable of type TIME has no unit: it holds nanoseconds.
        quantity.in_unit(&Unit::new("ns"))
    } else {
        quantity.in_unit(&own)
    };
    number.ok_or_else(|| {
        let has = if own.is_none() { "no unit".into() } else { format!("the unit {}", info.unit) };
        format!("`{}` has {has}; `{quantity}` cannot be compared with it", info.name)
    })
}

/// A value and its tolerance as exact numbers in the unit of a signal.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Around {
    /// The value.
    pub(crate) middle: Decimal,
    /// The least that is within the tolerance.
    pub(crate) min: Decimal,
    /// The greatest that is within the tolerance.
    pub(crate) max: Decimal,
}

impl Around {
    /// `tolerance` may be a part of `middle`, as in `10 %`, for a signal that is not in `%` itself.
    ///
    /// # Errors
    /// Why the two have no meaning for the signal.
    pub(crate) fn new(middle: &Literal, tolerance: &Literal, info: &SignalInfo) -> Result<Around, String> {
        let own = Quantity { number: exact(middle, info)?, unit: Unit::new(&info.unit) };
        let band = match tolerance.quantity() {
            Some(part) if part.is_part() && !own.is_part() => part,
            _ => Quantity { number: exact(tolerance, info)?, unit: own.unit.clone() },
        };
        let range = QuantityRange::around(&own, &band).map_err(|fault| match fault {
            QuantityFault::Negative => format!("a tolerance of {tolerance} can never be met"),
            fault => format!("{middle} ± {tolerance}: {fault}"),
        })?;
        let end = |end: Option<Quantity>| end.map_or(own.number, |end| end.number);
        Ok(Around { middle: own.number, min: end(range.min), max: end(range.max) })
    }
}

/// A literal as an exact number of this signal.
pub(crate) fn exact(literal: &Literal, info: &SignalInfo) -> Result<Decimal, String> {
    if let Some(quantity) = literal.quantity() {
        return in_unit_of(&quantity, info);
    }
    let exact = match number(literal, info)? {
        Number::Int(whole) => Some(Decimal::from(whole)),
        Number::Real(real) => Decimal::from_f64(real),
    };
    exact.ok_or_else(|| format!("`{literal}` is no finite number"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn literal_of(text: &str) -> Literal {
        Literal::parse(text).unwrap()
    }

    #[test]
    fn quantities_meet_in_the_unit_of_the_signal() {
        let bind = |unit: &str, text: &str| {
            let mut info = SignalInfo::exact("u", Kind::Real);
            info.unit = unit.into();
            number(&literal_of(text), &info)
        };
        assert_eq!(bind("V", "1500 mV"), Ok(Number::Real(1.5)));
        assert_eq!(bind("°C", "20.5 degC"), Ok(Number::Real(20.5)));
        assert_eq!(bind("l/min", "3 l/min"), Ok(Number::Int(3)));
        assert_eq!(bind("ms", "1 s 500 ms"), Ok(Number::Int(1500)));
        assert_eq!(bind("", "T#1ms"), Ok(Number::Int(1_000_000)));
        assert_eq!(bind("V", "3"), Ok(Number::Int(3)));
        let fault = "`u` has the unit V; `1 A` cannot be compared with it";
        assert_eq!(bind("V", "1 A"), Err(fault.into()));
        for (unit, text) in [("V", "500 ms"), ("", "1 V"), ("l/min", "3 l/h"), ("h", "90 min")] {
            assert!(bind(unit, text).is_err(), "{text} in {unit}");
        }
    }

    #[test]
    fn a_tolerance_ends_where_its_decimals_say() {
        let ends = |unit: &str, middle: &str, tolerance: &str| {
            let mut info = SignalInfo::exact("u", Kind::Real);
            info.unit = unit.into();
            let around = Around::new(&literal_of(middle), &literal_of(tolerance), &info)?;
            Ok((around.min.as_f64(), around.max.as_f64()))
        };
        // In floats 0.3 + 0.1 is above 0.4, and 24 - 2.4 below 21.6.
        assert_eq!(ends("V", "0.3", "100 mV"), Ok((0.2, 0.4)));
        assert_eq!(ends("V", "24 V", "10 %"), Ok((21.6, 26.4)));
        assert_eq!(ends("%", "50 %", "5 %"), Ok((45.0, 55.0)));
        assert_eq!(ends("", "1000", "0.5 %"), Ok((995.0, 1005.0)));
        assert_eq!(ends("", "16#10", "1"), Ok((15.0, 17.0)));
        assert!(ends("V", "24 V", "-1").is_err_and(|why: String| why.contains("never be met")));
        assert!(ends("V", "24 V", "1 A").is_err());
    }

    #[test]
    fn labels_are_those_of_the_state() {
        let mut info = SignalInfo::exact("state", Kind::State);
        info.labels = vec![(2, "RUNNING".into()), (4, "HALT".into())];
        assert_eq!(Condition::label("halt").bind(&info), Ok(Test::OneOf(vec![Number::Int(4)])));
        assert!(Condition::label("RUNING").bind(&info).unwrap_err().contains("did you mean `RUNNING`"));
    }
}
