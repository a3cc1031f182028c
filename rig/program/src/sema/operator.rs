//! Operators with two sides.

use super::Sema;
use super::constant::is_comparison;
use super::literal::LiteralOperand;
use super::types::{Type, TypeId, WRONG};
use crate::codes::Code;
use crate::findings::SourcePlace;
use crate::parse::ast::{self, BinaryOp as Written};
use crate::tree::{BinaryOp, Expr, ExprKind, Stmt, StmtKind, Target, TreePlace, TreeRoot, Ty};
use crate::types::Elementary;

/// Operations in a row after which the value so far is put into a variable, so that the tree stays flat.
const ROW: u32 = 200;

impl<'a> Sema<'a> {
    /// Operators of one level, from left to right.
    pub(super) fn chain(
        &mut self,
        first: &ast::Expr,
        rest: &[(Written, SourcePlace, ast::Expr)],
    ) -> LiteralOperand {
        let mut left = self.expr(first, None);
        let mut at = first.at;
        let mut before: Vec<Stmt> = Vec::new();
        let mut row = 0;
        for (op, op_at, right) in rest {
            let expected = match &left {
                LiteralOperand::Value(_, ty) => Some(*ty),
                _ => None,
            };
            let right_operand = self.expr(right, expected);
            // An enumerator on the left may wait for the type on the right.
            left = self.operate(*op, left, right_operand, *op_at);
            at = at.to(right.at);
            if let LiteralOperand::Value(value, _) = &mut left {
                value.at = at;
                row += 1;
                if row >= ROW && !matches!(value.kind, ExprKind::Constant(_)) {
                    row = 0;
                    self.set_aside(value, &mut before);
                }
            }
        }
        if let (LiteralOperand::Value(value, _), false) = (&mut left, before.is_empty()) {
            let (ty, at) = (value.ty, value.at);
            let wrong = Expr { kind: ExprKind::Constant(0), ty, at };
            let inner = std::mem::replace(value, wrong);
            *value = Expr { kind: ExprKind::Sequence(before, Box::new(inner)), ty, at };
        }
        left
    }

    /// Moves a value into a variable without a name.
    pub(super) fn set_aside(&mut self, value: &mut Expr, before: &mut Vec<Stmt>) {
        let wrong = Expr { kind: ExprKind::Constant(0), ty: value.ty, at: value.at };
        let partial = std::mem::replace(value, wrong);
        let partial = self.promoted(partial);
        let (ty, at) = (partial.ty, partial.at);
        let place = TreePlace {
            root: TreeRoot::Frame,
            offset: self.hidden(ty),
            indices: Vec::new(),
            ty,
            retained: false,
            at,
        };
        *value = self.uncut(Expr { kind: ExprKind::Load(place.clone()), ty, at });
        before.push(Stmt { kind: StmtKind::Assign(Target::Place(place), partial), at });
    }

