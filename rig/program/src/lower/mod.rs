//! From the syntax tree to code: names, types, layout and operations in one pass over each unit.
//!
//! A cell holds the same bits for a value whatever integer type it has, so widening needs no code, and an expression can
//! be emitted while its type is being found.

mod call;
mod declare;
mod expr;
mod finish;
mod fold;
mod layout;
mod located;
mod place;
mod standard;
mod stmt;

use crate::code::{Bounds, Need, Op, Step, Unit};
use crate::codes::Code;
use crate::findings::{At, Findings};
use crate::native::Native;
use crate::options::Options;
use crate::parse::ast::{self, PouKind, SectionKind};
use crate::program::{Located, Program, Retention};
use crate::types::Elementary;
use document::{Diagnostic, SourceFile};
use layout::Cells;
use signal::Address;
use std::collections::BTreeMap;

/// The type of a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Type {
    One(Elementary),
    /// Of the table of arrays.
    Array(u32),
    /// A FUNCTION_BLOCK, by its unit.
    Block(u16),
    /// A native block, by its place in the options.
    Native(u16),
    /// Was reported.
    Wrong,
}

/// Elements of one type, laid out row by row.
#[derive(Clone, Debug)]
struct ArrayType {
    of: Type,
    dimensions: Vec<(i64, i64)>,
    /// Cells in all.
    size: u32,
    /// The first entry of `bounds`, one a dimension.
    bounds: u32,
}

/// Where a variable is, seen from its own unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Home {
    Absolute(u32),
    /// Of the instance of the block.
    Member(u32),
    Frame(u32),
    Located(u32),
}

#[derive(Clone, Copy, Debug)]
enum Symbol {
    /// An elementary constant: the number, and 0 or 1 for BOOL.
    Constant(i128, Elementary),
    Variable {
        ty: Type,
        home: Home,
        retention: Retention,
        /// An array of constants.
        constant: bool,
    },
}

#[derive(Clone, Debug)]
struct Member {
    name: String,
    at: At,
    kind: SectionKind,
    symbol: Symbol,
    /// Whether it is declared with an initial value.
    given: bool,
}

/// Names of a unit, or the global ones, in the order of declaration.
#[derive(Debug, Default)]
struct Scope {
    members: Vec<Member>,
    index: BTreeMap<String, usize>,
}

impl Scope {
    fn get(&self, key: &str) -> Option<&Member> {
        self.index.get(key).and_then(|place| self.members.get(*place))
    }
}

/// How far the declarations of a unit have been read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Progress {
    Waiting,
    Reading,
    Ready,
}

#[derive(Debug)]
struct Pou {
    kind: PouKind,
    name: String,
    at: At,
    scope: Scope,
    progress: Progress,
    /// Of a function.
    result: Type,
    /// Of an instance, or of a function's frame.
    cells: Cells,
    /// Blocks inside each other, this one included.
    level: u32,
}

/// A loop whose end is not known yet.
#[derive(Debug, Default)]
struct Loop {
    exits: Vec<usize>,
    continues: Vec<usize>,
}

/// What is known while one unit is being emitted.
#[derive(Debug, Default)]
struct Context {
    /// Operands now and at most.
    depth: u32,
    deepest: u32,
    /// Frame cells in use and at most.
    frame: u32,
    frame_max: u32,
    /// Units called and the operands at the call.
    calls: Vec<(u16, u32)>,
    /// Entries of the located places written.
    writes: Vec<u32>,
    loops: Vec<Loop>,
    /// The unit whose names are seen.
    pou: Option<usize>,
}

struct Compiler<'s> {
    options: &'s Options,
    findings: Findings<'s>,
    /// Starts of the lines of each source.
    lines: Vec<Vec<u32>>,
    pous: Vec<Pou>,
    pou_index: BTreeMap<String, usize>,
    /// Units whose declarations are being read inside each other.
    declaring: u32,
    /// A constant is being computed.
    in_constant: bool,
    globals: Scope,
    arrays: Vec<ArrayType>,
    /// Memory of globals and programs.
    cells: Cells,
    code: Vec<Step>,
    wide: Vec<i64>,
    wide_index: BTreeMap<i64, u32>,
    bounds: Vec<Bounds>,
    units: Vec<Unit>,
    calls: Vec<Vec<(u16, u32)>>,
    located: Vec<Located>,
    located_index: BTreeMap<(Address, Elementary), u32>,
    context: Context,
}

/// Reads and lowers the sources.
pub(crate) fn compile(sources: &[SourceFile], options: &Options) -> Result<Program, Vec<Diagnostic>> {
    let mut findings = Findings::new(sources, options.limits.errors);
    let mut tree = ast::Unit::default();
    let size: usize = sources.iter().map(|source| source.text.len()).sum();
    if size > options.limits.source || sources.len() > 255 {
        let message = format!("{} sources of {size} bytes in all", sources.len());
        let help = format!("at most 255 sources of {} bytes in all are compiled", options.limits.source);
        findings.error(Code::SourceSize, At::default(), message, help);
        return Err(findings.finish());
    }
    for (file, source) in sources.iter().enumerate() {
        crate::parse::parse(file as u8, &source.text, &mut findings, &mut tree);
    }
    if findings.failed() {
        // A tree with faults has holes: what is missing would be reported as unknown.
        return Err(findings.finish());
    }
    let mut compiler = Compiler {
        options,
        findings,
        lines: sources.iter().map(|source| line_starts(&source.text)).collect(),
        pous: Vec::new(),
        pou_index: BTreeMap::new(),
        declaring: 0,
        in_constant: false,
        globals: Scope::default(),
        arrays: Vec::new(),
        cells: Cells::default(),
        code: Vec::new(),
        wide: Vec::new(),
        wide_index: BTreeMap::new(),
        bounds: Vec::new(),
        units: Vec::new(),
        calls: Vec::new(),
        located: Vec::new(),
        located_index: BTreeMap::new(),
        context: Context::default(),
    };
    compiler.declare(&tree);
    for (place, pou) in tree.pous.iter().enumerate() {
        if compiler.findings.full() {
            break;
        }
        compiler.body(place, pou);
    }
    compiler.finish(sources)
}

