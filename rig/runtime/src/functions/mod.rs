//! Expert functions in plans: their parameters, and what can be looked at by their names: `HSC0.value`,
//! `PTO0.position`.

mod axis;
mod configure;
mod counted;

pub use configure::{check, configure, warnings};
pub use counted::{check as check_counted, counted};

use crate::observable::Observable;
use controller::Probe;
use expert::{ExpertConfig, FunctionKind, FunctionProbe};
use signal::Kind;

/// What can be looked at of a counter or meter, by its name.
const COUNTER: &[(&str, FunctionProbe, Kind)] = &[
    ("value", FunctionProbe::Value, Kind::Int),
    ("captured", FunctionProbe::Captured, Kind::Int),
    ("valid", FunctionProbe::Valid, Kind::Bool),
    ("run", FunctionProbe::Run, Kind::Bool),
    ("error", FunctionProbe::Error, Kind::Int),
    ("TH0", FunctionProbe::Threshold(0), Kind::Bool),
    ("TH1", FunctionProbe::Threshold(1), Kind::Bool),
    ("TH2", FunctionProbe::Threshold(2), Kind::Bool),
    ("TH3", FunctionProbe::Threshold(3), Kind::Bool),
    ("reflex0", FunctionProbe::Reflex(0), Kind::Bool),
    ("reflex1", FunctionProbe::Reflex(1), Kind::Bool),
    ("modulo_flag", FunctionProbe::ModuloFlag, Kind::Bool),
    ("preset_flag", FunctionProbe::PresetFlag, Kind::Bool),
    ("capture_flag", FunctionProbe::CaptureFlag, Kind::Bool),
    ("excess", FunctionProbe::Excess, Kind::Int),
];

/// The same of an axis.
const AXIS: &[(&str, FunctionProbe, Kind)] = &[
    ("state", FunctionProbe::State, Kind::State),
    ("position", FunctionProbe::Position, Kind::Int),
    ("velocity", FunctionProbe::Velocity, Kind::Int),
    ("homed", FunctionProbe::Homed, Kind::Bool),
    ("pulses", FunctionProbe::Pulses, Kind::Int),
    ("error", FunctionProbe::Error, Kind::Int),
];

/// The same of a PWM output: frequency in tenths of a hertz, duty in tenths of a percent.
const PWM: &[(&str, FunctionProbe, Kind)] = &[
    ("frequency", FunctionProbe::Frequency, Kind::Int),
    ("duty", FunctionProbe::Duty, Kind::Int),
    ("pulses", FunctionProbe::Pulses, Kind::Int),
    ("error", FunctionProbe::Error, Kind::Int),
];

/// The same of a frequency generator.
const GENERATOR: &[(&str, FunctionProbe, Kind)] = &[
    ("frequency", FunctionProbe::Frequency, Kind::Int),
    ("pulses", FunctionProbe::Pulses, Kind::Int),
    ("error", FunctionProbe::Error, Kind::Int),
];

const fn facts(kind: &FunctionKind) -> &'static [(&'static str, FunctionProbe, Kind)] {
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
