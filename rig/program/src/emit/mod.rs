//! From the checked program to operations on three addresses.
//!
//! The value of an expression stays where it is as long as possible: operations read variables and constants in
//! place and write straight to the destination. Each cost of the source lands on exactly one operation: what reading a
//! variable costs goes to the operation that uses it. So the modelled time does not depend on how well code is made.

mod call;
mod condition;
mod convert;
mod expr;
mod frame;
mod ops;
mod place;
mod pool;
mod stmt;
#[cfg(test)]
mod tests;

use crate::code::{CodeStep, CodeUnit, IndexOf, LibraryCall, Op, Operand, Statement, TextPair, map};
use crate::codes::Code;
use crate::findings::{CompileFindings, SourcePlace};
use crate::options::{Costs, Options, ProgramLimits};
use crate::program::Program;
use crate::tree::{Tree, Ty, UnitTree};
use frame::RunningLoop;
use pool::Pool;
use std::collections::BTreeMap;

/// Bytes that the frame of one unit may have.
const FRAME_LIMIT: u32 = 1 << 20;

/// A value where it stands.
#[derive(Clone, Copy, Debug)]
struct Value {
    at: Operand,
    ty: Ty,
    /// What is still to be charged for reading it, by the operation that does.
    cost: u32,
    /// Nothing that is computed later changes it: a constant or a temporary.
    fixed: bool,
}

/// Where a value goes.
#[derive(Clone, Copy, Debug)]
struct Dest {
    at: Operand,
    ty: Ty,
    /// What the operation that writes it is to charge for that.
    cost: u32,
}

/// What code is made with.
struct Emitter<'t, 'f, 's> {
    tree: &'t Tree,
    costs: Costs,
    limits: ProgramLimits,
    findings: &'f mut CompileFindings<'s>,
    /// Starts of the lines of each source.
    starts: Vec<Vec<u32>>,
    code: Vec<CodeStep>,
    lines: Vec<u32>,
    indexes: Vec<IndexOf>,
    texts: Vec<TextPair>,
    library: Vec<LibraryCall>,
    statements: Vec<Statement>,
    pool: Pool,
    /// The units that a virtual call of each selector may reach.
    reached: BTreeMap<u32, Vec<u16>>,
    /// The unit that is being made.
    unit: RunningLoop,
    /// Too much code was reported.
    full: bool,
}

/// Makes the code of a checked program. What is derived from the variables is left empty.
pub(crate) fn emit(
    tree: Tree,
    options: &Options,
    findings: &mut CompileFindings<'_>,
    sources: &[document::SourceFile],
) -> Program {
    let variables = u32::try_from(tree.variables.len()).unwrap_or(u32::MAX);
    // Room, so that no store to a variable comes near what is read only: the machine looks closer there.
    let variables_to = map::FIRST.saturating_add(variables).saturating_add(16) / 8 * 8;
    let mut emitter = Emitter {
        tree: &tree,
        costs: options.costs,
        limits: options.limits,
        findings,
        starts: sources.iter().map(|source| line_starts(&source.text)).collect(),
        code: Vec::new(),
        lines: Vec::new(),
        indexes: Vec::new(),
        texts: Vec::new(),
        library: Vec::new(),
        statements: Vec::new(),
        pool: Pool::new(variables_to),
        reached: reached(&tree),
        unit: RunningLoop::default(),
        full: false,
    };
    if tree.units.len() > usize::from(u16::MAX) {
        let message = format!("the application has {} units", tree.units.len());
        let help = "at most 65535 programs, functions, blocks and methods are compiled together";
        emitter.findings.error(Code::Length, SourcePlace::default(), message, help);
    }
    let units = tree.units.iter().map(|unit| emitter.unit(unit)).collect();
    emitter.check_memory(variables_to);
    let Emitter { code, lines, indexes, texts, library, statements, pool, .. } = emitter;
    let mut image = vec![0; map::FIRST as usize];
    image.extend_from_slice(&tree.variables);
    image.resize(variables_to as usize, 0);
    image.extend_from_slice(&pool.bytes);
    Program {
        code,
        lines,
        indexes,
        texts,
        library,
        units,
        natives: tree.natives,
        classes: tree.classes,
        kinds: tree.kinds,
        statements,
        located: tree.located,
        programs: tree.programs,
        program_names: tree.program_names,
        image,
        variables_from: map::FIRST,
        variables_to,
        limits: options.limits.addresses,
        retained: tree.retained,
        roots: tree.roots,
        shapes: tree.shapes,
        tasks: tree.tasks,
        pins: tree.pins,
        images: tree.images,
        lreal: tree.lreal,
        variables: Vec::new(),
        index: BTreeMap::new(),
        files: sources.iter().map(|source| source.name.clone()).collect(),
        digest: [0; 32],
        layout: [0; 8],
        kept: Vec::new(),
        declarations: [0; 8],
        warnings: Vec::new(),
    }
}

