//! Statements.

use super::expr::survey;
use super::frame::{CodeLabel, Loop};
use super::{Dest, Emitter, Value, ops};
use crate::code::{Op, Operand, Statement};
use crate::findings::SourcePlace;
use crate::tree::{CaseArm, Expr, ExprKind, For, Stmt, StmtKind, Ty};
use crate::types::Elementary;

const LINT: Ty = Ty::Scalar(Elementary::Lint);
/// Parts of a condition of WHILE that is worth being there twice.
const SMALL: usize = 16;

impl Emitter<'_, '_, '_> {
    /// Statements of the source.
    pub(super) fn statements(&mut self, list: &[Stmt]) {
        for statement in list {
            let place = self.statements.len();
            let pc = self.code.len() as u32;
            let line = self.line(statement.at);
            self.statements.push(Statement { pc, file: statement.at.file, line });
            self.statement(statement);
            if self.code.len() as u32 == pc {
                // Nothing to stop at.
                self.statements.truncate(place);
            }
        }
    }

    /// Statements inside an expression, where nothing stops.
    pub(super) fn run(&mut self, list: &[Stmt]) {
        for statement in list {
            self.statement(statement);
        }
    }

    fn statement(&mut self, statement: &Stmt) {
        let at = statement.at;
        let mark = self.mark();
        match &statement.kind {
            StmtKind::Assign(target, value) => {
                let aim = self.aim(target);
                self.assign(aim, value, at);
            }
            StmtKind::Call(call) => {
                self.value(call);
            }
            StmtKind::If { arms, otherwise } => self.if_statement(arms, otherwise, at),
            StmtKind::Case { selector, arms, otherwise } => {
                self.case_statement(selector, arms, otherwise, at)
            }
            StmtKind::For(counted) => self.for_statement(counted),
            StmtKind::While { condition, body, end } => self.while_statement(condition, body, *end),
            StmtKind::Repeat { body, until } => {
                let top = self.label();
                self.bind(top);
                let ends = self.body(body);
                self.bind(ends.next);
                self.jump_if(until, false, top, self.costs.turn());
                self.bind(ends.exit);
            }
            StmtKind::Exit | StmtKind::Continue => {
                if let Some(innermost) = self.unit.loops.last().copied() {
                    let to = if matches!(statement.kind, StmtKind::Exit) {
                        innermost.exit
                    } else {
                        innermost.next
                    };
                    self.go(to, at);
                }
            }
            StmtKind::Return => self.push(Op::Return, (0, 0, 0), 0, at),
        }
        self.release(mark);
    }

    fn go(&mut self, to: CodeLabel, at: SourcePlace) {
        self.jump(Op::Jump, to, [Operand(0); 2], 0, at);
    }

    /// The body of a loop.
    fn body(&mut self, body: &[Stmt]) -> Loop {
        let ends = Loop { exit: self.label(), next: self.label() };
        self.unit.loops.push(ends);
        self.statements(body);
        self.unit.loops.pop();
        ends
    }

    /// The condition is tested before the first turn and, where it is small, again at the end of each.
    fn while_statement(&mut self, condition: &Expr, body: &[Stmt], end: SourcePlace) {
        let known = survey(condition);
        let (top, leave) = (self.label(), self.label());
        let (branch, turn) = (self.costs.branch, self.costs.turn());
        if known.effects || known.parts > SMALL {
            self.bind(top);
            self.jump_if(condition, false, leave, branch);
            let ends = self.body(body);
            self.bind(ends.next);
            self.jump(Op::Jump, top, [Operand(0); 2], turn, end);
            self.bind(ends.exit);
        } else {
            self.jump_if(condition, false, leave, branch);
            self.bind(top);
            let ends = self.body(body);
            self.bind(ends.next);
            self.jump_if(condition, true, top, branch.saturating_add(turn));
            self.bind(ends.exit);
        }
        self.bind(leave);
    }

    fn if_statement(&mut self, arms: &[(Expr, Vec<Stmt>)], otherwise: &[Stmt], at: SourcePlace) {
        let end = self.label();
        for (nth, (condition, body)) in arms.iter().enumerate() {
            let next = self.label();
            self.jump_if(condition, false, next, self.costs.branch);
            self.statements(body);
            if nth + 1 < arms.len() || !otherwise.is_empty() {
                self.go(end, at);
            }
            self.bind(next);
        }
        self.statements(otherwise);
        self.bind(end);
    }

    /// Labels are tested one by one, as their costs say.
    fn case_statement(&mut self, selector: &Expr, arms: &[CaseArm], otherwise: &[Stmt], at: SourcePlace) {
        let chosen = self.value(selector);
        // A variable is read once.
        let chosen = self.stable(chosen, selector.at);
        if chosen.cost > 0 {
            let to = Dest { at: self.temporary(chosen.ty), ty: chosen.ty, cost: 0 };
            self.transfer(to, chosen, 0, selector.at);
        }
        let chosen = Value { cost: 0, ..chosen };
        let end = self.label();
        for (nth, (labels, body)) in arms.iter().enumerate() {
            let (hit, next) = (self.label(), self.label());
            for (nth, range) in labels.iter().enumerate() {
                self.test_label(chosen, *range, nth + 1 == labels.len(), (hit, next), selector.at);
            }
            self.bind(hit);
            self.statements(body);
            if nth + 1 < arms.len() || !otherwise.is_empty() {
                self.go(end, at);
            }
            self.bind(next);
        }
        self.statements(otherwise);
        self.bind(end);
    }

    /// Goes to `hit` if the number is in the range; else on, or to `next` after the last label.
    fn test_label(
        &mut self,
        chosen: Value,
        (low, high): (i128, i128),
        last: bool,
        (hit, next): (CodeLabel, CodeLabel),
        at: SourcePlace,
    ) {
        let ty = ops::scalar(chosen.ty);
        let cost = self.costs.op(ops::priced(chosen.ty)).saturating_add(self.costs.branch);
        let low_at = self.constant(low as i64, chosen.ty).at;
        if low == high {
            let (op, to) = if last {
                (ops::CompareRelation::NotEqual, next)
            } else {
                (ops::CompareRelation::Equal, hit)
            };
            return self.jump(ops::jump(op, ty, true).0, to, [chosen.at, low_at], cost, at);
        }
        let high_at = self.constant(high as i64, chosen.ty).at;
        let below = if last { next } else { self.label() };
        let less = ops::jump(ops::CompareRelation::Less, ty, true).0;
        self.jump(less, below, [chosen.at, low_at], cost, at);
        if last {
            self.jump(less, next, [high_at, chosen.at], cost, at);
        } else {
            self.jump(
                ops::jump(ops::CompareRelation::LessEqual, ty, true).0,
                hit,
                [chosen.at, high_at],
                cost,
                at,
            );
            self.bind(below);
        }
    }

    /// FOR. The step is computed once, the end before each turn. A turn costs a comparison and a branch at its start, an
    /// addition and a turn at its end; where one operation does both at the end, it bears both. What reading a variable
    /// as the end costs is charged before the first turn; for the others it is in the price of a turn.
    fn for_statement(&mut self, counted: &For) {
        let variable = self.destination(&counted.variable);
        let ty = ops::scalar(variable.ty);
        self.store(&counted.from, variable);
        let step = match counted.by.as_ref().map(|by| (constant(by), by)) {
            None => LoopStep::Constant(1),
            Some((Some(n), _)) => LoopStep::Constant(n),
            Some((None, by)) => {
                let at = self.temporary(LINT);
                self.store(by, Dest { at, ty: LINT, cost: 0 });
                LoopStep::Computed(at)
            }
        };
        let kept = if counted.variable.retained { self.costs.retained } else { 0 };
        let op = self.costs.op(ty);
        let load = self.costs.load(ty).saturating_add(kept);
        let store = self.costs.store(ty).saturating_add(kept);
        let test = load.saturating_add(op).saturating_add(self.costs.branch);
        let turn = load.saturating_add(op).saturating_add(store).saturating_add(self.costs.turn());
        let (top, leave) = (self.label(), self.label());
        let first = LoopTest { within: false, to: leave, cost: test, at: counted.to.at };
        self.for_test(counted, variable, step, first);
        self.bind(top);
        let ends = self.body(&counted.body);
        self.bind(ends.next);
        if let (LoopStep::Constant(1), true) = (step, is_plain_end(&counted.to, variable.ty)) {
            let end = self.value(&counted.to);
            self.jump(ops::counted(ty), top, [variable.at, end.at], turn.saturating_add(test), counted.end);
        } else {
            let by = match step {
                LoopStep::Constant(n) => self.constant(ty.wrap(n), variable.ty).at,
                // Its low bits.
                LoopStep::Computed(by) => by,
            };
            self.operate(ops::add(ty), [variable.at, variable.at, by], turn, counted.end);
            let again = LoopTest { within: true, to: top, cost: test, at: counted.end };
            self.for_test(counted, variable, step, again);
        }
        self.bind(ends.exit);
        self.bind(leave);
    }

    /// Computes the end, and jumps by whether the variable is beyond it.
    fn for_test(&mut self, counted: &For, variable: Dest, step: LoopStep, test: LoopTest) {
        let (at, mark) = (test.at, self.mark());
        let end = self.value(&counted.to);
        let mut own = Value { at: variable.at, ty: variable.ty, cost: 0, fixed: false };
        if end.ty != own.ty {
            // The end has more bits than the variable.
            let to = Dest { at: self.temporary(end.ty), ty: end.ty, cost: 0 };
            self.convert(own, to, 0, at);
            own = Value { at: to.at, ty: end.ty, cost: 0, fixed: true };
        }
        let relation = if test.within { ops::CompareRelation::LessEqual } else { ops::CompareRelation::Less };
        let jump = ops::jump(relation, ops::scalar(end.ty), true).0;
        let read = if test.within && is_plain_end(&counted.to, variable.ty) { 0 } else { end.cost };
        let cost = test.cost.saturating_add(read);
        let upwards = if test.within { [own.at, end.at] } else { [end.at, own.at] };
        let downwards = [upwards[1], upwards[0]];
        match step {
            LoopStep::Constant(n) => {
                self.jump(jump, test.to, if n >= 0 { upwards } else { downwards }, cost, at);
            }
            LoopStep::Computed(by) => {
                let (down, out) = (self.label(), self.label());
                let zero = self.constant(0, LINT).at;
                self.jump(Op::JumpLtI64, down, [by, zero], cost, at);
                self.jump(jump, test.to, upwards, 0, at);
                self.go(out, at);
                self.bind(down);
                self.jump(jump, test.to, downwards, 0, at);
                self.bind(out);
            }
        }
        self.release(mark);
    }
}

/// How FOR counts.
#[derive(Clone, Copy, Debug)]
enum LoopStep {
    Constant(i64),
    /// Computed into a variable of LINT.
    Computed(Operand),
}

/// A test of FOR.
#[derive(Clone, Copy, Debug)]
struct LoopTest {
    /// It jumps where the variable is not beyond the end; else where it is.
    within: bool,
    to: CodeLabel,
    cost: u32,
    at: SourcePlace,
}

/// Whether the end of FOR is a number or a variable that stands ready, of the control variable's type.
fn is_plain_end(end: &Expr, ty: Ty) -> bool {
    let ready = match &end.kind {
        ExprKind::Constant(_) => true,
        ExprKind::Load(place) => place.is_direct(),
        _ => false,
    };
    ready && end.ty == ty
}

fn constant(expr: &Expr) -> Option<i64> {
    match expr.kind {
        ExprKind::Constant(cell) => Some(cell),
        _ => None,
    }
}
