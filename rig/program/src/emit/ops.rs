//! Which operation an operator is for a type.

use crate::code::Op::{self, *};
use crate::tree::{BinaryOp, Ty};
use crate::types::Elementary;

/// By width, then REAL and LREAL.
type Six = [Op; 6];
/// By width, signed and unsigned of each, then REAL and LREAL.
type Ten = [Op; 10];

const MOVE: [Op; 4] = [Move8, Move16, Move32, Move64];
const ADD: Six = [Add8, Add16, Add32, Add64, AddF32, AddF64];
const SUB: Six = [Sub8, Sub16, Sub32, Sub64, SubF32, SubF64];
const MUL: Six = [Mul8, Mul16, Mul32, Mul64, MulF32, MulF64];
const NEG: Six = [Neg8, Neg16, Neg32, Neg64, NegF32, NegF64];
const ABS: Six = [AbsI8, AbsI16, AbsI32, AbsI64, AbsF32, AbsF64];
const EQ: Six = [Eq8, Eq16, Eq32, Eq64, EqF32, EqF64];
const NE: Six = [Ne8, Ne16, Ne32, Ne64, NeF32, NeF64];
const JUMP_EQ: Six = [JumpEq8, JumpEq16, JumpEq32, JumpEq64, JumpEqF32, JumpEqF64];
const JUMP_NE: Six = [JumpNe8, JumpNe16, JumpNe32, JumpNe64, JumpNeF32, JumpNeF64];
const DIV: Ten = [DivI8, DivU8, DivI16, DivU16, DivI32, DivU32, DivI64, DivU64, DivF32, DivF64];
const MOD: [Op; 8] = [ModI8, ModU8, ModI16, ModU16, ModI32, ModU32, ModI64, ModU64];
const MIN: Ten = [MinI8, MinU8, MinI16, MinU16, MinI32, MinU32, MinI64, MinU64, MinF32, MinF64];
const MAX: Ten = [MaxI8, MaxU8, MaxI16, MaxU16, MaxI32, MaxU32, MaxI64, MaxU64, MaxF32, MaxF64];
const LT: Ten = [LtI8, LtU8, LtI16, LtU16, LtI32, LtU32, LtI64, LtU64, LtF32, LtF64];
const LE: Ten = [LeI8, LeU8, LeI16, LeU16, LeI32, LeU32, LeI64, LeU64, LeF32, LeF64];
const JUMP_LT: Ten = [
    JumpLtI8, JumpLtU8, JumpLtI16, JumpLtU16, JumpLtI32, JumpLtU32, JumpLtI64, JumpLtU64, JumpLtF32,
    JumpLtF64,
];
const JUMP_LE: Ten = [
    JumpLeI8, JumpLeU8, JumpLeI16, JumpLeU16, JumpLeI32, JumpLeU32, JumpLeI64, JumpLeU64, JumpLeF32,
    JumpLeF64,
];
const AND: [Op; 4] = [And8, And16, And32, And64];
const OR: [Op; 4] = [Or8, Or16, Or32, Or64];
const XOR: [Op; 4] = [Xor8, Xor16, Xor32, Xor64];
const NOT: [Op; 4] = [Not8, Not16, Not32, Not64];
const SHL: [Op; 4] = [Shl8, Shl16, Shl32, Shl64];
const SHR: [Op; 8] = [ShrI8, ShrU8, ShrI16, ShrU16, ShrI32, ShrU32, ShrI64, ShrU64];
const ROL: [Op; 4] = [Rol8, Rol16, Rol32, Rol64];
const ROR: [Op; 4] = [Ror8, Ror16, Ror32, Ror64];
const INDEX: [Op; 8] = [IndexI8, IndexU8, IndexI16, IndexU16, IndexI32, IndexU32, IndexI64, IndexU64];
const FOR: [Op; 8] = [ForI8, ForU8, ForI16, ForU16, ForI32, ForU32, ForI64, ForU64];

/// A comparison as the machine has them; the others are these with their sides or their outcome turned round.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum CompareRelation {
    Equal,
    NotEqual,
    Less,
    LessEqual,
}

/// The relation, and whether the sides change places.
pub(super) fn relation(op: BinaryOp) -> Option<(CompareRelation, bool)> {
    Some(match op {
        BinaryOp::Equal => (CompareRelation::Equal, false),
        BinaryOp::NotEqual => (CompareRelation::NotEqual, false),
        BinaryOp::Less => (CompareRelation::Less, false),
        BinaryOp::LessEqual => (CompareRelation::LessEqual, false),
        BinaryOp::Greater => (CompareRelation::Less, true),
        BinaryOp::GreaterEqual => (CompareRelation::LessEqual, true),
        _ => return None,
    })
}

/// The type that a value is computed as: an address is an unsigned number of 32 bits.
pub(super) fn scalar(ty: Ty) -> Elementary {
    match ty {
        Ty::Scalar(ty) => ty,
        Ty::Promoted(ty) => ty.promoted(),
        Ty::Address => Elementary::Dword,
        Ty::Text { .. } | Ty::Block { .. } => Elementary::Byte,
    }
}

/// The type whose operations a value's cost: how many bits the processor takes for them makes no difference.
pub(super) fn priced(ty: Ty) -> Elementary {
    match ty {
        Ty::Promoted(ty) => ty,
        ty => scalar(ty),
    }
}

