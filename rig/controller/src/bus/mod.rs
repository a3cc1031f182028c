//! The expansion bus of TM3 and TM2 modules (io: sections 10 to 12).

mod start;

pub use start::{BusStart, ConfiguredPosition, ExtraModules, PositionState, compare_modules};
