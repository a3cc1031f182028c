//! The embedded inputs and outputs by number.

use profile::Reference;
use signal::{Address, Area, Size};

/// An embedded input or output.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Channel {
    /// In, from I0.
    Input(usize),
    /// Qn, from Q0.
    Output(usize),
}

impl Channel {
    /// The channel behind a bit of %I or %Q; none where the reference has no channel there.
    pub fn at(address: Address, reference: &Reference) -> Option<Channel> {
        let bit = address.bit_offset() as usize;
        match (address.area(), address.size()) {
            (Area::Input, Size::Bit) if bit < reference.input_count() => Some(Channel::Input(bit)),
            (Area::Output, Size::Bit) if bit < reference.output_count() => Some(Channel::Output(bit)),
            _ => None,
        }
    }
}
