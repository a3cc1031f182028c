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
use rtrb::{Consumer, Producer, RingBuffer};
use rustix::io::Errno;
use signal::{Span, Time};

use crate::codes;
use crate::event_collector::EventCollector;
use crate::gone::is_gone;
use crate::{BoardError, BoardEvent, ChannelId, LossReason};

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
        told: false,
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
    /// There is something that the bell was not rung for.
    told: bool,
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

    /// Reports something. FALSE where it found no room, which the board will tell.
    pub(crate) fn report(&mut self, report: R) -> bool {
        self.told = true;
        let room = self.reports.push(report).is_ok();
        if !room {
            self.presence.unreported.fetch_add(1, Ordering::AcqRel);
        }
        room
    }

    /// Has the board look at what was reported since the last call.
    pub(crate) fn ring(&mut self) {
        if std::mem::take(&mut self.told) {
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

    /// A call failed. TRUE where the device is to be given up: it is not there any more, or has failed for too long.
    pub(crate) fn refused(&mut self, error: &io::Error) -> bool {
        let now = HostInstant::now();
        self.presence.failed.fetch_add(1, Ordering::AcqRel);
        self.told = true;
        let code = error.raw_os_error().unwrap_or(Errno::IO.raw_os_error());
        let since = *self.failing.get_or_insert(now);
        let gives_up = is_gone(code, &[]) || now - since > self.limit;
        if gives_up {
            self.failing = None;
            self.presence.gone_at.set(now);
            self.presence.gone.store(code, Ordering::Release);
            self.presence.answer.ring();
        }
        gives_up
    }

    /// The device is there again. Its board learns it by this report, behind all that was reported before.
    pub(crate) fn returned(&mut self, report: R) {
        self.presence.gone.store(0, Ordering::Release);
        self.report(report);
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

    /// Waits until the thread answers something, at most until then.
    pub(crate) fn wait(&self, until: HostInstant) {
        self.presence.answer.wait_until(until);
    }

    /// Whether the work with the device has ended.
    pub(crate) fn is_gone(&self) -> bool {
        self.presence.gone.load(Ordering::Acquire) != 0
    }

    /// Whether it was told that the device is lost.
    pub(crate) const fn is_lost(&self) -> bool {
        self.lost.is_some()
    }

    /// What a start says that gets nothing of the device, which owes an answer until `due`.
    pub(crate) fn loss(&self, channel: ChannelId, due: Option<HostInstant>) -> BoardError {
        let (reason, since) = match self.is_gone() {
            true => (LossReason::Gone, self.presence.gone_at.get()),
            // Its call began so long before it counts as one that hangs.
            false => (LossReason::Unresponsive, due.map(|due| due - self.limit)),
        };
        BoardError::Lost { channel, reason, since: since.map_or(Span::ZERO, HostInstant::elapsed) }
    }

    /// When the device counts as silent that owes an answer until `due`.
    pub(crate) fn overdue(&self, due: Option<HostInstant>) -> Option<HostInstant> {
        due.filter(|_| self.lost.is_none())
    }

    /// Tells whether a device of these channels still answers, which owes an answer until `due`. TRUE where
    /// it does again: then what is there now is to be reported.
    pub(crate) fn report_presence(
        &mut self,
        due: Option<HostInstant>,
        channels: impl Iterator<Item = ChannelId>,
        collector: &mut EventCollector<'_>,
    ) -> bool {
        let now = collector.time.stamp(collector.now);
        let reason = match self.lost {
            _ if self.is_gone() => Some(LossReason::Gone),
            // It says itself when it is there again.
            Some(LossReason::Gone) => return false,
            _ => due.is_some_and(|due| due < now).then_some(LossReason::Unresponsive),
        };
        if reason == self.lost {
            return false;
        }
        self.lost = reason;
        tell(reason, channels, collector.now, collector);
        reason.is_none()
    }

    /// Tells that a device of these channels is there again, even where it was not reported that it was gone.
    pub(crate) fn report_return(
        &mut self,
        at: Time,
        channels: impl Iterator<Item = ChannelId> + Clone,
        collector: &mut EventCollector<'_>,
    ) {
        if self.lost.take().is_none() {
            tell(Some(LossReason::Gone), channels.clone(), at, collector);
        }
        tell(None, channels, at, collector);
    }

    /// Tells what found no room.
    pub(crate) fn report_overflow(
        &self,
        channels: impl Iterator<Item = ChannelId>,
        collector: &mut EventCollector<'_>,
    ) {
        let unreported = self.presence.unreported.swap(0, Ordering::AcqRel);
        if unreported > 0 {
            let count = u32::try_from(unreported).unwrap_or(u32::MAX);
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

fn tell(
    lost: Option<LossReason>,
    channels: impl Iterator<Item = ChannelId>,
    at: Time,
    collector: &mut EventCollector<'_>,
) {
    for channel in channels {
        collector.tell(match lost {
            Some(reason) => BoardEvent::Lost { channel, at, reason },
            None => BoardEvent::Returned { channel, at },
        });
    }
}
