//! Between two turns: what clients of a rig that is kept running ask for, and what is left for them.

use super::Executor;
use super::event_source::EventSource;
use crate::executor::rig_fault::RigFault;
use crate::scan_port::{ExecutorRole, ObservedSource, ScanCommand, ScanCommandError, ScanPort, ScanRequest};
use crate::subject::{NO_PROBE, SubjectExt};
use control::ControllerAction;
use controller::{Command, Probe};
use drivers::{BusEvent, ChannelId, LossReason};
use signal::{Address, Area, Cause, Time, Value, When};
use std::sync::atomic::Ordering;

/// Whether a probe of the rig's own controller means the same in the one that an executor has: the program and the functions
/// of a case are others.
fn is_there(probe: Probe, role: ExecutorRole) -> bool {
    role == ExecutorRole::Rig
        || !matches!(probe, Probe::Variable(_) | Probe::Expert { .. } | Probe::TaskFigure { .. })
}

/// What a client's order came to here: faults of the rig apart, a value or a refusal.
type CommandOutcome = Result<Option<Value>, ScanCommandError>;

impl<'a> Executor<'a> {
    /// The same, and clients are served by this port.
    #[must_use]
    pub fn serving(mut self, port: Option<&'a mut ScanPort>, role: ExecutorRole) -> Executor<'a> {
        self.live = port;
        if let Some(live) = &mut self.live {
            self.parts.subject.reserve(live.watches());
            live.begin(role, |of| match of {
                ObservedSource::Inside(probe) if is_there(probe, role) => self.parts.subject.watch(probe),
                _ => NO_PROBE,
            });
        }
        self
    }

    /// Serves the clients. FALSE where time stands still until they lead it on.
    #[inline]
    pub(super) fn serve_clients(&mut self) -> Result<bool, RigFault> {
        while let Some(request) = self.live.as_mut().and_then(|live| live.next_request()) {
            self.handle_request(request)?;
        }
        if let Some(live) = &mut self.live {
            live.served();
        }
        if self.live.as_ref().is_some_and(|live| live.stands_still(self.now)) && !self.has_more() {
            return self.stand_still();
        }
        let Some(live) = &mut self.live else { return Ok(true) };
        live.passes();
        if live.is_due(self.now) {
            self.publish_snapshot();
        }
        Ok(true)
    }

    /// Up to where clients lead the time.
    #[inline]
    pub(super) fn stepped_until(&self) -> Time {
        self.live.as_ref().map_or(Time::MAX, |live| live.until())
    }

    /// Whether something is due by now.
    fn has_more(&self) -> bool {
        let now = self.now;
        EventSource::BY_THEMSELVES.into_iter().filter_map(|source| source.next(self)).any(|due| due <= now)
    }

    fn stand_still(&mut self) -> Result<bool, RigFault> {
        if self.live.as_ref().is_some_and(|live| live.is_stale()) {
            self.publish_snapshot();
        }
        if let Some(live) = &mut self.live {
            live.arrive();
            live.wait();
        }
        if self.parts.interrupt.load(Ordering::Relaxed) { Err(RigFault::Interrupted) } else { Ok(false) }
    }

    /// Leaves a snapshot.
    fn publish_snapshot(&mut self) {
        let Some(live) = &mut self.live else { return };
        let (subject, board) = (&*self.parts.subject, &*self.parts.board);
        let (late, late_outputs) = (self.parts.recorder.late(), self.lines.late_outputs());
        let tasks = live.tasks();
        live.publish(self.now, |snapshot| {
            snapshot.state = subject.state();
            snapshot.front = subject.front();
            for place in 0..tasks {
                if let (Some(kept), Some(task)) = (snapshot.tasks.get_mut(place), subject.task_status(place))
                {
                    *kept = task;
                }
            }
            snapshot.health = board.health();
            (snapshot.late, snapshot.late_outputs) = (late, late_outputs);
        });
    }

    fn handle_request(&mut self, request: ScanRequest) -> Result<(), RigFault> {
        match request {
            ScanRequest::Watch(source, of) => {
                let role = self.live.as_ref().map_or(ExecutorRole::Rig, |live| live.role());
                let probe = match of {
                    ObservedSource::Inside(probe) if is_there(probe, role) => self.parts.subject.watch(probe),
                    _ => NO_PROBE,
                };
                let (at, value) = self.look(of);
                if let Some(live) = &mut self.live {
                    live.follow(source, of, probe);
                    live.change(source, at, value);
                }
            }
            ScanRequest::Unwatch(source) => {
                if let Some(probe) = self.live.as_mut().and_then(|live| live.unfollow(source)) {
                    self.parts.subject.unwatch(probe);
                }
            }
            ScanRequest::Command(ticket, command) if self.is_case() => {
                return self.command_in_case(ticket, command);
            }
            ScanRequest::Command(ticket, ScanCommand::Plan) => {
                if let Some(live) = &mut self.live {
                    live.make_room();
                    live.answer(ticket, Ok(None));
                }
                // The controller ends as it does after its time.
                self.over = true;
            }
            ScanRequest::Command(ticket, ScanCommand::Advance(by)) => {
                let now = self.now;
                if let Some(live) = &mut self.live
                    && !live.advance(ticket, now, by)
                {
                    live.answer(ticket, Err(ScanCommandError::NotStepped));
                }
            }
            ScanRequest::Command(ticket, command) => {
                let came = self.carry_out(command);
                self.apply()?;
                // Whoever leads the time finds what an order did in the status after it.
                if self.live.as_ref().is_some_and(|live| live.is_led()) {
                    self.publish_snapshot();
                }
                if let Some(live) = &mut self.live {
                    live.answer(ticket, came);
                }
            }
        }
        Ok(())
    }

    fn is_case(&self) -> bool {
        self.live.as_ref().is_some_and(|live| live.role() == ExecutorRole::Case)
    }

    /// While a case runs the board is its own: clients may look, and end it.
    fn command_in_case(&mut self, ticket: u64, command: ScanCommand) -> Result<(), RigFault> {
        let came = match command {
            ScanCommand::Read(of) => Ok(Some(self.look(of).1)),
            ScanCommand::Abort => Ok(None),
            _ => Err(ScanCommandError::PlanRuns),
        };
        let aborts = command == ScanCommand::Abort;
        if let Some(live) = &mut self.live {
            if aborts {
                live.abort();
            }
            live.answer(ticket, came);
        }
        if aborts { Err(RigFault::Interrupted) } else { Ok(()) }
    }

    /// A step of the case began, or is done.
    pub(super) fn report_step(&mut self, step: usize, done: bool) {
        let at = self.now - self.report.start.unwrap_or(self.now);
        if let Some(live) = &mut self.live {
            live.step(step, at, done);
        }
    }

    /// What a source shows now.
    fn look(&self, of: ObservedSource) -> (When, Value) {
        match of {
            ObservedSource::Inside(probe) if self.is_case() && !is_there(probe, ExecutorRole::Case) => {
                (self.seen(self.now), Value::Unknown)
            }
            ObservedSource::Inside(probe) => (self.seen(self.now), self.parts.subject.read(&probe)),
            ObservedSource::Channel(channel) => {
                let unseen = (When::exactly(self.now), Value::Unknown);
                self.live.as_ref().map_or(unseen, |live| live.seen(channel))
            }
        }
    }

    fn carry_out(&mut self, command: ScanCommand) -> CommandOutcome {
        match command {
            ScanCommand::Read(of) => Ok(Some(self.look(of).1)),
            ScanCommand::Write(ObservedSource::Inside(probe), value) => {
                let written = self.parts.subject.write(
                    self.now,
                    &probe,
                    value,
                    Cause::Unknown,
                    &mut self.buffers.effects,
                );
                written.map(|()| None).map_err(ScanCommandError::Write)
            }
            ScanCommand::Write(ObservedSource::Channel(channel), value) => self.write_channel(channel, value),
            ScanCommand::Force(address, value) => self.command(&Command::Force { address, value }),
            ScanCommand::Release(address) => self.command(&Command::Unforce(address)),
            ScanCommand::ReleaseAll => self.release_all(),
            ScanCommand::Command(action) => self.act_on(action),
            ScanCommand::Abort => Err(ScanCommandError::NoPlan),
            // Answered when they have come to pass.
            ScanCommand::Advance(_) | ScanCommand::Plan => Ok(None),
        }
    }

    /// Puts a value on a line that nothing else of the rig drives.
    fn write_channel(&mut self, channel: ChannelId, value: Value) -> CommandOutcome {
        self.buffers.writes.clear();
        self.buffers.writes.push((channel, value));
        if let Some(writer) = self.parts.wiring.writers.get_mut(usize::from(channel.0)) {
            *writer = Cause::Unknown;
        }
        let written = self.parts.board.write(self.board_time(), &self.buffers.writes);
        self.buffers.writes.clear();
        written.map_err(ScanCommandError::Board)?;
        if let Some(driven) = self.driven.values.get_mut(usize::from(channel.0)) {
            *driven = value;
        }
        Ok(None)
    }

    fn command(&mut self, command: &Command) -> CommandOutcome {
        let obeyed = self.parts.subject.command(self.now, command, &mut self.buffers.effects);
        obeyed.map(|()| None).map_err(ScanCommandError::Command)
    }

    fn release_all(&mut self) -> CommandOutcome {
        let Some(front) = self.parts.subject.front() else { return Err(ScanCommandError::NoModel) };
        let inputs = front.forced_inputs.iter().map(|(input, _)| Address::bit(Area::Input, input as u32));
        let outputs =
            front.forced_outputs.iter().map(|(output, _)| Address::bit(Area::Output, output as u32));
        let of_modules = front.forced_places.iter().map(|(address, _)| address);
        for address in inputs.chain(outputs).chain(of_modules) {
            self.command(&Command::Unforce(address))?;
        }
        Ok(None)
    }

    fn act_on(&mut self, action: ControllerAction) -> CommandOutcome {
        let command = match action {
            ControllerAction::Run => Command::Run,
            ControllerAction::Stop => Command::Stop,
            ControllerAction::ResetWarm => Command::ResetWarm,
            ControllerAction::ResetCold => Command::ResetCold,
            ControllerAction::ResetOrigin => Command::ResetOrigin,
            ControllerAction::Reboot => Command::Reboot,
            ControllerAction::SwitchRun => Command::Switch(true),
            ControllerAction::SwitchStop => Command::Switch(false),
            ControllerAction::PowerOn | ControllerAction::PowerOff => {
                self.parts.subject.power(
                    self.now,
                    action == ControllerAction::PowerOn,
                    &mut self.buffers.effects,
                );
                return Ok(None);
            }
        };
        self.command(&command)
    }

    /// Clients learn what a channel has.
    #[inline]
    pub(super) fn report_channel(
        &mut self,
        channel: ChannelId,
        at: When,
        value: Value,
        lost: Option<LossReason>,
    ) {
        if let Some(live) = &mut self.live {
            live.channel(channel, at, value, lost);
        }
    }

    /// Clients learn what was on a bus.
    #[inline]
    pub(super) fn report_bus(&mut self, event: &BusEvent) {
        if let Some(live) = &mut self.live {
            live.bus(event);
        }
    }
}
