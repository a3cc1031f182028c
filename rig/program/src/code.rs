//! Operations of the machine.

use crate::types::Elementary;

/// What an operation does. `acc` is the top of the operand stack.
///
/// Cells are addressed absolutely, relative to the instance of the running block (`This`), or in the running
/// unit's frame (`Local`). The `At` forms add an offset from the operand stack.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Op {
    Const(i32),
    /// A constant of the table.
    Wide(u32),
    Load(u32),
    LoadThis(u32),
    LoadLocal(u32),
    LoadAt(u32),
    LoadThisAt(u32),
    LoadLocalAt(u32),
    /// A located place, by its entry.
    LoadIo(u32),
    Store(u32),
    StoreThis(u32),
    StoreLocal(u32),
    /// Offset below value.
    StoreAt(u32),
    StoreThisAt(u32),
    StoreLocalAt(u32),
    StoreIo(u32),
    /// An index to an offset, checked against an entry of the bounds.
    Index(u32),
    Add(Elementary),
    Sub(Elementary),
    Mul(Elementary),
    Div(Elementary),
    Mod(Elementary),
    /// The next four with a constant on the right.
    AddConst(Elementary, i32),
    EqConst(i32),
    LtConst(i32),
    GtConst(i32),
    And,
    Or,
    Xor,
    Not(Elementary),
    Neg(Elementary),
    Eq,
    Ne,
    Lt,
    Le,
    Gt,
    Ge,
    /// The order of ULINT and LWORD.
    LtWide,
    LeWide,
    GtWide,
    GeWide,
    Wrap(Elementary),
    /// 1 where not 0.
    Truth,
    Abs(Elementary),
    Min,
    Max,
    MinWide,
    MaxWide,
    /// Condition, value if FALSE, value if TRUE.
    Sel,
    Shl(Elementary),
    Shr(Elementary),
    Rol(Elementary),
    Ror(Elementary),
    Jump(u32),
    JumpIfNot(u32),
    JumpIf(u32),
    /// FOR: value, end, step; whether the value is not past the end.
    Within(Elementary),
    /// FOR: value, step; the next value, or the jump where the type cannot hold it.
    NextOrJump(Elementary, u32),
    /// A function: its parameters are on the operand stack, its result comes there.
    CallFunction(u16),
    /// A block or a program: the unit and the absolute first cell of the instance.
    CallBlock(u16, u32),
    CallBlockThis(u16, u32),
    /// The same with an offset from the operand stack.
    CallBlockAt(u16, u32),
    CallBlockThisAt(u16, u32),
    CallNative(u16, u32),
    CallNativeThis(u16, u32),
    CallNativeAt(u16, u32),
    CallNativeThisAt(u16, u32),
    Return,
    /// Runs of operations in one go, made by [`crate::fuse`]. `If`: compare a cell with a constant and jump if not.
    IfEq(u32, i32, u32),
    IfLt(u32, i32, u32),
    IfLe(u32, i32, u32),
    IfGt(u32, i32, u32),
    IfGe(u32, i32, u32),
    /// Jump if the cell is 0.
    IfTrue(u32, u32),
    /// CASE: jump if the local is this.
    LocalEqJump(u32, i32, u32),
    /// FOR: a cell and a constant step, then [`Op::NextOrJump`].
    NextCell(Elementary, u32, i32, u32),
    /// A cell compared with a constant, and divided by one.
    GtCell(u32, i32),
    LtCell(u32, i32),
    DivCell(Elementary, u32, i32),
    /// The operand and not the top; two operands combined to a cell.
    AndNot(Elementary),
    AndTo(u32),
    OrTo(u32),
    /// A cell, a constant, a sum of both, and the sum of two operands to a cell.
    Move(u32, u32),
    Set(i32, u32),
    AddConstTo(Elementary, u32, i32, u32),
    AddTo(Elementary, u32),
    /// The operand with a cell.
    AndCell(u32),
    OrCell(u32),
    AddCell(Elementary, u32),
    LoadConst(u32, i32),
    LoadTwo(u32, u32),
    StoreJump(u32, u32),
    IndexLoad(u32, u32),
    /// Compare two operands and jump if not.
    EqJump(u32),
    LtJump(u32),
    LeJump(u32),
    GtJump(u32),
    GeJump(u32),
}

/// An operation with its modelled time and its place in the source.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Step {
    pub op: Op,
    /// Nanoseconds.
    pub cost: u32,
    /// From 1.
    pub line: u32,
}

/// One dimension of an array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Bounds {
    pub low: i64,
    pub high: i64,
    /// Cells from one element to the next.
    pub stride: u32,
}

/// Code that can be called.
#[derive(Clone, Debug)]
pub(crate) struct Unit {
    /// As declared.
    pub name: String,
    /// Place of the source file.
    pub file: u8,
    pub entry: u32,
    /// Cells of the frame: for a function the result first, then the inputs.
    pub frame: u32,
    /// Parameters on the operand stack.
    pub inputs: u32,
    /// Leading cells of the frame at a call: inputs are put over it.
    pub template: Vec<i64>,
    /// Whether a result goes to the operand stack.
    pub has_result: bool,
    /// Units that it calls, and entries of the located places that it writes, each once.
    pub calls: Vec<u16>,
    pub writes: Vec<u32>,
    /// Operands, frame cells and calls that it needs, units it calls included.
    pub need: Need,
}

/// Room for running a unit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Need {
    pub operands: u32,
    pub frame: u32,
    pub calls: u32,
}
