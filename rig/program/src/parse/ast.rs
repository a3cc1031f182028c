//! The syntax tree. Chains of equal operators are flat, so that its depth is that of brackets and blocks only.

use crate::findings::At;
use crate::program::Retention;
use crate::types::Elementary;

/// A name with its capitals, by which names are compared (controller:DT-03).
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Name {
    pub text: String,
    pub key: String,
    pub at: At,
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

/// A program organisation unit.
#[derive(Debug)]
pub(crate) struct Pou {
    pub kind: PouKind,
    pub name: Name,
    pub result: Option<TypeRef>,
    pub sections: Vec<Section>,
    pub body: Vec<Stmt>,
    /// Line of the closing keyword, where the return belongs.
    pub end: At,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SectionKind {
    Input,
    Output,
    Local,
    Global,
}

/// One VAR .. END_VAR.
#[derive(Debug)]
pub(crate) struct Section {
    pub kind: SectionKind,
    pub retention: Retention,
    pub constant: bool,
    pub variables: Vec<VarDecl>,
    pub at: At,
}

#[derive(Debug)]
pub(crate) struct VarDecl {
    pub name: Name,
    /// Text of the address behind AT.
    pub address: Option<(String, At)>,
    pub ty: TypeRef,
    pub initial: Option<Initial>,
}

#[derive(Clone, Debug)]
pub(crate) enum Initial {
    One(Expr),
    /// `[1, 2, 3(0)]`: values with their number of repetitions.
    List(Vec<(Option<Expr>, Expr)>, At),
}

#[derive(Clone, Debug)]
pub(crate) enum TypeRef {
    Named(Name),
    Array { ranges: Vec<(Expr, Expr)>, of: Name, at: At },
}

impl TypeRef {
    pub fn at(&self) -> At {
        match self {
            TypeRef::Named(name) => name.at,
            TypeRef::Array { at, .. } => *at,
        }
    }
}

#[derive(Clone, Debug)]
pub(crate) struct Expr {
    pub kind: ExprKind,
    pub at: At,
}

#[derive(Clone, Debug)]
pub(crate) enum ExprKind {
    /// A number, of a type where it is written with one.
    Number(i128, Option<Elementary>),
    Bool(bool),
    /// Milliseconds.
    Duration(i64),
    Path(Path),
    /// A direct address.
    Direct(String),
    Unary(UnaryOp, Box<Expr>),
    /// Operators of one level, from left to right.
    Chain(Box<Expr>, Vec<(BinaryOp, At, Expr)>),
    Call(Name, Vec<Argument>),
    /// What was reported already.
    Wrong,
}

#[derive(Clone, Debug)]
pub(crate) struct Path {
    pub root: Name,
    pub rest: Vec<Segment>,
    pub at: At,
}

#[derive(Clone, Debug)]
pub(crate) enum Segment {
    Member(Name),
    Index(Vec<Expr>, At),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum UnaryOp {
    Not,
    Minus,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BinaryOp {
    Or,
    Xor,
    And,
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
}

impl BinaryOp {
    pub fn text(self) -> &'static str {
        match self {
            BinaryOp::Or => "OR",
            BinaryOp::Xor => "XOR",
            BinaryOp::And => "AND",
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
        }
    }
}

#[derive(Clone, Debug)]
pub(crate) enum Argument {
    Positional(Expr),
    /// `name := value`.
    Input(Name, Expr),
    /// `name => target`.
    Output(Name, Expr),
}

#[derive(Debug)]
pub(crate) struct Stmt {
    pub kind: StmtKind,
    pub at: At,
}

#[derive(Debug)]
pub(crate) enum StmtKind {
    Assign { target: Expr, value: Expr },
    Call(Path, Vec<Argument>),
    If { arms: Vec<(Expr, Vec<Stmt>)>, otherwise: Vec<Stmt> },
    Case { selector: Expr, arms: Vec<(Vec<CaseLabel>, Vec<Stmt>)>, otherwise: Vec<Stmt> },
    For(Box<Counted>),
    While { condition: Expr, body: Vec<Stmt>, end: At },
    Repeat { body: Vec<Stmt>, until: Expr },
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
    pub end: At,
}

#[derive(Debug)]
pub(crate) struct CaseLabel {
    pub low: Expr,
    pub high: Option<Expr>,
}

/// Everything that the sources declare.
#[derive(Debug, Default)]
pub(crate) struct Unit {
    pub pous: Vec<Pou>,
    pub globals: Vec<Section>,
}
