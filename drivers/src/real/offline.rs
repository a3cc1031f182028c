//! A board of real devices that nobody opened.

use super::{RealSpec, WireRelays, wire};
use crate::channel_table::ChannelTable;
use crate::{
    Board, BoardError, BoardEvent, Bus, BusEvent, BusId, Buses, Channel, ChannelId, Fault, FaultInjection,
    Health,
};
use signal::{CanFrame, SerialOutput, SerialSettings, Span, Time, Value, When};

/// The channels and buses of real devices that nobody opened: what a plan is checked against on any machine. It never starts.
/// The default one has none.
#[derive(Clone, Debug, Default)]
pub struct OfflineBoard {
    channels: Vec<Channel>,
    buses: Vec<Bus>,
    relays: Vec<WireRelays>,
}

impl OfflineBoard {
    /// The offline board of a file's board.
    pub fn new(table: &ChannelTable, spec: &RealSpec) -> OfflineBoard {
        OfflineBoard { channels: channels(table, spec), buses: buses(spec), relays: spec.relays.clone() }
    }
}

/// The channels of a board of real devices, before anything is known of the devices.
pub(crate) fn channels(table: &ChannelTable, spec: &RealSpec) -> Vec<Channel> {
    let mut channels = table.blank();
    spec.devices.iter().for_each(|devices| devices.describe(table, spec.limits, &mut channels));
    wire::describe(&spec.relays, &mut channels);
    channels
}

/// The buses of a board of real devices, before anything is known of the devices.
pub(crate) fn buses(spec: &RealSpec) -> Vec<Bus> {
    let mut buses = Vec::new();
    spec.devices.iter().for_each(|devices| devices.describe_buses(&mut buses));
    buses
}

impl Board for OfflineBoard {
    fn inner(&self) -> Option<&dyn Board> {
        None
    }

    fn inner_mut(&mut self) -> Option<&mut dyn Board> {
        None
    }

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

    fn safe(&mut self, _now: Time) -> Result<(), BoardError> {
        Ok(())
    }

    fn health(&self) -> Health {
        Health::default()
    }

    fn buses(&self) -> Option<&dyn Buses> {
        Some(self)
    }

    fn buses_mut(&mut self) -> Option<&mut dyn Buses> {
        Some(self)
    }

    fn faults(&self) -> Option<&dyn FaultInjection> {
        Some(self)
    }

    fn faults_mut(&mut self) -> Option<&mut dyn FaultInjection> {
        Some(self)
    }
}

impl FaultInjection for OfflineBoard {
    fn inject(&mut self, _now: Time, fault: Fault) -> Result<(), BoardError> {
        Err(BoardError::NoSuchFault(fault.channel))
    }

    fn clear_faults(&mut self, _now: Time, _channel: ChannelId) -> Result<(), BoardError> {
        Ok(())
    }

    fn fault_switching_time(&self, channel: ChannelId) -> Span {
        wire::settle(&self.relays, channel)
    }

    fn fault_settled_at(&self, _channel: ChannelId) -> Option<When> {
        None
    }
}

impl Buses for OfflineBoard {
    fn bus_list(&self) -> &[Bus] {
        &self.buses
    }

    fn bus_device(&self, _bus: BusId) -> Option<&str> {
        None
    }

    fn send(&mut self, _now: Time, _bus: BusId, _frame: &CanFrame) -> Result<(), BoardError> {
        Err(BoardError::NotStarted)
    }

    fn send_serial(&mut self, _now: Time, _bus: BusId, _output: &SerialOutput) -> Result<(), BoardError> {
        Err(BoardError::NotStarted)
    }

    fn configure(
        &mut self,
        _now: Time,
        _bus: BusId,
        _settings: &SerialSettings,
        _message_gap: Span,
    ) -> Result<(), BoardError> {
        Err(BoardError::NotStarted)
    }

    fn break_off(&mut self, _now: Time, _bus: BusId) -> Result<(), BoardError> {
        Err(BoardError::NotStarted)
    }

    fn poll_buses(&mut self, _now: Time, _out: &mut Vec<BusEvent>) -> Result<(), BoardError> {
        Err(BoardError::NotStarted)
    }
}
