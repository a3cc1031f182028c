//! The parameters of plants that steps set.

use super::TestBench;
use crate::codes;
use document::Findings;
use drivers::circuit::ParameterKind;
use plans::PlanStep;
use plans::lang::Literal;
use signal::Value;

/// The name that was meant, or all that there are.
fn known(name: &str, names: Vec<&str>) -> String {
    match document::suggest(name, names.iter().copied()) {
        Some(meant) => format!("did you mean `{meant}`?"),
        None => format!("there are {}", names.join(", ")),
    }
}

/// The places of a plant and of its parameter, and the number that it is set to. Reports what is not there or does not fit.
pub(super) fn plant_parameter(
    plant: &str,
    parameter: &str,
    value: &Literal,
    bench: &TestBench<'_>,
    step: &PlanStep,
    out: &mut Findings,
) -> Option<(usize, usize, f64)> {
    let plants = &bench.file.circuit.plants;
    let mut named = plants.iter().enumerate().filter(|(_, spec)| spec.name() == plant);
    let Some((place, spec)) = named.next() else {
        let help = match plants.is_empty() {
            true => String::from("give the plan a `board` with `[[plants]]`"),
            false => known(plant, plants.iter().map(|spec| spec.name()).collect()),
        };
        out.error(codes::NO_PLANT, step.span.clone(), format!("the board has no plant `{plant}`"), help);
        return None;
    };
    if named.next().is_some() {
        let message = format!("several plants of the board are called `{plant}`");
        out.error(
            codes::NO_PLANT,
            step.span.clone(),
            message,
            "give each a name of its own in the board file",
        );
        return None;
    }
    let parameters = spec.parameters();
    let Some(at) = parameters.iter().position(|one| one.name.eq_ignore_ascii_case(parameter)) else {
        let help = match parameters.is_empty() {
            true => String::from("none of it can be set"),
            false => known(parameter, parameters.iter().map(|one| one.name.as_str()).collect()),
        };
        let message = format!("the plant `{plant}` has no parameter `{parameter}`");
        out.error(codes::NO_PARAMETER, step.span.clone(), message, help);
        return None;
    };
    let takes = &parameters[at].takes;
    let number = number_for(takes, value);
    if number.is_none() {
        let message = format!("`{parameter}` of the plant `{plant}` cannot be {value}");
        out.error(codes::PARAMETER_VALUE, step.span.clone(), message, help_for(takes, value));
    }
    Some((place, at, number?))
}

/// The number of a value that a parameter takes.
fn number_for(takes: &ParameterKind, value: &Literal) -> Option<f64> {
    match takes {
        ParameterKind::Flag => match value {
            Literal::Value(Value::Bool(on)) => Some(f64::from(u8::from(*on))),
            Literal::Value(Value::Int(number @ (0 | 1))) => Some(*number as f64),
            _ => None,
        },
        ParameterKind::Measure { dimension, least, most } => {
            let number = dimension.number(&value.as_quantity()?)?;
            (*least..=*most).contains(&number).then_some(number)
        }
    }
}

/// What to write in place of a value that a parameter does not take.
fn help_for(takes: &ParameterKind, value: &Literal) -> String {
    match takes {
        ParameterKind::Flag => String::from("write true or false"),
        ParameterKind::Measure { dimension, least, most } => {
            let of_its_kind = value.as_quantity().and_then(|quantity| dimension.number(&quantity)).is_some();
            match of_its_kind {
                true => format!("write {}", dimension.limits(*least, *most)),
                false => format!("write {}", dimension.example()),
            }
        }
    }
}
