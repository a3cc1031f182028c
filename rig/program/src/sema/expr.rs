//! Expressions: what they come to.

use super::Sema;
use super::literal::{LiteralOperand, in_range};
use super::place::PathMeaning;
use super::scope::FoundName;
use super::types::{Type, TypeId, WRONG};
use crate::codes::Code;
use crate::findings::SourcePlace;
use crate::parse::ast;
use crate::tree::{Expr, ExprKind, TreeRoot, Ty, UnaryOp};
use crate::types::Elementary;

impl<'a> Sema<'a> {
    /// What an expression comes to. `expected` helps where a name means several things.
    pub(super) fn expr(&mut self, written: &ast::Expr, expected: Option<TypeId>) -> LiteralOperand {
        let at = written.at;
        match &written.kind {
            ast::ExprKind::Number(n, None) => self.literal(*n, at),
            ast::ExprKind::Number(n, Some(ty)) => self.typed_number(*n, *ty, at),
            ast::ExprKind::Real(double, single, None) => LiteralOperand::Real(*double, *single),
            ast::ExprKind::Real(double, single, Some(ty)) => {
                let id = self.elementary(*ty);
                self.give_real((*double, *single), *ty, at)
                    .map_or(LiteralOperand::Wrong, |value| LiteralOperand::Value(value, id))
            }
            ast::ExprKind::Bool(value) => self.known(i64::from(*value), Elementary::Bool, at),
            ast::ExprKind::Moment(cell, ty) => self.known(*cell, *ty, at),
            ast::ExprKind::Text { wide, units, typed } => self.text_literal(*wide, units, *typed, at),
            ast::ExprKind::Null => LiteralOperand::Null,
            ast::ExprKind::This => self.this_pointer(at),
            ast::ExprKind::Super => {
                let message = "SUPER stands for no value";
                self.findings.error(Code::NotAValue, at, message, "write SUPER^.method()");
                LiteralOperand::Wrong
            }
            ast::ExprKind::Unary(op, of) => self.unary_operator(*op, of, expected, at),
            ast::ExprKind::Chain(first, rest) => self.chain(first, rest),
            ast::ExprKind::Call(callee, arguments) => match self.call_value(callee, arguments, at) {
                LiteralOperand::Nothing(_) => {
                    let message = "this call returns no value";
                    self.findings.error(Code::NotCallable, at, message, "call it in a statement of its own");
                    LiteralOperand::Wrong
                }
                operand => operand,
            },
            ast::ExprKind::Name(name) => {
                if let Some(value) = self.expected_enumerator(name.key, expected, at) {
                    return value;
                }
                let meaning = self.meaning(written);
                self.operand_of(meaning, at)
            }
            ast::ExprKind::Wrong => LiteralOperand::Wrong,
            _ => {
                let meaning = self.meaning(written);
                self.operand_of(meaning, at)
            }
        }
    }

    /// A value of the enumeration that is wanted here, where the name means nothing nearer.
    fn expected_enumerator(
        &mut self,
        key: ast::Key,
        expected: Option<TypeId>,
        at: SourcePlace,
    ) -> Option<LiteralOperand> {
        let ty = expected?;
        let Type::Enumeration(place) = *self.ty(ty) else { return None };
        let cell = self.enumerations.get(place as usize)?.values.iter().find(|(k, ..)| *k == key)?.2;
        match self.find(key) {
            None | Some(FoundName::Ambiguous | FoundName::Enumerator(..)) => {
                let base = self.scalar(ty)?;
                Some(LiteralOperand::Value(self.constant(cell, base, at), ty))
            }
            _ => None,
        }
    }

    pub(super) fn known(&mut self, cell: i64, ty: Elementary, at: SourcePlace) -> LiteralOperand {
        let id = self.elementary(ty);
        LiteralOperand::Value(self.constant(cell, ty, at), id)
    }

