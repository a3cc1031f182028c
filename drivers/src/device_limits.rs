//! How much patience a board has with its devices.

use signal::Span;

/// How long a device may take for a call, and what becomes of one that is gone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DeviceLimits {
    /// How long a call on a device may last before the device counts as lost.
    pub unresponsive_after: Span,
    /// A device that went away is opened again when it is there again.
    pub reconnect: bool,
}

impl DeviceLimits {
    /// How long a call on a device may last, where the board file does not say.
    pub const UNRESPONSIVE_AFTER: Span = Span::from_millis(100);
}

impl Default for DeviceLimits {
    fn default() -> DeviceLimits {
        DeviceLimits { unresponsive_after: DeviceLimits::UNRESPONSIVE_AFTER, reconnect: false }
    }
}
