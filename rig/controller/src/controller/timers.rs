//! Everything that is due at an instant, and the order in which it happens.

use super::Controller;
use crate::module::IoModule;
use crate::probes::class;
use crate::{Effects, LogEntry, State};
use signal::{Cause, Time};

impl Controller {
    /// The earliest instant at which something is due: a watchdog, the end of the hold-up time, a step of the boot,
    /// a power cycle, the end of a save, protection, something of an expert function, an edge at a terminal or behind the filter of an input that is acted on at once,
    /// a release, default values, an update in STOPPED, a flash, something at a port. It changes with every call of another method.
    pub fn next_timer(&self) -> Option<Time> {
        let mut next =
            self.io.next().min(self.modules.next()).min(self.remanent.next()).min(self.clock_due());
        next = next.min(self.power.next()).min(self.leds.next()).min(self.ports.next());
        if self.state == State::Running {
            if self.scheduler.stopping().is_none() {
                next = next.min(self.scheduler.release_due());
            }
            next = next.min(self.scheduler.wake_due()).min(self.scheduler.watchdogs_due());
        }
        (next != Time::MAX).then_some(next)
    }

    /// Lets everything happen that is due at `now`, in this order: task watchdogs by priority, system watchdogs, end of
    /// the hold-up time, edges of inputs, boot step, warning of a power cycle, boot application saved, end of a save, expert functions, protection, edges at
    /// terminals by number, tasks that wake, releases by priority, events, default values after initialization values,
    /// update in STOPPED, flashes of indicators, ports. [`Controller::run`] must have come to `now` before.
    pub fn fire(&mut self, now: Time, fx: &mut Effects) {
        self.refresh_watches();
        self.scheduler.idle_until(now);
        self.fire_watchdogs(now, fx);
        if self.power.hold_up.is_some_and(|end| end <= now) {
            self.go_off(now, fx);
        }
        self.fire_inputs(now, fx);
        self.fire_clocks(now, fx);
        if let Some((stage, end)) = self.power.stage
            && end <= now
        {
            self.next_stage(stage, now, fx);
        }
        if self.power.cycle_due.is_some_and(|at| at <= now) {
            self.power.cycle_due = None;
            self.log_entry(now, LogEntry::PowerCycleDue, fx);
        }
        if self.power.creating.is_some_and(|end| end <= now) {
            self.complete_boot_application();
            self.observe(class::STATE | class::FILE, now, Cause::Controller, fx);
        }
        if self.remanent.next() <= now
            && self.remanent.fire(now, self.files.store_mut())
            && self.scheduler.is_between_cycles()
            && self.state != State::Halt
        {
            // A change during the save; in HALT the variables may be half a cycle.
            self.save_if_dirty(now);
        }
        self.fire_functions(now, fx);
        if self.io.is_protection_due(now) {
            self.protect(now, fx);
        }
        self.fire_outputs(now, fx);
        if self.state == State::Running {
            self.scheduler.wake(now);
        }
        if self.state == State::Running && self.scheduler.stopping().is_none() {
            self.release(now, fx);
        }
        if self.io.ends_initialization(now) {
            self.end_initialization(now, fx);
        }
        if self.power.refresh.is_some_and(|at| at <= now) {
            self.refresh(now, fx);
        }
        if self.leds.next() <= now {
            self.observe(class::LED, now, Cause::Controller, fx);
        }
        self.fire_ports(now, fx);
    }
}
