//! Trees made by hand, run by the machine: results, and times against the tables of [`Costs`].

use super::emit;
use crate::code::{Op, map};
use crate::findings::{CompileFindings, SourcePlace};
use crate::host::{Host, StopReason};
use crate::machine::Machine;
use crate::options::Options;
use crate::program::Program;
use crate::tree::*;
use crate::types::Elementary::{self, Bool, Dint, Int, Lint, Lreal, Real};
use signal::{Address, Span, Time};
use std::sync::Arc;

mod calls;
mod loops;
mod values;

struct NoHost;

impl Host for NoHost {
    fn load(&mut self, _: Address) -> u64 {
        0
    }

    fn store(&mut self, _: Address, _: u64, _: u16, _: u32) -> bool {
        false
    }
}

const AT: SourcePlace = SourcePlace { file: 0, start: 0, end: 0 };

fn one(ty: Elementary) -> Ty {
    Ty::Scalar(ty)
}

fn place(root: TreeRoot, offset: u32, ty: Ty) -> TreePlace {
    TreePlace { root, offset, indices: Vec::new(), ty, retained: false, at: AT }
}

/// The variable at an offset of the variables.
fn global(offset: u32, ty: Elementary) -> TreePlace {
    place(TreeRoot::Absolute, map::FIRST + offset, one(ty))
}

fn element(array: u32, index: Expr, low: i64, high: i64, ty: Elementary) -> TreePlace {
    let index = Index { value: index, low, high, stride: ty.bytes() as u32 };
    TreePlace { indices: vec![index], ..global(array, ty) }
}

fn load(place: TreePlace) -> Expr {
    Expr { ty: place.ty, kind: ExprKind::Load(place), at: AT }
}

fn number(n: i64, ty: Elementary) -> Expr {
    Expr { kind: ExprKind::Constant(n), ty: one(ty), at: AT }
}

fn typed(kind: ExprKind, ty: Ty) -> Expr {
    Expr { kind, ty, at: AT }
}

fn binary(op: BinaryOp, a: Expr, b: Expr, ty: Elementary) -> Expr {
    typed(ExprKind::Binary(op, Box::new(a), Box::new(b)), one(ty))
}

fn stmt(kind: StmtKind) -> Stmt {
    Stmt { kind, at: AT }
}

fn set(to: TreePlace, value: Expr) -> Stmt {
    stmt(StmtKind::Assign(Target::Place(to), value))
}

fn unit(name: &str, frame: u32, body: Vec<Stmt>) -> UnitTree {
    UnitTree { name: name.into(), frame: vec![0; frame as usize], body, ..UnitTree::default() }
}

/// The first unit is the program.
fn program(units: Vec<UnitTree>) -> Tree {
    Tree {
        units,
        programs: vec![0],
        program_names: vec!["MAIN".into()],
        variables: vec![0; 256],
        ..Tree::default()
    }
}

fn made(tree: Tree) -> Program {
    let sources = [document::SourceFile { name: "a.st".into(), text: "a\n".into() }];
    let mut findings = CompileFindings::new(&sources, 10);
    let program = emit(tree, &Options::default(), &mut findings, &sources);
    assert!(!findings.failed(), "{:?}", findings.finish());
    program
}

/// Memory after one cycle, and what it took.
struct Ran {
    machine: Machine,
    nanos: i64,
}

impl Ran {
    fn cell(&self, offset: u32, ty: Elementary) -> i64 {
        let at = (map::FIRST + offset) as usize;
        let bytes = &self.machine.memory()[at..at + ty.bytes()];
        ty.wrap(bytes.iter().rev().fold(0u64, |n, byte| n << 8 | u64::from(*byte)) as i64)
    }
}

fn run_tree(tree: Tree) -> Ran {
    ran(made(tree))
}

fn ran(program: Program) -> Ran {
    let mut machine = Machine::new(Arc::new(program), &[vec![0]]).unwrap();
    machine.begin(0);
    let slice = machine.resume(0, Time::ZERO, Span::from_secs(1), &mut NoHost);
    assert_eq!(slice.stop, StopReason::Done);
    Ran { machine, nanos: slice.used.as_nanos() }
}

fn run(body: Vec<Stmt>) -> Ran {
    run_tree(program(vec![unit("MAIN", 0, body)]))
}

/// Sets variables without being counted, then runs the body: the time of the body alone.
fn run_after(before: Vec<Stmt>, body: Vec<Stmt>) -> Ran {
    let first = run(before.clone()).nanos;
    let ran = run(before.into_iter().chain(body).collect());
    Ran { nanos: ran.nanos - first, ..ran }
}

fn operations(body: Vec<Stmt>) -> Vec<Op> {
    made(program(vec![unit("MAIN", 0, body)])).code.iter().map(|step| step.op).collect()
}
