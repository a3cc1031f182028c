//! One serial line as the board follows it: what passed on it, what is to be sent, whether its port still answers.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use document::Diagnostic;
use host::{HostInstant, TimeBase};
use rtrb::{Consumer, Producer, RingBuffer};
use signal::{SerialOutput, SerialSettings, Span, Time, When};
use tokio::runtime::Builder;

use super::assembler::MessageTiming;
use super::device::{Event, SerialOrder, SerialReport, SerialThread, SharedPort};
use super::find::Identity;
use super::open::refused;
use super::{SerialPort, SerialSpec};
use crate::thread::{DeviceThread, PresenceChange, ends, not_started};
use crate::{BoardContext, BoardError, BusError, BusEvent, BusId, DeviceLimits, LossReason};

/// Messages that nobody took yet: some seconds of a busy line.
const REPORTS: usize = 1_024;

/// Outputs that wait for the thread.
const ORDERS: usize = 64;

/// A serial line at work. Dropping it ends its thread and closes its port.
#[derive(Debug)]
pub(super) struct SerialHandle {
    pub(super) bus: BusId,
    /// Its port, as messages name it.
    pub(super) device: String,
    settings: SerialSettings,
    message_gap: Span,
    shared: Arc<SharedPort>,
    orders: Producer<SerialOrder>,
    reports: Consumer<SerialReport>,
    /// The run under way.
    run: u64,
    /// What lies ahead of the last poll.
    pub(super) ahead: Option<Time>,
    /// Messages that were lost on their way since the start.
    pub(super) dropped: u64,
    thread: DeviceThread,
}

impl SerialHandle {
    /// Opens a port and sets it to work.
    ///
    /// # Errors
    /// Why it cannot be had, at its place in the board file.
    pub(super) fn open(
        file: &str,
        spec: &SerialSpec,
        limits: DeviceLimits,
        context: &BoardContext,
    ) -> Result<SerialHandle, Vec<Diagnostic>> {
        let cannot = |error: std::io::Error| not_started(file, "the thread of a serial line", &error);
        let runtime = Builder::new_current_thread().enable_io().build().map_err(cannot)?;
        let shared = Arc::<SharedPort>::default();
        let port = {
            let _inside = runtime.enter();
            SerialPort::watched(&spec.port, Arc::clone(&shared.in_call))
                .map_err(|error| vec![refused(&error).finding(file, spec.place.clone())])?
        };
        let (reporter, mut thread, reports) = ends(REPORTS, &context.bell, limits.unresponsive_after);
        let (orders, ordered) = RingBuffer::new(ORDERS);
        let device = SerialThread {
            spec: spec.port.clone(),
            identity: Identity::of(&spec.port.path),
            timing: MessageTiming::of(&spec.port.line, spec.message_gap),
            shared: Arc::clone(&shared),
            orders: ordered,
            reporter,
            reconnect: limits.reconnect,
            realtime: context.realtime,
            run: 0,
        };
        let path = &spec.port.path;
        let name = path.file_name().map_or_else(String::new, |name| name.display().to_string());
        thread.start(format!("serial {name}"), move || device.run(&runtime, port)).map_err(cannot)?;
        Ok(SerialHandle {
            bus: spec.bus,
            device: path.display().to_string(),
            settings: spec.port.line,
            message_gap: spec.message_gap,
            shared,
            orders,
            reports,
            run: 0,
            ahead: None,
            dropped: 0,
            thread,
        })
    }

    /// Until when an answer is due.
    fn due(&self) -> Option<HostInstant> {
        Some(self.shared.in_call.get()? + self.thread.limit())
    }

    /// Asks for a new run. The number of this request.
    pub(super) fn ask_start(&mut self) -> u64 {
        self.run = self.shared.run.fetch_add(1, Ordering::AcqRel) + 1;
        self.shared.latched.store(false, Ordering::Release);
        self.shared.ask()
    }

    /// Waits until the run has begun. FALSE where it has not by then, or the port is gone and is not opened again.
    pub(super) fn await_start(&mut self, request: u64, due: HostInstant, reconnect: bool) -> bool {
        let (shared, reports, run) = (&self.shared, &mut self.reports, self.run);
        let has_started = self.thread.await_start(due, reconnect, || {
            let heard = shared.heard.load(Ordering::Acquire) >= request;
            // What was before makes room.
            while heard && reports.peek().is_ok_and(|report| report.run != run) {
                let _ = reports.pop();
            }
            heard
        });
        if has_started {
            (self.ahead, self.dropped) = (None, 0);
        }
        has_started
    }

