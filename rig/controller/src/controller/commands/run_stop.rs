//! Run, Stop and the Run/Stop switch (controller: sections 13, 14.1, 14.2).

use crate::CommandError;
use crate::controller::Controller;
use crate::{Effects, State};
use profile::StopCause;
use signal::Time;

impl Controller {
    pub(in crate::controller) fn command_run(
        &mut self,
        now: Time,
        fx: &mut Effects,
    ) -> Result<(), CommandError> {
        match self.state {
            State::Stopped => {
                self.may_run(now)?;
                self.enter_running(now, fx);
                Ok(())
            }
            state => Err(CommandError::State(state)),
        }
    }

    pub(in crate::controller) fn command_stop(
        &mut self,
        cause: StopCause,
        now: Time,
        fx: &mut Effects,
    ) -> Result<(), CommandError> {
        match self.state {
            State::Running if self.scheduler.stopping().is_some() => Err(CommandError::Stopping),
            State::Running => {
                // Cycles under way are finished, so that no context is ever half a cycle.
                if self.scheduler.is_between_cycles() {
                    self.enter_stopped(now, cause, fx);
                } else {
                    self.scheduler.stop_after_cycles(cause);
                }
                Ok(())
            }
            // The cycles that are held are given up: nothing of them runs after a Stop.
            State::Breakpoint => {
                self.enter_stopped(now, cause, fx);
                Ok(())
            }
            // controller:TR-26
            State::Empty => Ok(()),
            state => Err(CommandError::State(state)),
        }
    }

    /// controller:RS-06, controller:RS-10
    pub(in crate::controller) fn move_switch(&mut self, run: bool, now: Time, fx: &mut Effects) {
        if std::mem::replace(&mut self.power.switch_at_run, run) == run {
            return;
        }
        // An edge that the state does not take is no error: only the position stays.
        let _ = if run { self.command_run(now, fx) } else { self.command_stop(StopCause::Switch, now, fx) };
    }
}
