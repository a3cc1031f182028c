//! The syntax tree of Structured Text. Chains of equal operators are flat, and every other nesting is bounded by the
//! parser, so that walking the tree by recursion is safe.

use crate::findings::SourcePlace;
use crate::program::Retention;
use crate::types::Elementary;

/// A name by its capitals: names are compared without case (controller:DT-03). The place in [`super::NameTable`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct Key(pub u32);

/// A name with its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Name {
    pub key: Key,
    pub at: SourcePlace,
}

/// Everything that the sources declare.
#[derive(Debug, Default)]
pub(crate) struct SourceUnit {
    pub pous: Vec<Pou>,
    pub types: Vec<TypeDecl>,
    pub interfaces: Vec<InterfaceDecl>,
    pub globals: Vec<Section>,
    pub configurations: Vec<Configuration>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PouKind {
    Program,
    Function,
    FunctionBlock,
}

impl PouKind {
    pub fn keyword(self) -> &'static str {
        match self {
            PouKind::Program => "PROGRAM",
            PouKind::Function => "FUNCTION",
            PouKind::FunctionBlock => "FUNCTION_BLOCK",
        }
    }
}

/// Words before a name: PUBLIC, PRIVATE, PROTECTED, INTERNAL, ABSTRACT, FINAL, OVERRIDE.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Modifiers {
    pub private: bool,
    pub protected: bool,
    pub is_abstract: bool,
    pub is_final: bool,
    pub is_override: bool,
}

/// A program organisation unit.
#[derive(Debug)]
pub(crate) struct Pou {
    pub kind: PouKind,
    pub name: Name,
    pub modifiers: Modifiers,
    pub extends: Option<Name>,
    pub implements: Vec<Name>,
    /// Of a function.
    pub result: Option<TypeRef>,
    pub sections: Vec<Section>,
    pub methods: Vec<Method>,
    pub properties: Vec<Property>,
    pub actions: Vec<Action>,
    pub body: Vec<Stmt>,
    /// Line of the closing keyword, where the return belongs.
    pub end: SourcePlace,
}

/// METHOD of a block, or its head in an interface, where the body is empty.
#[derive(Debug)]
pub(crate) struct Method {
    pub name: Name,
    pub modifiers: Modifiers,
    pub result: Option<TypeRef>,
    pub sections: Vec<Section>,
    pub body: Vec<Stmt>,
    pub end: SourcePlace,
}

/// PROPERTY with its GET and SET; in an interface their bodies are empty.
#[derive(Debug)]
pub(crate) struct Property {
    pub name: Name,
    pub modifiers: Modifiers,
    pub ty: TypeRef,
    pub get: Option<Accessor>,
    pub set: Option<Accessor>,
}

/// GET or SET.
#[derive(Debug)]
pub(crate) struct Accessor {
    pub sections: Vec<Section>,
    pub body: Vec<Stmt>,
    pub end: SourcePlace,
}

/// ACTION: statements of a block or program under a name.
#[derive(Debug)]
pub(crate) struct Action {
    pub name: Name,
    pub body: Vec<Stmt>,
    pub end: SourcePlace,
}

#[derive(Debug)]
pub(crate) struct InterfaceDecl {
    pub name: Name,
    pub extends: Vec<Name>,
    pub methods: Vec<Method>,
    pub properties: Vec<Property>,
}

/// CONFIGURATION: globals and tasks with the programs that they run.
#[derive(Debug)]
pub(crate) struct Configuration {
    pub name: Name,
    pub globals: Vec<Section>,
    pub tasks: Vec<TaskDecl>,
    pub programs: Vec<ProgramDecl>,
}

/// `TASK fast(INTERVAL := T#10ms, PRIORITY := 1);` Values are constant expressions.
#[derive(Debug)]
pub(crate) struct TaskDecl {
    pub name: Name,
    pub parameters: Vec<(Name, Expr)>,
}

