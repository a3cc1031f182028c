//! Constant expressions, and what is computed at compile time.

use super::promote::{exceeds, whole_constant};
use super::types::{Type, TypeId};
use super::{Sema, WRONG};
use crate::codes::Code;
use crate::library::convert;
use crate::parse::ast;
use crate::tree::{BinaryOp, Expr, ExprKind, Ty, UnaryOp};
use crate::types::Elementary;

impl<'a> Sema<'a> {
    /// A whole number that is constant, of whatever type.
    pub(super) fn constant_number(&mut self, written: &ast::Expr) -> Option<i64> {
        let outer = std::mem::replace(&mut self.context.constant, true);
        let operand = self.expr(written, None);
        self.context.constant = outer;
        let number = match &operand {
            super::literal::LiteralOperand::Integer(n) => i64::try_from(*n).ok(),
            super::literal::LiteralOperand::Value(expr, _) => {
                whole_constant(expr).and_then(|number| i64::try_from(number).ok())
            }
            super::literal::LiteralOperand::Wrong => return None,
            _ => None,
        };
        if number.is_none() {
            self.not_constant(written.at, "a whole number that is constant is needed here");
        }
        number
    }

    /// The cell of a constant of a scalar or address type.
    pub(super) fn constant_cell(&mut self, written: &ast::Expr, ty: TypeId) -> Option<i64> {
        match self.constant_value(written, ty)?.kind {
            ExprKind::Constant(cell) => Some(cell),
            _ => None,
        }
    }

    /// A constant of a type: its kind is Constant, Text or Bytes.
    pub(super) fn constant_value(&mut self, written: &ast::Expr, ty: TypeId) -> Option<Expr> {
        let outer = std::mem::replace(&mut self.context.constant, true);
        let value = self.value(written, ty);
        self.context.constant = outer;
        let value = value?;
        match value.kind {
            // What typed constants come to: a literal was compared with the range before.
            ExprKind::Constant(cell) if beyond_reals(value.ty, cell) => {
                let message = "this value is outside the range of its type";
                self.findings.error(
                    Code::Range,
                    written.at,
                    message,
                    "write smaller terms, or LREAL where they are of REAL",
                );
                None
            }
            ExprKind::Constant(_) | ExprKind::Text(_) | ExprKind::Bytes(_) => Some(value),
            _ => {
                if ty != WRONG {
                    self.not_constant(written.at, "a constant is needed here");
                }
                None
            }
        }
    }

    pub(super) fn not_constant(&mut self, at: crate::findings::SourcePlace, message: &str) {
        self.findings.error(Code::NotConstant, at, message, "use literals and names from VAR CONSTANT");
    }

    /// A unary operation, computed where the operand is constant.
    pub(super) fn unary(&mut self, op: UnaryOp, of: Expr, at: crate::findings::SourcePlace) -> Expr {
        let ty = of.ty;
        if let (Some(number), Ty::Scalar(own)) = (whole_constant(&of), ty)
            && own.is_promoted()
        {
            let whole = match op {
                UnaryOp::Not => i128::from(own.wrap(!(number as i64))),
                UnaryOp::Negate => -number,
                UnaryOp::Absolute => number.abs(),
            };
            return self.small_constant(whole as i64, own, at);
        }
        if let (ExprKind::Constant(cell), Ty::Scalar(scalar) | Ty::Promoted(scalar)) = (&of.kind, ty) {
            let (cell, scalar) = (*cell, if ty == Ty::Scalar(scalar) { scalar } else { scalar.promoted() });
            let folded = match op {
                UnaryOp::Not if scalar == Elementary::Bool => i64::from(cell == 0),
                UnaryOp::Not => scalar.wrap(!cell),
                UnaryOp::Negate if scalar.is_real() => real_cell(scalar, -real(scalar, cell)),
                UnaryOp::Negate => scalar.wrap(cell.wrapping_neg()),
                UnaryOp::Absolute if scalar.is_real() => real_cell(scalar, real(scalar, cell).abs()),
                UnaryOp::Absolute if scalar.signed() => scalar.wrap(cell.wrapping_abs()),
                UnaryOp::Absolute => cell,
            };
            return Expr { kind: ExprKind::Constant(folded), ty, at };
        }
        Expr { kind: ExprKind::Unary(op, Box::new(of)), ty, at }
    }

    /// A binary operation on two values of one type, computed where both are constant.
    pub(super) fn binary(
        &mut self,
        op: BinaryOp,
        left: Expr,
        right: Expr,
        at: crate::findings::SourcePlace,
    ) -> Expr {
        let ty = if is_comparison(op) { Ty::Scalar(Elementary::Bool) } else { left.ty };
        if let Ty::Scalar(own) = ty
            && own.is_promoted()
            && !is_shift(op)
            && let (Some(a), Some(b)) = (whole_constant(&left), whole_constant(&right))
            && let Some(whole) = fold(op, own.promoted(), a as i64, b as i64)
        {
            return self.small_constant(whole, own, at);
        }
        let left = if is_shift(op) { self.cut(left) } else { left };
        if let (ExprKind::Constant(a), ExprKind::Constant(b)) = (&left.kind, &right.kind) {
            let scalar = match left.ty {
                Ty::Scalar(scalar) => scalar,
                Ty::Promoted(scalar) => scalar.promoted(),
                _ => Elementary::Udint,
            };
            if let Some(cell) = fold(op, scalar, *a, *b) {
                return Expr { kind: ExprKind::Constant(cell), ty, at };
            }
        }
        Expr { kind: ExprKind::Binary(op, Box::new(left), Box::new(right)), ty, at }
    }

