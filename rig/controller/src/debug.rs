//! Breakpoints: RUNNING with breakpoint (controller:TR-22). The processing of all tasks is held, and their time with
//! it: neither a watchdog nor a release goes on until they do.

use crate::commands::CommandError;
use crate::{Controller, Effects, State};
use profile::StopCause;
use signal::{Span, Time};

impl Controller {
    /// A task of this place stands before a statement with a breakpoint.
    pub(crate) fn enter_breakpoint(&mut self, place: usize, fx: &mut Effects) {
        let now = self.cpu.at;
        self.held = Some((now, place));
        self.system.stop_cause = StopCause::Debugging;
        self.enter(State::Breakpoint, now, fx);
    }

    /// Every task stops before the first statement of a line, or of the next line that has one.
    pub(crate) fn set_breakpoint(&mut self, file: u16, line: u32) -> Result<(), CommandError> {
        if !matches!(self.state, State::Stopped | State::Running | State::Breakpoint) {
            return Err(CommandError::State(self.state));
        }
        let set = self.application.as_mut().and_then(|it| it.breakpoint(file, line));
        set.map(|_| ()).ok_or(CommandError::NoStatement { line })
    }

    /// Takes every breakpoint away; tasks that are held go on (controller:TR-22).
    pub(crate) fn clear_breakpoints(&mut self, now: Time, fx: &mut Effects) {
        if let Some(application) = &mut self.application {
            application.clear_breakpoints();
        }
        let _ = self.resume(now, fx);
    }

    /// The task that is held goes on to its next statement.
    pub(crate) fn step_statement(&mut self, now: Time, fx: &mut Effects) -> Result<(), CommandError> {
        if let (Some((_, place)), Some(application)) = (self.held, &mut self.application) {
            application.step(place);
        }
        self.resume(now, fx)
    }

    /// The tasks go on in the middle of their cycles, as if no time had passed for them.
    pub(crate) fn resume(&mut self, now: Time, fx: &mut Effects) -> Result<(), CommandError> {
        let (State::Breakpoint, Some((since, _))) = (self.state, self.held.take()) else {
            return Err(CommandError::State(self.state));
        };
        self.postpone(now - since);
        // The processor had nothing to do.
        self.load.advance(now, None, &mut self.tasks);
        self.enter(State::Running, now, fx);
        Ok(())
    }

    /// Everything that the tasks wait for comes later by this.
    fn postpone(&mut self, by: Span) {
        for task in &mut self.tasks {
            task.postpone(by);
        }
        // MAX stays MAX.
        self.tick = self.tick.saturating_add(by);
        self.cpu.busy_since = self.cpu.busy_since.saturating_add(by);
        self.cpu.busy_until = self.cpu.busy_until.saturating_add(by);
    }
}
