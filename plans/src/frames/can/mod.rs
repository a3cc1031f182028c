//! Frames of CAN buses: which of them a name of a plan stands for, what is sent, and what values their data carry.

mod coding;
mod dbc;
mod pattern;

pub use coding::{Coding, Order, Raw, Selector};
pub use dbc::{Database, DbcFault, FieldSpec, MessageSpec};
pub(crate) use dbc::{Databases, NONE};
pub use pattern::{FramePattern, FrameView, From, MAX_EXTENDED_ID, MAX_ID};

/// A value in frames.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FrameSignal {
    /// The frames.
    pub pattern: FramePattern,
    /// Where it stands in them.
    pub field: FieldSpec,
}
