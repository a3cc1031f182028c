//! Why functions cannot be configured so.

use super::ChannelRole;
use crate::{AxisParameterError, CounterFault};
use profile::IoChannel;
use signal::Span;
use std::fmt;
use thiserror::Error;

/// One thing in a configuration that no controller of the profile accepts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("{}{fault}", .role.map_or_else(String::new, |role| format!("{role}: ")))]
pub struct ExpertError {
    /// The function, by its place.
    pub function: usize,
    /// What of it, where it is about one of its inputs or outputs.
    pub role: Option<ChannelRole>,
    /// What is wrong with it.
    #[source]
    pub fault: ExpertFault,
}

/// What is wrong with a function.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum ExpertFault {
    /// The name is none that a program can write (io:EXP-06).
    #[error("a name has letters, digits and single underscores, begins with no digit and is not None")]
    Name,
    /// The function at this place has the same name (io:EXP-06).
    #[error("another function has this name")]
    SameName(usize),
    /// The reference has no embedded inputs and outputs (io:REF-08).
    #[error("the reference has no embedded inputs and outputs, so no expert functions")]
    NoEmbedded,
    /// More main counters, meters, PTO, PWM and frequency generators than can be (io:EXP-08).
    #[error(
        "main counters, meters, PTO, PWM and frequency generators are {most} in all: only HSC Simple can be added"
    )]
    Shared {
        /// So many are possible, together.
        most: usize,
    },
    /// More PTO than the profile has.
    #[error("the profile has {most} PTO")]
    Axes {
        /// So many are possible.
        most: usize,
    },
    /// A parameter of a counter that cannot be.
    #[error(transparent)]
    Counter(CounterFault),
    /// A parameter of an axis that cannot be.
    #[error(transparent)]
    Axis(AxisParameterError),
    /// A main counter takes more inputs than it can have (io:EXP-01).
    #[error("{found} inputs, a main counter has {most} at most")]
    Inputs {
        /// Those of the configuration.
        found: usize,
        /// So many are possible.
        most: usize,
    },
    /// Counters of the profile have no such capture input (io:STD-ASG-01).
    #[error("counters of the profile have one capture input")]
    Capture,
    /// The reference has no such input or output.
    #[error("the reference has no {0}")]
    Missing(IoChannel),
    /// No expert function can use it (io:EXP-02, io:EXP-09, io:STD-ASG-01).
    #[error("no expert function can use {0}")]
    Unusable(IoChannel),
    /// A relay, or an output of a relay reference that is no fast one: it makes no pulses (io:EXP-04).
    #[error("{0} makes no pulses: of a reference with relays only the fast outputs do")]
    Pulses(IoChannel),
    /// Another role has it, of the function at this place (io:EXP-10).
    #[error("{channel} is {role} already")]
    Assigned {
        /// The input or output.
        channel: IoChannel,
        /// The other function, by its place.
        function: usize,
        /// What it is there.
        role: ChannelRole,
    },
    /// It is the Run/Stop input (io:RS-06).
    #[error("{0} is the Run/Stop input")]
    RunStop(IoChannel),
    /// It has Latch or Event (io:EIO-12).
    #[error("{0} has Latch or Event")]
    Advanced(IoChannel),
    /// It is the alarm output (io:OUT-05).
    #[error("{0} is the alarm output")]
    Alarm(IoChannel),
}

/// A counter that cannot count as fast as it is meant to: its bounce time suppresses the pulses (io:STD-IN-05).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ExpertWarning {
    /// The function, by its place.
    pub function: usize,
    /// Which input.
    pub role: ChannelRole,
    /// Bounce time of that input.
    pub bounce: Span,
    /// The frequency that is expected, in hertz.
    pub expected: u32,
    /// The highest frequency at a duty of 50 % that passes, in hertz.
    pub most: u32,
}

impl fmt::Display for ExpertWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ExpertWarning { role, bounce, expected, most, .. } = self;
        write!(f, "{role}: a bounce time of {bounce} lets {most} Hz pass at most, not {expected} Hz")
    }
}
