//! The end of the scan: it takes requests, reports events and leaves snapshots, and never waits for anybody.
//!
//! Only a rig whose time clients lead waits: for what they ask, and for room where they do not take what it reports.

use super::queues::{
    ObservedSource, OrderOutcome, ScanCommand, ScanCommandError, ScanEnd, ScanEvent, ScanRequest,
};
use super::snapshot::{LineCounts, Snapshot};
use control::PlanEvent;
use controller::{JITTER_BORDERS, ProbeId};
use drivers::{BoardContext, BusEvent, ChannelId, LossReason};
use host::{Bell, HostInstant};
use signal::{SerialErrors, Span, Time, Value, When};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// From one snapshot to the next.
const EVERY: Span = Span::from_millis(50);

/// The longest that a rig that is led waits at a stretch, so that an interrupt is seen: nanoseconds.
const GLANCE: Span = Span::from_millis(50);

/// Wishes that are taken at once: the scan goes on however fast clients ask.
const AT_ONCE: u32 = 32;

/// No source.
const NONE: u32 = u32::MAX;

/// What was last seen of a channel.
#[derive(Clone, Copy, Debug)]
struct LastSeen {
    at: When,
    value: Value,
    /// Under which number changes are reported.
    source: u32,
}

/// The end of the scan.
#[derive(Debug)]
pub struct ScanPort {
    ends: ScanEnd,
    bell: Arc<Bell>,
    /// Up to where time may go; [`Time::MAX`] where nobody leads it.
    until: Time,
    led: bool,
    /// The order that waits for time to pass.
    advancing: Option<u64>,
    /// Wishes that were taken since the scan went on last.
    taken: u32,
    /// Waits that end later than this are overruns.
    late: Span,
    interrupt: &'static AtomicBool,
    /// What is watched, by source.
    watched: Vec<Option<(ObservedSource, ProbeId)>>,
    /// The source of each probe.
    probes: Vec<u32>,
    channels: Vec<LastSeen>,
    /// The next snapshot in the making: counts go there.
    now: Snapshot,
    next: Time,
    /// Something may be otherwise than in the last snapshot of a rig whose time stands still.
    stale: bool,
    /// What the executor is for that serves it.
    role: ExecutorRole,
    /// The rig's time at the beginning of the executor's.
    base: Span,
    /// The host's time when the rig began, in nanoseconds.
    began: Option<HostInstant>,
    /// The last instant that was reported.
    last: Time,
    /// A plan was asked for, and the controller makes room for it.
    leaves: bool,
    aborted: bool,
}

/// What an executor is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExecutorRole {
    /// It keeps a controller running.
    Rig,
    /// It runs a case.
    Case,
}

/// What a port is made with.
#[derive(Clone, Copy, Debug)]
pub struct PortLimits {
    /// Sources that there can ever be.
    pub sources: usize,
    /// Those that can be watched at once.
    pub watches: usize,
    /// Clients lead the time.
    pub led: bool,
    /// How late the rig may be.
    pub late: Span,
    /// Ends every wait for clients: the end of the rig waits for none.
    pub interrupt: &'static AtomicBool,
}

impl ScanPort {
    pub(crate) fn new(ends: ScanEnd, bell: Arc<Bell>, snapshot: Snapshot, room: PortLimits) -> ScanPort {
        let unseen = LastSeen { at: When::exactly(Time::ZERO), value: Value::Unknown, source: NONE };
        ScanPort {
            ends,
            bell,
            until: if room.led { Time::ZERO } else { Time::MAX },
            led: room.led,
            advancing: None,
            taken: 0,
            late: room.late,
            interrupt: room.interrupt,
            watched: vec![None; room.sources],
            probes: vec![NONE; room.watches],
            channels: vec![unseen; snapshot.lines.len()],
            now: snapshot,
            next: Time::ZERO,
            stale: true,
            role: ExecutorRole::Rig,
            base: Span::ZERO,
            began: None,
            last: Time::ZERO,
            leaves: false,
            aborted: false,
        }
    }

