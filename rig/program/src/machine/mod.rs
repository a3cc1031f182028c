//! The machine: memory of a program and the tasks that run in it.

mod adopt;
mod change;
mod debug;
mod force;
mod retain;

pub use change::{ChangeError, ChangeReport};

use crate::host::{Host, MachineSlice, StopReason};
use crate::program::{Program, VarRef};
use crate::run::{MachineParts, PreparedCode, finish_service, run};
use crate::state::{
    Debug, MachineError, NEAR, PinOffsets, READ_ONLY, RETAINED, Scratch, ServiceCall, TaskState, WATCHED,
};
use crate::types::Elementary;
use force::ForcedVariable;
use signal::{Span, Time, Value};
use std::ops::Range;
use std::sync::Arc;

/// Time goes on by what each operation costs.
const AS_MODELLED: i64 = 1;
/// Time stands still while a cycle runs.
const STILL: i64 = 0;

/// A program with its memory. Nothing is allocated by [`Machine::begin`] and [`Machine::resume`].
#[derive(Clone, Debug)]
pub struct Machine {
    program: Arc<Program>,
    prepared: Arc<PreparedCode>,
    natives: Arc<[PinOffsets]>,
    /// The program's memory, then the stacks of the tasks.
    memory: Vec<u8>,
    /// For each byte.
    flags: Vec<u8>,
    dirty: bool,
    tasks: Vec<TaskState>,
    scratch: Scratch,
    debug: Debug,
    forced: Vec<ForcedVariable>,
}

impl Machine {
    /// A machine with all variables at their initial values. `tasks` gives for each task the places in
    /// [`Program::programs`] that it runs in order; a program may be in several.
    ///
    /// # Errors
    /// [`MachineError`].
    pub fn new(program: Arc<Program>, tasks: &[Vec<usize>]) -> Result<Machine, MachineError> {
        let mut end = program.image.len().next_multiple_of(8);
        let mut made = Vec::with_capacity(tasks.len());
        for (task, places) in tasks.iter().enumerate() {
            let unit = |program_place: &usize| {
                let unit = program.programs.get(*program_place).copied();
                unit.ok_or(MachineError::NoSuchProgram { task, program: *program_place })
            };
            let units: Result<Vec<u16>, MachineError> = places.iter().map(unit).collect();
            let task = TaskState::new(&program, units?, end)?;
            end = task.end as usize;
            made.push(task);
        }
        let mut memory = program.image.clone();
        memory.resize(end, 0);
        let mut machine = Machine {
            flags: vec![0; memory.len()],
            memory,
            dirty: false,
            tasks: made,
            scratch: Scratch::new(&program),
            prepared: Arc::new(PreparedCode::new(&program)),
            natives: program.natives.iter().map(|native| PinOffsets::new(native)).collect(),
            debug: Debug::default(),
            forced: Vec::new(),
            program,
        };
        let variables = machine.program.variables_from as usize..machine.program.variables_to as usize;
        machine.flag(0..variables.start, READ_ONLY);
        machine.flag(variables.end..machine.program.image.len(), READ_ONLY);
        let program = Arc::clone(&machine.program);
        for kept in &program.retained {
            let first = kept.address as usize;
            machine.flag(first..first.saturating_add(kept.bytes as usize), RETAINED);
        }
        Ok(machine)
    }

    /// Marks bytes, and those before them from which a store of up to 8 bytes may reach them.
    fn flag(&mut self, range: Range<usize>, flag: u8) {
        let near = range.start.saturating_sub(7)..range.start;
        if range.is_empty() {
            return;
        }
        for (range, flag) in [(range, flag), (near, NEAR)] {
            if let Some(flags) = self.flags.get_mut(range) {
                flags.iter_mut().for_each(|known| *known |= flag);
            }
        }
    }

    /// The program that it runs.
    pub fn program(&self) -> &Arc<Program> {
        &self.program
    }

    /// Starts a cycle of a task from the first operation of its first program. A cycle under way is abandoned.
    pub fn begin(&mut self, task: usize) {
        self.apply_forced();
        if let Some(task) = self.tasks.get_mut(task) {
            task.position = 0;
            task.stopped = false;
            task.asks = None;
            task.enter(&self.program, &mut self.memory);
        }
    }

    /// Runs a task from `now` for at most `budget`.
    ///
    /// Operations are indivisible and take effect when they complete: an operation that does not fit waits for a
    /// later slice. So results and times do not depend on how a cycle is cut into slices. A task without a cycle
    /// under way is [`StopReason::Done`] at once.
    pub fn resume(&mut self, task: usize, now: Time, budget: Span, host: &mut dyn Host) -> MachineSlice {
        self.slice(task, now, (budget, AS_MODELLED), host)
    }

