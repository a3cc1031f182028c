//! Calls in the quick loop. `None` or FALSE is for what the other loop looks at; nothing has happened then.
//!
//! They are kept out of the loop: with them in it, all other steps take a tenth longer.

use super::{NONE, Quick, QuickContext};
use crate::native::{BlockBody, Pins};
use crate::program::Program;
use crate::state::{PinOffsets, TaskRegisters, TaskState};
use signal::{Span, Time};

/// A unit that can be called.
#[derive(Clone, Debug)]
pub(super) struct CalleeUnit {
    /// The step at which it begins.
    pub entry: u32,
    /// Bytes of its frame.
    pub frame: u32,
}

/// What calls work on, besides the memory.
pub(super) struct Calls<'a> {
    program: &'a Program,
    pins: &'a [PinOffsets],
    task: &'a mut TaskState,
    now: Time,
    budget: i64,
    pace: i64,
    /// By `From`.
    pub bases: [u32; 3],
    pub unit: u16,
}

impl<'a> Calls<'a> {
    /// With the memory and its flags, which are as many.
    pub fn new(
        around: QuickContext<'a>,
        bases: [u32; 3],
        unit: u16,
    ) -> Option<(Calls<'a>, &'a mut [u8], &'a [u8])> {
        let QuickContext { program, memory, flags, pins, task, now, budget, pace } = around;
        let flags = flags.get(..memory.len())?;
        Some((Calls { program, pins, task, now, budget, pace, bases, unit }, memory, flags))
    }
}

impl Quick {
    /// The frame of a unit after the running one.
    #[inline(always)]
    fn room(&self, calls: &Calls<'_>, unit: u32) -> Option<(&CalleeUnit, u32)> {
        let (callee, caller) = (self.callees.get(unit as usize)?, self.callees.get(usize::from(calls.unit))?);
        let next = calls.bases[2].saturating_add(caller.frame);
        let fits = next.saturating_add(callee.frame) <= calls.task.end;
        (fits && calls.task.callers.len() < calls.task.depth).then_some((callee, next))
    }

    /// Prepares the frame of a unit.
    #[inline(never)]
    pub(super) fn frame(&self, calls: &Calls<'_>, memory: &mut [u8], unit: u32) -> bool {
        let Some((_, next)) = self.room(calls, unit) else { return false };
        let template = calls.program.units.get(unit as usize).map_or(&[][..], |unit| &unit.template);
        match memory.get_mut(next as usize..next as usize + template.len()) {
            Some(frame) => {
                frame.copy_from_slice(template);
                true
            }
            None => false,
        }
    }

    /// Calls a unit that returns to the operation `back`: the step at which it begins.
    #[inline(never)]
    pub(super) fn call(&self, calls: &mut Calls<'_>, unit: u32, this: u32, back: u32) -> Option<u32> {
        let (callee, next) = self.room(calls, unit)?;
        let entry = Some(callee.entry).filter(|entry| *entry != NONE)?;
        let [_, old, base] = calls.bases;
        calls.task.callers.push(TaskRegisters { pc: back, this: old, base, unit: calls.unit });
        calls.bases = [0, this, next];
        calls.unit = unit as u16;
        Some(entry)
    }

    /// Goes back to the caller: the step that comes next there.
    #[inline(never)]
    pub(super) fn back(&self, calls: &mut Calls<'_>) -> Option<u32> {
        let TaskRegisters { pc, this, base, unit } = *calls.task.callers.last()?;
        let to = self.positions.get(pc as usize).copied().filter(|to| *to != NONE)?;
        calls.task.callers.pop();
        calls.bases = [0, this, base];
        calls.unit = unit;
        Some(to)
    }

    /// Calls a native block with the instance at a place, none of whose bytes has a flag.
    #[inline(always)]
    pub(super) fn native(
        &self,
        calls: &Calls<'_>,
        (memory, flags): (&mut [u8], &[u8]),
        (native, at): (u32, usize),
        left: i64,
    ) -> bool {
        let (Some(native), Some(pins)) =
            (calls.program.natives.get(native as usize), calls.pins.get(native as usize))
        else {
            return false;
        };
        let BlockBody::Own(run) = native.body else { return false };
        let range = at..at + pins.bytes as usize;
        let (Some(bytes), Some(flags)) = (memory.get_mut(range.clone()), flags.get(range)) else {
            return false;
        };
        // An instance is a number of whole words.
        if flags.chunks_exact(8).any(|flags| flags != [0; 8]) {
            return false;
        }
        let now = calls.now.saturating_add(Span::from_nanos((calls.budget - left) * calls.pace));
        run(&mut Pins::new(bytes, native.pins, &pins.offsets, &[], now));
        true
    }

    /// As [`Quick::native`], where that is seldom.
    #[inline(never)]
    pub(super) fn native_aside(
        &self,
        calls: &Calls<'_>,
        places: (&mut [u8], &[u8]),
        block: (u32, usize),
        left: i64,
    ) -> bool {
        self.native(calls, places, block, left)
    }
}