    /// The bell that clients ring. One of a board is that which ends the waits of its clock.
    pub fn bell(surroundings: Option<&BoardContext>) -> Arc<Bell> {
        surroundings.map_or_else(Arc::default, |surroundings| surroundings.bell.clone())
    }

    /// Probes that may be watched at once.
    pub(crate) fn watches(&self) -> usize {
        self.probes.len()
    }

    /// Tasks that a snapshot has.
    pub(crate) fn tasks(&self) -> usize {
        self.now.tasks.len()
    }

    /// An executor begins at its time 0. What was watched before is to be watched again in its controller.
    pub(crate) fn begin(&mut self, role: ExecutorRole, mut watch: impl FnMut(ObservedSource) -> ProbeId) {
        let now = HostInstant::now();
        let began = *self.began.get_or_insert(now);
        self.base = if self.led { self.last - Time::ZERO } else { now - began };
        (self.role, self.next) = (role, Time::ZERO);
        self.until = if self.led && role == ExecutorRole::Rig { Time::ZERO } else { Time::MAX };
        for seen in &mut self.channels {
            (seen.at, seen.value) = (When::exactly(Time::ZERO), Value::Unknown);
        }
        self.probes.fill(NONE);
        for source in 0..self.watched.len() {
            if let Some((of, _)) = self.watched[source] {
                let probe = watch(of);
                self.follow(source as u32, of, probe);
            }
        }
    }

    /// What the executor that it serves is for.
    pub(crate) const fn role(&self) -> ExecutorRole {
        self.role
    }

    /// An instant of the executor in the rig's own time.
    #[inline]
    fn own(&self, at: Time) -> Time {
        at.saturating_add(self.base)
    }

    /// The same of an uncertain instant.
    #[inline]
    fn own_when(&self, at: When) -> When {
        When { earliest: self.own(at.earliest), latest: self.own(at.latest) }
    }

    /// The controller is to make room for a plan.
    pub(crate) fn make_room(&mut self) {
        self.leaves = true;
    }

    /// Whether it made room for a plan, since this was last asked.
    pub(crate) fn take_plan_request(&mut self) -> bool {
        self.aborted = false;
        std::mem::take(&mut self.leaves)
    }

    /// The plan is to end.
    pub(crate) fn abort(&mut self) {
        self.aborted = true;
    }

    /// Whether it is.
    pub(crate) const fn is_aborted(&self) -> bool {
        self.aborted
    }

    /// No plan is run any more.
    pub(crate) fn ends_plan(&mut self) {
        self.aborted = false;
    }

    /// Answers between two cases. TRUE where the plan is to end.
    pub(crate) fn between(&mut self) -> bool {
        while let Some(request) = self.next_request() {
            match request {
                ScanRequest::Watch(source, of) => {
                    if let Some(watched) = self.watched.get_mut(source as usize) {
                        *watched = Some((of, ProbeId(u32::MAX)));
                    }
                }
                ScanRequest::Unwatch(source) => {
                    self.unfollow(source);
                }
                ScanRequest::Command(ticket, ScanCommand::Abort) => {
                    self.abort();
                    self.answer(ticket, Ok(None));
                }
                ScanRequest::Command(ticket, _) => self.answer(ticket, Err(ScanCommandError::PlanRuns)),
            }
        }
        self.served();
        self.aborted
    }

    /// Reports an event of a plan.
    pub(crate) fn plan(&mut self, event: PlanEvent) {
        self.push(ScanEvent::Plan(Box::new(event)));
    }

    /// A step of the case began, or is done.
    pub(crate) fn step(&mut self, step: usize, at: Span, done: bool) {
        self.push(ScanEvent::Step(step as u32, at, done));
    }

    /// The next request, if it may be taken before the scan goes on. A rig that is led carries out nothing while time passes
    /// for somebody.
    #[inline]
    pub(crate) fn next_request(&mut self) -> Option<ScanRequest> {
        if self.advancing.is_some() || self.taken >= AT_ONCE {
            return None;
        }
        let request = self.ends.requests.pop().ok()?;
        self.taken += 1;
        self.stale = true;
        Some(request)
    }

