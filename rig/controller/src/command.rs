//! What can be commanded, and why it is refused.

use crate::{LoadError, State};
use profile::Reference;
use signal::{Address, Area, Size};
use std::fmt;

/// A command of a user or a tool.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Command {
    /// Start the application (controller:RUN-01).
    Run,
    /// Stop the application (controller:STP-01). Cycles under way are finished first; no new one starts.
    Stop,
    /// Reset warm (controller:RW-01).
    ResetWarm,
    /// Reset cold (controller:RC-01).
    ResetCold,
    /// Load an application and make it the boot application (controller:DL-02).
    Download(Vec<u8>),
    /// Force the value of an embedded input or output (controller:FRC-01).
    Force {
        /// What is forced.
        channel: Channel,
        /// Its value.
        on: bool,
    },
    /// End the forcing of an embedded input or output.
    Unforce(Channel),
    /// Move the Run/Stop switch: TRUE to Run (controller:RS-01).
    Switch(bool),
}

/// An embedded input or output.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Channel {
    /// In, from I0.
    Input(usize),
    /// Qn, from Q0.
    Output(usize),
}

impl Channel {
    /// The channel behind a bit of %I or %Q; none where the reference has no channel there.
    pub fn at(address: Address, reference: &Reference) -> Option<Channel> {
        let bit = address.bit_offset() as usize;
        match (address.area(), address.size()) {
            (Area::Input, Size::Bit) if bit < reference.input_count() => Some(Channel::Input(bit)),
            (Area::Output, Size::Bit) if bit < reference.output_count() => Some(Channel::Output(bit)),
            _ => None,
        }
    }
}

/// Why a command was not obeyed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// Not possible in this state (controller:TR-24, controller:TR-28, controller:WD-14).
    State(State),
    /// The Run/Stop switch is at Stop.
    SwitchAtStop,
    /// A stop is under way: a cycle is being finished.
    Stopping,
    /// The reference has no such channel.
    NoChannel(Channel),
    /// The downloaded application is not valid. The old one is already erased: the state is EMPTY
    /// (controller:DL-04).
    Application(LoadError),
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Refusal::State(state) => write!(f, "not possible in state {state}"),
            Refusal::SwitchAtStop => f.write_str("the Run/Stop switch is at Stop"),
            Refusal::Stopping => f.write_str("a stop is under way"),
            Refusal::NoChannel(Channel::Input(n)) => write!(f, "the reference has no input I{n}"),
            Refusal::NoChannel(Channel::Output(n)) => write!(f, "the reference has no output Q{n}"),
            Refusal::Application(error) => write!(f, "the application is not valid: {error}"),
        }
    }
}

impl std::error::Error for Refusal {}

/// Why a value was not written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WriteError {
    /// No service answers in this state, or there is no application.
    State(State),
    /// The probe can only be read.
    ReadOnly,
    /// The value is no number.
    NotANumber,
}

impl fmt::Display for WriteError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            WriteError::State(state) => write!(f, "cannot be written in state {state}"),
            WriteError::ReadOnly => f.write_str("can only be read: write a variable or a %M, %Q or %I address"),
            WriteError::NotANumber => f.write_str("the value is no number"),
        }
    }
}

impl std::error::Error for WriteError {}
