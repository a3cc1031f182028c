//! Task watchdogs and system watchdogs (controller: section 9).

use crate::watch::class;
use crate::{Controller, Effects, LogEntry, State, WatchdogBasis};
use profile::{ApplicationError, SYSTEM_WATCHDOG_FULL_LOAD, SYSTEM_WATCHDOG_STARVED, StopCause};
use signal::{Cause, Time};

impl Controller {
    /// When the next mark of a task's watchdog is reached (controller:WD-04, controller:WD-10).
    fn watchdog_due(&self, rank: usize) -> Time {
        let task = &self.tasks[rank];
        let Some(mark) = task.mark() else { return Time::MAX };
        match self.config.watchdog_basis {
            WatchdogBasis::Elapsed => task.cycle.start.saturating_add(mark),
            // Processor time passes only for the task that has the processor.
            WatchdogBasis::Processor if self.holder() == Some(rank) => {
                self.cpu.at.saturating_add(mark - task.cycle.used)
            }
            WatchdogBasis::Processor => Time::MAX,
        }
    }

    /// Rank of the task that has the processor or gets it next.
    fn holder(&self) -> Option<usize> {
        match (self.cpu.in_flight, self.runnable()) {
            (Some(_), _) => Some(self.cpu.running),
            (None, 0) => None,
            (None, runnable) => Some(self.chosen(runnable)),
        }
    }

    /// When controller tasks will have had the whole processor for too long (controller:WD-02).
    fn full_load_due(&self) -> Time {
        if self.cpu.busy_until != self.cpu.at {
            return Time::MAX;
        }
        match self.holder() {
            Some(rank) if self.tasks[rank].foreground() => {
                self.cpu.busy_since.saturating_add(SYSTEM_WATCHDOG_FULL_LOAD)
            }
            _ => Time::MAX,
        }
    }

    /// When the task of the lowest priority will have waited for the processor for too long (controller:WD-03). It
    /// waits while a cycle of it is due or under way, and it neither sleeps nor has the processor. Tasks that share
    /// the lowest priority are watched one by one.
    fn starved_due(&self, rank: usize) -> Time {
        let task = &self.tasks[rank];
        if (self.cpu.ready | self.cpu.active) >> rank & 1 == 0 {
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
        let mut left = self.cpu.active;
        while left != 0 {
            next = next.min(self.watchdog_due(left.trailing_zeros() as usize));
            left &= left - 1;
        }
        self.lowest().fold(next, |next, rank| next.min(self.starved_due(rank)))
    }

    pub(crate) fn fire_watchdogs(&mut self, now: Time, fx: &mut Effects) {
        for rank in 0..self.tasks.len() {
            while self.state == State::Running
                && self.cpu.active >> rank & 1 == 1
                && self.watchdog_due(rank) <= now
            {
                self.watchdog_mark(rank, now, fx);
            }
        }
        if self.state != State::Running {
            return;
        }
        let starved = self.lowest().find(|rank| self.starved_due(*rank) <= now);
        let entry = match starved {
            _ if self.full_load_due() <= now => LogEntry::SystemWatchdog,
            Some(rank) => LogEntry::Starved { task: self.tasks[rank].place },
            None => return self.fire_load(now, fx),
        };
        self.log_entry(now, entry, fx);
        // controller:WD-11
        self.system_error(now, StopCause::HardwareWatchdog, ApplicationError::SystemWatchdog, fx);
    }

    /// The load where a slot ends at `now`: figures of the tasks, and an overload that has lasted too long
    /// (controller:WD-01, controller:WD-05).
    fn fire_load(&mut self, now: Time, fx: &mut Effects) {
        if self.load.due() > now {
            return;
        }
        self.account_load(now);
        if self.load.take_second() {
            self.observe(class::FIGURE, now, Cause::Controller, fx);
        }
        let Some(overload) = self.load.exceeded(now) else { return };
        self.log_entry(now, LogEntry::Overload(overload), fx);
        self.enter_halt(now, ApplicationError::Overload, fx);
    }

    /// Processor time is accounted for up to `now`: an operation under way has the processor.
    pub(crate) fn account_load(&mut self, now: Time) {
        let running = self.cpu.in_flight.map(|_| self.cpu.running);
        self.load.advance(now, running, &mut self.tasks);
    }

    /// A cycle is still under way at a mark of its watchdog. Exceptions are counted when the time is exceeded, not
    /// when the cycle ends, so that an endless loop is caught. Consecutive exceptions up to the sensitivity stop the
    /// application; so does a single cycle of time × sensitivity.
    fn watchdog_mark(&mut self, rank: usize, now: Time, fx: &mut Effects) {
        let task = &mut self.tasks[rank];
        let Some(marks) = task.cycle.marks else { return };
        let place = task.place;
        let mut trips = task.cycle.excepted;
        if !task.cycle.excepted {
            task.cycle.excepted = true;
            task.consecutive += 1;
            task.figures.exceptions += 1;
            trips = task.consecutive >= marks.sensitivity;
            let entry = LogEntry::WatchdogException { task: place, consecutive: task.consecutive };
            self.log_entry(now, entry, fx);
        }
        if trips {
            self.log_entry(now, LogEntry::TaskWatchdog { task: place }, fx);
            self.enter_halt(now, ApplicationError::TaskWatchdog, fx);
        }
    }
}
