//! When watchdogs bite: those of tasks, and those of the system (controller: section 9).

use super::{Overload, Scheduler};
use crate::config::WatchdogBasis;
use profile::{SYSTEM_WATCHDOG_FULL_LOAD, SYSTEM_WATCHDOG_STARVED};
use signal::Time;

/// A system watchdog that was not served in time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SystemWatchdog {
    /// Controller tasks had the whole processor (controller:WD-02).
    FullLoad,
    /// The task of the lowest priority at this place waited too long (controller:WD-03).
    Starved(usize),
}

/// What a mark of a task's watchdog does.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WatchdogMark {
    /// Place of the task.
    pub place: usize,
    /// The exceptions in a row, where this mark is one.
    pub exception: Option<u32>,
    /// It stops the application.
    pub trips: bool,
}

impl Scheduler {
    /// When the next mark of a task's watchdog is reached (controller:WD-04, controller:WD-10).
    fn watchdog_due(&self, rank: usize) -> Time {
        let task = &self.tasks[rank];
        let Some(mark) = task.mark() else { return Time::MAX };
        match self.basis {
            WatchdogBasis::Elapsed => task.cycle.start.saturating_add(mark),
            // Processor time passes only for the task that has the processor.
            WatchdogBasis::Processor if self.holder() == Some(rank) => {
                self.at.saturating_add(mark - task.cycle.used)
            }
            WatchdogBasis::Processor => Time::MAX,
        }
    }

    /// Rank of the task that has the processor or gets it next.
    fn holder(&self) -> Option<usize> {
        match (self.in_flight, self.runnable()) {
            (Some(_), _) => Some(self.running),
            (None, 0) => None,
            (None, runnable) => Some(self.chosen(runnable)),
        }
    }

    /// When controller tasks will have had the whole processor for too long (controller:WD-02).
    fn full_load_due(&self) -> Time {
        if self.busy_until != self.at {
            return Time::MAX;
        }
        match self.holder() {
            Some(rank) if self.tasks[rank].foreground() => {
                self.busy_since.saturating_add(SYSTEM_WATCHDOG_FULL_LOAD)
            }
            _ => Time::MAX,
        }
    }

    /// When the task of the lowest priority will have waited for the processor for too long (controller:WD-03). It
    /// waits while a cycle of it is due or under way, and it neither sleeps nor has the processor. Tasks that share
    /// the lowest priority are watched one by one.
    fn starved_due(&self, rank: usize) -> Time {
        let task = &self.tasks[rank];
        if (self.ready | self.active) >> rank & 1 == 0 {
            return Time::MAX;
        }
        task.waits_since.max(task.sleeps_until).saturating_add(SYSTEM_WATCHDOG_STARVED)
    }

    /// Ranks of the tasks of the lowest priority.
    fn lowest(&self) -> std::ops::Range<usize> {
        let end = self.tasks.len();
        let lowest = self.tasks.last().map(|task| task.priority);
        let first = self.tasks.iter().position(|task| Some(task.priority) == lowest).unwrap_or(end);
        first..end
    }

    /// When a watchdog is next due, in RUNNING.
    pub(crate) fn watchdogs_due(&self) -> Time {
        let mut next = self.full_load_due().min(self.load.due());
        let mut left = self.active;
        while left != 0 {
            next = next.min(self.watchdog_due(left.trailing_zeros() as usize));
            left &= left - 1;
        }
        self.lowest().fold(next, |next, rank| next.min(self.starved_due(rank)))
    }

    /// The mark of the watchdog of this rank that its cycle under way has reached by `now`. Exceptions are counted when
    /// the time is exceeded, not when the cycle ends, so that an endless loop is caught. Consecutive exceptions up to
    /// the sensitivity stop the application; so does a single cycle of time × sensitivity.
    pub(crate) fn take_watchdog_mark(&mut self, rank: usize, now: Time) -> Option<WatchdogMark> {
        if self.active >> rank & 1 == 0 || self.watchdog_due(rank) > now {
            return None;
        }
        let task = &mut self.tasks[rank];
        let marks = task.cycle.marks?;
        if task.cycle.excepted {
            return Some(WatchdogMark { place: task.place, exception: None, trips: true });
        }
        task.cycle.excepted = true;
        task.consecutive += 1;
        task.figures.exceptions += 1;
        let trips = task.consecutive >= marks.sensitivity;
        Some(WatchdogMark { place: task.place, exception: Some(task.consecutive), trips })
    }

    /// The system watchdog that bites at `now`.
    pub(crate) fn system_watchdog(&self, now: Time) -> Option<SystemWatchdog> {
        if self.full_load_due() <= now {
            return Some(SystemWatchdog::FullLoad);
        }
        let starved = self.lowest().find(|rank| self.starved_due(*rank) <= now);
        starved.map(|rank| SystemWatchdog::Starved(self.tasks[rank].place))
    }

    /// Whether a slot of the load ends by `now`; the load is accounted for up to there.
    pub(crate) fn end_load_slot(&mut self, now: Time) -> bool {
        let due = self.load.due() <= now;
        if due {
            self.account_load(now);
        }
        due
    }

    /// Whether a second of load figures ended since the last call.
    pub(crate) fn take_load_second(&mut self) -> bool {
        self.load.take_second()
    }

    /// What had too much of the processor for too long by `now` (controller:WD-01, controller:WD-05).
    pub(crate) fn overloaded(&self, now: Time) -> Option<Overload> {
        self.load.exceeded(now)
    }

    /// Processor time is accounted for up to `now`: an operation under way has the processor.
    pub(crate) fn account_load(&mut self, now: Time) {
        let running = self.in_flight.map(|_| self.running);
        self.load.advance(now, running, &mut self.tasks);
    }
}
