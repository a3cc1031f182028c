//! Statements.

use super::call::CONDITION;
use super::fold::Operand;
use super::place::Place;
use super::{Compiler, Loop};
use crate::code::Op;
use crate::codes::Code;
use crate::findings::At;
use crate::parse::ast::{CaseLabel, Counted, Expr, ExprKind, Stmt, StmtKind};
use crate::types::Elementary;

impl Compiler<'_> {
    pub(super) fn statements(&mut self, list: &[Stmt]) {
        for statement in list {
            if self.findings.full() {
                return;
            }
            self.statement(statement);
        }
    }

    fn statement(&mut self, statement: &Stmt) {
        let at = statement.at;
        match &statement.kind {
            StmtKind::Assign { target, value } => self.assign(target, value),
            StmtKind::Call(path, arguments) => self.call_statement(path, arguments, at),
            StmtKind::If { arms, otherwise } => self.if_statement(arms, otherwise, at),
            StmtKind::Case { selector, arms, otherwise } => {
                self.case_statement(selector, arms, otherwise, at)
            }
            StmtKind::For(counted) => self.for_statement(counted, at),
            StmtKind::While { condition, body, end } => {
                let top = self.code.len() as u32;
                let leave = self.condition(condition);
                self.context.loops.push(Loop::default());
                self.statements(body);
                let ends = self.context.loops.pop().unwrap_or_default();
                self.patch_all(&ends.continues);
                self.emit(Op::Jump(top), self.options.costs.turn(), *end);
                self.patch(leave);
                self.patch_all(&ends.exits);
            }
            StmtKind::Repeat { body, until } => {
                let top = self.code.len() as u32;
                self.context.loops.push(Loop::default());
                self.statements(body);
                let ends = self.context.loops.pop().unwrap_or_default();
                self.patch_all(&ends.continues);
                self.boolean(until);
                self.emit(Op::JumpIfNot(top), self.options.costs.turn(), until.at);
                self.patch_all(&ends.exits);
            }
            StmtKind::Exit | StmtKind::Continue => {
                if self.context.loops.is_empty() {
                    let message = "there is no loop to leave or to go on with";
                    self.findings.error(
                        Code::OutsideLoop,
                        at,
                        message,
                        "EXIT and CONTINUE belong into FOR, WHILE or REPEAT",
                    );
                    return;
                }
                let jump = self.emit(Op::Jump(0), 0, at);
                if let Some(innermost) = self.context.loops.last_mut() {
                    let list = match statement.kind {
                        StmtKind::Exit => &mut innermost.exits,
                        _ => &mut innermost.continues,
                    };
                    list.push(jump);
                }
            }
            StmtKind::Return => {
                self.emit(Op::Return, 0, at);
            }
        }
    }

    fn patch_all(&mut self, jumps: &[usize]) {
        for jump in jumps {
            self.patch(*jump);
        }
    }

    fn assign(&mut self, target: &Expr, value: &Expr) {
        let Some(place) = self.target(target) else {
            // Faults of the value are found in the same run.
            self.expr(value);
            return;
        };
        let Some(ty) = self.elementary(&place, target.at) else { return };
        let operand = match (self.expr(value), place.loose) {
            (Operand::Stack { ty, .. }, true) => Operand::Stack { ty, loose: true },
            (operand, _) => operand,
        };
        if self.convert(operand, ty, value.at) {
            self.store(&place, ty, target.at);
        }
    }

    /// A condition on the operand stack.
    fn boolean(&mut self, condition: &Expr) {
        let operand = self.expr(condition);
        match operand {
            Operand::Wrong => {}
            _ if operand.ty() == Some(CONDITION) => self.push(operand, condition.at),
            _ => {
                let ty = operand.ty().map_or("a number", Elementary::name);
                let message = format!("a condition is BOOL, this is {ty}");
                self.findings.error(Code::Condition, condition.at, message, "compare it, as in n <> 0");
            }
        }
    }

    /// Emits a condition and the jump for its being FALSE.
    fn condition(&mut self, condition: &Expr) -> usize {
        self.boolean(condition);
        self.emit(Op::JumpIfNot(0), self.options.costs.branch, condition.at)
    }

    fn if_statement(&mut self, arms: &[(Expr, Vec<Stmt>)], otherwise: &[Stmt], at: At) {
        let mut ends = Vec::new();
        for (nth, (condition, body)) in arms.iter().enumerate() {
            let next = self.condition(condition);
            self.statements(body);
            if nth + 1 < arms.len() || !otherwise.is_empty() {
                ends.push(self.emit(Op::Jump(0), 0, at));
            }
            self.patch(next);
        }
        self.statements(otherwise);
        self.patch_all(&ends);
    }

    fn case_statement(
        &mut self,
        selector: &Expr,
        arms: &[(Vec<CaseLabel>, Vec<Stmt>)],
        otherwise: &[Stmt],
        at: At,
    ) {
        let operand = self.expr(selector);
        let ty = operand.ty().filter(|ty| ty.is_integer());
        if ty.is_none() && operand != Operand::Wrong {
            self.findings.error(
                Code::Type,
                selector.at,
                "CASE selects by a number",
                "use IF for other types",
            );
        }
        self.push(operand, selector.at);
        let chosen = self.temporary();
        self.emit(Op::StoreLocal(chosen), 0, at);
        let mut seen: Vec<(i128, i128, At)> = Vec::new();
        let mut ends = Vec::new();
        for (labels, body) in arms {
            let mut hits = Vec::new();
            for label in labels {
                let Some(ty) = ty else { continue };
                if let Some(range) = self.label(label, ty) {
                    seen.push(range);
                    hits.push(self.test_label(chosen, range, ty));
                }
            }
            let next = self.emit(Op::Jump(0), 0, at);
            self.patch_all(&hits);
            self.statements(body);
            ends.push(self.emit(Op::Jump(0), 0, at));
            self.patch(next);
        }
        self.statements(otherwise);
        self.patch_all(&ends);
        self.context.frame = chosen;
        seen.sort_by_key(|(low, high, at)| (*low, *high, at.start));
        for pair in seen.windows(2) {
            if let [(_, high, first), (low, _, second)] = pair
                && low <= high
            {
                let (first, second) =
                    if first.start < second.start { (first, second) } else { (second, first) };
                let other = (*first, "first here");
                let message = format!("{low} is a label twice");
                self.findings.error_with(
                    Code::CaseLabel,
                    *second,
                    message,
                    "each value has one place",
                    other,
                );
            }
        }
    }

    /// The values of a label, both ends included.
    fn label(&mut self, label: &CaseLabel, ty: Elementary) -> Option<(i128, i128, At)> {
        let low = self.constant_of(&label.low, ty).map(|cell| ty.number(cell))?;
        let Some(high) = &label.high else { return Some((low, low, label.low.at)) };
        let at = label.low.at.to(high.at);
        let high = self.constant_of(high, ty).map(|cell| ty.number(cell))?;
        if low > high {
            self.findings.error(
                Code::CaseLabel,
                at,
                format!("the range {low}..{high} is empty"),
                "write the lower end first",
            );
            return None;
        }
        Some((low, high, at))
    }

    /// Emits the comparison with a label; the jump to its statements.
    fn test_label(&mut self, chosen: u32, (low, high, at): (i128, i128, At), ty: Elementary) -> usize {
        let (cost, branch) = (self.options.costs.op(ty), self.options.costs.branch);
        self.emit(Op::LoadLocal(chosen), 0, at);
        if low == high {
            match i32::try_from(low) {
                Ok(n) => {
                    self.emit(Op::EqConst(n), cost, at);
                }
                Err(_) => {
                    self.push_cell(low as i64, at);
                    self.emit(Op::Eq, cost, at);
                }
            }
            return self.emit(Op::JumpIf(0), branch, at);
        }
        let wide = ty.wide_unsigned();
        self.push_cell(low as i64, at);
        self.emit(if wide { Op::GeWide } else { Op::Ge }, cost, at);
        let below = self.emit(Op::JumpIfNot(0), branch, at);
        self.emit(Op::LoadLocal(chosen), 0, at);
        self.push_cell(high as i64, at);
        self.emit(if wide { Op::LeWide } else { Op::Le }, cost, at);
        let hit = self.emit(Op::JumpIf(0), branch, at);
        self.patch(below);
        hit
    }

    /// FOR: end and step are computed once, before the first turn. The variable ends one step beyond the end, or where
    /// its type cannot hold that at its last value: there is no wrapping round.
    fn for_statement(&mut self, counted: &Counted, at: At) {
        let Some((place, ty)) = self.for_variable(&counted.variable) else { return };
        if !self.value(&counted.from, ty) {
            return;
        }
        self.store(&place, ty, counted.from.at);
        let frame = self.context.frame;
        let Some(end) = self.held(&counted.to, ty) else { return };
        let step = match &counted.by {
            None => Held::Constant(1),
            Some(by) => match self.step(by, ty) {
                Some(step) => step,
                None => return,
            },
        };
        let top = self.code.len() as u32;
        let costs = self.options.costs;
        self.load(&place, counted.variable.at);
        self.push_held(end, counted.to.at);
        let within = match step {
            Held::Constant(n) => match (n < 0, ty.wide_unsigned()) {
                (false, false) => Op::Le,
                (false, true) => Op::LeWide,
                (true, false) => Op::Ge,
                (true, true) => Op::GeWide,
            },
            Held::Frame(_) => {
                self.push_held(step, at);
                Op::Within(ty)
            }
        };
        self.emit(within, costs.op(ty), counted.to.at);
        let leave = self.emit(Op::JumpIfNot(0), costs.branch, counted.to.at);
        self.context.loops.push(Loop::default());
        self.statements(&counted.body);
        let ends = self.context.loops.pop().unwrap_or_default();
        self.patch_all(&ends.continues);
        self.load(&place, counted.end);
        self.push_held(step, counted.end);
        let beyond = self.emit(Op::NextOrJump(ty, 0), costs.op(ty), counted.end);
        self.store(&place, ty, counted.end);
        self.emit(Op::Jump(top), costs.turn(), counted.end);
        self.patch(leave);
        self.patch(beyond);
        self.patch_all(&ends.exits);
        self.context.frame = frame;
    }

    fn for_variable(&mut self, variable: &Expr) -> Option<(Place, Elementary)> {
        let place = self.target(variable)?;
        let ty = self.elementary(&place, variable.at)?;
        if !ty.is_integer() {
            let message = format!("the control variable of FOR is an integer, this is {}", ty.name());
            self.findings.error(Code::ForVariable, variable.at, message, "count in INT or DINT");
            return None;
        }
        if place.dynamic {
            let message = "the control variable of FOR cannot be an element at a variable index";
            self.findings.error(Code::ForVariable, variable.at, message, "count in a variable of its own");
            return None;
        }
        Some((place, ty))
    }

    /// A value that is kept over the turns of a loop.
    fn held(&mut self, expr: &Expr, ty: Elementary) -> Option<Held> {
        let operand = self.expr(expr);
        if operand.known().is_some() {
            let cell = self.constant_of(expr, ty)?;
            return Some(Held::Constant(cell));
        }
        if !self.convert(operand, ty, expr.at) {
            return None;
        }
        let place = self.temporary();
        self.emit(Op::StoreLocal(place), 0, expr.at);
        Some(Held::Frame(place))
    }

    /// A step may be negative even where the variable cannot.
    fn step(&mut self, by: &Expr, ty: Elementary) -> Option<Held> {
        let held = if matches!(by.kind, ExprKind::Unary(..) | ExprKind::Number(..)) {
            self.held(by, Elementary::Lint)
        } else {
            self.held(by, ty)
        }?;
        if held == Held::Constant(0) {
            self.findings.error(Code::ForVariable, by.at, "a step of 0 never comes to an end", "");
            return None;
        }
        Some(held)
    }

    fn push_held(&mut self, held: Held, at: At) {
        match held {
            Held::Constant(cell) => self.push_cell(cell, at),
            Held::Frame(place) => {
                self.emit(Op::LoadLocal(place), 0, at);
            }
        }
    }
}

/// Where a value is kept over the turns of a loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Held {
    Constant(i64),
    Frame(u32),
}
