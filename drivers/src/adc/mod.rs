//! Converters: devices that measure voltages (or what their driver makes of them) at their inputs, now and then.
//!
//! A [`Adc`] is what is behind a device: one on an SPI bus that the rig reads itself, or one of the kernel's
//! industrial I/O. The board asks it on a thread of its own, so a reading that takes its time holds up nobody.

mod accuracy;
mod board;
mod calibrated;
mod certificate;
mod device;
mod driver;
mod handle;
pub mod iio;
mod scale;
mod spec;
pub mod spi;

pub use accuracy::{Accuracy, Noise, Resolution};
pub use board::{AdcBoard, AdcSource, describe, open};
pub use calibrated::Calibrated;
pub(crate) use calibrated::calibrated;
pub use certificate::{Certificate, today};
pub use scale::{Point, Scale, Shown};
pub use spec::{AdcKind, AdcSpec, AdcsSpec, FindInput, SPREAD, SampleSpec};

use host::HostInstant;
use signal::Span;
use std::fmt::Debug;
use std::io;
use std::os::fd::BorrowedFd;

/// Readings of an input that one call brings at most.
pub const AT_ONCE: usize = 64;

/// What an input showed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdcReading {
    /// Place of the input among those that the converter was opened for.
    pub input: u16,
    /// The instants between which the input was sampled: the earlier one.
    pub before: HostInstant,
    /// The later one.
    pub after: HostInstant,
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
pub enum AdcPace<'a> {
    /// When they are asked for, so often.
    Asked(Span),
    /// By themselves, about so often, when this descriptor can be read.
    Ready(BorrowedFd<'a>, Span),
}

impl AdcPace<'_> {
    /// Whether readings come by themselves.
    pub const fn comes_by_itself(&self) -> bool {
        matches!(self, AdcPace::Ready(..))
    }
}

/// A converter that was opened for some of its inputs.
pub trait Adc: Send + Debug {
    /// What it is, as messages name it.
    fn device(&self) -> &str;

    /// How it is reached, in a word for clients: `spi`, `iio`.
    fn kind(&self) -> &'static str;

    /// How its readings come.
    fn pace(&self) -> AdcPace<'_>;

    /// How many periods may pass between the beginning of one sample of an input and the end of the next where none is
    /// lost.
    fn spread(&self) -> u8 {
        SPREAD
    }

    /// A run begins: what waits, and what was lost, is from before.
    ///
    /// # Errors
    /// As [`Adc::read`].
    fn begin(&mut self) -> io::Result<()> {
        Ok(())
    }

    /// Appends what there is: one reading of each input where it is asked, what waits where they come by themselves,
    /// at most [`AT_ONCE`] of each input.
    /// Does not allocate once `out` has grown.
    ///
    /// # Errors
    /// The kernel's: `ENODEV` and `ENXIO` where the device is gone.
    fn read(&mut self, out: &mut Vec<AdcReading>) -> io::Result<()>;

    /// How many readings were lost on the way since a run began, as far as the device reports it.
    fn lost(&self) -> u64 {
        0
    }

    /// How finely an input is measured.
    fn resolution(&self, input: u16) -> Resolution {
        let _ = input;
        Resolution::default()
    }

    /// How noisy the samples behind the last reading of an input were. `None` where a reading is one sample.
    fn noise(&self, input: u16) -> Option<Noise> {
        let _ = input;
        None
    }
}
