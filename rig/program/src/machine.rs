//! The machine: memory of a program and the tasks that run in it.

use crate::code::Need;
use crate::program::{Program, Retention, VarRef};
use crate::run::run;
use signal::{Address, Span, Time, Value};
use std::fmt;
use std::sync::Arc;

/// A cell that somebody watches.
pub(crate) const WATCHED: u8 = 1;
/// A cell that belongs to the retained image.
pub(crate) const RETAINED: u8 = 2;

/// Operands that fit; the place on this stack is a byte.
pub(crate) const OPERANDS: usize = 256;

/// The images and the mapped memory, as the program sees them.
pub trait Host {
    /// The bits at a place, in the low bits.
    fn load(&mut self, at: Address) -> u64;

    /// Stores the low bits of `value`. `file` and `line` (from 1) are the place in the source. TRUE where a
    /// watched location changed: the machine stops right after the operation with [`Stop::Touched`].
    fn store(&mut self, at: Address, value: u64, file: u8, line: u32) -> bool;
}

/// What a task did in one slice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Slice {
    /// Modelled time that was used, never more than the budget.
    pub used: Span,
    /// Why it stopped.
    pub stop: Stop,
}

/// Why a slice ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stop {
    /// The next operation takes `next`, more than what is left. Nothing of it has happened.
    Budget {
        /// Modelled time of the next operation.
        next: Span,
    },
    /// The cycle is complete.
    Done,
    /// A watched variable or location changed at the end of the slice.
    Touched,
    /// The cycle was abandoned.
    Fault(Fault),
}

/// What no program can go on from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fault {
    /// What happened.
    pub kind: FaultKind,
    /// Place of the source file.
    pub file: u8,
    /// Line, from 1.
    pub line: u32,
}

/// Kinds of faults.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum FaultKind {
    /// `/` or MOD by 0.
    DivisionByZero,
    /// An index outside the bounds of its array.
    Bounds,
    /// The code asked for what the compiler never emits: a defect of the rig.
    Internal,
}

impl fmt::Display for FaultKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            FaultKind::DivisionByZero => "division by zero",
            FaultKind::Bounds => "index outside the bounds of the array",
            FaultKind::Internal => "internal fault of the compiler",
        })
    }
}

/// Why a machine cannot be made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MachineError {
    /// A task names a program by a place that [`Program::programs`] does not have.
    NoSuchProgram {
        /// Place of the task.
        task: usize,
        /// The place asked for.
        program: usize,
    },
}

impl fmt::Display for MachineError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            MachineError::NoSuchProgram { task, program } => {
                write!(f, "task {task} calls program {program}, which the application does not have")
            }
        }
    }
}

impl std::error::Error for MachineError {}

/// Registers that survive a slice.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Registers {
    pub pc: u32,
    /// First cell of the running block's instance.
    pub this: u32,
    /// First cell of the running unit's frame.
    pub base: u32,
    pub unit: u16,
    /// Operands below the accumulator.
    pub sp: u8,
    pub acc: i64,
}

/// A task between two slices.
#[derive(Clone, Debug)]
pub(crate) struct Task {
    /// Units of its programs, in order.
    pub programs: Vec<u16>,
    /// The program that runs; beyond the end the task is idle.
    pub position: usize,
    pub registers: Registers,
    /// Callers, innermost last.
    pub callers: Vec<Registers>,
    /// Frames of all active units.
    pub frames: Vec<i64>,
    pub operands: Box<[i64; OPERANDS]>,
}

impl Task {
    fn new(program: &Program, programs: Vec<u16>) -> Self {
        let needs =
            programs.iter().filter_map(|unit| program.units.get(usize::from(*unit))).map(|unit| unit.need);
        let need = needs.fold(Need::default(), |all, need| Need {
            operands: all.operands.max(need.operands),
            frame: all.frame.max(need.frame),
            calls: all.calls.max(need.calls),
        });
        Task {
            position: programs.len(),
            programs,
            registers: Registers::default(),
            callers: Vec::with_capacity(need.calls as usize + 1),
            frames: vec![0; need.frame as usize + 1],
            operands: Box::new([0; OPERANDS]),
        }
    }