fn line_starts(text: &str) -> Vec<u32> {
    std::iter::once(0)
        .chain(text.bytes().enumerate().filter(|(_, b)| *b == b'\n').map(|(at, _)| at as u32 + 1))
        .collect()
}

impl Compiler<'_> {
    fn line(&self, at: At) -> u32 {
        let starts = self.lines.get(usize::from(at.file)).map_or(&[][..], Vec::as_slice);
        starts.partition_point(|start| *start <= at.start) as u32
    }

    fn native(&self, place: u16) -> Option<&'static Native> {
        self.options.blocks.get(usize::from(place))
    }

    /// Adds an operation and keeps account of the operands.
    fn emit(&mut self, op: Op, cost: u32, at: At) -> usize {
        let place = self.code.len();
        if place >= self.options.limits.code {
            if place == self.options.limits.code {
                let message = format!("the program has more than {place} operations");
                self.findings.error(Code::Length, at, message, "split it into applications");
            } else {
                return place - 1;
            }
        }
        let line = self.line(at);
        self.code.push(Step { op, cost, line });
        let depth = i64::from(self.context.depth) + effect(op);
        self.context.depth = depth.max(0) as u32;
        self.context.deepest = self.context.deepest.max(self.context.depth);
        place
    }

    /// The next operation will be the target of what `place` emitted.
    fn patch(&mut self, place: usize) {
        let here = self.code.len() as u32;
        self.patch_to(place, here);
    }

    fn patch_to(&mut self, place: usize, target: u32) {
        if let Some(step) = self.code.get_mut(place) {
            match &mut step.op {
                Op::Jump(to) | Op::JumpIf(to) | Op::JumpIfNot(to) | Op::NextOrJump(_, to) => *to = target,
                _ => {}
            }
        }
    }

    /// A frame cell for what the compiler keeps there.
    fn temporary(&mut self) -> u32 {
        let place = self.context.frame;
        self.context.frame += 1;
        self.context.frame_max = self.context.frame_max.max(self.context.frame);
        place
    }

    /// Emits the body of a unit.
    fn body(&mut self, place: usize, pou: &ast::Pou) {
        let Some(info) = self.pous.get(place) else { return };
        let function = info.kind == PouKind::Function;
        let declared = if function { info.cells.initial.len() as u32 } else { 0 };
        let template = if function { info.cells.initial.clone() } else { Vec::new() };
        let inputs =
            info.scope.members.iter().filter(|m| function && m.kind == SectionKind::Input).count() as u32;
        let name = info.name.clone();
        self.context =
            Context { pou: Some(place), frame: declared, frame_max: declared, ..Context::default() };
        let entry = self.code.len() as u32;
        self.statements(&pou.body);
        self.emit(Op::Return, 0, pou.end);
        let context = std::mem::take(&mut self.context);
        self.units.push(Unit {
            name,
            file: pou.name.at.file,
            entry,
            frame: context.frame_max,
            inputs,
            template,
            has_result: function,
            calls: unique(context.calls.iter().map(|(callee, _)| *callee).collect()),
            writes: unique(context.writes),
            need: Need { operands: context.deepest, frame: context.frame_max, calls: 0 },
        });
        self.calls.push(context.calls);
    }
}

/// In order and each once.
fn unique<T: Ord>(mut list: Vec<T>) -> Vec<T> {
    list.sort();
    list.dedup();
    list
}

/// What an operation does to the number of operands. Calls of functions are accounted for by the caller.
fn effect(op: Op) -> i64 {
    match op {
        Op::Const(_) | Op::Wide(_) | Op::Load(_) | Op::LoadThis(_) | Op::LoadLocal(_) | Op::LoadIo(_) => 1,
        Op::Store(_) | Op::StoreThis(_) | Op::StoreLocal(_) | Op::StoreIo(_) => -1,
        Op::StoreAt(_) | Op::StoreThisAt(_) | Op::StoreLocalAt(_) | Op::Sel | Op::Within(_) => -2,
        Op::Add(_) | Op::Sub(_) | Op::Mul(_) | Op::Div(_) | Op::Mod(_) | Op::And | Op::Or | Op::Xor => -1,
        Op::Eq | Op::Ne | Op::Lt | Op::Le | Op::Gt | Op::Ge => -1,
        Op::LtWide | Op::LeWide | Op::GtWide | Op::GeWide => -1,
        Op::Min | Op::Max | Op::MinWide | Op::MaxWide => -1,
        Op::Shl(_) | Op::Shr(_) | Op::Rol(_) | Op::Ror(_) => -1,
        Op::JumpIf(_) | Op::JumpIfNot(_) | Op::NextOrJump(..) => -1,
        Op::CallBlockAt(..) | Op::CallBlockThisAt(..) | Op::CallNativeAt(..) | Op::CallNativeThisAt(..) => -1,
        _ => 0,
    }
}
