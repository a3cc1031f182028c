//! Faults of real wires: relays that cut a wire or join it to 0 V or to the supply, driven as outputs of the board.
//!
//! Of one wire at most one relay is on. Another one follows only when the contact of the last has surely moved, so two
//! shorts never meet. Where several faults are on a channel the newest counts, as on the simulated board.

use host::HostInstant;
use signal::{Span, Time, Value, When};

use super::RealSpec;
use super::wire::{self, FaultWay, WireRelays};
use crate::sim::MAX_FAULTS;
use crate::{
    Board, BoardContext, BoardError, BoardEvent, BoardExt, Channel, ChannelId, Fault, FaultInjection,
    FaultKind, Health,
};

/// A fault that was asked for.
#[derive(Clone, Copy, Debug)]
struct Active {
    way: FaultWay,
    until: Option<Time>,
}

/// A wire with its relays.
#[derive(Debug)]
struct Wire {
    spec: WireRelays,
    faults: Vec<Active>,
    /// The relay that is on, or was asked to be.
    on: Option<FaultWay>,
    /// A relay that was asked to move and was not seen driven yet: its channel, and where to.
    asked: Option<(ChannelId, bool)>,
    /// When the contact that moved last has settled.
    settles: Option<Time>,
    /// When it began to move: not before this instant.
    moves: Time,
    /// When the wire came to be as it is wanted, where that is known.
    settled_at: Option<When>,
}

impl Wire {
    fn new(spec: WireRelays) -> Wire {
        let faults = Vec::with_capacity(usize::from(MAX_FAULTS));
        Wire { spec, faults, on: None, asked: None, settles: None, moves: Time::ZERO, settled_at: None }
    }

    /// No fault is wanted, and every relay is off.
    fn forget(&mut self) {
        self.faults.clear();
        (self.on, self.asked, self.settles, self.settled_at) = (None, None, None, None);
    }

    /// The relay of the newest fault.
    fn wanted(&self) -> Option<FaultWay> {
        self.faults.last().map(|fault| fault.way)
    }

    /// Whether a contact moves.
    fn is_moving(&self) -> bool {
        self.asked.is_some() || self.settles.is_some()
    }

    /// Ends what is over by `now`.
    fn pass(&mut self, now: Time) {
        self.faults.retain(|fault| fault.until.is_none_or(|until| until > now));
        if let Some(settled) = self.settles.take_if(|settles| *settles <= now) {
            self.arrived(When::within(self.moves, settled));
        }
    }

    /// A channel changed: a relay was driven, or the wire itself shows that it is as it is wanted.
    fn changed(&mut self, channel: ChannelId, value: Value, at: When) {
        let awaited = |asked: &(ChannelId, bool)| (asked.0, Value::Bool(asked.1)) == (channel, value);
        if self.asked.take_if(|asked| awaited(asked)).is_some() {
            self.moves = self.moves.max(at.earliest);
            self.settles = Some(at.latest.saturating_add(self.spec.settle));
        } else if channel == self.spec.channel && self.is_moving() && at.latest >= self.moves {
            let level = match self.on {
                Some(FaultWay::Ground) => Some(Value::Bool(self.spec.ground_is_one)),
                Some(FaultWay::Supply) => Some(Value::Bool(!self.spec.ground_is_one)),
                // What else is on the wire decides.
                Some(FaultWay::Open) | None => None,
            };
            if level.is_none_or(|level| level == value || !matches!(value, Value::Bool(_))) {
                self.arrived(at);
            }
        }
    }

    /// The wire is as the relay that moved last has it, since this instant.
    fn arrived(&mut self, at: When) {
        if self.on == self.wanted() {
            self.settled_at.get_or_insert(at);
        }
    }

    /// When it has something to do by itself.
    fn next(&self) -> Option<Time> {
        self.faults.iter().filter_map(|fault| fault.until).chain(self.settles).min()
    }

    /// The next relay to be driven, and where to: one is off before another one is on.
    fn step(&self) -> Option<(FaultWay, bool)> {
        match (self.on, self.wanted()) {
            _ if self.is_moving() => None,
            (on, wanted) if on == wanted => None,
            (Some(on), _) => Some((on, false)),
            (None, wanted) => wanted.map(|way| (way, true)),
        }
    }
}

