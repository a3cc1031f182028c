//! Pulse train outputs and their axes (io: section 17.4).

mod command;
mod config;
mod control;
mod fault;
mod homing;
mod motion;
mod parameter;
mod profile;
mod ramp;
#[cfg(test)]
mod tests;
mod touch_probe;
mod train;

pub(crate) use command::{AxisCommand, BufferMode, CommandPhase, MotionCommand};
pub use config::{AxisConfig, AxisParameterError, AxisRole, DriveInput, PulseOutput, RampUnit};
pub use fault::AxisFault;
pub(crate) use homing::{Homing, HomingMethod};
pub(crate) use profile::Ramps;
use ramp::HERTZ;
pub(crate) use touch_probe::CaptureTrigger;

use crate::{ExpertEffect, ExpertEffects, ExpertOperation, FunctionProbe};
use ::profile::ChannelSet;
use command::{CommandResults, QueuedCommand};
use homing::{HomingEvent, HomingRun};
use motion::Motion;
use parameter::AxisParameters;
use signal::{Time, Value};
use touch_probe::TouchProbe;

/// What an axis does (io:STD-PTO-03).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AxisState {
    /// No power.
    Disabled,
    /// At rest, ready.
    Standstill,
    /// On the way to a known position.
    Homing,
    /// On the way to a position, or to rest.
    DiscreteMotion,
    /// With a velocity.
    ContinuousMotion,
    /// On the way to rest, and held there.
    Stopping,
    /// An error of the axis.
    ErrorStop,
}

/// A pulse train output with its axis.
#[derive(Clone, Debug)]
pub(crate) struct Axis {
    config: AxisConfig,
    place: u8,
    motion: Motion,
    parameters: AxisParameters,
    state: AxisState,
    /// The inputs that are at 1.
    high: ChannelSet,
    /// The application runs.
    operating: bool,
    /// The program wants power.
    enabled: bool,
    /// Protection holds an output of the axis.
    cut: bool,
    /// The output that enables the drive is on.
    drive: bool,
    homed: bool,
    fault: Option<AxisFault>,
    search: Option<HomingRun>,
    probe: TouchProbe,
    /// The command that controls the axis, and the one that follows.
    active: Option<QueuedCommand>,
    queued: Option<QueuedCommand>,
    /// When the one that follows begins after a delay.
    delayed: Time,
    /// The stop that holds the axis, and whether it may let go.
    stop: u32,
    released: bool,
    tickets: u32,
    ends: CommandResults,
}

impl Axis {
    pub fn new(config: &AxisConfig, place: u8) -> Axis {
        Axis {
            motion: Motion::new(config),
            parameters: AxisParameters::new(config),
            config: config.clone(),
            place,
            state: AxisState::Disabled,
            high: ChannelSet::EMPTY,
            operating: false,
            enabled: false,
            cut: false,
            drive: false,
            homed: false,
            fault: None,
            search: None,
            probe: TouchProbe::default(),
            active: None,
            queued: None,
            delayed: Time::MAX,
            stop: 0,
            released: false,
            tickets: 0,
            ends: CommandResults::new(),
        }
    }

    /// The accepted level of input `input` from `at` on.
    pub fn edge(&mut self, at: Time, input: u8, high: bool, fx: &mut ExpertEffects) {
        if self.high.contains(input.into()) == high {
            return;
        }
        self.high.set(input.into(), high);
        let becomes =
            |it: Option<DriveInput>| it.filter(|it| it.input == input).map(|it| high != it.inverted);
        let config = &self.config;
        let reference = becomes(config.reference).map(HomingEvent::Reference);
        let index = becomes(config.index).filter(|on| *on).map(|_| HomingEvent::Index);
        let probe = becomes(config.probe);
        for mark in [reference, index].into_iter().flatten() {
            self.mark(at, mark, fx);
        }
        if let Some(on) = probe {
            self.probe_edge(at, on, fx);
        }
        if !self.drive_is_ready() && self.powered_state() {
            self.fail(at, AxisFault::DriveNotReady, fx);
        }
        self.guard(at, fx);
        self.update_power(at, fx);
    }

    fn is_on(&self, input: Option<DriveInput>) -> bool {
        input.is_some_and(|it| self.high.contains(it.input.into()) != it.inverted)
    }

    fn drive_is_ready(&self) -> bool {
        self.config.drive_ready.is_none() || self.is_on(self.config.drive_ready)
    }

