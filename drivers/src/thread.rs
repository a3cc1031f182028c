//! The thread of a device, and what its board makes of it: whether the device is there, whether it answers.
//!
//! The thread holds the [`Reporter`], the board the [`DeviceThread`]. Neither waits for the other, but for a start, a safe
//! state and the end.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicI32, AtomicU64, Ordering};
use std::thread::JoinHandle;

use document::Diagnostic;
use host::{AtomicInstant, Bell, HostInstant};
use rtrb::{Consumer, Producer, PushError, RingBuffer};
use rustix::io::Errno;
use signal::{Span, Time};

use crate::codes;
use crate::event_collector::EventCollector;
use crate::gone::is_gone;
use crate::{BoardError, BoardEvent, ChannelId, LossReason};

/// What became of a device, for the events of its channels or its bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PresenceChange {
    /// It is lost.
    Lost(LossReason),
    /// It answers again.
    Returned,
}

/// What board and thread share.
#[derive(Debug, Default)]
struct Presence {
    /// The error that ended the work with the device; 0 for none.
    gone: AtomicI32,
    /// When that was.
    gone_at: AtomicInstant,
    /// Calls that failed.
    failed: AtomicU64,
    /// Reports that found no room.
    unreported: AtomicU64,
    stop: AtomicBool,
    ended: AtomicBool,
    /// Wakes whoever waits for the thread.
    answer: Bell,
}

/// The two ends: the thread is not started yet, and its reports find so much room. Whoever reads them hears `bell`. A call
/// may last so long, and calls may go on to fail so long, before the device counts as gone.
pub(crate) fn ends<R>(
    room: usize,
    bell: &Arc<Bell>,
    limit: Span,
) -> (Reporter<R>, DeviceThread, Consumer<R>) {
    let presence = Arc::<Presence>::default();
    let (reports, reported) = RingBuffer::new(room);
    let reporter = Reporter {
        presence: presence.clone(),
        reports,
        bell: bell.clone(),
        kept: None,
        unrung: false,
        limit,
        failing: None,
    };
    (reporter, DeviceThread { presence, limit, lost: None, failed: 0, thread: None }, reported)
}

/// The thread's end.
pub(crate) struct Reporter<R> {
    presence: Arc<Presence>,
    reports: Producer<R>,
    bell: Arc<Bell>,
    /// A report that must not be lost, until there is room for it.
    kept: Option<R>,
    /// There is something that the bell was not rung for.
    unrung: bool,
    limit: Span,
    /// Since when calls fail.
    failing: Option<HostInstant>,
}

impl<R> Reporter<R> {
    /// How long a call may last.
    pub(crate) const fn limit(&self) -> Span {
        self.limit
    }

    /// Whether the thread is to end.
    pub(crate) fn is_stopped(&self) -> bool {
        self.presence.stop.load(Ordering::Acquire)
    }

    /// The thread is about to end.
    pub(crate) fn end(&self) {
        self.presence.ended.store(true, Ordering::Release);
        self.presence.answer.ring();
    }

    /// Reports something. FALSE where it found no room, which the board will report.
    pub(crate) fn report(&mut self, report: R) -> bool {
        self.unrung = true;
        // Nothing comes before what was kept.
        let room = self.hand_on_kept() && self.reports.push(report).is_ok();
        if !room {
            self.presence.unreported.fetch_add(1, Ordering::AcqRel);
        }
        room
    }

    /// Reports something that must not be lost, such as the answer to a start: where there is no room it waits, and what is
    /// reported meanwhile is lost in its place. Ends the wait of a board that waits for its device.
    pub(crate) fn insist(&mut self, report: R) {
        self.kept = Some(report);
        self.hand_on_kept();
    }

    /// Whether a report waits for room.
    pub(crate) const fn keeps_report(&self) -> bool {
        self.kept.is_some()
    }

    /// TRUE where nothing is kept any more.
    fn hand_on_kept(&mut self) -> bool {
        let Some(report) = self.kept.take() else { return true };
        match self.reports.push(report) {
            Ok(()) => {
                self.unrung = true;
                self.presence.answer.ring();
            }
            Err(PushError::Full(report)) => self.kept = Some(report),
        }
        self.kept.is_none()
    }

