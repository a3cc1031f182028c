//! The executor: one loop that brings subject, board and steps together on a clock, virtual or not.
//!
//! At one instant the order is: operations of the program that complete, changes of the board, steps of the plan,
//! timers of the controller (docs/decisions/0003-time-of-an-operation.md).

mod act;
mod alarms;
mod teardown;

use crate::clock::Clock;
use crate::operator::Operator;
use crate::prepare::Armed;
use crate::recorder::Recorder;
use crate::schedule::{EndReason, Schedule};
use crate::stepping::{Stepper, Stepping};
use crate::subject::Subject;
use crate::trouble::Trouble;
use crate::wiring::Wiring;
use controller::{Command, Effect, Effects, Probe, State};
use drivers::{Board, BoardEvent, ChannelId, LossReason, Origin, TimestampSource};
use plans::plan::Phase;
use signal::{Cause, Level, Span, Time, Value, When};
use std::sync::atomic::{AtomicBool, Ordering};

/// Turns of the loop without a moment of time passing: more is a circuit that oscillates for ever in no time.
const MOST_SIMULTANEOUS: u32 = 1_000_000;

/// How long the subject may take to reach the state that the case begins in, in modelled time.
const PRELUDE: Span = Span::from_secs(60);

/// Lines that a case's log keeps.
const LOG_LINES: usize = 1_000;

/// What the executor is told of a case.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// The state in which the case begins.
    pub initial: State,
    /// The longest that the rig may be late before its verdict is `error`.
    pub late: Span,
    /// The longest that the application may run on before the rest of the rig is looked after; `Span::MAX` leaves
    /// it to the events. Never shows in the trace.
    pub slice: Span,
    /// The case ends when a claim is lost.
    pub fail_fast: bool,
    /// Most modelled time from power-on to the end.
    pub timeout: Span,
    /// Most modelled time of the teardown.
    pub teardown: Span,
}

/// What a case's run leaves besides its trace.
#[derive(Debug, Default)]
pub struct Ran {
    /// When the case's own time began.
    pub start: Option<Time>,
    /// The end of the case: its teardown comes behind.
    pub end: Time,
    /// The last instant.
    pub closed: Time,
    /// Trouble of the rig: the verdict is then `error`.
    pub trouble: Option<Trouble>,
    /// Deadlines of the rig that it missed.
    pub overruns: u64,
    /// Events that the board lost.
    pub dropped: u64,
    /// The log.
    pub log: Vec<(Time, String)>,
    /// Log lines that found no room.
    pub log_dropped: u64,
}

/// Runs one case.
pub struct Executor<'a> {
    clock: &'a mut dyn Clock,
    subject: &'a mut dyn Subject,
    board: &'a mut dyn Board,
    recorder: &'a mut Recorder,
    schedule: &'a mut Schedule,
    wiring: &'a mut Wiring,
    alarms: &'a mut Vec<Armed>,
    limits: Limits,
    interrupt: &'a AtomicBool,
    operator: Option<&'a dyn Operator>,
    effects: Effects,
    spare: Vec<Effect>,
    writes: Vec<(ChannelId, Value)>,
    polled: Vec<BoardEvent>,
    /// What each channel was driven to last, to be driven back to after a pulse.
    driven: Vec<Value>,
    restore: Vec<Value>,
    /// Instant that the rig has reached: modelled, and on the clock.
    now: Time,
    actual: Time,
    /// The board's lines are modelled: they live in the controller's time, and a rig that is late only knows less
    /// exactly when things happened. Wires have the clock's time.
    modelled: bool,
    same: u32,
    over: bool,
    /// The outputs were driven to their safe values.
    safe: bool,
    ran: Ran,
    /// Somebody who goes through the case step by step.
    stepping: Option<Stepping<'a>>,
}

impl std::fmt::Debug for Executor<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Executor").field("now", &self.now).field("ran", &self.ran).finish_non_exhaustive()
    }
}

/// Nothing stays driven behind a run that panics.
impl Drop for Executor<'_> {
    fn drop(&mut self) {
        if !self.safe {
            // The board itself may be what panicked: a second panic would end the process.
            let safe = std::panic::AssertUnwindSafe(|| self.board.safe(self.board_time()));
            let _ = std::panic::catch_unwind(safe);
        }
    }
}

