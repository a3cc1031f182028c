//! The executor: one loop that brings subject, board and steps together on a clock, virtual or not.
//!
//! At one instant the order is: operations of the program that complete, changes of the board, steps of the plan,
//! timers of the controller (docs/decisions/0003-time-of-an-operation.md).

mod alarms;
mod board_events;
mod buses;
mod confirm;
mod edges;
mod emission;
mod limits;
mod live;
mod loss;
mod real_lines;
mod relays;
mod startup;
mod steps;
mod teardown;

use crate::clock::Clock;
use crate::frame_log::FrameLog;
use crate::heartbeat::Heartbeat;
use crate::loop_counter::LoopCounter;
use crate::operator::Operator;
use crate::prepare::ArmedAlarm;
use crate::recorder::Recorder;
use crate::rig_fault::RigFault;
use crate::scan_port::ScanPort;
use crate::schedule::{EndReason, Schedule};
use crate::stepping::{Stepper, Stepping};
use crate::subject::Subject;
use crate::wake_statistics::WakeStatistics;
use crate::wiring::Wiring;
use confirm::PendingWrites;
use controller::{Effect, Effects};
use drivers::{Board, BoardEvent, BoardExt, BusEvent, BusState, ChannelId, Emission, TimestampSource};
use edges::PendingEdges;
use emission::Emissions;
use plans::steps::CasePart;
use real_lines::RealLines;
use relays::RelayMarks;
use signal::{Cause, Span, Time, Value, When};
use std::sync::atomic::{AtomicBool, Ordering};

pub use limits::{ExecutorReport, Limits};

/// Turns of the loop without a moment of time passing: more is a circuit that oscillates for ever in no time.
const MOST_SIMULTANEOUS: u32 = 1_000_000;

/// Lines that a case's log keeps.
const LOG_LINES: usize = 1_000;

/// Runs one case.
pub struct Executor<'a> {
    clock: &'a mut dyn Clock,
    subject: &'a mut dyn Subject,
    board: &'a mut dyn Board,
    recorder: &'a mut Recorder,
    schedule: &'a mut Schedule,
    wiring: &'a mut Wiring,
    alarms: &'a mut Vec<ArmedAlarm>,
    limits: Limits,
    interrupt: &'a AtomicBool,
    operator: Option<&'a dyn Operator>,
    heartbeat: Option<&'a dyn Heartbeat>,
    loop_counter: Option<&'a LoopCounter>,
    /// The guard counts on its beats.
    beating: bool,
    effects: Effects,
    spare: Vec<Effect>,
    writes: Vec<(ChannelId, Value)>,
    polled: Vec<BoardEvent>,
    polled_buses: Vec<BusEvent>,
    /// How each of the board's controllers takes part in its bus.
    nodes: Vec<BusState>,
    /// What each channel was driven to last, to be driven back to after a pulse.
    driven: Vec<Value>,
    restore: Vec<Value>,
    /// Instant that the rig has reached: modelled, and on the clock.
    now: Time,
    actual: Time,
    /// Since when the subject has its program.
    loaded: Time,
    /// The board's lines are modelled: they live in the controller's time, and a rig that is late only knows less
    /// exactly when things happened. Wires have the clock's time.
    modelled: bool,
    /// What real lines need.
    lines: RealLines,
    pending_writes: PendingWrites,
    edges: PendingEdges,
    relays: RelayMarks,
    emissions: Emissions,
    punctuality: Option<WakeStatistics>,
    same: u32,
    over: bool,
    /// The last device that was told to be lost, or to be back, and when.
    noticed: Option<(Time, String)>,
    /// The outputs were driven to their safe values.
    safe: bool,
    report: ExecutorReport,
    /// Somebody who goes through the case step by step.
    stepping: Option<Stepping<'a>>,
    /// Clients of a rig that is kept running.
    live: Option<&'a mut ScanPort>,
}

