//! Communication lines of a board: CAN buses and serial lines, what passes on them, and how they fare.

use signal::{Span, Time, When};

use crate::{LossReason, TimestampSource};

/// The place of a bus in [`crate::Board::buses`].
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
    /// A serial line, with its speed in Bd.
    Serial {
        /// Symbols a second.
        baud: u32,
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
        let kind = BusKind::Serial { baud: 0 };
        Bus { name: String::new(), kind, timestamp: TimestampSource::Virtual, resolution: Span::ZERO }
    }
}

/// The most data bytes of a CAN frame: 8 on classic CAN, 64 with CAN FD (ISO 11898-1).
pub const MAX_DATA: usize = 64;

/// A CAN frame.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct Frame {
    /// Identifier: 11 bits, or 29 of an extended one.
    pub id: u32,
    /// The identifier has 29 bits.
    pub extended: bool,
    /// A remote frame: it asks for data and has none. Never with `fd`.
    pub remote: bool,
    /// A CAN FD frame.
    pub fd: bool,
    /// Its data came at the data bit rate (CAN FD).
    pub brs: bool,
    /// Its sender is error-passive (CAN FD).
    pub esi: bool,
    /// Number of data bytes; of a remote frame the number that is asked for.
    pub len: u8,
    /// The data; 0 behind `len`.
    pub data: [u8; MAX_DATA],
}

impl Frame {
    /// A classic data frame. `None` where the identifier does not fit, or the data have more than 8 bytes.
    pub fn classic(id: u32, extended: bool, data: &[u8]) -> Option<Frame> {
        let most = if extended { 0x1FFF_FFFF } else { 0x7FF };
        if id > most || data.len() > 8 {
            return None;
        }
        let mut bytes = [0; MAX_DATA];
        bytes[..data.len()].copy_from_slice(data);
        let len = data.len() as u8;
        Some(Frame { id, extended, remote: false, fd: false, brs: false, esi: false, len, data: bytes })
    }

    /// Its data.
    pub fn data(&self) -> &[u8] {
        let len = if self.remote { 0 } else { usize::from(self.len).min(MAX_DATA) };
        &self.data[..len]
    }
}

impl std::fmt::Debug for Frame {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let width = if self.extended { 8 } else { 3 };
        write!(f, "{:0width$X}#", self.id)?;
        if self.remote {
            return write!(f, "R{}", self.len);
        }
        if self.fd {
            write!(f, "#{:X}", u8::from(self.brs) | u8::from(self.esi) << 1)?;
        }
        self.data().iter().try_for_each(|byte| write!(f, "{byte:02X}"))
    }
}

/// How a CAN controller takes part in its bus (ISO 11898-1, fault confinement).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum BusState {
    /// As it should.
    ErrorActive,
    /// One of its error counters has reached 96.
    ErrorWarning,
    /// One of its error counters has reached 128.
    ErrorPassive,
    /// It takes no part any more.
    BusOff,
    /// It is switched off, or its cable is gone.
    Stopped,
}

/// What went wrong on a CAN bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum BusError {
    /// Nobody acknowledged a frame.
    NoAck,
    /// Another node won the arbitration; the bit at which it was lost, where it is known.
    LostArbitration(Option<u8>),
    /// A bit, stuff, form or CRC error.
    Protocol,
    /// The controller lost frames that it had received.
    ReceiveOverflow,
    /// The controller lost frames that it was to send.
    SendOverflow,
    /// A frame was not sent in time.
    SendTimeout,
    /// The transceiver reports a fault.
    Transceiver,
    /// Anything else that the controller reports.
    Other,
}

/// What a bus has to tell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BusEvent {
    /// A frame was on the bus.
    Frame {
        /// Which bus.
        bus: BusId,
        /// When its end was seen.
        at: When,
        /// The frame.
        frame: Frame,
        /// It was sent by [`crate::Board::send`], and is on the bus now.
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
            BusEvent::Frame { bus, .. }
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
            BusEvent::Frame { at, .. } => at.latest,
            BusEvent::State { at, .. }
            | BusEvent::Error { at, .. }
            | BusEvent::Dropped { at, .. }
            | BusEvent::Lost { at, .. }
            | BusEvent::Returned { at, .. } => at,
        }
    }
}
