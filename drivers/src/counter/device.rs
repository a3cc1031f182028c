//! The thread that reads a counter: the only one whose calls may last.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use host::{AtomicInstant, Bell, CounterEvent, HostInstant, Realtime, Role};
use signal::Span;

use super::{Counter, Follower, Step};
use crate::thread::Reporter;

/// How a counter is opened again when it was gone.
pub(super) type Opener = Box<dyn FnMut() -> Option<Box<dyn Counter>> + Send>;

/// What the device found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Report {
    /// It has counted.
    Counted(Step),
    /// Events were lost on the way.
    Missed { at: HostInstant },
    /// It was read since this start.
    Started { start: u64 },
    /// It was gone and is there again, and goes on where it was.
    Returned { at: HostInstant },
}

/// What board and thread share.
#[derive(Debug, Default)]
pub(super) struct Shared {
    /// A run goes on: the count is to be read.
    pub(super) active: AtomicBool,
    /// Number of starts asked for.
    pub(super) starts: AtomicU64,
    /// Since when an answer is owed.
    pub(super) owes: AtomicInstant,
    /// Wakes the thread.
    pub(super) wake: Bell,
}

/// The thread's side of a counter.
pub(super) struct Device {
    pub(super) counter: Option<Box<dyn Counter>>,
    pub(super) opener: Opener,
    pub(super) shared: Arc<Shared>,
    pub(super) reporter: Reporter<Report>,
    pub(super) follower: Follower,
    /// How far it had counted when it was lost last.
    pub(super) before: i64,
    /// How far it has counted since.
    pub(super) total: i64,
    /// The events of one look.
    pub(super) events: Vec<CounterEvent>,
    /// What became known by one look.
    pub(super) steps: Vec<Step>,
    /// Time between two readings.
    pub(super) period: Span,
    /// A device that was gone is opened again.
    pub(super) reconnect: bool,
    pub(super) started: u64,
    /// Whether the start has been answered.
    pub(super) complete: bool,
    /// It is open again, and was not read since.
    pub(super) returning: bool,
    /// When the next reading is due.
    pub(super) due: HostInstant,
}

impl Device {
    /// The thread.
    pub(super) fn run(mut self, realtime: Realtime) {
        // A refusal is reported once for all threads, by whoever set up the run.
        let _ = realtime.enter(Role::Devices);
        while !self.reporter.is_stopped() {
            let until = self.turn();
            self.reporter.ring();
            self.shared.wake.wait_until(until);
        }
        drop(self.counter.take());
        self.reporter.end();
    }

    /// One look at what is asked, and at most one reading. Says until when there is nothing to do.
    fn turn(&mut self) -> HostInstant {
        let starts = self.shared.starts.load(Ordering::Acquire);
        if starts != self.started {
            self.begin(starts);
        }
        if !self.shared.active.load(Ordering::Acquire) {
            self.shared.owes.clear();
            return HostInstant::NEVER;
        }
        let now = HostInstant::now();
        if now >= self.due {
            match self.counter.is_some() {
                true => self.look(now),
                false => self.look_again(now),
            }
        }
        self.due
    }

    /// A new run: it counts from 0.
    fn begin(&mut self, start: u64) {
        (self.started, self.complete) = (start, false);
        self.reporter.works();
        (self.before, self.total) = (0, 0);
        self.follower.begin();
        let now = HostInstant::now();
        self.due = now;
        self.shared.owes.set(now);
        if let Some(Err(error)) = self.counter.as_mut().map(|counter| counter.begin()) {
            self.refused(&error);
        }
        self.shared.owes.clear();
    }

    fn look(&mut self, now: HostInstant) {
        self.shared.owes.set(now);
        self.events.clear();
        let Some(counter) = &mut self.counter else { return };
        let answer = counter.read().and_then(|reading| Ok((reading, counter.events(&mut self.events)?)));
        self.shared.owes.clear();
        // As often as asked for on the whole; what was slept through is not made up for.
        let after = HostInstant::now();
        self.due += self.period;
        if self.due <= after {
            self.due = after + self.period;
        }
        let (reading, whole) = match answer {
            Ok(answer) => answer,
            Err(error) => return self.refused(&error),
        };
        self.reporter.works();
        let steps = &mut self.steps;
        self.follower.take(reading, &self.events, &mut |step| steps.push(step));
        for at in 0..self.steps.len() {
            let step = self.steps[at];
            self.total = self.before.saturating_add(step.total);
            self.reporter.report(Report::Counted(Step { total: self.total, ..step }));
        }
        self.steps.clear();
        // Not before it was read: what it counts from the instant of its return on is counted.
        if self.returning && self.follower.since().is_some() {
            self.returning = false;
            self.reporter.returned(Report::Returned { at: HostInstant::now() });
        }
        if !whole {
            self.reporter.report(Report::Missed { at: reading.after });
        }
        if !self.complete && self.follower.since().is_some() {
            self.complete = true;
            self.reporter.insist(Report::Started { start: self.started });
        }
    }

    fn refused(&mut self, error: &std::io::Error) {
        if self.reporter.refused(error) {
            self.counter = None;
            self.due = HostInstant::now() + self.reporter.limit();
        }
    }

    /// Whether a device that was gone is there again.
    fn look_again(&mut self, now: HostInstant) {
        self.due = if self.reconnect { now + self.reporter.limit() } else { HostInstant::NEVER };
        if !self.reconnect {
            return;
        }
        self.counter = (self.opener)();
        if self.counter.is_some() {
            // What it counted meanwhile, and from where it counts now, nobody knows.
            self.before = self.total;
            self.follower.begin();
            self.returning = true;
            self.due = HostInstant::now();
        }
    }
}
