//! Real lines: time passes whether the executor is ready or not, and what it sees has happened already.
//!
//! While the application computes, it runs ahead of the clock by at most the horizon, so that its outputs can be
//! released at their modelled instants. While it does not, one wait lasts until the next thing is due, or until the
//! board rings.

use super::pacing::Pacing;
use super::{Executor, MOST_SIMULTANEOUS};
use crate::executor::rig_fault::RigFault;
use crate::subject::SubjectExt;
use controller::Terminal;
use drivers::{BoardEvent, ChannelId, Origin};
use guard::GuardError;
use signal::{Span, Time, Value, When};
use std::collections::VecDeque;

/// Most changes of inputs that wait for the modelled time to reach them: those of one late wake-up.
const MOST_PENDING: usize = 16_384;

/// Room for what the board reports at once, so that none is taken later.
const AT_ONCE: usize = 1024;

/// The longest that a wait lasts at a stretch, so that an interrupt is seen.
pub(super) const LONGEST_WAIT: Span = Span::from_millis(50);

/// A change of an input terminal that the modelled time has not reached yet.
#[derive(Clone, Copy, Debug)]
struct PendingInput {
    at: When,
    terminal: Terminal,
    what: InputChange,
}

/// What comes to an input terminal.
#[derive(Clone, Copy, Debug)]
pub(super) enum InputChange {
    /// A level, or a number in the unit of its channel.
    Value(Value),
    /// So many steps that hardware counted, below 0 backwards.
    Steps(i64),
}

/// When an input gets a change whose instant the modelled time has reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Arrival {
    /// Now.
    AtOnce,
    /// In its turn among those that the modelled time stops at.
    AtItsInstant,
}

/// What the executor keeps for real lines.
#[derive(Debug, Default)]
pub(super) struct RealLines {
    /// By their instants.
    pending: VecDeque<PendingInput>,
    /// When the wait for the next thing ended, while nothing has passed since.
    woke: Option<Time>,
    /// Until when the modelled time goes only from one seen change of an input to the next: the board was asked before it.
    ahead_until: Option<Time>,
    /// What the board reported then. The inputs have it; the trace and the steps get it when the modelled time is there.
    polled_ahead: Vec<BoardEvent>,
    /// The modelled time stops next at what was seen, and not at what the rig planned: it cannot have been there in time.
    is_seen: bool,
    /// How far each channel has counted, as far as it was reported.
    counts: Vec<i64>,
    /// How late the subject's last write of each channel was.
    lag: Vec<Span>,
    /// The worst of them.
    worst: Span,
    /// The instant of the subject's last write of each channel.
    wrote: Vec<Time>,
    /// How late what it wrote reached its lines at worst.
    late_outputs: Span,
    /// By how much what it wrote to each channel last may have come earlier, and whether that is on the line.
    early: Vec<(Span, bool)>,
}

impl RealLines {
    /// For so many channels of modelled lines, which nothing is late on.
    pub(super) fn modelled(channels: usize) -> RealLines {
        let early = vec![(Span::ZERO, true); channels];
        RealLines { counts: vec![0; channels], early, ..RealLines::default() }
    }

    /// For so many channels.
    pub(super) fn new(channels: usize) -> RealLines {
        RealLines {
            pending: VecDeque::with_capacity(MOST_PENDING),
            polled_ahead: Vec::with_capacity(AT_ONCE),
            lag: vec![Span::ZERO; channels],
            wrote: vec![Time::MAX; channels],
            ..RealLines::modelled(channels)
        }
    }

    /// When the next change of an input is due, or the trace and the steps are to get what was polled ahead.
    #[inline]
    pub(super) fn next(&self) -> Option<Time> {
        let Some(pending) = self.pending.front() else { return self.ahead_until };
        let at = pending.at.latest;
        Some(self.ahead_until.map_or(at, |until| at.min(until)))
    }

    /// The subject wrote a channel at this instant, or by so much earlier, and the rig was at the other one by then.
    pub(super) fn wrote(&mut self, channel: ChannelId, at: Time, actual: Time, early: Span) {
        let place = usize::from(channel.0);
        if let Some((known, reached)) = self.early.get_mut(place) {
            // What was written before and is still on its way has the wider one, too.
            *known = if std::mem::take(reached) { early } else { early.max(*known) };
        }
        if let (Some(lag), Some(wrote)) = (self.lag.get_mut(place), self.wrote.get_mut(place)) {
            *lag = actual - at;
            *wrote = at;
            self.worst = self.worst.max(*lag);
        }
    }

