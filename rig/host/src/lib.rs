//! The host: its clock, its waits, its threads. A thin safe layer over the kernel's calls that real lines need.
//!
//! Goals: one place for what is not portable; no call that allocates once it is set up; every failed call with its
//! name. Not goals: devices (`drivers`), what runs when (`runtime`).

mod background;
mod bell;
mod counter;
mod datagram;
mod descriptor;
mod histogram;
mod instant;
mod latency;
mod lock;
mod machine;
mod process;
mod refused;
mod serial;
mod stop;
mod thread;
mod time;
mod watchdog;

/// The longest path that the kernel takes for a socket, bytes.
pub const LONGEST_SOCKET_PATH: usize = 107;

pub use background::{Abandoned, BackgroundTask, TaskProgress};
pub use bell::{Bell, Woken};
pub use counter::{
    COUNTER_RECORD, CounterEvent, CounterEventKind, disable_counter_events, enable_counter_events,
    watch_count,
};
pub use datagram::{ReceivedDatagram, receive, stamp_arrivals};
pub use descriptor::duplicate;
pub use histogram::Histogram;
pub use instant::{AtomicInstant, HostInstant};
pub use latency::{Wakeups, wakeups};
pub use lock::lock_bytes;
pub use machine::{HostMachine, Preemption};
pub use process::{Punctual, ask_to_end, lock_memory};
pub use refused::{Privilege, Refused};
pub use rustix::io::Errno;
pub use serial::{
    LineCounters, Rs485, is_exclusive, line_counters, low_latency, rs485, set_low_latency, set_rs485,
    transmitter_is_empty,
};
pub use stop::{Unstoppable, stop_here};
pub use thread::{Entered, Processors, Realtime, ThreadRole, go_before_all};
pub use time::{Bracket, TimeBase, resolution};
pub use watchdog::{WatchdogDevice, never_stops};