    /// A constant of a type of fewer than 32 bits, computed in 32 and not cut yet.
    fn small_constant(&mut self, whole: i64, ty: Elementary, at: crate::findings::SourcePlace) -> Expr {
        let kind = ExprKind::Constant(ty.promoted().wrap(whole));
        self.uncut(Expr { kind, ty: Ty::Promoted(ty), at })
    }

    /// A conversion between scalars, computed where the value is constant; texts are converted when the code runs.
    pub(super) fn converted(&mut self, value: Expr, to: Ty) -> Expr {
        let at = value.at;
        if value.ty == to {
            return value;
        }
        // A text is made by a function, whose parameter is of the type of the value.
        let value = if matches!(to, Ty::Text { .. }) { self.cut(value) } else { self.promoted(value) };
        match (&value.kind, value.ty, to) {
            (ExprKind::Constant(cell), Ty::Scalar(from), Ty::Scalar(into)) => {
                Expr { kind: ExprKind::Constant(convert(from, into, *cell)), ty: to, at }
            }
            (ExprKind::Constant(cell), Ty::Promoted(from), Ty::Scalar(into)) => {
                Expr { kind: ExprKind::Constant(convert(from.promoted(), into, *cell)), ty: to, at }
            }
            _ => Expr { kind: ExprKind::Convert(Box::new(value)), ty: to, at },
        }
    }

    /// A value that goes into another type by itself: between whole numbers and bit strings at no cost.
    pub(super) fn widened(&mut self, value: Expr, to: Ty) -> Expr {
        let value = match (value.ty, to) {
            (Ty::Scalar(from), Ty::Scalar(into)) if exceeds(&value) => {
                if into.is_promoted() && into.bits() > from.bits() {
                    let whole = self.in_promoted(value, into);
                    return self.uncut(whole);
                }
                if into.bits() > 32 || into.is_real() {
                    self.check_below_0(&value);
                }
                if into.bits() > from.bits() { self.promoted(value) } else { value }
            }
            _ => value,
        };
        match (value.ty, to) {
            (Ty::Promoted(_), Ty::Scalar(into)) if into.is_integer() => match value.kind {
                ExprKind::Constant(cell) => {
                    Expr { kind: ExprKind::Constant(into.wrap(cell)), ty: to, at: value.at }
                }
                _ => self.reinterpreted(value, to),
            },
            (Ty::Scalar(from), Ty::Scalar(into))
                if !from.is_real() && !into.is_real() && same_scale(from, into) =>
            {
                match value.kind {
                    ExprKind::Constant(cell) => {
                        Expr { kind: ExprKind::Constant(into.wrap(cell)), ty: to, at: value.at }
                    }
                    _ => self.reinterpreted(value, to),
                }
            }
            _ => self.converted(value, to),
        }
    }

    /// A value of another type with the same bits, extended or cut where the widths differ.
    pub(super) fn reinterpreted(&mut self, value: Expr, to: Ty) -> Expr {
        if value.ty == to {
            return value;
        }
        let at = value.at;
        match value.kind {
            ExprKind::Constant(_) => Expr { ty: to, ..value },
            _ => Expr { kind: ExprKind::Reinterpret(Box::new(value)), ty: to, at },
        }
    }

    /// Reports a constant that its type's range does not hold.
    pub(super) fn check_subrange(&mut self, value: &Expr, ty: TypeId) {
        if let (Type::Subrange { base, low, high }, ExprKind::Constant(cell)) = (self.ty(ty), &value.kind) {
            let number = base.number(*cell);
            if number < i128::from(*low) || number > i128::from(*high) {
                let message = format!("{number} is outside of {low}..{high}");
                self.findings.error(Code::Range, value.at, message, "choose a value inside");
            }
        }
    }
}

pub(super) fn is_comparison(op: BinaryOp) -> bool {
    matches!(
        op,
        BinaryOp::Equal
            | BinaryOp::NotEqual
            | BinaryOp::Less
            | BinaryOp::LessEqual
            | BinaryOp::Greater
            | BinaryOp::GreaterEqual
    )
}

/// Whether the first operand keeps to the width of its type.
fn is_shift(op: BinaryOp) -> bool {
    use BinaryOp::{RotateLeft, RotateRight, ShiftLeft, ShiftRight};
    matches!(op, ShiftLeft | ShiftRight | RotateLeft | RotateRight)
}

