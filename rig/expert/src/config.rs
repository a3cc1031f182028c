//! What expert functions a controller has.

use crate::{AxisConfig, CounterConfig, WaveConfig};
use signal::Span;

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

/// What stands between the terminal of an input and the functions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct InputConditions {
    /// The input's own delay in each direction (io:STD-IN-02).
    pub delay: Span,
    /// Its anti-bounce filter (io:EIO-12, io:STD-IN-03).
    pub bounce: Span,
}
