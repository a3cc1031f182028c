//! Tasks: programs in order, a stack, and where they stand between two slices.

use super::MachineError;
use crate::code::{CodeUnit, map};
use crate::library::Service;
use crate::program::Program;

/// Stack of a task whose programs call in circles, in bytes and calls.
const CIRCLE_BYTES: usize = 64 << 10;
const CIRCLE_CALLS: usize = 1000;

/// Registers that survive a slice.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct TaskRegisters {
    pub pc: u32,
    /// Address of the running unit's instance.
    pub this: u32,
    /// Address of the running unit's frame.
    pub base: u32,
    pub unit: u16,
}

/// A service that a task waits for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ServiceCall {
    /// The call's entry in `Program::library`.
    pub call: u32,
    pub service: Service,
    pub argument: i64,
    pub answer: Option<i64>,
}

/// A task between two slices.
#[derive(Clone, Debug)]
pub(crate) struct TaskState {
    /// Units of its programs, in order.
    pub programs: Vec<u16>,
    /// The program that runs; beyond the end the task is idle.
    pub position: usize,
    pub registers: TaskRegisters,
    /// Callers, innermost last: never more than `depth`, for which there is room.
    pub callers: Vec<TaskRegisters>,
    pub depth: usize,
    /// The stack in the machine's memory.
    pub start: u32,
    pub end: u32,
    /// It has stopped before the next statement already, and goes on with it.
    pub stopped: bool,
    /// It stops before the next statement.
    pub stepping: bool,
    /// It has asked the caller of the machine for something.
    pub asks: Option<ServiceCall>,
}

impl TaskState {
    /// A task whose stack starts at `start`.
    pub fn new(program: &Program, programs: Vec<u16>, start: usize) -> Result<TaskState, MachineError> {
        let needs = needs(&program.units);
        let (mut bytes, mut calls) = (0, 0);
        for unit in &programs {
            let frame = program.units.get(usize::from(*unit)).map_or(0, |unit| unit.frame as usize);
            let need = needs.get(usize::from(*unit)).copied().flatten();
            let (need_bytes, need_calls) = need.unwrap_or((CIRCLE_BYTES.max(frame), CIRCLE_CALLS));
            bytes = need_bytes.max(bytes);
            calls = need_calls.max(calls);
        }
        let end = start.saturating_add(bytes).saturating_add(8).next_multiple_of(8);
        if end > map::OWN_END as usize {
            return Err(MachineError::Memory { bytes: end });
        }
        Ok(TaskState {
            position: programs.len(),
            programs,
            registers: TaskRegisters::default(),
            callers: Vec::with_capacity(calls),
            depth: calls,
            start: start as u32,
            end: end as u32,
            stopped: false,
            stepping: false,
            asks: None,
        })
    }

    /// Whether no cycle is under way.
    pub fn idle(&self) -> bool {
        self.position >= self.programs.len()
    }

    /// Starts the program at `position`, if there is one.
    pub fn enter(&mut self, program: &Program, memory: &mut [u8]) -> bool {
        self.callers.clear();
        let Some(place) = self.programs.get(self.position) else { return false };
        let Some(unit) = program.units.get(usize::from(*place)) else { return false };
        self.registers = TaskRegisters { pc: unit.entry, this: 0, base: self.start, unit: *place };
        let start = self.start as usize;
        if let Some(frame) = memory.get_mut(start..start + unit.template.len()) {
            frame.copy_from_slice(&unit.template);
        }
        true
    }
}

/// Bytes of frames and calls that each unit needs with all that it calls; `None` for what calls in circles.
fn needs(units: &[CodeUnit]) -> Vec<Option<(usize, usize)>> {
    let mut needs: Vec<Option<(usize, usize)>> = vec![None; units.len()];
    let mut waiting: Vec<usize> = vec![0; units.len()];
    let mut callers: Vec<Vec<usize>> = vec![Vec::new(); units.len()];
    for (caller, unit) in units.iter().enumerate() {
        for callee in &unit.calls {
            if let (Some(callers), Some(waiting)) =
                (callers.get_mut(usize::from(*callee)), waiting.get_mut(caller))
            {
                callers.push(caller);
                *waiting += 1;
            }
        }
    }
    let mut ready: Vec<usize> = (0..units.len()).filter(|unit| waiting.get(*unit) == Some(&0)).collect();
    while let Some(place) = ready.pop() {
        let Some(unit) = units.get(place) else { continue };
        let (mut bytes, mut calls) = (0, 0);
        for callee in &unit.calls {
            let (inner_bytes, inner_calls) =
                needs.get(usize::from(*callee)).copied().flatten().unwrap_or_default();
            bytes = inner_bytes.max(bytes);
            calls = (inner_calls + 1).max(calls);
        }
        let frame = (unit.frame as usize).max(unit.template.len());
        if let Some(need) = needs.get_mut(place) {
            *need = Some((bytes.saturating_add(frame), calls));
        }
        for caller in callers.get(place).into_iter().flatten() {
            if let Some(count) = waiting.get_mut(*caller) {
                *count -= 1;
                if *count == 0 {
                    ready.push(*caller);
                }
            }
        }
    }
    needs
}
