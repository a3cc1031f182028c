//! A loop from one of the board's outputs to one of its inputs.

use crate::ChannelId;

/// An output and the input that a wire brings it to; one channel where the board reads the output back. The rig may
/// drive it at any time: nothing else depends on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LoopbackPair {
    /// Is driven.
    pub out: ChannelId,
    /// Follows.
    pub input: ChannelId,
}
