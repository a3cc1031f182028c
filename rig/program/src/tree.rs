//! The checked program: the intermediate form at which every language of IEC 61131-3 enters. Names are resolved,
//! variables have their places, every conversion is written out, every value has its type. What is here is right:
//! code can be made from it without asking.

use crate::findings::SourcePlace;
use crate::native::Native;
use crate::program::{ConfiguredTask, ImagePlace, Located, ProgramPin, Retained};
use crate::shape::MemoryLayout;
use crate::types::Elementary;

/// The type of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Ty {
    Scalar(Elementary),
    /// A whole number of this type of fewer than 32 bits as the processor computes it: in 32 bits, signed or not as the
    /// type. It costs what its type does.
    Promoted(Elementary),
    /// Text with room for this many characters.
    Text {
        wide: bool,
        length: u32,
    },
    /// Anything else that is copied as bytes: structures, arrays.
    Block {
        bytes: u32,
    },
    /// An address of 4 bytes: pointers, references, interfaces.
    Address,
}

impl Ty {
    /// Bytes in memory.
    pub fn bytes(self) -> u32 {
        match self {
            Ty::Scalar(ty) => ty.bytes() as u32,
            Ty::Promoted(ty) => ty.promoted().bytes() as u32,
            Ty::Text { wide, length } => (length + 1) * if wide { 2 } else { 1 },
            Ty::Block { bytes } => bytes,
            Ty::Address => 4,
        }
    }

    pub fn align(self) -> u32 {
        match self {
            Ty::Scalar(ty) => ty.bytes() as u32,
            Ty::Promoted(ty) => ty.promoted().bytes() as u32,
            Ty::Text { wide, .. } => 1 + u32::from(wide),
            Ty::Block { .. } => 8,
            Ty::Address => 4,
        }
    }
}

/// Everything to make code from.
#[derive(Debug, Default)]
pub(crate) struct Tree {
    /// Programs, functions, blocks, methods, accessors, actions.
    pub units: Vec<UnitTree>,
    /// Those at the end that make instances, which no task runs.
    pub makers: std::ops::Range<usize>,
    /// The one of them that makes everything.
    pub initial: Option<u16>,
    /// Places in `units` of the programs, in the order of the sources.
    pub programs: Vec<u16>,
    pub program_names: Vec<String>,
    pub classes: Vec<crate::code::ObjectClass>,
    pub kinds: Vec<String>,
    pub natives: Vec<&'static Native>,
    /// Initial bytes of the variables. Their first stands at [`crate::code::map::FIRST`]: constants that code needs come after
    /// them when the code is made.
    pub variables: Vec<u8>,
    pub retained: Vec<Retained>,
    pub located: Vec<Located>,
    pub roots: Vec<crate::shape::Root>,
    pub shapes: Vec<MemoryLayout>,
    pub tasks: Vec<ConfiguredTask>,
    pub pins: Vec<ProgramPin>,
    /// Places of %I and %Q that the user's sources name.
    pub images: Vec<ImagePlace>,
    /// Source file and bytes of the first LREAL.
    pub lreal: Option<(u16, std::ops::Range<usize>)>,
}

/// A unit: one piece of code with a frame.
#[derive(Debug, Default)]
pub(crate) struct UnitTree {
    /// As declared; a method with its block, `block.method`.
    pub name: String,
    pub file: u16,
    /// Initial bytes of the frame: result, parameters, variables. Temporaries come after.
    pub frame: Vec<u8>,
    pub body: Vec<Stmt>,
    /// The closing keyword.
    pub end: SourcePlace,
}

/// Where a place counts from.
#[derive(Clone, Debug)]
pub(crate) enum TreeRoot {
    /// The address space: [`crate::code::map`].
    Absolute,
    /// The instance of the running unit.
    This,
    /// The frame of the running unit.
    Frame,
    /// The address that this value is (`Ty::Address`).
    Address(Box<Expr>),
}

/// A place in memory: root, offset, then the indices in turn.
#[derive(Clone, Debug)]
pub(crate) struct TreePlace {
    pub root: TreeRoot,
    pub offset: u32,
    pub indices: Vec<Index>,
    pub ty: Ty,
    /// Declared RETAIN or PERSISTENT: it costs more.
    pub retained: bool,
    pub at: SourcePlace,
}

/// One index of one dimension.
#[derive(Clone, Debug)]
pub(crate) struct Index {
    /// A whole number of any type.
    pub value: Expr,
    pub low: i64,
    pub high: i64,
    /// Bytes from one element to the next.
    pub stride: u32,
}

#[derive(Clone, Debug)]
pub(crate) struct Expr {
    pub kind: ExprKind,
    pub ty: Ty,
    pub at: SourcePlace,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum UnaryOp {
    Not,
    Negate,
    Absolute,
}

/// Both operands are of one type, but for shifts, whose count is LINT.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BinaryOp {
    Add,
    Subtract,
    Multiply,
    Divide,
    Mod,
    And,
    Or,
    Xor,
    /// On BOOL: the right side is computed only where it matters.
    AndThen,
    OrElse,
    ShiftLeft,
    ShiftRight,
    RotateLeft,
    RotateRight,
    Least,
    Greatest,
    Equal,
    NotEqual,
    Less,
    LessEqual,
    Greater,
    GreaterEqual,
}

