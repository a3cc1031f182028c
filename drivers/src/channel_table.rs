//! The channels of a board file, as its devices need them.

use signal::{Span, Value};

use crate::channel::{Channel, FaultSet, TimestampSource};
use crate::circuit::ChannelSpec;

/// What a device has to know of the board file: its name, for messages, and its channels.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ChannelTable {
    /// Path of the file as the user gave it.
    pub file: String,
    /// The channels, by their numbers.
    pub channels: Vec<ChannelSpec>,
}

impl ChannelTable {
    /// The channels of a board that has no device.
    pub(crate) fn blank(&self) -> Vec<Channel> {
        let unknown = |channel: &ChannelSpec| Channel {
            name: channel.name.clone(),
            kind: channel.kind.clone(),
            drives: false,
            senses: channel.senses,
            timestamp: TimestampSource::Kernel,
            resolution: Span::ZERO,
            shortest_pulse: Span::MAX,
            deadband: 0.0,
            max_pulse_hz: 0,
            emits: None,
            counts_hz: None,
            faults: FaultSet::NONE,
            safe: Value::HighZ,
        };
        self.channels.iter().map(unknown).collect()
    }
}
