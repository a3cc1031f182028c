//! Makes the steps of the quick loop: elements are found by the operation that uses them.

use super::super::fast::{FastIndex, FastStep, OperandBase};
use super::constant::{constant, with_constant};
use super::element::{address, element};
use super::lookup::{IndexType, Lookup};
use super::pair::pair;
use super::{BASED, CalleeUnit, DIRECT, INDIRECT, LOOKUP, NONE, PLAIN, Quick, QuickStep};
use crate::code::{Op, map};
use crate::program::Program;

/// Operations whose time is taken at once, at most: a budget that is shorter than that goes the slow way.
const RUN: usize = 32;
/// Steps that the quick loop is worth going over to for.
const WORTH: usize = 5;
/// Operations that are looked through for the next use of a temporary.
const FAR: usize = 200;

struct Folder<'a> {
    code: &'a [FastStep],
    indexes: &'a [FastIndex],
    program: &'a Program,
    /// By operation: jumps lead here.
    reached: Vec<bool>,
    /// By operation: a unit begins here.
    starts: Vec<bool>,
    quick: Quick,
}

/// A lookup and the operations that it stands for.
pub(super) struct FoldedLoop {
    pub lookup: Lookup,
    /// Where the element's address goes in the frame.
    pub slot: u32,
    /// Where the sum goes that is the index, if there is one.
    sum: Option<u32>,
    length: usize,
}

pub(in super::super) fn fold(code: &[FastStep], indexes: &[FastIndex], program: &Program) -> Quick {
    let mut reached = vec![false; code.len()];
    for step in code.iter().filter(|step| step.op == Op::Jump || step.op.branches()) {
        if let Some(reached) = reached.get_mut(step.a as usize) {
            *reached = true;
        }
    }
    let mut starts = vec![false; code.len()];
    for unit in &program.units {
        for marks in [&mut reached, &mut starts] {
            if let Some(mark) = marks.get_mut(unit.entry as usize) {
                *mark = true;
            }
        }
    }
    let quick = Quick { indexes: indexes.to_vec(), ..Quick::default() };
    Folder { code, indexes, program, reached, starts, quick }.fold()
}

