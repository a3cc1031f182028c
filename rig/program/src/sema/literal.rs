//! What an expression comes to before its neighbours decide on its type.

use super::Sema;
use super::types::{Type, TypeId, WRONG};
use crate::findings::SourcePlace;
use crate::tree::{Expr, ExprKind, Ty};
use crate::types::Elementary;

/// A value with or without a type of its own.
#[derive(Clone, Debug)]
pub(super) enum LiteralOperand {
    /// A whole number without a type, which takes the type that its neighbour has.
    Integer(i128),
    /// A number with a point, likewise: as double and as single, for rounding twice is not rounding once.
    Real(f64, f32),
    /// A text literal: its units. It suits texts of its width, and one character suits CHAR and WCHAR.
    Text(bool, Vec<u16>),
    /// NULL.
    Null,
    Value(Expr, TypeId),
    /// A call without a result, which only a statement takes.
    Nothing(Expr),
    /// Was reported.
    Wrong,
}

impl LiteralOperand {
    /// Whether it is a literal or made of literals alone.
    pub fn is_literal(&self) -> bool {
        matches!(
            self,
            LiteralOperand::Integer(_)
                | LiteralOperand::Real(..)
                | LiteralOperand::Text(..)
                | LiteralOperand::Null
        )
    }
}

pub(super) fn in_range(n: i128, ty: Elementary) -> bool {
    let (low, high) = ty.range();
    low <= n && n <= high
}

/// The type that a whole number has by itself: the smallest of INT, DINT, LINT and ULINT.
pub(super) fn integer_type(n: i128) -> Option<Elementary> {
    use Elementary::{Dint, Int, Lint, Ulint};
    [Int, Dint, Lint, Ulint].into_iter().find(|ty| in_range(n, *ty))
}

/// A text as it is stored.
pub(super) fn stored(wide: bool, units: &[u16]) -> Vec<u8> {
    let closed = units.iter().copied().chain([0]);
    if wide { closed.flat_map(u16::to_le_bytes).collect() } else { closed.map(|unit| unit as u8).collect() }
}

impl Sema<'_> {
    /// A constant of a scalar type.
    pub(super) fn constant(&self, cell: i64, ty: Elementary, at: SourcePlace) -> Expr {
        Expr { kind: ExprKind::Constant(cell), ty: Ty::Scalar(ty), at }
    }

    /// The type of an operand by itself; WRONG for what has none.
    pub(super) fn own_type(&mut self, operand: &LiteralOperand) -> TypeId {
        match operand {
            LiteralOperand::Integer(n) => integer_type(*n).map_or(WRONG, |ty| self.elementary(ty)),
            // The vendor's tool takes LREAL: nothing of the literal is lost.
            LiteralOperand::Real(..) => self.elementary(Elementary::Lreal),
            LiteralOperand::Text(wide, units) => {
                let length = (units.len() as u32).max(1);
                self.intern(Type::Text { wide: *wide, length })
            }
            LiteralOperand::Value(_, ty) => *ty,
            LiteralOperand::Null | LiteralOperand::Nothing(_) | LiteralOperand::Wrong => WRONG,
        }
    }

    /// The operand as a value of its own type.
    pub(super) fn own_value(&mut self, operand: LiteralOperand, at: SourcePlace) -> Option<(Expr, TypeId)> {
        let ty = self.own_type(&operand);
        match operand {
            LiteralOperand::Value(expr, ty) => Some((expr, ty)),
            LiteralOperand::Wrong | LiteralOperand::Nothing(_) => None,
            _ => self.give(operand, ty, at).map(|expr| (expr, ty)),
        }
    }
}
