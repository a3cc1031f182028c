//! Expressions.

use super::convert::{is_cut, same_bits};
use super::place::PlaceUse;
use super::{Dest, Emitter, Value, ops};
use crate::code::{AddressBase, Op, Operand};
use crate::codes::Code;
use crate::findings::SourcePlace;
use crate::tree::{BinaryOp, Expr, ExprKind, TreePlace, TreeRoot, Ty, UnaryOp};
use crate::types::Elementary;

/// Expressions inside each other. The parser allows fewer: this keeps the stack of the host safe whatever comes.
const DEPTH: u32 = 640;

pub(super) const BOOL: Ty = Ty::Scalar(Elementary::Bool);

/// Operators that compute both sides.
fn is_plain(op: BinaryOp) -> bool {
    !matches!(op, BinaryOp::AndThen | BinaryOp::OrElse)
}

/// What is known of an expression without making code of it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Survey {
    /// Computing it may change a variable.
    pub effects: bool,
    /// Computing it may fail.
    pub faults: bool,
    /// What is computed depends on values.
    pub forks: bool,
    /// Expressions in it; counted as far as the first one with effects.
    pub parts: usize,
}

/// Without recursion: chains of operators are deep.
pub(super) fn survey(expr: &Expr) -> Survey {
    let mut found = Survey { parts: 1, ..Survey::default() };
    match &expr.kind {
        // What most expressions are.
        ExprKind::Constant(_) => return found,
        ExprKind::Load(place) if place.is_direct() => return found,
        _ => found.parts = 0,
    }
    let mut waiting = vec![expr];
    while let Some(expr) = waiting.pop() {
        found.parts += 1;
        match &expr.kind {
            ExprKind::Constant(_) | ExprKind::Text(_) | ExprKind::Bytes(_) => {}
            ExprKind::Load(place) | ExprKind::LoadBit(place, _) | ExprKind::AddressOf(place) => {
                found.faults |= !place.is_direct();
                waiting.extend(place.indices.iter().map(|index| &index.value));
                if let TreeRoot::Address(address) = &place.root {
                    waiting.push(address);
                }
            }
            ExprKind::Unary(_, inner) | ExprKind::Convert(inner) => waiting.push(inner),
            ExprKind::Reinterpret(inner) => waiting.push(inner),
            ExprKind::IsKind(inner, _) => {
                found.faults = true;
                waiting.push(inner);
            }
            ExprKind::Binary(op, a, b) => {
                found.faults |= matches!(op, BinaryOp::Divide | BinaryOp::Mod);
                found.forks |= !is_plain(*op);
                waiting.extend([a.as_ref(), b.as_ref()]);
            }
            ExprKind::Offset(a, b) => waiting.extend([a.as_ref(), b.as_ref()]),
            ExprKind::Select(which, values) => {
                found.forks = true;
                waiting.push(which);
                waiting.extend(values);
            }
            ExprKind::Library(_, _, values) => waiting.extend(values),
            ExprKind::Call(_) | ExprKind::Sequence(..) => {
                found.effects = true;
                return found;
            }
        }
    }
    found
}

pub(super) fn has_effects(expr: &Expr) -> bool {
    survey(expr).effects
}

impl TreePlace {
    /// Whether its address is known without an operation.
    pub(super) fn is_direct(&self) -> bool {
        self.indices.is_empty() && !matches!(self.root, TreeRoot::Address(_))
    }
}

