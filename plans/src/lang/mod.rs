//! The small languages inside a plan's texts: instants, values, needs and references. One grammar each, and
//! errors that point inside the text.

mod address;
mod anchor;
mod literal;
mod names;
mod need;
mod operand;
mod reference;
mod words;

pub(crate) use address::{address, terminal};
pub(crate) use anchor::pattern as instant_pattern;
pub use anchor::{Anchor, AnchorError, AnchorFault, Base};
pub use literal::{Literal, LiteralFault};
pub use names::Names;
pub(crate) use need::millihertz;
pub use need::{Amount, Bound, CAPABILITIES, Capability, Measure, Need, NeedFault, Relation};
pub use operand::{Operand, OperandError};
pub(crate) use reference::has_reference;
pub use reference::{Bindings, MAX_VALUE_BYTES, substitute};
pub use words::{is_id, is_path};
