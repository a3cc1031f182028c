//! What a board hands to whoever makes its outputs safe when the rig cannot any more.

use std::io;
use std::os::fd::OwnedFd;

/// Through which of the kernel's interfaces lines are driven.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LineApi {
    /// GPIO, first version: a handle of so many lines.
    V1 {
        /// Number of lines, at most 64.
        lines: u8,
    },
    /// GPIO, second version: a request whose lines are the bits of a mask.
    V2,
    /// The active time of an output of a PWM chip, as a file of `/sys`: one line, which is 0 while the output rests.
    Pwm,
}

/// Output lines that one call drives: a claim of their own on the lines, which outlives the board's.
#[derive(Debug)]
pub struct OutputClaim {
    /// The device, as messages name it.
    pub device: String,
    /// The claim.
    pub claim: OwnedFd,
    /// How it is driven.
    pub api: LineApi,
    /// The lines among it: bit 0 is its first line.
    pub mask: u64,
    /// Their safe levels.
    pub safe: u64,
}

impl OutputClaim {
    /// The same claim once more.
    ///
    /// # Errors
    /// The process has no descriptor left.
    pub fn try_clone(&self) -> io::Result<OutputClaim> {
        let (claim, device) = (self.claim.try_clone()?, self.device.clone());
        Ok(OutputClaim { device, claim, api: self.api, mask: self.mask, safe: self.safe })
    }
}
