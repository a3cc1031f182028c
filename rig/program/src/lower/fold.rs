//! Values that are known at compile time, and the types that operators give.

use crate::parse::ast::BinaryOp;
use crate::types::Elementary;

/// What an expression came to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Operand {
    /// A number without a type, which takes the type that its neighbour has.
    Literal(i128),
    /// A constant of a type. Nothing has been emitted for it.
    Known(i128, Elementary),
    /// On top of the operand stack. `loose` for bits of a direct address, which suit numbers of their width silently.
    Stack { ty: Elementary, loose: bool },
    /// Was reported.
    Wrong,
}

impl Operand {
    pub fn stack(ty: Elementary) -> Self {
        Operand::Stack { ty, loose: false }
    }

    /// The constant, if it is one.
    pub fn known(self) -> Option<i128> {
        match self {
            Operand::Literal(n) | Operand::Known(n, _) => Some(n),
            Operand::Stack { .. } | Operand::Wrong => None,
        }
    }

    /// The type; of a literal the smallest of INT, DINT, LINT and ULINT.
    pub fn ty(self) -> Option<Elementary> {
        match self {
            Operand::Literal(n) => literal_type(n),
            Operand::Known(_, ty) | Operand::Stack { ty, .. } => Some(ty),
            Operand::Wrong => None,
        }
    }

    pub fn is_literal(self) -> bool {
        matches!(self, Operand::Literal(_))
    }
}

fn literal_type(n: i128) -> Option<Elementary> {
    use Elementary::{Dint, Int, Lint, Ulint};
    [Int, Dint, Lint, Ulint].into_iter().find(|ty| in_range(n, *ty))
}

pub(super) fn in_range(n: i128, ty: Elementary) -> bool {
    let (low, high) = ty.range();
    low <= n && n <= high
}

/// The type in which two integers meet: the one that holds both, else the smallest signed one that does.
/// A literal takes the type of the other where it fits.
pub(super) fn common(a: Operand, b: Operand) -> Option<Elementary> {
    match (a, b) {
        (Operand::Literal(n), other) | (other, Operand::Literal(n)) if !other.is_literal() => {
            let ty = other.ty()?;
            if ty == Elementary::Bool && (n == 0 || n == 1) {
                return Some(ty);
            }
            if ty.is_integer() && in_range(n, ty) {
                return Some(ty);
            }
            meet(ty, literal_type(n)?)
        }
        (Operand::Literal(a), Operand::Literal(b)) => meet(literal_type(a)?, literal_type(b)?),
        _ => meet(a.ty()?, b.ty()?),
    }
}

fn meet(a: Elementary, b: Elementary) -> Option<Elementary> {
    if a == b {
        return Some(a);
    }
    if !a.is_integer() || !b.is_integer() {
        return None;
    }
    if a.holds(b) {
        return Some(a);
    }
    if b.holds(a) {
        return Some(b);
    }
    use Elementary::{Dint, Int, Lint};
    [Int, Dint, Lint].into_iter().find(|ty| ty.holds(a) && ty.holds(b))
}

/// A binary operation on constants, exact. `None` for a division by 0.
pub(super) fn fold(op: BinaryOp, a: i128, b: i128) -> Option<i128> {
    Some(match op {
        BinaryOp::Or => a | b,
        BinaryOp::Xor => a ^ b,
        BinaryOp::And => a & b,
        BinaryOp::Equal => i128::from(a == b),
        BinaryOp::NotEqual => i128::from(a != b),
        BinaryOp::Less => i128::from(a < b),
        BinaryOp::LessEqual => i128::from(a <= b),
        BinaryOp::Greater => i128::from(a > b),
        BinaryOp::GreaterEqual => i128::from(a >= b),
        // Operands have at most 64 bits and a sign: nothing here leaves 128 bits but a product of two ULINT, which wraps
        // to the same low bits.
        BinaryOp::Add => a + b,
        BinaryOp::Subtract => a - b,
        BinaryOp::Multiply => a.wrapping_mul(b),
        BinaryOp::Divide => a.checked_div(b)?,
        BinaryOp::Mod => a.checked_rem(b)?,
    })
}

/// A number cut to the width of a type.
pub(super) fn wrapped(n: i128, ty: Elementary) -> i128 {
    ty.number(ty.wrap(n as i64))
}
