//! The lines of one chip as the rig has claimed them: the same few calls through either interface of the kernel.

use std::fmt;
use std::io;
use std::os::fd::BorrowedFd;

use super::{Backend, Bias, Drive};
use crate::OutputClaim;
use host::HostInstant;

/// A line to be claimed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wanted {
    /// Its number on the chip.
    pub number: u32,
    /// Its pull.
    pub bias: Option<Bias>,
    /// A low level is 1.
    pub active_low: bool,
    /// How an output drives.
    pub drive: Drive,
    /// How long an input must keep a level, in microseconds; 0 for at once.
    pub debounce_us: u32,
    /// What an output is driven to at once, and when safe.
    pub safe: bool,
}

/// What the lines of one chip are claimed as: outputs and inputs, each by rising numbers.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Claim {
    /// Lines to drive.
    pub outputs: Vec<Wanted>,
    /// Lines to read and to have edges of.
    pub inputs: Vec<Wanted>,
}

/// Levels of inputs, by their place in the claim.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LineLevels {
    /// Bit 0 is the first input.
    pub bits: u64,
    /// The inputs that were read.
    pub known: u64,
}

/// An edge, as the kernel reports it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Edge {
    /// Place of the line among the claimed inputs.
    pub input: u8,
    /// The level after the edge.
    pub high: bool,
    /// When, as the kernel stamped it.
    pub stamp: HostInstant,
    /// Its number among the edges of the claim and of the line, from 1; `None` where the kernel does not count.
    pub numbers: Option<(u32, u32)>,
}

/// Claimed lines of a chip. Calls may come from several threads at once; none allocates but [`GpioPort::output_claims`].
pub trait GpioPort: Send + Sync + fmt::Debug {
    /// The interface behind it.
    fn backend(&self) -> Backend;

    /// Drives all outputs, in one call where the kernel can; bit 0 is the first output.
    ///
    /// # Errors
    /// What the kernel says: ENODEV when the chip is gone.
    fn set(&self, bits: u64) -> io::Result<()>;

    /// Reads inputs, in one call: all of them, or as many as one call can read, others the next time.
    ///
    /// # Errors
    /// As [`GpioPort::set`].
    fn get(&self) -> io::Result<LineLevels>;

    /// Reads all inputs, in as many calls as that takes.
    ///
    /// # Errors
    /// As [`GpioPort::set`].
    fn survey(&self) -> io::Result<LineLevels>;

    /// What to wait on for edges, by number from 0; `None` after the last.
    fn source(&self, number: usize) -> Option<BorrowedFd<'_>>;

    /// Appends edges that a source has ready, at most as many as fit into `out` as it is. Waits where it has none.
    ///
    /// # Errors
    /// As [`GpioPort::set`].
    fn edges(&self, source: usize, out: &mut Vec<Edge>) -> io::Result<()>;

    /// A claim of its own on the outputs, for whoever makes them safe when the rig cannot.
    ///
    /// # Errors
    /// The kernel has no descriptor left.
    fn output_claims(&self, device: &str) -> io::Result<Vec<OutputClaim>>;
}
