//! Conditions: comparisons jump by themselves.

use super::expr::{BOOL, has_effects, survey};
use super::frame::CodeLabel;
use super::{Dest, Emitter, ops};
use crate::code::{Op, Operand};
use crate::tree::{BinaryOp, Expr, ExprKind, UnaryOp};
use crate::types::Elementary;

/// Whether it makes no difference if a BOOL is not computed, but for the time.
fn is_harmless(condition: &Expr) -> bool {
    let known = survey(condition);
    condition.ty == BOOL && !known.effects && !known.faults && !known.forks
}

impl Emitter<'_, '_, '_> {
    /// Goes to the label if the condition is `holds`. The cost comes on top, once on every way.
    pub(super) fn jump_if(&mut self, condition: &Expr, holds: bool, label: CodeLabel, cost: u32) {
        let (mut condition, mut holds, mut cost) = (condition, holds, cost);
        while let ExprKind::Unary(UnaryOp::Not, inner) = &condition.kind {
            (condition, holds) = (inner, !holds);
            cost = cost.saturating_add(self.costs.op(Elementary::Bool));
        }
        let mark = self.mark();
        if self.enter(condition.at) {
            self.jump_if_plain(condition, holds, label, cost);
        }
        self.leave();
        self.release(mark);
    }

    fn jump_if_plain(&mut self, condition: &Expr, holds: bool, label: CodeLabel, cost: u32) {
        let at = condition.at;
        if let ExprKind::Binary(op, left, right) = &condition.kind {
            if matches!(op, BinaryOp::AndThen | BinaryOp::OrElse) {
                return self.jump_chain(*op, condition, holds, label, cost);
            }
            if matches!(op, BinaryOp::And | BinaryOp::Or) && is_harmless(condition) {
                return self.jump_at_once(*op, condition, holds, label, cost);
            }
            if let Some((relation, swap)) = ops::relation(*op) {
                let mut a = self.value(left);
                if has_effects(right) {
                    a = self.stable(a, left.at);
                }
                let b = self.value(right);
                let (sides, ty, compared) = self.comparable(a, b, at);
                let (op, turned) = ops::jump(relation, ty, holds);
                let sides = if swap != turned { [sides[1], sides[0]] } else { sides };
                return self.jump(op, label, sides, cost.saturating_add(compared), at);
            }
        }
        let value = self.value(condition);
        let op = if holds { Op::JumpIf } else { Op::JumpIfNot };
        self.jump(op, label, [value.at, Operand(0)], cost.saturating_add(value.cost), at);
    }

    /// AND or OR of what can be left out without anybody seeing it: each side jumps. The first operation bears what
    /// all of them cost, for both sides are computed as far as time goes.
    fn jump_at_once(&mut self, op: BinaryOp, condition: &Expr, holds: bool, label: CodeLabel, cost: u32) {
        let first = self.code.len();
        self.jump_chain(op, condition, holds, label, cost);
        let steps = self.code.get_mut(first..).unwrap_or_default();
        let total =
            steps.iter_mut().fold(0u32, |sum, step| sum.saturating_add(std::mem::take(&mut step.cost)));
        if let Some(step) = steps.first_mut() {
            step.cost = total;
        }
    }

    /// AND_THEN or OR_ELSE: each side is tested in turn. An operator costs what AND does, where its right side is
    /// left out too.
    fn jump_chain(&mut self, op: BinaryOp, condition: &Expr, holds: bool, label: CodeLabel, cost: u32) {
        let mut parts = Vec::new();
        let mut left = condition;
        while let ExprKind::Binary(found, first, second) = &left.kind
            && *found == op
        {
            parts.push(second.as_ref());
            left = first;
        }
        parts.push(left);
        // What one side alone decides.
        let decided = matches!(op, BinaryOp::OrElse | BinaryOp::Or);
        let beyond = self.label();
        let mut cost = cost;
        while let Some(part) = parts.pop() {
            if parts.is_empty() {
                self.jump_if(part, holds, label, cost);
            } else {
                let cost = std::mem::take(&mut cost).saturating_add(self.costs.op(Elementary::Bool));
                self.jump_if(part, decided, if holds == decided { label } else { beyond }, cost);
            }
        }
        self.bind(beyond);
    }

    /// AND_THEN or OR_ELSE as a value.
    pub(super) fn short_circuit(&mut self, expr: &Expr, to: Dest) {
        let (other, end) = (self.label(), self.label());
        self.jump_if(expr, false, other, to.cost);
        let (yes, no, to) = (self.constant(1, to.ty), self.constant(0, to.ty), Dest { cost: 0, ..to });
        self.transfer(to, yes, 0, expr.at);
        self.jump(Op::Jump, end, [Operand(0); 2], 0, expr.at);
        self.bind(other);
        self.transfer(to, no, 0, expr.at);
        self.bind(end);
    }
}
