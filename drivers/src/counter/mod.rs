//! Counters: devices that count pulses by themselves, faster than anything that looks at each edge.
//!
//! A [`Counter`] is what is behind a device of the kernel's counter subsystem. The board asks it on a thread of its own, so
//! a call that takes its time holds up nobody. What a device counts wraps at its ceiling; the [`Follower`] makes a count of
//! it that goes on.

mod board;
mod device;
mod driver;
mod find;
mod follow;
#[cfg(test)]
mod follow_tests;
mod handle;
mod kernel;
mod spec;

pub use board::{CounterBoard, CounterSource, describe};
pub use find::{CounterDevice, HardwareCount, find, list, look, named};
pub use follow::{CountStep, CounterReading, Follower, Way};
pub use kernel::{KernelCounter, shown};
pub(crate) use spec::EVENTS;
pub use spec::{CountSpec, CounterSpec, CountersSpec, FindCount, FindCounter};

use host::CounterEvent;
use std::fmt::Debug;
use std::io;

/// A counter that was opened for one of its counts.
pub trait Counter: Send + Debug {
    /// What it is, as messages name it.
    fn device(&self) -> &str;

    /// The highest number that the count shows: one more is 0.
    fn ceiling(&self) -> u64;

    /// A run begins: events that wait are from before.
    ///
    /// # Errors
    /// As [`Counter::read`].
    fn begin(&mut self) -> io::Result<()>;

    /// What the count shows. Does not allocate.
    ///
    /// # Errors
    /// The kernel's: `ENODEV` and `ENXIO` where the device is gone.
    fn read(&mut self) -> io::Result<CounterReading>;

    /// Appends the events that wait, oldest first. FALSE where some may have been lost. Does not allocate once `out` has
    /// grown.
    ///
    /// # Errors
    /// As [`Counter::read`].
    fn events(&mut self, out: &mut Vec<CounterEvent>) -> io::Result<bool>;
}
