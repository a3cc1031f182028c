//! The channels of a board.

mod emission;
mod fault;

pub use emission::{Emission, NotEmitted, PulseCapability};
pub use fault::{Fault, FaultKind, FaultSet};

use signal::{Span, Value};

/// The place of a channel in [`Board::channels`](crate::Board::channels).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ChannelId(pub u16);

/// What a channel carries.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum ChannelKind {
    /// A level: [`Value::Bool`], or [`Value::HighZ`] where nobody drives.
    Digital,
    /// A measured or set quantity: [`Value::Measured`] or [`Value::Real`] in this unit.
    Analog {
        /// Unit as it is written, as in `V` or `degC`; empty for none.
        unit: String,
    },
    /// How far a counter has counted since the start: [`Value::Int`].
    Count,
}

/// Where the instants of a channel's events come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TimestampSource {
    /// Modelled time: exact.
    Virtual,
    /// The kernel stamps each edge.
    Kernel,
    /// A device stamps each edge with a clock of its own.
    Device,
    /// Changes are found by reading the line every `period`.
    Sampled {
        /// Time between two samples.
        period: Span,
    },
}

/// One channel of a board: a terminal with a line on it.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// The name that bindings, wires and plants use, as in `I0`, `Q4` or `temp`.
    pub name: String,
    /// What it carries.
    pub kind: ChannelKind,
    /// Whether [`Board::write`](crate::Board::write) may drive it.
    pub drives: bool,
    /// Whether [`Board::poll`](crate::Board::poll) reports it.
    pub senses: bool,
    /// Where the instants of its events come from.
    pub timestamp: TimestampSource,
    /// Width of the interval in which an event is stamped (0 = exact).
    pub resolution: Span,
    /// The shortest pulse that is certain to be seen; [`Span::MAX`] where the board cannot say.
    pub shortest_pulse: Span,
    /// The fastest pulse train that [`Board::write`](crate::Board::write) can emit on it, in Hz (0 = none).
    pub max_pulse_hz: u64,
    /// What it emits by itself: pulses that nobody writes edge by edge.
    pub emits: Option<PulseCapability>,
    /// The fastest pulse train of which the board is known to count every pulse, in Hz; `None` where nobody said. A claim
    /// that counts faster ones is inconclusive.
    pub counts_hz: Option<u64>,
    /// The faults that can be injected on it.
    pub faults: FaultSet,
    /// What a driven line is left at by [`Board::start`](crate::Board::start) and [`Board::safe`](crate::Board::safe).
    pub safe: Value,
    /// How far an analog channel can move from what was reported of it without being reported again, in its unit; 0 for not at
    /// all.
    pub deadband: f64,
}

impl Channel {
    /// Whether the channel carries a level.
    pub fn is_digital(&self) -> bool {
        self.kind == ChannelKind::Digital
    }

    /// Unit of an analog channel; empty for none, for a level and for a count.
    pub fn unit(&self) -> &str {
        match &self.kind {
            ChannelKind::Digital | ChannelKind::Count => "",
            ChannelKind::Analog { unit } => unit,
        }
    }
}
