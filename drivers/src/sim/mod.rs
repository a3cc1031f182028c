//! The simulated board: lines, wires, plants and faults in virtual time.

mod board;
mod checks;
mod line;
mod wire;

pub use board::{MAX_PENDING, SimulatedBoard};
pub use line::MAX_FAULTS;
