//! A board that makes trouble by itself, out of a seed.

use std::collections::VecDeque;

use signal::{Span, Time, Value, When};

use crate::board::{Board, BoardError, BoardExt, Call, FaultInjection, PulseOutputs};
use crate::channel::{Channel, ChannelId, Emission, Fault};
use crate::event::{BoardEvent, Health, LossReason, Origin};
use signal::Random;

/// The most events that are held back at once; what comes on top is dropped and reported as such.
pub const MAX_HELD: usize = 1 << 16;

/// Which trouble, and how often. Chances are in millionths: 1 000 000 is always.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Disturbance {
    /// Chance of a change to become known late.
    pub late_ppm: u32,
    /// At most how late.
    pub late_by: Span,
    /// Chance of a change to be lost and reported as [`BoardEvent::Dropped`].
    pub drop_ppm: u32,
    /// Chance of a call of write, poll, inject or clear to fail without any effect.
    pub call_ppm: u32,
    /// Chance of a channel's device to be lost at one of its changes.
    pub lose_ppm: u32,
    /// How long a lost device stays away, at least one nanosecond.
    pub lost_for: Span,
}

/// A wrapper that delays, drops and refuses, the same way for the same seed and calls.
///
/// A late change is reported up to [`Disturbance::late_by`] after it happened, its interval stretched to the
/// instant of the report; later changes of the same channel are never reported before it. Trouble with events is
/// drawn per change, so that it does not depend on how often the board is polled.
#[derive(Debug)]
pub struct Faulty<B: Board> {
    inner: B,
    disturbance: Disturbance,
    seed: u64,
    events: Random,
    calls: Random,
    fresh: Vec<BoardEvent>,
    /// Events to be reported, by the instant from which they may be.
    held: VecDeque<(Time, BoardEvent)>,
    state: Vec<State>,
    /// Whether a channel has missed events.
    missed: bool,
    health: Health,
}

#[derive(Clone, Copy, Debug)]
struct State {
    /// Nothing of this channel is reported before this instant.
    not_before: Time,
    /// When a lost device comes back.
    back: Option<Time>,
    /// The newest value that the channel had.
    value: Value,
    /// Events that found no room.
    missed: u32,
}

impl State {
    const NEW: State = State { not_before: Time::MIN, back: None, value: Value::Unknown, missed: 0 };
}

/// Input/output error, as the kernel numbers it.
const EIO: i32 = 5;
/// No such device, as the kernel numbers it.
const ENODEV: i32 = 19;

impl<B: Board> Faulty<B> {
    /// Puts the disturbance around a board.
    pub fn new(inner: B, disturbance: Disturbance, seed: u64) -> Self {
        Faulty {
            state: vec![State::NEW; inner.channels().len()],
            inner,
            disturbance,
            seed,
            events: Random::lane(seed, EVENTS_LANE),
            calls: Random::lane(seed, CALLS_LANE),
            fresh: Vec::new(),
            held: VecDeque::new(),
            missed: false,
            health: Health::default(),
        }
    }

    /// The board within.
    pub fn into_inner(self) -> B {
        self.inner
    }

    /// A call on channels of which one is lost fails.
    fn reachable(
        &mut self,
        channels: impl IntoIterator<Item = ChannelId>,
        now: Time,
    ) -> Result<(), BoardError> {
        let lost = |channel: ChannelId| {
            self.state
                .get(usize::from(channel.0))
                .is_some_and(|state| state.back.is_some_and(|back| back > now))
        };
        if channels.into_iter().any(lost) {
            self.health.failed_calls += 1;
            return Err(BoardError::Os { call: Call::Write, code: ENODEV });
        }
        Ok(())
    }

    fn disturb_call(&mut self, call: Call) -> Result<(), BoardError> {
        if self.calls.chance(self.disturbance.call_ppm) {
            self.health.failed_calls += 1;
            return Err(BoardError::Os { call, code: EIO });
        }
        Ok(())
    }

    /// Puts an event where it belongs, its knowledge not older than the instant at which it may be reported; equal
    /// instants keep their order.
    fn hold(&mut self, from: Time, mut event: BoardEvent) {
        let state = &mut self.state[usize::from(event.channel().0)];
        if self.held.len() >= MAX_HELD {
            self.health.dropped += 1;
            state.missed = state.missed.saturating_add(1);
            self.missed = true;
            return;
        }
        let from = from.max(state.not_before);
        state.not_before = from;
        match &mut event {
            BoardEvent::Changed { at, .. } => at.latest = at.latest.max(from),
            BoardEvent::Lost { at, .. }
            | BoardEvent::Returned { at, .. }
            | BoardEvent::Dropped { at, .. } => {
                *at = from;
            }
        }
        let place = self.held.partition_point(|(held, _)| *held <= from);
        self.held.insert(place, (from, event));
    }

    fn take(&mut self, event: BoardEvent) {
        let BoardEvent::Changed { channel, at, value, .. } = event else {
            return self.hold(event.latest(), event);
        };
        let place = usize::from(channel.0);
        let first = matches!(self.state[place].value, Value::Unknown);
        self.state[place].value = value;
        if self.state[place].back.is_some() {
            return;
        }
        // The value at the start is read, not waited for: no trouble with it.
        if first {
            return self.hold(at.latest, event);
        }
        let dropped = self.events.chance(self.disturbance.drop_ppm);
        let lost = self.events.chance(self.disturbance.lose_ppm);
        let late = self.events.chance(self.disturbance.late_ppm);
        let delay = self.events.span(self.disturbance.late_by);
        if lost {
            let away = self.disturbance.lost_for.max(Span::from_nanos(1));
            self.health.lost += 1;
            self.hold(at.latest, BoardEvent::Lost { channel, at: at.latest, reason: LossReason::Gone });
            let gone = self.state[place].not_before;
            self.state[place].back = Some(gone.saturating_add(away));
        } else if dropped {
            self.health.dropped += 1;
            self.hold(at.latest, BoardEvent::Dropped { channel, at: at.latest, count: 1 });
        } else {
            self.hold(if late { at.latest.saturating_add(delay) } else { at.latest }, event);
        }
    }