/// The parts that an executor brings together.
pub struct Parts<'a> {
    /// Wakes it.
    pub clock: &'a mut dyn Clock,
    /// Is under test.
    pub subject: &'a mut dyn Subject,
    /// Is between the subject and the world.
    pub board: &'a mut dyn Board,
    /// Keeps what is seen.
    pub recorder: &'a mut Recorder,
    /// Says what is done when.
    pub schedule: &'a mut Schedule,
    /// Says who is behind whom.
    pub wiring: &'a mut Wiring,
    /// The alarms.
    pub alarms: &'a mut Vec<Armed>,
    /// Ends the case early when it becomes TRUE.
    pub interrupt: &'a AtomicBool,
    /// Can be asked.
    pub operator: Option<&'a dyn Operator>,
}

impl std::fmt::Debug for Parts<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Parts").finish_non_exhaustive()
    }
}

impl<'a> Executor<'a> {
    /// An executor at time 0.
    pub fn new(parts: Parts<'a>, limits: Limits) -> Executor<'a> {
        let channels = parts.board.channels();
        let driven: Vec<Value> = channels.iter().map(|channel| channel.safe).collect();
        let modelled = channels.iter().all(|channel| channel.timestamp == TimestampSource::Virtual);
        Executor {
            effects: Effects::new(),
            spare: Vec::with_capacity(256),
            writes: Vec::with_capacity(channels.len()),
            polled: Vec::with_capacity(1024),
            restore: driven.clone(),
            driven,
            clock: parts.clock,
            subject: parts.subject,
            board: parts.board,
            recorder: parts.recorder,
            schedule: parts.schedule,
            wiring: parts.wiring,
            alarms: parts.alarms,
            interrupt: parts.interrupt,
            operator: parts.operator,
            limits,
            now: Time::ZERO,
            actual: Time::ZERO,
            modelled,
            same: 0,
            over: false,
            safe: false,
            ran: Ran { log: Vec::with_capacity(64), ..Ran::default() },
            stepping: None,
        }
    }

    /// The same, and `stepper` is asked before each step of the plan.
    #[must_use]
    pub fn stepping(mut self, stepper: &'a mut dyn Stepper) -> Executor<'a> {
        self.stepping = Some(Stepping::new(stepper));
        self
    }

    /// Runs the case from power-on to its end and its teardown, then drives every output to its safe value.
    pub fn run(mut self) -> Ran {
        let outcome = self.prelude().and_then(|()| self.main());
        if let Err(trouble) = outcome {
            self.ran.trouble.get_or_insert(trouble);
        }
        self.ran.end = self.now;
        // What comes behind the end raises no alarm.
        self.alarms.clear();
        if let Some(mark) = self.wiring.end {
            self.recorder.mark(mark, self.seen(self.now));
        }
        if self.ran.start.is_some() {
            self.tear_down();
        }
        self.ran.closed = self.now;
        self.safe = true;
        let at = self.board_time();
        if let Err(error) = self.board.safe(at) {
            self.ran.trouble.get_or_insert(Trouble::Board { at, error });
        }
        let health = self.board.health();
        self.ran.dropped = health.dropped;
        if !health.is_sound() {
            self.ran.trouble.get_or_insert(Trouble::Unsound { at: self.now, health });
        }
        if let Some(error) = self.recorder.take_fault() {
            self.ran.trouble.get_or_insert(Trouble::Trace(error));
        }
        std::mem::take(&mut self.ran)
    }

    /// Brings the subject into the state in which the case begins.
    fn prelude(&mut self) -> Result<(), Trouble> {
        self.board.start(Time::ZERO).map_err(|error| Trouble::Board { at: Time::ZERO, error })?;
        self.show_initial()?;
        let initial = self.limits.initial;
        if initial != State::Off {
            self.subject.power(Time::ZERO, true, &mut self.effects);
            self.apply()?;
        }
        let mut commanded = false;
        loop {
            let state = self.subject.state();
            if state == initial {
                break;
            }
            let settled = matches!(state, State::Stopped | State::Running | State::Empty);
            if settled && !commanded {
                commanded = true;
                let command = if initial == State::Running { Command::Run } else { Command::Stop };
                let at = self.now;
                self.subject
                    .command(at, &command, &mut self.effects)
                    .map_err(|refusal| Trouble::Prelude { state, refusal: Some(refusal) })?;
                self.apply()?;
                continue;
            }
            if self.now > Time::ZERO + PRELUDE || !self.turn(Time::ZERO + PRELUDE + Span::from_secs(1))? {
                return Err(Trouble::Prelude { state, refusal: None });
            }
        }
        self.ran.start = Some(self.now);
        if let Some(mark) = self.wiring.start {
            self.recorder.mark(mark, self.seen(self.now));
        }
        self.schedule.start(self.now);
        self.arm();
        Ok(())
    }

    /// What every observed probe shows before anything happens.
    fn show_initial(&mut self) -> Result<(), Trouble> {
        if let Some(signal) = self.wiring.state {
            let state = Value::Int(self.subject.state().number());
            self.recorder.record(signal, When::exactly(Time::ZERO), state, Cause::Controller);
        }
        self.writes.clear();
        for (output, channel) in self.wiring.outputs.iter().enumerate() {
            if let Some(channel) = channel {
                self.writes.push((*channel, self.subject.read(&Probe::Terminal(output))));
                self.wiring.writers[usize::from(channel.0)] = Cause::Controller;
            }
        }
        let written = self.board.write(Time::ZERO, &self.writes);
        written.map_err(|error| Trouble::Board { at: Time::ZERO, error })?;
        self.poll()
    }

    fn main(&mut self) -> Result<(), Trouble> {
        // Steps at the start itself come before the first operation of the first cycle.
        while !self.over {
            let timeout = Time::ZERO.saturating_add(self.limits.timeout);
            let end = self.schedule.end().unwrap_or(Time::MAX);
            if !self.turn(end.min(timeout))? {
                if self.now >= timeout && end > timeout {
                    return Err(Trouble::Timeout { limit: self.limits.timeout });
                }
                break;
            }
        }
        Ok(())
    }

    /// One turn: everything up to the next instant at which something happens. FALSE at `end`, or when nothing
    /// will ever happen again.
    fn turn(&mut self, end: Time) -> Result<bool, Trouble> {
        let timer = self.subject.next_timer().unwrap_or(Time::MAX);
        let board = self.board.next_event().unwrap_or(Time::MAX);
        let step = self.schedule.next_due().unwrap_or(Time::MAX);
        let alarm = self.next_alarm().unwrap_or(Time::MAX);
        let wake = self.stepping.as_ref().map_or(Time::MAX, |stepping| stepping.wake(self.now));
        let slice = self.now.saturating_add(self.limits.slice);
        let due = timer.min(board).min(step).min(alarm).min(end).min(slice).min(wake);
        if due == Time::MAX {
            return Err(Trouble::Stuck { at: self.now });
        }
        let due = due.max(self.now);
        let reached = self.subject.run(due, &mut self.effects);
        self.pass(reached)?;
        if !self.effects.list.is_empty() {
            self.apply()?;
            return Ok(true);
        }
        if reached < due {
            return Ok(true);
        }
        if board <= due {
            self.poll()?;
        }
        if step <= due {
            self.steps(due)?;
        }
        if alarm <= due {
            self.raise_due();
        }
        if self.over
            || self.schedule.ended().is_some() && self.schedule.phase() != Phase::Teardown
            || due >= end
        {
            // Whatever is due at the end itself still belongs to the case, but no step comes after it.
            self.fire(due)?;
            return Ok(false);
        }
        self.fire(due)?;
        if wake <= due {
            self.pause(None)?;
        }
        if self.schedule.phase() == Phase::Teardown {
            return Ok(true);
        }
        if self.interrupt.load(Ordering::Relaxed) {
            return Err(Trouble::Interrupted);
        }
        if self.limits.fail_fast && self.recorder.failed_early() {
            self.schedule.end_early(EndReason::Claim, self.now);
            return Ok(false);
        }
        Ok(true)
    }

    fn fire(&mut self, due: Time) -> Result<(), Trouble> {
        if self.subject.next_timer().is_some_and(|timer| timer <= due) {
            self.subject.fire(due, &mut self.effects);
            self.apply()?;
        }
        Ok(())
    }

    /// Time passes to `to`: waits for it, and takes note of how late the wait ended.
    #[inline]
    fn pass(&mut self, to: Time) -> Result<(), Trouble> {
        if to > self.now {
            self.same = 0;
            self.now = to;
        } else {
            self.same += 1;
            if self.same > MOST_SIMULTANEOUS {
                return Err(Trouble::Simultaneous { at: self.now });
            }
        }
        self.actual = self.clock.wait_until(to).max(self.actual);
        let late = self.actual - to;
        if late > Span::ZERO {
            self.recorder.note_late(late);
            if late > self.limits.late {
                self.ran.overruns += 1;
                self.ran.trouble.get_or_insert(Trouble::Late { at: to, late, limit: self.limits.late });
            }
        }
        Ok(())
    }

    /// Carries out what the subject did.
    fn apply(&mut self) -> Result<(), Trouble> {
        if self.effects.list.is_empty() {
            return Ok(());
        }
        std::mem::swap(&mut self.effects.list, &mut self.spare);
        self.writes.clear();
        for index in 0..self.spare.len() {
            let effect = self.spare[index];
            match effect {
                Effect::Terminal { output, level, cause, .. } => {
                    let Some(channel) = self.wiring.output(output) else { continue };
                    self.wiring.writers[usize::from(channel.0)] = cause;
                    self.writes.push((channel, Value::from(level)));
                }
                Effect::State { at, state } => {
                    if let Some(signal) = self.wiring.state {
                        let at = self.seen(at);
                        self.record(signal, at, Value::Int(state.number()), Cause::Controller);
                    }
                }
                Effect::Changed { at, probe, value, cause } => {
                    let at = self.seen(at);
                    for place in 0..self.wiring.probes.get(probe.0 as usize).map_or(0, Vec::len) {
                        let signal = self.wiring.probes[probe.0 as usize][place];
                        self.record(signal, at, value, cause);
                    }
                }
                Effect::Log { at, entry } => {
                    if self.ran.log.len() < LOG_LINES {
                        self.ran.log.push((at, crate::log::show(&entry, &*self.subject)));
                    } else {
                        self.ran.log_dropped += 1;
                    }
                }
            }
        }
        self.spare.clear();
        if !self.writes.is_empty() {
            let writes = std::mem::take(&mut self.writes);
            let at = self.board_time();
            let written = self.board.write(at, &writes);
            self.writes = writes;
            written.map_err(|error| Trouble::Board { at, error })?;
            self.poll()?;
        }
        Ok(())
    }

    /// When something that happened at a modelled instant was seen: exactly in virtual time, else up to now.
    fn seen(&self, at: Time) -> When {
        if self.clock.is_exact() { When::exactly(at) } else { When::within(at, self.actual) }
    }

    /// When something that the board saw happened. What a late rig did to a wire, it should have done earlier.
    fn seen_by_board(&self, at: When) -> When {
        match (self.clock.is_exact(), self.modelled) {
            (true, _) => at,
            (false, true) => When::within(at.earliest, at.latest.max(self.actual)),
            (false, false) => When::within(at.earliest.saturating_add(-self.recorder.late()), at.latest),
        }
    }

    /// The instant that the rig has reached in the board's time.
    const fn board_time(&self) -> Time {
        if self.modelled { self.now } else { self.actual }
    }

    fn record(&mut self, signal: signal::SignalId, at: When, value: Value, cause: Cause) {
        let before = if self.schedule.awaits(signal) { self.recorder.trace().last(signal) } else { None };
        if self.recorder.record(signal, at, value, cause) {
            if self.schedule.awaits(signal) {
                self.schedule.changed(signal, before.map(|event| event.value), value, self.now);
            }
            self.alarmed(signal, at, value);
        }
    }

    /// What the board saw up to now goes to the trace and to the subject's inputs.
    fn poll(&mut self) -> Result<(), Trouble> {
        let mut events = std::mem::take(&mut self.polled);
        events.clear();
        let now = self.board_time();
        let polled = self.board.poll(now, &mut events);
        for event in &events {
            self.see(event);
        }
        self.polled = events;
        polled.map_err(|error| Trouble::Board { at: now, error })
    }

    fn see(&mut self, event: &BoardEvent) {
        let place = usize::from(event.channel().0);
        let (at, value, cause) = match *event {
            BoardEvent::Changed { at, value, origin, .. } => {
                let cause = if origin == Origin::Write { self.wiring.writers[place] } else { Cause::Board };
                (at, value, cause)
            }
            BoardEvent::Lost { at, reason, .. } => {
                if reason != LossReason::Injected {
                    self.ran.trouble.get_or_insert(Trouble::Lost { at, channel: event.channel(), reason });
                }
                (When::exactly(at), Value::Unknown, Cause::Board)
            }
            BoardEvent::Returned { .. } => return,
            BoardEvent::Dropped { at, count, channel } => {
                self.ran.trouble.get_or_insert(Trouble::Dropped { at, channel, count });
                return;
            }
        };
        for index in 0..self.wiring.channels[place].len() {
            let signal = self.wiring.channels[place][index];
            self.record(signal, self.seen_by_board(at), value, cause);
        }
        let inputs = &self.wiring.inputs[place];
        if !inputs.is_empty() {
            let level = match value {
                Value::Bool(high) => Level::from_bool(high),
                // Between the two levels of a voltage an input keeps the one that it had.
                Value::Real(volts) => match profile::input_level(volts) {
                    Some(high) => Level::from_bool(high),
                    None => return,
                },
                _ => Level::HighZ,
            };
            for &input in inputs {
                self.subject.input(self.now.max(at.latest), input, level);
            }
        }
    }
}