    /// Has the board look at what was reported since the last call.
    pub(crate) fn ring(&mut self) {
        self.hand_on_kept();
        if std::mem::take(&mut self.unrung) {
            self.bell.ring();
        }
    }

    /// Ends the wait of a board that waits for its device.
    pub(crate) fn answer(&self) {
        self.presence.answer.ring();
    }

    /// A call succeeded, or a new run begins.
    pub(crate) fn works(&mut self) {
        self.failing = None;
    }

    /// A call failed, which says nothing of whether the device is there.
    pub(crate) fn failed(&mut self) {
        self.presence.failed.fetch_add(1, Ordering::AcqRel);
        self.unrung = true;
    }

    /// A call failed. TRUE where the device is to be given up: it is not there any more, or has failed for too long.
    pub(crate) fn refused(&mut self, error: &io::Error) -> bool {
        let now = HostInstant::now();
        tracing::debug!(%error, "a call on the device failed");
        let since = *self.failing.get_or_insert(now);
        let gives_up = is_gone(code_of(error), &[]) || now - since > self.limit;
        if gives_up {
            self.gives_up(error)
        } else {
            self.failed()
        }
        gives_up
    }

    /// A call failed, and the device is given up: nothing is asked of it until it is opened again.
    pub(crate) fn gives_up(&mut self, error: &io::Error) {
        self.failed();
        self.mark_gone(code_of(error));
    }

    /// The device is not there any more, as is known without a call that failed.
    pub(crate) fn mark_gone(&mut self, code: i32) {
        (self.failing, self.unrung) = (None, true);
        tracing::info!(code, "the device is given up");
        self.presence.gone_at.set(HostInstant::now());
        self.presence.gone.store(code, Ordering::Release);
        self.presence.answer.ring();
    }

    /// The device is there again. Its board learns it by this report, after all that was reported before.
    pub(crate) fn returned(&mut self, report: R) {
        tracing::info!("the device is there again");
        self.presence.gone.store(0, Ordering::Release);
        self.insist(report);
    }
}

/// The board's end.
#[derive(Debug)]
pub(crate) struct DeviceThread {
    presence: Arc<Presence>,
    limit: Span,
    lost: Option<LossReason>,
    /// Calls that had failed when the run began.
    failed: u64,
    thread: Option<JoinHandle<()>>,
}

impl DeviceThread {
    /// Starts the thread.
    ///
    /// # Errors
    /// The machine has no room for it.
    pub(crate) fn start(&mut self, name: String, run: impl FnOnce() + Send + 'static) -> io::Result<()> {
        self.thread = Some(std::thread::Builder::new().name(name).spawn(run)?);
        Ok(())
    }

    /// How long a call may last.
    pub(crate) const fn limit(&self) -> Span {
        self.limit
    }

    /// A run begins: what was before is forgotten.
    pub(crate) fn begin(&mut self) {
        self.lost = None;
        self.failed = self.presence.failed.load(Ordering::Acquire);
        self.presence.unreported.store(0, Ordering::Release);
    }

    /// Waits until the thread has answered a start, which `answered` sees. FALSE where it has not by then, or the device is gone
    /// and is not opened again.
    pub(crate) fn await_start(
        &mut self,
        due: HostInstant,
        reconnect: bool,
        mut answered: impl FnMut() -> bool,
    ) -> bool {
        loop {
            if answered() {
                self.begin();
                return true;
            }
            if self.is_gone() && !reconnect || HostInstant::now() >= due {
                return false;
            }
            self.wait(due);
        }
    }

    /// Waits until the thread answers something, at most until then.
    pub(crate) fn wait(&self, until: HostInstant) {
        self.presence.answer.wait_until(until);
    }

    /// Whether the work with the device has ended.
    pub(crate) fn is_gone(&self) -> bool {
        self.presence.gone.load(Ordering::Acquire) != 0
    }

    /// Whether it was reported that the device is lost.
    pub(crate) const fn is_lost(&self) -> bool {
        self.lost.is_some()
    }

