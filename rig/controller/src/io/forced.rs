//! Forced values of the embedded inputs and outputs (controller:FRC-02).

use profile::ChannelSet;

/// Channels of one kind that are forced, with their values (controller:FRC-02).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ForcedChannels {
    channels: ChannelSet,
    /// Those of them that are forced to 1.
    on: ChannelSet,
}

impl ForcedChannels {
    /// Each forced channel by number, with its value.
    pub fn iter(self) -> impl Iterator<Item = (usize, bool)> {
        self.channels.iter().map(move |channel| (channel, self.on.contains(channel)))
    }

    /// Whether none is forced.
    #[inline]
    pub const fn is_empty(self) -> bool {
        self.channels.is_empty()
    }

    /// Which are forced.
    #[inline]
    pub(super) const fn channels(self) -> ChannelSet {
        self.channels
    }

    /// Those of them that are forced to 1.
    #[inline]
    pub(super) const fn on(self) -> ChannelSet {
        self.on
    }

    /// The channels at 1 where those of `on` were without forcing.
    #[inline]
    pub(super) fn apply(self, on: ChannelSet) -> ChannelSet {
        on.updated(self.channels, self.on)
    }

    pub(super) fn set(&mut self, channel: usize, on: Option<bool>) {
        self.channels.set(channel, on.is_some());
        self.on.set(channel, on == Some(true));
    }

    /// Takes the channels of `which` from `other`.
    pub(super) fn take(&mut self, other: ForcedChannels, which: ChannelSet) {
        self.channels = self.channels.updated(which, other.channels);
        self.on = self.on.updated(which, other.on);
    }
}
