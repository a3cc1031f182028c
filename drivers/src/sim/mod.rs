//! The simulated board: lines, wires, plants and faults in virtual time.

mod board;
mod bus;
mod checks;
mod line;
mod links;
mod tally;
mod wire;
mod wire_time;

pub use board::{MAX_PENDING, SimulatedBoard};
pub use bus::MAX_QUEUED;
pub use line::MAX_FAULTS;