    /// The scan goes on. If more is asked for than was taken, its next wait ends at once.
    #[inline]
    pub(crate) fn served(&mut self) {
        self.taken = 0;
        if self.advancing.is_none() && !self.ends.requests.is_empty() {
            self.bell.ring();
        }
    }

    /// Whether clients lead the time.
    pub(crate) const fn is_led(&self) -> bool {
        self.led
    }

    /// Time passes, or stood still since the last snapshot.
    #[inline]
    pub(crate) fn passes(&mut self) {
        self.stale = true;
    }

    /// Whether something may have changed since the last snapshot of a rig whose time stands still.
    pub(crate) const fn is_stale(&self) -> bool {
        self.stale
    }

    /// Up to where time may go.
    #[inline]
    pub(crate) const fn until(&self) -> Time {
        self.until
    }

    /// Time may go on by so much from `now`; FALSE where nobody leads it.
    pub(crate) fn advance(&mut self, ticket: u64, now: Time, by: Span) -> bool {
        if self.led {
            let by = if by.is_negative() { Span::ZERO } else { by };
            self.until = self.until.max(now).saturating_add(by);
            self.advancing = Some(ticket);
        }
        self.led
    }

    /// Whether the time that clients asked for has passed, where they lead it.
    #[inline]
    pub(crate) fn stands_still(&self, now: Time) -> bool {
        self.led && self.role == ExecutorRole::Rig && now >= self.until
    }

    /// All of the time that was asked for has passed: what it brought is reported.
    pub(crate) fn arrive(&mut self) {
        if let Some(ticket) = self.advancing.take() {
            self.answer(ticket, Ok(None));
        }
    }

    /// Waits for whoever leads the time.
    pub(crate) fn wait(&self) {
        self.bell.wait_until(HostInstant::now() + GLANCE);
    }

    /// From now on changes of a source are reported.
    pub(crate) fn follow(&mut self, source: u32, of: ObservedSource, probe: ProbeId) {
        let Some(watched) = self.watched.get_mut(source as usize) else { return };
        *watched = Some((of, probe));
        match of {
            ObservedSource::Channel(channel) => {
                if let Some(seen) = self.channels.get_mut(usize::from(channel.0)) {
                    seen.source = source;
                }
            }
            ObservedSource::Inside(_) => {
                if let Some(place) = self.probes.get_mut(probe.0 as usize) {
                    *place = source;
                }
            }
        }
    }

    /// Changes of a source are no longer reported; hands back the probe that is to be watched no more.
    pub(crate) fn unfollow(&mut self, source: u32) -> Option<ProbeId> {
        let (of, probe) = self.watched.get_mut(source as usize)?.take()?;
        match of {
            ObservedSource::Channel(channel) => {
                if let Some(seen) = self.channels.get_mut(usize::from(channel.0)) {
                    seen.source = NONE;
                }
                None
            }
            ObservedSource::Inside(_) => {
                if let Some(place) = self.probes.get_mut(probe.0 as usize) {
                    *place = NONE;
                }
                Some(probe)
            }
        }
    }

    /// What was last seen of a channel.
    pub(crate) fn seen(&self, channel: ChannelId) -> (When, Value) {
        let seen = self.channels.get(usize::from(channel.0));
        seen.map_or((When::exactly(Time::ZERO), Value::Unknown), |seen| (seen.at, seen.value))
    }

    /// Reports the value of a source.
    #[inline]
    pub(crate) fn change(&mut self, source: u32, at: When, value: Value) {
        self.push(ScanEvent::Change(source, self.own_when(at), value));
    }

    /// An observed probe changed.
    #[inline]
    pub(crate) fn probe(&mut self, probe: ProbeId, at: When, value: Value) {
        let source = self.probes.get(probe.0 as usize).copied().unwrap_or(NONE);
        if source != NONE {
            self.change(source, at, value);
        }
    }

    /// A channel changed.
    #[inline]
    pub(crate) fn channel(&mut self, channel: ChannelId, at: When, value: Value, lost: Option<LossReason>) {
        let place = usize::from(channel.0);
        let (Some(seen), Some(line)) = (self.channels.get_mut(place), self.now.lines.get_mut(place)) else {
            return;
        };
        match (seen.value, value) {
            (Value::Bool(false), Value::Bool(true)) => line.rising += 1,
            (Value::Bool(true), Value::Bool(false)) => line.falling += 1,
            _ => {}
        }
        line.lost = lost;
        let news = seen.value != value;
        (seen.at, seen.value) = (at, value);
        let source = seen.source;
        if news && source != NONE {
            self.change(source, at, value);
        }
    }

