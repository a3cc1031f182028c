//! Breakpoints, single step and coverage of a machine.

use super::Machine;
use crate::state::Coverage;

impl Machine {
    /// Switches coverage on, from nothing, or off.
    pub fn set_coverage(&mut self, on: bool) {
        self.debug.set_coverage(on, &self.program);
    }

    /// What ran since coverage was switched on.
    pub fn coverage(&self) -> Coverage {
        self.debug.coverage(&self.program)
    }

    /// Stops every task before the first statement of a line, or of the next line that has one: which line that is.
    pub fn set_breakpoint(&mut self, file: u16, line: u32) -> Option<u32> {
        self.debug.set_breakpoint(file, line, &self.program)
    }

    /// Takes all breakpoints away.
    pub fn clear_breakpoints(&mut self) {
        self.debug.clear_breakpoints();
    }

    /// The task's next slice stops before the next statement: the first one of a cycle that begins, else the one after
    /// the statement at which the task stands. Calls are followed.
    pub fn step(&mut self, task: usize) {
        self.debug.prepare(&self.program);
        if let Some(task) = self.tasks.get_mut(task) {
            task.stepping = true;
        }
    }
}
