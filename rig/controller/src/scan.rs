//! The scan: application code on the one processor, cycle by cycle.

use crate::watch::class;
use crate::{ApplicationFault, Controller, Effects, FaultClass, LogEntry, SliceEnd, State, TaskKind};
use profile::{MINIMUM_CYCLE, StopCause};
use signal::{Cause, Span, Time};

/// What a step of the processor did.
enum Step {
    /// Time may go on.
    Go,
    /// Nothing completes before the end of the span that was given.
    Wait,
}

impl Controller {
    /// Lets application code run up to and including `limit`, and hands back how far it went: to `limit`, to the
    /// next timer, or to the instant at which something happened, whichever comes first. The instants handed back
    /// never go backwards.
    ///
    /// Operations that complete at `limit` take effect, cycles that end there write their outputs; a cycle that could
    /// start there starts with the next call, when everything else of that instant is known.
    pub fn run(&mut self, limit: Time, fx: &mut Effects) -> Time {
        self.refresh_watches();
        let before = fx.len();
        loop {
            if fx.len() > before {
                return self.cpu.at;
            }
            let end = self.next_timer().map_or(limit, |timer| timer.min(limit));
            if self.state != State::Running {
                self.cpu.at = self.cpu.at.max(end);
                return end;
            }
            if self.cpu.at >= end {
                return end;
            }
            match self.step(end, fx) {
                Step::Go => {}
                Step::Wait => return end,
            }
        }
    }

    /// Whether application code wants the processor now: without it, nothing but [`Controller::next_timer`] brings
    /// anything about.
    #[inline]
    pub fn is_computing(&self) -> bool {
        self.state == State::Running && (self.runnable() != 0 || self.cpu.in_flight.is_some())
    }

    /// Ranks that want the processor.
    #[inline]
    pub(crate) fn runnable(&self) -> u32 {
        let wanted = match self.cpu.stopping {
            None if self.pending.is_none() => self.cpu.active | self.cpu.ready,
            _ => self.cpu.active,
        };
        wanted & !self.cpu.held
    }

    fn step(&mut self, end: Time, fx: &mut Effects) -> Step {
        let runnable = self.runnable();
        if runnable == 0 {
            self.cpu.at = end;
            return Step::Wait;
        }
        let chosen = self.chosen(runnable);
        // controller:TASK-03: pre-emption waits for the operation under way.
        let (rank, cap) = match self.cpu.in_flight {
            Some(until) if self.cpu.running != chosen => (self.cpu.running, until),
            _ => (chosen, end),
        };
        if cap > end {
            return Step::Wait;
        }
        let end = cap;
        let cap = if rank == chosen { self.start_time_slice(rank, cap) } else { cap };
        self.cpu.running = rank;
        if self.tasks[rank].foreground() && self.cpu.at > self.cpu.busy_until {
            self.cpu.busy_since = self.cpu.at;
            self.cpu.busy_until = self.cpu.at;
        }
        if self.cpu.active >> rank & 1 == 0 {
            self.start_cycle(rank, fx);
            return Step::Go;
        }
        self.execute(rank, cap, end, fx)
    }

    /// Runs the cycle of a task up to `cap`, which is the end of its turn or `end`.
    fn execute(&mut self, rank: usize, cap: Time, end: Time, fx: &mut Effects) -> Step {
        if let Some(rest) = self.tasks[rank].cycle.rest {
            let used = rest.min(cap - self.cpu.at);
            self.tasks[rank].cycle.rest = Some(rest - used);
            self.pass(rank, used);
            if used == rest {
                self.end_cycle(rank, fx);
            }
            return Step::Go;
        }
        let (place, before, mut cap) = (self.tasks[rank].place, fx.len(), cap);
        self.functions.expert_mut().enter(place);
        loop {
            let Some(application) = &mut self.application else { return Step::Wait };
            let budget = cap - self.cpu.at;
            let slice =
                application.resume(place, self.cpu.at, budget, &mut self.memory, self.functions.expert_mut());
            self.cpu.in_flight = None;
            self.pass(rank, slice.used);
            match slice.end {
                SliceEnd::Budget { next } => {
                    if slice.used < budget {
                        // It is under way; at least a nanosecond, so that a cost of 0 cannot hold up the time.
                        let until = self.cpu.at.saturating_add(next.max(Span::from_nanos(1)));
                        self.cpu.in_flight = Some(until);
                        if until > end || slice.used == Span::ZERO && cap == end {
                            return Step::Wait;
                        }
                    }
                }
                SliceEnd::Touched => {
                    let (at, cause) = (self.cpu.at, self.memory.cause());
                    self.observe_memory(at, cause, fx);
                    self.check_plc_w(at, fx);
                    self.observe(class::EXPERT, at, cause, fx);
                    // What a block began comes in time.
                    cap = cap.min(self.functions.next().max(at));
                    if self.cpu.held >> rank & 1 == 1 || !self.still_running() {
                        return Step::Go;
                    }
                    if fx.len() > before {
                        // What completes without further time still belongs to this instant: watching must not move
                        // the end of a cycle behind a watchdog.
                        cap = at;
                    }
                    continue;
                }
                SliceEnd::Done => {
                    let cycle = &mut self.tasks[rank].cycle;
                    if cycle.used < cycle.least {
                        cycle.rest = Some(cycle.least - cycle.used);
                    } else {
                        self.end_cycle(rank, fx);
                    }
                }
                SliceEnd::Break => self.enter_breakpoint(place, fx),
                SliceEnd::SystemCall { call, argument } => {
                    self.answer_call(rank, call, argument);
                    if self.cpu.held >> rank & 1 == 1 {
                        return Step::Go;
                    }
                    continue;
                }
                SliceEnd::Fault(fault) => self.fault(rank, fault, fx),
            }
            return Step::Go;
        }
    }