/// The board of real devices with its relays in charge of its faults, where it has some.
pub(super) fn around(board: Box<dyn Board>, spec: &RealSpec, context: &BoardContext) -> Box<dyn Board> {
    match spec.relays.as_slice() {
        [] => board,
        wires => Box::new(FaultRelays::new(board, wires, Some(context))),
    }
}

/// A board with relays among its outputs that put faults on the wires of its channels.
#[derive(Debug)]
pub struct FaultRelays<B: Board> {
    inner: B,
    channels: Vec<Channel>,
    wires: Vec<Wire>,
    /// Whether a channel is that of a relay.
    is_relay: Vec<bool>,
    /// What a run lives in; `None` in virtual time, where nothing is waited for.
    context: Option<BoardContext>,
    /// When relays that were on were let go at the end of a run.
    released: Option<HostInstant>,
    last: Time,
}

impl<B: Board> FaultRelays<B> {
    /// Puts relays of these wires, which are outputs of the board, in charge of its faults.
    pub fn new(inner: B, wires: &[WireRelays], context: Option<&BoardContext>) -> FaultRelays<B> {
        let mut channels = inner.channels().to_vec();
        wire::describe(wires, &mut channels);
        let mut is_relay = vec![false; channels.len()];
        for relay in wires.iter().flat_map(|wire| wire.relays.iter().flatten()) {
            if let Some(is_relay) = is_relay.get_mut(usize::from(relay.0)) {
                *is_relay = true;
            }
        }
        FaultRelays {
            inner,
            channels,
            wires: wires.iter().cloned().map(Wire::new).collect(),
            is_relay,
            context: context.cloned(),
            released: None,
            last: Time::ZERO,
        }
    }

    /// The wire of a channel.
    fn wire(&self, channel: ChannelId) -> Option<usize> {
        self.wires.iter().position(|wire| wire.spec.channel == channel)
    }

    /// Lets relays move that have to.
    fn turn(&mut self, now: Time) -> Result<(), BoardError> {
        for at in 0..self.wires.len() {
            self.wires[at].pass(now);
        }
        for at in 0..self.wires.len() {
            let Some((way, on)) = self.wires[at].step() else { continue };
            // A wire that it must keep apart from may still be on its way back.
            let free = |other: &usize| {
                let other = &self.wires[*other];
                other.on.is_none() && !other.is_moving()
            };
            if on && !self.wires[at].spec.apart.iter().all(free) {
                continue;
            }
            let Some(relay) = self.wires[at].spec.relay(way) else { continue };
            self.inner.write(now, &[(relay, Value::Bool(on))])?;
            let wire = &mut self.wires[at];
            wire.on = on.then_some(way);
            (wire.asked, wire.moves, wire.settled_at) = (Some((relay, on)), now, None);
        }
        Ok(())
    }

    /// The faults of a wire are others now.
    fn ask(&mut self, at: usize, now: Time) -> Result<(), BoardError> {
        self.wires[at].settled_at = None;
        self.turn(now)?;
        let wire = &mut self.wires[at];
        if !wire.is_moving() {
            wire.arrived(When::exactly(now));
        }
        Ok(())
    }

    /// The fault as its relay makes it, and when it ends.
    fn fault(&self, now: Time, fault: Fault) -> Result<(usize, Active), BoardError> {
        let channel = fault.channel;
        if usize::from(channel.0) >= self.channels.len() {
            return Err(BoardError::NoChannel(channel));
        }
        let none = BoardError::NoSuchFault(channel);
        let at = self.wire(channel).ok_or(none)?;
        let spec = &self.wires[at].spec;
        let way = spec.way(fault.kind).ok_or(none)?;
        let lasts = match fault.kind {
            FaultKind::Glitch { width, .. } => Some(fault.lasts.map_or(width, |lasts| lasts.min(width))),
            _ => fault.lasts,
        };
        // One that is over before the relay has moved was none.
        if lasts.is_some_and(|lasts| lasts < spec.shortest()) {
            return Err(none);
        }
        let ends = |lasts: Span| now.as_nanos().checked_add(lasts.as_nanos()).map(Time::from_nanos);
        let until = match lasts {
            Some(lasts) => Some(ends(lasts).ok_or(BoardError::BadFaultTime(channel))?),
            None => None,
        };
        Ok((at, Active { way, until }))
    }
}

