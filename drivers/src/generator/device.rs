//! The thread that talks to a generator: the only one whose calls may last.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use host::{AtomicInstant, Bell, HostInstant, Realtime, ThreadRole};
use rtrb::Consumer;
use signal::Span;

use super::{Generator, SentPulses};
use crate::device_board::Reopen;
use crate::thread::Reporter;

/// What is asked of an output.
#[derive(Clone, Debug)]
pub(super) enum GeneratorOrder {
    Level(bool),
    Square { period: Span, high: Span },
    Pulses(Arc<[Span]>),
}

/// An order on its way.
#[derive(Clone, Debug)]
pub(super) struct NumberedOrder {
    /// Rising from order to order of a device.
    pub(super) number: u64,
    pub(super) output: u8,
    /// Orders of an epoch that is over are not carried out.
    pub(super) epoch: u64,
    pub(super) order: GeneratorOrder,
}

/// What the device did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum GeneratorReport {
    /// The pulses of an order were sent.
    Sent { number: u64, sent: SentPulses },
    /// An order was not carried out: it was not wanted any more, or failed.
    Dropped { number: u64, output: u8, at: HostInstant },
    /// It was gone and is there again, at rest.
    Returned { at: HostInstant },
}

/// What board and thread share.
#[derive(Debug, Default)]
pub(super) struct SharedGenerator {
    /// The epoch of the orders that are to be carried out.
    pub(super) epoch: AtomicU64,
    /// Times that rest was asked for, and the last of them that was carried out.
    pub(super) rests: AtomicU64,
    pub(super) rested: AtomicU64,
    /// When a call under way, or an order not looked at yet, counts as one that hangs.
    pub(super) due: AtomicInstant,
    /// Wakes the thread.
    pub(super) orders: Bell,
}

impl SharedGenerator {
    /// Asks for rest, after which no order given before counts. The number of this request.
    pub(super) fn ask_rest(&self) -> u64 {
        // The order matters: whoever sees the request sees the epoch.
        self.epoch.fetch_add(1, Ordering::AcqRel);
        let request = self.rests.fetch_add(1, Ordering::AcqRel) + 1;
        self.orders.ring();
        request
    }
}

/// The thread's side of a generator.
pub(super) struct GeneratorThread {
    pub(super) generator: Option<Box<dyn Generator>>,
    /// Opens it guarded as before.
    pub(super) reopen: Reopen<dyn Generator>,
    pub(super) shared: Arc<SharedGenerator>,
    pub(super) asked: Consumer<NumberedOrder>,
    /// Its limit is beside what a call emits, and for how long the device may go without being looked at.
    pub(super) reporter: Reporter<GeneratorReport>,
    /// A device that was gone is opened again.
    pub(super) reconnect: bool,
    /// The request for rest that was carried out.
    pub(super) rested: u64,
    /// When the device is looked at next.
    pub(super) look: HostInstant,
}

impl GeneratorThread {
    /// The thread.
    pub(super) fn run(mut self, realtime: Realtime) {
        // A refusal is reported once for all threads, by whoever set up the run.
        let _ = realtime.enter(ThreadRole::Devices);
        loop {
            // What is asked before the stop is seen after it.
            let stop = self.reporter.is_stopped();
            self.turn();
            self.reporter.ring();
            if stop {
                break;
            }
            self.shared.orders.wait_until(self.look);
        }
        drop(self.generator.take());
        self.reporter.end();
    }

    /// Carries out what is asked, and looks whether the device is there if it is time.
    fn turn(&mut self) {
        loop {
            let rests = self.shared.rests.load(Ordering::Acquire);
            if rests != self.rested && self.call(Span::ZERO, |generator| generator.rest()).is_some() {
                self.rested = rests;
                self.shared.rested.store(rests, Ordering::Release);
                self.reporter.answer();
            }
            let Ok(asked) = self.asked.pop() else { break };
            self.carry_out(asked);
        }
        let now = HostInstant::now();
        if now >= self.look {
            match self.generator.is_some() {
                true => drop(self.call(Span::ZERO, |generator| generator.look())),
                false => self.look_again(),
            }
            self.look = now + self.reporter.limit().max(Span::from_nanos(1));
        }
        // Nothing is under way, and what is asked from now on has a time of its own.
        if self.asked.is_empty() {
            self.shared.due.clear();
        }
    }

    fn carry_out(&mut self, asked: NumberedOrder) {
        let NumberedOrder { number, output, epoch, order } = asked;
        let wanted = epoch == self.shared.epoch.load(Ordering::Acquire);
        let done = match order {
            _ if !wanted => None,
            GeneratorOrder::Level(high) => {
                self.call(Span::ZERO, |generator| generator.level(output, high)).map(|()| None)
            }
            GeneratorOrder::Square { period, high } => {
                self.call(Span::ZERO, |generator| generator.square(output, period, high)).map(|()| None)
            }
            GeneratorOrder::Pulses(edges) => {
                let lasts = self.generator.as_ref().map_or(Span::ZERO, |generator| generator.lasts(&edges));
                self.call(lasts, |generator| generator.pulses(output, &edges)).map(Some)
            }
        };
        let report = match done {
            Some(None) => return,
            Some(Some(sent)) => GeneratorReport::Sent { number, sent },
            None => GeneratorReport::Dropped { number, output, at: HostInstant::now() },
        };
        self.reporter.report(report);
    }

    /// A call that lasts so long by itself. `None` where it failed.
    fn call<T>(&mut self, lasts: Span, call: impl FnOnce(&mut dyn Generator) -> io::Result<T>) -> Option<T> {
        let generator = self.generator.as_deref_mut()?;
        let due = HostInstant::now() + lasts + self.reporter.limit();
        self.shared.due.set(due);
        let outcome = call(generator);
        self.shared.due.clear();
        match outcome {
            Ok(done) => {
                self.reporter.works();
                Some(done)
            }
            Err(error) => {
                if self.reporter.refused(&error) {
                    self.generator = None;
                }
                None
            }
        }
    }

    /// Whether a device that was gone is there again.
    fn look_again(&mut self) {
        if !self.reconnect {
            return;
        }
        // Opening it brings it to rest.
        let rests = self.shared.rests.load(Ordering::Acquire);
        self.generator = self.reopen.open();
        if self.generator.is_some() {
            self.rested = rests;
            self.shared.rested.store(rests, Ordering::Release);
            self.reporter.returned(GeneratorReport::Returned { at: HostInstant::now() });
            self.reporter.answer();
        }
    }
}
