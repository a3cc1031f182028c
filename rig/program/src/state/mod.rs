//! What a machine keeps between two slices, and the interpreter works on: tasks, flags of bytes, marks on the code.

mod debug;
mod task;

pub(crate) use debug::Debug;
pub use debug::{BranchCoverage, Coverage, StatementCoverage};
pub(crate) use task::{ServiceCall, TaskRegisters, TaskState};

use crate::code::{LibraryArgument, map};
use crate::native::Native;
use crate::program::Program;
use std::fmt;

/// A byte of a variable that somebody watches.
pub(crate) const WATCHED: u8 = 1;
/// A byte that belongs to the retained image.
pub(crate) const RETAINED: u8 = 2;
/// A byte that is not written.
pub(crate) const READ_ONLY: u8 = 4;
/// A byte that is nothing of the above itself, but a store that starts here may reach one that is.
pub(crate) const NEAR: u8 = 8;

/// Why a machine cannot be made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MachineError {
    /// A task names a program by a place that [`crate::Program::programs`] does not have.
    NoSuchProgram {
        /// Place of the task.
        task: usize,
        /// The place asked for.
        program: usize,
    },
    /// Variables and stacks are more than what a machine addresses.
    Memory {
        /// Bytes needed.
        bytes: usize,
    },
}

impl fmt::Display for MachineError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            MachineError::NoSuchProgram { task, program } => {
                write!(f, "task {task} calls program {program}, which the application does not have")
            }
            MachineError::Memory { bytes } => {
                write!(f, "variables and stacks need {bytes} bytes, and there are {}", map::OWN_END)
            }
        }
    }
}

impl std::error::Error for MachineError {}

/// Where the pins of a native block lie in an instance.
#[derive(Clone, Debug)]
pub(crate) struct PinOffsets {
    pub offsets: Vec<u16>,
    pub bytes: u32,
}

impl PinOffsets {
    pub fn new(native: &Native) -> PinOffsets {
        let (offsets, bytes) = native.layout();
        PinOffsets { offsets, bytes }
    }
}

/// Room for the arguments of the library, sized once.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scratch {
    pub bytes: Vec<u8>,
    pub cells: Vec<i64>,
}

impl Scratch {
    pub fn new(program: &Program) -> Scratch {
        let (mut bytes, mut cells) = (0, 0);
        for call in &program.library {
            let all = call.arguments.iter().chain([&call.result]);
            let texts = all.map(|argument| match argument {
                LibraryArgument::Text(text) => text.bytes as usize,
                LibraryArgument::Cell(..) => 0,
            });
            bytes = texts.sum::<usize>().max(bytes);
            cells = call.arguments.len().max(cells);
        }
        Scratch { bytes: vec![0; bytes], cells: vec![0; cells] }
    }
}
