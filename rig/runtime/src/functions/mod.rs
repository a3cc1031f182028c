//! Expert functions in plans: their parameters, and what can be looked at by their names: `HSC0.value`,
//! `PTO0.position`.

mod axis;
mod configure;
mod counted;
mod lines;

pub use configure::{check, configure, warnings};
pub use counted::{check as check_counted, counted};
pub(crate) use lines::on_lines;

use crate::subject::Observable;
use controller::Probe;
use expert::{AxisState, ExpertConfig, Fact, FunctionKind};
use signal::Kind;

/// What can be looked at of a counter or meter, by its name.
const COUNTER: &[(&str, Fact, Kind)] = &[
    ("value", Fact::Value, Kind::Int),
    ("captured", Fact::Captured, Kind::Int),
    ("valid", Fact::Valid, Kind::Bool),
    ("run", Fact::Run, Kind::Bool),
    ("error", Fact::Error, Kind::Int),
    ("TH0", Fact::Threshold(0), Kind::Bool),
    ("TH1", Fact::Threshold(1), Kind::Bool),
    ("TH2", Fact::Threshold(2), Kind::Bool),
    ("TH3", Fact::Threshold(3), Kind::Bool),
    ("reflex0", Fact::Reflex(0), Kind::Bool),
    ("reflex1", Fact::Reflex(1), Kind::Bool),
    ("modulo_flag", Fact::ModuloFlag, Kind::Bool),
    ("preset_flag", Fact::PresetFlag, Kind::Bool),
    ("capture_flag", Fact::CaptureFlag, Kind::Bool),
    ("excess", Fact::Excess, Kind::Int),
];

/// The same of an axis.
const AXIS: &[(&str, Fact, Kind)] = &[
    ("state", Fact::State, Kind::State),
    ("position", Fact::Position, Kind::Int),
    ("velocity", Fact::Velocity, Kind::Int),
    ("homed", Fact::Homed, Kind::Bool),
    ("pulses", Fact::Pulses, Kind::Int),
    ("error", Fact::Error, Kind::Int),
];

/// The same of a PWM output: frequency in tenths of a hertz, duty in tenths of a percent.
const PWM: &[(&str, Fact, Kind)] = &[
    ("frequency", Fact::Frequency, Kind::Int),
    ("duty", Fact::Duty, Kind::Int),
    ("pulses", Fact::Pulses, Kind::Int),
    ("error", Fact::Error, Kind::Int),
];

/// The same of a frequency generator.
const GENERATOR: &[(&str, Fact, Kind)] = &[
    ("frequency", Fact::Frequency, Kind::Int),
    ("pulses", Fact::Pulses, Kind::Int),
    ("error", Fact::Error, Kind::Int),
];

/// The names of an axis' states, by their numbers (io:STD-PTO-03).
const STATES: [(AxisState, &str); 7] = [
    (AxisState::Disabled, "Disabled"),
    (AxisState::Standstill, "Standstill"),
    (AxisState::Homing, "Homing"),
    (AxisState::DiscreteMotion, "DiscreteMotion"),
    (AxisState::ContinuousMotion, "ContinuousMotion"),
    (AxisState::Stopping, "Stopping"),
    (AxisState::ErrorStop, "ErrorStop"),
];

/// The names of the values of a fact, where they have any.
pub fn labels(fact: Fact) -> Vec<(i64, String)> {
    let states = STATES.iter().map(|(state, name)| (*state as i64, (*name).to_owned()));
    states.filter(|_| fact == Fact::State).collect()
}

const fn facts(kind: &FunctionKind) -> &'static [(&'static str, Fact, Kind)] {
    match kind {
        FunctionKind::Counter(_) => COUNTER,
        FunctionKind::Axis(_) => AXIS,
        FunctionKind::Pwm(_) => PWM,
        FunctionKind::Generator(_) => GENERATOR,
    }
}

/// What `HSC0.value` and the like mean on a controller with these functions, in any case of letters.
pub fn observable(name: &str, config: &ExpertConfig) -> Option<Observable> {
    let (function, fact) = name.split_once('.')?;
    let place = config.functions.iter().position(|known| known.name.eq_ignore_ascii_case(function))?;
    let facts = facts(&config.functions.get(place)?.kind);
    let (_, fact, kind) = facts.iter().find(|(known, ..)| known.eq_ignore_ascii_case(fact))?;
    Some(Observable { probe: Probe::Expert { function: place, fact: *fact }, kind: *kind })
}

/// The names of everything that can be looked at of these functions.
pub fn names(config: &ExpertConfig) -> impl Iterator<Item = String> {
    let named = |function: &expert::Function| {
        facts(&function.kind).iter().map(|(fact, ..)| format!("{}.{fact}", function.name)).collect::<Vec<_>>()
    };
    config.functions.iter().flat_map(named)
}
