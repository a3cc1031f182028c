//! What programs and the machine make an axis do: commands, their order, states, limits (io:STD-PTO-03, io:STD-PTO-05).

use super::command::{AxisCommand, BufferMode, CommandPhase, MotionCommand, QueuedCommand};
use super::homing::{Homing, HomingEvent, HomingRun};
use super::motion::{MotionProgress, MotionTarget};
use super::profile::Ramps;
use super::touch_probe::CaptureTrigger;
use super::{Axis, AxisFault, AxisState, PulseOutput};
use crate::{ExpertEffect, ExpertEffects};
use signal::Time;

impl Axis {
    /// Takes a command, or says why not. The number stands for it from then on.
    pub fn command(
        &mut self,
        now: Time,
        command: AxisCommand,
        fx: &mut ExpertEffects,
    ) -> Result<u32, AxisFault> {
        self.allows(&command.order)?;
        let direction = self.direction(&command.order);
        if direction == Some(false) && self.config.output == PulseOutput::Pulse {
            return Err(AxisFault::InvalidDirection);
        }
        let waits = match command.mode {
            BufferMode::Aborting => false,
            BufferMode::Trigger if self.config.probe.is_none() => return Err(AxisFault::InvalidProbe),
            BufferMode::Trigger | BufferMode::BufferedDelay => true,
            _ => self.active.is_some(),
        };
        if command.mode != BufferMode::Aborting && self.queued.is_some() {
            return Err(AxisFault::QueueFull);
        }
        if let Some(fault) = direction.filter(|_| !waits).and_then(|forward| self.blocked(forward)) {
            return Err(fault);
        }
        let job = QueuedCommand { ticket: self.ticket(), command };
        if !waits {
            self.end_all(CommandPhase::Aborted, CommandPhase::Aborted);
            self.begin(now, job, fx);
            return Ok(job.ticket);
        }
        self.queued = Some(job);
        match self.active {
            None if command.mode == BufferMode::BufferedDelay => {
                self.delayed = now.saturating_add(command.delay);
            }
            None => {}
            Some(_) if self.motion.in_velocity() => self.follow(now, fx),
            Some(active) => self.blend(now, &active.command, &command, fx),
        }
        Ok(job.ticket)
    }

    fn ticket(&mut self) -> u32 {
        self.tickets = self.tickets.checked_add(1).unwrap_or(1);
        self.tickets
    }

    /// Whether the state allows an order.
    fn allows(&self, order: &MotionCommand) -> Result<(), AxisFault> {
        match self.state {
            AxisState::Disabled => return Err(AxisFault::Disabled),
            AxisState::ErrorStop => return Err(AxisFault::ErrorStopActive),
            AxisState::Stopping => return Err(AxisFault::StoppingActive),
            AxisState::Homing if !matches!(order, MotionCommand::Stop) => {
                return Err(AxisFault::InvalidTransition);
            }
            _ => {}
        }
        match order {
            MotionCommand::To(_) if !self.homed => Err(AxisFault::NotHomed),
            MotionCommand::Home(_) if self.state != AxisState::Standstill => {
                Err(AxisFault::InvalidTransition)
            }
            MotionCommand::Home(method) if method.mode != Homing::PositionSetting => {
                let index = !method.mode.needs_index() || self.config.index.is_some();
                if index && self.config.reference.is_some() { Ok(()) } else { Err(AxisFault::InvalidHoming) }
            }
            _ => Ok(()),
        }
    }

    /// The direction in which an order that begins now goes in the end; None where it goes nowhere. Homing finds its
    /// way by the switches.
    fn direction(&self, order: &MotionCommand) -> Option<bool> {
        match *order {
            MotionCommand::To(target) => (target != self.position()).then_some(target > self.position()),
            MotionCommand::By(distance) => (distance != 0).then_some(distance > 0),
            MotionCommand::Velocity(forward) => Some(forward.unwrap_or(self.motion.train.forward())),
            MotionCommand::Halt | MotionCommand::Stop => None,
            MotionCommand::Home(method) => {
                // On an axis with one direction only what never turns back can be homed.
                let onwards = matches!(method.mode, Homing::PositionSetting);
                (self.config.output == PulseOutput::Pulse && !onwards).then_some(false)
            }
        }
    }

