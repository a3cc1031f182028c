//! The name of an input or output.

use crate::Reference;
use signal::{Address, Area, Size};
use std::fmt;

/// One input or output of a module, by its number there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum IoChannel {
    /// In, from I0.
    Input(usize),
    /// Qn, from Q0.
    Output(usize),
}

impl IoChannel {
    /// The embedded channel at a bit of %I or %Q; none where the reference has no channel there.
    pub fn at(address: Address, reference: &Reference) -> Option<IoChannel> {
        let bit = address.bit_offset() as usize;
        match (address.area(), address.size()) {
            (Area::Input, Size::Bit) if bit < reference.input_count() => Some(IoChannel::Input(bit)),
            (Area::Output, Size::Bit) if bit < reference.output_count() => Some(IoChannel::Output(bit)),
            _ => None,
        }
    }
}

impl IoChannel {
    /// Whether it is an input or an output, in a word.
    pub const fn kind(self) -> &'static str {
        match self {
            IoChannel::Input(_) => "input",
            IoChannel::Output(_) => "output",
        }
    }
}

impl fmt::Display for IoChannel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            IoChannel::Input(n) => write!(f, "I{n}"),
            IoChannel::Output(n) => write!(f, "Q{n}"),
        }
    }
}
