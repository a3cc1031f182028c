//! Frames of CAN buses: which of them a name of a plan stands for, what is sent, and what values their data carry.

mod coding;
mod dbc;
mod pattern;
mod read;
mod send;

pub use coding::{Coding, Order, Raw, Selector};
pub use dbc::{Database, DbcFault, FieldSpec, MessageSpec};
pub(crate) use dbc::{Databases, NONE};
pub use pattern::{FramePattern, FrameView, From, MAX_EXTENDED_ID, MAX_ID};
pub use read::FrameSignal;
pub(crate) use read::{FRAME_TYPE, Frames, Named, read};
pub(crate) use send::SEND;
pub use send::{OutFrame, Send};
