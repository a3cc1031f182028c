//! Faults that can be injected on a channel.

use super::ChannelId;
use signal::{Span, Value};

/// What an injected fault does to a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaultKind {
    /// The line keeps this value, whoever drives it.
    StuckAt(Value),
    /// The line is cut at the terminal: nothing drives it any more, an input reads its pull.
    Open,
    /// The line is at 0 V.
    ShortToGround,
    /// The line is at the supply.
    ShortToSupply,
    /// The line has this value for this time, then follows its drivers again.
    Glitch {
        /// Value during the glitch.
        value: Value,
        /// Length of the glitch, above 0.
        width: Span,
    },
    /// Every change of the line comes this much later.
    Late(Span),
    /// The device behind the channel is gone: its value is unknown and writes do not reach the line.
    Lost,
}

impl FaultKind {
    /// The flag of this kind in a [`FaultSet`].
    const fn bit(self) -> u8 {
        match self {
            FaultKind::StuckAt(Value::Bool(true)) => 128,
            FaultKind::StuckAt(_) => 1,
            FaultKind::Open => 2,
            FaultKind::ShortToGround => 4,
            FaultKind::ShortToSupply => 8,
            FaultKind::Glitch { .. } => 16,
            FaultKind::Late(_) => 32,
            FaultKind::Lost => 64,
        }
    }
}

/// A fault on one channel, from the instant of its injection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fault {
    /// Where.
    pub channel: ChannelId,
    /// What.
    pub kind: FaultKind,
    /// How long it stays; `None`: until [`clear_faults`](crate::FaultInjection::clear_faults). A glitch ends after its width in any case.
    pub lasts: Option<Span>,
}

/// Which kinds of fault a channel can have.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct FaultSet(u8);

impl FaultSet {
    /// No fault can be injected.
    pub const NONE: FaultSet = FaultSet(0);
    /// Every fault of a digital line.
    pub const DIGITAL: FaultSet = FaultSet(255);
    /// Every fault of an analog line: as [`FaultSet::DIGITAL`] but without a short to the supply, which has no
    /// value in the channel's unit.
    pub const ANALOG: FaultSet = FaultSet(127 - 8);

    /// Whether faults of this kind can be injected. Being stuck at 1 is a kind of its own; other values and times do not
    /// count.
    pub const fn contains(self, kind: FaultKind) -> bool {
        self.0 & kind.bit() != 0
    }

    /// The set with this kind added.
    #[must_use]
    pub const fn with(self, kind: FaultKind) -> Self {
        FaultSet(self.0 | kind.bit())
    }
}
