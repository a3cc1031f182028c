//! The thread that reads a counter: the only one whose calls may last.

use std::sync::Arc;

use host::{Bell, CounterEvent, HostInstant, Realtime, ThreadRole};
use signal::Span;

use super::{CountStep, Counter, Follower};
use crate::sampled::{SampleTurn, Sampler};

/// What the device found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum CounterReport {
    /// It has counted.
    Counted(CountStep),
    /// Events were lost on the way.
    Missed { at: HostInstant },
    /// It was read since this start.
    Started { start: u64 },
    /// It was gone and is there again, and goes on where it was.
    Returned { at: HostInstant },
}

/// The thread's side of a counter.
pub(super) struct CounterThread {
    pub(super) sampler: Sampler<dyn Counter, CounterReport>,
    /// Wakes the thread.
    pub(super) wake: Arc<Bell>,
    pub(super) follower: Follower,
    /// How far it had counted when it was lost last.
    pub(super) before: i64,
    /// How far it has counted since.
    pub(super) total: i64,
    /// The events of one look.
    pub(super) events: Vec<CounterEvent>,
    /// What became known by one look.
    pub(super) steps: Vec<CountStep>,
    /// Time between two readings.
    pub(super) period: Span,
    /// It is open again, and was not read since.
    pub(super) returning: bool,
}

impl CounterThread {
    /// The thread.
    pub(super) fn run(mut self, realtime: Realtime) {
        // A refusal is reported once for all threads, by whoever set up the run.
        let _ = realtime.enter(ThreadRole::Devices);
        while !self.sampler.reporter.is_stopped() {
            let until = self.turn();
            self.sampler.reporter.ring();
            self.wake.wait_until(until);
        }
        drop(self.sampler.device.take());
        self.sampler.reporter.end();
    }

    /// One look at what is asked, and at most one reading. Returns until when there is nothing to do.
    fn turn(&mut self) -> HostInstant {
        if self.sampler.starts() {
            self.begin();
        }
        let now = HostInstant::now();
        let turn = self.sampler.turn(now);
        match turn {
            SampleTurn::Read => self.look(now),
            SampleTurn::Reopen => self.reopen(now),
            SampleTurn::Wait | SampleTurn::Rest => {}
        }
        self.sampler.waits_until(turn)
    }

    /// A new run: it counts from 0.
    fn begin(&mut self) {
        (self.before, self.total) = (0, 0);
        self.follower.begin();
        self.sampler.control.waits_since.set(HostInstant::now());
        let begun = self.sampler.device.as_mut().map(|counter| counter.begin());
        self.sampler.control.waits_since.clear();
        if let Some(Err(error)) = begun {
            self.sampler.refused(&error);
        }
    }

    fn look(&mut self, now: HostInstant) {
        self.events.clear();
        let Some(counter) = &mut self.sampler.device else { return };
        self.sampler.control.waits_since.set(now);
        let answer = counter.read().and_then(|reading| Ok((reading, counter.events(&mut self.events)?)));
        self.sampler.control.waits_since.clear();
        self.sampler.was_read(self.period, HostInstant::now());
        let (reading, whole) = match answer {
            Ok(answer) => answer,
            Err(error) => return self.sampler.refused(&error),
        };
        self.sampler.reporter.works();
        let steps = &mut self.steps;
        self.follower.take(reading, &self.events, &mut |step| steps.push(step));
        for at in 0..self.steps.len() {
            let step = self.steps[at];
            self.total = self.before.saturating_add(step.total);
            self.sampler.reporter.report(CounterReport::Counted(CountStep { total: self.total, ..step }));
        }
        self.steps.clear();
        // Not before it was read: what it counts from the instant of its return on is counted.
        if self.returning && self.follower.since().is_some() {
            self.returning = false;
            self.sampler.reporter.returned(CounterReport::Returned { at: HostInstant::now() });
        }
        if !whole {
            self.sampler.reporter.report(CounterReport::Missed { at: reading.after });
        }
        if self.follower.since().is_some() {
            self.sampler.answer_start(|start| CounterReport::Started { start });
        }
    }

    /// Whether a device that was gone is there again.
    fn reopen(&mut self, now: HostInstant) {
        if self.sampler.reopen(now) {
            // What it counted meanwhile, and from where it counts now, nobody knows.
            self.before = self.total;
            self.follower.begin();
            self.returning = true;
        }
    }
}
