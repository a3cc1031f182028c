//! Serial lines: RS-485 and RS-232 ports of the kernel.
//!
//! [`SerialPort`] is the port, on a current-thread tokio runtime, so that waits for bytes, for room and for a timer are one;
//! [`SerialBoard`] holds the ports of a board for a run and reports when one goes away.

mod assembler;
mod board;
mod device;
mod driver;
mod error;
mod find;
mod handle;
mod marks;
mod open;
mod port;
mod spec;
mod timer;

pub use assembler::{MessageAssembler, MessageTiming, ReceivedMessage};
pub use board::SerialBoard;
pub use error::{SerialCall, SerialError};
pub use find::Identity;
pub use marks::{Marks, Symbol};
pub(crate) use open::refused;
pub use open::{OpenError, UnsupportedSetting};
pub use port::{Received, Sending, SerialPort};
pub use spec::{PortSpec, SerialLinesSpec, SerialSpec};

use crate::{Bus, BusKind, TimestampSource};

/// Describes the serial lines among the buses of a board.
pub(crate) fn describe(lines: &[SerialSpec], buses: &mut Vec<Bus>) {
    for line in lines {
        let at = usize::from(line.bus.0);
        if buses.len() <= at {
            buses.resize(at + 1, Bus::none());
        }
        let character = line.port.line.lasts(1);
        buses[at] = Bus {
            name: line.name.clone(),
            kind: BusKind::Serial { settings: line.port.line },
            // The kernel does not stamp bytes: they are there when they are read.
            timestamp: TimestampSource::Sampled { period: character },
            resolution: character,
        };
    }
}
