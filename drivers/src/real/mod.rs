//! Boards of this machine's devices: one board of all the devices that a board file names.

mod board;
mod look;
mod offline;
mod relays;
mod spec;
mod uses;
mod wire;

pub(crate) use board::sort;
pub use board::{RealBoard, open};
pub use look::{Look, look};
pub use offline::OfflineBoard;
pub(crate) use offline::{blank, channels};
pub use relays::FaultRelays;
pub use spec::{RealSpec, UNRESPONSIVE_AFTER};
pub use uses::{Used, uses};
pub use wire::{FaultWay, SETTLE, WireRelays};
