//! Breakpoints: RUNNING with breakpoint (controller:TR-22). The processing of all tasks is held, and their time with
//! it: neither a watchdog nor a release goes on until they do.

use super::Controller;
use crate::CommandError;
use crate::{Effects, State};
use profile::StopCause;
use signal::Time;

impl Controller {
    /// A task of this place stands before a statement with a breakpoint.
    pub(super) fn enter_breakpoint(&mut self, place: usize, fx: &mut Effects) {
        let now = self.scheduler.now();
        self.scheduler.hold_at_breakpoint(place);
        self.system.stop_cause = StopCause::Debugging;
        self.enter(State::Breakpoint, now, fx);
    }

    /// Every task stops before the first statement of a line, or of the next line that has one.
    pub(super) fn set_breakpoint(&mut self, file: u16, line: u32) -> Result<(), CommandError> {
        if !matches!(self.state, State::Stopped | State::Running | State::Breakpoint) {
            return Err(CommandError::State(self.state));
        }
        let set = self.application.as_mut().and_then(|it| it.breakpoint(file, line));
        set.map(|_| ()).ok_or(CommandError::NoStatement { line })
    }

    /// Takes every breakpoint away; tasks that are held go on (controller:TR-22).
    pub(super) fn clear_breakpoints(&mut self, now: Time, fx: &mut Effects) {
        if let Some(application) = &mut self.application {
            application.clear_breakpoints();
        }
        let _ = self.resume(now, fx);
    }

    /// The task that is held goes on to its next statement.
    pub(super) fn step_statement(&mut self, now: Time, fx: &mut Effects) -> Result<(), CommandError> {
        if let (Some(place), Some(application)) = (self.scheduler.at_breakpoint(), &mut self.application) {
            application.step(place);
        }
        self.resume(now, fx)
    }

    /// The tasks go on in the middle of their cycles, as if no time had passed for them.
    pub(super) fn resume(&mut self, now: Time, fx: &mut Effects) -> Result<(), CommandError> {
        if self.state != State::Breakpoint || !self.scheduler.resume(now) {
            return Err(CommandError::State(self.state));
        }
        self.enter(State::Running, now, fx);
        Ok(())
    }
}