    /// When something happens without an edge; [`Time::MAX`] for never.
    #[inline]
    pub fn next(&self) -> Time {
        self.motion.next().min(self.delayed)
    }

    pub fn fire(&mut self, now: Time, fx: &mut ExpertEffects) {
        while self.motion.next() <= now {
            let at = self.motion.next();
            if let Some(progress) = self.motion.fire(fx) {
                self.progress(at, progress, fx);
            }
        }
        if self.delayed <= now {
            self.delayed = Time::MAX;
            self.begin_queued(now, fx);
        }
    }

    pub fn operate(&mut self, now: Time, operation: ExpertOperation, fx: &mut ExpertEffects) {
        self.operating = operation == ExpertOperation::Running;
        if !self.operating {
            self.enabled = false;
            self.disable(now, AxisFault::ApplicationStopped, fx);
            self.probe.abort();
        }
    }

    /// After a cold reset or a download (io:STD-HSC-15).
    pub fn reset(&mut self, now: Time, fx: &mut ExpertEffects) {
        let mut fresh = Axis::new(&self.config, self.place);
        self.disable(now, AxisFault::ApplicationStopped, fx);
        fresh.high = self.high;
        fresh.operating = self.operating;
        fresh.cut = self.cut;
        // Blocks keep the numbers of their commands in variables that a download may keep.
        fresh.tickets = self.tickets;
        *self = fresh;
    }

    /// Protection switched these outputs off (io:STD-PTO-14).
    pub fn protect(&mut self, now: Time, cut: ChannelSet, fx: &mut ExpertEffects) {
        self.cut = cut.intersects(self.outputs());
        if self.cut && !matches!(self.state, AxisState::Disabled | AxisState::ErrorStop) {
            self.fail(now, AxisFault::OutputProtection, fx);
        }
        if self.cut {
            self.motion.cut(now, fx);
        }
    }

    pub fn read(&self, fact: FunctionProbe) -> Option<Value> {
        Some(match fact {
            FunctionProbe::State => Value::Int(self.state as i64),
            FunctionProbe::Position => Value::Int(self.position()),
            FunctionProbe::Velocity => Value::Int(self.velocity(self.motion.train.latest())),
            FunctionProbe::Homed => Value::Bool(self.homed),
            FunctionProbe::Pulses => Value::Int(self.motion.train.pulses() as i64),
            FunctionProbe::Captured => Value::Int(self.probe.position()),
            FunctionProbe::Error => Value::Int(self.fault.map_or(0, |fault| fault.number().into())),
            _ => return None,
        })
    }

    /// The outputs that it may drive.
    pub fn outputs(&self) -> ChannelSet {
        self.config.outputs().map(|(_, output)| usize::from(output)).collect()
    }

    /// The inputs that it looks at.
    pub fn inputs(&self) -> ChannelSet {
        self.config.inputs().map(|(_, input)| usize::from(input)).collect()
    }

    pub const fn state(&self) -> AxisState {
        self.state
    }

    pub const fn homed(&self) -> bool {
        self.homed
    }

    pub const fn fault(&self) -> Option<AxisFault> {
        self.fault
    }

    /// Whether no further command can be buffered.
    pub const fn queue_full(&self) -> bool {
        self.queued.is_some()
    }

    /// Whether positions get larger with the last or current motion.
    pub const fn forward(&self) -> bool {
        self.motion.train.forward()
    }

    /// In pulses.
    pub const fn position(&self) -> i64 {
        self.motion.train.position()
    }

    /// In pulses a second, rounded; negative for smaller positions.
    pub fn velocity(&self, now: Time) -> i64 {
        self.motion.train.course(now).map_or(0, |course| {
            let hertz = (course.velocity + HERTZ / 2) / HERTZ;
            if course.forward { hertz } else { -hertz }
        })
    }

    /// Whether it gets faster (above 0), slower (below 0) or neither; None at rest.
    pub fn trend(&self, now: Time) -> Option<i64> {
        self.motion.train.trend(now)
    }

    /// The drive has power and may move the axis (MC_Power.Status).
    pub fn powered(&self) -> bool {
        self.enabled && self.operating && self.drive_is_ready()
    }

    fn switch_drive(&mut self, now: Time, on: bool, fx: &mut ExpertEffects) {
        if self.drive != on {
            self.drive = on;
            if let Some(output) = self.config.drive_enable {
                fx.push(now, ExpertEffect::Output { output, on });
            }
        }
    }
}
