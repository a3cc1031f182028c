//! A board of real devices on paper.

use super::RealSpec;
use crate::circuit::ChannelSpec;
use crate::file::BoardFile;
use crate::gpio;
use crate::{Board, BoardError, BoardEvent, Channel, ChannelId, Fault, FaultSet, Health, TimestampSource};
use signal::{Span, Time, Value};

/// The channels of real devices that nobody opened: what a plan is checked against on any machine. It never starts.
#[derive(Clone, Debug)]
pub struct Outline {
    channels: Vec<Channel>,
}

impl Outline {
    /// The outline of a file's board.
    pub fn new(file: &BoardFile, spec: &RealSpec) -> Outline {
        Outline { channels: channels(file, spec) }
    }
}

/// The channels of a board of real devices, before anything is known of the devices.
pub(crate) fn channels(file: &BoardFile, spec: &RealSpec) -> Vec<Channel> {
    let mut channels = blank(file);
    gpio::describe(file, &spec.gpio, &mut channels);
    channels
}

/// The channels of a board that has no device.
pub(crate) fn blank(file: &BoardFile) -> Vec<Channel> {
    let unknown = |channel: &ChannelSpec| Channel {
        name: channel.name.clone(),
        kind: channel.kind.clone(),
        drives: false,
        senses: channel.senses,
        timestamp: TimestampSource::Kernel,
        resolution: Span::ZERO,
        shortest_pulse: Span::MAX,
        max_pulse_hz: 0,
        faults: FaultSet::NONE,
        safe: Value::HighZ,
    };
    file.circuit.channels.iter().map(unknown).collect()
}

impl Board for Outline {
    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    fn start(&mut self, _now: Time) -> Result<(), BoardError> {
        Err(BoardError::NotStarted)
    }

    fn write(&mut self, _now: Time, _writes: &[(ChannelId, Value)]) -> Result<(), BoardError> {
        Err(BoardError::NotStarted)
    }

    fn poll(&mut self, _now: Time, _out: &mut Vec<BoardEvent>) -> Result<(), BoardError> {
        Err(BoardError::NotStarted)
    }

    fn next_event(&self) -> Option<Time> {
        None
    }

    fn inject(&mut self, _now: Time, fault: Fault) -> Result<(), BoardError> {
        Err(BoardError::NoSuchFault(fault.channel))
    }

    fn clear(&mut self, _now: Time, _channel: ChannelId) -> Result<(), BoardError> {
        Ok(())
    }

    fn safe(&mut self, _now: Time) -> Result<(), BoardError> {
        Ok(())
    }

    fn health(&self) -> Health {
        Health::default()
    }
}
