//! Boards of this machine's devices: one board of all the devices that a board file names.

mod board;
mod look;
mod offline;
mod relays;
mod spec;
mod uses;
mod wire;

pub use board::{RealBoard, open};
pub use look::{Look, look};
pub use offline::OfflineBoard;
pub(crate) use offline::channels;
pub use relays::FaultRelays;
pub use spec::{DeviceSpec, RealSpec};
pub use uses::{Used, uses};
pub use wire::{FaultWay, SETTLE, WireRelays};
