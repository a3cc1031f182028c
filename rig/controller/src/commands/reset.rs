//! Reset warm and reset cold (controller: section 14.5).

use super::CommandError;
use crate::service::FirstCycle;
use crate::transition::ApplicationStart;
use crate::{Controller, Effects, State, VariableReset};
use profile::{ApplicationError, StopCause};
use signal::Time;

impl Controller {
    /// Reset warm and cold (controller:RW-01, controller:RC-01, controller:TR-13).
    pub(crate) fn command_reset(
        &mut self,
        reset: VariableReset,
        now: Time,
        fx: &mut Effects,
    ) -> Result<(), CommandError> {
        if !matches!(self.state, State::Running | State::Breakpoint | State::Stopped | State::Halt) {
            return Err(CommandError::State(self.state));
        }
        let Some(application) = &mut self.application else { return Err(CommandError::State(self.state)) };
        let runs = matches!(self.state, State::Running | State::Breakpoint);
        let cause = if runs { StopCause::Reset } else { StopCause::Unknown };
        application.reset(reset);
        self.start = FirstCycle::behind(reset);
        self.memory.reset(|word| !application.associates(word));
        application.initialize(&mut self.memory);
        if reset == VariableReset::COLD {
            self.functions.reset(now);
        }
        self.clear_diagnostics(cause);
        self.initial_outputs(ApplicationStart::Reset, State::Stopped, now, fx);
        self.rest(State::Stopped, now, fx);
        self.context.dirty = true;
        self.save_if_dirty(now);
        Ok(())
    }

    /// Forcing and the indications of errors are erased (controller:FRC-07, controller:WD-15).
    pub(crate) fn clear_diagnostics(&mut self, cause: StopCause) {
        self.clear_forcing();
        self.protection.reset();
        self.power.system_error = false;
        self.system.error = ApplicationError::None;
        self.system.stop_cause = cause;
        self.clear_plc_w();
    }
}