fn width(ty: Elementary) -> usize {
    ty.bytes().trailing_zeros() as usize
}

fn six(table: &Six, ty: Elementary) -> Op {
    table[match ty {
        Elementary::Real => 4,
        Elementary::Lreal => 5,
        _ => width(ty),
    }]
}

fn ten(table: &Ten, ty: Elementary) -> Op {
    table[match ty {
        Elementary::Real => 8,
        Elementary::Lreal => 9,
        _ => signed_width(ty),
    }]
}

fn signed_width(ty: Elementary) -> usize {
    2 * width(ty) + usize::from(!ty.signed())
}

pub(super) fn mov(ty: Elementary) -> Op {
    MOVE[width(ty)]
}

pub(super) fn not(ty: Elementary) -> Op {
    if ty == Elementary::Bool { NotBool } else { NOT[width(ty)] }
}

pub(super) fn negate(ty: Elementary) -> Op {
    six(&NEG, ty)
}

/// `None` for types without negative values.
pub(super) fn absolute(ty: Elementary) -> Option<Op> {
    (ty.signed() || ty.is_real()).then(|| six(&ABS, ty))
}

pub(super) fn index(ty: Elementary) -> Op {
    INDEX[signed_width(ty)]
}

pub(super) fn counted(ty: Elementary) -> Op {
    FOR[signed_width(ty)]
}

pub(super) fn add(ty: Elementary) -> Op {
    six(&ADD, ty)
}

/// Operators with a result of the operands' type. `None` for the others.
pub(super) fn arithmetic(op: BinaryOp, ty: Elementary) -> Option<Op> {
    Some(match op {
        BinaryOp::Add => six(&ADD, ty),
        BinaryOp::Subtract => six(&SUB, ty),
        BinaryOp::Multiply => six(&MUL, ty),
        BinaryOp::Divide => ten(&DIV, ty),
        BinaryOp::Mod => MOD[signed_width(ty)],
        BinaryOp::And => AND[width(ty)],
        BinaryOp::Or => OR[width(ty)],
        BinaryOp::Xor => XOR[width(ty)],
        BinaryOp::ShiftLeft => SHL[width(ty)],
        BinaryOp::ShiftRight => SHR[signed_width(ty)],
        BinaryOp::RotateLeft => ROL[width(ty)],
        BinaryOp::RotateRight => ROR[width(ty)],
        BinaryOp::Least => ten(&MIN, ty),
        BinaryOp::Greatest => ten(&MAX, ty),
        _ => return None,
    })
}

pub(super) fn compare(relation: CompareRelation, ty: Elementary) -> Op {
    match relation {
        CompareRelation::Equal => six(&EQ, ty),
        CompareRelation::NotEqual => six(&NE, ty),
        CompareRelation::Less => ten(&LT, ty),
        CompareRelation::LessEqual => ten(&LE, ty),
    }
}

/// The jump where the relation holds, or where it does not, and whether the sides change places for it.
pub(super) fn jump(relation: CompareRelation, ty: Elementary, holds: bool) -> (Op, bool) {
    match (relation, holds) {
        (CompareRelation::Equal, true) | (CompareRelation::NotEqual, false) => (six(&JUMP_EQ, ty), false),
        (CompareRelation::NotEqual, true) | (CompareRelation::Equal, false) => (six(&JUMP_NE, ty), false),
        (CompareRelation::Less, true) => (ten(&JUMP_LT, ty), false),
        (CompareRelation::LessEqual, true) => (ten(&JUMP_LE, ty), false),
        // With NaN, no relation holds: `not a < b` is not `b <= a`.
        (CompareRelation::Less, false) => match ty {
            Elementary::Real => (JumpNotLtF32, false),
            Elementary::Lreal => (JumpNotLtF64, false),
            _ => (ten(&JUMP_LE, ty), true),
        },
        (CompareRelation::LessEqual, false) => match ty {
            Elementary::Real => (JumpNotLeF32, false),
            Elementary::Lreal => (JumpNotLeF64, false),
            _ => (ten(&JUMP_LT, ty), true),
        },
    }
}

/// The operation that makes `to` of `from` between numbers, where there is a short one.
pub(super) fn convert(from: Elementary, to: Elementary) -> Option<Op> {
    use Elementary::{Dint, Int, Lreal, Real};
    Some(match (from, to) {
        (Int, Real) => I16ToF32,
        (Dint, Real) => I32ToF32,
        (Dint, Lreal) => I32ToF64,
        (Real, Lreal) => F32ToF64,
        _ => return None,
    })
}

/// The operation that widens a whole number.
pub(super) fn extend(from: Elementary, to: Elementary) -> Option<Op> {
    Some(match (from.signed(), from.bytes(), to.bytes()) {
        (true, 1, 2) => Sign8To16,
        (true, 1, 4) => Sign8To32,
        (true, 1, 8) => Sign8To64,
        (true, 2, 4) => Sign16To32,
        (true, 2, 8) => Sign16To64,
        (true, 4, 8) => Sign32To64,
        (false, 1, 2) => Zero8To16,
        (false, 1, 4) => Zero8To32,
        (false, 1, 8) => Zero8To64,
        (false, 2, 4) => Zero16To32,
        (false, 2, 8) => Zero16To64,
        (false, 4, 8) => Zero32To64,
        _ => return None,
    })
}