    /// What a start says that could not begin, and a send on a line that is lost.
    pub(super) fn loss(&self) -> BoardError {
        let (reason, since) = self.thread.lost_since(self.due());
        BoardError::BusLost { bus: self.bus, reason, since }
    }

    /// Nothing is sent from now on. The number of this request.
    pub(super) fn ask_safe(&mut self) -> u64 {
        self.shared.latched.store(true, Ordering::Release);
        self.shared.ask()
    }

    /// Waits until nothing is on its way to the port any more. FALSE where it is by then, as far as anybody knows.
    pub(super) fn await_safe(&self, request: u64, due: HostInstant) -> bool {
        while self.shared.heard.load(Ordering::Acquire) < request {
            if self.thread.is_gone() {
                return true;
            }
            if HostInstant::now() >= due {
                return false;
            }
            self.thread.wait(due);
        }
        true
    }

    /// Whether it carries bytes so.
    pub(super) fn has(&self, settings: &SerialSettings, message_gap: Span) -> bool {
        (&self.settings, self.message_gap) == (settings, message_gap)
    }

    /// Hands an output to the thread.
    pub(super) fn send(&mut self, output: &SerialOutput) -> Result<(), BoardError> {
        let order = SerialOrder::of(self.run, output).ok_or(BoardError::BadFrame(self.bus))?;
        if self.thread.is_gone() {
            return Err(self.loss());
        }
        self.orders.push(order).map_err(|_| BoardError::BusFull(self.bus))?;
        self.shared.wake.notify_one();
        Ok(())
    }

    /// Reports what happened up to now.
    pub(super) fn poll(&mut self, time: &TimeBase, now: Time, out: &mut Vec<BusEvent>) {
        let stamp = time.stamp(now);
        self.ahead = None;
        while let Ok(report) = self.reports.peek().copied() {
            let known = stamp_of(&report.event);
            if report.run == self.run && known > stamp {
                self.ahead = Some(time.at(known));
                break;
            }
            // It is the one that was looked at.
            let _ = self.reports.pop();
            if report.run == self.run {
                self.report(report.event, time, out);
            }
        }
        let bus = self.bus;
        let count = self.thread.take_overflow();
        if count > 0 {
            self.dropped += u64::from(count);
            out.push(BusEvent::Dropped { bus, at: now, count });
        }
        match self.thread.presence_change(self.due(), stamp) {
            Some(PresenceChange::Lost(reason)) => out.push(BusEvent::Lost { bus, at: now, reason }),
            Some(PresenceChange::Returned) => out.push(BusEvent::Returned { bus, at: now }),
            None => {}
        }
    }

    fn report(&mut self, event: Event, time: &TimeBase, out: &mut Vec<BusEvent>) {
        let bus = self.bus;
        let when = |(earliest, latest)| When::within(time.at(earliest), time.at(latest));
        match event {
            Event::Message { first, last, mut message, own } => {
                (message.first, message.last) = (when(first), when(last));
                out.push(BusEvent::SerialMessage { bus, message, own });
            }
            Event::NotSent { at } => {
                out.push(BusEvent::Error { bus, at: time.at(at), error: BusError::SendTimeout });
            }
            Event::Returned { at } => {
                let at = time.at(at);
                if self.thread.returns_unreported() {
                    out.push(BusEvent::Lost { bus, at, reason: LossReason::Gone });
                }
                out.push(BusEvent::Returned { bus, at });
            }
        }
    }

    /// When the port counts as unresponsive if its call does not end.
    pub(super) fn overdue(&self) -> Option<HostInstant> {
        self.thread.overdue(self.due())
    }

    /// Whether it was reported that the port is lost.
    pub(super) const fn is_lost(&self) -> bool {
        self.thread.is_lost()
    }

    /// Calls that failed since the start.
    pub(super) fn failed_calls(&self) -> u64 {
        self.thread.failed_calls()
    }
}

impl Drop for SerialHandle {
    fn drop(&mut self) {
        let shared = &self.shared;
        self.thread.end(|| shared.wake.notify_one(), || None);
    }
}

const fn stamp_of(event: &Event) -> HostInstant {
    match *event {
        Event::Message { last: (_, at), .. } | Event::NotSent { at } | Event::Returned { at } => at,
    }
}
