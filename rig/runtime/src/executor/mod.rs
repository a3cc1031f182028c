//! The executor: one loop that brings subject, board and steps together on a clock, virtual or not.
//!
//! At one instant the order is: operations of the program that complete, then the event sources (`event_source.rs`) in theirs
//! (docs/decisions/0003-time-of-an-operation.md, docs/decisions/0056-event-sources-and-pacing.md).

mod alarms;
mod board_events;
mod buses;
pub mod clock;
mod confirm;
mod edges;
mod emission;
mod event_source;
mod exceptions;
pub mod frame_log;
pub mod heartbeat;
mod late_reports;
mod limits;
mod live;
pub mod loop_counter;
mod loss;
pub mod operator;
mod pacing;
mod plant_settings;
mod ports;
mod real_lines;
pub mod recorder;
mod relays;
pub mod rig_fault;
mod startup;
pub mod stepping;
mod steps;
mod teardown;
pub(crate) mod wake_statistics;

use crate::executor::clock::Clock;
use crate::executor::frame_log::FrameLog;
use crate::executor::heartbeat::Heartbeat;
use crate::executor::loop_counter::LoopCounter;
use crate::executor::operator::Operator;
use crate::executor::recorder::Recorder;
use crate::executor::rig_fault::RigFault;
use crate::executor::stepping::{Stepper, Stepping};
use crate::executor::wake_statistics::WakeStatistics;
use crate::prepare::ArmedAlarm;
use crate::scan_port::ScanPort;
use crate::schedule::{EndReason, Schedule};
use crate::subject::{Subject, SubjectExt};
use crate::wiring::Wiring;
use confirm::PendingWrites;
use controller::{Effect, Effects};
use drivers::{Board, BoardError, BoardEvent, BoardExt, BusEvent, BusState, ChannelId, Emission};
use edges::PendingEdges;
use emission::Emissions;
use event_source::EventSource;
use exceptions::ExceptionWatch;
use pacing::Pacing;
use plans::steps::CasePart;
use plant_settings::PlantSettings;
use ports::BoundPorts;
use real_lines::RealLines;
use relays::RelayMarks;
use signal::{Cause, Time, Value, When};
use std::sync::atomic::{AtomicBool, Ordering};

pub use exceptions::ExceptionStop;
pub use limits::{ExecutorLimits, ExecutorReport};

/// Turns of the loop without a moment of time passing: more is a circuit that oscillates for ever in no time.
const MOST_SIMULTANEOUS: u32 = 1_000_000;

/// Lines that a case's log keeps.
const LOG_LINES: usize = 1_000;

/// Runs one case.
pub struct Executor<'a> {
    parts: Parts<'a>,
    limits: ExecutorLimits,
    /// The guard counts on its beats.
    beating: bool,
    buffers: Buffers,
    devices: Devices,
    driven: Driven,
    plant_settings: PlantSettings,
    /// Instant that the rig has reached: modelled, and on the clock.
    now: Time,
    actual: Time,
    /// Since when the subject has its program.
    loaded: Time,
    pacing: Pacing,
    /// What real lines need.
    lines: RealLines,
    /// What passes between the subject's ports and their buses.
    ports: BoundPorts,
    awaited: Awaited,
    wakes: Option<WakeStatistics>,
    /// Turns without a moment of time passing.
    same: u32,
    /// The end of this turn's time.
    end: Time,
    /// The case ends with this turn.
    ends: bool,
    /// Something ended the case before its time.
    over: bool,
    /// The end of the case, which the teardown comes after: in the board's time, and the latest that it can have been.
    ended: Option<(Time, Time)>,
    /// How far the board was asked after the end, for what it had not reported by then.
    board_reached: Time,
    /// The outputs were driven to their safe values.
    safe: bool,
    report: ExecutorReport,
    exceptions: ExceptionWatch,
    /// Somebody who goes through the case step by step.
    stepping: Option<Stepping<'a>>,
    /// Clients of a rig that is kept running.
    live: Option<&'a mut ScanPort>,
}

