//! Forcing: who may force, and when it ends (controller: section 12).

use super::Controller;
use crate::{CommandError, State};
use profile::IoChannel;

impl Controller {
    /// Forcing acts at the next end of the output's task (controller:FRC-05) or read of the inputs.
    pub(super) fn force(&mut self, channel: IoChannel, on: Option<bool>) -> Result<(), CommandError> {
        if !matches!(self.state, State::Running | State::Breakpoint | State::Stopped | State::Halt) {
            return Err(CommandError::State(self.state));
        }
        if !self.power.tool_connected {
            return Err(CommandError::NotConnected);
        }
        match channel {
            IoChannel::Input(input) if input < self.config.reference.input_count() => {
                self.io.force_input(input, on);
            }
            IoChannel::Output(output) if self.io.drives(output) => {
                return Err(CommandError::ExpertOutput(output));
            }
            IoChannel::Output(output) if output < self.config.reference.output_count() => {
                self.io.force_output(output, on);
            }
            channel => return Err(CommandError::NoChannel(channel)),
        }
        Ok(())
    }

    /// The tool connects (controller:FRC-01).
    pub(super) fn log_in(&mut self) -> Result<(), CommandError> {
        self.state.status().ok_or(CommandError::State(self.state))?;
        self.power.tool_connected = true;
        Ok(())
    }

    /// The tool disconnects and keeps forcing, or ends it (controller:FRC-03).
    pub(super) fn log_out(&mut self, keep_forcing: bool) -> Result<(), CommandError> {
        self.state.status().ok_or(CommandError::State(self.state))?;
        if !self.power.tool_connected {
            return Err(CommandError::NotConnected);
        }
        self.power.tool_connected = false;
        if !keep_forcing {
            self.io.clear_forcing();
        }
        Ok(())
    }
}
