//! The way back from a service: what the caller answered goes where the call stands in its expression.

use super::place;
use super::world::{By, ProgramMemory, Stored};
use crate::code::LibraryArgument;
use crate::host::{Host, ProgramFault, ProgramFaultKind, StopReason};
use crate::program::Program;
use crate::state::TaskState;

/// Stores the answer to the service that a task waits for; the operation was complete when it was asked. Gives why
/// the task does not go on at once, and the flags of the bytes that changed.
pub(crate) fn finish_service(
    program: &Program,
    memory: &mut [u8],
    flags: &[u8],
    task: &mut TaskState,
    host: &mut dyn Host,
    (call, answer): (u32, i64),
) -> (Option<StopReason>, u8) {
    let registers = task.registers;
    let by = By { pc: (registers.pc as usize).saturating_sub(1), unit: registers.unit };
    let mut world = ProgramMemory { program, flags, host, changed: 0 };
    let stored = match program.library.get(call as usize).map(|call| &call.result) {
        Some(LibraryArgument::Cell(operand, ty)) => {
            place(memory, [0, registers.this, registers.base], *operand).map_or(Stored::Bad, |at| {
                world.store(memory, at, ty.bytes() as u32, ty.wrap(answer) as u64, by)
            })
        }
        _ => Stored::Bad,
    };
    let stop = match stored {
        Stored::Fine => None,
        Stored::Touched => {
            let (file, line) = program.source_of(by.unit, by.pc);
            Some(StopReason::Touched { file, line })
        }
        Stored::Bad => {
            task.position = task.programs.len();
            let (file, line) = program.source_of(by.unit, by.pc);
            Some(StopReason::Fault(ProgramFault { kind: ProgramFaultKind::ReservedWrite, file, line }))
        }
    };
    (stop, world.changed)
}