    /// Starts the program at `position`, if there is one.
    pub(crate) fn enter(&mut self, program: &Program) -> bool {
        let unit = self.programs.get(self.position).copied().unwrap_or(0);
        let entry = program.units.get(usize::from(unit)).map_or(0, |unit| unit.entry);
        self.registers = Registers { pc: entry, unit, ..Registers::default() };
        self.callers.clear();
        self.position < self.programs.len()
    }
}

/// A program with its memory. Nothing is allocated after [`Machine::new`].
#[derive(Clone, Debug)]
pub struct Machine {
    program: Arc<Program>,
    cells: Vec<i64>,
    flags: Vec<u8>,
    dirty: bool,
    tasks: Vec<Task>,
}

impl Machine {
    /// A machine with all variables at their initial values. `tasks` gives for each task the places in
    /// [`Program::programs`] that it runs in order; a program may be in several.
    ///
    /// # Errors
    /// [`MachineError::NoSuchProgram`].
    pub fn new(program: Arc<Program>, tasks: &[Vec<usize>]) -> Result<Machine, MachineError> {
        let mut made = Vec::with_capacity(tasks.len());
        for (task, places) in tasks.iter().enumerate() {
            let units: Result<Vec<u16>, MachineError> = places
                .iter()
                .map(|&place| {
                    program
                        .programs
                        .get(place)
                        .copied()
                        .ok_or(MachineError::NoSuchProgram { task, program: place })
                })
                .collect();
            made.push(Task::new(&program, units?));
        }
        let flags =
            program.retention.iter().map(|r| if *r == Retention::None { 0 } else { RETAINED }).collect();
        Ok(Machine { cells: program.initial.clone(), flags, dirty: false, tasks: made, program })
    }

    /// The program that it runs.
    pub fn program(&self) -> &Arc<Program> {
        &self.program
    }

    /// Starts a cycle of a task from the first operation of its first program. A cycle under way is abandoned.
    pub fn begin(&mut self, task: usize) {
        if let Some(task) = self.tasks.get_mut(task) {
            task.position = 0;
            task.enter(&self.program);
        }
    }

    /// Runs a task from `now` for at most `budget`.
    ///
    /// Operations are indivisible and take effect when they complete: an operation that does not fit waits for a
    /// later slice. So results and times do not depend on how a cycle is cut into slices. A task without a cycle
    /// under way is [`Stop::Done`] at once.
    pub fn resume<H: Host>(&mut self, task: usize, now: Time, budget: Span, host: &mut H) -> Slice {
        let Some(task) = self.tasks.get_mut(task) else {
            return Slice { used: Span::ZERO, stop: Stop::Done };
        };
        let mut changed = 0;
        let slice = run(&self.program, &mut self.cells, &self.flags, task, &mut changed, now, budget, host);
        self.dirty |= changed & RETAINED != 0;
        slice
    }

    /// Abandons all cycles and puts the variables back to their initial values, but for the RETAIN ones
    /// where `keep_retain`, and the PERSISTENT ones where `keep_persistent` (controller:REM-02).
    pub fn reset(&mut self, keep_retain: bool, keep_persistent: bool) {
        for task in &mut self.tasks {
            task.position = task.programs.len();
        }
        let program = &self.program;
        for (cell, (initial, retention)) in
            self.cells.iter_mut().zip(program.initial.iter().zip(&program.retention))
        {
            let keep = match retention {
                Retention::None => false,
                Retention::Retain => keep_retain,
                Retention::Persistent => keep_persistent,
            };
            if !keep {
                self.dirty |= *retention != Retention::None && *cell != *initial;
                *cell = *initial;
            }
        }
    }

    /// Bytes of the retained image, at most 64 Kbytes (controller:MEM-08); 0 where nothing is retained.
    pub fn retained_len(&self) -> usize {
        let bytes: usize = self.retained().map(|(_, ty)| ty.bytes()).sum();
        if bytes == 0 { 0 } else { bytes + self.program.layout.len() }
    }

