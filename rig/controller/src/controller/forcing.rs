//! Forcing: who may force, and when it ends (controller: section 12).

use super::Controller;
use crate::probes::class;
use crate::{CommandError, Effects, ForcedPlaces, State};
use profile::IoChannel;
use signal::{Address, Cause, Time};

impl Controller {
    /// Forcing acts at the next end of the output's task (controller:FRC-05) or read of the inputs.
    pub(super) fn force(&mut self, address: Address, value: Option<u64>) -> Result<(), CommandError> {
        if !matches!(self.state, State::Running | State::Breakpoint | State::Stopped | State::Halt) {
            return Err(CommandError::State(self.state));
        }
        if !self.power.tool_connected {
            return Err(CommandError::NotConnected);
        }
        let on = value.map(|value| value != 0);
        match IoChannel::at(address, self.config.reference) {
            Some(IoChannel::Input(input)) => self.io.force_input(input, on),
            Some(IoChannel::Output(output)) if self.io.drives(output) => {
                return Err(CommandError::ExpertOutput(output));
            }
            Some(IoChannel::Output(output)) => self.io.force_output(output, on),
            None => return self.modules.bus.force(address, value),
        }
        Ok(())
    }

    /// Nothing is forced any more (controller:FRC-07).
    pub(super) fn clear_forcing(&mut self) {
        self.io.clear_forcing();
        self.modules.bus.restore_forced(ForcedPlaces::default());
    }

    /// Whether anything is forced (controller:STATE-03).
    pub(super) fn has_forced(&self) -> bool {
        self.io.has_forced() || !self.modules.bus.forced().is_empty()
    }

    /// The tool connects (controller:FRC-01).
    pub(super) fn log_in(&mut self, now: Time, fx: &mut Effects) -> Result<(), CommandError> {
        self.state.status().ok_or(CommandError::State(self.state))?;
        self.power.tool_connected = true;
        // The port of the tool shows it.
        self.observe(class::STATE, now, Cause::Controller, fx);
        Ok(())
    }

    /// The tool disconnects and keeps forcing, or ends it (controller:FRC-03).
    pub(super) fn log_out(
        &mut self,
        keep_forcing: bool,
        now: Time,
        fx: &mut Effects,
    ) -> Result<(), CommandError> {
        self.state.status().ok_or(CommandError::State(self.state))?;
        if !self.power.tool_connected {
            return Err(CommandError::NotConnected);
        }
        self.power.tool_connected = false;
        if !keep_forcing {
            self.clear_forcing();
        }
        self.observe(class::STATE, now, Cause::Controller, fx);
        Ok(())
    }
}
