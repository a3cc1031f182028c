//! What makes the cycles of tasks due: intervals, pauses, variables, events, and what holds tasks back.

use crate::{Controller, Effects, Probe, State, TaskKind};
use profile::{FREEWHEELING_PAUSE, MINIMUM_CYCLE, TRIGGER_TICK};
use signal::{Address, Span, Time};

impl Controller {
    /// When the next cycle becomes due, a trigger is looked at, or a task wakes.
    pub(crate) fn release_due(&self) -> Time {
        let due = self.tasks.iter().fold(self.arrivals.next(), |next, task| next.min(task.next_release));
        due.min(self.tick)
    }

    /// When a task that sleeps or is held back goes on.
    pub(crate) fn wake_due(&self) -> Time {
        let mut next = Time::MAX;
        let mut left = self.cpu.held;
        while left != 0 {
            next = next.min(self.tasks[left.trailing_zeros() as usize].held_until());
            left &= left - 1;
        }
        next
    }

    /// Releases the cycles due at `now`. A release that finds one waiting is lost; the grid of a cyclic task is kept
    /// (controller:TASK-11). After them the variables are looked at that start event tasks.
    pub(crate) fn release(&mut self, now: Time, fx: &mut Effects) {
        for rank in 0..self.tasks.len() {
            while self.tasks[rank].next_release <= now {
                let task = &mut self.tasks[rank];
                let due = task.next_release;
                task.interval = task.set_interval;
                task.next_release = task.interval.map_or(Time::MAX, |interval| due.saturating_add(interval));
                self.make_ready(rank, due);
            }
        }
        while let Some(rank) = self.arrivals.take(now) {
            self.make_ready(rank, now);
        }
        while self.tick <= now {
            self.tick = self.tick.saturating_add(TRIGGER_TICK);
            self.check_triggers(now, fx);
        }
    }

    /// Tasks that slept or were held back until `now` go on.
    pub(crate) fn wake(&mut self, now: Time) {
        let mut left = self.cpu.held;
        while left != 0 {
            let rank = left.trailing_zeros() as usize;
            left &= left - 1;
            if self.tasks[rank].held_until() <= now {
                self.cpu.held &= !(1 << rank);
            }
        }
    }

    /// A cycle of a task is due since `due`; one that is due already takes its place.
    pub(crate) fn make_ready(&mut self, rank: usize, due: Time) {
        let (bit, task) = (1 << rank, &mut self.tasks[rank]);
        if self.cpu.ready & bit != 0 {
            task.figures.lost += 1;
            return;
        }
        task.due = due;
        if self.cpu.active & bit == 0 {
            task.waits_since = due;
        }
        self.cpu.ready |= bit;
    }

    /// Every task starts again at `now`: cyclic and freewheeling ones at once (controller:TR-06, controller:TR-08),
    /// the others with their next event.
    pub(crate) fn release_all(&mut self, now: Time) {
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
                    let level = self.trigger_level(rank);
                    self.tasks[rank].trigger_was = level;
                    self.tick = now.saturating_add(TRIGGER_TICK);
                }
                TaskKind::ExternalEvent { .. } => {}
            }
        }
    }

    /// A cycle of a freewheeling task that took `elapsed` ended at `now`: the next one begins after a pause of 30 %
    /// of both together, of at least a nanosecond (controller:TASK-21).
    pub(crate) fn pause(&mut self, rank: usize, elapsed: Span, now: Time) {
        let (part, of) = FREEWHEELING_PAUSE;
        let whole = i128::from(elapsed.as_nanos()) * i128::from(part) + i128::from(of) - 1;
        let pause = i64::try_from(whole / i128::from(of)).unwrap_or(i64::MAX);
        self.tasks[rank].next_release = now.saturating_add(Span::from_nanos(pause.max(1)));
    }

    /// Starts the event tasks whose variables became TRUE since they were looked at last (controller:TASK-30). This
    /// happens at the end of every task's cycle and every [`TRIGGER_TICK`].
    pub(crate) fn check_triggers(&mut self, now: Time, fx: &mut Effects) {
        if self.tick == Time::MAX {
            return;
        }
        for rank in 0..self.tasks.len() {
            if self.state != State::Running || self.cpu.stopping.is_some() {
                return;
            }
            if self.tasks[rank].trigger.is_none() {
                continue;
            }
            let level = self.trigger_level(rank);
            let was = std::mem::replace(&mut self.tasks[rank].trigger_was, level);
            if level && !was {
                self.software_event(rank, now, fx);
            }
        }
    }

    fn trigger_level(&self, rank: usize) -> bool {
        let trigger = self.tasks.get(rank).and_then(|task| task.trigger);
        trigger.is_some_and(|probe| self.read(&probe).as_bool() == Some(true))
    }

    /// Looks up the variables that start event tasks in a new application.
    pub(crate) fn find_triggers(&mut self) {
        for rank in 0..self.tasks.len() {
            if let TaskKind::Event { trigger } = &self.tasks[rank].kind {
                let application = self.application.as_deref();
                self.tasks[rank].trigger = application.and_then(|it| find_trigger(it, trigger));
            }
        }
    }

    /// The interval of a cyclic task by its place in the configuration: the one that was set last
    /// (controller:TASK-13). `None` for a task of another kind.
    pub fn interval(&self, task: usize) -> Option<Span> {
        self.tasks.iter().find(|at| at.place == task)?.set_interval
    }

    /// Sets the interval of a cyclic task by its place in the configuration; it holds from the next release on
    /// (controller:TASK-13). FALSE, with nothing set, for a task of another kind and for an interval below the
    /// minimum cycle. A download and a boot bring the configured interval back.
    pub fn set_interval(&mut self, task: usize, interval: Span) -> bool {
        match self.tasks.iter_mut().find(|at| at.place == task) {
            Some(task) if task.set_interval.is_some() && interval >= MINIMUM_CYCLE => {
                task.set_interval = Some(interval);
                true
            }
            _ => false,
        }
    }

    /// The task of this rank, which has the processor, gives it to others until `until` (controller:TASK-52). The
    /// time is part of its cycle's elapsed time and no load.
    pub fn sleep(&mut self, rank: usize, until: Time) {
        if let Some(task) = self.tasks.get_mut(rank) {
            task.sleeps_until = until;
            self.cpu.held |= 1 << rank;
        }
    }

    /// A task, by its place in the configuration, does not get the processor until `until`, however much it wants it
    /// (controller:WD-13). Ends when RUNNING is left.
    pub fn suspend(&mut self, task: usize, until: Time) {
        if let Some(rank) = self.tasks.iter().position(|at| at.place == task) {
            self.tasks[rank].suspended_until = until;
            self.cpu.held |= 1 << rank;
        }
    }
}

/// What the trigger of an event task means in an application: an address, or the path of a variable.
pub(crate) fn find_trigger(application: &dyn crate::Application, trigger: &str) -> Option<Probe> {
    if trigger.starts_with('%') {
        return Address::parse(trigger).ok().map(Probe::Address);
    }
    application.variable(trigger).map(Probe::Variable)
}
