//! Expert functions in plans: their parameters, and what can be looked at by their names: `HSC0.value`,
//! `PTO0.position`.

mod axis;
mod configure;
mod counted;

pub use configure::{check, configure, warnings};
pub use counted::{check as check_counted, counted};

use crate::application::observable::Observable;
use controller::Probe;
use expert::{ExpertConfig, FunctionKind, FunctionProbe};
use signal::ValueKind;

/// What can be looked at of a counter or meter, by its name.
const COUNTER: &[(&str, FunctionProbe, ValueKind)] = &[
    ("value", FunctionProbe::Value, ValueKind::Int),
    ("captured", FunctionProbe::Captured, ValueKind::Int),
    ("valid", FunctionProbe::Valid, ValueKind::Bool),
    ("run", FunctionProbe::Run, ValueKind::Bool),
    ("error", FunctionProbe::Error, ValueKind::Int),
    ("TH0", FunctionProbe::Threshold(0), ValueKind::Bool),
    ("TH1", FunctionProbe::Threshold(1), ValueKind::Bool),
    ("TH2", FunctionProbe::Threshold(2), ValueKind::Bool),
    ("TH3", FunctionProbe::Threshold(3), ValueKind::Bool),
    ("reflex0", FunctionProbe::Reflex(0), ValueKind::Bool),
    ("reflex1", FunctionProbe::Reflex(1), ValueKind::Bool),
    ("modulo_flag", FunctionProbe::ModuloFlag, ValueKind::Bool),
    ("preset_flag", FunctionProbe::PresetFlag, ValueKind::Bool),
    ("capture_flag", FunctionProbe::CaptureFlag, ValueKind::Bool),
    ("excess", FunctionProbe::Excess, ValueKind::Int),
];

/// The same of an axis.
const AXIS: &[(&str, FunctionProbe, ValueKind)] = &[
    ("state", FunctionProbe::State, ValueKind::State),
    ("position", FunctionProbe::Position, ValueKind::Int),
    ("velocity", FunctionProbe::Velocity, ValueKind::Int),
    ("homed", FunctionProbe::Homed, ValueKind::Bool),
    ("pulses", FunctionProbe::Pulses, ValueKind::Int),
    ("error", FunctionProbe::Error, ValueKind::Int),
];

/// The same of a PWM output: frequency in tenths of a hertz, duty in tenths of a percent.
const PWM: &[(&str, FunctionProbe, ValueKind)] = &[
    ("frequency", FunctionProbe::Frequency, ValueKind::Int),
    ("duty", FunctionProbe::Duty, ValueKind::Int),
    ("pulses", FunctionProbe::Pulses, ValueKind::Int),
    ("error", FunctionProbe::Error, ValueKind::Int),
];

/// The same of a frequency generator.
const GENERATOR: &[(&str, FunctionProbe, ValueKind)] = &[
    ("frequency", FunctionProbe::Frequency, ValueKind::Int),
    ("pulses", FunctionProbe::Pulses, ValueKind::Int),
    ("error", FunctionProbe::Error, ValueKind::Int),
];

const fn facts(kind: &FunctionKind) -> &'static [(&'static str, FunctionProbe, ValueKind)] {
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
    let named = |function: &expert::FunctionConfig| {
        facts(&function.kind).iter().map(|(fact, ..)| format!("{}.{fact}", function.name)).collect::<Vec<_>>()
    };
    config.functions.iter().flat_map(named)
}
