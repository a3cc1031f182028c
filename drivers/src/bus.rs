//! Communication lines of a board: CAN buses and serial lines, what passes on them, and how they fare.

use signal::{BusError, BusState, CanFrame, SerialMessage, SerialSettings, Span, Time, When};

use crate::{LossReason, TimestampSource};

/// The place of a bus in [`crate::Buses::bus_list`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct BusId(pub u16);

/// What kind of line it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum BusKind {
    /// CAN, with these bit rates in bit/s.
    Can {
        /// Of arbitration, and of everything on classic CAN.
        bitrate: u32,
        /// Of the data of a frame with bit-rate switch; `None` for classic CAN.
        data_bitrate: Option<u32>,
    },
    /// A serial line.
    Serial {
        /// Its speed and how it carries bytes, as the board file has it.
        settings: SerialSettings,
    },
}

/// A bus of a board.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Bus {
    /// Its name in the board file.
    pub name: String,
    /// What it is.
    pub kind: BusKind,
    /// Where the instants of its frames come from.
    pub timestamp: TimestampSource,
    /// Width of the interval in which a frame is stamped (0 = exact).
    pub resolution: Span,
}

impl Bus {
    /// The place of a bus of which nothing is known here: it has no name.
    pub(crate) fn none() -> Bus {
        let kind = BusKind::Serial { settings: SerialSettings { baud: 0, ..SerialSettings::default() } };
        Bus { name: String::new(), kind, timestamp: TimestampSource::Virtual, resolution: Span::ZERO }
    }
}

/// What a bus has to report.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(clippy::large_enum_variant, reason = "copied between queues that never allocate")]
pub enum BusEvent {
    /// A frame was on the bus.
    CanFrame {
        /// Which bus.
        bus: BusId,
        /// When its end was seen.
        at: When,
        /// The frame.
        frame: CanFrame,
        /// It was sent by [`crate::Buses::send`], and is on the bus now.
        own: bool,
    },
    /// Characters were on a serial line: a message, or a part of one.
    SerialMessage {
        /// Which line.
        bus: BusId,
        /// The characters, and when they came.
        message: SerialMessage,
        /// They were sent by [`crate::Buses::send_serial`], and are over now.
        own: bool,
    },
    /// The controller takes part in another way from now on.
    State {
        /// Which bus.
        bus: BusId,
        /// When it was noticed.
        at: Time,
        /// How it takes part.
        state: BusState,
    },
    /// Something went wrong on the bus.
    Error {
        /// Which bus.
        bus: BusId,
        /// When it was noticed.
        at: Time,
        /// What.
        error: BusError,
    },
    /// Frames were lost on their way to the rig: no verdict that rests on this bus around `at` holds.
    Dropped {
        /// Which bus.
        bus: BusId,
        /// When the loss was noticed.
        at: Time,
        /// How many, at least.
        count: u32,
    },
    /// The device is gone.
    Lost {
        /// Which bus.
        bus: BusId,
        /// When it was noticed.
        at: Time,
        /// Why.
        reason: LossReason,
    },
    /// The device is back.
    Returned {
        /// Which bus.
        bus: BusId,
        /// When it was noticed.
        at: Time,
    },
}

impl BusEvent {
    /// The bus that it concerns.
    pub fn bus(&self) -> BusId {
        match *self {
            BusEvent::CanFrame { bus, .. }
            | BusEvent::SerialMessage { bus, .. }
            | BusEvent::State { bus, .. }
            | BusEvent::Error { bus, .. }
            | BusEvent::Dropped { bus, .. }
            | BusEvent::Lost { bus, .. }
            | BusEvent::Returned { bus, .. } => bus,
        }
    }

    /// The latest instant at which it can have happened: what a poll orders by.
    pub fn latest(&self) -> Time {
        match *self {
            BusEvent::CanFrame { at, .. } => at.latest,
            BusEvent::SerialMessage { message, .. } => message.last.latest,
            BusEvent::State { at, .. }
            | BusEvent::Error { at, .. }
            | BusEvent::Dropped { at, .. }
            | BusEvent::Lost { at, .. }
            | BusEvent::Returned { at, .. } => at,
        }
    }
}
