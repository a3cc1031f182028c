//! A count of modelled lines, as data.

use crate::channel::ChannelId;
use crate::counting::{CountEdge, CountFunction};

/// A count of modelled lines, behind a channel of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TallySpec {
    /// The channel that reports it.
    pub channel: ChannelId,
    /// Signal A.
    pub a: ChannelId,
    /// Signal B, where the function has one.
    pub b: Option<ChannelId>,
    /// What is made of them.
    pub function: CountFunction,
    /// The edge of A that counts where it is alone.
    pub edge: CountEdge,
}

impl TallySpec {
    /// The lines that it counts.
    pub fn signals(&self) -> impl Iterator<Item = ChannelId> + use<> {
        [Some(self.a), self.b].into_iter().flatten()
    }
}
