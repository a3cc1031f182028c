//! The scan: application code on the one processor, cycle by cycle.

use super::Controller;
use crate::application::SliceEnd;
use crate::probes::class;
use crate::scheduler::NextStep;
use crate::{ApplicationFault, Effects, FaultClass, LogEntry, State};
use profile::StopCause;
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
                return self.scheduler.now();
            }
            let end = self.next_timer().map_or(limit, |timer| timer.min(limit));
            if self.is_port_turn(end) {
                self.run_ports(end, fx);
                continue;
            }
            if self.state != State::Running {
                self.scheduler.skip_to(end);
                return end;
            }
            if self.scheduler.now() >= end {
                return end;
            }
            match self.step(end, fx) {
                Step::Go => {}
                Step::Wait => return end,
            }
        }
    }

    /// Whether application code or an endpoint wants the processor now: without them, nothing but
    /// [`Controller::next_timer`] brings anything about.
    #[inline]
    pub fn is_computing(&self) -> bool {
        self.state == State::Running && self.scheduler.is_computing() || self.ports.is_busy()
    }

    /// Whether the processor is an endpoint's now, up to `end` at most: no task wants it.
    #[inline]
    fn is_port_turn(&self, end: Time) -> bool {
        self.ports.is_busy()
            && self.scheduler.now() < end
            && (self.state != State::Running || self.scheduler.is_idle())
    }

    fn step(&mut self, end: Time, fx: &mut Effects) -> Step {
        match self.scheduler.next_step(end) {
            NextStep::Wait => Step::Wait,
            NextStep::StartCycle(rank) => {
                self.start_cycle(rank, fx);
                Step::Go
            }
            NextStep::Execute { rank, cap, end } => self.execute(rank, cap, end, fx),
        }
    }

    /// Runs the cycle of a task up to `cap`, which is the end of its time slice or `end`.
    fn execute(&mut self, rank: usize, cap: Time, end: Time, fx: &mut Effects) -> Step {
        if let Some(over) = self.scheduler.run_rest(rank, cap) {
            if over {
                self.end_cycle(rank, fx);
            }
            return Step::Go;
        }
        let (place, before, mut cap) = (self.scheduler.place(rank), fx.len(), cap);
        self.io.expert_mut().enter(place);
        loop {
            let Some(application) = &mut self.application else { return Step::Wait };
            let at = self.scheduler.now();
            let budget = cap - at;
            let slice = application.resume(place, at, budget, &mut self.memory, self.io.expert_mut());
            self.scheduler.complete(rank, slice.used);
            match slice.end {
                SliceEnd::Budget { next } => {
                    if slice.used < budget {
                        let until = self.scheduler.begin_operation(next);
                        if until > end || slice.used == Span::ZERO && cap == end {
                            return Step::Wait;
                        }
                    }
                }
                SliceEnd::Touched => {
                    let (at, cause) = (self.scheduler.now(), self.memory.cause());
                    self.observe_memory(at, cause, fx);
                    self.check_commands(at, fx);
                    self.observe(class::EXPERT, at, cause, fx);
                    // What a block began comes in time.
                    cap = cap.min(self.io.functions_due().max(at));
                    if self.scheduler.is_held(rank) || self.state != State::Running {
                        return Step::Go;
                    }
                    if fx.len() > before {
                        // What completes without further time still belongs to this instant: watching must not move
                        // the end of a cycle past a watchdog.
                        cap = at;
                    }
                    continue;
                }
                SliceEnd::Done => {
                    if self.scheduler.is_cycle_over(rank) {
                        self.end_cycle(rank, fx);
                    }
                }
                SliceEnd::Break => self.enter_breakpoint(place, fx),
                SliceEnd::SystemCall { call, argument } => {
                    self.answer_call(rank, call, argument, fx);
                    if self.scheduler.is_held(rank) {
                        return Step::Go;
                    }
                    continue;
                }
                SliceEnd::Fault(fault) => self.fault(place, fault, fx),
            }
            return Step::Go;
        }
    }

    /// Phase 1 of a cycle (controller:TASK-10): the inputs that the task uses -> %I (controller:PRIO-04).
    fn start_cycle(&mut self, rank: usize, fx: &mut Effects) {
        let (at, place) = (self.scheduler.now(), self.scheduler.place(rank));
        self.write_late(place, at, fx);
        self.exchange_inputs(Some(rank), at, fx);
        self.scheduler.start_cycle(rank);
        if self.scheduler.is_mast(place) {
            self.system.first_cycle.begin_cycle();
        }
        self.io.expert_mut().sample(at, place);
        if let Some(application) = &mut self.application {
            application.begin(place);
        }
    }

    /// Phase 3 of a cycle (controller:TASK-10): %Q of the task's outputs, adjusted for forcing, -> outputs.
    fn end_cycle(&mut self, rank: usize, fx: &mut Effects) {
        let at = self.scheduler.now();
        let end = self.scheduler.end_cycle(rank);
        self.exchange_outputs(Some(rank), at, fx);
        if end.overran {
            self.log_entry(at, LogEntry::Overrun { task: end.place, elapsed: end.elapsed }, fx);
        }
        // A context is consistent only while no cycle is half done (controller:REM-07).
        if self.scheduler.is_mast(end.place) {
            self.system.first_cycle.end_cycle();
        }
        if self.scheduler.is_between_cycles() {
            self.save_if_dirty(at);
            self.change(at, fx);
            if let Some(cause) = self.scheduler.stopping() {
                self.enter_stopped(at, cause, fx);
            }
        }
        self.check_triggers(at, fx);
        self.observe(class::FIGURE, at, Cause::Controller, fx);
    }

    /// Starts a save of the remanent variables where one changed.
    #[inline]
    pub(super) fn save_if_dirty(&mut self, at: Time) {
        let Some(application) = &mut self.application else { return };
        let dirty = application.retained_dirty() | self.memory.take_remanent_dirty();
        self.remanent.dirty |= dirty;
        self.remanent.start(at, &**application, &self.memory);
    }

    /// An operation failed (controller:ERR-01).
    fn fault(&mut self, task: usize, fault: ApplicationFault, fx: &mut Effects) {
        let at = self.scheduler.now();
        self.log_entry(at, LogEntry::Fault { task, fault }, fx);
        match fault.class {
            FaultClass::Application => self.enter_halt(at, fault.error, fx),
            FaultClass::System => self.system_error(at, StopCause::Exception, fault.error, fx),
        }
    }
}
