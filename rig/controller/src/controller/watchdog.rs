//! What watchdogs do when they bite (controller: section 9).

use super::Controller;
use crate::probes::class;
use crate::scheduler::SystemWatchdog;
use crate::{Effects, LogEntry, State};
use profile::{ApplicationError, StopCause};
use signal::{Cause, Time};

impl Controller {
    /// Task watchdogs by priority, then those of the system.
    pub(super) fn fire_watchdogs(&mut self, now: Time, fx: &mut Effects) {
        for rank in 0..self.scheduler.len() {
            while self.state == State::Running
                && let Some(mark) = self.scheduler.take_watchdog_mark(rank, now)
            {
                if let Some(consecutive) = mark.exception {
                    self.log_entry(now, LogEntry::WatchdogException { task: mark.place, consecutive }, fx);
                }
                if mark.trips {
                    self.log_entry(now, LogEntry::TaskWatchdog { task: mark.place }, fx);
                    self.enter_halt(now, ApplicationError::TaskWatchdog, fx);
                }
            }
        }
        if self.state != State::Running {
            return;
        }
        let entry = match self.scheduler.system_watchdog(now) {
            Some(SystemWatchdog::FullLoad) => LogEntry::SystemWatchdog,
            Some(SystemWatchdog::Starved(task)) => LogEntry::Starved { task },
            None => return self.fire_load(now, fx),
        };
        self.log_entry(now, entry, fx);
        // controller:WD-11
        self.system_error(now, StopCause::HardwareWatchdog, ApplicationError::SystemWatchdog, fx);
    }

    /// The load where a slot ends at `now`: figures of the tasks, and an overload that has lasted too long
    /// (controller:WD-01, controller:WD-05).
    fn fire_load(&mut self, now: Time, fx: &mut Effects) {
        if !self.scheduler.end_load_slot(now) {
            return;
        }
        if self.scheduler.take_load_second() {
            self.observe(class::FIGURE, now, Cause::Controller, fx);
        }
        let Some(overload) = self.scheduler.overloaded(now) else { return };
        self.log_entry(now, LogEntry::Overload(overload), fx);
        self.enter_halt(now, ApplicationError::Overload, fx);
    }
}