    /// Why nothing is to be had of the device, whose answer is due by `due`, and for how long.
    pub(crate) fn lost_since(&self, due: Option<HostInstant>) -> (LossReason, Span) {
        let (reason, since) = match self.is_gone() {
            true => (LossReason::Gone, self.presence.gone_at.get()),
            // Its call began so long before it counts as one that hangs.
            false => (LossReason::Unresponsive, due.map(|due| due - self.limit)),
        };
        (reason, since.map_or(Span::ZERO, HostInstant::elapsed))
    }

    /// What a start says that gets nothing of the device.
    pub(crate) fn loss(&self, channel: ChannelId, due: Option<HostInstant>) -> BoardError {
        let (reason, since) = self.lost_since(due);
        BoardError::Lost { channel, reason, since }
    }

    /// When the device counts as unresponsive whose answer is due by `due`.
    pub(crate) fn overdue(&self, due: Option<HostInstant>) -> Option<HostInstant> {
        due.filter(|_| self.lost.is_none())
    }

    /// What became by `now` of a device whose answer is due by `due`; `None` where that was reported.
    pub(crate) fn presence_change(
        &mut self,
        due: Option<HostInstant>,
        now: HostInstant,
    ) -> Option<PresenceChange> {
        let reason = match self.lost {
            _ if self.is_gone() => Some(LossReason::Gone),
            // It says itself when it is there again.
            Some(LossReason::Gone) => return None,
            _ => due.is_some_and(|due| due < now).then_some(LossReason::Unresponsive),
        };
        if reason == self.lost {
            return None;
        }
        self.lost = reason;
        Some(reason.map_or(PresenceChange::Returned, PresenceChange::Lost))
    }

    /// The device reported that it is there again. TRUE where it was not reported that it was gone.
    pub(crate) fn returns_unreported(&mut self) -> bool {
        self.lost.take().is_none()
    }

    /// Reports what became of a device of these channels, whose answer is due by `due`. TRUE where it answers again: then
    /// what is there now is to be reported.
    pub(crate) fn report_presence(
        &mut self,
        due: Option<HostInstant>,
        channels: impl Iterator<Item = ChannelId>,
        collector: &mut EventCollector<'_>,
    ) -> bool {
        let now = collector.time.stamp(collector.now);
        let Some(change) = self.presence_change(due, now) else { return false };
        report(change, channels, collector.now, collector);
        change == PresenceChange::Returned
    }

    /// Reports that a device of these channels is there again, even where it was not reported that it was gone.
    pub(crate) fn report_return(
        &mut self,
        at: Time,
        channels: impl Iterator<Item = ChannelId> + Clone,
        collector: &mut EventCollector<'_>,
    ) {
        if self.returns_unreported() {
            report(PresenceChange::Lost(LossReason::Gone), channels.clone(), at, collector);
        }
        report(PresenceChange::Returned, channels, at, collector);
    }

    /// How many reports found no room since the last call.
    pub(crate) fn take_overflow(&self) -> u32 {
        let unreported = self.presence.unreported.swap(0, Ordering::AcqRel);
        u32::try_from(unreported).unwrap_or(u32::MAX)
    }

    /// Reports what found no room.
    pub(crate) fn report_overflow(
        &self,
        channels: impl Iterator<Item = ChannelId>,
        collector: &mut EventCollector<'_>,
    ) {
        let count = self.take_overflow();
        if count > 0 {
            channels.for_each(|channel| collector.dropped(channel, collector.now, count));
        }
    }

    /// Calls that failed since the start.
    pub(crate) fn failed_calls(&self) -> u64 {
        self.presence.failed.load(Ordering::Acquire) - self.failed
    }

