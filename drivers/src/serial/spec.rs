//! What a board file says of serial lines.

use std::ops::Range;
use std::path::PathBuf;

use host::Rs485;
use signal::{SerialSettings, Span};

use crate::BusId;

/// The serial lines of a board.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SerialLinesSpec {
    /// The lines, in the order of their numbers among the buses.
    pub lines: Vec<SerialSpec>,
}

/// A serial line of the board.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SerialSpec {
    /// Its place among the buses of the board.
    pub bus: BusId,
    /// Its name in the board file.
    pub name: String,
    /// How its port is set up.
    pub port: PortSpec,
    /// How long the line is at rest between two messages, above 0.
    pub message_gap: Span,
    /// Where the file says so.
    pub place: Range<usize>,
}

/// A port, and how it is set up.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PortSpec {
    /// Its device, or a link to it.
    pub path: PathBuf,
    /// How bytes are made of bits.
    pub line: SerialSettings,
    /// How the kernel drives the direction of a transceiver; `None` leaves it as it is.
    pub rs485: Option<Rs485>,
    /// Whether each byte is handed on at once; `None` leaves it as it is.
    pub low_latency: Option<bool>,
    /// Nobody else may use it meanwhile.
    pub exclusive: bool,
}
