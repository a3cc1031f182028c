//! Terminals: the inputs and outputs of modules, by number.

use profile::Reference;
use signal::{Address, Area, Size};
use std::fmt;

/// One input or output of a module, by its number there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Channel {
    /// In, from I0.
    Input(usize),
    /// Qn, from Q0.
    Output(usize),
}

impl Channel {
    /// The embedded channel at a bit of %I or %Q; none where the reference has no channel there.
    pub fn at(address: Address, reference: &Reference) -> Option<Channel> {
        let bit = address.bit_offset() as usize;
        match (address.area(), address.size()) {
            (Area::Input, Size::Bit) if bit < reference.input_count() => Some(Channel::Input(bit)),
            (Area::Output, Size::Bit) if bit < reference.output_count() => Some(Channel::Output(bit)),
            _ => None,
        }
    }
}

impl fmt::Display for Channel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Channel::Input(n) => write!(f, "I{n}"),
            Channel::Output(n) => write!(f, "Q{n}"),
        }
    }
}

/// The screw of a module.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Terminal {
    /// The module, by its place in the controller's list; 0 is the embedded I/O.
    pub module: usize,
    /// The channel of that module.
    pub channel: Channel,
}

impl Terminal {
    /// The terminal of an embedded input: n for In.
    pub const fn input(input: usize) -> Terminal {
        Terminal { module: 0, channel: Channel::Input(input) }
    }

    /// The number of an embedded input; none of anything else.
    pub const fn embedded_input(self) -> Option<usize> {
        match self {
            Terminal { module: 0, channel: Channel::Input(input) } => Some(input),
            _ => None,
        }
    }

    /// The terminal of an embedded output: n for Qn.
    pub const fn output(output: usize) -> Terminal {
        Terminal { module: 0, channel: Channel::Output(output) }
    }
}

impl fmt::Display for Terminal {
    /// `I3` of the embedded I/O, `module 2 I3` of another module.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.module == 0 {
            return write!(f, "{}", self.channel);
        }
        write!(f, "module {} {}", self.module, self.channel)
    }
}
