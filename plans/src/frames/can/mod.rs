//! Frames of CAN buses: which of them a name of a plan stands for, what is sent, and what values their data carry.

mod coding;
mod dbc;
mod pattern;

pub use coding::{ByteOrder, Coding, FrameSelector, RawKind};
pub(crate) use dbc::{Databases, NONE};
pub use dbc::{DbcDatabase, DbcFault, FieldSpec, MessageSpec};
pub use pattern::{FramePattern, FrameSender, FrameView, MAX_EXTENDED_ID, MAX_ID};

/// A value in frames.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FrameSignal {
    /// The frames.
    pub pattern: FramePattern,
    /// Where it stands in them.
    pub field: FieldSpec,
}
