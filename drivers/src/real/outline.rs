//! A board of real devices on paper.

use super::{RealSpec, WireRelays, wire};
use crate::circuit::ChannelSpec;
use crate::file::BoardFile;
use crate::{
    Board, BoardError, BoardEvent, Bus, Channel, ChannelId, Fault, FaultSet, Health, TimestampSource,
};
use crate::{can, convert, counter, emit, gpio, serial};
use signal::{Span, Time, Value};

/// The channels and buses of real devices that nobody opened: what a plan is checked against on any machine. It never starts.
#[derive(Clone, Debug)]
pub struct Outline {
    channels: Vec<Channel>,
    buses: Vec<Bus>,
    relays: Vec<WireRelays>,
}

impl Outline {
    /// The outline of a file's board.
    pub fn new(file: &BoardFile, spec: &RealSpec) -> Outline {
        Outline { channels: channels(file, spec), buses: buses(spec), relays: spec.relays.clone() }
    }
}

/// The channels of a board of real devices, before anything is known of the devices.
pub(crate) fn channels(file: &BoardFile, spec: &RealSpec) -> Vec<Channel> {
    let mut channels = blank(file);
    gpio::describe(file, &spec.gpio, &mut channels);
    convert::describe(file, &spec.converters, &mut channels);
    counter::describe(file, spec, Span::ZERO, &mut channels);
    emit::describe(file, &spec.generators, &mut channels);
    wire::describe(&spec.relays, &mut channels);
    channels
}

/// The buses of a board of real devices, before anything is known of the devices.
pub(crate) fn buses(spec: &RealSpec) -> Vec<Bus> {
    let mut buses = Vec::new();
    can::describe(&spec.can, &mut buses);
    serial::describe(&spec.serial, &mut buses);
    buses
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
        deadband: 0.0,
        max_pulse_hz: 0,
        emits: None,
        counts_hz: None,
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

    fn settle(&self, channel: ChannelId) -> Span {
        wire::settle(&self.relays, channel)
    }

    fn safe(&mut self, _now: Time) -> Result<(), BoardError> {
        Ok(())
    }

    fn health(&self) -> Health {
        Health::default()
    }

    fn buses(&self) -> &[Bus] {
        &self.buses
    }
}
