//! What a board file says of the relays that put faults on a wire.

use signal::{Span, Value};

use crate::{Channel, ChannelId, FaultKind, FaultSet};

/// How long a relay takes to move and to stop bouncing, where the board file does not say.
pub const SETTLE: Span = Span::from_millis(10);

/// What a relay does to its wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaultWay {
    /// It cuts the wire.
    Open,
    /// It joins the wire to 0 V.
    Ground,
    /// It joins the wire to the supply.
    Supply,
}

impl FaultWay {
    /// Every way, in the order of their keys.
    pub const ALL: [FaultWay; 3] = [FaultWay::Open, FaultWay::Ground, FaultWay::Supply];

    /// The key of a board file.
    pub const fn key(self) -> &'static str {
        match self {
            FaultWay::Open => "open",
            FaultWay::Ground => "short-to-ground",
            FaultWay::Supply => "short-to-supply",
        }
    }
}

/// The relays of a channel's wire.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WireRelays {
    /// The channel whose wire it is.
    pub channel: ChannelId,
    /// The channel of the relay of each way, in the order of [`FaultWay::ALL`]; 1 puts the fault on the wire.
    pub relays: [Option<ChannelId>; 3],
    /// How long a relay takes at most to move and to stop bouncing, from the end of the call that drives it.
    pub settle: Span,
    /// The channel is 1 while its wire is at 0 V.
    pub ground_is_one: bool,
    /// Places of the wires among those of the board on which no fault may be at the same time.
    pub apart: Vec<usize>,
}

impl WireRelays {
    /// The relay that does this to the wire.
    pub fn relay(&self, way: FaultWay) -> Option<ChannelId> {
        self.relays[way as usize]
    }

    /// What brings a fault of this kind about, if a relay can.
    pub fn way(&self, kind: FaultKind) -> Option<FaultWay> {
        let at_level = |value| match value {
            Value::Bool(level) if level == self.ground_is_one => Some(FaultWay::Ground),
            Value::Bool(_) => Some(FaultWay::Supply),
            _ => None,
        };
        let way = match kind {
            FaultKind::Open => FaultWay::Open,
            FaultKind::ShortToGround => FaultWay::Ground,
            FaultKind::ShortToSupply => FaultWay::Supply,
            FaultKind::StuckAt(value) | FaultKind::Glitch { value, .. } => at_level(value)?,
            FaultKind::Late(_) | FaultKind::Lost => return None,
        };
        self.relay(way).map(|_| way)
    }

    /// The shortest fault that is certain to be there: a relay closes before it opens.
    pub fn shortest(&self) -> Span {
        self.settle + self.settle
    }

    /// The faults that the relays can put on a channel of this kind.
    fn faults(&self, digital: bool) -> FaultSet {
        let level =
            |value: bool| [FaultKind::StuckAt(Value::Bool(value))].into_iter().filter(move |_| digital);
        let glitch = FaultKind::Glitch { value: Value::Bool(false), width: self.shortest() };
        // A set does not tell glitches to either level apart.
        let both = self.relay(FaultWay::Ground).is_some() && self.relay(FaultWay::Supply).is_some();
        let kinds = [FaultKind::Open, FaultKind::ShortToGround, FaultKind::ShortToSupply].into_iter();
        let kinds = kinds.chain(level(false)).chain(level(true)).filter(|kind| self.way(*kind).is_some());
        kinds.chain(Some(glitch).filter(|_| both && digital)).fold(FaultSet::NONE, FaultSet::with)
    }
}

/// Describes what relays do to the channels of a board: faults can be put on their wires, and nothing but a fault drives
/// a relay.
pub(super) fn describe(wires: &[WireRelays], channels: &mut [Channel]) {
    for wire in wires {
        if let Some(channel) = channels.get_mut(usize::from(wire.channel.0)) {
            channel.faults = wire.faults(channel.is_digital());
        }
        for relay in wire.relays.iter().flatten() {
            if let Some(channel) = channels.get_mut(usize::from(relay.0)) {
                channel.drives = false;
            }
        }
    }
}

/// The longest that a fault on this channel takes to come or to go.
pub(super) fn settle(wires: &[WireRelays], channel: ChannelId) -> Span {
    wires.iter().find(|wire| wire.channel == channel).map_or(Span::ZERO, |wire| wire.settle)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wire(relays: [Option<ChannelId>; 3], ground_is_one: bool) -> WireRelays {
        WireRelays { channel: ChannelId(0), relays, settle: SETTLE, ground_is_one, apart: Vec::new() }
    }

    #[test]
    fn a_level_is_held_by_the_short_that_has_it() {
        let both = [None, Some(ChannelId(1)), Some(ChannelId(2))];
        let stuck = |value| FaultKind::StuckAt(Value::Bool(value));
        assert_eq!(wire(both, false).way(stuck(true)), Some(FaultWay::Supply));
        assert_eq!(wire(both, true).way(stuck(true)), Some(FaultWay::Ground));
        let one = wire([None, Some(ChannelId(1)), None], false);
        let faults = one.faults(true);
        assert!(faults.contains(stuck(false)) && !faults.contains(stuck(true)));
        assert!(!faults.contains(FaultKind::Open) && !faults.contains(FaultKind::ShortToSupply));
        let glitch = FaultKind::Glitch { value: Value::Bool(false), width: Span::from_millis(50) };
        assert!(!faults.contains(glitch) && wire(both, false).faults(true).contains(glitch));
        assert!(!wire(both, false).faults(false).contains(stuck(true)), "a quantity has no level");
    }
}