    fn retained(&self) -> impl Iterator<Item = (usize, crate::Elementary)> + '_ {
        let of = self.program.retention.iter().zip(&self.program.types).enumerate();
        of.filter(|(_, (retention, _))| **retention != Retention::None).map(|(cell, (_, ty))| (cell, *ty))
    }

    /// Writes the retained variables into the first [`Machine::retained_len`] bytes of `out`: names and types as a hash of
    /// 8 bytes, then the values, little-endian. FALSE where `out` is too short, and then nothing is written.
    pub fn save_retained(&self, out: &mut [u8]) -> bool {
        let length = self.retained_len();
        let Some(out) = out.get_mut(..length) else { return false };
        if length == 0 {
            return true;
        }
        let (head, mut rest) = out.split_at_mut(self.program.layout.len());
        head.copy_from_slice(&self.program.layout);
        for (cell, ty) in self.retained() {
            let (place, after) = rest.split_at_mut(ty.bytes());
            place.copy_from_slice(&self.cells[cell].to_le_bytes()[..ty.bytes()]);
            rest = after;
        }
        true
    }

    /// Takes the retained variables from an image that [`Machine::save_retained`] wrote. FALSE, and nothing changed, where the
    /// image is not of these variables in name, type and number (controller:REM-06).
    pub fn restore_retained(&mut self, image: &[u8]) -> bool {
        let length = self.retained_len();
        if image.len() != length {
            return false;
        }
        if length == 0 {
            return true;
        }
        let (head, mut rest) = image.split_at(self.program.layout.len());
        if head != self.program.layout {
            return false;
        }
        let program = Arc::clone(&self.program);
        for (cell, (retention, ty)) in program.retention.iter().zip(&program.types).enumerate() {
            if *retention == Retention::None {
                continue;
            }
            let (place, after) = rest.split_at(ty.bytes());
            let mut bytes = [0; 8];
            bytes[..ty.bytes()].copy_from_slice(place);
            self.cells[cell] = ty.wrap(i64::from_le_bytes(bytes));
            rest = after;
        }
        true
    }

    /// Whether a retained variable changed since the last call of this.
    pub fn retained_dirty(&mut self) -> bool {
        std::mem::take(&mut self.dirty)
    }

    /// Identity of code and variables: [`Program::signature`].
    pub fn signature(&self) -> u64 {
        self.program.signature()
    }

    /// The variable or element of a path: [`Program::resolve`]. Located variables are in the host's memory: see [`Program::find`].
    pub fn find(&self, path: &str) -> Option<VarRef> {
        self.program.resolve(path)
    }

    /// The value of a variable, TIME in nanoseconds; [`Value::Unknown`] for a reference of another program.
    pub fn read(&self, variable: VarRef) -> Value {
        let at = variable.0 as usize;
        match (self.program.types.get(at), self.cells.get(at)) {
            (Some(ty), Some(cell)) => ty.value(*cell),
            _ => Value::Unknown,
        }
    }

    /// Sets a variable, cut to the width of its type; TIME is given in nanoseconds. FALSE where the value has no number.
    pub fn write(&mut self, variable: VarRef, value: Value) -> bool {
        let at = variable.0 as usize;
        let cell = self.program.types.get(at).and_then(|ty| ty.cell(value));
        let (Some(new), Some(old), Some(flags)) = (cell, self.cells.get_mut(at), self.flags.get(at)) else {
            return false;
        };
        self.dirty |= *old != new && flags & RETAINED != 0;
        *old = new;
        true
    }

    /// From now on a change of this variable by the program stops the slice with [`Stop::Touched`].
    pub fn watch(&mut self, variable: VarRef) {
        if let Some(flags) = self.flags.get_mut(variable.0 as usize) {
            *flags |= WATCHED;
        }
    }

    /// Ends [`Machine::watch`].
    pub fn unwatch(&mut self, variable: VarRef) {
        if let Some(flags) = self.flags.get_mut(variable.0 as usize) {
            *flags &= !WATCHED;
        }
    }
}
