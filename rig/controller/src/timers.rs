//! Everything that is due at an instant, and the order in which it happens.

use crate::watch::class;
use crate::{Controller, Effects, State};
use signal::{Cause, Time};

impl Controller {
    /// The earliest instant at which something is due: a watchdog, the end of the hold-up time, a step of the boot,
    /// the end of a save, protection, something of an expert function, an edge at a terminal or behind the filter of an input that is acted on at once,
    /// a release, default values, an update in STOPPED, a flash. It changes with every call of another method.
    pub fn next_timer(&self) -> Option<Time> {
        let mut next = self.outputs.next().min(self.context.next()).min(self.inputs.next());
        next = next.min(self.functions.next());
        next = next.min(self.clock_due());
        next = next.min(self.protection.next()).min(self.leds.next);
        let power = &self.power;
        next = next.min(power.initialization.map_or(Time::MAX, |(end, _)| end));
        next = next.min(power.hold_up.unwrap_or(Time::MAX));
        next = next.min(power.refresh.unwrap_or(Time::MAX));
        next = next.min(power.stage.map_or(Time::MAX, |(_, end)| end));
        next = next.min(power.creating.unwrap_or(Time::MAX));
        if self.state == State::Running {
            if self.cpu.stopping.is_none() {
                next = next.min(self.release_due());
            }
            next = next.min(self.wake_due()).min(self.watchdogs_due());
        }
        (next != Time::MAX).then_some(next)
    }

    /// Lets everything happen that is due at `now`, in this order: task watchdogs by priority, system watchdogs, end of
    /// the hold-up time, edges of inputs, boot step, boot application saved, end of a save, expert functions, protection, edges at
    /// terminals by number, tasks that wake, releases by priority, events, default values after initialization values,
    /// update in STOPPED, flashes of indicators. [`Controller::run`] must have come to `now` before.
    pub fn fire(&mut self, now: Time, fx: &mut Effects) {
        self.refresh_watches();
        self.idle_until(now);
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
        if self.power.creating.is_some_and(|end| end <= now) {
            self.complete_boot_application();
            self.observe(class::STATE | class::FILE, now, Cause::Controller, fx);
        }
        if self.context.fire(now, &mut *self.store) && self.cpu.active == 0 && self.state != State::Halt {
            // A change during the save; in HALT the variables may be half a cycle.
            self.save_if_dirty(now);
        }
        self.fire_functions(now, fx);
        if self.protection.next() <= now {
            self.protect(now, fx);
        }
        if self.outputs.fire(now, fx) {
            self.observe(class::TERMINAL, now, Cause::Unknown, fx);
        }
        if self.state == State::Running {
            self.wake(now);
        }
        if self.state == State::Running && self.cpu.stopping.is_none() {
            self.release(now, fx);
        }
        if self.power.initialization.is_some_and(|(end, _)| end <= now) {
            self.end_initialization(now, fx);
        }
        if self.power.refresh.is_some_and(|at| at <= now) {
            self.refresh(now, fx);
        }
        if self.leds.next <= now {
            self.observe(class::LED, now, Cause::Controller, fx);
        }
    }

    /// The processor idles up to `now`; an operation under way goes on.
    pub(crate) fn idle_until(&mut self, now: Time) {
        if self.cpu.in_flight.is_none() {
            self.cpu.at = self.cpu.at.max(now);
        }
    }
}
