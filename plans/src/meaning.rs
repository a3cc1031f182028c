//! What a written value means for a signal.

use signal::{Decimal, Quantity, QuantityFault, QuantityRange, SignalInfo, Unit, Value, ValueKind};

use crate::lang::Literal;
use crate::monitor::Number;

/// A written value as a value of this signal: labels are those of its state, quantities are in its unit.
///
/// # Errors
/// Why it has no meaning for the signal.
pub fn value_of(literal: &Literal, info: &SignalInfo) -> Result<Value, String> {
    if is_high_z(literal) && info.kind != ValueKind::State {
        return Ok(Value::HighZ);
    }
    Ok(match number(literal, info)? {
        Number::Int(number) => match i64::try_from(number) {
            Ok(number) => Value::Int(number),
            Err(_) => {
                Value::Word(u64::try_from(number).map_err(|_| String::from("the number has over 64 bits"))?)
            }
        },
        real => Value::Real(real.as_real()),
    })
}

/// A written value in words.
pub fn show_literal(literal: &Literal) -> String {
    literal.to_string()
}

/// Whether it stands for a line that nobody drives.
pub(crate) fn is_high_z(literal: &Literal) -> bool {
    match literal {
        Literal::Label(word) => word.eq_ignore_ascii_case("z"),
        Literal::Value(value) => matches!(value, Value::HighZ),
        Literal::Measure { .. } => false,
    }
}

/// A literal as a number of this signal.
///
/// # Errors
/// Why it has no meaning for the signal.
pub fn number(literal: &Literal, info: &SignalInfo) -> Result<Number, String> {
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

/// States that a help names at most.
const NAMED: usize = 12;

/// What a plan writes for a value of this signal.
pub(crate) fn what_to_write(info: &SignalInfo) -> String {
    let unit = info.unit.as_str();
    match info.kind {
        _ if !info.labels.is_empty() => {
            let known: Vec<String> =
                info.labels.iter().take(NAMED).map(|(_, label)| format!("\"{label}\"")).collect();
            let more = if info.labels.len() > NAMED { ", ..." } else { "" };
            format!("write one of its states: {}{more}", known.join(", "))
        }
        ValueKind::Bool => String::from("write true or false"),
        _ if unit == "ns" => String::from("write a duration such as \"10 ms\""),
        _ if unit.is_empty() => String::from(
            "write a number without a unit, such as 42; a variable of type TIME takes a duration such as \"500 ms\"",
        ),
        _ => format!("write a number in its unit, such as \"1.5 {unit}\""),
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
pub(crate) struct ToleranceBand {
    /// The value.
    pub(crate) middle: Decimal,
    /// The least that is within the tolerance.
    pub(crate) min: Decimal,
    /// The greatest that is within the tolerance.
    pub(crate) max: Decimal,
}

impl ToleranceBand {
    /// `tolerance` may be a part of `middle`, as in `10 %`, for a signal that is not in `%` itself.
    ///
    /// # Errors
    /// Why the two have no meaning for the signal.
    pub(crate) fn new(
        middle: &Literal,
        tolerance: &Literal,
        info: &SignalInfo,
    ) -> Result<ToleranceBand, String> {
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
        Ok(ToleranceBand { middle: own.number, min: end(range.min), max: end(range.max) })
    }
}

/// A literal as an exact number of this signal.
pub(crate) fn exact(literal: &Literal, info: &SignalInfo) -> Result<Decimal, String> {
    if let Some(quantity) = literal.quantity() {
        return in_unit_of(&quantity, info);
    }
    number(literal, info)?.as_decimal().ok_or_else(|| format!("`{literal}` is no finite number"))
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
            let mut info = SignalInfo::exact("u", ValueKind::Real);
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
    fn a_help_says_what_to_write() {
        let of = |kind: ValueKind, unit: &str, labels: &[&str]| {
            let mut info = SignalInfo::exact("u", kind);
            info.unit = unit.into();
            info.labels = (0..).zip(labels).map(|(n, label)| (n, (*label).to_owned())).collect();
            what_to_write(&info)
        };
        assert_eq!(of(ValueKind::Bool, "", &[]), "write true or false");
        assert_eq!(of(ValueKind::Real, "V", &[]), "write a number in its unit, such as \"1.5 V\"");
        assert_eq!(of(ValueKind::Int, "ns", &[]), "write a duration such as \"10 ms\"");
        assert_eq!(
            of(ValueKind::State, "", &["RUNNING", "HALT"]),
            "write one of its states: \"RUNNING\", \"HALT\""
        );
        assert!(of(ValueKind::Int, "", &[]).starts_with("write a number without a unit"));
    }

    #[test]
    fn a_tolerance_ends_where_its_decimals_say() {
        let ends = |unit: &str, middle: &str, tolerance: &str| {
            let mut info = SignalInfo::exact("u", ValueKind::Real);
            info.unit = unit.into();
            let around = ToleranceBand::new(&literal_of(middle), &literal_of(tolerance), &info)?;
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
}
