//! One bus as the board follows it: what was asked of it, what it reported, whether it still answers.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use host::{Bell, HostInstant, TimeBase};
use rtrb::{Consumer, Producer, RingBuffer};
use signal::{CanFrame, Span, Time, When};

use super::adapter::Adapter;
use super::device::CanThread;
use super::port::CanPort;
use super::shared::{CanReport, REPORTS, SharedCan, ThreadConfig};
use super::spec::CanBusSpec;
use super::wire::encode;
use crate::thread::{DeviceThread, PresenceChange, ends};
use crate::{BoardError, BusEvent, BusId, BusState, LossReason};

/// Frames on their way to the bus.
const TO_SEND: usize = 1_024;

/// The rig's part in a bus. Dropping it ends its thread.
#[derive(Debug)]
pub(super) struct Node {
    pub(super) spec: CanBusSpec,
    pub(super) shared: Arc<SharedCan>,
    frames: Producer<CanFrame>,
    pub(super) reports: Consumer<CanReport>,
    /// How long the end of the thread is waited for.
    patience: Span,
    /// What the thread had seen to when it was looked at last, and since when the rest was due.
    heard: u64,
    since: HostInstant,
    /// How the controller took part at the start, until it is reported.
    fresh: Option<BusState>,
    /// Frames of before the start waited for the bus then.
    waiting: bool,
    /// What lies ahead of the last poll.
    pub(super) ahead: Option<Time>,
    pub(super) dropped: u64,
    thread: DeviceThread,
}

impl Node {
    /// Sets an open interface to work.
    ///
    /// # Errors
    /// The machine has no room for its thread.
    pub(super) fn start(
        spec: CanBusSpec,
        adapter: Box<dyn Adapter>,
        port: Box<dyn CanPort>,
        bell: &Arc<Bell>,
        config: ThreadConfig,
    ) -> std::io::Result<Node> {
        let shared = Arc::new(SharedCan::new()?);
        let (frames, to_send) = RingBuffer::new(TO_SEND);
        let (reporter, mut thread, reports) = ends(REPORTS, bell, config.limit);
        let device = CanThread::new(adapter, port, shared.clone(), to_send, reporter, config);
        thread.start(format!("can {}", spec.interface), move || device.run(config.realtime))?;
        Ok(Node {
            spec,
            shared,
            frames,
            reports,
            patience: config.patience,
            heard: 0,
            since: HostInstant::BOOT,
            fresh: None,
            waiting: false,
            ahead: None,
            dropped: 0,
            thread,
        })
    }

    /// What a start says of an interface that is lost.
    pub(super) fn loss(&self) -> BoardError {
        let (reason, since) = self.thread.lost_since(self.due());
        BoardError::BusLost { bus: self.id(), reason, since }
    }

    /// Waits until the thread answers something, at most until then.
    pub(super) fn wait(&self, until: HostInstant) {
        self.thread.wait(until);
    }

    /// Whether it was reported that the interface is lost.
    pub(super) const fn is_lost(&self) -> bool {
        self.thread.is_lost()
    }

    /// Whether the start found the controller off its bus, or with frames of before.
    pub(super) fn is_behind(&self) -> bool {
        self.waiting || self.fresh == Some(BusState::BusOff)
    }

    fn id(&self) -> BusId {
        self.spec.bus
    }

    /// Asks for a beginning; its number.
    pub(super) fn ask_start(&mut self) -> u64 {
        self.shared.latched.store(true, Ordering::Release);
        let start = self.shared.starts.fetch_add(1, Ordering::AcqRel) + 1;
        self.shared.ask();
        start
    }

    /// Waits until the thread has begun again and the interface is there. FALSE where it is not in time.
    pub(super) fn await_start(&mut self, start: u64, due: HostInstant) -> bool {
        loop {
            while let Ok(report) = self.reports.pop() {
                let CanReport::Started { start: done, state, waiting } = report else { continue };
                if done != start {
                    continue;
                }
                if self.gone() {
                    return false;
                }
                (self.ahead, self.dropped) = (None, 0);
                self.since = HostInstant::now();
                self.waiting = waiting;
                self.fresh = Some(state).filter(|state| *state != BusState::ErrorActive);
                self.thread.begin();
                self.shared.latched.store(false, Ordering::Release);
                return true;
            }
            if HostInstant::now() >= due {
                return false;
            }
            self.thread.wait(due);
        }
    }

    /// Nothing is sent from now on. The number of what is asked.
    pub(super) fn ask_safe(&mut self) -> u64 {
        self.shared.latched.store(true, Ordering::Release);
        self.shared.ask()
    }

    /// Waits until nothing is on its way to the kernel any more.
    pub(super) fn await_safe(&self, asked: u64, due: HostInstant) -> bool {
        loop {
            if self.gone() || self.shared.heard.load(Ordering::Acquire) >= asked {
                return true;
            }
            if HostInstant::now() >= due {
                return false;
            }
            self.thread.wait(due);
        }
    }