    /// Processor time passes for a task.
    #[inline]
    fn pass(&mut self, rank: usize, used: Span) {
        self.load.advance(self.cpu.at, None, &mut self.tasks);
        self.cpu.at += used;
        self.load.advance(self.cpu.at, Some(rank), &mut self.tasks);
        self.use_time_slice(rank, used);
        let task = &mut self.tasks[rank];
        task.cycle.used = task.cycle.used + used;
        task.waits_since = self.cpu.at;
        if task.foreground() {
            self.cpu.busy_until = self.cpu.at;
        }
    }

    /// Phase 1 of a cycle (controller:TASK-10): the inputs that the task uses -> %I (controller:PRIO-04).
    fn start_cycle(&mut self, rank: usize, fx: &mut Effects) {
        let at = self.cpu.at;
        self.write_late(rank, at, fx);
        self.exchange_inputs(rank, at, fx);
        self.cpu.ready &= !(1 << rank);
        self.cpu.active |= 1 << rank;
        let task = &mut self.tasks[rank];
        task.start(at, MINIMUM_CYCLE);
        let place = task.place;
        self.start_first_cycle(place);
        self.functions.expert_mut().sample(at, place);
        if let Some(application) = &mut self.application {
            application.begin(place);
        }
    }

    /// Phase 3 of a cycle (controller:TASK-10): %Q of the task's outputs, adjusted for forcing, -> outputs.
    fn end_cycle(&mut self, rank: usize, fx: &mut Effects) {
        let at = self.cpu.at;
        let task = &mut self.tasks[rank];
        let (place, elapsed) = (task.place, task.end(at));
        let over = task.overran(elapsed);
        if matches!(task.kind, TaskKind::Freewheeling) {
            self.pause(rank, elapsed, at);
        }
        self.end_time_slice(rank);
        self.cpu.active &= !(1 << rank);
        self.exchange_outputs(rank, at, fx);
        if over {
            self.log_entry(at, LogEntry::Overrun { task: place, elapsed }, fx);
        }
        // A context is consistent only while no cycle is half done (controller:REM-07).
        self.end_first_cycle(place);
        if self.cpu.active == 0 {
            self.save_if_dirty(at);
            self.change(at, fx);
            if let Some(cause) = self.cpu.stopping {
                self.enter_stopped(at, cause, fx);
            }
        }
        self.check_triggers(at, fx);
        self.observe(class::FIGURE, at, Cause::Controller, fx);
    }

    /// Starts a save of the remanent variables where one changed.
    #[inline]
    pub(crate) fn save_if_dirty(&mut self, at: Time) {
        let Some(application) = &mut self.application else { return };
        let dirty = application.retained_dirty() | self.memory.take_remanent_dirty();
        self.context.dirty |= dirty;
        self.context.start(at, &**application, &self.memory);
    }

    /// An operation failed (controller:ERR-01).
    fn fault(&mut self, rank: usize, fault: ApplicationFault, fx: &mut Effects) {
        let at = self.cpu.at;
        let task = self.tasks[rank].place;
        self.log_entry(at, LogEntry::Fault { task, fault }, fx);
        match fault.class {
            FaultClass::Application => self.enter_halt(at, fault.error, fx),
            FaultClass::System => self.system_error(at, StopCause::Exception, fault.error, fx),
        }
    }
}