/// Memory that is used in each turn, so that none is taken.
struct Buffers {
    effects: Effects,
    spare: Vec<Effect>,
    writes: Vec<(ChannelId, Value)>,
    polled: Vec<BoardEvent>,
    polled_buses: Vec<BusEvent>,
}

/// How the board's devices fare, as far as that was reported.
struct Devices {
    /// How each of the board's controllers takes part in its bus.
    nodes: Vec<BusState>,
    /// The last device that was reported to be lost, or to be back, and when.
    noticed: Option<(Time, String)>,
}

/// By channel: what it was driven to last, and what it is to be driven back to after a pulse.
struct Driven {
    values: Vec<Value>,
    restore: Vec<Value>,
}

/// What steps wait for on lines that take their time.
struct Awaited {
    writes: PendingWrites,
    edges: PendingEdges,
    relays: RelayMarks,
    emissions: Emissions,
}

impl std::fmt::Debug for Executor<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Executor")
            .field("now", &self.now)
            .field("report", &self.report)
            .finish_non_exhaustive()
    }
}

/// Nothing stays driven after a run that panics.
impl Drop for Executor<'_> {
    fn drop(&mut self) {
        if !self.safe {
            // The board itself may be what panicked: a second panic would end the process.
            let at = self.board_time().max(self.board_reached);
            let safe = std::panic::AssertUnwindSafe(|| self.parts.board.safe(at));
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
    pub fn new(parts: Parts<'a>, limits: ExecutorLimits) -> Executor<'a> {
        let channels = parts.board.channels();
        let buses = parts.board.bus_list();
        let values: Vec<Value> = channels.iter().map(|channel| channel.safe).collect();
        let pacing = Pacing::of(channels, buses, parts.heartbeat.is_some());
        let frames = FrameLog::of(buses);
        parts.subject.offload_pulses(&emission::offloaded_outputs(parts.wiring, channels));
        Executor {
            beating: false,
            buffers: Buffers {
                effects: Effects::new(),
                spare: Vec::with_capacity(256),
                writes: Vec::with_capacity(channels.len()),
                polled: Vec::with_capacity(1024),
                polled_buses: Vec::with_capacity(if buses.is_empty() { 0 } else { 1024 }),
            },
            devices: Devices { nodes: vec![BusState::ErrorActive; buses.len()], noticed: None },
            driven: Driven { restore: values.clone(), values },
            plant_settings: PlantSettings::default(),
            now: Time::ZERO,
            actual: Time::ZERO,
            loaded: Time::ZERO,
            lines: match pacing {
                Pacing::EventDriven => RealLines::modelled(channels.len()),
                Pacing::WallClock => RealLines::new(channels.len()),
            },
            pacing,
            ports: BoundPorts::new(&parts.wiring.ports, buses.len()),
            awaited: Awaited {
                writes: PendingWrites::new(channels),
                edges: PendingEdges::new(channels.len(), parts.schedule.steps().len()),
                relays: RelayMarks::new(channels.len()),
                emissions: Emissions::new(channels),
            },
            wakes: (!parts.clock.is_exact()).then(|| WakeStatistics::new(limits.horizon)),
            same: 0,
            end: Time::MAX,
            ends: false,
            over: false,
            ended: None,
            board_reached: Time::MIN,
            safe: false,
            report: ExecutorReport {
                log: Vec::with_capacity(64),
                exceptions: Vec::with_capacity(2),
                frames,
                ..ExecutorReport::default()
            },
            exceptions: ExceptionWatch::default(),
            stepping: None,
            live: None,
            limits,
            parts,
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
        self.see_polled_ahead();
        self.record_unsettled_at_end();
        self.see_all_windows();
        self.report.end = self.now;
        let mark = self.seen(self.now);
        self.ended = Some((self.board_time(), mark.latest));
        self.mark_pending_faults(|_| true);
        // What comes after the end raises no alarm.
        self.parts.alarms.clear();
        if let Some(mark) = self.parts.wiring.end {
            self.parts.recorder.mark(mark, self.seen(self.now));
        }
        if self.report.start.is_some() {
            self.tear_down();
        }
        self.report.closed = self.now;
        self.take_late_reports();
        self.safe = true;
        let at = self.board_time().max(self.board_reached);
        if let Err(error) = self.parts.board.safe(at) {
            self.report.fault.get_or_insert(RigFault::Board { at, error });
        }
        if let Some(heartbeat) = self.parts.heartbeat.filter(|_| self.beating)
            && let Err(error) = heartbeat.end()
        {
            let fault = self.unguarded(&error);
            self.report.fault.get_or_insert(fault);
        }
        let health = self.parts.board.health();
        self.report.dropped = health.dropped;
        // What it had not come to by now is late as well.
        self.report.late_outputs = self.lines.late_outputs().max(self.actual - self.now);
        self.report.horizon = self.pacing.horizon(self.limits.horizon);
        self.report.wakes = self.wakes.take().map(WakeStatistics::figures);
        if !health.is_sound() {
            self.report.fault.get_or_insert(RigFault::Unsound { at: self.now, health });
        }
        if let Some(error) = self.parts.recorder.take_fault() {
            self.report.fault.get_or_insert(RigFault::Trace(error));
        }
        if let Some(RigFault::Board { error: BoardError::PlantFailed(_), .. }) = self.report.fault
            && let Some(fault) = self.parts.board.plant_fault()
        {
            self.report.fault = Some(RigFault::Plant(fault.clone()));
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
        if let Some(loop_counter) = self.parts.loop_counter {
            loop_counter.add();
        }
        self.end = end;
        // By their places: arrays that are mapped and iterated over by value are copied, in each turn.
        let mut planned = [Time::MAX; EventSource::ORDER.len()];
        let mut next = self.now.saturating_add(self.limits.slice).min(self.stepped_until());
        for (place, source) in EventSource::ORDER.iter().enumerate() {
            if let Some(at) = source.next(self) {
                planned[place] = at;
                next = next.min(at);
            }
        }
        if next == Time::MAX {
            return Err(RigFault::Stuck { at: self.now });
        }
        let next = next.max(self.now);
        let due = self.approach(next)?;
        // What was due when the host's time went on without the subject, while a program was loaded, is due now.
        let reached = self.parts.subject.run(due, &mut self.buffers.effects).max(self.now);
        if due < next && self.has_computed(reached) {
            return Ok(true);
        }
        self.pass(reached)?;
        if !self.buffers.effects.list.is_empty() {
            self.apply()?;
            return Ok(true);
        }
        if reached < due {
            return Ok(true);
        }
        for (place, source) in EventSource::ORDER.iter().enumerate() {
            source.fire(self, planned[place], due)?;
        }
        if self.ends {
            return Ok(false);
        }
        if self.parts.schedule.phase() == CasePart::Teardown {
            return Ok(true);
        }
        if self.parts.interrupt.load(Ordering::Relaxed) {
            return Err(RigFault::Interrupted);
        }
        if self.limits.fail_fast && self.parts.recorder.failed_early(self.now) {
            self.parts.schedule.end_early(EndReason::Claim, self.now);
            return Ok(false);
        }
        Ok(true)
    }

    /// Carries out what the subject did.
    fn apply(&mut self) -> Result<(), RigFault> {
        if self.buffers.effects.list.is_empty() {
            return Ok(());
        }
        std::mem::swap(&mut self.buffers.effects.list, &mut self.buffers.spare);
        self.buffers.writes.clear();
        let mut outcome = Ok(());
        for index in 0..self.buffers.spare.len() {
            let effect = self.buffers.spare[index];
            match effect {
                Effect::Terminal { at, terminal, value, cause, early } => {
                    let Some(channel) = self.parts.wiring.channel_of(terminal) else { continue };
                    self.parts.wiring.writers[usize::from(channel.0)] = cause;
                    self.lines.wrote(channel, at, self.actual, early);
                    self.keep_edge(channel, value)?;
                    self.buffers.writes.push((channel, value));
                }
                Effect::Unsettled { at, terminal, left, back } => {
                    self.record_unsettled(at, terminal, left, back);
                }
                Effect::Wave { at, output, period, high, cause } => {
                    let emission = Emission::Square { period, high };
                    let made =
                        self.write_effects().and_then(|_| self.emit_wave(at, output, &emission, cause));
                    outcome = outcome.and(made);
                }
                Effect::PeriodRestarted { at, output } => self.cannot_restart_period(at, output),
                Effect::PortOutput { at, port } => self.send_from_port(at, port),
                Effect::PortSilent { port, .. } => outcome = outcome.and(self.silence_port(port)),
                Effect::State { at, state } => {
                    if let Some(stop) = self.exceptions.state(at, state) {
                        self.note_exception(stop);
                    }
                    if let Some(signal) = self.parts.wiring.state {
                        let at = self.seen(at);
                        self.record(signal, at, Value::Int(state.number()), Cause::Controller);
                    }
                }
                Effect::Changed { at, probe, value, cause } => {
                    let at = self.seen(at);
                    if let Some(live) = &mut self.live {
                        live.probe(probe, at, value);
                    }
                    for place in 0..self.parts.wiring.probes.get(probe.0 as usize).map_or(0, Vec::len) {
                        let signal = self.parts.wiring.probes[probe.0 as usize][place];
                        self.record(signal, at, value, cause);
                    }
                }
                Effect::Log { at, entry } => {
                    self.exceptions.log(&entry);
                    // No words for a line that nobody gets.
                    if self.live.is_none() && self.report.log.len() >= LOG_LINES {
                        self.report.log_dropped += 1;
                        continue;
                    }
                    self.log(at, crate::subject::log::show(&entry, self.parts.subject.catalogue()));
                }
            }
        }
        self.buffers.spare.clear();
        if outcome.and(self.write_effects())? { self.poll() } else { Ok(()) }
    }

    /// The application was stopped by an exception: the first into each state counts, up to the end of the case.
    fn note_exception(&mut self, stop: ExceptionStop) {
        let known = self.report.exceptions.iter().any(|known| known.state == stop.state);
        if !known && self.parts.schedule.phase() != CasePart::Teardown {
            self.report.exceptions.push(stop);
        }
    }

    /// A line for the log of the case, and for clients.
    fn log(&mut self, at: Time, text: String) {
        if let Some(live) = &mut self.live {
            live.log(at, &text);
        }
        if self.report.log.len() < LOG_LINES {
            self.report.log.push((at, text));
        } else {
            self.report.log_dropped += 1;
        }
    }

    /// Hands what the subject wrote to the board, if anything.
    fn write_effects(&mut self) -> Result<bool, RigFault> {
        if self.buffers.writes.is_empty() {
            return Ok(false);
        }
        self.expect_writes();
        let at = self.board_time();
        let written = self.parts.board.write(at, &self.buffers.writes);
        self.buffers.writes.clear();
        written.map_err(|error| RigFault::Board { at, error })?;
        Ok(true)
    }

    /// When something that happened at a modelled instant was seen: exactly in virtual time, else up to now.
    fn seen(&self, at: Time) -> When {
        if self.parts.clock.is_exact() { When::exactly(at) } else { When::within(at, self.actual) }
    }

    /// The instant that the rig has reached in the board's time.
    const fn board_time(&self) -> Time {
        self.pacing.board_time(self.now, self.actual)
    }

    fn record(&mut self, signal: signal::SignalId, at: When, value: Value, cause: Cause) {
        let before =
            if self.parts.schedule.awaits(signal) { self.parts.recorder.trace().last(signal) } else { None };
        if self.parts.recorder.record(signal, at, value, cause) {
            if self.parts.schedule.awaits(signal) {
                self.parts.schedule.changed(signal, before.map(|event| event.value), value, self.now);
            }
            self.alarmed(signal, at, value);
        }
    }
}
