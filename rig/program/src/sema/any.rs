//! Inputs of any type: ANY and its kinds. The caller gives a variable, the callee sees its class, address and size, as
//! in the vendor's tool.

use super::Sema;
use super::argument::CallParameter;
use super::place::PathMeaning;
use super::types::{Type, TypeId};
use crate::codes::Code;
use crate::findings::SourcePlace;
use crate::parse::ast;
use crate::tree::{CallInput, Expr, ExprKind, Slot, TreePlace, Ty};
use crate::types::Elementary;

/// Which types an input takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Any(&'static str);

const KINDS: [&str; 7] = ["ANY", "ANY_NUM", "ANY_INT", "ANY_REAL", "ANY_BIT", "ANY_STRING", "ANY_DATE"];

impl<'a> Sema<'a> {
    /// The kind of any type that a name stands for, where the sources do not declare it.
    pub(super) fn any_named(&self, name: ast::Name) -> Option<Any> {
        let text = self.names.key_text(name.key);
        let kind = KINDS.into_iter().find(|kind| *kind == text)?;
        (!self.outside.contains_key(&name.key)).then_some(Any(kind))
    }

    /// What a callee sees of such an input.
    pub(super) fn any_type(&mut self, name: ast::Name) -> TypeId {
        if !std::mem::replace(&mut self.any, false) {
            let message = format!("only an input can be of type {}", self.shown(name));
            self.findings.error(Code::Type, name.at, message, "name one type, or take a POINTER TO BYTE");
            return super::WRONG;
        }
        match self.names.get("__ANY").and_then(|key| self.outside.get(&key).copied()) {
            Some(super::Global::Type(place)) => self.named_type(place),
            _ => super::WRONG,
        }
    }

    /// The values for an input of any type. `None` where something was reported.
    pub(super) fn any_inputs(
        &mut self,
        written: &ast::Expr,
        parameter: &CallParameter,
        kind: Any,
    ) -> Option<Vec<CallInput>> {
        let at = written.at;
        let (place, ty) = match self.meaning(written) {
            PathMeaning::Place(place, ty, _) => (place, ty),
            PathMeaning::Wrong => return None,
            PathMeaning::Bit(..) => {
                let message = "a single bit has no address";
                self.findings.error(Code::Output, at, message, "pass a BOOL variable and copy it");
                return None;
            }
            meaning => {
                let operand = self.operand_of(meaning, at);
                let (value, ty) = self.own_value(operand, at)?;
                (self.held_value(value, at), ty)
            }
        };
        if ty == parameter.ty {
            // Handed on as it came.
            let value = self.value(written, ty)?;
            return Some(vec![CallInput { to: parameter.slot.clone(), value }]);
        }
        if !self.is_any(kind, ty) {
            let message = format!("{} is no {}", self.type_name(ty), kind.0);
            self.findings.error(Code::Type, at, message, "pass a variable of such a type");
            return None;
        }
        let Type::Structure(structure) = *self.ty(parameter.ty) else { return None };
        let fields: Vec<(TypeId, u32)> =
            self.structures.get(structure as usize)?.fields.iter().map(|f| (f.ty, f.offset)).collect();
        let [class, value, size] = fields.as_slice() else { return None };
        let number = |n: i64| Expr { kind: ExprKind::Constant(n), ty: Ty::Scalar(Elementary::Dint), at };
        let values = [
            (*class, number(self.class_of(ty))),
            (*value, self.address_of(place)),
            (*size, number(i64::from(self.layout(ty).size))),
        ];
        Some(values.into_iter().map(|(field, value)| self.field_input(parameter, field, value, at)).collect())
    }

    fn field_input(
        &self,
        parameter: &CallParameter,
        field: (TypeId, u32),
        value: Expr,
        at: SourcePlace,
    ) -> CallInput {
        let (ty, offset) = field;
        let to = match &parameter.slot {
            Slot::Frame(first, _) => Slot::Frame(first + offset, self.tree_type(ty)),
            Slot::Place(place) => Slot::Place(TreePlace { at, ..self.inside(place.clone(), offset, ty, at) }),
        };
        CallInput { to, value }
    }

    fn is_any(&self, kind: Any, ty: TypeId) -> bool {
        let scalar = self.scalar(ty);
        let real = scalar.is_some_and(Elementary::is_real);
        let bits = scalar.is_some_and(|ty| ty.is_bit_string() || ty == Elementary::Bool);
        let whole = scalar.is_some_and(Elementary::is_integer) && !bits;
        match kind.0 {
            "ANY" => !super::is_wrong(ty),
            "ANY_NUM" => whole || real,
            "ANY_INT" => whole,
            "ANY_REAL" => real,
            "ANY_BIT" => bits,
            "ANY_STRING" => matches!(self.ty(ty), Type::Text { .. }),
            _ => scalar.is_some_and(Elementary::is_date),
        }
    }

    /// The number of a type's class, as TYPE_CLASS of the library has it.
    fn class_of(&self, ty: TypeId) -> i64 {
        use Elementary::*;
        match self.ty(ty) {
            Type::Text { wide, .. } => 16 + i64::from(*wide),
            Type::Pointer(_) | Type::RefTo(_) => 22,
            Type::Reference(_) => 23,
            Type::Subrange { .. } => 24,
            Type::Enumeration(_) => 25,
            Type::Array { .. } | Type::Open { .. } => 26,
            Type::Elementary(ty) => match ty {
                Bool => 0,
                Byte => 2,
                Word => 3,
                Dword => 4,
                Lword => 5,
                Sint => 6,
                Int => 7,
                Dint => 8,
                Lint => 9,
                Usint => 10,
                Uint => 11,
                Udint => 12,
                Ulint => 13,
                Real => 14,
                Lreal => 15,
                Char => 16,
                Wchar => 17,
                Time | Ltime => 18,
                Date | Ldate => 19,
                Dt | Ldt => 20,
                Tod | Ltod => 21,
            },
            _ => 28,
        }
    }
}