    fn slice(
        &mut self,
        task: usize,
        now: Time,
        (budget, pace): (Span, i64),
        host: &mut dyn Host,
    ) -> MachineSlice {
        let Some(task) = self.tasks.get_mut(task) else {
            return MachineSlice { used: Span::ZERO, stop: StopReason::Done };
        };
        if let Some(ServiceCall { call, service, argument, answer }) = task.asks {
            let nothing = |stop| MachineSlice { used: Span::ZERO, stop };
            let Some(answer) = answer else { return nothing(StopReason::Service { service, argument }) };
            task.asks = None;
            let place = (call, answer);
            let (stop, changed) =
                finish_service(&self.program, &mut self.memory, &self.flags, task, host, place);
            self.dirty |= changed & RETAINED != 0;
            if let Some(stop) = stop {
                return nothing(stop);
            }
        }
        let mut changed = 0;
        let idle = task.idle();
        let debugged = self.debug.active(task);
        let parts = MachineParts {
            program: &self.program,
            prepared: &self.prepared,
            natives: &self.natives,
            memory: &mut self.memory,
            flags: &self.flags,
            scratch: &mut self.scratch,
            debug: &mut self.debug,
            changed: &mut changed,
            pace,
        };
        let slice = if debugged {
            run::<true>(parts, task, now, budget, host)
        } else {
            run::<false>(parts, task, now, budget, host)
        };
        self.dirty |= changed & RETAINED != 0;
        if slice.stop == StopReason::Done && !idle {
            self.apply_forced();
        }
        slice
    }

    /// Runs a whole cycle of a task in no time: all of it happens at `now`, for timers, too. What its operations cost bounds it:
    /// [`StopReason::Budget`] says that it was not complete after `most`, and what is left of it is abandoned by the next one.
    pub fn cycle(&mut self, task: usize, now: Time, most: Span, host: &mut dyn Host) -> StopReason {
        self.begin(task);
        self.slice(task, now, (most, STILL), host).stop
    }

    /// Place of the source file and line, from 1, of the operation that a task executes next.
    pub fn source_line(&self, task: usize) -> Option<(u16, u32)> {
        let pc = self.tasks.get(task)?.registers.pc;
        Some((self.program.file_at(pc), self.program.lines.get(pc as usize).copied()?))
    }

    /// Answers what a task asked for with [`StopReason::Service`]: the result of the call, cut to its type. Nothing happens
    /// where the task waits for none.
    pub fn answer(&mut self, task: usize, result: i64) {
        if let Some(asks) = self.tasks.get_mut(task).and_then(|task| task.asks.as_mut()) {
            asks.answer = Some(result);
        }
    }

    /// Identity of code and variables: [`Program::signature`].
    pub fn signature(&self) -> u64 {
        self.program.signature()
    }

    /// The variable or element of a path: [`Program::resolve`]. Located variables are in the host's memory: see
    /// [`Program::find`].
    pub fn find(&self, path: &str) -> Option<VarRef> {
        self.program.resolve(path)
    }

    /// The value of a variable, TIME in nanoseconds; [`Value::Unknown`] for a reference of another program.
    pub fn read(&self, variable: VarRef) -> Value {
        self.cell(variable).map_or(Value::Unknown, |(ty, cell)| ty.value(cell))
    }

    /// Type and cell of a variable.
    fn cell(&self, variable: VarRef) -> Option<(Elementary, i64)> {
        let ty = variable.ty()?;
        let stored = self.memory.get(variable.bytes()?)?;
        let mut bytes = [0; 8];
        bytes.get_mut(..stored.len())?.copy_from_slice(stored);
        Some((ty, ty.wrap(i64::from_le_bytes(bytes))))
    }

    /// Sets a variable, cut to the width of its type; TIME is given in nanoseconds. FALSE where the value has no number.
    pub fn write(&mut self, variable: VarRef, value: Value) -> bool {
        let cell = variable.ty().and_then(|ty| ty.cell(value));
        cell.is_some_and(|cell| self.set_cell(variable, cell))
    }

    /// Stores a cell into a variable.
    fn set_cell(&mut self, variable: VarRef, cell: i64) -> bool {
        let Some(range) = variable.bytes() else { return false };
        let bytes = cell.to_le_bytes();
        let Some(bytes) = bytes.get(..range.len()) else { return false };
        self.set_bytes(range.start, bytes)
    }

    /// Stores bytes into variables, and minds the retained ones. FALSE outside the variables.
    fn set_bytes(&mut self, at: usize, bytes: &[u8]) -> bool {
        let range = at..at.saturating_add(bytes.len());
        if at < self.program.variables_from as usize || range.end > self.program.variables_to as usize {
            return false;
        }
        let (Some(old), Some(flags)) = (self.memory.get_mut(range.clone()), self.flags.get(range)) else {
            return false;
        };
        let mut pairs = old.iter().zip(bytes).zip(flags);
        self.dirty |= pairs.any(|((old, new), flag)| old != new && flag & RETAINED != 0);
        old.copy_from_slice(bytes);
        true
    }

    /// From now on a change of this variable by the program stops the slice with [`StopReason::Touched`].
    pub fn watch(&mut self, variable: VarRef) {
        if let Some(range) = variable.bytes() {
            self.flag(range, WATCHED);
        }
    }

    /// Ends [`Machine::watch`].
    pub fn unwatch(&mut self, variable: VarRef) {
        // The bytes before stay NEAR, which costs a look and changes nothing.
        if let Some(flags) = variable.bytes().and_then(|range| self.flags.get_mut(range)) {
            flags.iter_mut().for_each(|flags| *flags &= !WATCHED);
        }
    }

    /// The machine's own memory, for showing variables.
    pub(crate) fn memory(&self) -> &[u8] {
        &self.memory
    }

    /// Stores what was written as a literal; FALSE outside the variables.
    pub(crate) fn set_variable(&mut self, address: u32, bytes: &[u8]) -> bool {
        self.set_bytes(address as usize, bytes)
    }
}
