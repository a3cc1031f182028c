//! Integer promotion: a whole number of fewer than 32 bits is computed in 32, as the processor of the controllers does
//! (decision 64). Its type stays what it was, for what it may be assigned to; only a store, a parameter or a written
//! conversion into a type cuts it.
//!
//! Sums, differences, products and bit operations have the same low bits in every width. So an expression stays in the
//! width of its type until its high bits matter: where it is compared, divided, extended or made a real. There it is
//! promoted: made again in 32 bits.

use super::Sema;
use crate::codes::Code;
use crate::tree::{BinaryOp, Expr, ExprKind, Ty, UnaryOp};
use crate::types::Elementary;

/// Operators whose result may need more bits than their type has.
fn grows(op: BinaryOp) -> bool {
    matches!(op, BinaryOp::Add | BinaryOp::Subtract | BinaryOp::Multiply)
}

fn is_bitwise(op: BinaryOp) -> bool {
    matches!(op, BinaryOp::And | BinaryOp::Or | BinaryOp::Xor)
}

/// Whether the high bits of both operands matter to the result.
fn needs_high_bits(op: BinaryOp) -> bool {
    use BinaryOp::{Divide, Equal, Greater, GreaterEqual, Greatest, Least, Less, LessEqual, Mod, NotEqual};
    matches!(
        op,
        Divide | Mod | Least | Greatest | Equal | NotEqual | Less | LessEqual | Greater | GreaterEqual
    )
}

/// The type, where it is one that is promoted.
fn small(ty: Ty) -> Option<Elementary> {
    match ty {
        Ty::Scalar(ty) if ty.is_promoted() => Some(ty),
        _ => None,
    }
}

/// What stands in 32 bits for a value of this type: `Reinterpret` of a promoted value with its own type.
fn in_32_bits(value: &Expr) -> Option<&Expr> {
    match (&value.kind, small(value.ty)) {
        (ExprKind::Reinterpret(inner), Some(ty)) if inner.ty == Ty::Promoted(ty) => Some(inner),
        _ => None,
    }
}

/// Whether a value may be outside of the range of its type: the result of operations that was not cut yet.
pub(super) fn exceeds(value: &Expr) -> bool {
    found(value, |op, _| grows(op) || op == BinaryOp::Divide, true)
}

/// Whether a difference of unsigned numbers may be below 0 in a value.
fn may_be_below_0(value: &Expr) -> bool {
    found(value, |op, ty| op == BinaryOp::Subtract && !ty.signed(), false)
}

/// Whether the part of a value that is not cut has such an operator; `negated` where the negation of a signed number
/// counts too. Sums without recursion: chains of operators are deep.
fn found(value: &Expr, wanted: fn(BinaryOp, Elementary) -> bool, negated: bool) -> bool {
    let mut waiting = vec![value];
    while let Some(value) = waiting.pop() {
        let ty = match value.ty {
            Ty::Promoted(ty) => ty,
            other => match small(other) {
                Some(ty) => ty,
                None => continue,
            },
        };
        if negated && in_32_bits(value).is_some() {
            return true;
        }
        match &value.kind {
            ExprKind::Binary(BinaryOp::Divide, _, b) => {
                // Only the least number by -1 is out of range.
                let minus_one = !matches!(b.kind, ExprKind::Constant(n) if n != -1);
                if ty.signed() && minus_one && wanted(BinaryOp::Divide, ty) {
                    return true;
                }
            }
            // What is masked with a value of the type is one.
            ExprKind::Binary(BinaryOp::And, a, b) if !ty.signed() => {
                let both = found(a, wanted, negated) && found(b, wanted, negated);
                if both {
                    return true;
                }
            }
            ExprKind::Binary(op, a, b) if grows(*op) || is_bitwise(*op) => {
                if wanted(*op, ty) {
                    return true;
                }
                waiting.extend([a.as_ref(), b.as_ref()]);
            }
            ExprKind::Unary(UnaryOp::Negate | UnaryOp::Absolute, _) if negated && ty.signed() => return true,
            ExprKind::Unary(UnaryOp::Negate | UnaryOp::Absolute, inner) => waiting.push(inner),
            ExprKind::Select(_, values) => waiting.extend(values),
            ExprKind::Sequence(_, inner) => waiting.push(inner),
            ExprKind::Reinterpret(inner) if matches!(inner.ty, Ty::Promoted(own) if own == ty) => {
                waiting.push(inner);
            }
            _ => {}
        }
    }
    false
}

/// The number of a constant of whole numbers, where it is not cut yet the whole of it.
pub(super) fn whole_constant(value: &Expr) -> Option<i128> {
    let whole = in_32_bits(value).unwrap_or(value);
    match (&whole.kind, whole.ty) {
        (ExprKind::Constant(cell), Ty::Promoted(ty)) => Some(ty.promoted().number(*cell)),
        (ExprKind::Constant(cell), Ty::Scalar(ty)) if ty.is_integer() => Some(ty.number(*cell)),
        _ => None,
    }
}

