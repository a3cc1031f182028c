//! Modelled buses, as data.

use signal::{SerialSettings, Span};

use crate::bus::BusId;

/// A simulated bus as data.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BusSpec {
    /// Its name in the board file.
    pub name: String,
    /// What it is.
    pub kind: BusSpecKind,
    /// A bus of the same kind before it in the list whose wire it is on.
    pub joins: Option<BusId>,
}

/// What a simulated bus is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BusSpecKind {
    /// A node on a CAN bus.
    Can(CanRates),
    /// An end of a serial line.
    Serial(SerialEnd),
}

/// The speed of a simulated CAN bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CanRates {
    /// Bit rate of the arbitration and of classic frames, bit/s, above 0.
    pub bitrate: u32,
    /// Bit rate of the data of CAN FD frames; `None`: the bus takes classic frames only.
    pub data_bitrate: Option<u32>,
}

/// How the ends of a serial line are joined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SerialMedium {
    /// Two ends, both ways at once.
    Rs232,
    /// Any number of ends on one pair of wires.
    Rs485 {
        /// The end's receiver is on while it sends.
        hears_itself: bool,
    },
}

/// An end of a simulated serial line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SerialEnd {
    /// How it makes characters of bits.
    pub settings: SerialSettings,
    /// How it is joined to others.
    pub medium: SerialMedium,
    /// How long what it sends takes to the other ends, from 0.
    pub delay: Span,
    /// How long the line is at rest between two messages, above 0.
    pub message_gap: Span,
}
