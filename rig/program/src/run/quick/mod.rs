//! The loop for the plain case: operations in the machine's own memory that nobody watches, calls, native blocks. What
//! is anything else - a fault, the host's areas, a watched byte, a text, a budget that is too short - is left to the
//! loop of [`super::run`], with everything as it is before that step. So this loop decides how fast operations are, and
//! never what they do.
//!
//! Time is taken at once for a run of operations up to the next jump. What was not executed is given back at the end.

mod call;
mod constant;
mod element;
mod fold;
mod go;
mod lookup;
mod pair;
mod steps;

use super::fast::{FastIndex, OperandBase};
use crate::code::Op;
use crate::program::Program;
use crate::state::{PinOffsets, TaskState};
use call::CalleeUnit;
pub(super) use fold::fold;
use lookup::Lookup;
use signal::Time;

/// One operation or several, of which all happens or nothing.
#[derive(Clone, Copy, Debug)]
struct QuickStep {
    op: Op,
    /// The bases of `a`, `b`, `c`, and of `d` or the array.
    from: [OperandBase; 4],
    /// Two bits for each of `a`, `b`, `c`: [`DIRECT`], [`INDIRECT`] or [`LOOKUP`]; or [`PLAIN`] or [`BASED`].
    modes: u8,
    /// The index of the element has 16 bits and not 32.
    narrow: bool,
    /// Places; for jumps, `a` is a place in the steps.
    a: u32,
    b: u32,
    c: u32,
    /// With an element, what makes its place of the index: see [`Lookup::add`].
    d: u32,
    /// The place of the last element.
    last: u32,
    /// The array.
    of: u32,
    /// Of all operations from this one to the next jump, with it.
    cost: u32,
}

/// The operand stands where its offset leads.
const DIRECT: u8 = 0;
/// Its address stands there.
const INDIRECT: u8 = 1;
/// It is an element: the field is a place in the lookups.
const LOOKUP: u8 = 2;

/// All operands stand where their offsets from 0 lead.
const PLAIN: u8 = 0;
/// All operands stand where their offsets lead, some from another base.
const BASED: u8 = 1 << 7;

/// No step begins at the operation.
const NONE: u32 = u32::MAX;

/// The code as this loop takes it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Quick {
    steps: Vec<QuickStep>,
    /// Beside the steps: the first operation of each.
    origins: Vec<u32>,
    /// By operation: the step that begins there, if it is worth going on there with this loop.
    entries: Vec<u32>,
    /// By operation: the step that begins there.
    positions: Vec<u32>,
    lookups: Vec<Lookup>,
    indexes: Vec<FastIndex>,
    callees: Vec<CalleeUnit>,
}

/// What the loop works on.
pub(super) struct QuickContext<'a> {
    pub program: &'a Program,
    pub memory: &'a mut [u8],
    pub flags: &'a [u8],
    /// Beside the program's native blocks.
    pub pins: &'a [PinOffsets],
    pub task: &'a mut TaskState,
    /// When the slice began, and its budget in nanoseconds.
    pub now: Time,
    pub budget: i64,
    /// Nanoseconds that pass for each nanosecond of cost: 1 or 0.
    pub pace: i64,
}

/// Where a task stands.
#[derive(Clone, Copy)]
pub(super) struct QuickPlace {
    /// The operation that comes next.
    pub pc: usize,
    /// Time that is left, in nanoseconds.
    pub left: i64,
    /// By `From`.
    pub bases: [u32; 3],
    pub unit: u16,
}

impl Quick {
    /// The step at which it is worth going on with this loop.
    #[inline(always)]
    pub fn entry(&self, pc: usize) -> Option<u32> {
        self.entries.get(pc).copied().filter(|entry| *entry != NONE)
    }

    /// Where a task stands that goes on with a step, if nothing of it ran though its time is taken.
    #[cold]
    #[inline(never)]
    fn before(&self, position: usize, place: QuickPlace) -> QuickPlace {
        let cost = self.steps.get(position).map_or(0, |step| i64::from(step.cost));
        let pc = self.origins.get(position).map_or(NONE as usize, |pc| *pc as usize);
        QuickPlace { pc, left: place.left + cost, ..place }
    }
}
