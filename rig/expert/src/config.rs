//! What expert functions a controller has.

use crate::{AxisConfig, CounterConfig, WaveConfig};

/// The expert functions of a configuration, in the user's order. The place of a function, counted from 1, is the number
/// by which function blocks refer to it; 0 is None (io:EXP-16).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ExpertConfig {
    /// The functions.
    pub functions: Vec<FunctionConfig>,
}

/// One function.
#[derive(Clone, Debug, PartialEq)]
pub struct FunctionConfig {
    /// Name of the instance, by which programs know it (io:EXP-06).
    pub name: String,
    /// What it is and does.
    pub kind: FunctionKind,
}

/// The kinds of functions, with their parameters.
#[derive(Clone, Debug, PartialEq)]
pub enum FunctionKind {
    /// A fast counter or meter.
    Counter(CounterConfig),
    /// A pulse train output with its axis.
    Axis(AxisConfig),
    /// Pulse width modulation.
    Pwm(WaveConfig),
    /// A frequency generator.
    Generator(WaveConfig),
}