impl Folder<'_> {
    fn fold(mut self) -> Quick {
        let (mut pc, mut length, mut sum) = (0, 0, 0u32);
        let mut positions = vec![NONE; self.code.len()];
        while let Some(plain) = self.code.get(pc) {
            let (step, count) = self.step(pc, plain);
            let total = sum.checked_add(step.cost).filter(|_| length < RUN);
            if total.is_none() {
                self.pause(pc);
                (length, sum) = (0, 0);
            }
            if let Some(position) = positions.get_mut(pc) {
                *position = self.quick.steps.len() as u32;
            }
            self.push(step, pc);
            (length, sum) = if ends(step.op) { (0, 0) } else { (length + 1, sum.saturating_add(step.cost)) };
            pc += count;
        }
        // So that there is a step after each.
        self.push(leave(), pc);
        renumber_jumps(&mut self.quick.steps, &positions);
        self.quick.entries = self.entries(&positions);
        let at = |pc: u32| positions.get(pc as usize).copied().unwrap_or(NONE);
        let callees =
            self.program.units.iter().map(|unit| CalleeUnit { entry: at(unit.entry), frame: unit.frame });
        self.quick.callees = callees.collect();
        self.quick.positions = positions;
        self.quick
    }

    fn push(&mut self, mut step: QuickStep, pc: usize) {
        if step.modes == DIRECT {
            let calls = is_call(step.op)
                || matches!(step.op, Op::Frame | Op::CallThrough | Op::CallNative | Op::Return);
            step.modes = if step.from == [OperandBase::Zero; 4] && !calls { PLAIN } else { BASED };
        }
        self.quick.steps.push(step);
        self.quick.origins.push(pc as u32);
    }

    /// Where it is worth going over to the quick loop: not just before an operation that it leaves.
    fn entries(&self, positions: &[u32]) -> Vec<u32> {
        let Quick { steps, origins, .. } = &self.quick;
        let mut entries = vec![NONE; self.code.len()];
        let mut ahead = 0;
        for (position, (step, pc)) in steps.iter().zip(origins).enumerate().rev() {
            let stays = is_quick(step.op) && !self.code.get(*pc as usize).is_some_and(is_foreign);
            ahead = if stays { ahead + 1 } else { 0 };
            if ahead >= WORTH
                && positions.get(*pc as usize) == Some(&(position as u32))
                && let Some(entry) = entries.get_mut(*pc as usize)
            {
                *entry = position as u32;
            }
        }
        entries
    }

    /// A jump to the next operation, where the time of the following ones is taken.
    fn pause(&mut self, pc: usize) {
        let jump = FastStep {
            op: Op::Jump,
            from: [OperandBase::Zero; 3],
            indirect: 0,
            a: pc as u32,
            b: 0,
            c: 0,
            cost: 0,
        };
        let step = self.simple(pc, &jump).0;
        self.push(step, pc);
    }

    /// The longest step that begins at an operation, and of how many operations it is.
    fn step(&mut self, pc: usize, plain: &FastStep) -> (QuickStep, usize) {
        if let Some(step) = self.pair(pc, plain) {
            return (step, 2);
        }
        let mut lookups: Vec<FoldedLoop> = Vec::new();
        let mut after = pc;
        while lookups.len() < 3
            && let Some(found) = self.lookup(after)
        {
            after += found.length;
            lookups.push(found);
        }
        while !lookups.is_empty() {
            if let Some(step) = self.folded(pc, after, &lookups) {
                return (step, after - pc + 1);
            }
            after -= lookups.pop().map_or(0, |found| found.length);
        }
        match self.plain_lookup(plain).and_then(|found| address(plain, &found)) {
            Some(step) => (QuickStep { cost: plain.cost, ..step }, 1),
            None => (self.simple(pc, plain).0, 1),
        }
    }

    /// The operation and the next one, if they are one step.
    fn pair(&self, pc: usize, plain: &FastStep) -> Option<QuickStep> {
        let next = self.code.get(pc + 1).filter(|_| self.reached.get(pc + 1) == Some(&false))?;
        let (step, temporary) = pair(self.program, plain, next)?;
        let cost = plain.cost.checked_add(next.cost)?;
        let idle = |offset| self.is_dead(pc + 2, offset);
        temporary.is_none_or(idle).then_some(QuickStep { cost, ..step })
    }

    /// The lookup that begins at an operation.
    fn lookup(&self, pc: usize) -> Option<FoldedLoop> {
        let first = self.code.get(pc)?;
        let (width, ty) = match first.op {
            Op::Add16 | Op::Sub16 => (2, IndexType::Narrow),
            Op::Add32 | Op::Sub32 => (4, IndexType::Wide),
            _ => return self.plain_lookup(first),
        };
        // A constant is added to the index.
        let add = constant(self.program, first, 2, width)?;
        let mut found = self.plain_lookup(self.code.get(pc + 1)?)?;
        let FoldedLoop { lookup, slot, sum, length } = &mut found;
        let to = lookup.index_from == OperandBase::Frame && lookup.index == first.a && *slot != first.a;
        if !to || first.from[0] != OperandBase::Frame || first.indirect != 0 || lookup.ty != ty {
            return None;
        }
        let minus = matches!(first.op, Op::Sub16 | Op::Sub32);
        lookup.add = lookup.add.wrapping_add(if minus { add.wrapping_neg() } else { add });
        (lookup.index, lookup.index_from) = (first.b, first.from[1]);
        *sum = Some(first.a);
        *length = 2;
        Some(found)
    }

    fn plain_lookup(&self, step: &FastStep) -> Option<FoldedLoop> {
        let index = self.indexes.get(step.c as usize).filter(|_| step.op.indexes() && step.indirect == 0)?;
        let (ty, add, range) = match step.op {
            Op::IndexI16 => (IndexType::Narrow, 0, i64::from(i16::MIN)..=i64::from(i16::MAX)),
            Op::IndexU16 => (IndexType::Narrow, 0, 0..=i64::from(u16::MAX)),
            Op::IndexI32 => (IndexType::Wide, 0, i64::from(i32::MIN)..=i64::from(i32::MAX)),
            Op::IndexU8 => {
                (IndexType::Constant, constant(self.program, step, 1, 1)?, i64::from(i32::MIN)..=255)
            }
            _ => return None,
        };
        if !range.contains(&index.low) || !range.contains(&index.high) || index.high < index.low {
            return None;
        }
        let low = index.low as u32;
        let lookup = Lookup {
            index: step.b,
            add: u32::wrapping_sub(add, low),
            last: (index.high - index.low) as u32,
            of: index.of,
            stride: index.stride,
            index_from: step.from[1],
            from: index.from,
            ty,
            indirect: index.indirect,
        };
        Some(FoldedLoop { lookup, slot: step.a, sum: None, length: 1 })
    }

    /// The operation as a step, its constant in it, and with the sides as the step has them.
    fn simple(&self, pc: usize, plain: &FastStep) -> (QuickStep, FastStep) {
        let (plain, op) = with_constant(self.program, plain).unwrap_or((*plain, plain.op));
        let modes = (0..3).fold(DIRECT, |modes, nth| {
            modes | if plain.indirect >> nth & 1 != 0 { INDIRECT << (2 * nth) } else { DIRECT }
        });
        let FastStep { from: [from_a, from_b, from_c], a, b, c, cost, .. } = plain;
        let from = [from_a, from_b, from_c, OperandBase::Zero];
        let mut step = QuickStep { op, from, modes, a, b, c, cost, ..leave() };
        if is_call(op) {
            // Where it returns to.
            step.c = pc as u32 + 1;
        }
        if op == Op::CallThis && modes == INDIRECT << 2 {
            (step.op, step.modes) = (Op::CallThrough, DIRECT);
        }
        (if is_quick(op) { step } else { QuickStep { op, ..leave() } }, plain)
    }

    /// The operation at `at` with the lookups before it, if it uses all of them and nothing else does.
    fn folded(&mut self, first: usize, at: usize, lookups: &[FoldedLoop]) -> Option<QuickStep> {
        let plain = self.code.get(at).filter(|plain| is_quick(plain.op))?;
        if self.reached.get(first + 1..=at)?.contains(&true) || !apart(lookups) {
            return None;
        }
        let (mut step, turned) = self.simple(at, plain);
        let mut used = 0;
        for (nth, found) in (0u32..).zip(lookups) {
            let mut uses = false;
            let fields = [(&mut step.a, turned.a), (&mut step.b, turned.b), (&mut step.c, turned.c)];
            for (place, (field, offset)) in fields.into_iter().enumerate() {
                if turned.indirect >> place & 1 != 0 && offset == found.slot {
                    *field = self.quick.lookups.len() as u32 + nth;
                    step.from[place] = OperandBase::Zero;
                    step.modes = step.modes & !(3 << (2 * place)) | LOOKUP << (2 * place);
                    uses = true;
                }
            }
            used += usize::from(uses);
            let idle = |offset| !reads_beside(plain, offset) && self.is_dead(at + 1, offset);
            if !idle(found.slot) || !found.sum.is_none_or(idle) {
                return None;
            }
        }
        let costs = self.code.get(first..=at)?.iter().try_fold(0u32, |sum, step| sum.checked_add(step.cost));
        step.cost = costs?;
        if used != lookups.len() {
            return None;
        }
        if let Some(element) = element(plain, lookups) {
            return Some(QuickStep { cost: step.cost, ..element });
        }
        self.quick.lookups.extend(lookups.iter().map(|found| found.lookup));
        Some(step)
    }

    /// Whether nobody reads a temporary from here on. Temporaries live in the order of the code: an operation that
    /// writes there begins another one.
    fn is_dead(&self, from: usize, offset: u32) -> bool {
        for (step, starts) in self.code.iter().zip(&self.starts).skip(from).take(FAR) {
            if *starts {
                return true;
            }
            let table = [Op::CallLibrary, Op::MoveText, Op::CompareText, Op::Copy].contains(&step.op);
            let of = self.indexes.get(step.c as usize).filter(|_| step.op.indexes());
            if table
                || reads(step, offset)
                || of.is_some_and(|of| of.from == OperandBase::Frame && near(of.of, offset))
                || (step.indirect & 1 != 0 && near(step.a, offset))
            {
                return false;
            }
            if step.op.places()[0] && step.from[0] == OperandBase::Frame && step.a == offset {
                return true;
            }
        }
        // After the last unit.
        self.code.len().saturating_sub(from) <= FAR
    }
}

