//! What makes the cycles of tasks due: intervals, pauses, variables, events, and what holds tasks back.

use super::Scheduler;
use super::load::Load;
use crate::application::Application;
use crate::config::TaskKind;
use crate::event_source::ExternalEventSource;
use profile::{EVENT_LATENCY, FREEWHEELING_PAUSE, MINIMUM_CYCLE, TRIGGER_TICK};
use signal::{Address, Span, Time};

/// What starts an event task (controller:TASK-30).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TaskTrigger {
    /// A bit of memory.
    Address(Address),
    /// A variable of the application by its number.
    Variable(u32),
}

impl TaskTrigger {
    /// What the trigger of a configuration means in an application: an address, or the path of a variable.
    pub(crate) fn find(application: &dyn Application, trigger: &str) -> Option<TaskTrigger> {
        if trigger.starts_with('%') {
            return Address::parse(trigger).ok().map(TaskTrigger::Address);
        }
        application.variable(trigger).map(TaskTrigger::Variable)
    }
}

impl Scheduler {
    /// When the next cycle becomes due, or a trigger is looked at.
    pub(crate) fn release_due(&self) -> Time {
        let due = self.tasks.iter().fold(self.events.next(), |next, task| next.min(task.next_release));
        due.min(self.tick)
    }

    /// When a task that sleeps or is suspended goes on.
    pub(crate) fn wake_due(&self) -> Time {
        let mut next = Time::MAX;
        let mut left = self.held;
        while left != 0 {
            next = next.min(self.tasks[left.trailing_zeros() as usize].held_until());
            left &= left - 1;
        }
        next
    }

    /// Releases the cycles due at `now`. A release that finds one waiting is lost; the grid of a cyclic task is kept
    /// (controller:TASK-11).
    pub(crate) fn release(&mut self, now: Time) {
        for rank in 0..self.tasks.len() {
            while self.tasks[rank].next_release <= now {
                let task = &mut self.tasks[rank];
                let due = task.next_release;
                task.interval = task.set_interval;
                task.next_release = task.interval.map_or(Time::MAX, |interval| due.saturating_add(interval));
                self.make_ready(rank, due);
            }
        }
        while let Some(rank) = self.events.take(now) {
            self.make_ready(rank, now);
        }
    }

    /// Whether the triggers of event tasks are to be looked at by `now`, once for each tick.
    pub(crate) fn take_tick(&mut self, now: Time) -> bool {
        let due = self.tick <= now;
        if due {
            self.tick = self.tick.saturating_add(TRIGGER_TICK);
        }
        due
    }

    /// Whether an event task waits for its trigger.
    pub(crate) fn has_triggers(&self) -> bool {
        self.tick != Time::MAX
    }

    /// What starts the event task of this rank.
    pub(crate) fn trigger(&self, rank: usize) -> Option<TaskTrigger> {
        self.tasks[rank].trigger
    }

    /// The trigger of this rank has this level: whether it rose (controller:TASK-30).
    pub(crate) fn trigger_rose(&mut self, rank: usize, level: bool) -> bool {
        let was = std::mem::replace(&mut self.tasks[rank].trigger_was, level);
        level && !was
    }

    /// Looks up the triggers of event tasks in a new application.
    pub(crate) fn find_triggers(&mut self, application: Option<&dyn Application>) {
        for task in &mut self.tasks {
            if let TaskKind::Event { trigger } = &task.kind {
                task.trigger = application.and_then(|it| TaskTrigger::find(it, trigger));
            }
        }
    }

    /// Tasks that slept or were suspended until `now` go on.
    pub(crate) fn wake(&mut self, now: Time) {
        let mut left = self.held;
        while left != 0 {
            let rank = left.trailing_zeros() as usize;
            left &= left - 1;
            if self.tasks[rank].held_until() <= now {
                self.held &= !(1 << rank);
            }
        }
    }

    /// A cycle of a task is due since `due`; where one is due already, the later release is lost.
    fn make_ready(&mut self, rank: usize, due: Time) {
        let (bit, task) = (1 << rank, &mut self.tasks[rank]);
        if self.ready & bit != 0 {
            task.figures.lost += 1;
            return;
        }
        task.due = due;
        if self.active & bit == 0 {
            task.waits_since = due;
        }
        self.ready |= bit;
    }

