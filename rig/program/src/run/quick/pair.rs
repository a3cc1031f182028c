//! Two operations that often follow each other as one step.

use super::super::fast::{FastStep, OperandBase};
use super::QuickStep;
use super::constant::{constant, with_constant};
use super::fold::{leave, near};
use crate::code::Op;
use crate::program::Program;

/// The step, and the offset of the temporary in between, which it does not write.
pub(super) type StepPair = (QuickStep, Option<u32>);

/// The operations at the start of `code` as one.
pub(super) fn pair(program: &Program, first: &FastStep, second: &FastStep) -> Option<StepPair> {
    if first.indirect != 0 || second.indirect != 0 {
        return None;
    }
    match first.op {
        Op::Add32 | Op::Sub32 => grow(program, first, second),
        Op::Move8 => inputs(program, first, second),
        Op::Mul32 | Op::ModI32 | Op::MulF32 if first.from[0] == OperandBase::Frame => {
            through(program, first, second)
        }
        _ => None,
    }
}

/// What timers get: a BOOL, then a constant.
fn inputs(program: &Program, first: &FastStep, second: &FastStep) -> Option<StepPair> {
    let (second, Op::Set32) = with_constant(program, second)? else { return None };
    let from = [first.from[0], first.from[1], second.from[0], OperandBase::Zero];
    let step =
        QuickStep { op: Op::Move8Set32, from, a: first.a, b: first.b, c: second.a, d: second.c, ..leave() };
    Some((step, None))
}

/// A count and a comparison of it.
fn grow(program: &Program, first: &FastStep, second: &FastStep) -> Option<StepPair> {
    let (first, Op::Grow32) = with_constant(program, first)? else { return None };
    let (second, op) = with_constant(program, second)?;
    let constant = second.c as i32;
    let (op, constant) = match op {
        Op::Less32 => (Op::GrowLess32, constant),
        Op::LessEqual32 => (Op::GrowLess32, constant.checked_add(1)?),
        Op::Greater32 => (Op::GrowGreater32, constant),
        Op::GreaterEqual32 => (Op::GrowGreater32, constant.checked_sub(1)?),
        _ => return None,
    };
    let same = (first.from[0], first.a) == (second.from[1], second.b);
    let from = [OperandBase::Zero, first.from[0], OperandBase::Zero, OperandBase::Zero];
    let step = QuickStep { op, from, a: second.a, b: first.a, c: first.c, d: constant as u32, ..leave() };
    same.then_some((step, None))
}

/// An operation to a temporary and one that uses it.
fn through(program: &Program, first: &FastStep, second: &FastStep) -> Option<StepPair> {
    let [_, from_b, from_c] = first.from;
    let FastStep { a: temporary, b, c, .. } = *first;
    let is = |nth: usize, offset| second.from.get(nth) == Some(&OperandBase::Frame) && offset == temporary;
    // The other operand of the second one.
    let (side, other, from_other) = match (is(1, second.b), is(2, second.c)) {
        (true, false) => (1, second.c, second.from[2]),
        (false, true) => (2, second.b, second.from[1]),
        _ => return None,
    };
    if from_other == OperandBase::Frame && near(other, temporary) {
        return None;
    }
    let (op, d, from_d) = match (first.op, second.op, side) {
        (Op::Mul32, Op::JumpLtI32, 1) => (Op::MulLess32, other, from_other),
        (Op::Mul32, Op::JumpLtI32, _) => (Op::MulGreater32, other, from_other),
        (Op::ModI32, Op::JumpEq32, 1) => {
            (Op::ModEqual32, constant(program, second, 2, 4)?, OperandBase::Zero)
        }
        (Op::ModI32, Op::JumpNe32, 1) => {
            (Op::ModOther32, constant(program, second, 2, 4)?, OperandBase::Zero)
        }
        (Op::Mul32, Op::Add32, _) => (Op::MulAdd32, other, from_other),
        (Op::MulF32, Op::AddF32, _) => (Op::MulAddF32, other, from_other),
        _ => return None,
    };
    // For jumps, `a` is where they lead.
    let from = [second.from[0], from_b, from_c, from_d];
    Some((QuickStep { op, from, a: second.a, b, c, d, ..leave() }, Some(temporary)))
}
