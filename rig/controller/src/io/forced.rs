//! Forced values of the embedded inputs and outputs (controller:FRC-02).

/// Forced channels (controller:FRC-02).
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Forced {
    /// A 1 for every forced channel.
    pub mask: u32,
    /// Their values.
    pub bits: u32,
}

impl Forced {
    #[inline]
    pub(super) const fn apply(self, bits: u32) -> u32 {
        bits & !self.mask | self.bits & self.mask
    }

    pub(super) fn set(&mut self, channel: usize, on: Option<bool>) {
        let bit = 1 << channel;
        self.mask = if on.is_some() { self.mask | bit } else { self.mask & !bit };
        self.bits = if on == Some(true) { self.bits | bit } else { self.bits & !bit };
    }

    /// Takes the channels of `which` from `other`.
    pub(super) fn take(&mut self, other: Forced, which: u32) {
        self.mask = self.mask & !which | other.mask & which;
        self.bits = self.bits & !which | other.bits & which;
    }
}