    /// One operator.
    pub(super) fn operate(
        &mut self,
        op: Written,
        a: LiteralOperand,
        b: LiteralOperand,
        at: SourcePlace,
    ) -> LiteralOperand {
        if matches!(a, LiteralOperand::Wrong) || matches!(b, LiteralOperand::Wrong) {
            return LiteralOperand::Wrong;
        }
        for operand in [&a, &b] {
            if let LiteralOperand::Value(value, ty) = operand
                && matches!(self.ty(*ty), Type::Block(_) | Type::Native(_))
            {
                self.not_a_value(value.at);
                return LiteralOperand::Wrong;
            }
        }
        if op == Written::Power {
            return self.power(a, b, at);
        }
        if let (LiteralOperand::Integer(a), LiteralOperand::Integer(b)) = (&a, &b)
            && let Some(result) = self.fold_integers(op, *a, *b, at)
        {
            return result;
        }
        if let Some(result) = self.fold_reals(op, &a, &b, at) {
            return result;
        }
        if let Some(result) = self.time_operator(op, &a, &b, at) {
            return result;
        }
        if let Some(result) = self.pointer_operator(op, &a, &b, at) {
            return result;
        }
        let Some(ty) = self.common(&a, &b) else {
            let (a, b) = (self.own_type(&a), self.own_type(&b));
            let message =
                format!("{} does not take {} and {}", op.text(), self.type_name(a), self.type_name(b));
            let help = match (self.scalar(a), self.scalar(b)) {
                (Some(a), Some(b)) => {
                    format!("convert one of them, as with {}_TO_{}(...)", b.name(), a.name())
                }
                _ => String::new(),
            };
            self.findings.error(Code::Operator, at, message, help);
            return LiteralOperand::Wrong;
        };
        let Some(kind) = self.operation(op, ty, at) else { return LiteralOperand::Wrong };
        self.check_exact(kind, ty, &a, &b, at);
        if matches!(kind, BinaryOp::Divide | BinaryOp::Mod) && is_zero(&b) {
            return self.division_by_zero(at);
        }
        let (Some(left), Some(right)) = (self.give_beside(a, ty, at), self.give_beside(b, ty, at)) else {
            return LiteralOperand::Wrong;
        };
        let (left, right) = self.promoted_for(kind, left, right);
        let value = self.binary(kind, left, right, at);
        let value = self.uncut(value);
        let result = if is_comparison(kind) {
            self.elementary(Elementary::Bool)
        } else {
            // Arithmetic leaves enumerations and subranges.
            self.scalar(ty).map_or(ty, |scalar| self.elementary(scalar))
        };
        LiteralOperand::Value(value, result)
    }

    /// An operand in the type where both meet: without the warnings of an assignment.
    fn give_beside(&mut self, operand: LiteralOperand, ty: TypeId, at: SourcePlace) -> Option<Expr> {
        match operand {
            LiteralOperand::Value(value, from)
                if self.scalar(from).is_some() && self.scalar(ty).is_some() =>
            {
                let to = self.tree_type(ty);
                Some(self.widened(value, to))
            }
            LiteralOperand::Value(value, from) if self.is_address(from) && self.is_address(ty) => Some(value),
            LiteralOperand::Value(value, from)
                if matches!(self.ty(from), Type::Text { .. }) && matches!(self.ty(ty), Type::Text { .. }) =>
            {
                Some(value)
            }
            operand => self.give(operand, ty, at),
        }
    }

    /// Warns where a REAL is tested for a number that no REAL is: a tool that computes with LREAL finds another outcome.
    fn check_exact(
        &mut self,
        kind: BinaryOp,
        ty: TypeId,
        a: &LiteralOperand,
        b: &LiteralOperand,
        at: SourcePlace,
    ) {
        let (double, single) = match (a, b) {
            (LiteralOperand::Real(double, single), LiteralOperand::Value(..))
            | (LiteralOperand::Value(..), LiteralOperand::Real(double, single)) => (double, single),
            _ => return,
        };
        let exact = f64::from(*single) == *double;
        if exact
            || self.scalar(ty) != Some(Elementary::Real)
            || !matches!(kind, BinaryOp::Equal | BinaryOp::NotEqual)
        {
            return;
        }
        let message = format!("no REAL is {double}: the nearest one is compared, {single:.9}");
        let help = "compare with a margin, as in ABS(a - b) < 0.001; REAL#... says that the nearest is meant";
        self.findings.warning(Code::Inexact, at, message, help);
    }

    pub(super) fn division_by_zero(&mut self, at: SourcePlace) -> LiteralOperand {
        let help = "divide by something else; a divisor that may be 0 is tested before, as in IF d <> 0 THEN";
        self.findings.error(Code::DivisionByZero, at, "a division by 0", help);
        LiteralOperand::Wrong
    }

