//! Everything that is due at an instant, and the order in which it happens.

use crate::watch::class;
use crate::{Controller, Effects, Entry, State, WatchdogBasis};
use profile::{ApplicationError, SYSTEM_WATCHDOG_FULL_LOAD, StopCause};
use signal::{Cause, Time};

impl Controller {
    /// The earliest instant at which something is due: a watchdog, the end of the hold-up time, a step of the boot,
    /// the end of a save, an edge at a terminal, a release, an update in STOPPED. It changes with every call of
    /// another method.
    pub fn next_timer(&self) -> Option<Time> {
        let mut next = self.outputs.next().min(self.context.next());
        let power = &self.power;
        next = next.min(power.hold_up.unwrap_or(Time::MAX));
        next = next.min(power.refresh.unwrap_or(Time::MAX));
        next = next.min(power.stage.map_or(Time::MAX, |(_, end)| end));
        if self.state == State::Running {
            if self.cpu.stopping.is_none() {
                next = self.tasks.iter().fold(next, |next, task| next.min(task.next_release));
            }
            let mut left = self.cpu.active;
            while left != 0 {
                next = next.min(self.watchdog_due(left.trailing_zeros() as usize));
                left &= left - 1;
            }
            next = next.min(self.full_load_due());
        }
        (next != Time::MAX).then_some(next)
    }

    /// Lets everything happen that is due at `now`, in this order: task watchdogs by priority, system watchdog, end of
    /// the hold-up time, boot step, end of a save, edges at terminals by number, releases by priority, update in
    /// STOPPED. [`Controller::run`] must have come to `now` before.
    pub fn fire(&mut self, now: Time, fx: &mut Effects) {
        self.come_to(now);
        self.fire_watchdogs(now, fx);
        if self.power.hold_up.is_some_and(|end| end <= now) {
            self.go_off(now, fx);
        }
        if let Some((stage, end)) = self.power.stage
            && end <= now
        {
            self.next_stage(stage, now, fx);
        }
        if self.context.fire(now, &mut *self.store) && self.cpu.active == 0 && self.state != State::Halt {
            // A change during the save; in HALT the variables may be half a cycle.
            self.save_if_dirty(now);
        }
        if self.outputs.fire(now, fx) {
            self.observe(class::TERMINAL, now, Cause::Unknown, fx);
        }
        if self.state == State::Running && self.cpu.stopping.is_none() {
            self.release(now);
        }
        if self.power.refresh.is_some_and(|at| at <= now) {
            self.refresh(now, fx);
        }
    }

    /// The processor idles up to `now`; an operation under way goes on.
    pub(crate) fn come_to(&mut self, now: Time) {
        if self.cpu.in_flight.is_none() {
            self.cpu.at = self.cpu.at.max(now);
        }
    }

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
            (None, runnable) => Some(runnable.trailing_zeros() as usize),
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

    fn fire_watchdogs(&mut self, now: Time, fx: &mut Effects) {
        for rank in 0..self.tasks.len() {
            while self.state == State::Running
                && self.cpu.active >> rank & 1 == 1
                && self.watchdog_due(rank) <= now
            {
                self.watchdog_mark(rank, now, fx);
            }
        }
        if self.state == State::Running && self.full_load_due() <= now {
            self.note(now, Entry::SystemWatchdog, fx);
            // controller:WD-11
            self.system_error(now, StopCause::HardwareWatchdog, ApplicationError::SystemWatchdog, fx);
        }
    }

    /// A cycle is still under way at a mark of its watchdog. Exceptions are counted when the time is exceeded, not
    /// when the cycle ends, so that an endless loop is caught. Consecutive exceptions up to the sensitivity stop the
    /// application; so does a single cycle of time × sensitivity.
    fn watchdog_mark(&mut self, rank: usize, now: Time, fx: &mut Effects) {
        let task = &mut self.tasks[rank];
        let Some(marks) = task.marks else { return };
        let place = task.place;
        let mut trips = task.cycle.excepted;
        if !task.cycle.excepted {
            task.cycle.excepted = true;
            task.consecutive += 1;
            task.figures.exceptions += 1;
            trips = task.consecutive >= marks.sensitivity;
            let entry = Entry::WatchdogException { task: place, consecutive: task.consecutive };
            self.note(now, entry, fx);
        }
        if trips {
            self.note(now, Entry::TaskWatchdog { task: place }, fx);
            self.enter_halt(now, ApplicationError::TaskWatchdog, fx);
        }
    }

    /// Releases the cycles due at `now`. A release that finds one waiting is lost; the grid is kept
    /// (controller:TASK-11).
    fn release(&mut self, now: Time) {
        for (rank, task) in self.tasks.iter_mut().enumerate() {
            while task.next_release <= now {
                task.next_release = task.next_release.saturating_add(task.interval);
                if self.cpu.ready >> rank & 1 == 1 {
                    task.figures.lost += 1;
                }
                self.cpu.ready |= 1 << rank;
            }
        }
    }
}