    /// A number without a type, if 64 bits hold it.
    pub(super) fn literal(&mut self, n: i128, at: SourcePlace) -> LiteralOperand {
        if i128::from(i64::MIN) <= n && n <= i128::from(u64::MAX) {
            return LiteralOperand::Integer(n);
        }
        self.findings.error(Code::Range, at, format!("{n} does not fit into 64 bits"), "");
        LiteralOperand::Wrong
    }

    fn typed_number(&mut self, n: i128, ty: Elementary, at: SourcePlace) -> LiteralOperand {
        match ty {
            Elementary::Real => return self.known(i64::from((n as f32).to_bits()), ty, at),
            Elementary::Lreal => return self.known((n as f64).to_bits() as i64, ty, at),
            _ => {}
        }
        if !in_range(n, ty) {
            let (low, high) = ty.range();
            let message = format!("{n} is outside the range of {}", ty.name());
            self.findings.error(Code::Range, at, message, format!("{} takes {low} to {high}", ty.name()));
            return LiteralOperand::Wrong;
        }
        self.known(ty.wrap(n as i64), ty, at)
    }

    fn text_literal(
        &mut self,
        wide: bool,
        units: &[u16],
        typed: Option<Elementary>,
        at: SourcePlace,
    ) -> LiteralOperand {
        match typed {
            Some(ty @ (Elementary::Char | Elementary::Wchar)) => match units {
                [unit] => self.known(i64::from(*unit), ty, at),
                _ => {
                    let message = format!("{} is one character", ty.name());
                    self.findings.error(Code::Range, at, message, "");
                    LiteralOperand::Wrong
                }
            },
            _ => LiteralOperand::Text(wide, units.to_vec()),
        }
    }

    /// THIS without `^`: a pointer to the running instance.
    fn this_pointer(&mut self, at: SourcePlace) -> LiteralOperand {
        let Some(block) = self.this_block(at) else { return LiteralOperand::Wrong };
        let block = self.intern(Type::Block(block));
        let place = self.place(TreeRoot::This, 0, block, false, at);
        let pointer = self.intern(Type::Pointer(block));
        LiteralOperand::Value(self.address_of(place), pointer)
    }

    /// The value of what a path means.
    pub(super) fn operand_of(&mut self, meaning: PathMeaning, at: SourcePlace) -> LiteralOperand {
        let message = match meaning {
            PathMeaning::Operand(operand) => return operand,
            PathMeaning::Wrong => return LiteralOperand::Wrong,
            PathMeaning::Place(place, ty, _) => {
                if ty == WRONG {
                    return LiteralOperand::Wrong;
                }
                if let Type::Open { .. } = self.ty(ty) {
                    let message = "an array of variable length is no value";
                    self.findings.error(Code::NotAValue, at, message, "use its elements one by one");
                    return LiteralOperand::Wrong;
                }
                if self.context.constant {
                    if let Some(bytes) = self.constant_place(&place, ty) {
                        return LiteralOperand::Value(bytes, ty);
                    }
                    self.not_constant(at, "a constant is needed here");
                    return LiteralOperand::Wrong;
                }
                let kind = ExprKind::Load(place);
                return LiteralOperand::Value(Expr { kind, ty: self.tree_type(ty), at }, ty);
            }
            PathMeaning::Bit(place, bit, _) => {
                if self.context.constant {
                    self.not_constant(at, "a constant is needed here");
                    return LiteralOperand::Wrong;
                }
                let ty = self.elementary(Elementary::Bool);
                let kind = ExprKind::LoadBit(place, bit);
                return LiteralOperand::Value(Expr { kind, ty: Ty::Scalar(Elementary::Bool), at }, ty);
            }
            PathMeaning::Property(instance, name) => return self.get_property(&instance, name),
            PathMeaning::Function(_) | PathMeaning::Method(..) => "this is called with brackets, as in f(x)",
            PathMeaning::Action(..) => "an action has no value",
            PathMeaning::Program(_) => "a program has no value",
            PathMeaning::Type(_) => "a type has no value",
            PathMeaning::Super(_) => "SUPER^ has no value",
        };
        self.findings.error(Code::NotAValue, at, message, "");
        LiteralOperand::Wrong
    }

