//! The guard: a small process of its own that holds the output lines too, and makes them safe when the rig cannot.
//!
//! The rig starts it before anything else ([`Guard::spawn`]), hands it the claims on its output lines
//! ([`GuardHandle::hold`]), arms it for each case, and gives a sign of life now and then ([`GuardHandle::beat`]).
//! When the rig dies, or gives no sign of life within the limit, the guard latches, kills the rig so that nothing
//! late can be written, drives every line to its safe level through its own descriptors, reads it back, and drives
//! it again until the rig's process is gone. A watchdog can stand behind it.
//!
//! Goals: it needs nothing of the rig but its death; no call on a line keeps it from another; nothing is allocated
//! while it is armed. Not goals: what is safe (the board file), when a run is over (`runtime`).
//!
//! What it cannot do: call back a write that is already inside the kernel. It drives after it.

mod driver;
mod error;
mod handle;
mod lines;
mod page;
mod reason;
mod serve;
mod setup;
mod takeover;
mod watch;
mod wire;

pub use drivers::{Bite, GuardSettings, WatchdogSettings};
pub use error::{CODES, GuardError};
pub use handle::{Guard, GuardHandle, HeartbeatState};
pub use lines::{KernelLines, OutputLines};
pub use reason::Reason;
pub use serve::{serve, serve_with};
pub use setup::MissingPrivileges;
pub use takeover::take_over;
