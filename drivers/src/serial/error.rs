//! What the kernel says when a call on a serial port fails.

use std::io;
use std::path::{Path, PathBuf};

use rustix::io::Errno;
use thiserror::Error;

/// The call that failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SerialCall {
    /// Opening the port.
    Open,
    /// Taking it for the rig alone.
    Hold,
    /// Setting speed and bits.
    Settings,
    /// Setting up the direction of a transceiver.
    Rs485,
    /// Having each byte handed on at once.
    LowLatency,
    /// Receiving.
    Receive,
    /// Sending.
    Send,
    /// Waiting until all is sent.
    Drain,
    /// Sending a break.
    Break,
    /// Forgetting what waits in the kernel.
    Discard,
    /// Reading the counters of the line.
    Counters,
}

impl SerialCall {
    /// The call in words, as in `opening`.
    pub const fn words(self) -> &'static str {
        match self {
            SerialCall::Open => "opening",
            SerialCall::Hold => "taking hold of",
            SerialCall::Settings => "setting speed and bits of",
            SerialCall::Rs485 => "setting the RS-485 direction of",
            SerialCall::LowLatency => "setting the latency of",
            SerialCall::Receive => "receiving from",
            SerialCall::Send => "sending to",
            SerialCall::Drain => "waiting until all is sent by",
            SerialCall::Break => "sending a break to",
            SerialCall::Discard => "emptying the queues of",
            SerialCall::Counters => "reading the counters of",
        }
    }
}

/// A call on a serial port failed.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{} {} failed: {errno}", .call.words(), .path.display())]
pub struct SerialError {
    /// The device as it was named.
    pub path: PathBuf,
    /// What was asked of it.
    pub call: SerialCall,
    /// What the kernel says.
    #[source]
    pub errno: Errno,
}

impl SerialError {
    pub(crate) fn new(path: &Path, call: SerialCall, error: &io::Error) -> SerialError {
        // Without a number the library itself refused what was asked.
        let errno = Errno::from_io_error(error).unwrap_or(Errno::INVAL);
        SerialError { path: path.to_owned(), call, errno }
    }

    pub(super) fn of(path: &Path, call: SerialCall, errno: Errno) -> SerialError {
        SerialError { path: path.to_owned(), call, errno }
    }

    /// From what the library says, which hides the kernel's number: this must come right after the call.
    pub(super) fn last(path: &Path, call: SerialCall) -> SerialError {
        SerialError::new(path, call, &io::Error::last_os_error())
    }

    /// The error in std's terms.
    pub fn io(&self) -> io::Error {
        self.errno.into()
    }

    /// Whether it says that the port is there no more: unplugged, or its driver taken away.
    pub fn is_gone(&self) -> bool {
        // EIO is what a terminal says that was hung up.
        crate::gone::is_gone(self.errno.raw_os_error(), &[Errno::IO])
    }
}