/// `PROGRAM instance WITH task : type;`
#[derive(Debug)]
pub(crate) struct ProgramDecl {
    pub instance: Name,
    pub task: Option<Name>,
    pub program: Name,
    pub at: SourcePlace,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SectionKind {
    Input,
    Output,
    InOut,
    /// VAR.
    Local,
    /// VAR_TEMP.
    Temp,
    /// VAR_STAT.
    Static,
    /// VAR_INST of a method.
    Instance,
    Global,
    External,
}

/// One VAR .. END_VAR.
#[derive(Debug)]
pub(crate) struct Section {
    pub kind: SectionKind,
    pub retention: Retention,
    pub constant: bool,
    pub variables: Vec<VarDecl>,
    pub at: SourcePlace,
}

#[derive(Clone, Debug)]
pub(crate) struct VarDecl {
    pub name: Name,
    /// Text of the address after AT.
    pub address: Option<(Box<str>, SourcePlace)>,
    pub ty: TypeRef,
    pub built: Option<Built>,
    /// R_EDGE, F_EDGE where TRUE.
    pub edge: Option<(bool, SourcePlace)>,
    pub initial: Option<Initializer>,
}

/// What FB_Init of an instance is given: `block(level := 1)`; for an array one list for each element,
/// `ARRAY[1..2] OF block[(level := 1), (level := 2)]`.
#[derive(Clone, Debug)]
pub(crate) struct Built {
    pub each: bool,
    pub lists: Vec<Vec<Argument>>,
    pub at: SourcePlace,
}

#[derive(Clone, Debug)]
pub(crate) enum Initializer {
    One(Expr),
    /// `[1, 2, 3(0)]`: values with their number of repetitions.
    List(Vec<(Option<Expr>, Initializer)>, SourcePlace),
    /// `(a := 1, b := [1, 2])`: members of a structure, inputs of a block.
    Members(Vec<(Name, Initializer)>, SourcePlace),
}

#[derive(Clone, Debug)]
pub(crate) struct TypeRef {
    pub kind: TypeKind,
    pub at: SourcePlace,
}

#[derive(Clone, Debug)]
pub(crate) enum TypeKind {
    /// Elementary types too; the base of `lib.type` is skipped by the parser.
    Named(Name),
    /// STRING, WSTRING, STRING(80), STRING[80].
    Text {
        wide: bool,
        length: Option<Box<Expr>>,
    },
    /// `INT (0..100)`.
    Subrange {
        base: Name,
        low: Box<Expr>,
        high: Box<Expr>,
    },
    /// Bounds of each dimension; `None` for `*`.
    Array {
        ranges: Vec<Option<(Expr, Expr)>>,
        of: Box<TypeRef>,
    },
    /// POINTER TO.
    Pointer(Box<TypeRef>),
    /// REF_TO.
    RefTo(Box<TypeRef>),
    /// REFERENCE TO.
    Reference(Box<TypeRef>),
    /// `(red, green := 5) INT`.
    Enumeration {
        values: Vec<(Name, Option<Expr>)>,
        base: Option<Name>,
    },
    Struct {
        extends: Option<Name>,
        members: Vec<VarDecl>,
    },
    Union {
        members: Vec<VarDecl>,
    },
}

/// One name of a TYPE block.
#[derive(Debug)]
pub(crate) struct TypeDecl {
    pub name: Name,
    pub ty: TypeRef,
    pub initial: Option<Initializer>,
}

#[derive(Clone, Debug)]
pub(crate) struct Expr {
    pub kind: ExprKind,
    pub at: SourcePlace,
}

#[derive(Clone, Debug)]
pub(crate) enum ExprKind {
    /// A whole number, of a type where it is written with one.
    Number(i128, Option<Elementary>),
    /// A number with a point: nearest double, nearest single, type where written with one.
    Real(f64, f32, Option<Elementary>),
    Bool(bool),
    /// TIME (whole milliseconds in a cell) or LTIME (nanoseconds); dates and times of day: the cell of the type.
    Moment(i64, Elementary),
    /// A string literal, already unescaped: codes of characters; type where written `STRING#'..'`, `CHAR#'x'`.
    Text {
        wide: bool,
        units: Vec<u16>,
        typed: Option<Elementary>,
    },
    Name(Name),
    /// `.name`: the global variable of this name.
    Global(Name),
    /// `colour#red`.
    Qualified(Name, Name),
    Member(Box<Expr>, Name),
    /// `w.3`, `w.%X3`; `w.%B1` and wider: the size in bits (1, 8, 16, 32) and the number.
    Part {
        of: Box<Expr>,
        bits: u8,
        number: u32,
    },
    Index(Box<Expr>, Vec<Expr>),
    /// `p^`.
    Deref(Box<Expr>),
    /// The callee is a name or a member.
    Call(Box<Expr>, Vec<Argument>),
    /// A direct address.
    Direct(Box<str>),
    This,
    Super,
    /// NULL.
    Null,
    Unary(UnaryOp, Box<Expr>),
    /// Operators of one level, from left to right.
    Chain(Box<Expr>, Vec<(BinaryOp, SourcePlace, Expr)>),
    /// What was reported already.
    Wrong,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum UnaryOp {
    Not,
    Minus,
    Plus,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BinaryOp {
    Or,
    OrElse,
    Xor,
    And,
    AndThen,
    Equal,
    NotEqual,
    Less,
    LessEqual,
    Greater,
    GreaterEqual,
    Add,
    Subtract,
    Multiply,
    Divide,
    Mod,
    Power,
}

impl BinaryOp {
    pub fn text(self) -> &'static str {
        match self {
            BinaryOp::Or => "OR",
            BinaryOp::OrElse => "OR_ELSE",
            BinaryOp::Xor => "XOR",
            BinaryOp::And => "AND",
            BinaryOp::AndThen => "AND_THEN",
            BinaryOp::Equal => "=",
            BinaryOp::NotEqual => "<>",
            BinaryOp::Less => "<",
            BinaryOp::LessEqual => "<=",
            BinaryOp::Greater => ">",
            BinaryOp::GreaterEqual => ">=",
            BinaryOp::Add => "+",
            BinaryOp::Subtract => "-",
            BinaryOp::Multiply => "*",
            BinaryOp::Divide => "/",
            BinaryOp::Mod => "MOD",
            BinaryOp::Power => "**",
        }
    }
}

#[derive(Clone, Debug)]
pub(crate) enum Argument {
    Positional(Expr),
    /// `name := value`.
    Input(Name, Expr),
    /// `name := ` with nothing after, which leaves the parameter out.
    Empty(Name),
    /// `name => target`, `name => NOT target`; without a target it is left out.
    Output {
        name: Name,
        negated: bool,
        target: Option<Expr>,
    },
}

#[derive(Debug)]
pub(crate) struct Stmt {
    pub kind: StmtKind,
    pub at: SourcePlace,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum AssignKind {
    /// `:=`
    Value,
    /// `S=`
    Set,
    /// `R=`
    Reset,
    /// `REF=`
    Reference,
}

#[derive(Debug)]
pub(crate) enum StmtKind {
    /// `a := b := value`: targets from the left.
    Assign {
        targets: Vec<Expr>,
        kind: AssignKind,
        value: Expr,
    },
    /// An expression that stands alone: a call, or the name of an action.
    Call(Expr),
    If {
        arms: Vec<(Expr, Vec<Stmt>)>,
        otherwise: Vec<Stmt>,
    },
    Case {
        selector: Expr,
        arms: Vec<(Vec<CaseLabel>, Vec<Stmt>)>,
        otherwise: Vec<Stmt>,
    },
    For(Box<Counted>),
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

/// FOR.
#[derive(Debug)]
pub(crate) struct Counted {
    pub variable: Expr,
    pub from: Expr,
    pub to: Expr,
    pub by: Option<Expr>,
    pub body: Vec<Stmt>,
    /// The closing keyword, where the turn is counted.
    pub end: SourcePlace,
}

#[derive(Debug)]
pub(crate) struct CaseLabel {
    pub low: Expr,
    pub high: Option<Expr>,
}