    /// Ends the thread, which `wake` wakes. One that is inside a call that hangs is left to it: it is waited for as long as
    /// a call may last, and until the instant that `due` gives.
    pub(crate) fn end(&mut self, wake: impl FnOnce(), due: impl Fn() -> Option<HostInstant>) {
        self.presence.stop.store(true, Ordering::Release);
        wake();
        let least = HostInstant::now() + self.limit;
        while !self.presence.ended.load(Ordering::Acquire) {
            let due = due().map_or(least, |due| due.max(least));
            if HostInstant::now() >= due {
                return;
            }
            self.presence.answer.wait_until(due);
        }
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// What it means that the machine does not start a thread for a board: `what` says which.
pub(crate) fn not_started(file: &str, what: &str, error: &io::Error) -> Vec<Diagnostic> {
    let message = format!("{what} cannot be started: {error}");
    let help = "the machine has no room for another thread or file: see `ulimit -u` and `ulimit -n`";
    vec![Diagnostic::error(codes::HOST, message).at(file.to_owned(), 0..0, "").help(help)]
}

/// The kernel's number of an error.
fn code_of(error: &io::Error) -> i32 {
    error.raw_os_error().unwrap_or(Errno::IO.raw_os_error())
}

fn report(
    change: PresenceChange,
    channels: impl Iterator<Item = ChannelId>,
    at: Time,
    collector: &mut EventCollector<'_>,
) {
    for channel in channels {
        collector.report(match change {
            PresenceChange::Lost(reason) => BoardEvent::Lost { channel, at, reason },
            PresenceChange::Returned => BoardEvent::Returned { channel, at },
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMIT: Span = Span::from_millis(100);

    fn at(nanos: i64) -> HostInstant {
        HostInstant::from_nanos(nanos)
    }

    #[test]
    fn a_call_that_lasts_too_long_is_a_loss_until_it_ends() {
        let (_reporter, mut thread, _) = ends::<()>(1, &Arc::default(), LIMIT);
        assert_eq!(thread.presence_change(None, at(10)), None);
        let due = Some(at(50));
        assert_eq!((thread.overdue(due), thread.presence_change(due, at(50))), (due, None));
        let lost = Some(PresenceChange::Lost(LossReason::Unresponsive));
        assert_eq!(thread.presence_change(due, at(51)), lost);
        assert_eq!((thread.overdue(due), thread.presence_change(due, at(52))), (None, None));
        assert_eq!(thread.presence_change(None, at(53)), Some(PresenceChange::Returned));
    }

    #[test]
    fn a_loss_is_reported_though_the_device_is_back_before_anybody_looked() {
        let (mut reporter, mut thread, mut reports) = ends(1, &Arc::default(), LIMIT);
        let gone = io::Error::from(Errno::NODEV);
        assert!(reporter.refused(&gone) && thread.is_gone());
        reporter.returned(7);
        assert_eq!(reports.pop(), Ok(7));
        assert!(thread.returns_unreported());
        assert_eq!(thread.presence_change(None, at(1)), None);
        // Seen this time, it is reported once.
        assert!(reporter.refused(&gone));
        assert_eq!(thread.presence_change(None, at(2)), Some(PresenceChange::Lost(LossReason::Gone)));
        assert_eq!(thread.presence_change(None, at(3)), None);
        reporter.returned(8);
        // Its report comes first.
        assert_eq!(thread.presence_change(None, at(4)), None);
        assert!(!thread.returns_unreported());
        assert_eq!(thread.failed_calls(), 2);
    }

    #[test]
    fn what_must_not_be_lost_waits_for_room_and_comes_before_what_is_reported_later() {
        let (mut reporter, thread, mut reports) = ends(1, &Arc::default(), LIMIT);
        assert!(reporter.report(1));
        reporter.insist(2);
        assert!(reporter.keeps_report() && !reporter.report(3));
        assert_eq!(reports.pop(), Ok(1));
        reporter.ring();
        assert_eq!((reports.pop(), reporter.keeps_report()), (Ok(2), false));
        assert!(reporter.report(4));
        assert_eq!((reports.pop(), thread.take_overflow()), (Ok(4), 1));
    }

    #[test]
    fn calls_that_fail_for_a_while_do_not_lose_the_device_and_those_that_go_on_to_fail_do() {
        let (mut reporter, thread, _) = ends::<()>(1, &Arc::default(), Span::ZERO);
        let busy = io::Error::from(Errno::BUSY);
        assert!(!reporter.refused(&busy));
        let first = HostInstant::now();
        while first.elapsed() == Span::ZERO {}
        assert!(reporter.refused(&busy) && thread.is_gone());
        assert_eq!(thread.lost_since(None).0, LossReason::Gone);
    }
}
