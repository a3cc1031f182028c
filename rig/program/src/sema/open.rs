//! Arrays of variable length, `ARRAY[*]`: in-outs that bring their bounds along. After the address of the array the
//! slot of such an in-out holds two DINT for each dimension, the lower and the upper bound.

use super::Sema;
use super::argument::CallParameter;
use super::literal::LiteralOperand;
use super::place::PathMeaning;
use super::types::{Type, TypeId, stride};
use crate::codes::Code;
use crate::findings::{SourcePlace, count};
use crate::parse::ast;
use crate::tree::{
    BinaryOp, CallInput, Expr, ExprKind, Index, Slot, Stmt, StmtKind, Target, TreePlace, TreeRoot, Ty,
};
use crate::types::Elementary;

const LINT: Ty = Ty::Scalar(Elementary::Lint);
const DINT: Ty = Ty::Scalar(Elementary::Dint);

/// Bytes of a slot that holds an address.
const ADDRESS: u32 = 4;

impl Sema<'_> {
    /// Bytes of the slot of an in-out.
    pub(super) fn in_out_size(&self, ty: TypeId) -> u32 {
        match self.ty(ty) {
            Type::Open { dimensions, .. } => ADDRESS + dimensions * 8,
            _ => ADDRESS,
        }
    }

    /// A bound in the slot of an in-out.
    fn bound_place(&self, slot: &TreePlace, dimension: u32, upper: bool) -> TreePlace {
        let offset = slot.offset + ADDRESS + dimension * 8 + if upper { 4 } else { 0 };
        TreePlace { offset, ty: DINT, ..slot.clone() }
    }

    /// The bound of a variable as a value of LINT.
    fn bound_value(&mut self, slot: &TreePlace, dimension: u32, upper: bool, at: SourcePlace) -> Expr {
        let kind = ExprKind::Load(self.bound_place(slot, dimension, upper));
        self.widened(Expr { kind, ty: DINT, at }, LINT)
    }

    /// The slot of an in-out whose place this is.
    fn slot_of(place: &TreePlace) -> Option<&TreePlace> {
        let TreeRoot::Address(address) = &place.root else { return None };
        match &address.kind {
            ExprKind::Load(slot) if place.offset == 0 && place.indices.is_empty() => Some(slot),
            _ => None,
        }
    }

    /// The bounds that go with an array into an in-out of variable length.
    pub(super) fn open_inputs(&mut self, written: &ast::Expr, parameter: &CallParameter) -> Vec<CallInput> {
        let Type::Open { dimensions, .. } = *self.ty(parameter.ty) else { return Vec::new() };
        let PathMeaning::Place(place, ty, _) = self.meaning(written) else { return Vec::new() };
        let at = written.at;
        let known = match self.ty(ty) {
            Type::Array { dimensions, .. } => dimensions.clone(),
            _ => Vec::new(),
        };
        let mut inputs = Vec::new();
        for dimension in 0..dimensions {
            for upper in [false, true] {
                let value = match (known.get(dimension as usize), Self::slot_of(&place)) {
                    (Some((low, high)), _) => {
                        let cell = if upper { *high } else { *low };
                        self.constant(Elementary::Dint.wrap(cell), Elementary::Dint, at)
                    }
                    (None, Some(slot)) => {
                        let kind = ExprKind::Load(self.bound_place(slot, dimension, upper));
                        Expr { kind, ty: DINT, at }
                    }
                    (None, None) => return Vec::new(),
                };
                let to = match &parameter.slot {
                    Slot::Frame(offset, _) => {
                        Slot::Frame(offset + ADDRESS + dimension * 8 + if upper { 4 } else { 0 }, DINT)
                    }
                    Slot::Place(slot) => Slot::Place(self.bound_place(slot, dimension, upper)),
                };
                inputs.push(CallInput { to, value });
            }
        }
        inputs
    }

    /// An element of an array of variable length: its address is computed, each index checked against its bounds.
    pub(super) fn open_element(
        &mut self,
        place: TreePlace,
        ty: TypeId,
        indices: &[ast::Expr],
        at: SourcePlace,
    ) -> Option<(TreePlace, TypeId)> {
        let Type::Open { dimensions, of } = *self.ty(ty) else { return None };
        let Some(slot) = Self::slot_of(&place).cloned() else {
            self.findings.error(Code::NotAValue, at, "the bounds of this array are not known here", "");
            return None;
        };
        if indices.len() != dimensions as usize {
            let message = format!("the array has {}, not {}", count(dimensions, "dimension"), indices.len());
            self.findings.error(Code::Index, at, message, "give one index for each");
            return None;
        }
        let mut before = Vec::new();
        let step = i64::from(stride(self.layout(of)));
        let mut bytes: Option<Expr> = None;
        for (dimension, written) in (0..dimensions).zip(indices) {
            let operand = self.expr(written, None);
            let (index, index_type) = self.own_value(operand, written.at)?;
            if !self.scalar(index_type).is_some_and(Elementary::is_integer) {
                let message = format!("an index is a whole number, this is {}", self.type_name(index_type));
                self.findings.error(Code::Index, written.at, message, "convert it");
                return None;
            }
            let index = self.widened(index, LINT);
            let held = self.checked_index(index, &slot, dimension, &mut before, written.at);
            let low = self.bound_value(&slot, dimension, false, at);
            let relative = self.binary(BinaryOp::Subtract, held, low, at);
            bytes = Some(match bytes {
                None => relative,
                Some(so_far) => {
                    let (high, low) = (
                        self.bound_value(&slot, dimension, true, at),
                        self.bound_value(&slot, dimension, false, at),
                    );
                    let width = self.binary(BinaryOp::Subtract, high, low, at);
                    let one = self.constant(1, Elementary::Lint, at);
                    let width = self.binary(BinaryOp::Add, width, one, at);
                    let rows = self.binary(BinaryOp::Multiply, so_far, width, at);
                    self.binary(BinaryOp::Add, rows, relative, at)
                }
            });
        }
        let step = self.constant(step, Elementary::Lint, at);
        let bytes = self.binary(BinaryOp::Multiply, bytes?, step, at);
        let start = Expr { kind: ExprKind::Load(slot), ty: Ty::Address, at };
        let kind = ExprKind::Offset(Box::new(start), Box::new(bytes));
        let address = Expr { kind, ty: Ty::Address, at };
        let address = Expr { kind: ExprKind::Sequence(before, Box::new(address)), ty: Ty::Address, at };
        Some((self.place(TreeRoot::Address(Box::new(address)), 0, of, false, at), of))
    }

    /// Puts an index into a variable without a name and lets the machine stop where it is outside of its bounds.
    fn checked_index(
        &mut self,
        index: Expr,
        slot: &TreePlace,
        dimension: u32,
        before: &mut Vec<Stmt>,
        at: SourcePlace,
    ) -> Expr {
        let frame = |offset: u32, ty: Ty| TreePlace {
            root: TreeRoot::Frame,
            offset,
            indices: Vec::new(),
            ty,
            retained: false,
            at,
        };
        let held = frame(self.hidden(LINT), LINT);
        let load = Expr { kind: ExprKind::Load(held.clone()), ty: LINT, at };
        before.push(Stmt { kind: StmtKind::Assign(Target::Place(held), index), at });
        let (low, high) =
            (self.bound_value(slot, dimension, false, at), self.bound_value(slot, dimension, true, at));
        let below = self.binary(BinaryOp::Less, load.clone(), low, at);
        let above = self.binary(BinaryOp::Greater, load.clone(), high, at);
        let outside = self.binary(BinaryOp::Or, below, above, at);
        // An array without elements: every index of it is a fault.
        let byte = Ty::Scalar(Elementary::Byte);
        let never = Index { value: load.clone(), low: 1, high: 0, stride: 1 };
        let empty = frame(self.hidden(byte), byte);
        let element = TreePlace { indices: vec![never], ..empty.clone() };
        let read = Expr { kind: ExprKind::Load(element), ty: byte, at };
        let fault = Stmt { kind: StmtKind::Assign(Target::Place(empty), read), at };
        let arms = vec![(outside, vec![fault])];
        before.push(Stmt { kind: StmtKind::If { arms, otherwise: Vec::new() }, at });
        load
    }

    /// LOWER_BOUND and UPPER_BOUND: a DINT, constant for arrays of known length.
    pub(super) fn bound_call(
        &mut self,
        upper: bool,
        values: &[&ast::Expr],
        at: SourcePlace,
    ) -> LiteralOperand {
        let [array, dimension] = values else { return LiteralOperand::Wrong };
        let Some(number) = self.constant_number(dimension) else { return LiteralOperand::Wrong };
        let (place, ty) = match self.meaning(array) {
            PathMeaning::Place(place, ty, _) => (place, ty),
            PathMeaning::Wrong => return LiteralOperand::Wrong,
            _ => {
                self.findings.error(Code::NotAValue, array.at, "only variables have bounds", "");
                return LiteralOperand::Wrong;
            }
        };
        let nth = u32::try_from(number).ok().and_then(|number| number.checked_sub(1));
        let dint = self.elementary(Elementary::Dint);
        match (self.ty(ty).clone(), nth) {
            (Type::Array { dimensions, .. }, Some(nth)) if (nth as usize) < dimensions.len() => {
                let (low, high) = dimensions.get(nth as usize).copied().unwrap_or_default();
                let cell = Elementary::Dint.wrap(if upper { high } else { low });
                LiteralOperand::Value(self.constant(cell, Elementary::Dint, at), dint)
            }
            (Type::Open { dimensions, .. }, Some(nth)) if nth < dimensions => match Self::slot_of(&place) {
                Some(slot) => {
                    let kind = ExprKind::Load(self.bound_place(slot, nth, upper));
                    LiteralOperand::Value(Expr { kind, ty: DINT, at }, dint)
                }
                None => LiteralOperand::Wrong,
            },
            (Type::Array { .. } | Type::Open { .. }, _) => {
                let message = format!("the array has no dimension {number}");
                self.findings.error(Code::Index, dimension.at, message, "the first is 1");
                LiteralOperand::Wrong
            }
            _ => {
                let message = format!("{} has no bounds", self.type_name(ty));
                self.findings.error(Code::Type, array.at, message, "arrays have");
                LiteralOperand::Wrong
            }
        }
    }
}
