//! Generators: devices that make pulses by themselves once they are given which.
//!
//! Two kinds: the outputs of a PWM chip, which emit square waves without end, and the data line of an SPI bus, which
//! emits counted pulses as a stream of bits. The board talks to each on a thread of its own, so a call that takes its
//! time holds up nobody.

mod bits;
mod board;
mod device;
mod driver;
mod handle;
mod pwm;
mod sent_edges;
mod spec;
mod stream;

pub use bits::{BitClock, BitLayout};
pub use board::{GeneratorBoard, GeneratorSource, describe, look, open};
pub use pwm::{Attribute, Attributes, FoundPwm, Pwm, PwmOutput, find};
pub use spec::{FindPwm, GeneratorKind, GeneratorSpec, GeneratorsSpec, OutputSpec, PwmSpec, StreamSpec};
pub use stream::{BUFFER, Stream};

use host::HostInstant;
use signal::Span;
use std::fmt::Debug;
use std::io;

use crate::OutputClaim;

/// When a stream of bits was on its line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SentPulses {
    /// The instants around the call that sent it: the earlier one.
    pub before: HostInstant,
    /// The later one.
    pub after: HostInstant,
    /// Bits that were sent.
    pub bits: u64,
}

/// A generator that was opened for some of its outputs, which it numbers from 0.
pub trait Generator: Send + Debug {
    /// What it is, as messages name it.
    fn device(&self) -> &str;

    /// Brings all outputs to rest.
    ///
    /// # Errors
    /// The kernel's: `ENODEV`, `ENXIO` and `ESHUTDOWN` where the device is gone.
    fn rest(&mut self) -> io::Result<()>;

    /// Keeps an output at a level of its channel.
    ///
    /// # Errors
    /// As [`Generator::rest`].
    fn level(&mut self, output: u8, high: bool) -> io::Result<()>;

    /// Has an output emit a square wave.
    ///
    /// # Errors
    /// As [`Generator::rest`].
    fn square(&mut self, output: u8, period: Span, high: Span) -> io::Result<()>;

    /// PulseCapability pulses, whose edges come at these times, to their end.
    ///
    /// # Errors
    /// As [`Generator::rest`].
    fn pulses(&mut self, output: u8, edges: &[Span]) -> io::Result<SentPulses>;

    /// How long [`Generator::pulses`] takes at least.
    fn lasts(&self, edges: &[Span]) -> Span;

    /// Whether the device is still there.
    ///
    /// # Errors
    /// As [`Generator::rest`].
    fn look(&mut self) -> io::Result<()>;

    /// A claim of its own on what has to be made safe when the rig cannot any more.
    ///
    /// # Errors
    /// The kernel has no descriptor left.
    fn output_claims(&self) -> io::Result<Vec<OutputClaim>>;
}
