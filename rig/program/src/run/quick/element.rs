//! Steps that have an element of an array of numbers, found by themselves.

use super::super::fast::{FastStep, OperandBase};
use super::fold::{FoldedLoop, leave};
use super::lookup::{IndexType, Lookup};
use super::{DIRECT, QuickStep};
use crate::code::Op;

/// Which operand the element is.
#[derive(Clone, Copy, PartialEq, Eq)]
enum ElementSide {
    A,
    B,
    C,
}

/// The lookup alone, as a step that leaves the address.
pub(super) fn address(plain: &FastStep, found: &FoldedLoop) -> Option<QuickStep> {
    let Lookup { stride, .. } = found.lookup;
    let [from_a, ..] = plain.from;
    let step = QuickStep { op: Op::Element, from: [from_a; 4], a: plain.a, b: stride, ..leave() };
    with(step, &found.lookup)
}

/// An operation and the lookups before it, all of which it uses.
pub(super) fn element(plain: &FastStep, lookups: &[FoldedLoop]) -> Option<QuickStep> {
    let FastStep { from: [from_a, from_b, from_c], a, b, c, .. } = *plain;
    match lookups {
        [found] => {
            let side = match plain.indirect {
                1 if a == found.slot => ElementSide::A,
                2 if b == found.slot => ElementSide::B,
                4 if c == found.slot => ElementSide::C,
                _ => return None,
            };
            if found.lookup.ty == IndexType::Constant {
                return to_offset(plain, side, &found.lookup);
            }
            let (op, width) = one(plain.op, side)?;
            // The operand that is no element.
            let (other, from_other) = if side == ElementSide::B { (c, from_c) } else { (b, from_b) };
            let from = [from_a, from_other, OperandBase::Zero, OperandBase::Zero];
            let step = QuickStep { op, from, a, b: other, ..leave() };
            (found.lookup.stride == width).then_some(())?;
            with(step, &found.lookup)
        }
        [one, other] if plain.indirect == 3 => {
            let (to, of) = match (a, b) {
                _ if (a, b) == (one.slot, other.slot) => (one.lookup, other.lookup),
                _ if (a, b) == (other.slot, one.slot) => (other.lookup, one.lookup),
                _ => return None,
            };
            let (op, width) = match plain.op {
                Op::Move8 => (Op::Shift8, 1),
                Op::Move16 => (Op::Shift16, 2),
                Op::Move32 => (Op::Shift32, 4),
                _ => return None,
            };
            let same = Lookup { add: to.add, ..of } == to && to.stride == width;
            same.then_some(())?;
            with(QuickStep { op, b: of.add, ..leave() }, &to)
        }
        _ => None,
    }
}

/// What goes after an address: a pin of an instance that was found.
fn to_offset(plain: &FastStep, side: ElementSide, lookup: &Lookup) -> Option<QuickStep> {
    let op = match plain.op {
        Op::Move8 => Op::ToOffset8,
        Op::Move16 => Op::ToOffset16,
        Op::Move32 => Op::ToOffset32,
        _ => return None,
    };
    let fits = side == ElementSide::A && lookup.indirect && lookup.add <= lookup.last;
    let from = [lookup.from, plain.from[1], OperandBase::Zero, OperandBase::Zero];
    let d = lookup.add.wrapping_mul(lookup.stride);
    fits.then_some(QuickStep { op, from, a: lookup.of, b: plain.b, d, ..leave() })
}

/// The operation with an element on one side, and the width of the element.
fn one(op: Op, side: ElementSide) -> Option<(Op, u32)> {
    Some(match (op, side) {
        (Op::Move8, ElementSide::B) => (Op::Fetch8, 1),
        (Op::Move16, ElementSide::B) => (Op::Fetch16, 2),
        (Op::Move32, ElementSide::B) => (Op::Fetch32, 4),
        (Op::Move8, ElementSide::A) => (Op::Keep8, 1),
        (Op::Move16, ElementSide::A) => (Op::Keep16, 2),
        (Op::Move32, ElementSide::A) => (Op::Keep32, 4),
        (Op::Add32, ElementSide::B | ElementSide::C) => (Op::AddElement32, 4),
        (Op::AddF32, ElementSide::B | ElementSide::C) => (Op::AddElementF32, 4),
        (Op::JumpEq32, ElementSide::B | ElementSide::C) => (Op::EqualElement32, 4),
        (Op::JumpNe32, ElementSide::B | ElementSide::C) => (Op::OtherElement32, 4),
        (Op::JumpLtI32, ElementSide::C) => (Op::LessElement32, 4),
        (Op::JumpLtI32, ElementSide::B) => (Op::GreaterElement32, 4),
        (Op::JumpLeI32, ElementSide::C) => (Op::LessEqualElement32, 4),
        (Op::JumpLeI32, ElementSide::B) => (Op::GreaterEqualElement32, 4),
        _ => return None,
    })
}

/// The step with its lookup, if it is one that steps can have.
fn with(step: QuickStep, lookup: &Lookup) -> Option<QuickStep> {
    let Lookup { index, add, last, of, index_from, from, ty, indirect, .. } = *lookup;
    let fits = !indirect && ty != IndexType::Constant && step.modes == DIRECT;
    let [from_a, from_b, ..] = step.from;
    let from = [from_a, from_b, index_from, from];
    let narrow = ty == IndexType::Narrow;
    fits.then_some(QuickStep { from, c: index, d: add, last, of, narrow, ..step })
}