fn line_starts(text: &str) -> Vec<u32> {
    let breaks = text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n');
    std::iter::once(0).chain(breaks.map(|(at, _)| at as u32 + 1)).collect()
}

/// The units of each selector, over all classes.
fn reached(tree: &Tree) -> BTreeMap<u32, Vec<u16>> {
    let mut reached: BTreeMap<u32, Vec<u16>> = BTreeMap::new();
    for class in &tree.classes {
        for (selector, unit) in (0u32..).zip(&class.methods) {
            if let Some(unit) = unit {
                reached.entry(selector).or_default().push(*unit);
            }
        }
    }
    for units in reached.values_mut() {
        units.sort_unstable();
        units.dedup();
    }
    reached
}

impl Emitter<'_, '_, '_> {
    fn line(&self, at: SourcePlace) -> u32 {
        let starts = self.starts.get(usize::from(at.file)).map_or(&[][..], Vec::as_slice);
        starts.partition_point(|start| *start <= at.start) as u32
    }

    /// Adds an operation.
    fn push(&mut self, op: Op, (a, b, c): (u32, u32, u32), cost: u32, at: SourcePlace) {
        if self.code.len() >= self.limits.code {
            if !std::mem::replace(&mut self.full, true) {
                let message = format!("the program has more than {} operations", self.limits.code);
                self.findings.error(Code::Length, at, message, "split it into applications");
            }
            return;
        }
        let line = self.line(at);
        self.code.push(CodeStep { op, a, b, c, cost });
        self.lines.push(line);
    }

    /// An operation on places.
    fn operate(&mut self, op: Op, [a, b, c]: [Operand; 3], cost: u32, at: SourcePlace) {
        self.push(op, (a.0, b.0, c.0), cost, at);
    }

    fn unit(&mut self, unit: &UnitTree) -> CodeUnit {
        self.unit = RunningLoop::new(unit);
        let entry = self.code.len() as u32;
        let tables = (self.indexes.len(), self.texts.len(), self.library.len());
        self.statements(&unit.body);
        self.push(Op::Return, (0, 0, 0), 0, unit.end);
        if self.unit.most > FRAME_LIMIT {
            let message = format!("`{}` needs {} bytes for its variables", unit.name, self.unit.most);
            let help = format!("at most {FRAME_LIMIT} are allowed: declare large arrays global");
            self.findings.error(Code::DataSize, unit.end, message, help);
        }
        let frame = self.unit.most.min(FRAME_LIMIT);
        self.resolve(entry as usize, tables, frame);
        let running = std::mem::take(&mut self.unit);
        CodeUnit {
            name: unit.name.clone(),
            file: unit.file,
            entry,
            frame,
            template: unit.frame.clone(),
            calls: unique(running.calls),
            writes: unique(running.writes),
            reads: unique(running.reads),
        }
    }

    fn check_memory(&mut self, variables_to: u32) {
        let size = (variables_to as usize).saturating_add(self.pool.bytes.len());
        let limit = self.limits.memory.min(map::OWN_END);
        if size > limit as usize {
            let message = format!("variables and constants need {size} bytes");
            self.findings.error(
                Code::DataSize,
                SourcePlace::default(),
                message,
                format!("there are {limit}"),
            );
        }
    }
}

/// In order and each once.
fn unique<T: Ord>(mut list: Vec<T>) -> Vec<T> {
    list.sort_unstable();
    list.dedup();
    list
}
