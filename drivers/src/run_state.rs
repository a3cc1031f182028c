//! How far a run of a board of real devices has come, and what such a board answers for channels that it does not drive.

use host::{HostInstant, TimeBase};
use signal::{Span, Time, Value};

use crate::event_collector::EventCollector;
use crate::{BoardError, Channel, ChannelId};

/// How long a start waits for a device at least: nothing runs yet that it could hold up, and threads are new.
pub(crate) const START: Span = Span::from_secs(2);

/// The account of a run.
#[derive(Debug, Default)]
pub(crate) struct RunState {
    started: bool,
    latched: bool,
    /// The start, until what there was then was reported.
    fresh: Option<Time>,
    last: Time,
    ahead: Option<Time>,
    dropped: u64,
}

impl RunState {
    /// A start is asked for: there is no run until it has succeeded.
    pub(crate) fn end(&mut self) {
        self.started = false;
    }

    /// It has.
    pub(crate) fn begin(&mut self, now: Time) {
        *self = RunState { started: true, last: now, ..RunState::default() };
    }

    /// What there is at the start is still to be reported.
    pub(crate) fn start_unreported(&mut self) {
        self.fresh = Some(self.last);
    }

    /// Comes to the instant of a call.
    ///
    /// # Errors
    /// [`BoardError::NotStarted`], [`BoardError::Backwards`].
    pub(crate) fn come_to(&mut self, now: Time) -> Result<(), BoardError> {
        if !self.started {
            return Err(BoardError::NotStarted);
        }
        if now < self.last {
            return Err(BoardError::Backwards { now, last: self.last });
        }
        self.last = now;
        Ok(())
    }

    /// The same for a call that drives.
    ///
    /// # Errors
    /// Those of [`RunState::come_to`], and [`BoardError::Latched`].
    pub(crate) fn drive_at(&mut self, now: Time) -> Result<(), BoardError> {
        self.come_to(now)?;
        if self.latched { Err(BoardError::Latched) } else { Ok(()) }
    }

    /// Nothing is driven from now on, until the next start.
    pub(crate) fn latch(&mut self, now: Time) {
        self.latched = true;
        self.last = self.last.max(now);
    }

    pub(crate) const fn is_latched(&self) -> bool {
        self.latched
    }

    /// The start, once: what there was then is to be reported.
    pub(crate) fn take_fresh(&mut self) -> Option<Time> {
        self.fresh.take()
    }

    /// A poll has reported everything.
    pub(crate) fn polled(&mut self, mut collector: EventCollector<'_>) {
        self.dropped += collector.dropped;
        self.ahead = collector.ahead;
        collector.sort();
    }

    /// The next of what a poll found that lies ahead of it.
    pub(crate) fn lies_ahead(&mut self, ahead: Option<Time>) {
        self.ahead = ahead;
    }

    /// What lies ahead of the last poll, and when the first device counts as lost whose answer is due by one of these
    /// instants.
    pub(crate) fn next_event(
        &self,
        time: &TimeBase,
        deadlines: impl Iterator<Item = HostInstant>,
    ) -> Option<Time> {
        if !self.started {
            return None;
        }
        let unresponsive = deadlines.min().map(|stamp| time.at(stamp + Span::from_nanos(1)));
        [self.fresh, self.ahead, unresponsive].into_iter().flatten().min()
    }

    /// Events that were lost.
    pub(crate) const fn dropped(&self) -> u64 {
        self.dropped
    }
}

/// Whether there is such a channel.
///
/// # Errors
/// [`BoardError::NoChannel`].
pub(crate) fn known(channels: &[Channel], channel: ChannelId) -> Result<(), BoardError> {
    if usize::from(channel.0) < channels.len() { Ok(()) } else { Err(BoardError::NoChannel(channel)) }
}

/// What a board says to writes that drives nothing.
///
/// # Errors
/// [`BoardError::NotDriven`], [`BoardError::NoChannel`]; none where there is nothing to be written.
pub(crate) fn drives_none(channels: &[Channel], writes: &[(ChannelId, Value)]) -> Result<(), BoardError> {
    match writes.first() {
        Some((channel, _)) => known(channels, *channel).and(Err(BoardError::NotDriven(*channel))),
        None => Ok(()),
    }
}
