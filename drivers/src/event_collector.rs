//! What a poll of a board has to say, and in which order.

use host::{HostInstant, TimeBase};
use rtrb::Consumer;
use signal::{Time, Value, When};

use crate::{BoardEvent, ChannelId, Origin};

/// The events of one poll as they are gathered.
#[derive(Debug)]
pub struct EventCollector<'a> {
    out: &'a mut Vec<BoardEvent>,
    first: usize,
    pub(crate) time: &'a TimeBase,
    pub(crate) now: Time,
    /// Events that were lost.
    pub(crate) dropped: u64,
    /// The next event that lies ahead of this poll.
    pub(crate) ahead: Option<Time>,
    /// The newest event so far, and whether one after it is older.
    newest: Time,
    disorder: bool,
}

impl<'a> EventCollector<'a> {
    /// Appends to `out` what happened up to `now`.
    pub(crate) fn new(out: &'a mut Vec<BoardEvent>, time: &'a TimeBase, now: Time) -> EventCollector<'a> {
        let first = out.len();
        let newest = Time::from_nanos(i64::MIN);
        EventCollector { out, first, time, now, dropped: 0, ahead: None, newest, disorder: false }
    }

    pub(crate) fn report(&mut self, event: BoardEvent) {
        let latest = event.latest();
        self.disorder |= latest < self.newest;
        self.newest = self.newest.max(latest);
        self.out.push(event);
    }

    pub(crate) fn changed(&mut self, channel: ChannelId, at: When, high: bool, origin: Origin) {
        self.report(BoardEvent::Changed { channel, at, value: Value::Bool(high), origin });
    }

    pub(crate) fn dropped(&mut self, channel: ChannelId, at: Time, count: u32) {
        if count > 0 {
            self.dropped += u64::from(count);
            self.report(BoardEvent::Dropped { channel, at, count });
        }
    }

    /// Something with this stamp waits; it may lie ahead of this poll.
    pub(crate) fn ahead(&mut self, stamp: HostInstant) {
        let at = self.time.at(stamp);
        if at > self.now {
            self.ahead = Some(self.ahead.map_or(at, |other| other.min(at)));
        }
    }

    /// The next report that a device made up to this poll.
    pub(crate) fn next<R: Copy>(
        &mut self,
        reports: &mut Consumer<R>,
        stamp: impl Fn(&R) -> HostInstant,
    ) -> Option<R> {
        let report = *reports.peek().ok()?;
        let stamp = stamp(&report);
        if stamp > self.time.stamp(self.now) {
            self.ahead(stamp);
            return None;
        }
        // It is the one that was looked at.
        let _ = reports.pop();
        Some(report)
    }

    /// There is more to report than one poll does.
    pub(crate) fn goes_on(&mut self) {
        self.ahead = Some(self.now);
    }

    /// Oldest first, in place and without allocation; events of one instant keep their order. They are in order as they
    /// come, but for those of several chips.
    pub(crate) fn sort(&mut self) {
        if !self.disorder {
            return;
        }
        let events = &mut self.out[self.first..];
        for at in 1..events.len() {
            let mut place = at;
            while place > 0 && events[place - 1].latest() > events[place].latest() {
                events.swap(place - 1, place);
                place -= 1;
            }
        }
    }
}

/// Puts what several devices reported in order, in place and without allocation; events of one instant keep
/// their order.
pub(crate) fn sort_by<E: Copy>(events: &mut [E], latest: impl Fn(&E) -> Time) {
    for at in 1..events.len() {
        let mut place = at;
        while place > 0 && latest(&events[place - 1]) > latest(&events[place]) {
            events.swap(place - 1, place);
            place -= 1;
        }
    }
}
