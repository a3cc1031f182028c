//! Terminals: where a wire is at a module.

use profile::IoChannel;
use std::fmt;

/// The screw of a module.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Terminal {
    /// The module, by its place in the controller's list; 0 is the embedded I/O.
    pub module: usize,
    /// The channel of that module.
    pub channel: IoChannel,
}

impl Terminal {
    /// The terminal of an embedded input: n for In.
    pub const fn input(input: usize) -> Terminal {
        Terminal { module: 0, channel: IoChannel::Input(input) }
    }

    /// The number of an embedded input; none of anything else.
    pub const fn embedded_input(self) -> Option<usize> {
        match self {
            Terminal { module: 0, channel: IoChannel::Input(input) } => Some(input),
            _ => None,
        }
    }

    /// The terminal of an embedded output: n for Qn.
    pub const fn output(output: usize) -> Terminal {
        Terminal { module: 0, channel: IoChannel::Output(output) }
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