fn real(ty: Elementary, cell: i64) -> f64 {
    if ty == Elementary::Real { f64::from(f32::from_bits(cell as u32)) } else { f64::from_bits(cell as u64) }
}

/// Whether it is an infinity or no number.
fn beyond_reals(ty: Ty, cell: i64) -> bool {
    matches!(ty, Ty::Scalar(ty) if ty.is_real() && !real(ty, cell).is_finite())
}

/// Whether the numbers of both types mean the same.
fn same_scale(a: Elementary, b: Elementary) -> bool {
    let plain = |ty: Elementary| ty.is_integer() || ty == Elementary::Bool;
    plain(a) && plain(b)
}

/// A result in the precision of the type; there is one NaN.
fn real_cell(ty: Elementary, value: f64) -> i64 {
    if ty == Elementary::Real {
        let single = value as f32;
        i64::from(if single.is_nan() { 0x7FC0_0000 } else { single.to_bits() })
    } else if value.is_nan() {
        0x7FF8_0000_0000_0000
    } else {
        value.to_bits() as i64
    }
}

/// `None` for what the machine has to do: divisions by zero.
fn fold(op: BinaryOp, ty: Elementary, a: i64, b: i64) -> Option<i64> {
    if ty.is_real() {
        return fold_real(op, ty, a, b);
    }
    let (x, y) = (ty.number(a), ty.number(b));
    let bits = u32::try_from(b).ok().filter(|n| *n < ty.bits());
    let unsigned = if ty.bits() == 64 { a as u64 } else { a as u64 & ((1 << ty.bits()) - 1) };
    let rotated = |n: i64| {
        let n = n.rem_euclid(i64::from(ty.bits())) as u32;
        let right = if n == 0 { 0 } else { unsigned >> (ty.bits() - n) };
        ty.wrap((unsigned << n | right) as i64)
    };
    Some(match op {
        BinaryOp::Add => ty.wrap(a.wrapping_add(b)),
        BinaryOp::Subtract => ty.wrap(a.wrapping_sub(b)),
        BinaryOp::Multiply => ty.wrap(a.wrapping_mul(b)),
        BinaryOp::Divide => ty.wrap(x.checked_div(y)? as i64),
        BinaryOp::Mod => ty.wrap(x.checked_rem(y)? as i64),
        BinaryOp::And | BinaryOp::AndThen => a & b,
        BinaryOp::Or | BinaryOp::OrElse => a | b,
        BinaryOp::Xor => a ^ b,
        BinaryOp::ShiftLeft => bits.map_or(0, |n| ty.wrap((unsigned << n) as i64)),
        BinaryOp::ShiftRight if ty.signed() => u32::try_from(b).map_or(0, |n| ty.wrap(a >> n.min(63))),
        BinaryOp::ShiftRight => bits.map_or(0, |n| ty.wrap((unsigned >> n) as i64)),
        BinaryOp::RotateLeft => rotated(b),
        BinaryOp::RotateRight => rotated(b.wrapping_neg()),
        BinaryOp::Least => {
            if x <= y {
                a
            } else {
                b
            }
        }
        BinaryOp::Greatest => {
            if x >= y {
                a
            } else {
                b
            }
        }
        BinaryOp::Equal => i64::from(x == y),
        BinaryOp::NotEqual => i64::from(x != y),
        BinaryOp::Less => i64::from(x < y),
        BinaryOp::LessEqual => i64::from(x <= y),
        BinaryOp::Greater => i64::from(x > y),
        BinaryOp::GreaterEqual => i64::from(x >= y),
    })
}

fn fold_real(op: BinaryOp, ty: Elementary, a: i64, b: i64) -> Option<i64> {
    let (x, y) = (real(ty, a), real(ty, b));
    // Singles are computed as doubles and rounded once more, which gives the result of a single operation.
    let result = match op {
        BinaryOp::Add => x + y,
        BinaryOp::Subtract => x - y,
        BinaryOp::Multiply => x * y,
        BinaryOp::Divide if y == 0.0 => return None,
        BinaryOp::Divide => x / y,
        BinaryOp::Equal => return Some(i64::from(x == y)),
        BinaryOp::NotEqual => return Some(i64::from(x != y)),
        BinaryOp::Less => return Some(i64::from(x < y)),
        BinaryOp::LessEqual => return Some(i64::from(x <= y)),
        BinaryOp::Greater => return Some(i64::from(x > y)),
        BinaryOp::GreaterEqual => return Some(i64::from(x >= y)),
        // As the machine does: -0.0 comes before 0.0, and NaN wins.
        BinaryOp::Least | BinaryOp::Greatest if x.is_nan() || y.is_nan() => f64::NAN,
        BinaryOp::Least => {
            if x.total_cmp(&y).is_lt() {
                x
            } else {
                y
            }
        }
        BinaryOp::Greatest => {
            if x.total_cmp(&y).is_gt() {
                x
            } else {
                y
            }
        }
        _ => return None,
    };
    Some(real_cell(ty, result))
}