impl Sema<'_> {
    /// A value whose high bits matter: in 32 bits where it may be outside of the range of its type.
    pub(super) fn promoted(&mut self, value: Expr) -> Expr {
        match small(value.ty) {
            Some(ty) if exceeds(&value) => self.in_promoted(value, ty),
            _ => value,
        }
    }

    /// Both operands of an operator, in 32 bits where their high bits matter and one of them may be outside of the
    /// range of their type.
    pub(super) fn promoted_for(&mut self, op: BinaryOp, left: Expr, right: Expr) -> (Expr, Expr) {
        match small(left.ty) {
            Some(ty) if needs_high_bits(op) && (exceeds(&left) || exceeds(&right)) => {
                self.check_below_0(&left);
                self.check_below_0(&right);
                (self.in_promoted(left, ty), self.in_promoted(right, ty))
            }
            _ => (left, right),
        }
    }

    /// All values in 32 bits where one of them may be outside of the range of their type.
    pub(super) fn all_promoted(&mut self, values: Vec<Expr>) -> Vec<Expr> {
        let Some(ty) = values.first().and_then(|value| small(value.ty)) else { return values };
        if !values.iter().any(exceeds) {
            return values;
        }
        values.into_iter().map(|value| self.in_promoted(value, ty)).collect()
    }

    /// A value in 32 bits, to stand where values of `ty` are computed: signed or not as that type.
    pub(super) fn in_promoted(&mut self, value: Expr, ty: Elementary) -> Expr {
        let to = Ty::Promoted(ty);
        let Some(own) = small(value.ty) else { return value };
        // The left sides without recursion: chains of operators are deep.
        let mut rights = Vec::new();
        let mut left = value;
        let mut kind = left.kind;
        loop {
            match kind {
                ExprKind::Binary(op, a, b) if grows(op) || is_bitwise(op) || op == BinaryOp::Divide => {
                    rights.push((op, *b, left.at));
                    left = *a;
                    kind = left.kind;
                }
                other => {
                    left.kind = other;
                    break;
                }
            }
        }
        let mut whole = self.operand_promoted(left, own);
        for (op, right, at) in rights.into_iter().rev() {
            let right = self.in_promoted(right, own);
            whole = self.binary(op, whole, right, at);
        }
        Expr { ty: to, ..whole }
    }

    fn operand_promoted(&mut self, value: Expr, own: Elementary) -> Expr {
        let (to, at) = (Ty::Promoted(own), value.at);
        if in_32_bits(&value).is_some() {
            return match value.kind {
                ExprKind::Reinterpret(inner) => *inner,
                _ => value,
            };
        }
        match value.kind {
            ExprKind::Constant(_) => Expr { ty: to, ..value },
            // Extended twice is extended once.
            ExprKind::Reinterpret(inner) if small(inner.ty).is_some_and(|from| own.holds(from)) => {
                Expr { kind: ExprKind::Reinterpret(inner), ty: to, at }
            }
            ExprKind::Unary(op @ (UnaryOp::Negate | UnaryOp::Absolute), inner) => {
                let inner = self.in_promoted(*inner, own);
                self.unary(op, inner, at)
            }
            ExprKind::Sequence(before, inner) => {
                let inner = self.in_promoted(*inner, own);
                Expr { ty: to, kind: ExprKind::Sequence(before, Box::new(inner)), at }
            }
            kind => Expr {
                kind: ExprKind::Reinterpret(Box::new(Expr { kind, ty: Ty::Scalar(own), at })),
                ty: to,
                at,
            },
        }
    }

    /// A result of 32 bits as a value of its own type, which is not cut yet.
    pub(super) fn uncut(&mut self, value: Expr) -> Expr {
        let Ty::Promoted(ty) = value.ty else { return value };
        let (own, at) = (Ty::Scalar(ty), value.at);
        match value.kind {
            ExprKind::Constant(cell) if ty.wrap(cell) == cell => Expr { ty: own, ..value },
            _ => Expr { kind: ExprKind::Reinterpret(Box::new(value)), ty: own, at },
        }
    }

    /// A value as a variable of its type holds it: constants are cut at once.
    pub(super) fn cut(&mut self, value: Expr) -> Expr {
        match (in_32_bits(&value).map(|whole| &whole.kind), small(value.ty)) {
            (Some(ExprKind::Constant(cell)), Some(ty)) => self.constant(ty.wrap(*cell), ty, value.at),
            _ => value,
        }
    }

    /// Warns where a difference of small unsigned numbers is looked at in 32 bits: it does not wrap at its own width.
    pub(super) fn check_below_0(&mut self, value: &Expr) {
        let ty = match value.ty {
            Ty::Promoted(ty) => ty,
            other => match small(other) {
                Some(ty) => ty,
                None => return,
            },
        };
        if whole_constant(value).is_none() && may_be_below_0(value) {
            let (_, high) = ty.range();
            let message = format!(
                "the difference is computed in 32 bits: where it is below 0 it does not go on at {high}, \
                 the end of {}",
                ty.name()
            );
            let help =
                format!("TO_{}(...) around it cuts it; convert its operands to DINT for a sign", ty.name());
            self.findings.warning(Code::NotCut, value.at, message, help);
        }
    }
}