    /// Something was on a bus, or became of it.
    pub(crate) fn bus(&mut self, event: &BusEvent) {
        let Some(traffic) = self.now.buses.get_mut(usize::from(event.bus().0)) else { return };
        match *event {
            BusEvent::CanFrame { bus, at, frame, own } => {
                *(if own { &mut traffic.sent } else { &mut traffic.received }) += 1;
                let at = self.own(at.latest);
                self.push(ScanEvent::Frame(bus, at, frame, own));
            }
            BusEvent::SerialMessage { bus, mut message, own } => {
                let SerialErrors { parity, framing, damaged, breaks, overruns } = message.errors;
                let errors = [parity, framing, damaged, breaks, overruns].map(u64::from);
                if own {
                    traffic.sent += message.data().len() as u64;
                } else {
                    traffic.received += message.data().len() as u64;
                    traffic.errors += errors.iter().sum::<u64>();
                }
                (message.first, message.last) = (self.own_when(message.first), self.own_when(message.last));
                self.push(ScanEvent::SerialMessage(bus, message, own));
            }
            BusEvent::State { state, .. } => traffic.state = state,
            BusEvent::Error { .. } => traffic.errors += 1,
            BusEvent::Dropped { count, .. } => traffic.dropped += u64::from(count),
            BusEvent::Lost { reason, .. } => traffic.lost = Some(reason),
            BusEvent::Returned { .. } => traffic.lost = None,
        }
    }

    /// A line of the log.
    pub(crate) fn log(&mut self, at: Time, text: &str) {
        let at = self.own(at);
        self.push(ScanEvent::Log(at, text.to_owned()));
    }

    /// A wait ended so much later than it was to.
    #[inline]
    pub(crate) fn woke(&mut self, late: Span) {
        self.now.wakes[JITTER_BORDERS.partition_point(|border| *border < late.as_nanos())] += 1;
        self.now.overruns += u64::from(late > self.late);
    }

    /// What an order came to. There is room for every order that can be under way.
    pub(crate) fn answer(&mut self, ticket: u64, outcome: OrderOutcome) {
        if self.ends.outcomes.push((ticket, outcome)).is_err() {
            self.now.untold += 1;
        }
    }

    #[inline]
    fn push(&mut self, event: ScanEvent) {
        let Err(rtrb::PushError::Full(event)) = self.ends.events.push(event) else { return };
        if self.led {
            self.push_waiting(event);
        } else {
            self.now.untold += 1;
        }
    }

    /// Time that is led can wait until somebody listens.
    #[cold]
    fn push_waiting(&mut self, mut event: ScanEvent) {
        while self.may_wait() {
            self.wait();
            match self.ends.events.push(event) {
                Ok(()) => return,
                Err(rtrb::PushError::Full(back)) => event = back,
            }
        }
        self.now.untold += 1;
    }

    /// Whether somebody is there to be waited for.
    fn may_wait(&self) -> bool {
        !self.ends.events.is_abandoned() && !self.interrupt.load(Ordering::Relaxed)
    }

    /// Whether it is time for a snapshot.
    #[inline]
    pub(crate) fn is_due(&self, now: Time) -> bool {
        now >= self.next
    }

    /// Leaves a snapshot; `fill` adds what the port does not know. Whoever asks for one while nobody took those before
    /// gets an older one.
    pub(crate) fn publish(&mut self, now: Time, fill: impl FnOnce(&mut Snapshot)) {
        self.next = now.saturating_add(EVERY);
        self.stale = false;
        let mut empty = self.ends.empty.pop();
        while self.led && empty.is_err() && self.may_wait() {
            self.wait();
            empty = self.ends.empty.pop();
        }
        let Ok(mut snapshot) = empty else { return };
        fill(&mut self.now);
        self.last = self.last.max(self.own(now));
        self.now.at = self.last;
        if let Some(front) = &mut self.now.front {
            front.since = front.since.saturating_add(self.base);
        }
        (*snapshot).clone_from(&self.now);
        // As many as there are find room.
        let _ = self.ends.full.push(snapshot);
    }