/// Turns jumps to operations into jumps to steps, and costs into those of runs.
fn renumber_jumps(steps: &mut [QuickStep], positions: &[u32]) {
    let mut after = 0;
    for step in steps.iter_mut().rev() {
        if jumps(step.op) {
            match positions.get(step.a as usize) {
                Some(position) if *position != NONE => step.a = *position,
                _ => *step = leave(),
            }
        }
        if ends(step.op) {
            after = 0;
        }
        step.cost += after;
        after = step.cost;
    }
}

/// What the other loop goes on with.
pub(super) fn leave() -> QuickStep {
    QuickStep {
        op: Op::Leave,
        from: [OperandBase::Zero; 4],
        modes: DIRECT,
        narrow: false,
        a: 0,
        b: 0,
        c: 0,
        d: 0,
        last: 0,
        of: 0,
        cost: 0,
    }
}

/// Whether a value of at most 8 bytes at one offset may reach the temporary at the other.
pub(super) fn near(of: u32, offset: u32) -> bool {
    of < offset.saturating_add(8) && offset < of.saturating_add(8)
}

/// Whether the operation reads at the frame's offset, itself or for an address.
fn reads(step: &FastStep, offset: u32) -> bool {
    let fields = [(1, step.b), (2, step.c)];
    fields.iter().any(|(nth, field)| {
        step.op.places()[*nth] && step.from[*nth] == OperandBase::Frame && near(*field, offset)
    })
}

