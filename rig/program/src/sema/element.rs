//! Elements of arrays, texts and what pointers lead to; bits and other parts of whole numbers.

use super::Sema;
use super::literal::LiteralOperand;
use super::place::PathMeaning;
use super::promote::whole_constant;
use super::scope::FoundName;
use super::types::{Type, TypeId, WRONG, stride};
use crate::codes::Code;
use crate::findings::{SourcePlace, count};
use crate::parse::ast::{self, Name};
use crate::tree::{self, Expr, ExprKind, TreePlace, Ty};
use crate::types::Elementary;

impl Sema<'_> {
    pub(super) fn index_meaning(
        &mut self,
        of: &ast::Expr,
        indices: &[ast::Expr],
        at: SourcePlace,
    ) -> PathMeaning {
        let (place, ty, fixed) = match self.meaning(of) {
            PathMeaning::Place(place, ty, fixed) => (place, ty, fixed),
            PathMeaning::Wrong => return PathMeaning::Wrong,
            PathMeaning::Property(instance, property) => {
                let value = self.get_property(&instance, property);
                let Some((value, ty)) = self.own_value(value, of.at) else { return PathMeaning::Wrong };
                (self.held_value(value, of.at), ty, Some("it is a value"))
            }
            PathMeaning::Operand(operand) => {
                let Some((value, ty)) = self.own_value(operand, of.at) else { return PathMeaning::Wrong };
                (self.held_value(value, of.at), ty, Some("it is a value"))
            }
            _ => {
                self.findings.error(Code::NotAValue, at, "this has no elements", "arrays and texts have");
                return PathMeaning::Wrong;
            }
        };
        match self.ty(ty).clone() {
            Type::Array { dimensions, of } => {
                let (place, ty) = match self.indexed(place, &dimensions, of, indices, at) {
                    Some(found) => found,
                    None => return PathMeaning::Wrong,
                };
                self.followed(place, ty, fixed)
            }
            Type::Open { .. } => match self.open_element(place, ty, indices, at) {
                Some((place, ty)) => self.followed(place, ty, fixed),
                None => PathMeaning::Wrong,
            },
            Type::Text { wide, length } => {
                let unit = if wide { Elementary::Word } else { Elementary::Byte };
                let of = self.elementary(unit);
                match self.indexed(place, &[(0, i64::from(length))], of, indices, at) {
                    Some((place, ty)) => PathMeaning::Place(place, ty, fixed),
                    None => PathMeaning::Wrong,
                }
            }
            Type::Pointer(to) => {
                let [index] = indices else {
                    self.findings.error(Code::Index, at, "a pointer takes one index", "");
                    return PathMeaning::Wrong;
                };
                let lint = self.elementary(Elementary::Lint);
                let Some(index) = self.value(index, lint) else { return PathMeaning::Wrong };
                let step = i64::from(stride(self.layout(to)));
                let step = self.constant(step, Elementary::Lint, at);
                let bytes = self.binary(tree::BinaryOp::Multiply, index, step, at);
                let pointer = Expr { kind: ExprKind::Load(place), ty: Ty::Address, at };
                let kind = ExprKind::Offset(Box::new(pointer), Box::new(bytes));
                let address = Expr { kind, ty: Ty::Address, at };
                let place = self.place(tree::TreeRoot::Address(Box::new(address)), 0, to, false, at);
                self.followed(place, to, None)
            }
            Type::Wrong => PathMeaning::Wrong,
            _ => {
                let message = format!("{} has no elements", self.type_name(ty));
                self.findings.error(Code::NotAValue, at, message, "arrays and texts have");
                PathMeaning::Wrong
            }
        }
    }

    /// An element of an array; constant indices become part of the offset. Too few indices give an error.
    fn indexed(
        &mut self,
        mut place: TreePlace,
        dimensions: &[(i64, i64)],
        of: TypeId,
        indices: &[ast::Expr],
        at: SourcePlace,
    ) -> Option<(TreePlace, TypeId)> {
        // `a[1, 2]` may stand for `a[1][2]` where the elements are arrays.
        if indices.len() > dimensions.len()
            && let Type::Array { dimensions: inner, of: element } = self.ty(of).clone()
        {
            let (first, rest) = indices.split_at(dimensions.len());
            let (place, _) = self.indexed(place, dimensions, of, first, at)?;
            return self.indexed(place, &inner, element, rest, at);
        }
        if indices.len() != dimensions.len() {
            let message =
                format!("the array has {}, not {}", count(dimensions.len(), "dimension"), indices.len());
            self.findings.error(Code::Index, at, message, "give one index for each");
            return None;
        }
        let mut step = u64::from(stride(self.layout(of)));
        let mut strides = Vec::with_capacity(dimensions.len());
        for (low, high) in dimensions.iter().rev() {
            strides.push(step);
            step = step.saturating_mul(u64::try_from(i128::from(*high) - i128::from(*low) + 1).unwrap_or(0));
        }
        strides.reverse();
        for ((index, (low, high)), step) in indices.iter().zip(dimensions).zip(strides) {
            let operand = self.expr(index, None);
            let known = match &operand {
                LiteralOperand::Integer(n) => Some(*n),
                LiteralOperand::Value(value, _) => whole_constant(value),
                _ => None,
            };
            if let Some(n) = known {
                if n < i128::from(*low) || n > i128::from(*high) {
                    let message = format!("the index {n} is outside of {low}..{high}");
                    self.findings.error(
                        Code::Index,
                        index.at,
                        message,
                        "the bounds are those of the declaration",
                    );
                    return None;
                }
                let bytes = (n - i128::from(*low)) as u64 * step;
                place.offset = place.offset.wrapping_add(bytes as u32);
                continue;
            }
            let (value, ty) = self.own_value(operand, index.at)?;
            if !self.scalar(ty).is_some_and(Elementary::is_integer) {
                if ty != WRONG {
                    let message = format!("an index is a whole number, this is {}", self.type_name(ty));
                    self.findings.error(Code::Index, index.at, message, "convert it");
                }
                return None;
            }
            let value = self.promoted(value);
            place.indices.push(tree::Index { value, low: *low, high: *high, stride: step as u32 });
        }
        place.ty = self.tree_type(of);
        place.at = place.at.to(at);
        Some((place, of))
    }

    pub(super) fn part_meaning(
        &mut self,
        of: &ast::Expr,
        bits: u8,
        number: u32,
        at: SourcePlace,
    ) -> PathMeaning {
        let (place, ty, fixed) = match self.meaning(of) {
            PathMeaning::Place(place, ty, fixed) => (place, ty, fixed),
            PathMeaning::Wrong => return PathMeaning::Wrong,
            meaning => {
                let operand = self.operand_of(meaning, of.at);
                let Some((value, ty)) = self.own_value(operand, of.at) else { return PathMeaning::Wrong };
                (self.held_value(value, of.at), ty, Some("it is a value"))
            }
        };
        self.part_of(place, ty, fixed, (bits, number), at)
    }

    /// The number of a bit that a constant names, as in `status.READY`.
    pub(super) fn named_bit(&mut self, name: Name) -> Option<u32> {
        let found = self.find(name.key)?;
        if !matches!(found, FoundName::Local(_) | FoundName::Member(..) | FoundName::Global(_)) {
            return None;
        }
        match self.symbol_meaning(found, name) {
            PathMeaning::Operand(LiteralOperand::Value(Expr { kind: ExprKind::Constant(cell), .. }, ty)) => {
                let scalar = self.scalar(ty).filter(|ty| ty.is_integer())?;
                u32::try_from(scalar.number(cell)).ok()
            }
            _ => None,
        }
    }

    /// Part `number` of so many bits of a place.
    pub(super) fn part_of(
        &mut self,
        place: TreePlace,
        ty: TypeId,
        fixed: Option<&'static str>,
        (bits, number): (u8, u32),
        at: SourcePlace,
    ) -> PathMeaning {
        let Some(scalar) = self.scalar(ty).filter(|ty| ty.is_integer()) else {
            if ty != WRONG {
                let message = format!("{} has no bits", self.type_name(ty));
                self.findings.error(Code::NotAValue, at, message, "whole numbers and bit strings have");
            }
            return PathMeaning::Wrong;
        };
        let parts = scalar.bits() / u32::from(bits.max(1));
        if number >= parts || (bits > 1 && u32::from(bits) >= scalar.bits()) {
            let message =
                format!("{} has no part {number} of {}", scalar.name(), count(u32::from(bits), "bit"));
            let help = if parts > 0 { format!("0 to {}", parts - 1) } else { String::new() };
            self.findings.error(Code::Index, at, message, help);
            return PathMeaning::Wrong;
        }
        if bits == 1 {
            return PathMeaning::Bit(place, number, fixed);
        }
        let part = match bits {
            8 => Elementary::Byte,
            16 => Elementary::Word,
            _ => Elementary::Dword,
        };
        let ty = self.elementary(part);
        let place = self.inside(place, number * u32::from(bits) / 8, ty, at);
        PathMeaning::Place(place, ty, fixed)
    }
}