    /// Why the axis cannot go on in a direction (io:STD-PTO-10).
    fn blocked(&self, forward: bool) -> Option<AxisFault> {
        let (switch, at_switch, at_limit) = if forward {
            (self.config.limit_positive, AxisFault::LimitPositive, AxisFault::SoftwareLimitPositive)
        } else {
            (self.config.limit_negative, AxisFault::LimitNegative, AxisFault::SoftwareLimitNegative)
        };
        if self.is_on(switch) {
            return Some(at_switch);
        }
        // A position that is not known has no limits, nor has one that is about to be found.
        let known = self.homed && self.state != AxisState::Homing;
        (known && self.parameters.beyond(forward, self.position())).then_some(at_limit)
    }

    /// An axis that goes into a limit ends with an error, or searches on the other way.
    pub(super) fn guard(&mut self, now: Time, fx: &mut ExpertEffects) {
        if !self.motion.train.goes_on() || self.state == AxisState::ErrorStop {
            return;
        }
        let forward = self.motion.train.forward();
        if !forward && self.config.output == PulseOutput::Pulse {
            // A move that overran its end would have to go back.
            self.fail(now, AxisFault::InvalidDirection, fx);
            return;
        }
        let Some(fault) = self.blocked(forward) else { return };
        if let (Some(search), Some(job)) = (&mut self.search, self.active) {
            if search.turns(forward) {
                return;
            }
            if !search.limit() {
                self.fail(now, fault, fx);
                return;
            }
            let aim = search.aim();
            let ramps = Ramps { fall: self.fast_stop().fall, ..job.command.ramps };
            self.motion.retarget(now, aim, ramps, fx);
            return;
        }
        self.fail(now, fault, fx);
    }

    fn fast_stop(&self) -> Ramps {
        let rate = self.config.rate(self.parameters.fast_stop());
        Ramps { rise: rate, fall: rate, jerk_ratio: self.config.jerk_ratio }
    }

    /// A command takes the axis.
    fn begin(&mut self, now: Time, job: QueuedCommand, fx: &mut ExpertEffects) {
        self.active = Some(job);
        let AxisCommand { order, velocity, ramps, .. } = job.command;
        let position = self.position();
        let (state, aim) = match order {
            MotionCommand::To(target) => {
                (AxisState::DiscreteMotion, MotionTarget::Position { target, velocity, end: 0 })
            }
            MotionCommand::By(distance) => {
                let target = position.saturating_add(distance);
                (AxisState::DiscreteMotion, MotionTarget::Position { target, velocity, end: 0 })
            }
            MotionCommand::Velocity(forward) => {
                let forward = forward.unwrap_or(self.motion.train.forward());
                (AxisState::ContinuousMotion, MotionTarget::Velocity { forward, velocity })
            }
            MotionCommand::Halt => (AxisState::DiscreteMotion, MotionTarget::Stop),
            MotionCommand::Stop => {
                self.stop = job.ticket;
                self.released = false;
                self.search = None;
                (AxisState::Stopping, MotionTarget::Stop)
            }
            MotionCommand::Home(method) => {
                self.homed = false;
                let search = HomingRun::new(method, self.is_on(self.config.reference));
                self.search = Some(search);
                let setting = method.mode == Homing::PositionSetting;
                (AxisState::Homing, if setting { MotionTarget::Stop } else { search.aim() })
            }
        };
        self.state = state;
        let (start, stop) = self.parameters.velocities();
        self.motion.set_velocities(start, stop);
        if let Some(progress) = self.motion.retarget(now, aim, ramps, fx) {
            self.progress(now, progress, fx);
        }
        self.guard(now, fx);
    }

    /// Something became of the aim.
    pub(super) fn progress(&mut self, now: Time, progress: MotionProgress, fx: &mut ExpertEffects) {
        match progress {
            MotionProgress::Moves => self.guard(now, fx),
            MotionProgress::Steady if self.state == AxisState::ContinuousMotion => self.follow(now, fx),
            MotionProgress::Steady => {}
            MotionProgress::Arrived => self.arrive(now, fx),
        }
    }