/// The same without the addresses of operands, for an operation that the lookup is made for.
fn reads_beside(step: &FastStep, offset: u32) -> bool {
    let fields = [step.a, step.b, step.c];
    fields.iter().enumerate().any(|(nth, field)| {
        let exact = step.indirect >> nth & 1 != 0 && *field == offset;
        let read = nth > 0 || step.indirect & 1 != 0;
        read && !exact
            && step.op.places()[nth]
            && step.from[nth] == OperandBase::Frame
            && near(*field, offset)
    })
}

/// Whether no lookup reads or overwrites in another way what one before it leaves. They are all found before
/// anything is left.
fn apart(lookups: &[FoldedLoop]) -> bool {
    let touches = |one: &FoldedLoop, other: &Lookup| {
        let inputs = [(other.index_from, other.index), (other.from, other.of)];
        [Some(one.slot), one.sum]
            .into_iter()
            .flatten()
            .any(|left| inputs.iter().any(|(from, at)| *from == OperandBase::Frame && left.abs_diff(*at) < 4))
    };
    lookups.iter().enumerate().all(|(nth, one)| {
        let slots = lookups.iter().skip(nth + 1).all(|other| other.slot != one.slot);
        slots && !lookups.iter().any(|other| touches(one, &other.lookup))
    })
}

/// Whether the quick loop has the operation by itself.
fn is_quick(op: Op) -> bool {
    let is = |first: Op, last: Op| within(op, first, last);
    is(Op::Move8, Op::Move64)
        || is(Op::Address, Op::F32ToF64)
        || is(Op::IndexI8, Op::IndexU64)
        || is(Op::Jump, Op::Frame)
        || is_call(op)
        || matches!(op, Op::CallNative | Op::Return)
        || is(Op::Set8, Op::CallThrough)
}

fn is_call(op: Op) -> bool {
    within(op, Op::Call, Op::CallSame)
}

fn within(op: Op, first: Op, last: Op) -> bool {
    op as u16 >= first as u16 && op as u16 <= last as u16
}

/// Whether an operand is in the host's areas.
fn is_foreign(plain: &FastStep) -> bool {
    let fields = plain.op.places().into_iter().zip(plain.from).zip([plain.a, plain.b, plain.c]);
    fields
        .into_iter()
        .any(|((place, from), offset)| place && from == OperandBase::Zero && offset >= map::INPUTS)
}

/// Whether the step may go on at the operation `a`.
fn jumps(op: Op) -> bool {
    op == Op::Jump
        || op.branches()
        || within(op, Op::Equal8, Op::Turn32)
        || within(op, Op::EqualElement32, Op::GreaterEqualElement32)
        || within(op, Op::GrowLess32, Op::ModOther32)
}

/// Whether the time of what follows is not taken with this step.
fn ends(op: Op) -> bool {
    let leads_away = is_call(op) || matches!(op, Op::CallThrough | Op::CallNative | Op::Return);
    leads_away || jumps(op) || !is_quick(op)
}
