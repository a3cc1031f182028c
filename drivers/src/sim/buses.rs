//! The buses of a simulated board: CAN buses and serial lines, each in its own time.

use signal::{CanFrame, SerialOutput, SerialSettings, Span, Time};

use super::can::CanWires;
use super::serial::SerialLines;
use crate::circuit::{BusSpec, BusSpecKind};
use crate::{BoardError, Bus, BusEvent, BusId, BusKind, TimestampSource};

/// The buses of a simulated board.
#[derive(Clone, Debug, Default)]
pub struct SimulatedBuses {
    list: Vec<Bus>,
    can: CanWires,
    serial: SerialLines,
}

impl SimulatedBuses {
    /// The buses of a board.
    pub fn new(specs: &[BusSpec]) -> SimulatedBuses {
        let mut made = SimulatedBuses::default();
        for (place, spec) in specs.iter().enumerate() {
            let bus = BusId(place as u16);
            let kind = match spec.kind {
                BusSpecKind::Can(rates) => {
                    made.can.push(bus, rates, spec.joins);
                    BusKind::Can { bitrate: rates.bitrate, data_bitrate: rates.data_bitrate }
                }
                BusSpecKind::Serial(end) => {
                    made.serial.push(bus, end, spec.joins);
                    BusKind::Serial { settings: end.settings }
                }
            };
            let (name, timestamp) = (spec.name.clone(), TimestampSource::Virtual);
            made.list.push(Bus { name, kind, timestamp, resolution: Span::ZERO });
        }
        made
    }

    /// The buses.
    pub fn list(&self) -> &[Bus] {
        &self.list
    }

    /// Forgets what was before.
    pub fn start(&mut self) {
        self.can.start();
        self.serial.start();
    }

    /// Nothing more is sent; what is on a wire comes to its end.
    pub fn safe(&mut self, now: Time) {
        self.can.safe();
        self.serial.safe(now);
    }

    /// Puts a frame into the queue of a CAN bus.
    ///
    /// # Errors
    /// As [`CanWires::send`]; [`BoardError::BadFrame`] of a serial line.
    pub fn send(&mut self, now: Time, bus: BusId, frame: &CanFrame) -> Result<(), BoardError> {
        match self.kind(bus)? {
            BusKind::Can { .. } => self.can.send(now, bus, frame),
            BusKind::Serial { .. } => Err(BoardError::BadFrame(bus)),
        }
    }

    /// Sends on a serial line.
    ///
    /// # Errors
    /// As [`SerialLines::send`]; [`BoardError::BadFrame`] of a CAN bus.
    pub fn send_serial(&mut self, now: Time, bus: BusId, output: &SerialOutput) -> Result<(), BoardError> {
        match self.kind(bus)? {
            BusKind::Serial { .. } => self.serial.send(now, bus, output),
            BusKind::Can { .. } => Err(BoardError::BadFrame(bus)),
        }
    }

    /// Other settings of an end of a serial line.
    ///
    /// # Errors
    /// As [`SerialLines::configure`]; [`BoardError::BadSettings`] of a CAN bus.
    pub fn configure(
        &mut self,
        now: Time,
        bus: BusId,
        settings: &SerialSettings,
        message_gap: Span,
    ) -> Result<(), BoardError> {
        match self.kind(bus)? {
            BusKind::Serial { .. } => self.serial.configure(now, bus, settings, message_gap),
            BusKind::Can { .. } => Err(BoardError::BadSettings(bus)),
        }
    }

    /// Whoever sends on this bus lost its power.
    ///
    /// # Errors
    /// [`BoardError::NoBus`].
    pub fn break_off(&mut self, now: Time, bus: BusId) -> Result<(), BoardError> {
        match self.kind(bus)? {
            BusKind::Can { .. } => self.can.break_off(now, bus),
            BusKind::Serial { .. } => self.serial.break_off(now, bus),
        }
        Ok(())
    }

    fn kind(&self, bus: BusId) -> Result<BusKind, BoardError> {
        self.list.get(usize::from(bus.0)).map(|bus| bus.kind).ok_or(BoardError::NoBus(bus))
    }

    /// When there is something to report, as things stand.
    pub fn next_event(&self) -> Option<Time> {
        self.can.next_event().into_iter().chain(self.serial.next_event()).min()
    }

    /// Appends what happened up to `now`, in the order in which it became known; at one instant CAN buses come first.
    pub fn poll(&mut self, now: Time, out: &mut Vec<BusEvent>) {
        while let Some(next) = self.serial.next_event().filter(|next| *next <= now) {
            self.can.poll(next, out);
            self.serial.poll(next, out);
        }
        self.can.poll(now, out);
        self.serial.poll(now, out);
    }
}
