//! What can be commanded, what it does (controller: section 14.4), and why it is refused.

use crate::controller::Forced;
use crate::{APPLICATION_FILE, Application, Controller, Effects, Entry, LoadError, State, VariableReset};
use profile::{ApplicationError, BootProjectStatus, Reference, StopCause};
use signal::{Address, Area, Size, Time};
use std::fmt;

/// A command of a user or a tool.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Command {
    /// Start the application (controller:RUN-01).
    Run,
    /// Stop the application (controller:STP-01). Cycles under way are finished first; no new one starts.
    Stop,
    /// Reset warm (controller:RW-01).
    ResetWarm,
    /// Reset cold (controller:RC-01).
    ResetCold,
    /// Load an application and make it the boot application (controller:DL-02).
    Download(Vec<u8>),
    /// Force the value of an embedded input or output (controller:FRC-01).
    Force {
        /// What is forced.
        channel: Channel,
        /// Its value.
        on: bool,
    },
    /// End the forcing of an embedded input or output.
    Unforce(Channel),
    /// Move the Run/Stop switch: TRUE to Run (controller:RS-01).
    Switch(bool),
}

/// An embedded input or output.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Channel {
    /// In, from I0.
    Input(usize),
    /// Qn, from Q0.
    Output(usize),
}

impl Channel {
    /// The channel behind a bit of %I or %Q; none where the reference has no channel there.
    pub fn at(address: Address, reference: &Reference) -> Option<Channel> {
        let bit = address.bit_offset() as usize;
        match (address.area(), address.size()) {
            (Area::Input, Size::Bit) if bit < reference.input_count() => Some(Channel::Input(bit)),
            (Area::Output, Size::Bit) if bit < reference.output_count() => Some(Channel::Output(bit)),
            _ => None,
        }
    }
}

/// Why a command was not obeyed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// Not possible in this state (controller:TR-24, controller:TR-28, controller:WD-14).
    State(State),
    /// The Run/Stop switch is at Stop.
    SwitchAtStop,
    /// A stop is under way: a cycle is being finished.
    Stopping,
    /// The reference has no such channel.
    NoChannel(Channel),
    /// The downloaded application is not valid. The old one is already erased: the state is EMPTY
    /// (controller:DL-04).
    Application(LoadError),
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Refusal::State(state) => write!(f, "not possible in state {state}"),
            Refusal::SwitchAtStop => f.write_str("the Run/Stop switch is at Stop"),
            Refusal::Stopping => f.write_str("a stop is under way"),
            Refusal::NoChannel(Channel::Input(n)) => write!(f, "the reference has no input I{n}"),
            Refusal::NoChannel(Channel::Output(n)) => write!(f, "the reference has no output Q{n}"),
            Refusal::Application(error) => write!(f, "the application is not valid: {error}"),
        }
    }
}

impl std::error::Error for Refusal {}

/// Why a value was not written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WriteError {
    /// No service answers in this state, or there is no application.
    State(State),
    /// The probe can only be read.
    ReadOnly,
    /// The value is no number.
    NotANumber,
}

impl fmt::Display for WriteError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            WriteError::State(state) => write!(f, "cannot be written in state {state}"),
            WriteError::ReadOnly => {
                f.write_str("can only be read: write a variable or a %M, %Q or %I address")
            }
            WriteError::NotANumber => f.write_str("the value is no number"),
        }
    }
}

impl std::error::Error for WriteError {}

impl Controller {
    /// Obeys a command at `now`, between two operations of the application.
    ///
    /// # Errors
    /// [`Refusal`]; nothing has happened then, except that a download whose application is not valid has erased the
    /// old one.
    pub fn command(&mut self, now: Time, command: Command, fx: &mut Effects) -> Result<(), Refusal> {
        self.come_to(now);
        match command {
            Command::Run => self.command_run(now, fx),
            Command::Stop => self.command_stop(StopCause::User, now, fx),
            Command::ResetWarm => self.command_reset(VariableReset::WARM, now, fx),
            Command::ResetCold => self.command_reset(VariableReset::COLD, now, fx),
            Command::Download(bundle) => self.command_download(&bundle, now, fx),
            Command::Force { channel, on } => self.force(channel, Some(on)),
            Command::Unforce(channel) => self.force(channel, None),
            Command::Switch(run) => {
                self.move_switch(run, now, fx);
                Ok(())
            }
        }
    }

    fn command_run(&mut self, now: Time, fx: &mut Effects) -> Result<(), Refusal> {
        match self.state {
            // controller:RS-06: the switch at Stop inhibits every Run command.
            State::Stopped if !self.power.switch_at_run => Err(Refusal::SwitchAtStop),
            State::Stopped => {
                self.enter_running(now, fx);
                Ok(())
            }
            state => Err(Refusal::State(state)),
        }
    }

