//! What a plan may look at inside a subject.

use controller::{LedPattern, OutputState, Probe};
use expert::{AxisState, FunctionProbe};
use signal::ValueKind;

/// Something inside the subject that a plan may look at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Observable {
    /// What the subject calls it.
    pub probe: Probe,
    /// What its values are.
    pub kind: ValueKind,
}

impl Observable {
    /// The names of its values, where they have any.
    pub fn labels(&self) -> Vec<(i64, String)> {
        match self.probe {
            Probe::Led(_) => {
                LedPattern::ALL.iter().map(|pattern| (pattern.number(), pattern.name().to_owned())).collect()
            }
            Probe::Output(_) => {
                OutputState::ALL.iter().map(|state| (state.number(), state.name().to_owned())).collect()
            }
            Probe::Expert { fact, .. } => labels(fact),
            _ => Vec::new(),
        }
    }
}

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
fn labels(fact: FunctionProbe) -> Vec<(i64, String)> {
    let states = STATES.iter().map(|(state, name)| (*state as i64, (*name).to_owned()));
    states.filter(|_| fact == FunctionProbe::State).collect()
}