    /// The operation for a type; reports where there is none.
    fn operation(&mut self, op: Written, ty: TypeId, at: SourcePlace) -> Option<BinaryOp> {
        use Elementary::Bool;
        let scalar = self.scalar(ty);
        let integer = scalar.is_some_and(Elementary::is_integer);
        let number = integer || scalar.is_some_and(Elementary::is_real);
        let text = matches!(self.ty(ty), Type::Text { .. });
        let address = self.is_address(ty);
        let comparable = scalar.is_some() || text;
        let (allowed, kind) = match op {
            Written::Or => (integer || scalar == Some(Bool), BinaryOp::Or),
            Written::Xor => (integer || scalar == Some(Bool), BinaryOp::Xor),
            Written::And => (integer || scalar == Some(Bool), BinaryOp::And),
            Written::AndThen => (scalar == Some(Bool), BinaryOp::AndThen),
            Written::OrElse => (scalar == Some(Bool), BinaryOp::OrElse),
            Written::Equal => (comparable || address, BinaryOp::Equal),
            Written::NotEqual => (comparable || address, BinaryOp::NotEqual),
            Written::Less => (comparable || address, BinaryOp::Less),
            Written::LessEqual => (comparable || address, BinaryOp::LessEqual),
            Written::Greater => (comparable || address, BinaryOp::Greater),
            Written::GreaterEqual => (comparable || address, BinaryOp::GreaterEqual),
            Written::Add => (number, BinaryOp::Add),
            Written::Subtract => (number, BinaryOp::Subtract),
            Written::Multiply => (number, BinaryOp::Multiply),
            Written::Divide => (number, BinaryOp::Divide),
            Written::Mod => (integer, BinaryOp::Mod),
            Written::Power => (false, BinaryOp::Multiply),
        };
        if !allowed {
            self.no_operator(op.text(), ty, at);
            return None;
        }
        Some(kind)
    }

    /// Two literals: exact in 128 bits, and a literal again.
    fn fold_integers(&mut self, op: Written, a: i128, b: i128, at: SourcePlace) -> Option<LiteralOperand> {
        let truth = |value: bool| i64::from(value);
        let number = match op {
            Written::Or | Written::OrElse => a | b,
            Written::Xor => a ^ b,
            Written::And | Written::AndThen => a & b,
            Written::Add => a + b,
            Written::Subtract => a - b,
            Written::Multiply => a.checked_mul(b).unwrap_or(i128::MAX),
            Written::Divide | Written::Mod if b == 0 => return Some(self.division_by_zero(at)),
            Written::Divide => a / b,
            Written::Mod => a % b,
            Written::Equal => return Some(self.known(truth(a == b), Elementary::Bool, at)),
            Written::NotEqual => return Some(self.known(truth(a != b), Elementary::Bool, at)),
            Written::Less => return Some(self.known(truth(a < b), Elementary::Bool, at)),
            Written::LessEqual => return Some(self.known(truth(a <= b), Elementary::Bool, at)),
            Written::Greater => return Some(self.known(truth(a > b), Elementary::Bool, at)),
            Written::GreaterEqual => return Some(self.known(truth(a >= b), Elementary::Bool, at)),
            Written::Power => return None,
        };
        Some(self.literal(number, at))
    }

    fn fold_reals(
        &mut self,
        op: Written,
        a: &LiteralOperand,
        b: &LiteralOperand,
        at: SourcePlace,
    ) -> Option<LiteralOperand> {
        let number = |operand: &LiteralOperand| match operand {
            LiteralOperand::Real(double, _) => Some((*double, true)),
            LiteralOperand::Integer(n) => Some((*n as f64, false)),
            _ => None,
        };
        let ((a, real), (b, too)) = (number(a)?, number(b)?);
        if !real && !too {
            return None;
        }
        let value = match op {
            Written::Add => a + b,
            Written::Subtract => a - b,
            Written::Multiply => a * b,
            Written::Divide if b == 0.0 => return Some(self.division_by_zero(at)),
            Written::Divide => a / b,
            Written::Equal => return Some(self.known(i64::from(a == b), Elementary::Bool, at)),
            Written::NotEqual => return Some(self.known(i64::from(a != b), Elementary::Bool, at)),
            Written::Less => return Some(self.known(i64::from(a < b), Elementary::Bool, at)),
            Written::LessEqual => return Some(self.known(i64::from(a <= b), Elementary::Bool, at)),
            Written::Greater => return Some(self.known(i64::from(a > b), Elementary::Bool, at)),
            Written::GreaterEqual => return Some(self.known(i64::from(a >= b), Elementary::Bool, at)),
            _ => return None,
        };
        Some(LiteralOperand::Real(value, value as f32))
    }

