//! Marks on the code for breakpoints, single step and coverage.

use super::TaskState;
use crate::code::Op;
use crate::program::Program;

/// A statement begins here.
const STATEMENT: u8 = 1;
/// It has a breakpoint.
const BREAK: u8 = 2;
/// The operation has run.
const RUN: u8 = 4;
/// The jump was taken.
const TAKEN: u8 = 8;
/// The jump was not taken.
const PASSED: u8 = 16;

/// Marks on the code. Empty until somebody asks for one.
#[derive(Clone, Debug, Default)]
pub(crate) struct Debug {
    marks: Vec<u8>,
    coverage: bool,
    breakpoints: bool,
}

impl Debug {
    /// Whether a slice of this task needs the slower variant.
    pub fn active(&self, task: &TaskState) -> bool {
        self.coverage || self.breakpoints || task.stepping || task.stopped
    }

    /// Whether the task stops before this operation.
    #[inline]
    pub fn stops(&self, pc: usize, task: &mut TaskState) -> bool {
        let mark = self.marks.get(pc).copied().unwrap_or(0);
        if mark & STATEMENT == 0 || task.stopped || (mark & BREAK == 0 && !task.stepping) {
            return false;
        }
        task.stopped = true;
        task.stepping = false;
        true
    }

    /// An operation runs.
    #[inline]
    pub fn begin(&mut self, pc: usize, task: &mut TaskState) {
        task.stopped = false;
        if let (true, Some(mark)) = (self.coverage, self.marks.get_mut(pc)) {
            *mark |= RUN;
        }
    }

    /// The operation at `jump`, a conditional jump, went to `pc`.
    #[inline]
    pub fn passed(&mut self, jump: Option<usize>, pc: usize, program: &Program) {
        let Some(jump) = jump.filter(|_| self.coverage) else { return };
        if let (Some(step), Some(mark)) = (program.code.get(jump), self.marks.get_mut(jump)) {
            *mark |= if pc == step.a as usize { TAKEN } else { PASSED };
        }
    }

    /// Makes the marks, if there are none yet.
    pub fn prepare(&mut self, program: &Program) {
        if self.marks.is_empty() {
            self.marks = vec![0; program.code.len()];
            for statement in &program.statements {
                if let Some(mark) = self.marks.get_mut(statement.pc as usize) {
                    *mark |= STATEMENT;
                }
            }
        }
    }

    fn clear(&mut self, marks: u8) {
        self.marks.iter_mut().for_each(|mark| *mark &= !marks);
    }

    /// Switches coverage on, from nothing, or off.
    pub fn set_coverage(&mut self, on: bool, program: &Program) {
        self.prepare(program);
        self.clear(RUN | TAKEN | PASSED);
        self.coverage = on;
    }

    /// What ran since coverage was switched on.
    pub fn coverage(&self, program: &Program) -> Coverage {
        let mark = |pc: usize| self.marks.get(pc).copied().unwrap_or(0);
        let statements = program.statements.iter().map(|statement| StatementCoverage {
            file: statement.file,
            line: statement.line,
            executed: mark(statement.pc as usize) & RUN != 0,
        });
        let jumps =
            program.code.iter().zip(&program.lines).enumerate().filter(|(_, (step, _))| step.op.branches());
        let branches = jumps.map(|(pc, (_, line))| BranchCoverage {
            file: program.file_at(pc as u32),
            line: *line,
            taken: mark(pc) & TAKEN != 0,
            passed: mark(pc) & PASSED != 0,
        });
        Coverage { statements: statements.collect(), branches: branches.collect() }
    }

    /// Sets a breakpoint at the first statement of a line, or of the next line that has one: which line that is.
    pub fn set_breakpoint(&mut self, file: u16, line: u32, program: &Program) -> Option<u32> {
        let after = program.statements.iter().filter(|known| known.file == file && known.line >= line);
        let statement = *after.min_by_key(|known| (known.line, known.pc))?;
        self.prepare(program);
        *self.marks.get_mut(statement.pc as usize)? |= BREAK;
        self.breakpoints = true;
        Some(statement.line)
    }

    /// Takes all breakpoints away.
    pub fn clear_breakpoints(&mut self) {
        self.clear(BREAK);
        self.breakpoints = false;
    }
}

impl Op {
    /// Whether it may go on at its `a` or after itself.
    pub(crate) fn branches(self) -> bool {
        (self as u16 >= Op::JumpIf as u16) && (self as u16 <= Op::ForU64 as u16)
    }
}

/// What ran since coverage was switched on.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Coverage {
    /// All statements in the order of the code.
    pub statements: Vec<StatementCoverage>,
    /// All conditional jumps in the order of the code.
    pub branches: Vec<BranchCoverage>,
}

/// A statement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StatementCoverage {
    /// Place of the source file.
    pub file: u16,
    /// Line, from 1.
    pub line: u32,
    /// It ran.
    pub executed: bool,
}

/// A conditional jump.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BranchCoverage {
    /// Place of the source file.
    pub file: u16,
    /// Line, from 1.
    pub line: u32,
    /// It jumped.
    pub taken: bool,
    /// It did not jump.
    pub passed: bool,
}