impl std::fmt::Debug for Executor<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Executor").field("now", &self.now).field("ran", &self.report).finish_non_exhaustive()
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
    pub alarms: &'a mut Vec<ArmedAlarm>,
    /// Ends the case early when it becomes TRUE.
    pub interrupt: &'a AtomicBool,
    /// Can be asked.
    pub operator: Option<&'a dyn Operator>,
    /// Is shown that the executor goes on turning.
    pub heartbeat: Option<&'a dyn Heartbeat>,
    /// Counts its turns.
    pub loop_counter: Option<&'a LoopCounter>,
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
        // A board may have buses alone.
        let modelled = channels.iter().all(|channel| channel.timestamp == TimestampSource::Virtual)
            && parts.board.bus_list().iter().all(|bus| bus.timestamp == TimestampSource::Virtual);
        let exact = parts.clock.is_exact();
        let frames = FrameLog::of(parts.board.bus_list());
        parts.subject.offload_pulses(emission::offloaded_outputs(parts.wiring, channels));
        Executor {
            pending_writes: PendingWrites::new(channels),
            edges: PendingEdges::new(channels.len(), parts.schedule.steps().len()),
            relays: RelayMarks::new(channels.len()),
            emissions: Emissions::new(channels),
            lines: if modelled {
                RealLines::modelled(channels.len())
            } else {
                RealLines::new(channels.len())
            },
            punctuality: (!exact).then(|| WakeStatistics::new(limits.horizon)),
            effects: Effects::new(),
            spare: Vec::with_capacity(256),
            writes: Vec::with_capacity(channels.len()),
            polled: Vec::with_capacity(1024),
            polled_buses: Vec::with_capacity(if parts.board.bus_list().is_empty() { 0 } else { 1024 }),
            nodes: vec![BusState::ErrorActive; parts.board.bus_list().len()],
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
            heartbeat: parts.heartbeat,
            loop_counter: parts.loop_counter,
            beating: false,
            limits,
            now: Time::ZERO,
            actual: Time::ZERO,
            loaded: Time::ZERO,
            modelled,
            same: 0,
            over: false,
            noticed: None,
            safe: false,
            report: ExecutorReport { log: Vec::with_capacity(64), frames, ..ExecutorReport::default() },
            stepping: None,
            live: None,
        }
    }

    /// The same, and `stepper` is asked before each step of the plan.
    #[must_use]
    pub fn stepping(mut self, stepper: &'a mut dyn Stepper) -> Executor<'a> {
        self.stepping = Some(Stepping::new(stepper));
        self
    }

    /// Runs the case from power-on to its end and its teardown, then drives every output to its safe value.
    pub fn run(mut self) -> ExecutorReport {
        let outcome = self.prelude().and_then(|()| self.main());
        if let Err(fault) = outcome {
            self.report.fault.get_or_insert(fault);
        }
        self.report.end = self.now;
        self.mark_pending_faults(|_| true);
        // What comes behind the end raises no alarm.
        self.alarms.clear();
        if let Some(mark) = self.wiring.end {
            self.recorder.mark(mark, self.seen(self.now));
        }
        if self.report.start.is_some() {
            self.tear_down();
        }
        self.report.closed = self.now;
        self.safe = true;
        let at = self.board_time();
        if let Err(error) = self.board.safe(at) {
            self.report.fault.get_or_insert(RigFault::Board { at, error });
        }
        if let Some(heartbeat) = self.heartbeat.filter(|_| self.beating)
            && let Err(error) = heartbeat.end()
        {
            let fault = self.unguarded(&error);
            self.report.fault.get_or_insert(fault);
        }
        let health = self.board.health();
        self.report.dropped = health.dropped;
        // What it had not come to by now is late as well.
        self.report.late_outputs = self.lines.late_outputs().max(self.actual - self.now);
        self.report.horizon = if self.modelled { Span::ZERO } else { self.limits.horizon };
        self.report.wakes = self.punctuality.take().map(WakeStatistics::figures);
        if !health.is_sound() {
            self.report.fault.get_or_insert(RigFault::Unsound { at: self.now, health });
        }
        if let Some(error) = self.recorder.take_fault() {
            self.report.fault.get_or_insert(RigFault::Trace(error));
        }
        std::mem::take(&mut self.report)
    }

    fn main(&mut self) -> Result<(), RigFault> {
        // Steps at the start itself come before the first operation of the first cycle.
        while !self.over {
            let timeout = self.loaded.saturating_add(self.limits.timeout);
            let end = self.end();
            if self.live.is_some() && !self.serve_clients()? {
                continue;
            }
            if !self.turn(end.min(timeout))? {
                if self.now >= timeout && end > timeout {
                    return Err(RigFault::Timeout { limit: self.limits.timeout });
                }
                if self.puts_off_end() {
                    continue;
                }
                break;
            }
        }
        Ok(())
    }

    /// One turn: everything up to the next instant at which something happens. FALSE at `end`, or when nothing
    /// will ever happen again.
    fn turn(&mut self, end: Time) -> Result<bool, RigFault> {
        if let Some(loop_counter) = self.loop_counter {
            loop_counter.add();
        }
        let timer = self.subject.next_timer().unwrap_or(Time::MAX);
        let board = self.board.next_event().unwrap_or(Time::MAX);
        let step = self.schedule.next_due().unwrap_or(Time::MAX);
        let alarm = self.next_alarm().unwrap_or(Time::MAX);
        let wake = self.stepping.as_ref().map_or(Time::MAX, |stepping| stepping.wake(self.now));
        let slice = self.now.saturating_add(self.limits.slice);
        let input = self.lines.next().unwrap_or(Time::MAX);
        let pulses = self.edges.next().unwrap_or(Time::MAX);
        let due = timer.min(board).min(step).min(alarm).min(end).min(slice).min(wake).min(input).min(pulses);
        let due = due.min(self.stepped_until());
        if due == Time::MAX {
            return Err(RigFault::Stuck { at: self.now });
        }
        let due = due.max(self.now);
        let next = due;
        let due = if self.modelled { due } else { self.wait_for(due)? };
        let reached = self.subject.run(due, &mut self.effects);
        if due < next && self.has_computed(reached) {
            return Ok(true);
        }
        self.pass(reached)?;
        if !self.effects.list.is_empty() {
            self.apply()?;
            return Ok(true);
        }
        if reached < due {
            return Ok(true);
        }
        if board <= due || !self.modelled && self.clock.rung() {
            self.poll()?;
        }
        if input <= due {
            self.feed();
            self.apply()?;
        }
        self.end_pulses();
        if step <= due {
            self.steps(due)?;
        }
        if alarm <= due {
            self.raise_due();
        }
        if self.over
            || self.schedule.ended().is_some() && self.schedule.phase() != CasePart::Teardown
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
        if self.schedule.phase() == CasePart::Teardown {
            return Ok(true);
        }
        if self.interrupt.load(Ordering::Relaxed) {
            return Err(RigFault::Interrupted);
        }
        if self.limits.fail_fast && self.recorder.failed_early() {
            self.schedule.end_early(EndReason::Claim, self.now);
            return Ok(false);
        }
        Ok(true)
    }

    fn fire(&mut self, due: Time) -> Result<(), RigFault> {
        if self.subject.next_timer().is_some_and(|timer| timer <= due) {
            self.subject.fire(due, &mut self.effects);
            self.apply()?;
        }
        Ok(())
    }

    /// Carries out what the subject did.
    fn apply(&mut self) -> Result<(), RigFault> {
        if self.effects.list.is_empty() {
            return Ok(());
        }
        std::mem::swap(&mut self.effects.list, &mut self.spare);
        self.writes.clear();
        let mut outcome = Ok(());
        for index in 0..self.spare.len() {
            let effect = self.spare[index];
            match effect {
                Effect::Terminal { at, output, level, cause } => {
                    let Some(channel) = self.wiring.output(output) else { continue };
                    self.wiring.writers[usize::from(channel.0)] = cause;
                    self.lines.wrote(channel, at, self.actual);
                    self.keep_edge(channel, level)?;
                    self.writes.push((channel, Value::from(level)));
                }
                Effect::Wave { at, output, period, high, cause } => {
                    let emission = Emission::Square { period, high };
                    let made =
                        self.write_effects().and_then(|_| self.emit_wave(at, output, &emission, cause));
                    outcome = outcome.and(made);
                }
                Effect::PeriodRestarted { at, output } => self.cannot_restart_period(at, output),
                Effect::State { at, state } => {
                    if let Some(signal) = self.wiring.state {
                        let at = self.seen(at);
                        self.record(signal, at, Value::Int(state.number()), Cause::Controller);
                    }
                }
                Effect::Changed { at, probe, value, cause } => {
                    let at = self.seen(at);
                    if let Some(live) = &mut self.live {
                        live.probe(probe, at, value);
                    }
                    for place in 0..self.wiring.probes.get(probe.0 as usize).map_or(0, Vec::len) {
                        let signal = self.wiring.probes[probe.0 as usize][place];
                        self.record(signal, at, value, cause);
                    }
                }
                Effect::Log { at, entry } => {
                    if let Some(live) = &mut self.live {
                        live.log(at, &crate::log::show(&entry, &*self.subject));
                    }
                    if self.report.log.len() < LOG_LINES {
                        self.report.log.push((at, crate::log::show(&entry, &*self.subject)));
                    } else {
                        self.report.log_dropped += 1;
                    }
                }
            }
        }
        self.spare.clear();
        if outcome.and(self.write_effects())? { self.poll() } else { Ok(()) }
    }

    /// Hands what the subject wrote to the board, if anything.
    fn write_effects(&mut self) -> Result<bool, RigFault> {
        if self.writes.is_empty() {
            return Ok(false);
        }
        self.expect_writes();
        let at = self.board_time();
        let written = self.board.write(at, &self.writes);
        self.writes.clear();
        written.map_err(|error| RigFault::Board { at, error })?;
        Ok(true)
    }

    /// When something that happened at a modelled instant was seen: exactly in virtual time, else up to now.
    fn seen(&self, at: Time) -> When {
        if self.clock.is_exact() { When::exactly(at) } else { When::within(at, self.actual) }
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
}