    /// Durations and dates; `None` where neither side is one.
    fn time_operator(
        &mut self,
        op: Written,
        a: &LiteralOperand,
        b: &LiteralOperand,
        at: SourcePlace,
    ) -> Option<LiteralOperand> {
        let (a_id, b_id) = (self.own_type(a), self.own_type(b));
        let (left, right) = (self.scalar(a_id)?, self.scalar(b_id)?);
        let temporal = |ty: Elementary| ty.is_duration() || ty.is_date();
        if !temporal(left) && !temporal(right) {
            return None;
        }
        let number = |ty: Elementary| ty.is_integer() || ty.is_real();
        let function = match op {
            Written::Multiply if left.is_duration() && number(right) => {
                return Some(self.duration_by_number(op, left, a.clone(), right, b.clone(), at));
            }
            Written::Multiply if right.is_duration() && number(left) => {
                return Some(self.duration_by_number(op, right, b.clone(), left, a.clone(), at));
            }
            Written::Divide if left.is_duration() && number(right) => {
                if is_zero(b) {
                    return Some(self.division_by_zero(at));
                }
                return Some(self.duration_by_number(op, left, a.clone(), right, b.clone(), at));
            }
            Written::Add | Written::Subtract if left.is_duration() && right.is_duration() => {
                let meet = if left == right { left } else { Elementary::Ltime };
                let kind = if op == Written::Add { BinaryOp::Add } else { BinaryOp::Subtract };
                let ty = self.elementary(meet);
                let (left, right) = (self.give(a.clone(), ty, at)?, self.give(b.clone(), ty, at)?);
                return Some(LiteralOperand::Value(self.binary(kind, left, right, at), ty));
            }
            Written::Add if left.is_date() && right.is_duration() => self.time_function("ADD", left, right),
            Written::Add if left.is_duration() && right.is_date() => {
                return self.time_operator(op, b, a, at);
            }
            Written::Subtract if left.is_date() => self.time_function("SUB", left, right),
            Written::Equal
            | Written::NotEqual
            | Written::Less
            | Written::LessEqual
            | Written::Greater
            | Written::GreaterEqual => return None,
            _ => None,
        };
        let Some(function) = function else {
            let message =
                format!("{} does not take {} and {}", op.text(), self.type_name(a_id), self.type_name(b_id));
            self.findings.error(Code::Operator, at, message, "convert one of them");
            return Some(LiteralOperand::Wrong);
        };
        Some(self.library_call(function, vec![a.clone(), b.clone()], at))
    }