    fn command_stop(&mut self, cause: StopCause, now: Time, fx: &mut Effects) -> Result<(), Refusal> {
        match self.state {
            State::Running if self.cpu.stopping.is_some() => Err(Refusal::Stopping),
            State::Running => {
                // Cycles under way are finished, so that no context is ever half a cycle.
                if self.cpu.active == 0 {
                    self.enter_stopped(now, cause, fx);
                } else {
                    self.cpu.stopping = Some(cause);
                }
                Ok(())
            }
            // controller:TR-26
            State::Empty => Ok(()),
            state => Err(Refusal::State(state)),
        }
    }

    /// controller:RS-06, controller:RS-10
    fn move_switch(&mut self, run: bool, now: Time, fx: &mut Effects) {
        if std::mem::replace(&mut self.power.switch_at_run, run) == run {
            return;
        }
        // An edge that the state does not take is no error: only the position stays.
        let _ = if run { self.command_run(now, fx) } else { self.command_stop(StopCause::Switch, now, fx) };
    }

    /// Reset warm and cold (controller:RW-01, controller:RC-01, controller:TR-13).
    fn command_reset(&mut self, reset: VariableReset, now: Time, fx: &mut Effects) -> Result<(), Refusal> {
        if !matches!(self.state, State::Running | State::Stopped | State::Halt) {
            return Err(Refusal::State(self.state));
        }
        let Some(application) = &mut self.application else { return Err(Refusal::State(self.state)) };
        let cause = if self.state == State::Running { StopCause::Reset } else { StopCause::Unknown };
        application.reset(reset);
        self.memory.reset(|word| !application.associates(word));
        application.initialize(&mut self.memory);
        self.clear_diagnostics(cause);
        self.initial_outputs(State::Stopped, now, fx);
        self.rest(State::Stopped, now, fx);
        self.context.dirty = true;
        self.save_if_dirty(now);
        Ok(())
    }

    /// Forcing and the indications of errors are erased (controller:FRC-07, controller:WD-15).
    fn clear_diagnostics(&mut self, cause: StopCause) {
        (self.forced_inputs, self.forced_outputs) = (Forced::default(), Forced::default());
        self.power.system_error = false;
        self.system.error = ApplicationError::None;
        self.system.stop_cause = cause;
    }

    /// Download (controller:DL-02, controller:TR-16): RETAIN variables and other data start anew, persistent ones and
    /// %MW0...%MW999 are kept where the application is the same one again.
    fn command_download(&mut self, bundle: &[u8], now: Time, fx: &mut Effects) -> Result<(), Refusal> {
        if !matches!(self.state, State::Running | State::Stopped | State::Halt | State::Empty) {
            return Err(Refusal::State(self.state));
        }
        let cause = if self.state == State::Running { StopCause::User } else { StopCause::Unknown };
        let old = self.application.take();
        self.cease();
        self.context.abandon();
        self.clear_diagnostics(cause);
        match self.build(bundle) {
            Ok(new) => self.take_over(old, new, bundle, now, fx),
            Err(error) => {
                self.fail_download(error, now, fx);
                return Err(Refusal::Application(error));
            }
        }
        Ok(())
    }

    fn take_over(
        &mut self,
        old: Option<Box<dyn Application>>,
        mut new: Box<dyn Application>,
        bundle: &[u8],
        now: Time,
        fx: &mut Effects,
    ) {
        if let Some((byte, tasks)) = self.shared_output_byte(&*new) {
            self.note(now, Entry::SharedOutputByte { byte, tasks }, fx);
        }
        new.reset(VariableReset::ALL);
        if let Some(old) = old.filter(|old| old.signature() == new.signature()) {
            let mut image = vec![0; old.retained_len()];
            old.save_retained(&mut image);
            new.restore_retained(&image);
            new.reset(VariableReset::DOWNLOAD);
        }
        self.memory.reset(|word| !new.associates(word));
        new.initialize(&mut self.memory);
        self.store.write(APPLICATION_FILE, bundle);
        self.context.newest(&*self.store);
        self.context.prepare(&*new);
        self.context.save_now(&*new, &self.memory, &mut *self.store);
        self.install(new);
        self.system.boot_project = BootProjectStatus::Valid;
        self.outputs.initialize(now);
        self.initial_outputs(State::Stopped, now, fx);
        self.rest(State::Stopped, now, fx);
    }

    /// controller:DL-04: the old application is already erased.
    fn fail_download(&mut self, error: LoadError, now: Time, fx: &mut Effects) {
        self.note(now, Entry::Load(error), fx);
        self.unload(now);
        self.store.remove(APPLICATION_FILE);
        self.system.boot_project = BootProjectStatus::None;
        self.enter(State::Empty, now, fx);
    }

    /// Forcing acts at the next write of the outputs (controller:FRC-05) or read of the inputs.
    fn force(&mut self, channel: Channel, on: Option<bool>) -> Result<(), Refusal> {
        if !matches!(self.state, State::Running | State::Stopped | State::Halt) {
            return Err(Refusal::State(self.state));
        }
        match channel {
            Channel::Input(input) if input < self.config.reference.input_count() => {
                self.forced_inputs.set(input, on)
            }
            Channel::Output(output) if output < self.config.reference.output_count() => {
                self.forced_outputs.set(output, on);
            }
            channel => return Err(Refusal::NoChannel(channel)),
        }
        Ok(())
    }
}