#[derive(Clone, Debug)]
pub(crate) enum ExprKind {
    /// A scalar or an address: its cell.
    Constant(i64),
    /// A text as it is stored, with the closing unit.
    Text(Vec<u8>),
    /// A structure or an array that is constant.
    Bytes(Vec<u8>),
    Load(TreePlace),
    /// A bit of the memory at a place, counted from its first bit; BOOL.
    LoadBit(TreePlace, u32),
    /// The address of a place.
    AddressOf(TreePlace),
    Unary(UnaryOp, Box<Expr>),
    /// Comparisons give BOOL; operands may be texts or addresses in comparisons.
    Binary(BinaryOp, Box<Expr>, Box<Expr>),
    /// To `ty`, from the type of the operand: scalars and texts. It costs an operation of the wider type.
    Convert(Box<Expr>),
    /// The same bits as `ty`, at no cost: between an address and DWORD, an enumeration and its base. A whole number is
    /// brought to another width: conversions that the source does not write.
    Reinterpret(Box<Expr>),
    /// `pointer + n` bytes; the number is LINT.
    Offset(Box<Expr>, Box<Expr>),
    /// SEL and MUX: the selector (a whole number of any type, BOOL for SEL) and the values, of which the one that is taken
    /// is computed; a selector that is none of them takes the first or the last.
    Select(Box<Expr>, Vec<Expr>),
    /// A function of the library with the generic type of the call.
    Library(&'static crate::library::Function, Elementary, Vec<Expr>),
    Call(Box<TreeCall>),
    /// Whether an interface or block reference (an address) is of this kind (a place in `Tree::kinds`); BOOL.
    IsKind(Box<Expr>, u32),
    /// Runs statements, then gives the value (assignments inside expressions do not exist: this is for the outputs of
    /// calls in the middle of an expression and the like).
    Sequence(Vec<Stmt>, Box<Expr>),
}

/// Whose code a call runs.
#[derive(Clone, Debug)]
pub(crate) enum Callee {
    /// A function or a program: no instance.
    Unit(u16),
    /// A block's body, a method or an action of the block at a place.
    Of(u16, TreePlace),
    /// The same with the instance of the running unit.
    Same(u16),
    /// The method with this selector of the instance at an address.
    Virtual(u32, Expr),
    /// A native block (a place in `Tree::natives`) at a place.
    Native(u16, TreePlace),
}

/// A call: inputs in order, the body, outputs in order.
#[derive(Clone, Debug)]
pub(crate) struct TreeCall {
    pub callee: Callee,
    pub inputs: Vec<CallInput>,
    /// Assigned after the call.
    pub outputs: Vec<CallOutput>,
    /// Where the callee's frame holds the result; the type is that of the expression.
    pub result: Option<u32>,
    pub at: SourcePlace,
}

/// A value for a parameter.
#[derive(Clone, Debug)]
pub(crate) struct CallInput {
    pub to: Slot,
    pub value: Expr,
}

/// A parameter.
#[derive(Clone, Debug)]
pub(crate) enum Slot {
    /// This offset of the callee's frame, of this type.
    Frame(u32, Ty),
    /// This place (a pin of the instance).
    Place(TreePlace),
}

/// An output, assigned after the call.
#[derive(Clone, Debug)]
pub(crate) struct CallOutput {
    pub from: Slot,
    pub negated: bool,
    /// From the type of the slot to that of the target by itself, where it needs conversion.
    pub target: Target,
}

/// What can be assigned to.
#[derive(Clone, Debug)]
pub(crate) enum Target {
    Place(TreePlace),
    /// A bit of the memory at a place.
    Bit(TreePlace, u32),
}

#[derive(Clone, Debug)]
pub(crate) struct Stmt {
    pub kind: StmtKind,
    pub at: SourcePlace,
}

/// Labels of CASE and what they lead to.
pub(crate) type CaseArm = (Vec<(i128, i128)>, Vec<Stmt>);

#[derive(Clone, Debug)]
pub(crate) enum StmtKind {
    /// Target and value are of one type; texts may differ in length.
    Assign(Target, Expr),
    /// The result, if any, is dropped.
    Call(Box<Expr>),
    If {
        arms: Vec<(Expr, Vec<Stmt>)>,
        otherwise: Vec<Stmt>,
    },
    /// Labels are ranges of the cells' numbers, both ends included, disjoint.
    Case {
        selector: Expr,
        arms: Vec<CaseArm>,
        otherwise: Vec<Stmt>,
    },
    For(Box<For>),
    While {
        condition: Expr,
        body: Vec<Stmt>,
        end: SourcePlace,
    },
    Repeat {
        body: Vec<Stmt>,
        until: Expr,
    },
    Exit,
    Continue,
    Return,
}

/// FOR: the step is computed once, the end before each turn. The variable ends one step beyond the end; where its type does not
/// hold that, it goes on at the other end of the type, and the loop with it.
#[derive(Clone, Debug)]
pub(crate) struct For {
    /// A whole number.
    pub variable: TreePlace,
    pub from: Expr,
    /// Of the variable's type, or promoted of it.
    pub to: Expr,
    /// LINT; a constant is not 0.
    pub by: Option<Expr>,
    pub body: Vec<Stmt>,
    pub end: SourcePlace,
}
