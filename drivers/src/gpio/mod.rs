//! GPIO lines of the kernel's character devices: what there is, and (through either of the kernel's two interfaces)
//! claims on lines whose edges the kernel stamps.

mod board;
mod chip;
mod device;
mod edges;
mod error;
mod find;
mod info;
mod inputs;
mod lines;
mod outline;
mod port;
mod spec;
mod telling;
mod track;
mod v1;
mod v2;

pub use board::{GpioBoard, Served};
pub use error::{GpioCall, GpioError};
pub use find::{FoundChip, devices, find};
pub use info::{Backend, Bias, ChipInfo, Direction, Drive, LineInfo, list, look};
pub use outline::Outline;
pub use port::{Claim, Edge, Levels, Port, Wanted};
pub use spec::{ChipSpec, FindChip, FindLine, GpioSpec, LineSpec, MAX_CONSUMER, MAX_LINES, NamedLine};

use signal::Span;

/// How long a call on a chip may last, where the board file does not say.
pub const SILENT_AFTER: Span = Span::from_millis(100);
