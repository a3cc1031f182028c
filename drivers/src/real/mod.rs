//! Boards of this machine's devices: one board of all the devices that a board file names.

mod board;
mod outline;
mod spec;

pub use board::{RealBoard, open};
pub use outline::Outline;
pub(crate) use outline::{blank, channels};
pub use spec::{RealSpec, SILENT_AFTER};