    /// `ADD_DT_TIME` and the like.
    fn time_function(
        &self,
        op: &str,
        left: Elementary,
        right: Elementary,
    ) -> Option<&'static crate::library::Function> {
        let short = |ty: Elementary| match ty {
            Elementary::Tod => "TOD",
            Elementary::Dt => "DT",
            Elementary::Ltod => "LTOD",
            Elementary::Ldt => "LDT",
            ty => ty.name(),
        };
        // A short type beside a long one goes into the long one.
        let long = |ty: Elementary| match ty {
            Elementary::Time => Elementary::Ltime,
            Elementary::Date => Elementary::Ldate,
            Elementary::Tod => Elementary::Ltod,
            Elementary::Dt => Elementary::Ldt,
            ty => ty,
        };
        let find = |left, right| crate::library::find(&format!("{op}_{}_{}", short(left), short(right)));
        find(left, right).or_else(|| find(long(left), long(right)))
    }

    /// A duration times or by a number: for whole numbers an operation on the duration's own cells.
    fn duration_by_number(
        &mut self,
        op: Written,
        ty: Elementary,
        duration: LiteralOperand,
        number_type: Elementary,
        number: LiteralOperand,
        at: SourcePlace,
    ) -> LiteralOperand {
        let id = self.elementary(ty);
        if number_type.is_real() {
            let name = match (op, ty) {
                (Written::Multiply, Elementary::Time) => "MUL_TIME",
                (Written::Multiply, _) => "MUL_LTIME",
                (_, Elementary::Time) => "DIV_TIME",
                _ => "DIV_LTIME",
            };
            return match crate::library::find(name) {
                Some(function) => self.library_call(function, vec![duration, number], at),
                None => LiteralOperand::Wrong,
            };
        }
        let Some(left) = self.give(duration, id, at) else { return LiteralOperand::Wrong };
        let Some((number, _)) = self.own_value(number, at) else { return LiteralOperand::Wrong };
        let number = self.promoted(number);
        let to = Ty::Scalar(ty);
        let right = match number.kind {
            ExprKind::Constant(cell) => {
                Expr { kind: ExprKind::Constant(ty.wrap(cell)), ty: to, at: number.at }
            }
            _ => self.reinterpreted(number, to),
        };
        let kind = if op == Written::Multiply { BinaryOp::Multiply } else { BinaryOp::Divide };
        LiteralOperand::Value(self.binary(kind, left, right, at), id)
    }

    /// A pointer and a number of bytes, or two pointers.
    fn pointer_operator(
        &mut self,
        op: Written,
        a: &LiteralOperand,
        b: &LiteralOperand,
        at: SourcePlace,
    ) -> Option<LiteralOperand> {
        let (a_id, b_id) = (self.own_type(a), self.own_type(b));
        let pointer = |sema: &Self, ty: TypeId| matches!(sema.ty(ty), Type::Pointer(_));
        let (first, second) = (pointer(self, a_id), pointer(self, b_id));
        if !first && !second || !matches!(op, Written::Add | Written::Subtract) {
            return None;
        }
        if first && second {
            if op == Written::Add {
                return Some(self.no_operator("+", a_id, at));
            }
            // The distance in bytes.
            let dint = self.elementary(Elementary::Dint);
            let to = Ty::Scalar(Elementary::Dint);
            let (left, right) = (self.give(a.clone(), a_id, at)?, self.give(b.clone(), b_id, at)?);
            let (left, right) = (self.reinterpreted(left, to), self.reinterpreted(right, to));
            return Some(LiteralOperand::Value(self.binary(BinaryOp::Subtract, left, right, at), dint));
        }
        let (pointer, ty, number) = match (first, op) {
            (true, _) => (a.clone(), a_id, b.clone()),
            (false, Written::Add) => (b.clone(), b_id, a.clone()),
            _ => return Some(self.no_operator("-", b_id, at)),
        };
        let pointer = self.give(pointer, ty, at)?;
        let number_type = self.own_type(&number);
        if !self.scalar(number_type).is_some_and(Elementary::is_integer) {
            return Some(self.no_operator(op.text(), number_type, at));
        }
        let (number, _) = self.own_value(number, at)?;
        let lint = Ty::Scalar(Elementary::Lint);
        let number = self.widened(number, lint);
        let number = if op == Written::Subtract {
            self.unary(crate::tree::UnaryOp::Negate, number, at)
        } else {
            number
        };
        let kind = ExprKind::Offset(Box::new(pointer), Box::new(number));
        Some(LiteralOperand::Value(Expr { kind, ty: Ty::Address, at }, ty))
    }

    /// `a ** b`.
    fn power(&mut self, a: LiteralOperand, b: LiteralOperand, at: SourcePlace) -> LiteralOperand {
        let (a_id, b_id) = (self.own_type(&a), self.own_type(&b));
        let number =
            |sema: &Self, ty: TypeId| sema.scalar(ty).is_some_and(|ty| ty.is_integer() || ty.is_real());
        for ty in [a_id, b_id] {
            if ty == WRONG || !number(self, ty) {
                return self.no_operator("**", ty, at);
            }
        }
        match crate::library::find("EXPT") {
            Some(function) => self.library_call(function, vec![a, b], at),
            None => LiteralOperand::Wrong,
        }
    }
}

/// Whether it is a constant 0, of a real type with either sign.
fn is_zero(operand: &LiteralOperand) -> bool {
    match operand {
        LiteralOperand::Integer(n) => *n == 0,
        LiteralOperand::Real(double, _) => *double == 0.0,
        LiteralOperand::Value(Expr { kind: ExprKind::Constant(cell), ty, .. }, _) => match ty {
            Ty::Scalar(Elementary::Real) => f32::from_bits(*cell as u32) == 0.0,
            Ty::Scalar(Elementary::Lreal) => f64::from_bits(*cell as u64) == 0.0,
            _ => *cell == 0,
        },
        _ => false,
    }
}
