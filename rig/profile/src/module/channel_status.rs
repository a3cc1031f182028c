//! What the status byte of an analogue channel says.

/// The status of an analogue channel, a byte of %I for an output too (io:DIAG-06; manufacturer's product help, TM3 analogue
/// modules). No document of the controllers has its codes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ChannelStatus {
    /// Nothing is wrong.
    #[default]
    Normal,
    /// The module's own supply is off.
    Supply,
    /// At or above the limit, or an open sensor.
    OverRange,
    /// At or below the limit: an open loop of 4..20 mA.
    UnderRange,
    /// Above the high end of an extended mode, and below the limit.
    AboveEnd,
    /// Below the low end of an extended mode, and above the limit.
    BelowEnd,
}

impl ChannelStatus {
    /// The byte.
    pub const fn code(self) -> u8 {
        match self {
            ChannelStatus::Normal => 0,
            ChannelStatus::Supply => 4,
            ChannelStatus::OverRange => 5,
            ChannelStatus::UnderRange => 6,
            ChannelStatus::AboveEnd => 8,
            ChannelStatus::BelowEnd => 9,
        }
    }
}
