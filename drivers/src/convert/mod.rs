//! Converters: devices that measure voltages (or what their driver makes of them) at their inputs, now and then.
//!
//! A [`Converter`] is what is behind a device: one on an SPI bus that the rig reads itself, or one of the kernel's
//! industrial I/O. The board asks it on a thread of its own, so a reading that takes its time holds up nobody.

mod spec;

pub use spec::{ConverterKind, ConverterSpec, ConvertersSpec, FindInput, SampleSpec};

use signal::Span;
use std::fmt::Debug;
use std::io;
use std::os::fd::BorrowedFd;

/// What an input showed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// Place of the input among those that the converter was opened for.
    pub input: u16,
    /// Stamps of the monotonic clock, in ns, between which the input was sampled.
    pub before: i64,
    /// The later one.
    pub after: i64,
    /// The quantity at the input, in volts, or in the unit of its driver.
    pub value: f64,
    /// Whether the input was within what the converter can tell apart.
    pub range: InRange,
}

/// Where a reading lies in the range of its input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InRange {
    /// Within.
    Yes,
    /// At its lower end: the quantity may be less.
    Below,
    /// At its upper end: the quantity may be more.
    Above,
}

/// How readings come.
#[derive(Clone, Copy, Debug)]
pub enum Pace<'a> {
    /// When they are asked for, so often.
    Asked(Span),
    /// By themselves, about so often, when this descriptor can be read.
    Ready(BorrowedFd<'a>, Span),
}

/// A converter that was opened for some of its inputs.
pub trait Converter: Send + Debug {
    /// What it is, as messages name it.
    fn device(&self) -> &str;

    /// How its readings come.
    fn pace(&self) -> Pace<'_>;

    /// Appends what there is: one reading of each input where it is asked, all that wait where they come by themselves.
    /// Does not allocate once `out` has grown.
    ///
    /// # Errors
    /// The kernel's: `ENODEV` and `ENXIO` where the device is gone.
    fn read(&mut self, out: &mut Vec<Reading>) -> io::Result<()>;

    /// How many readings were lost on the way since it was opened, as far as the device tells.
    fn lost(&self) -> u64 {
        0
    }
}
