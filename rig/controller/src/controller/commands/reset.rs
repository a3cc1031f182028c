//! Reset warm and reset cold (controller: section 14.5).

use crate::CommandError;
use crate::controller::Controller;
use crate::controller::transition::ApplicationStart;
use crate::first_cycle::FirstCycle;
use crate::{Effects, State, VariableReset};
use profile::StopCause;
use signal::Time;

impl Controller {
    /// Reset warm and cold (controller:RW-01, controller:RC-01, controller:TR-13).
    pub(in crate::controller) fn command_reset(
        &mut self,
        reset: VariableReset,
        now: Time,
        fx: &mut Effects,
    ) -> Result<(), CommandError> {
        self.check_recoverable()?;
        if !matches!(self.state, State::Running | State::Breakpoint | State::Stopped | State::Halt) {
            return Err(CommandError::State(self.state));
        }
        let cause = self.stopped_by(StopCause::Reset);
        let Some(application) = &mut self.application else { return Err(CommandError::State(self.state)) };
        application.reset(reset);
        self.system.first_cycle = FirstCycle::after(reset);
        self.memory.reset(|word| !application.associates(word));
        application.initialize(&mut self.memory);
        self.show_fixed();
        if reset == VariableReset::COLD {
            self.io.reset_functions(now);
            self.system.events = 0;
        }
        self.clear_diagnostics(cause);
        self.initial_outputs(ApplicationStart::Reset, State::Stopped, now, fx);
        self.rest(State::Stopped, now, fx);
        self.remanent.dirty = true;
        self.save_if_dirty(now);
        Ok(())
    }

    /// Forcing and the indications of errors are erased (controller:FRC-07, controller:WD-15); `stopped` is why RUNNING is
    /// left with that.
    pub(in crate::controller) fn clear_diagnostics(&mut self, stopped: Option<StopCause>) {
        self.clear_forcing();
        self.io.reset_protection();
        self.clear_errors(stopped);
        self.clear_commands();
    }
}