    /// RUNNING is entered at `now`: cyclic and freewheeling tasks start at once (controller:TR-06, controller:TR-08), the
    /// others with their next event. `level` reads a trigger.
    pub(crate) fn begin_running(&mut self, now: Time, level: impl Fn(TaskTrigger) -> bool) {
        self.tick = Time::MAX;
        for rank in 0..self.tasks.len() {
            let task = &mut self.tasks[rank];
            task.begin_running();
            match task.kind {
                TaskKind::Cyclic { .. } => {
                    task.next_release =
                        task.interval.map_or(Time::MAX, |interval| now.saturating_add(interval));
                    self.make_ready(rank, now);
                }
                TaskKind::Freewheeling => self.make_ready(rank, now),
                TaskKind::Event { .. } => {
                    // A level is no edge (controller:TASK-30).
                    task.trigger_was = task.trigger.is_some_and(&level);
                    self.tick = now.saturating_add(TRIGGER_TICK);
                }
                TaskKind::ExternalEvent { .. } => {}
            }
        }
        self.load = Load::new(now, &self.tasks);
    }

    /// A cycle of a freewheeling task that took `elapsed` ended: the next one begins after a pause of 30 % of both
    /// together, of at least a nanosecond (controller:TASK-21).
    pub(super) fn pause(&mut self, rank: usize, elapsed: Span) {
        let (part, of) = FREEWHEELING_PAUSE;
        let whole = i128::from(elapsed.as_nanos()) * i128::from(part) + i128::from(of) - 1;
        let pause = i64::try_from(whole / i128::from(of)).unwrap_or(i64::MAX);
        self.tasks[rank].next_release = self.at.saturating_add(Span::from_nanos(pause.max(1)));
    }

    /// An event of the hardware at `now` is on its way to the task of this rank, where that waits for it
    /// (controller:TASK-40, io:EVT-01).
    pub(crate) fn put_event(&mut self, rank: usize, source: ExternalEventSource, now: Time) -> bool {
        if self.tasks[rank].source != Some(source) {
            return false;
        }
        if !self.events.put(now.saturating_add(EVENT_LATENCY), rank) {
            self.tasks[rank].figures.lost += 1;
        }
        true
    }

    /// Counts an event of the hardware: whether there are more than the limit (controller:TASK-43).
    pub(crate) fn exceeds_hardware_events(&mut self, now: Time, limit: usize) -> bool {
        self.hardware_rate.exceeded(now, limit)
    }

    /// A trigger starts the task of this rank: whether there are more such events than the limit (controller:TASK-31).
    pub(crate) fn start_by_trigger(&mut self, rank: usize, now: Time, limit: usize) -> bool {
        self.make_ready(rank, now);
        self.software_rate.exceeded(now, limit)
    }

    /// The interval of a cyclic task by its place: the one that was set last (controller:TASK-13).
    pub(crate) fn interval(&self, place: usize) -> Option<Span> {
        self.task(place)?.set_interval
    }

    /// Sets the interval of a cyclic task from the next release on (controller:TASK-13); FALSE where it cannot be.
    pub(crate) fn set_interval(&mut self, place: usize, interval: Span) -> bool {
        match self.task_mut(place) {
            Some(task) if task.set_interval.is_some() && interval >= MINIMUM_CYCLE => {
                task.set_interval = Some(interval);
                true
            }
            _ => false,
        }
    }

    /// The task of this rank gives the processor to others until `until` (controller:TASK-52).
    pub(crate) fn sleep(&mut self, rank: usize, until: Time) {
        if let Some(task) = self.tasks.get_mut(rank) {
            task.sleeps_until = until;
            self.held |= 1 << rank;
        }
    }

    /// The task at this place does not get the processor until `until` (controller:WD-13).
    pub(crate) fn suspend(&mut self, place: usize, until: Time) {
        if let Some(rank) = self.tasks.iter().position(|task| task.place == place) {
            self.tasks[rank].suspended_until = until;
            self.held |= 1 << rank;
        }
    }

    /// Whether the task of this rank sleeps or is suspended.
    #[inline]
    pub(crate) const fn is_held(&self, rank: usize) -> bool {
        self.held >> rank & 1 == 1
    }
}