    /// A device that was lost is back: what its channel has is reported next.
    pub(crate) fn regained(&mut self, channel: ChannelId) {
        if let Some(line) = self.now.lines.get_mut(usize::from(channel.0)) {
            *line = LineCounts { lost: None, ..*line };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::queues::queues;
    use super::*;
    use signal::SerialMessage;

    static NEVER: AtomicBool = AtomicBool::new(false);

    /// In stepped time the scan waits for room, but not once the rig is to end.
    #[test]
    fn the_end_of_a_rig_waits_for_no_client_that_leads_its_time() {
        static INTERRUPT: AtomicBool = AtomicBool::new(false);
        let snapshot = Snapshot::new(0, 0, 0);
        let (inside, outside) = queues(&snapshot);
        let room = PortLimits { sources: 1, watches: 1, led: true, late: Span::ZERO, interrupt: &INTERRUPT };
        let mut port = ScanPort::new(inside, Arc::default(), snapshot, room);
        let reports = std::thread::spawn(move || {
            let mut number = 0_i64;
            while port.now.untold == 0 {
                number += 1;
                port.push(ScanEvent::Log(Time::from_nanos(number), String::new()));
            }
            // Snapshots find no room, either.
            (0..10).for_each(|_| port.publish(Time::from_nanos(number), |_| {}));
        });
        while outside.events.slots() < outside.events.buffer().capacity() {
            std::thread::yield_now();
        }
        assert!(!reports.is_finished());
        INTERRUPT.store(true, Ordering::Relaxed);
        reports.join().expect("it ends though nobody takes what it reports");
        drop(outside);
    }

    /// A client reads one time, however many cases ran before.
    #[test]
    fn both_instants_of_a_message_are_in_the_time_of_the_rig() {
        let snapshot = Snapshot::new(0, 0, 1);
        let (inside, mut outside) = queues(&snapshot);
        let room = PortLimits { sources: 1, watches: 1, led: false, late: Span::ZERO, interrupt: &NEVER };
        let mut port = ScanPort::new(inside, Arc::default(), snapshot, room);
        port.base = Span::from_nanos(1_000);
        let when = |from, to| When::within(Time::from_nanos(from), Time::from_nanos(to));
        let message = SerialMessage::of(when(1, 3), when(5, 8), &[7]);
        port.bus(&BusEvent::SerialMessage { bus: drivers::BusId(0), message, own: false });
        let Ok(ScanEvent::SerialMessage(_, seen, false)) = outside.events.pop() else { panic!("no message") };
        assert_eq!((seen.first, seen.last), (when(1_001, 1_003), when(1_005, 1_008)));
    }

    /// A client that asks faster than it is served takes turns with the scan, and is not forgotten.
    #[test]
    fn the_scan_goes_on_between_wishes_however_many_there_are() {
        let snapshot = Snapshot::new(0, 0, 0);
        let (inside, mut outside) = queues(&snapshot);
        let bell = Arc::<Bell>::default();
        let room = PortLimits { sources: 1, watches: 1, led: false, late: Span::ZERO, interrupt: &NEVER };
        let mut port = ScanPort::new(inside, bell.clone(), snapshot, room);
        let asked = AT_ONCE * 5 / 2;
        for ticket in 0..asked {
            outside.requests.push(ScanRequest::Command(ticket.into(), ScanCommand::ReleaseAll)).unwrap();
        }
        let mut turns = Vec::new();
        while turns.iter().sum::<u32>() < asked {
            let mut taken = 0;
            while port.next_request().is_some() {
                taken += 1;
            }
            turns.push(taken);
            port.served();
            assert_eq!(bell.has_rung(), turns.iter().sum::<u32>() < asked, "rung while more waits");
        }
        assert_eq!(turns, [AT_ONCE, AT_ONCE, AT_ONCE / 2]);
    }
}
