//! The relocation table as it is configured (controller: section 6).

use profile::{READ_TABLE, WRITE_TABLE};
use std::fmt;

/// The relocation table as configured: one for a controller (controller:REL-01). Names or full paths, in order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RelocationConfig {
    /// What stands from %MW60200 on.
    pub read: Vec<String>,
    /// What stands from %MW62200 on.
    pub write: Vec<String>,
}

/// A part of the table (controller:REL-02).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum RelocationPart {
    /// From %MW60200 on.
    Read,
    /// From %MW62200 on.
    Write,
}

impl fmt::Display for RelocationPart {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            RelocationPart::Read => "read",
            RelocationPart::Write => "write",
        })
    }
}

impl RelocationPart {
    /// The first register.
    pub const fn first(self) -> u16 {
        match self {
            RelocationPart::Read => READ_TABLE,
            RelocationPart::Write => WRITE_TABLE,
        }
    }
}