    fn arrive(&mut self, now: Time, fx: &mut ExpertEffects) {
        match self.state {
            AxisState::Stopping => {
                self.end_active(CommandPhase::Done);
                if self.released {
                    self.let_go();
                }
                return;
            }
            AxisState::Homing => {
                if let Some(search) = self.search.take() {
                    self.motion.train.set_position(search.method.position);
                    self.homed = true;
                }
            }
            AxisState::DiscreteMotion => {}
            _ => return,
        }
        self.end_active(CommandPhase::Done);
        self.state = AxisState::Standstill;
        self.follow(now, fx);
    }

    /// The command that waits for the current one may begin.
    fn follow(&mut self, now: Time, fx: &mut ExpertEffects) {
        match self.queued {
            Some(job) if job.command.mode == BufferMode::BufferedDelay => {
                self.delayed = now.saturating_add(job.command.delay);
            }
            Some(job) if job.command.mode != BufferMode::Trigger => self.begin_queued(now, fx),
            _ => {}
        }
    }

    /// The command that waits begins.
    pub(super) fn begin_queued(&mut self, now: Time, fx: &mut ExpertEffects) {
        if let Some(job) = self.queued.take() {
            self.delayed = Time::MAX;
            self.end_active(CommandPhase::Aborted);
            self.begin(now, job, fx);
        }
    }

    /// The current command goes over into the next one, where both go the same way.
    fn blend(&mut self, now: Time, first: &AxisCommand, second: &AxisCommand, fx: &mut ExpertEffects) {
        let MotionTarget::Position { target, velocity, .. } = self.motion.aim() else { return };
        let end = second.mode.blend(velocity, second.velocity);
        let forward =
            if target == self.position() { self.motion.train.forward() } else { target > self.position() };
        let onwards = match second.order {
            MotionCommand::To(next) => next != target && (next > target) == forward,
            MotionCommand::By(distance) => distance != 0 && (distance > 0) == forward,
            MotionCommand::Velocity(way) => way.unwrap_or(forward) == forward && second.velocity > 0,
            _ => false,
        };
        if onwards && end > 0 {
            self.motion.retarget(now, MotionTarget::Position { target, velocity, end }, first.ramps, fx);
        }
    }

    pub(super) fn mark(&mut self, now: Time, mark: HomingEvent, fx: &mut ExpertEffects) {
        let (forward, position) = (self.motion.train.forward(), self.position());
        if let (Some(search), Some(job)) = (&mut self.search, self.active)
            && search.mark(mark, forward, position)
        {
            let aim = search.aim();
            if let Some(progress) = self.motion.retarget(now, aim, job.command.ramps, fx) {
                self.progress(now, progress, fx);
            }
        }
    }

    pub(super) fn probe_edge(&mut self, now: Time, on: bool, fx: &mut ExpertEffects) {
        let trigger = self.queued.is_some_and(|job| job.command.mode == BufferMode::Trigger);
        if self.probe.edge(on, self.position()) && trigger {
            self.begin_queued(now, fx);
        }
    }

    /// Captures the position with the next edge of the PROBE input.
    pub fn touch(&mut self, capture: CaptureTrigger) -> Result<u32, AxisFault> {
        let empty = capture.window.is_some_and(|(first, last)| first > last);
        if self.config.probe.is_none() || empty {
            return Err(AxisFault::InvalidProbe);
        }
        let ticket = self.ticket();
        self.probe.arm(ticket, capture);
        Ok(ticket)
    }

    /// A capture, or what became of it, and the position.
    pub fn touched(&self, ticket: u32) -> (CommandPhase, i64) {
        (self.probe.phase(ticket), self.probe.position())
    }

    /// Captures nothing more.
    pub fn abort_trigger(&mut self) -> Result<(), AxisFault> {
        if self.config.probe.is_none() {
            return Err(AxisFault::InvalidProbe);
        }
        self.probe.abort();
        Ok(())
    }

    /// How far a command is.
    pub fn phase(&self, ticket: u32) -> CommandPhase {
        let is = |job: Option<QueuedCommand>| job.filter(|job| job.ticket == ticket);
        if let Some(job) = is(self.active) {
            let velocity = matches!(job.command.order, MotionCommand::Velocity(_));
            if velocity && self.motion.in_velocity() {
                CommandPhase::InVelocity
            } else {
                CommandPhase::Active
            }
        } else if is(self.queued).is_some() {
            CommandPhase::Waiting
        } else {
            self.ends.get(ticket)
        }
    }