    /// What was written to a channel last is on its line.
    pub(super) fn reached(&mut self, channel: ChannelId, at: Time, origin: Origin) {
        if let (Origin::Write, Some((_, reached))) = (origin, self.early.get_mut(usize::from(channel.0))) {
            *reached = true;
        }
        if let (Origin::Write, Some(wrote)) = (origin, self.wrote.get(usize::from(channel.0))) {
            self.late_outputs = self.late_outputs.max(at - *wrote);
        }
    }

    /// How late what the subject wrote reached its lines at worst.
    pub(super) fn late_outputs(&self) -> Span {
        self.late_outputs
    }
}

impl Executor<'_> {
    /// Up to where the modelled time may go now on its way to what is due. On real lines it waits for time to bring that,
    /// where nothing is to be computed before.
    #[inline]
    pub(super) fn approach(&mut self, due: Time) -> Result<Time, RigFault> {
        match self.pacing {
            Pacing::EventDriven => Ok(due),
            Pacing::WallClock => self.wait_for(due),
        }
    }

    fn wait_for(&mut self, due: Time) -> Result<Time, RigFault> {
        let silent = self.beat()?;
        if self.parts.subject.is_computing() {
            let now = self.parts.clock.now();
            return self.poll_ahead(now, due.min(now.max(self.now).saturating_add(self.limits.horizon)));
        }
        let due = due.min(self.actual.max(self.now).saturating_add(silent));
        let woke = self.parts.clock.wait(due);
        self.lines.woke = Some(woke);
        self.poll_ahead(woke, due.min(woke).max(self.now))
    }

    /// Before the modelled time goes on to `reached`: inputs that the board has seen change up to `now` do so at their own
    /// instants on the way, since two edges that are seen at once are a pulse. Hands back where the modelled time may go first.
    fn poll_ahead(&mut self, now: Time, reached: Time) -> Result<Time, RigFault> {
        if reached > self.now && self.lines.ahead_until.is_none() && self.parts.clock.rung() {
            let polled = self.parts.board.poll(now.max(self.board_time()), &mut self.lines.polled_ahead);
            polled.map_err(|error| RigFault::Board { at: now, error })?;
            for place in 0..self.lines.polled_ahead.len() {
                let event = self.lines.polled_ahead[place];
                self.lead_to_inputs(&event, Arrival::AtItsInstant);
            }
            self.lines.ahead_until = Some(reached);
        }
        let seen = self.lines.next().map(|seen| seen.max(self.now)).filter(|seen| *seen <= reached);
        self.lines.is_seen = seen.is_some();
        Ok(seen.unwrap_or(reached))
    }

    /// On wires: the board has something to report, or has reported what is due at `due`.
    pub(super) fn board_has_news(&mut self, due: Time) -> bool {
        self.parts.clock.rung() || self.lines.ahead_until.is_some_and(|until| until <= due)
    }

    /// What [`Executor::poll_ahead`] found goes to the trace and to the steps.
    pub(super) fn see_polled_ahead(&mut self) {
        self.lines.ahead_until = None;
        let mut events = std::mem::take(&mut self.lines.polled_ahead);
        events.iter().for_each(|event| self.see(event));
        events.clear();
        self.lines.polled_ahead = events;
    }

    /// A sign of life; hands back how long the executor may wait until the next.
    pub(super) fn beat(&mut self) -> Result<Span, RigFault> {
        let Some(heartbeat) = self.parts.heartbeat else { return Ok(LONGEST_WAIT) };
        heartbeat.beat().map_err(|error| self.unguarded(&error))?;
        Ok(heartbeat.every().min(LONGEST_WAIT))
    }

    /// The guard does not do its part.
    pub(super) fn unguarded(&self, error: &GuardError) -> RigFault {
        RigFault::Guard { at: self.now, why: error.to_string() }
    }

    /// Whether the application is through before anything is due, with nothing to be released: the next wait is for
    /// what comes then, and not for the instant that it ran ahead to.
    pub(super) fn has_computed(&mut self, reached: Time) -> bool {
        let through = self.lines.woke.is_none()
            && self.buffers.effects.list.is_empty()
            && !self.parts.subject.is_computing();
        if through && reached > self.now {
            (self.now, self.same) = (reached, 0);
            return true;
        }
        false
    }

    /// Time passes to `to`: waits for it, and takes note of how late the wait ended.
    #[inline]
    pub(super) fn pass(&mut self, to: Time) -> Result<(), RigFault> {
        if to > self.now {
            self.same = 0;
            self.now = to;
        } else {
            self.same += 1;
            if self.same > MOST_SIMULTANEOUS {
                return Err(RigFault::Simultaneous { at: self.now });
            }
        }
        let future = to > self.actual;
        self.actual = self.reach(to).max(self.actual);
        if std::mem::take(&mut self.lines.is_seen) {
            return Ok(());
        }
        let late = self.actual - to;
        if future && let Some(live) = &mut self.live {
            live.woke(late);
        }
        if future && let Some(wakes) = &mut self.wakes {
            wakes.note(to, late);
        }
        if late > Span::ZERO {
            self.parts.recorder.note_late(late);
            if late > self.limits.late {
                self.report.overruns += 1;
                self.report.fault.get_or_insert(RigFault::Late { at: to, late, limit: self.limits.late });
            }
        }
        Ok(())
    }

    /// When the wait for `to` ended, waiting for it if nobody did yet.
    fn reach(&mut self, to: Time) -> Time {
        match self.lines.woke.take() {
            Some(woke) if woke >= to => woke,
            _ => self.parts.clock.wait_until(to),
        }
    }

    /// An input terminal changes at `at`, which the modelled time may not have reached.
    pub(super) fn input(
        &mut self,
        channel: ChannelId,
        at: When,
        terminal: Terminal,
        what: InputChange,
        arrival: Arrival,
    ) {
        let is_due = arrival == Arrival::AtOnce && at.latest <= self.now;
        if self.pacing == Pacing::EventDriven || is_due {
            self.arrive(self.now.max(at.latest), at, terminal, what);
            return;
        }
        if self.lines.pending.len() >= MOST_PENDING {
            self.report.fault.get_or_insert(RigFault::Dropped { at: at.latest, channel, count: 1 });
            return;
        }
        let place = self.lines.pending.partition_point(|pending| pending.at.latest <= at.latest);
        self.lines.pending.insert(place, PendingInput { at, terminal, what });
    }

    /// The inputs that are due.
    pub(super) fn feed(&mut self) {
        while let Some(pending) =
            self.lines.pending.front().copied().filter(|first| first.at.latest <= self.now)
        {
            self.lines.pending.pop_front();
            self.arrive(self.now, pending.at, pending.terminal, pending.what);
        }
    }

    fn arrive(&mut self, now: Time, at: When, terminal: Terminal, what: InputChange) {
        match what {
            InputChange::Value(value) => {
                self.parts.subject.set_input(now, at, terminal, value, &mut self.buffers.effects)
            }
            InputChange::Steps(steps) => {
                if let Some(input) = terminal.embedded_input() {
                    self.parts.subject.count(now, input, steps);
                }
            }
        }
    }

    /// By how much a channel has counted on that has counted so far now.
    pub(super) fn counted_on(&mut self, channel: ChannelId, count: i64) -> i64 {
        let last = self.lines.counts.get_mut(usize::from(channel.0));
        last.map_or(0, |last| count.saturating_sub(std::mem::replace(last, count)))
    }

    /// When something that the board saw happened. What a late rig did to a wire, it should have done earlier; what a
    /// controller does on a wire may be late as well.
    pub(super) fn seen_by_board(&self, at: When, channel: ChannelId, origin: Origin) -> When {
        let seen = self.widened(at, channel, origin);
        // What the board stamped after the end is of the teardown, however late the rig was.
        // Behind a delay it may have come before.
        let earliest = at.earliest.saturating_add(self.parts.wiring.delay_of(channel).0);
        match self.ended.filter(|(ended, _)| earliest >= *ended) {
            Some((_, latest)) => {
                let earliest = seen.earliest.max(latest);
                When::within(earliest, seen.latest.max(earliest))
            }
            None => seen,
        }
    }

    fn widened(&self, at: When, channel: ChannelId, origin: Origin) -> When {
        let place = usize::from(channel.0);
        let of_stage = self.lines.early.get(place).filter(|_| origin == Origin::Write);
        let (earliest, latest) = self.parts.wiring.delay_of(channel);
        let early = self.parts.wiring.early.get(place).copied().unwrap_or(Span::ZERO)
            + of_stage.map_or(Span::ZERO, |(early, _)| *early);
        let at = When::within(
            at.earliest.saturating_add(earliest).saturating_add(-early),
            at.latest.saturating_add(latest),
        );
        if self.parts.clock.is_exact() {
            return at;
        }
        if self.pacing == Pacing::EventDriven {
            return When::within(at.earliest, at.latest.max(self.actual));
        }
        // A controller that is not played by the rig was never late because of it.
        if !self.parts.subject.is_model() {
            return at;
        }
        let late = match origin {
            Origin::Write => self.lines.lag.get(usize::from(channel.0)).copied().unwrap_or(Span::ZERO),
            _ => self.lines.worst,
        };
        When::within(at.earliest.saturating_add(-(late + self.limits.horizon)), at.latest)
    }
}