    pub(super) fn gone(&self) -> bool {
        self.thread.is_gone()
    }

    /// Puts a frame into the queue.
    pub(super) fn send(&mut self, now: HostInstant, frame: &CanFrame) -> Result<(), BoardError> {
        let fits = encode(frame).is_some() && (!frame.fd || self.spec.data_bitrate.is_some());
        // The kernel filters what the rig sends as well, and then nobody would see it on the bus.
        if !fits || self.spec.listen_only || !self.spec.takes(frame) {
            return Err(BoardError::BadFrame(self.id()));
        }
        self.look(now);
        if !self.owing() {
            self.since = now;
        }
        self.frames.push(*frame).map_err(|_| BoardError::BusFull(self.id()))?;
        self.shared.ask();
        Ok(())
    }

    /// Looks at what the thread has seen to: whoever sees to something is not unresponsive.
    fn look(&mut self, now: HostInstant) {
        let heard = self.shared.heard.load(Ordering::Acquire);
        if heard != self.heard {
            (self.heard, self.since) = (heard, now);
        }
    }

    fn owing(&self) -> bool {
        self.shared.heard.load(Ordering::Acquire) < self.shared.asked.load(Ordering::Acquire)
    }

    /// Until when an answer is due.
    fn due(&self) -> Option<HostInstant> {
        let owing = Some(self.since).filter(|_| self.owing());
        let called = self.shared.in_call.get();
        let since = match (owing, called) {
            // The thread may be about to see what is asked; a call that lasts shows from when on it does not.
            (Some(owing), Some(called)) => owing.min(called),
            (owing, called) => owing.or(called)?,
        };
        Some(since + self.thread.limit())
    }

    /// When the interface counts as unresponsive if it does not answer.
    pub(super) fn overdue(&self) -> Option<HostInstant> {
        self.thread.overdue(self.due())
    }

    /// Reports what happened up to now.
    pub(super) fn poll(&mut self, time: &TimeBase, now: Time, out: &mut Vec<BusEvent>) {
        let bus = self.id();
        self.ahead = None;
        if let Some(state) = self.fresh.take() {
            // Before all that came since the start.
            let first = self.reports.peek().ok().map(stamp_of);
            let at = first.map_or(now, |first| time.at(first).min(now));
            out.push(BusEvent::State { bus, at, state });
        }
        let stamp = time.stamp(now);
        self.look(stamp);
        while let Ok(report) = self.reports.peek().copied() {
            let at = stamp_of(&report);
            if at > stamp {
                self.ahead = Some(time.at(at));
                break;
            }
            // It is the one that was looked at.
            let _ = self.reports.pop();
            let at = time.at(at);
            match report {
                CanReport::Frame { earliest, frame, own, .. } => {
                    let at = When::within(time.at(earliest), at);
                    out.push(BusEvent::CanFrame { bus, at, frame, own });
                }
                CanReport::State { state, .. } => out.push(BusEvent::State { bus, at, state }),
                CanReport::Error { error, .. } => out.push(BusEvent::Error { bus, at, error }),
                CanReport::Dropped { count, .. } => self.drop_some(at, count, out),
                CanReport::Returned { .. } => {
                    if self.thread.returns_unreported() {
                        out.push(BusEvent::Lost { bus, at, reason: LossReason::Gone });
                    }
                    out.push(BusEvent::Returned { bus, at });
                }
                // Was waited for.
                CanReport::Started { .. } => {}
            }
        }
        let count = self.thread.take_overflow();
        if count > 0 {
            self.drop_some(now, count, out);
        }
        match self.thread.presence_change(self.due(), stamp) {
            Some(PresenceChange::Lost(reason)) => out.push(BusEvent::Lost { bus, at: now, reason }),
            Some(PresenceChange::Returned) => out.push(BusEvent::Returned { bus, at: now }),
            None => {}
        }
    }

    fn drop_some(&mut self, at: Time, count: u32, out: &mut Vec<BusEvent>) {
        self.dropped += u64::from(count);
        out.push(BusEvent::Dropped { bus: self.id(), at, count });
    }

    /// Calls that failed since the start, frames that could not be sent among them.
    pub(super) fn failed(&self) -> u64 {
        self.thread.failed_calls()
    }
}

impl Drop for Node {
    fn drop(&mut self) {
        self.shared.latched.store(true, Ordering::Release);
        let (shared, due) = (&self.shared, HostInstant::now() + self.patience);
        self.thread.end(
            || {
                shared.ask();
            },
            || Some(due),
        );
    }
}

fn stamp_of(report: &CanReport) -> HostInstant {
    match *report {
        CanReport::Frame { latest, .. } => latest,
        CanReport::State { at, .. }
        | CanReport::Error { at, .. }
        | CanReport::Dropped { at, .. }
        | CanReport::Returned { at } => at,
        CanReport::Started { .. } => HostInstant::BOOT,
    }
}
