//! What a machine and its host say to each other: the host's memory, and how a slice ended.

use crate::library::Service;
use crate::native::Pins;
use signal::{Address, Span};
use std::fmt;

/// The images and the mapped memory, as the program sees them.
pub trait Host {
    /// The bits at a place, in the low bits.
    fn load(&mut self, at: Address) -> u64;

    /// Stores the low bits of `value`. `file` and `line` (from 1) are the place in the source. TRUE where a
    /// watched location changed: the machine stops right after the operation with [`StopReason::Touched`].
    fn store(&mut self, at: Address, value: u64, file: u16, line: u32) -> bool;

    /// A call of the block with this number, whose body is the host's ([`crate::BlockBody::Host`]). TRUE where the
    /// host wants to see to what came of it: the machine stops right after the call with [`StopReason::Touched`].
    fn block(&mut self, _block: u16, _pins: &mut Pins<'_>) -> bool {
        false
    }
}

/// What a task did in one slice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MachineSlice {
    /// Modelled time that was used, never more than the budget.
    pub used: Span,
    /// Why it stopped.
    pub stop: StopReason,
}

/// Why a slice ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopReason {
    /// The next operation takes `next`, more than what is left. Nothing of it has happened.
    Budget {
        /// Modelled time of the next operation.
        next: Span,
    },
    /// The cycle is complete.
    Done,
    /// A watched variable or location changed at the end of the slice.
    Touched {
        /// Source file of the operation, by its place.
        file: u16,
        /// Line in that file, from 1.
        line: u32,
    },
    /// A statement with a breakpoint comes next, or the next one after [`crate::Machine::step`]. The cycle goes on with
    /// the next slice.
    Break,
    /// The program asks for something, the operation that does so being complete at the end of the slice. The cycle
    /// goes on with the next slice after [`crate::Machine::answer`]; without an answer it asks again.
    Service {
        /// What it asks for.
        service: Service,
        /// The first argument; 0 where there is none.
        argument: i64,
    },
    /// The cycle was abandoned.
    Fault(ProgramFault),
}

/// What no program can go on from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ProgramFault {
    /// What happened.
    pub kind: ProgramFaultKind,
    /// Place of the source file.
    pub file: u16,
    /// Line, from 1.
    pub line: u32,
}

/// Kinds of faults.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ProgramFaultKind {
    /// `/` or MOD of whole numbers by 0.
    DivisionByZero,
    /// `/` of REAL or LREAL by 0.0 or -0.0, whatever is divided.
    RealDivisionByZero,
    /// An index outside the bounds of its array.
    Bounds,
    /// A pointer, reference or interface that leads nowhere, where it is read or called.
    BadReference,
    /// A store through a pointer or reference that leads nowhere, or to what may not be written.
    ReservedWrite,
    /// Calls that need more room than the task's stack has.
    StackDepth,
    /// The code asked for what the compiler never emits: a defect of the rig.
    Internal,
}

impl fmt::Display for ProgramFaultKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            ProgramFaultKind::DivisionByZero => "division by zero",
            ProgramFaultKind::RealDivisionByZero => "real division by zero",
            ProgramFaultKind::Bounds => "index outside the bounds of the array",
            ProgramFaultKind::BadReference => "reference to no variable",
            ProgramFaultKind::ReservedWrite => "write to reserved memory",
            ProgramFaultKind::StackDepth => "calls nested too deep",
            ProgramFaultKind::Internal => "internal fault of the compiler",
        })
    }
}
