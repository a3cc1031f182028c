//! Tasks as users and programs see them: figures, intervals, events and triggers that start them.

use super::Controller;
use crate::scheduler::TaskTrigger;
use crate::{Application, Effects, ExternalEventSource, JitterCounts, LogEntry, Memory, State, TaskFigures};
use profile::{ApplicationError, Profile};
use signal::{Span, Time};

/// Whether the trigger of an event task is TRUE.
fn level(trigger: TaskTrigger, memory: &Memory, application: Option<&dyn Application>) -> bool {
    match trigger {
        TaskTrigger::Address(at) => memory.value(at).as_bool() == Some(true),
        TaskTrigger::Variable(variable) => {
            application.is_some_and(|it| it.read(variable).as_bool() == Some(true))
        }
    }
}

impl Controller {
    /// The figures of a task by its place in the configuration.
    pub fn task_figures(&self, task: usize) -> Option<TaskFigures> {
        self.scheduler.figures(task)
    }

    /// How late the cycles of a task began, by its place in the configuration.
    pub fn task_jitter(&self, task: usize) -> Option<&JitterCounts> {
        self.scheduler.jitter(task)
    }

    /// The next `times` cycles of a task take `cycle` of processor time in all, however little the program needs.
    /// The time after the program's last operation can be pre-empted at any nanosecond.
    pub fn overload(&mut self, task: usize, cycle: Span, times: u32) {
        self.scheduler.overload(task, cycle, times);
    }

    /// The interval of a cyclic task by its place in the configuration: the one that was set last
    /// (controller:TASK-13). `None` for a task of another kind.
    pub fn interval(&self, task: usize) -> Option<Span> {
        self.scheduler.interval(task)
    }

    /// Sets the interval of a cyclic task by its place in the configuration; it holds from the next release on
    /// (controller:TASK-13). FALSE, with nothing set, for a task of another kind and for an interval below the
    /// minimum cycle. A download and a boot bring the configured interval back.
    pub fn set_interval(&mut self, task: usize, interval: Span) -> bool {
        self.scheduler.set_interval(task, interval)
    }

    /// A task, by its place in the configuration, does not get the processor until `until`, however much it wants it
    /// (controller:WD-13). Ends when RUNNING is left.
    pub fn suspend(&mut self, task: usize, until: Time) {
        self.scheduler.suspend(task, until);
    }

    /// RUNNING is entered: nothing is due but what starts by itself.
    pub(super) fn begin_tasks(&mut self, now: Time) {
        let (memory, application) = (&self.memory, self.application.as_deref());
        self.scheduler.begin_running(now, |trigger| level(trigger, memory, application));
    }

    /// Releases the cycles due at `now`, and after them looks at the variables that start event tasks.
    pub(super) fn release(&mut self, now: Time, fx: &mut Effects) {
        self.scheduler.release(now);
        while self.scheduler.take_tick(now) {
            self.check_triggers(now, fx);
        }
    }

    /// Starts the event tasks whose variables became TRUE since they were looked at last (controller:TASK-30). This
    /// happens at the end of every task's cycle and every [`profile::TRIGGER_TICK`].
    pub(super) fn check_triggers(&mut self, now: Time, fx: &mut Effects) {
        if !self.scheduler.has_triggers() {
            return;
        }
        for rank in 0..self.scheduler.len() {
            if self.state != State::Running || self.scheduler.stopping().is_some() {
                return;
            }
            let Some(trigger) = self.scheduler.trigger(rank) else { continue };
            let level = level(trigger, &self.memory, self.application.as_deref());
            if self.scheduler.trigger_rose(rank, level)
                && self.scheduler.start_by_trigger(rank, now, self.config.profile.event_limit())
            {
                self.too_many_events(now, fx);
            }
        }
    }

    /// An event of the hardware at `now`: it releases the external event tasks of this source
    /// [`profile::EVENT_LATENCY`] later (controller:TASK-40, io:EVT-01). Nothing happens outside RUNNING. More
    /// events than the 2019 profile takes stop the application (controller:TASK-43).
    pub fn external_event(&mut self, source: ExternalEventSource, now: Time, fx: &mut Effects) {
        for rank in 0..self.scheduler.len() {
            if self.state != State::Running || self.scheduler.stopping().is_some() {
                return;
            }
            let limit = self.config.profile.event_limit();
            if self.scheduler.put_event(rank, source, now)
                && self.config.profile == Profile::M241_2019
                && self.scheduler.exceeds_hardware_events(now, limit)
            {
                self.too_many_events(now, fx);
            }
        }
    }

    /// controller:WD-06
    fn too_many_events(&mut self, now: Time, fx: &mut Effects) {
        self.log_entry(now, LogEntry::TooManyEvents, fx);
        self.enter_halt(now, ApplicationError::TooManyEvents, fx);
    }
}