impl<B: Board> Board for FaultRelays<B> {
    fn inner(&self) -> Option<&dyn Board> {
        Some(&self.inner)
    }

    fn inner_mut(&mut self) -> Option<&mut dyn Board> {
        Some(&mut self.inner)
    }

    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// Waits until contacts that moved at the end of the run before have settled.
    fn start(&mut self, now: Time) -> Result<(), BoardError> {
        self.wires.iter_mut().for_each(Wire::forget);
        let settle = self.wires.iter().map(|wire| wire.spec.settle).max().unwrap_or(Span::ZERO);
        if let (Some(lives), Some(released)) = (&self.context, self.released.take()) {
            let settled = released + settle;
            while HostInstant::now() < settled {
                lives.bell.wait_until(settled);
            }
        }
        self.last = now;
        self.inner.start(now)
    }

    fn write(&mut self, now: Time, writes: &[(ChannelId, Value)]) -> Result<(), BoardError> {
        let is_relay = |channel: ChannelId| self.is_relay.get(usize::from(channel.0)) == Some(&true);
        if let Some((relay, _)) = writes.iter().find(|(channel, _)| is_relay(*channel)) {
            return Err(BoardError::NotDriven(*relay));
        }
        self.inner.write(now, writes)
    }

    fn poll(&mut self, now: Time, out: &mut Vec<BoardEvent>) -> Result<(), BoardError> {
        let first = out.len();
        let outcome = self.inner.poll(now, out);
        for event in &out[first..] {
            if let BoardEvent::Changed { channel, at, value, .. } = *event {
                self.wires.iter_mut().for_each(|wire| wire.changed(channel, value, at));
            }
        }
        self.last = now;
        outcome?;
        if self.inner.health().latched_safe { Ok(()) } else { self.turn(now) }
    }

    /// What is over already is nothing that is still to come.
    fn next_event(&self) -> Option<Time> {
        let own = self.wires.iter().filter_map(Wire::next).filter(|next| *next > self.last).min();
        [self.inner.next_event(), own].into_iter().flatten().min()
    }

    /// Relays go back with all other outputs.
    fn safe(&mut self, now: Time) -> Result<(), BoardError> {
        let moves = self.wires.iter().any(|wire| wire.on.is_some() || wire.is_moving());
        let made = self.inner.safe(now);
        if moves {
            self.released = Some(HostInstant::now());
        }
        self.wires.iter_mut().for_each(Wire::forget);
        made
    }

    fn health(&self) -> Health {
        self.inner.health()
    }

    fn faults(&self) -> Option<&dyn FaultInjection> {
        Some(self)
    }

    fn faults_mut(&mut self) -> Option<&mut dyn FaultInjection> {
        Some(self)
    }
}

impl<B: Board> FaultInjection for FaultRelays<B> {
    fn inject(&mut self, now: Time, fault: Fault) -> Result<(), BoardError> {
        let (at, active) = self.fault(now, fault)?;
        let wanted = |other: &&usize| self.wires[**other].wanted().is_some();
        if let Some(other) = self.wires[at].spec.apart.iter().find(wanted) {
            let other = self.wires[*other].spec.channel;
            return Err(BoardError::FaultsApart { channel: fault.channel, other });
        }
        let wire = &mut self.wires[at];
        if wire.faults.len() >= usize::from(MAX_FAULTS) {
            return Err(BoardError::TooManyFaults { channel: fault.channel, limit: MAX_FAULTS });
        }
        wire.faults.push(active);
        self.ask(at, now)
    }

    fn clear_faults(&mut self, now: Time, channel: ChannelId) -> Result<(), BoardError> {
        let Some(at) = self.wire(channel) else { return self.inner.clear_faults(now, channel) };
        self.wires[at].faults.clear();
        self.ask(at, now)
    }

    fn fault_switching_time(&self, channel: ChannelId) -> Span {
        self.wire(channel).map_or(Span::ZERO, |at| self.wires[at].spec.settle)
    }

    fn fault_settled_at(&self, channel: ChannelId) -> Option<When> {
        self.wires[self.wire(channel)?].settled_at
    }
}
