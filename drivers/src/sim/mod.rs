//! The simulated board: lines, wires, plants and faults in virtual time.

mod board;
mod buses;
mod can;
mod can_bits;
mod checks;
mod dirty;
mod line;
mod links;
mod serial;
mod tally;
mod timetable;
mod wire;

pub use board::{MAX_PENDING, SimulatedBoard};
pub use can::MAX_QUEUED;
pub use line::MAX_FAULTS;
pub use serial::MAX_SERIAL_QUEUED;
