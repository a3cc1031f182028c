//! The small languages inside a plan's texts: instants, values, needs and references. One grammar each, and
//! errors that point inside the text.

mod address;
mod anchor;
mod literal;
mod names;
mod need;
mod reference;
mod signal_at;
mod words;

pub(crate) use address::{address, terminal};
pub(crate) use anchor::pattern as instant_pattern;
pub use anchor::{Anchor, AnchorBase, AnchorError, AnchorFault};
pub use literal::{Literal, LiteralFault};
pub use names::PlanNames;
pub(crate) use need::millihertz;
pub use need::{Amount, BoundRelation, CAPABILITIES, Capability, CapabilityUnit, Need, NeedBound, NeedFault};
pub(crate) use reference::has_reference;
pub use reference::{Bindings, MAX_VALUE_BYTES, substitute};
pub use signal_at::{SignalAt, SignalAtError};
pub use words::{is_id, is_path};