    /// Brings back the devices that were away long enough.
    fn bring_back(&mut self, now: Time) {
        for place in 0..self.state.len() {
            let State { back: Some(back), value, .. } = self.state[place] else { continue };
            if back > now {
                continue;
            }
            self.state[place].back = None;
            self.health.lost -= 1;
            let channel = ChannelId(place as u16);
            self.hold(back, BoardEvent::Returned { channel, at: back });
            let at = When::exactly(back);
            self.hold(back, BoardEvent::Changed { channel, at, value, origin: Origin::Outside });
        }
    }

    /// Reports what found no room.
    fn confess(&mut self, now: Time, out: &mut Vec<BoardEvent>) {
        if !std::mem::replace(&mut self.missed, false) {
            return;
        }
        for (place, state) in self.state.iter_mut().enumerate() {
            let count = std::mem::take(&mut state.missed);
            if count > 0 {
                out.push(BoardEvent::Dropped { channel: ChannelId(place as u16), at: now, count });
            }
        }
    }

    fn next_back(&self) -> Option<Time> {
        self.state.iter().filter_map(|state| state.back).min()
    }

    /// Takes in all that the board within has up to `now`, with devices returning between its events.
    fn collect(&mut self, now: Time) -> Result<(), BoardError> {
        let mut fresh = std::mem::take(&mut self.fresh);
        let outcome = self.inner.poll(now, &mut fresh);
        for event in fresh.drain(..) {
            while self.next_back().is_some_and(|back| back <= event.latest()) {
                self.bring_back(event.latest());
            }
            self.take(event);
        }
        self.fresh = fresh;
        self.bring_back(now);
        outcome
    }
}

const EVENTS_LANE: u64 = 0xFA01;
const CALLS_LANE: u64 = 0xFA02;

impl<B: Board> Board for Faulty<B> {
    fn inner(&self) -> Option<&dyn Board> {
        Some(&self.inner)
    }

    fn inner_mut(&mut self) -> Option<&mut dyn Board> {
        Some(&mut self.inner)
    }

    fn channels(&self) -> &[Channel] {
        self.inner.channels()
    }

    fn start(&mut self, now: Time) -> Result<(), BoardError> {
        self.events = Random::lane(self.seed, EVENTS_LANE);
        self.calls = Random::lane(self.seed, CALLS_LANE);
        self.held.clear();
        self.state.fill(State::NEW);
        self.missed = false;
        self.health = Health::default();
        self.inner.start(now)
    }

    fn write(&mut self, now: Time, writes: &[(ChannelId, Value)]) -> Result<(), BoardError> {
        self.disturb_call(Call::Write)?;
        self.reachable(writes.iter().map(|(channel, _)| *channel), now)?;
        self.inner.write(now, writes)
    }

    fn poll(&mut self, now: Time, out: &mut Vec<BoardEvent>) -> Result<(), BoardError> {
        self.disturb_call(Call::Read)?;
        let outcome = self.collect(now);
        while let Some((from, event)) = self.held.front().copied() {
            if from > now {
                break;
            }
            self.held.pop_front();
            out.push(event);
        }
        self.confess(now, out);
        outcome
    }

    fn next_event(&self) -> Option<Time> {
        let held = self.held.front().map(|(from, _)| *from);
        self.inner.next_event().into_iter().chain(held).chain(self.next_back()).min()
    }

    fn reported_by(&self, at: Time) -> Time {
        let held = self.held.iter().filter(|(_, event)| event.earliest() <= at).map(|(from, _)| *from);
        held.chain([self.inner.reported_by(at)]).max().unwrap_or(at)
    }

    fn safe(&mut self, now: Time) -> Result<(), BoardError> {
        self.inner.safe(now)
    }

    fn health(&self) -> Health {
        let inner = self.inner.health();
        Health {
            lost: inner.lost + self.health.lost,
            dropped: inner.dropped + self.health.dropped,
            failed_calls: inner.failed_calls + self.health.failed_calls,
            ..inner
        }
    }

    fn pulse_outputs(&mut self) -> Option<&mut dyn PulseOutputs> {
        if self.inner.pulse_outputs().is_some() { Some(self) } else { None }
    }

    fn faults_mut(&mut self) -> Option<&mut dyn FaultInjection> {
        if self.inner.faults().is_some() { Some(self) } else { None }
    }
}

impl<B: Board> PulseOutputs for Faulty<B> {
    fn emit(&mut self, now: Time, channel: ChannelId, emission: &Emission) -> Result<(), BoardError> {
        self.disturb_call(Call::Write)?;
        self.reachable([channel], now)?;
        self.inner.emit(now, channel, emission)
    }
}

impl<B: Board> FaultInjection for Faulty<B> {
    fn inject(&mut self, now: Time, fault: Fault) -> Result<(), BoardError> {
        self.disturb_call(Call::Configure)?;
        self.inner.inject(now, fault)
    }

    fn clear_faults(&mut self, now: Time, channel: ChannelId) -> Result<(), BoardError> {
        self.disturb_call(Call::Configure)?;
        self.inner.clear_faults(now, channel)
    }

    fn fault_switching_time(&self, channel: ChannelId) -> Span {
        self.inner.fault_switching_time(channel)
    }

    fn fault_settled_at(&self, channel: ChannelId) -> Option<When> {
        self.inner.fault_settled_at(channel)
    }
}
