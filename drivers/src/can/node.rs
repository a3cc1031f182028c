//! One bus as the board follows it: what was asked of it, what it told, whether it still answers.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use host::{HostInstant, TimeBase};
use signal::{CanFrame, Span, Time, When};

use super::running::Running;
use super::shared::{Report, Shared};
use super::spec::CanBusSpec;
use super::wire::encode;
use crate::{BoardError, BusEvent, BusId, BusState, LossReason};

/// The rig's part in a bus.
#[derive(Debug)]
pub(super) struct Node {
    pub(super) spec: CanBusSpec,
    pub(super) shared: Arc<Shared>,
    running: Running,
    /// How long a call may last.
    limit: Span,
    /// What the thread had seen to when it was looked at last, and since when it owes the rest.
    heard: u64,
    owes: HostInstant,
    pub(super) lost: Option<LossReason>,
    /// How the controller took part at the start, until it is told.
    fresh: Option<BusState>,
    /// Frames of before the start waited for the bus then.
    waiting: bool,
    /// What lies ahead of the last poll.
    pub(super) ahead: Option<Time>,
    pub(super) dropped: u64,
    /// Calls that had failed when the run began.
    failed: u64,
}

impl Node {
    pub(super) fn new(spec: CanBusSpec, running: Running, limit: Span) -> Node {
        Node {
            spec,
            shared: running.shared.clone(),
            running,
            limit,
            heard: 0,
            owes: HostInstant::BOOT,
            lost: None,
            fresh: None,
            waiting: false,
            ahead: None,
            dropped: 0,
            failed: 0,
        }
    }

    /// What a start says of an interface that is lost.
    pub(super) fn is_lost(&self) -> BoardError {
        let now = HostInstant::now();
        let (reason, since) = match self.gone() {
            true => (LossReason::Gone, self.shared.gone_since.get().unwrap_or(now)),
            false => (LossReason::Unresponsive, self.overdue().map_or(now, |due| due - self.limit)),
        };
        BoardError::BusLost { bus: self.id(), reason, since: (now - since).max(Span::ZERO) }
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

    /// Waits until the thread has begun anew and the interface is there. FALSE where it is not in time.
    pub(super) fn await_start(&mut self, start: u64, due: HostInstant) -> bool {
        loop {
            while let Ok(report) = self.running.reports.pop() {
                let Report::Started { start: done, state, waiting } = report else { continue };
                if done != start {
                    continue;
                }
                if self.gone() {
                    return false;
                }
                (self.lost, self.ahead, self.dropped) = (None, None, 0);
                self.owes = HostInstant::now();
                self.waiting = waiting;
                self.fresh = Some(state).filter(|state| *state != BusState::ErrorActive);
                self.failed = self.shared.failed.load(Ordering::Acquire);
                self.shared.spilled.store(0, Ordering::Release);
                self.shared.latched.store(false, Ordering::Release);
                return true;
            }
            if HostInstant::now() >= due {
                return false;
            }
            self.shared.answer.wait_until(due);
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
            self.shared.answer.wait_until(due);
        }
    }

    pub(super) fn gone(&self) -> bool {
        self.shared.gone.load(Ordering::Acquire)
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
            self.owes = now;
        }
        self.running.frames.push(*frame).map_err(|_| BoardError::BusFull(self.id()))?;
        self.shared.ask();
        Ok(())
    }

    /// Looks at what the thread has seen to: whoever sees to something is not silent.
    fn look(&mut self, now: HostInstant) {
        let heard = self.shared.heard.load(Ordering::Acquire);
        if heard != self.heard {
            (self.heard, self.owes) = (heard, now);
        }
    }

    fn owing(&self) -> bool {
        self.shared.heard.load(Ordering::Acquire) < self.shared.asked.load(Ordering::Acquire)
    }

    /// When the interface counts as silent if it does not answer.
    pub(super) fn overdue(&self) -> Option<HostInstant> {
        if self.lost.is_some() {
            return None;
        }
        let owes = Some(self.owes).filter(|_| self.owing());
        let called = self.shared.in_call.get();
        let since = match (owes, called) {
            // The thread may be about to see what is asked; a call that lasts tells from when on it does not.
            (Some(owes), Some(called)) => owes.min(called),
            (owes, called) => owes.or(called)?,
        };
        Some(since + self.limit)
    }

    /// Tells what happened up to now.
    pub(super) fn poll(&mut self, time: &TimeBase, now: Time, out: &mut Vec<BusEvent>) {
        let bus = self.id();
        self.ahead = None;
        if let Some(state) = self.fresh.take() {
            // Before all that came since the start.
            let first = self.running.reports.peek().ok().map(stamp_of);
            let at = first.map_or(now, |first| time.at(first).min(now));
            out.push(BusEvent::State { bus, at, state });
        }
        let stamp = time.stamp(now);
        self.look(stamp);
        while let Ok(report) = self.running.reports.peek() {
            let report = *report;
            let at = stamp_of(&report);
            if at > stamp {
                self.ahead = Some(time.at(at));
                break;
            }
            // It is the one that was looked at.
            let _ = self.running.reports.pop();
            let at = time.at(at);
            match report {
                Report::Frame { earliest, frame, own, .. } => {
                    let at = When::within(time.at(earliest), at);
                    out.push(BusEvent::CanFrame { bus, at, frame, own });
                }
                Report::State { state, .. } => out.push(BusEvent::State { bus, at, state }),
                Report::Error { error, .. } => out.push(BusEvent::Error { bus, at, error }),
                Report::Dropped { count, .. } => self.drop_some(at, count, out),
                Report::Lost { .. } => {
                    self.lost = Some(LossReason::Gone);
                    out.push(BusEvent::Lost { bus, at, reason: LossReason::Gone });
                }
                Report::Returned { .. } => {
                    self.lost = None;
                    out.push(BusEvent::Returned { bus, at });
                }
                // Was waited for.
                Report::Started { .. } => {}
            }
        }
        if self.shared.spilled.load(Ordering::Relaxed) > 0 {
            let count = self.shared.spilled.swap(0, Ordering::AcqRel);
            self.drop_some(now, u32::try_from(count).unwrap_or(u32::MAX), out);
        }
        self.answers(stamp, now, out);
    }

    fn drop_some(&mut self, at: Time, count: u32, out: &mut Vec<BusEvent>) {
        self.dropped += u64::from(count);
        out.push(BusEvent::Dropped { bus: self.id(), at, count });
    }

    /// Whether the thread still answers.
    fn answers(&mut self, stamp: HostInstant, at: Time, out: &mut Vec<BusEvent>) {
        let bus = self.id();
        match self.lost {
            None if self.overdue().is_some_and(|due| due < stamp) => {
                self.lost = Some(LossReason::Unresponsive);
                out.push(BusEvent::Lost { bus, at, reason: LossReason::Unresponsive });
            }
            Some(LossReason::Unresponsive) if !self.owing() && self.shared.in_call.get().is_none() => {
                self.lost = None;
                out.push(BusEvent::Returned { bus, at });
            }
            _ => {}
        }
    }

    /// Calls that failed since the start.
    pub(super) fn failed(&self) -> u64 {
        self.shared.failed.load(Ordering::Acquire) - self.failed
    }
}

fn stamp_of(report: &Report) -> HostInstant {
    match *report {
        Report::Frame { latest, .. } => latest,
        Report::State { at, .. }
        | Report::Error { at, .. }
        | Report::Dropped { at, .. }
        | Report::Lost { at }
        | Report::Returned { at } => at,
        Report::Started { .. } => HostInstant::BOOT,
    }
}
