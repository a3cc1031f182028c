//! Conversions, texts, and functions of the library.

use super::{Dest, Emitter, Value, ops};
use crate::code::{LibraryArgument, LibraryCall, LibraryCode, Op, Operand, TextAt, TextPair};
use crate::findings::SourcePlace;
use crate::library::Function;
use crate::tree::{Expr, Ty};
use crate::types::Elementary;

/// Whether a conversion only takes the low bytes of the memory as they are.
pub(super) fn is_cut(from: Ty, to: Ty) -> bool {
    if !matches!((from, to), (Ty::Scalar(_) | Ty::Promoted(_), Ty::Scalar(_) | Ty::Promoted(_))) {
        return from == to;
    }
    let (from, to) = (ops::scalar(from), ops::scalar(to));
    let whole = |ty: Elementary| ty.is_integer() || ty == Elementary::Time;
    from == to
        || whole(from) && whole(to) && to.bytes() <= from.bytes()
        || from == Elementary::Bool && to.is_integer() && to.bytes() == 1
}

/// Whether the bytes of one type are taken as the other.
pub(super) fn same_bits(from: Ty, to: Ty) -> bool {
    let cell = |ty| matches!(ty, Ty::Scalar(_) | Ty::Promoted(_) | Ty::Address);
    is_cut(from, to) || cell(from) && cell(to) && from.bytes() == to.bytes()
}

impl Emitter<'_, '_, '_> {
    /// What a conversion costs that is written in the source: an operation of the wider type.
    pub(super) fn conversion(&self, from: Ty, to: Ty) -> u32 {
        if matches!(from, Ty::Text { .. }) || matches!(to, Ty::Text { .. }) {
            return self.costs.text;
        }
        let (from, to) = (ops::priced(from), ops::priced(to));
        self.costs.op(if from.bits() > to.bits() { from } else { to })
    }

    /// Brings a value into the type of the destination.
    pub(super) fn convert(&mut self, value: Value, to: Dest, cost: u32, at: SourcePlace) {
        let (from, into) = match (value.ty, to.ty) {
            (Ty::Text { .. }, Ty::Text { .. }) | (Ty::Block { .. }, _) | (_, Ty::Block { .. }) => {
                return self.transfer(to, value, cost, at);
            }
            (from, Ty::Text { .. }) => {
                let code = LibraryCode::ToText(ops::scalar(from));
                return self.call_library(code, Elementary::Bool, &[value], to, cost, at);
            }
            (Ty::Text { .. }, into) => {
                let code = LibraryCode::FromText(ops::scalar(into));
                return self.call_library(code, Elementary::Bool, &[value], to, cost, at);
            }
            (from, into) if is_cut(from, into) => return self.transfer(to, value, cost, at),
            (from, into) => (ops::scalar(from), ops::scalar(into)),
        };
        let cost = cost.saturating_add(value.cost).saturating_add(to.cost);
        let bool = Elementary::Bool;
        let widened = (from == bool || from.is_integer()) && into.is_integer();
        let op = ops::convert(from, into).or_else(|| ops::extend(from, into).filter(|_| widened));
        if let Some(op) = op {
            self.operate(op, [to.at, value.at, Operand(0)], cost, at);
        } else if into == bool && from.is_integer() {
            let zero = self.constant(0, value.ty);
            let op = ops::compare(ops::CompareRelation::NotEqual, from);
            self.operate(op, [to.at, value.at, zero.at], cost, at);
        } else {
            let types = u32::from(from as u8) << 8 | u32::from(into as u8);
            self.push(Op::Convert, (to.at.0, value.at.0, types), cost, at);
        }
    }

    pub(super) fn move_text(&mut self, to: Dest, value: Value, cost: u32, at: SourcePlace) {
        let entry = self.texts.len() as u32;
        self.texts.push(TextPair { to: text_at(to.at, to.ty), of: text_at(value.at, value.ty) });
        self.push(Op::MoveText, (to.at.0, value.at.0, entry), cost, at);
    }

    /// The order of two texts: -1, 0 or 1 as SINT.
    pub(super) fn compare_texts(&mut self, to: Operand, a: Value, b: Value, at: SourcePlace) {
        let entry = self.texts.len() as u32;
        self.texts.push(TextPair { to: text_at(a.at, a.ty), of: text_at(b.at, b.ty) });
        let cost = self.costs.text.saturating_add(a.cost).saturating_add(b.cost);
        self.push(Op::CompareText, (to.0, 0, entry), cost, at);
    }

    pub(super) fn library(
        &mut self,
        function: &'static Function,
        generic: Elementary,
        arguments: &[Expr],
        to: Dest,
        at: SourcePlace,
    ) {
        let arguments = self.values(&arguments.iter().collect::<Vec<_>>());
        let text = |ty: Ty| matches!(ty, Ty::Text { .. });
        let texts = text(to.ty) || arguments.iter().any(|argument| text(argument.ty));
        let cost = if texts { self.costs.text } else { self.costs.function };
        self.call_library(LibraryCode::Function(function), generic, &arguments, to, cost, at);
    }

    fn call_library(
        &mut self,
        code: LibraryCode,
        generic: Elementary,
        arguments: &[Value],
        to: Dest,
        cost: u32,
        at: SourcePlace,
    ) {
        let cost =
            arguments.iter().fold(cost.saturating_add(to.cost), |sum, value| sum.saturating_add(value.cost));
        let arguments = arguments.iter().map(|value| argument(value.at, value.ty)).collect();
        let entry = self.library.len() as u32;
        self.library.push(LibraryCall { code, generic, arguments, result: argument(to.at, to.ty) });
        self.push(Op::CallLibrary, (to.at.0, entry, 0), cost, at);
    }
}

fn argument(at: Operand, ty: Ty) -> LibraryArgument {
    match ty {
        Ty::Text { .. } => LibraryArgument::Text(text_at(at, ty)),
        _ => LibraryArgument::Cell(at, ops::scalar(ty)),
    }
}

fn text_at(at: Operand, ty: Ty) -> TextAt {
    TextAt { at, bytes: ty.bytes(), wide: matches!(ty, Ty::Text { wide: true, .. }) }
}
