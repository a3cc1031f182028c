//! What can go wrong with a trace.

use std::fmt;
use std::io;

use crate::SignalId;

/// Which transfer failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TraceTransfer {
    /// Moving a full segment to the store.
    Spill,
    /// Reading a segment back from the store.
    Recall,
    /// Writing a trace file.
    Save,
    /// Reading a trace file.
    Load,
}

/// Why a trace refuses an event or a definition, or cannot be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TraceError {
    /// An event of a signal that was never defined.
    UnknownSignal(SignalId),
    /// A second signal of the same name as this one.
    DuplicateName(SignalId),
    /// More than [`MAX_SIGNALS`](super::MAX_SIGNALS) signals.
    TooManySignals,
    /// A transfer failed. After a failed spill the trace takes no more events.
    Io {
        /// Which one.
        transfer: TraceTransfer,
        /// What the system said.
        kind: io::ErrorKind,
    },
    /// A segment came back from the store other than it went there.
    SpillDamaged {
        /// Its place among the segments.
        segment: usize,
    },
    /// A cursor of another trace.
    ForeignCursor,
    /// The file does not begin as a trace does.
    NotATrace,
    /// The file is of a version that this program does not read.
    Version(u16),
    /// The file ends at this byte, before the trace does.
    Truncated {
        /// Byte of the file.
        offset: u64,
    },
    /// The part of the file that begins at this byte does not match its checksum.
    Checksum {
        /// Byte of the file.
        offset: u64,
    },
    /// The part of the file that begins at this byte makes no sense.
    Malformed {
        /// Byte of the file.
        offset: u64,
    },
    /// The content does not match the digest that the file carries.
    DigestMismatch,
    /// The trace is larger than the caller allows.
    TooLarge {
        /// The limit, in bytes of memory.
        limit: u64,
    },
}

impl fmt::Display for TraceError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::UnknownSignal(id) => write!(f, "the trace has no signal number {}", id.0),
            Self::DuplicateName(id) => write!(f, "signal number {} already has this name", id.0),
            Self::TooManySignals => write!(f, "a trace holds at most {} signals", super::MAX_SIGNALS),
            Self::Io { transfer, kind } => {
                let what = match transfer {
                    TraceTransfer::Spill => "a part of the trace could not be stored",
                    TraceTransfer::Recall => "a stored part of the trace could not be read back",
                    TraceTransfer::Save => "the trace file could not be written",
                    TraceTransfer::Load => "the trace file could not be read",
                };
                write!(f, "{what}: {kind}")
            }
            Self::SpillDamaged { segment } => write!(f, "stored segment {segment} of the trace is damaged"),
            Self::ForeignCursor => write!(f, "the cursor belongs to another trace"),
            Self::NotATrace => write!(f, "the file is no trace"),
            Self::Version(found) => {
                write!(
                    f,
                    "the trace file has version {found}; this program reads version {}",
                    super::file::VERSION
                )
            }
            Self::Truncated { offset } => write!(f, "the trace file ends early, at byte {offset}"),
            Self::Checksum { offset } => write!(f, "the trace file is damaged at byte {offset}: checksum"),
            Self::Malformed { offset } => write!(f, "the trace file is damaged at byte {offset}"),
            Self::DigestMismatch => write!(f, "the content of the trace file does not match its digest"),
            Self::TooLarge { limit } => {
                write!(f, "the trace needs more than the allowed {limit} bytes of memory")
            }
        }
    }
}

impl std::error::Error for TraceError {}
