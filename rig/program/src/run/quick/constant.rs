//! Steps whose last operand is a constant, which they then hold themselves.

use super::super::fast::{FastStep, OperandBase};
use crate::code::Op;
use crate::program::Program;

/// The bytes of a constant from an operand on.
fn bytes(program: &Program, from: OperandBase, offset: u32) -> Option<&[u8]> {
    let is = from == OperandBase::Zero && offset >= program.variables_to;
    program.image.get(offset as usize..).filter(|_| is)
}

/// The constant at an operand (0 for `a`) as a number of 8, 16 or 32 bits, in the low bits.
pub(super) fn constant(program: &Program, plain: &FastStep, operand: usize, width: usize) -> Option<u32> {
    let offset = [plain.a, plain.b, plain.c].get(operand).copied()?;
    if plain.indirect >> operand & 1 != 0 {
        return None;
    }
    let bytes = bytes(program, *plain.from.get(operand)?, offset)?.get(..width)?;
    Some(bytes.iter().rev().fold(0, |n, byte| n << 8 | u32::from(*byte)))
}

/// The operation with its sides changed, so that the constant is the last operand, and what it is then.
pub(super) fn with_constant(program: &Program, plain: &FastStep) -> Option<(FastStep, Op)> {
    let (width, last, first) = match plain.op {
        Op::Move8 => (1, None, Some(Op::Set8)),
        Op::Move16 => (2, None, Some(Op::Set16)),
        Op::Move32 => (4, None, Some(Op::Set32)),
        Op::Add16 | Op::Sub16 => (2, Some(Op::Sum16), None),
        Op::Add32 | Op::Sub32 => (4, Some(Op::Sum32), None),
        Op::JumpEq8 => (1, Some(Op::Equal8), None),
        Op::JumpEq16 => (2, Some(Op::Equal16), None),
        Op::JumpEq32 => (4, Some(Op::Equal32), None),
        Op::JumpNe8 => (1, Some(Op::Other8), None),
        Op::JumpNe16 => (2, Some(Op::Other16), None),
        Op::JumpNe32 => (4, Some(Op::Other32), None),
        Op::JumpLtI16 => (2, Some(Op::Less16), Some(Op::Greater16)),
        Op::JumpLtI32 => (4, Some(Op::Less32), Some(Op::Greater32)),
        Op::JumpLeI16 => (2, Some(Op::LessEqual16), Some(Op::GreaterEqual16)),
        Op::JumpLeI32 => (4, Some(Op::LessEqual32), Some(Op::GreaterEqual32)),
        Op::ForI16 => (2, Some(Op::Turn16), None),
        Op::ForI32 => (4, Some(Op::Turn32), None),
        _ => return None,
    };
    let mut turned = *plain;
    if let Some(last) = last
        && let Some(value) = constant(program, plain, 2, width)
    {
        let [from_a, from_b, _] = plain.from;
        turned.from = [from_a, from_b, OperandBase::Zero];
        let minus = matches!(plain.op, Op::Sub16 | Op::Sub32);
        turned.c = if minus { value.wrapping_neg() } else { value };
        let same = plain.indirect == 0 && from_a == from_b && plain.a == plain.b;
        return Some((
            turned,
            match last {
                Op::Sum16 if same => Op::Grow16,
                Op::Sum32 if same => Op::Grow32,
                last => last,
            },
        ));
    }
    let value = constant(program, plain, 1, width)?;
    let [from_a, _, from_c] = plain.from;
    turned.from = [from_a, from_c, OperandBase::Zero];
    (turned.b, turned.c) = (plain.c, value);
    turned.indirect = plain.indirect & 1 | plain.indirect >> 1 & 2;
    Some((turned, first?))
}