    fn end_active(&mut self, phase: CommandPhase) {
        if let Some(job) = self.active.take() {
            self.ends.set(job.ticket, phase);
        }
    }

    fn end_all(&mut self, active: CommandPhase, queued: CommandPhase) {
        self.end_active(active);
        if let Some(job) = self.queued.take() {
            self.ends.set(job.ticket, queued);
        }
        self.delayed = Time::MAX;
        self.search = None;
    }

    /// The block of a stop lets go (io:STD-PTO-03).
    pub fn release(&mut self, ticket: u32) {
        if self.state == AxisState::Stopping && self.stop == ticket {
            self.released = true;
            if self.active.is_none() {
                self.let_go();
            }
        }
    }

    fn let_go(&mut self) {
        self.state = AxisState::Standstill;
        self.stop = 0;
    }

    /// Whether an error of the axis would change its state.
    pub(super) const fn powered_state(&self) -> bool {
        !matches!(self.state, AxisState::Disabled | AxisState::ErrorStop)
    }

    /// An error of the axis (io:STD-PTO-10).
    pub(super) fn fail(&mut self, now: Time, fault: AxisFault, fx: &mut ExpertEffects) {
        if self.state == AxisState::ErrorStop {
            return;
        }
        self.end_all(CommandPhase::Failed(fault), CommandPhase::Aborted);
        self.state = AxisState::ErrorStop;
        self.fault = Some(fault);
        self.stop = 0;
        fx.push(now, ExpertEffect::AxisError { function: self.place });
        self.motion.retarget(now, MotionTarget::Stop, self.fast_stop(), fx);
    }

    /// Power off: pulses end, what ran has failed.
    pub(super) fn disable(&mut self, now: Time, why: AxisFault, fx: &mut ExpertEffects) {
        self.motion.cut(now, fx);
        self.switch_drive(now, false, fx);
        self.end_all(CommandPhase::Failed(why), CommandPhase::Failed(why));
        self.stop = 0;
        self.homed = false;
        if self.state != AxisState::ErrorStop {
            self.state = AxisState::Disabled;
        }
    }

    /// The program gives the axis power or takes it.
    pub fn power(&mut self, now: Time, enable: bool, fx: &mut ExpertEffects) {
        self.enabled = enable;
        if enable {
            self.switch_drive(now, self.operating, fx);
            self.update_power(now, fx);
        } else if self.drive || self.state != AxisState::Disabled {
            self.disable(now, AxisFault::Disabled, fx);
        }
    }

    /// An axis with power is no longer Disabled.
    pub(super) fn update_power(&mut self, now: Time, fx: &mut ExpertEffects) {
        if self.state == AxisState::Disabled && self.powered() {
            self.state = AxisState::Standstill;
            if self.cut {
                self.fail(now, AxisFault::OutputProtection, fx);
            }
        }
    }

    /// Gives the position another number; it is known then.
    pub fn set_position(&mut self, position: i64) -> Result<(), AxisFault> {
        if self.state != AxisState::Standstill {
            return Err(AxisFault::InvalidSetPosition);
        }
        self.motion.train.set_position(position);
        self.homed = true;
        Ok(())
    }

    /// Leaves ErrorStop, once the axis is at rest and the cause is gone; whether that is so.
    pub fn acknowledge(&mut self) -> Result<bool, AxisFault> {
        if self.state != AxisState::ErrorStop {
            return Ok(true);
        }
        if self.motion.train.goes_on() {
            return Ok(false);
        }
        match self.fault {
            Some(AxisFault::OutputProtection) if self.cut => return Err(AxisFault::OutputProtection),
            Some(AxisFault::DriveNotReady) if self.enabled && !self.drive_is_ready() => {
                return Err(AxisFault::DriveNotReady);
            }
            _ => {}
        }
        self.fault = None;
        self.state = if self.powered() { AxisState::Standstill } else { AxisState::Disabled };
        self.homed &= self.state == AxisState::Standstill;
        Ok(true)
    }
}
