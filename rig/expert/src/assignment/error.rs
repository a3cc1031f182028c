//! Why functions cannot be configured so.

use super::ChannelRole;
use crate::{AxisParameterError, CounterFault};
use profile::IoChannel;
use signal::Span;
use std::fmt;

/// One thing in a configuration that no controller of the profile accepts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ExpertError {
    /// The function, by its place.
    pub function: usize,
    /// What of it, where it is about one of its inputs or outputs.
    pub role: Option<ChannelRole>,
    /// What is wrong with it.
    pub fault: ExpertFault,
}

/// What is wrong with a function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExpertFault {
    /// The name is none that a program can write (io:EXP-06).
    Name,
    /// The function at this place has the same name (io:EXP-06).
    SameName(usize),
    /// The reference has no embedded inputs and outputs (io:REF-08).
    NoEmbedded,
    /// More main counters, meters, PTO, PWM and frequency generators than can be (io:EXP-08).
    Shared {
        /// So many are possible, together.
        most: usize,
    },
    /// More PTO than the profile has.
    Axes {
        /// So many are possible.
        most: usize,
    },
    /// A parameter of a counter that cannot be.
    Counter(CounterFault),
    /// A parameter of an axis that cannot be.
    Axis(AxisParameterError),
    /// A main counter takes more inputs than it can have (io:EXP-01).
    Inputs {
        /// Those of the configuration.
        found: usize,
        /// So many are possible.
        most: usize,
    },
    /// Counters of the profile have no such capture input (io:STD-ASG-01).
    Capture,
    /// The reference has no such input or output.
    Missing(IoChannel),
    /// No expert function can use it (io:EXP-02, io:EXP-09, io:STD-ASG-01).
    Unusable(IoChannel),
    /// A relay, or an output of a relay reference that is no fast one: it makes no pulses (io:EXP-04).
    Pulses(IoChannel),
    /// Another role has it, of the function at this place (io:EXP-10).
    Assigned {
        /// The input or output.
        channel: IoChannel,
        /// The other function, by its place.
        function: usize,
        /// What it is there.
        role: ChannelRole,
    },
    /// It is the Run/Stop input (io:RS-06).
    RunStop(IoChannel),
    /// It has Latch or Event (io:EIO-12).
    Advanced(IoChannel),
    /// It is the alarm output (io:OUT-05).
    Alarm(IoChannel),
}

impl fmt::Display for ExpertError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.role {
            Some(role) => write!(f, "{role}: {}", self.fault),
            None => write!(f, "{}", self.fault),
        }
    }
}

impl std::error::Error for ExpertError {}

impl fmt::Display for ExpertFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ExpertFault::Name => f.write_str(
                "a name has letters, digits and single underscores, begins with no digit and is not None",
            ),
            ExpertFault::SameName(_) => f.write_str("another function has this name"),
            ExpertFault::NoEmbedded => {
                f.write_str("the reference has no embedded inputs and outputs, so no expert functions")
            }
            ExpertFault::Shared { most } => write!(
                f,
                "main counters, meters, PTO, PWM and frequency generators are {most} in all: only HSC Simple can be added"
            ),
            ExpertFault::Axes { most } => write!(f, "the profile has {most} PTO"),
            ExpertFault::Counter(fault) => write!(f, "{fault}"),
            ExpertFault::Axis(fault) => write!(f, "{fault}"),
            ExpertFault::Inputs { found, most } => {
                write!(f, "{found} inputs, a main counter has {most} at most")
            }
            ExpertFault::Capture => f.write_str("counters of the profile have one capture input"),
            ExpertFault::Missing(channel) => write!(f, "the reference has no {channel}"),
            ExpertFault::Unusable(channel) => write!(f, "no expert function can use {channel}"),
            ExpertFault::Pulses(channel) => {
                write!(f, "{channel} makes no pulses: of a reference with relays only the fast outputs do")
            }
            ExpertFault::Assigned { channel, role, .. } => write!(f, "{channel} is {role} already"),
            ExpertFault::RunStop(channel) => write!(f, "{channel} is the Run/Stop input"),
            ExpertFault::Advanced(channel) => write!(f, "{channel} has Latch or Event"),
            ExpertFault::Alarm(channel) => write!(f, "{channel} is the alarm output"),
        }
    }
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
