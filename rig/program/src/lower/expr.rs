//! Expressions: types are found and operations emitted in one pass.

use super::Compiler;
use super::fold::{Operand, common, fold, in_range, wrapped};
use crate::code::Op;
use crate::codes::Code;
use crate::findings::At;
use crate::parse::ast::{BinaryOp, Expr, ExprKind, UnaryOp};
use crate::types::Elementary;

impl Compiler<'_> {
    /// Emits an expression. Constants emit nothing: see [`Compiler::push`].
    pub(super) fn expr(&mut self, expr: &Expr) -> Operand {
        match &expr.kind {
            ExprKind::Number(n, None) => Operand::Literal(*n),
            ExprKind::Number(n, Some(ty)) => {
                if *ty == Elementary::Time || !in_range(*n, *ty) {
                    self.out_of_range(*n, *ty, expr.at);
                    return Operand::Wrong;
                }
                Operand::Known(*n, *ty)
            }
            ExprKind::Bool(value) => Operand::Known(i128::from(*value), Elementary::Bool),
            ExprKind::Duration(ms) => Operand::Known(i128::from(*ms), Elementary::Time),
            ExprKind::Path(path) => self.read_path(path),
            ExprKind::Direct(text) => self.read_direct(text, expr.at),
            ExprKind::Unary(op, inner) => self.unary(*op, inner, expr.at),
            ExprKind::Chain(first, rest) => self.chain(first, rest),
            ExprKind::Call(name, arguments) => self.call_function(name, arguments, expr.at),
            ExprKind::Wrong => Operand::Wrong,
        }
    }

    /// Puts a constant on the operand stack; other operands are there already.
    pub(super) fn push(&mut self, operand: Operand, at: At) {
        if let Some(n) = operand.known() {
            self.push_cell(n as i64, at);
        }
    }

    pub(super) fn push_cell(&mut self, cell: i64, at: At) {
        match i32::try_from(cell) {
            Ok(n) => self.emit(Op::Const(n), 0, at),
            Err(_) => {
                let next = self.wide.len() as u32;
                let place = *self.wide_index.entry(cell).or_insert(next);
                if place == next {
                    self.wide.push(cell);
                }
                self.emit(Op::Wide(place), 0, at)
            }
        };
    }

    fn out_of_range(&mut self, n: i128, ty: Elementary, at: At) {
        let (low, high) = ty.range();
        let message = format!("{n} is outside the range of {}", ty.name());
        let help = match ty {
            Elementary::Time => "write durations as in T#500ms".to_string(),
            _ => format!("{} holds {low} to {high}", ty.name()),
        };
        self.findings.error(Code::Range, at, message, help);
    }

    /// An expression as a value of `ty` on the operand stack. FALSE where it was reported that this cannot be.
    pub(super) fn value(&mut self, expr: &Expr, ty: Elementary) -> bool {
        let operand = self.expr(expr);
        self.convert(operand, ty, expr.at)
    }

    /// Brings an operand to `ty` as an assignment does, and onto the stack.
    pub(super) fn convert(&mut self, operand: Operand, ty: Elementary, at: At) -> bool {
        match self.suits(operand, ty, at) {
            None => false,
            Some(wrap) => {
                self.push(operand, at);
                if wrap && operand.known().is_none() {
                    self.emit(Op::Wrap(ty), 0, at);
                }
                true
            }
        }
    }

    /// Whether an operand can be assigned to `ty` without being asked: types that hold all its values, and with
    /// a warning those of its width. TRUE inside for a cell that changes. Anything else is reported.
    fn suits(&mut self, operand: Operand, ty: Elementary, at: At) -> Option<bool> {
        let from = match operand {
            Operand::Wrong => return None,
            Operand::Literal(n) if ty == Elementary::Bool && (n == 0 || n == 1) => return Some(false),
            Operand::Literal(n) if ty.is_integer() => {
                if in_range(n, ty) {
                    return Some(false);
                }
                self.out_of_range(n, ty, at);
                return None;
            }
            _ => operand.ty()?,
        };
        if from == ty {
            return Some(false);
        }
        if from.is_integer() && ty.is_integer() {
            if ty.holds(from) {
                return Some(false);
            }
            if from.bits() == ty.bits() {
                if let Some(n) = operand.known() {
                    if !in_range(n, ty) {
                        self.out_of_range(n, ty, at);
                        return None;
                    }
                } else if !matches!(operand, Operand::Stack { loose: true, .. }) {
                    let message =
                        format!("{} becomes {}: large values change their sign", from.name(), ty.name());
                    let help = format!("write {}_TO_{}(...) if that is meant", from.name(), ty.name());
                    self.findings.warning(Code::SignChange, at, message, help);
                }
                return Some(true);
            }
        }
        let found = if operand.is_literal() { "a number" } else { from.name() };
        let message = format!("{} is needed here, this is {found}", ty.name());
        let help = match (operand, ty) {
            (Operand::Literal(_), Elementary::Time) => "write durations as in T#500ms".to_string(),
            (Operand::Literal(_), Elementary::Bool) => "write TRUE or FALSE".to_string(),
            _ => format!("convert it with {}_TO_{}(...)", from.name(), ty.name()),
        };
        self.findings.error(Code::Type, at, message, help);
        None
    }

    /// A constant expression as a cell of `ty`; reports what is none.
    pub(super) fn constant_of(&mut self, expr: &Expr, ty: Elementary) -> Option<i64> {
        let (place, depth) = (self.code.len(), self.context.depth);
        let outer = std::mem::replace(&mut self.in_constant, true);
        let operand = self.expr(expr);
        self.in_constant = outer;
        self.code.truncate(place);
        self.context.depth = depth;
        match operand {
            Operand::Wrong => None,
            Operand::Stack { .. } => {
                let help = "use numbers and names of VAR CONSTANT";
                self.findings.error(Code::NotConstant, expr.at, "a constant is needed here", help);
                None
            }
            Operand::Literal(n) | Operand::Known(n, _) => {
                self.suits(operand, ty, expr.at).map(|_| ty.wrap(n as i64))
            }
        }
    }

    fn unary(&mut self, op: UnaryOp, inner: &Expr, at: At) -> Operand {
        let operand = self.expr(inner);
        let Some(ty) = operand.ty() else {
            if let Operand::Literal(n) = operand {
                self.out_of_range(n, Elementary::Ulint, inner.at);
            }
            return Operand::Wrong;
        };
        match op {
            UnaryOp::Minus => match operand {
                Operand::Literal(n) => self.literal(-n, at),
                _ if !ty.signed() => {
                    let message = format!("{} has no negative values", ty.name());
                    self.findings.error(Code::Operator, at, message, "convert to a signed type first");
                    Operand::Wrong
                }
                Operand::Known(n, ty) => Operand::Known(wrapped(-n, ty), ty),
                _ => {
                    self.emit(Op::Neg(ty), self.options.costs.op(ty), at);
                    Operand::stack(ty)
                }
            },
            UnaryOp::Not => match operand {
                _ if ty == Elementary::Time => self.no_operator("NOT", ty, at),
                Operand::Literal(_) => {
                    let help = "give it one, as in NOT WORD#16#FF";
                    self.findings.error(Code::Operator, at, "NOT needs an operand with a type", help);
                    Operand::Wrong
                }
                Operand::Known(n, ty) => Operand::Known(ty.number(ty.wrap(!(n as i64))), ty),
                _ => {
                    self.emit(Op::Not(ty), self.options.costs.op(ty), at);
                    Operand::stack(ty)
                }
            },
        }
    }

    /// A number without a type, if 64 bits hold it.
    fn literal(&mut self, n: i128, at: At) -> Operand {
        if i128::from(i64::MIN) <= n && n <= i128::from(u64::MAX) {
            return Operand::Literal(n);
        }
        self.findings.error(Code::Range, at, format!("{n} does not fit into 64 bits"), "");
        Operand::Wrong
    }

    fn no_operator(&mut self, op: &str, ty: Elementary, at: At) -> Operand {
        self.findings.error(Code::Operator, at, format!("{op} is not defined for {}", ty.name()), "");
        Operand::Wrong
    }

    /// Operators of one level, from left to right.
    fn chain(&mut self, first: &Expr, rest: &[(BinaryOp, At, Expr)]) -> Operand {
        let mut left = self.expr(first);
        let mut left_at = first.at;
        for (op, at, right) in rest {
            // A constant goes below what the right side emits; where that is a constant too, it is taken back.
            let (place, depth) = (self.code.len(), self.context.depth);
            self.push(left, left_at);
            let operand = self.expr(right);
            left = match (left.known(), operand.known()) {
                (Some(a), Some(b)) => {
                    self.code.truncate(place);
                    self.context.depth = depth;
                    self.fold_binary(*op, (left, a), (operand, b), *at)
                }
                _ => self.binary(*op, left, operand, *at),
            };
            left_at = left_at.to(right.at);
        }
        left
    }

    fn fold_binary(&mut self, op: BinaryOp, a: (Operand, i128), b: (Operand, i128), at: At) -> Operand {
        let Some((ty, result)) = self.result_type(op, a.0, b.0, at) else { return Operand::Wrong };
        let Some(n) = fold(op, a.1, b.1) else {
            self.findings.error(Code::DivisionByZero, at, "a division by 0", "");
            return Operand::Wrong;
        };
        if result == Elementary::Bool {
            return Operand::Known(n, result);
        }
        if a.0.is_literal() && b.0.is_literal() {
            return self.literal(n, at);
        }
        Operand::Known(wrapped(n, ty), result)
    }

    /// The type in which an operator works, and that of its result; reports where there is none.
    fn result_type(
        &mut self,
        op: BinaryOp,
        a: Operand,
        b: Operand,
        at: At,
    ) -> Option<(Elementary, Elementary)> {
        use BinaryOp::{Add, And, Divide, Multiply, Or, Subtract, Xor};
        use Elementary::{Bool, Time};
        if a == Operand::Wrong || b == Operand::Wrong {
            return None;
        }
        // A duration times or by a number is a duration.
        match (a.ty()?, b.ty()?) {
            (Time, n) if n.is_integer() && matches!(op, Multiply | Divide) => return Some((Time, Time)),
            (n, Time) if n.is_integer() && op == Multiply => return Some((Time, Time)),
            _ => {}
        }
        let Some(ty) = common(a, b) else {
            let (a, b) = (a.ty()?, b.ty()?);
            let message = format!("{} does not take {} and {}", op.text(), a.name(), b.name());
            let help = format!("convert one of them, as with {}_TO_{}(...)", b.name(), a.name());
            self.findings.error(Code::Operator, at, message, help);
            return None;
        };
        let (allowed, result) = match op {
            Or | Xor | And => (ty != Time, ty),
            BinaryOp::Equal | BinaryOp::NotEqual => (true, Bool),
            BinaryOp::Less | BinaryOp::LessEqual | BinaryOp::Greater | BinaryOp::GreaterEqual => (true, Bool),
            Add | Subtract => (ty != Bool, ty),
            Multiply | Divide | BinaryOp::Mod => (ty.is_integer(), ty),
        };
        if !allowed {
            self.no_operator(op.text(), ty, at);
            return None;
        }
        Some((ty, result))
    }

    fn binary(&mut self, op: BinaryOp, a: Operand, b: Operand, at: At) -> Operand {
        let Some((ty, result)) = self.result_type(op, a, b, at) else { return Operand::Wrong };
        let cost = match op {
            BinaryOp::Divide | BinaryOp::Mod => self.options.costs.div(ty),
            _ => self.options.costs.op(ty),
        };
        if b.known() == Some(0) && matches!(op, BinaryOp::Divide | BinaryOp::Mod) {
            self.findings.error(Code::DivisionByZero, at, "a division by 0", "");
            return Operand::Wrong;
        }
        let small = b.known().and_then(|n| i32::try_from(n).ok()).filter(|_| !ty.wide_unsigned());
        let with_constant = match (op, small) {
            (BinaryOp::Add, Some(n)) => Some(Op::AddConst(ty, n)),
            (BinaryOp::Subtract, Some(n)) if n != i32::MIN => Some(Op::AddConst(ty, -n)),
            (BinaryOp::Equal, Some(n)) => Some(Op::EqConst(n)),
            (BinaryOp::Less, Some(n)) => Some(Op::LtConst(n)),
            (BinaryOp::Greater, Some(n)) => Some(Op::GtConst(n)),
            _ => None,
        };
        if let Some(op) = with_constant {
            self.emit(op, cost, at);
            return Operand::stack(result);
        }
        self.push(b, at);
        let wide = ty.wide_unsigned();
        let op = match op {
            BinaryOp::Or => Op::Or,
            BinaryOp::Xor => Op::Xor,
            BinaryOp::And => Op::And,
            BinaryOp::Equal => Op::Eq,
            BinaryOp::NotEqual => Op::Ne,
            BinaryOp::Less if wide => Op::LtWide,
            BinaryOp::LessEqual if wide => Op::LeWide,
            BinaryOp::Greater if wide => Op::GtWide,
            BinaryOp::GreaterEqual if wide => Op::GeWide,
            BinaryOp::Less => Op::Lt,
            BinaryOp::LessEqual => Op::Le,
            BinaryOp::Greater => Op::Gt,
            BinaryOp::GreaterEqual => Op::Ge,
            BinaryOp::Add => Op::Add(ty),
            BinaryOp::Subtract => Op::Sub(ty),
            BinaryOp::Multiply => Op::Mul(ty),
            BinaryOp::Divide => Op::Div(ty),
            BinaryOp::Mod => Op::Mod(ty),
        };
        self.emit(op, cost, at);
        Operand::stack(result)
    }
}
