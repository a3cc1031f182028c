//! A GPIO board on paper.

use super::{Direction, GpioSpec, LineSpec};
use crate::circuit::ChannelSpec;
use crate::file::BoardFile;
use crate::{Board, BoardError, BoardEvent, Channel, ChannelId, Fault, FaultSet, Health, TimestampSource};
use signal::{Span, Time, Value};

/// The channels of a GPIO board that nobody opened: what a plan is checked against on any machine. It never starts.
#[derive(Clone, Debug)]
pub struct Outline {
    channels: Vec<Channel>,
}

impl Outline {
    /// The outline of a file's board.
    pub fn new(file: &BoardFile, spec: &GpioSpec) -> Outline {
        Outline { channels: channels(file, spec) }
    }
}

/// The channels of a GPIO board, before anything is known of its chips.
pub(super) fn channels(file: &BoardFile, spec: &GpioSpec) -> Vec<Channel> {
    let both = file.circuit.channels.iter().zip(&spec.lines);
    both.map(|(channel, line)| described(channel, line)).collect()
}

fn described(channel: &ChannelSpec, line: &LineSpec) -> Channel {
    let debounce = Span::from_micros(i64::from(line.debounce_us));
    let sensed = line.direction == Direction::Input || line.readback.is_some();
    Channel {
        name: channel.name.clone(),
        kind: channel.kind.clone(),
        drives: channel.drives,
        senses: channel.senses,
        timestamp: TimestampSource::Kernel,
        resolution: Span::ZERO,
        // What a debounced line keeps is long enough to be seen. Of others nobody can tell: a pulse may be over before
        // the kernel looks.
        shortest_pulse: if sensed && debounce > Span::ZERO { debounce } else { Span::MAX },
        max_pulse_hz: 0,
        faults: FaultSet::NONE,
        safe: if line.direction == Direction::Output { Value::Bool(line.safe) } else { Value::HighZ },
    }
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