    /// The bytes of a read-only structure, array or text whose initial value is known already.
    fn constant_place(&mut self, place: &crate::tree::TreePlace, ty: TypeId) -> Option<Expr> {
        use crate::code::map;
        let TreeRoot::Absolute = place.root else { return None };
        if !place.indices.is_empty() || place.offset >= map::OWN_END {
            return None;
        }
        let constant = self.globals.iter().find(|symbol| {
            symbol.is_value()
                && symbol.home == super::scope::Home::Absolute(place.offset)
                && symbol.type_id() == ty
        })?;
        let initial = constant.decl.initial.as_ref()?;
        let mut bytes = Vec::new();
        self.default_bytes(ty, &mut bytes);
        self.write_initial(ty, initial, &mut bytes, 0);
        let kind = match self.ty(ty) {
            Type::Text { .. } => ExprKind::Text(bytes),
            _ => ExprKind::Bytes(bytes),
        };
        Some(Expr { kind, ty: self.tree_type(ty), at: place.at })
    }

    fn unary_operator(
        &mut self,
        op: ast::UnaryOp,
        of: &ast::Expr,
        expected: Option<TypeId>,
        at: SourcePlace,
    ) -> LiteralOperand {
        let operand = self.expr(of, expected);
        match (op, operand) {
            (_, LiteralOperand::Wrong) => LiteralOperand::Wrong,
            (ast::UnaryOp::Minus, LiteralOperand::Integer(n)) => self.literal(-n, at),
            (ast::UnaryOp::Minus, LiteralOperand::Real(double, single)) => {
                LiteralOperand::Real(-double, -single)
            }
            (ast::UnaryOp::Plus, operand @ (LiteralOperand::Integer(_) | LiteralOperand::Real(..))) => {
                operand
            }
            (ast::UnaryOp::Not, LiteralOperand::Integer(_)) => {
                let help = "give it one, as in NOT WORD#16#FF";
                self.findings.error(Code::Operator, at, "NOT needs an operand with a type", help);
                LiteralOperand::Wrong
            }
            (op, operand) => {
                let Some((value, ty)) = self.own_value(operand, at) else { return LiteralOperand::Wrong };
                let scalar = self.scalar(ty);
                match (op, scalar) {
                    (ast::UnaryOp::Not, Some(scalar))
                        if scalar == Elementary::Bool || scalar.is_integer() =>
                    {
                        let id = self.elementary(scalar);
                        LiteralOperand::Value(self.unary(UnaryOp::Not, value, at), id)
                    }
                    (ast::UnaryOp::Minus, Some(scalar)) if scalar.signed() || scalar.is_real() => {
                        let id = self.elementary(scalar);
                        LiteralOperand::Value(self.unary(UnaryOp::Negate, value, at), id)
                    }
                    (ast::UnaryOp::Minus, Some(scalar)) if scalar.is_integer() => {
                        let message = format!("{} has no negative values", scalar.name());
                        let help = "convert to a signed type first";
                        self.findings.error(Code::Operator, at, message, help);
                        LiteralOperand::Wrong
                    }
                    (ast::UnaryOp::Plus, Some(scalar)) if scalar.is_integer() || scalar.is_real() => {
                        LiteralOperand::Value(value, ty)
                    }
                    _ => {
                        let word = match op {
                            ast::UnaryOp::Not => "NOT",
                            ast::UnaryOp::Minus => "-",
                            ast::UnaryOp::Plus => "+",
                        };
                        self.no_operator(word, ty, at)
                    }
                }
            }
        }
    }

    pub(super) fn no_operator(&mut self, op: &str, ty: TypeId, at: SourcePlace) -> LiteralOperand {
        if ty != WRONG {
            let message = format!("{op} is not defined for {}", self.type_name(ty));
            self.findings.error(Code::Operator, at, message, "");
        }
        LiteralOperand::Wrong
    }
}
