//! What the kernel says when a call on a GPIO chip fails.

use std::io;
use std::path::PathBuf;

use rustix::io::Errno;
use thiserror::Error;

/// The call that failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum GpioCall {
    /// Listing the chips.
    List,
    /// Opening a chip.
    Open,
    /// Asking what a chip is.
    ChipInfo,
    /// Asking what a line is and who holds it.
    LineInfo,
    /// Claiming lines.
    Claim,
    /// Reading the levels of claimed lines.
    Get,
    /// Driving claimed lines.
    Set,
    /// Reading edges.
    Edges,
}

impl GpioCall {
    /// The call in words, as in `opening`.
    pub const fn words(self) -> &'static str {
        match self {
            GpioCall::List => "listing",
            GpioCall::Open => "opening",
            GpioCall::ChipInfo => "asking about",
            GpioCall::LineInfo => "asking about the lines of",
            GpioCall::Claim => "claiming lines of",
            GpioCall::Get => "reading lines of",
            GpioCall::Set => "driving lines of",
            GpioCall::Edges => "reading edges of",
        }
    }
}

/// A call on a GPIO chip failed.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{} {} failed: {errno}", .call.words(), .device.display())]
pub struct GpioError {
    /// The device.
    pub device: PathBuf,
    /// What was asked of it.
    pub call: GpioCall,
    /// What the kernel says; EINVAL where a library refuses the request itself.
    #[source]
    pub errno: Errno,
}

impl GpioError {
    /// From what std says.
    pub(super) fn new(device: impl Into<PathBuf>, call: GpioCall, error: &io::Error) -> GpioError {
        GpioError { device: device.into(), call, errno: Errno::from_io_error(error).unwrap_or(Errno::INVAL) }
    }

    /// From what the library of the second interface says.
    pub(super) fn v2(device: impl Into<PathBuf>, call: GpioCall, error: &gpiocdev::Error) -> GpioError {
        let errno = match error {
            gpiocdev::Error::Os(errno) => Errno::from_raw_os_error(errno.0),
            gpiocdev::Error::Uapi(_, gpiocdev_uapi::Error::Os(errno)) => Errno::from_raw_os_error(errno.0),
            _ => Errno::INVAL,
        };
        GpioError { device: device.into(), call, errno }
    }

    /// From what the library of the first interface says. It hides the number of a refused call, so this must
    /// come right after the call.
    pub(super) fn v1(device: impl Into<PathBuf>, call: GpioCall, _error: &gpio_cdev::Error) -> GpioError {
        GpioError::new(device, call, &io::Error::last_os_error())
    }

    /// The error in std's terms.
    pub fn io(&self) -> io::Error {
        self.errno.into()
    }
}

/// The error of a call of the scan, which makes nothing of it that would have to be allocated.
pub(super) fn uapi(error: gpiocdev_uapi::Error) -> io::Error {
    match error {
        gpiocdev_uapi::Error::Os(errno) => io::Error::from_raw_os_error(errno.0),
        gpiocdev_uapi::Error::UnderRead(_) => Errno::INVAL.into(),
    }
}