impl Emitter<'_, '_, '_> {
    /// Whether one more expression may be opened inside those that are open.
    pub(super) fn enter(&mut self, at: SourcePlace) -> bool {
        self.unit.depth += 1;
        if self.unit.depth == DEPTH && !std::mem::replace(&mut self.unit.deep, true) {
            let help = "compute parts of it in statements of their own";
            self.findings.error(Code::Depth, at, "the expression is nested too deeply", help);
        }
        self.unit.depth < DEPTH
    }

    pub(super) fn leave(&mut self) {
        self.unit.depth = self.unit.depth.saturating_sub(1);
    }

    /// A constant of a scalar type.
    pub(super) fn constant(&mut self, cell: i64, ty: Ty) -> Value {
        let at = Operand::new(AddressBase::Absolute, self.pool.cell(cell, ty.bytes()));
        Value { at, ty, cost: 0, fixed: true }
    }

    /// The value of an expression, where it stands or in a temporary.
    pub(super) fn value(&mut self, expr: &Expr) -> Value {
        if !self.enter(expr.at) {
            self.leave();
            return self.constant(0, expr.ty);
        }
        let value = self.in_place(expr).unwrap_or_else(|| {
            let to = Dest { at: self.temporary(expr.ty), ty: expr.ty, cost: 0 };
            let mark = self.mark();
            self.compute(expr, to);
            self.release(mark);
            Value { at: to.at, ty: expr.ty, cost: 0, fixed: true }
        });
        self.leave();
        value
    }

    /// Computes an expression into a destination, whose address is known.
    pub(super) fn store(&mut self, expr: &Expr, to: Dest) {
        let mark = self.mark();
        if self.enter(expr.at) {
            match self.in_place(expr) {
                Some(value) => {
                    let cost = self.copying(to.ty);
                    self.transfer(to, value, cost, expr.at);
                }
                None => self.compute(expr, to),
            }
        }
        self.leave();
        self.release(mark);
    }

    /// Values that are computed in turn and used together.
    pub(super) fn values(&mut self, list: &[&Expr]) -> Vec<Value> {
        let last = list.iter().rposition(|expr| has_effects(expr)).unwrap_or(0);
        let mut values = Vec::with_capacity(list.len());
        for (nth, expr) in list.iter().enumerate() {
            let value = self.value(expr);
            values.push(if nth < last { self.stable(value, expr.at) } else { value });
        }
        values
    }

    /// The value of what needs no operation of its own at the end.
    fn in_place(&mut self, expr: &Expr) -> Option<Value> {
        let ty = expr.ty;
        match &expr.kind {
            ExprKind::Constant(cell) => Some(self.constant(*cell, ty)),
            ExprKind::Text(bytes) | ExprKind::Bytes(bytes) => {
                let at = Operand::new(AddressBase::Absolute, self.pool.block(bytes));
                let ty = match ty {
                    Ty::Text { wide, .. } => {
                        let units = bytes.len() as u32 / if wide { 2 } else { 1 };
                        Ty::Text { wide, length: units.saturating_sub(1) }
                    }
                    other => other,
                };
                Some(Value { at, ty, cost: 0, fixed: true })
            }
            ExprKind::Load(place) => Some(self.load(place)),
            ExprKind::AddressOf(place) => {
                self.read(place);
                self.address_in_place(place)
            }
            ExprKind::Call(call) => Some(self.call(call, ty)),
            ExprKind::Reinterpret(inner) if same_bits(inner.ty, ty) => {
                Some(Value { ty, ..self.value(inner) })
            }
            ExprKind::Convert(inner) if is_cut(inner.ty, ty) => {
                let value = self.value(inner);
                let cost = value.cost.saturating_add(self.conversion(inner.ty, ty));
                Some(Value { ty, cost, ..value })
            }
            ExprKind::Sequence(statements, inner) => {
                self.run(statements);
                Some(self.value(inner))
            }
            _ => None,
        }
    }

    /// Computes what does not stand anywhere yet. Only the last operation writes the destination.
    fn compute(&mut self, expr: &Expr, to: Dest) {
        let at = expr.at;
        match &expr.kind {
            ExprKind::Unary(op, inner) => self.unary(*op, inner, to, at),
            ExprKind::Binary(op, ..) if is_plain(*op) => self.chain(expr, to),
            ExprKind::Binary(..) => self.short_circuit(expr, to),
            ExprKind::LoadBit(place, bit) => {
                self.read_bit(place, *bit);
                let (from, cost) = self.place(place, PlaceUse::Load);
                let cost = cost.saturating_add(self.reading(BOOL, place.retained)).saturating_add(to.cost);
                self.push(Op::LoadBit, (to.at.0, from.0, *bit), cost, at);
            }
            ExprKind::Convert(inner) => {
                let value = self.value(inner);
                let cost = self.conversion(inner.ty, expr.ty);
                self.convert(value, Dest { ty: narrower_text(to.ty, expr.ty), ..to }, cost, at);
            }
            ExprKind::Reinterpret(inner) => {
                let value = self.value(inner);
                self.convert(value, to, 0, at);
            }
            ExprKind::Offset(pointer, number) => {
                let values = self.values(&[pointer, number]);
                if let [pointer, number] = values.as_slice() {
                    let cost = self.costs.op(Elementary::Dword).saturating_add(to.cost);
                    let cost = cost.saturating_add(pointer.cost).saturating_add(number.cost);
                    // The low half of the number: addresses wrap, and what they then point to is checked.
                    self.operate(Op::Add32, [to.at, pointer.at, number.at], cost, at);
                }
            }
            ExprKind::Select(which, values) => self.select(which, values, to, at),
            ExprKind::Library(function, generic, arguments) => {
                let to = Dest { ty: narrower_text(to.ty, expr.ty), ..to };
                self.library(function, *generic, arguments, to, at);
            }
            ExprKind::IsKind(inner, kind) => {
                let value = self.value(inner);
                let cost =
                    self.costs.op(Elementary::Dword).saturating_add(value.cost).saturating_add(to.cost);
                self.push(Op::IsKind, (to.at.0, value.at.0, *kind), cost, at);
            }
            ExprKind::AddressOf(place) => {
                let (of, cost) = self.place(place, PlaceUse::Load);
                self.operate(Op::Address, [to.at, of, Operand(0)], cost.saturating_add(to.cost), at);
            }
            // These stand somewhere.
            ExprKind::Constant(_) | ExprKind::Text(_) | ExprKind::Bytes(_) => {}
            ExprKind::Load(_) | ExprKind::Call(_) | ExprKind::Sequence(..) => {}
        }
    }

    fn unary(&mut self, op: UnaryOp, inner: &Expr, to: Dest, at: SourcePlace) {
        let value = self.value(inner);
        let ty = ops::scalar(value.ty);
        let op = match op {
            UnaryOp::Not => Some(ops::not(ty)),
            UnaryOp::Negate => Some(ops::negate(ty)),
            UnaryOp::Absolute => ops::absolute(ty),
        };
        let cost = self.costs.op(ops::priced(value.ty)).saturating_add(value.cost).saturating_add(to.cost);
        self.operate(op.unwrap_or(ops::mov(ty)), [to.at, value.at, Operand(0)], cost, at);
    }

    /// Operators from left to right, however many.
    fn chain(&mut self, expr: &Expr, to: Dest) {
        let mut operators = Vec::new();
        let mut left = expr;
        while let ExprKind::Binary(op, first, second) = &left.kind
            && is_plain(*op)
        {
            operators.push((*op, left, second));
            left = first;
        }
        let slot =
            if operators.len() > 1 { Some(self.temporary(Ty::Scalar(Elementary::Lint))) } else { None };
        let mut sum = self.value(left);
        for (nth, (op, whole, right)) in operators.into_iter().enumerate().rev() {
            let into = match slot {
                Some(at) if nth > 0 => Dest { at, ty: whole.ty, cost: 0 },
                _ => to,
            };
            let mark = self.mark();
            if has_effects(right) {
                sum = self.stable(sum, whole.at);
            }
            let right = self.value(right);
            self.binary(op, sum, right, into, whole.at);
            self.release(mark);
            sum = Value { at: into.at, ty: whole.ty, cost: 0, fixed: true };
        }
    }

    fn binary(&mut self, op: BinaryOp, a: Value, b: Value, to: Dest, at: SourcePlace) {
        let ty = ops::scalar(a.ty);
        if let Some((relation, swap)) = ops::relation(op) {
            let (mut sides, ty, cost) = self.comparable(a, b, at);
            if swap {
                sides.reverse();
            }
            let cost = cost.saturating_add(to.cost);
            self.operate(ops::compare(relation, ty), [to.at, sides[0], sides[1]], cost, at);
            return;
        }
        let cost = match op {
            BinaryOp::Divide | BinaryOp::Mod => self.costs.div(ops::priced(a.ty)),
            _ => self.costs.op(ops::priced(a.ty)),
        };
        let cost = cost.saturating_add(a.cost).saturating_add(b.cost).saturating_add(to.cost);
        if let Some(op) = ops::arithmetic(op, ty) {
            self.operate(op, [to.at, a.at, b.at], cost, at);
        }
    }

    /// What one operation can compare, the type it works in and its cost: of texts, their order and 0.
    pub(super) fn comparable(
        &mut self,
        a: Value,
        b: Value,
        at: SourcePlace,
    ) -> ([Operand; 2], Elementary, u32) {
        if matches!(a.ty, Ty::Text { .. }) {
            let ty = Ty::Scalar(Elementary::Sint);
            let order = self.temporary(ty);
            self.compare_texts(order, a, b, at);
            return ([order, self.constant(0, ty).at], Elementary::Sint, 0);
        }
        let ty = ops::scalar(a.ty);
        let cost = self.costs.op(ops::priced(a.ty)).saturating_add(a.cost).saturating_add(b.cost);
        ([a.at, b.at], ty, cost)
    }

    /// SEL and MUX: only the value that is taken is computed.
    fn select(&mut self, which: &Expr, choices: &[Expr], to: Dest, at: SourcePlace) {
        let which = self.value(which);
        let Some((last, others)) = choices.split_last() else { return };
        let op = match to.ty {
            Ty::Scalar(_) | Ty::Promoted(_) | Ty::Address => self.costs.op(ops::priced(to.ty)),
            Ty::Text { .. } | Ty::Block { .. } => self.copying(to.ty),
        };
        let mut cost = op.saturating_add(which.cost);
        let ty = ops::scalar(which.ty);
        let (end, at_most) = (self.label(), ops::jump(ops::CompareRelation::LessEqual, ty, true).0);
        let mut labels = Vec::new();
        for nth in 0..others.len() {
            let label = self.label();
            let limit = self.constant(nth as i64, which.ty);
            self.jump(at_most, label, [which.at, limit.at], std::mem::take(&mut cost), at);
            labels.push(label);
        }
        self.choose(last, Dest { cost: to.cost.saturating_add(cost), ..to });
        for (label, value) in labels.into_iter().zip(others) {
            self.jump(Op::Jump, end, [Operand(0); 2], 0, at);
            self.bind(label);
            self.choose(value, to);
        }
        self.bind(end);
    }

    /// Computes a value of SEL or MUX into the destination.
    fn choose(&mut self, value: &Expr, to: Dest) {
        let mark = self.mark();
        if self.enter(value.at) {
            match self.in_place(value) {
                Some(found) => self.transfer(to, found, 0, value.at),
                None => self.compute(value, to),
            }
        }
        self.leave();
        self.release(mark);
    }
}

/// The shorter of two texts of one width; the first for anything else.
fn narrower_text(a: Ty, b: Ty) -> Ty {
    match (a, b) {
        (Ty::Text { wide, length }, Ty::Text { length: other, .. }) => {
            Ty::Text { wide, length: length.min(other) }
        }
        _ => a,
    }
}
