//! The code in the form that runs: operands with their base taken apart.

use super::quick::{Quick, fold};
use crate::code::{AddressBase, CodeStep, IndexOf, Op, Operand};
use crate::program::Program;

/// Which base an operand's offset counts from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(super) enum OperandBase {
    /// 0: also for fields that are no operands.
    Zero,
    This,
    Frame,
}

/// An operation. Fields that are no operands count from 0.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FastStep {
    pub(super) op: Op,
    pub(super) from: [OperandBase; 3],
    /// Bits 0 to 2: the address stands where `a`, `b`, `c` lead.
    pub(super) indirect: u8,
    pub(super) a: u32,
    pub(super) b: u32,
    pub(super) c: u32,
    pub(super) cost: u32,
}

/// How an index becomes an address.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FastIndex {
    pub(super) low: i64,
    pub(super) high: i64,
    pub(super) stride: u32,
    pub(super) of: u32,
    pub(super) from: OperandBase,
    /// The array's address stands where `of` leads.
    pub(super) indirect: bool,
    /// See [`IndexOf::stored`].
    pub(super) stored: bool,
}

/// Code and indexes in the form that runs. Places in them are those of the program.
#[derive(Clone, Debug)]
pub(crate) struct PreparedCode {
    pub(super) code: Vec<FastStep>,
    pub(super) indexes: Vec<FastIndex>,
    pub(super) quick: Quick,
}

impl PreparedCode {
    pub fn new(program: &Program) -> PreparedCode {
        let code: Vec<FastStep> = program.code.iter().map(fast).collect();
        let indexes: Vec<FastIndex> = program.indexes.iter().map(index).collect();
        let quick = fold(&code, &indexes, program);
        PreparedCode { code, indexes, quick }
    }
}

impl OperandBase {
    fn of(base: AddressBase) -> OperandBase {
        match base {
            AddressBase::Absolute => OperandBase::Zero,
            AddressBase::This => OperandBase::This,
            AddressBase::Frame | AddressBase::Indirect => OperandBase::Frame,
        }
    }
}

fn index(index: &IndexOf) -> FastIndex {
    FastIndex {
        low: index.low,
        high: index.high,
        stride: index.stride,
        of: index.of.offset(),
        from: OperandBase::of(index.of.base()),
        indirect: index.of.base() == AddressBase::Indirect,
        stored: index.stored,
    }
}

fn fast(step: &CodeStep) -> FastStep {
    let mut fast = FastStep {
        op: step.op,
        from: [OperandBase::Zero; 3],
        indirect: 0,
        a: step.a,
        b: step.b,
        c: step.c,
        cost: step.cost,
    };
    let places = step.op.places();
    let fields = [&mut fast.a, &mut fast.b, &mut fast.c];
    for (nth, ((field, from), is_place)) in fields.into_iter().zip(&mut fast.from).zip(places).enumerate() {
        if !is_place {
            continue;
        }
        let operand = Operand(*field);
        *field = operand.offset();
        *from = OperandBase::of(operand.base());
        fast.indirect |= u8::from(operand.base() == AddressBase::Indirect) << nth;
    }
    if step.op.indexes() {
        // The element's address goes to the frame always.
        fast.a = Operand(step.a).offset();
        fast.from[0] = OperandBase::Frame;
        fast.indirect &= !1;
    }
    fast
}

impl Op {
    /// Whether it computes an element's address.
    pub(crate) fn indexes(self) -> bool {
        (self as u16 >= Op::IndexI8 as u16) && (self as u16 <= Op::IndexU64 as u16)
    }

    /// Which of the fields `a`, `b` and `c` are places.
    pub(crate) fn places(self) -> [bool; 3] {
        let op = self as u16;
        let within = |first: Op, last: Op| op >= first as u16 && op <= last as u16;
        match self {
            Op::Move8 | Op::Move16 | Op::Move32 | Op::Move64 | Op::Copy | Op::Address => [true, true, false],
            Op::NotBool | Op::Not8 | Op::Not16 | Op::Not32 | Op::Not64 => [true, true, false],
            _ if within(Op::Neg8, Op::AbsF64) => [true, true, false],
            _ if within(Op::Sign8To16, Op::IndexU64) => [true, true, false],
            Op::LoadBit | Op::StoreBit | Op::IsKind => [true, true, false],
            Op::Jump | Op::Frame | Op::Call | Op::CallSame | Op::MoveText | Op::CallLibrary | Op::Return => {
                [false; 3]
            }
            Op::CompareText => [true, false, false],
            Op::JumpIf | Op::JumpIfNot => [false, true, false],
            _ if within(Op::JumpEq8, Op::ForU64) => [false, true, true],
            Op::FrameVirtual | Op::CallThis | Op::CallVirtual | Op::CallNative => [false, true, false],
            _ => [true; 3],
        }
    }
}
