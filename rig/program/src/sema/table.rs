//! Conversions and the functions of the library's table.

use super::Sema;
use super::literal::LiteralOperand;
use super::types::{Type, TypeId, WRONG};
use crate::codes::Code;
use crate::findings::{SourcePlace, count};
use crate::library::{Accepts, Body, Conversion, ConversionSide, Function, Gives, How, TEXT_LIMIT};
use crate::parse::ast::{self, Argument, Name};
use crate::tree::{Expr, ExprKind, Ty};
use crate::types::Elementary;

/// Text arguments that one call takes.
const MOST_TEXTS: usize = 32;

impl Sema<'_> {
    pub(super) fn conversion(
        &mut self,
        conversion: Conversion,
        value: &ast::Expr,
        at: SourcePlace,
    ) -> LiteralOperand {
        let from = conversion.from.map(|side| self.side(side));
        let operand = self.expr(value, from);
        let value_at = value.at;
        let typed = match (from, operand) {
            (_, LiteralOperand::Wrong) => return LiteralOperand::Wrong,
            // The name says what the bits are: no warning, but no other type either.
            (Some(from), LiteralOperand::Value(value, own))
                if self.scalar(from).is_some_and(Elementary::is_integer)
                    && self
                        .scalar(own)
                        .is_some_and(|ty| ty.bits() == self.scalar(from).map_or(0, Elementary::bits))
                    && self.scalar(own).is_some_and(Elementary::is_integer) =>
            {
                let to = self.tree_type(from);
                Some((self.widened(value, to), from))
            }
            (Some(from), LiteralOperand::Value(value, own))
                if self.is_address(own) && self.scalar(from).is_some() =>
            {
                let plain = self.reinterpreted(value, Ty::Scalar(Elementary::Udint));
                let udint = self.elementary(Elementary::Udint);
                self.assigned(plain, udint, from, value_at).map(|value| (value, from))
            }
            (Some(from), LiteralOperand::Text(wide, units)) if matches!(self.ty(from), Type::Text { .. }) => {
                let _ = from;
                self.own_value(LiteralOperand::Text(wide, units), value_at)
            }
            (Some(from), LiteralOperand::Value(value, own)) if matches!((self.ty(from), self.ty(own)), (Type::Text { wide: a, .. }, Type::Text { wide: b, .. }) if a == b) => {
                Some((value, own))
            }
            (Some(from), operand) => self.give(operand, from, value_at).map(|value| (value, from)),
            (None, LiteralOperand::Value(value, own)) if self.is_address(own) => {
                let udint = self.elementary(Elementary::Udint);
                Some((self.reinterpreted(value, Ty::Scalar(Elementary::Udint)), udint))
            }
            (None, operand) => self.own_value(operand, value_at),
        };
        let Some((value, own)) = typed else { return LiteralOperand::Wrong };
        if let Some(function) = conversion.function() {
            return self.library_call(function, vec![LiteralOperand::Value(value, own)], at);
        }
        debug_assert_eq!(conversion.how, How::Plain);
        let to = self.conversion_target(conversion.to, own);
        if self.scalar(own).is_none() && !matches!(self.ty(own), Type::Text { .. }) {
            self.mismatch(own, to, at);
            return LiteralOperand::Wrong;
        }
        let target = self.tree_type(to);
        if value.ty == target {
            // A constant is cut here and costs nothing; all else costs what a conversion costs even where nothing changes.
            let value = self.cut(value);
            return match value.kind {
                ExprKind::Constant(_) => LiteralOperand::Value(value, to),
                _ => LiteralOperand::Value(
                    Expr { kind: ExprKind::Convert(Box::new(value)), ty: target, at },
                    to,
                ),
            };
        }
        LiteralOperand::Value(self.converted(value, target), to)
    }

    fn side(&mut self, side: ConversionSide) -> TypeId {
        match side {
            ConversionSide::Scalar(ty) => self.elementary(ty),
            ConversionSide::String => self.intern(Type::Text { wide: false, length: TEXT_LIMIT }),
            ConversionSide::Wstring => self.intern(Type::Text { wide: true, length: TEXT_LIMIT }),
        }
    }

    /// What a conversion gives; texts as long as the longest number, or as what they come from.
    fn conversion_target(&mut self, side: ConversionSide, from: TypeId) -> TypeId {
        let wide = match side {
            ConversionSide::Scalar(ty) => return self.elementary(ty),
            ConversionSide::String => false,
            ConversionSide::Wstring => true,
        };
        let length = match self.ty(from) {
            Type::Text { length, .. } => *length,
            _ => 80,
        };
        self.intern(Type::Text { wide, length })
    }

    /// The values of a function of the table, in order.
    pub(super) fn library_arguments<'e>(
        &mut self,
        function: &'static Function,
        name: Name,
        arguments: &'e [Argument],
    ) -> Option<Vec<&'e ast::Expr>> {
        let needed = function.parameters.len();
        let mut values: Vec<Option<&ast::Expr>> = vec![None; needed];
        let mut good = true;
        for (nth, argument) in arguments.iter().enumerate() {
            let (place, value) = match argument {
                Argument::Positional(value) => (Some(nth), value),
                Argument::Input(name, value) => (function.parameter(self.names.key_text(name.key)), value),
                _ => {
                    good = false;
                    continue;
                }
            };
            match place {
                Some(place) if place < needed || function.extensible && place < arguments.len() => {
                    if values.len() <= place {
                        values.resize(place + 1, None);
                    }
                    good &= values[place].replace(value).is_none();
                }
                _ => good = false,
            }
        }
        if let (true, Some(values)) = (good, values.into_iter().collect::<Option<Vec<_>>>()) {
            if values.len() > MOST_TEXTS {
                let message = format!("{} takes at most {}", function.name, count(MOST_TEXTS, "value"));
                self.findings.error(Code::Arguments, name.at, message, "call it twice");
                return None;
            }
            return Some(values);
        }
        let parameters: Vec<&str> = function.parameters.iter().map(|(name, _)| *name).collect();
        let taken = if parameters.is_empty() { "no values".to_string() } else { parameters.join(", ") };
        let message = format!("{} takes {taken}", function.name);
        let help = if function.extensible { "or more of the last" } else { "give each once" };
        self.findings.error(Code::Arguments, name.at, message, help);
        None
    }

    /// A call of a function of the table, computed where its arguments are constant cells.
    pub(super) fn library_call(
        &mut self,
        function: &'static Function,
        operands: Vec<LiteralOperand>,
        at: SourcePlace,
    ) -> LiteralOperand {
        if operands.iter().any(|operand| matches!(operand, LiteralOperand::Wrong)) {
            return LiteralOperand::Wrong;
        }
        let accepts = |nth: usize| {
            function.parameters.get(nth).or(function.parameters.last()).map_or(Accepts::AnyReal, |(_, a)| *a)
        };
        let Some(generic) = self.generic(function, &operands, &accepts, at) else {
            return LiteralOperand::Wrong;
        };
        let scalar = self.scalar(generic).unwrap_or(Elementary::Bool);
        let wide = matches!(self.ty(generic), Type::Text { wide: true, .. });
        let mut values = Vec::with_capacity(operands.len());
        for (nth, operand) in operands.into_iter().enumerate() {
            let value = match (accepts(nth), operand) {
                (Accepts::Exact(ty), operand) => {
                    let id = self.elementary(ty);
                    self.give(operand, id, at)
                }
                // Positions and lengths stand beside texts.
                (Accepts::AnyInt, operand) if matches!(self.ty(generic), Type::Text { .. }) => {
                    let lint = self.elementary(Elementary::Lint);
                    match operand {
                        LiteralOperand::Value(value, from)
                            if self.scalar(from).is_some_and(Elementary::is_integer) =>
                        {
                            Some(self.widened(value, Ty::Scalar(Elementary::Lint)))
                        }
                        operand => self.give(operand, lint, at),
                    }
                }
                (Accepts::AnyText, operand) => match operand {
                    LiteralOperand::Text(own, _) if own != wide => self.give(operand, generic, at),
                    LiteralOperand::Value(value, from) if matches!(self.ty(from), Type::Text { wide: own, .. } if *own == wide) => {
                        Some(value)
                    }
                    LiteralOperand::Text(..) => self.own_value(operand, at).map(|(value, _)| value),
                    operand => self.give(operand, generic, at),
                },
                (_, LiteralOperand::Value(value, from))
                    if self.scalar(from).is_some() && self.scalar(generic).is_some() =>
                {
                    let to = self.tree_type(generic);
                    Some(self.widened(value, to))
                }
                (_, operand) => self.give(operand, generic, at),
            };
            match value {
                Some(value) => values.push(value),
                None => return LiteralOperand::Wrong,
            }
        }
        let result = match function.gives {
            Gives::Same => self.elementary(scalar),
            Gives::Exact(ty) => self.elementary(ty),
            Gives::Text => self.intern(Type::Text { wide, length: TEXT_LIMIT }),
        };
        if let Body::Scalar(_) | Body::Quotient(_) = function.body {
            let cells: Option<Vec<i64>> = values
                .iter()
                .map(|value| match value.kind {
                    ExprKind::Constant(cell) => Some(cell),
                    _ => None,
                })
                .collect();
            if let (Some(cells), Some(ty)) = (cells, self.scalar(result)) {
                let cell = match function.body {
                    Body::Scalar(body) => Some(body(scalar, &cells)),
                    Body::Quotient(body) => body(scalar, &cells),
                    _ => None,
                };
                return match cell {
                    Some(cell) => LiteralOperand::Value(self.constant(cell, ty, at), result),
                    None => self.division_by_zero(at),
                };
            }
        }
        if self.context.constant {
            self.not_constant(at, "a constant is needed here");
            return LiteralOperand::Wrong;
        }
        let kind = ExprKind::Library(function, scalar, values);
        LiteralOperand::Value(Expr { kind, ty: self.tree_type(result), at }, result)
    }

    /// The type that the generic parameters of a call share; BOOL where there are none.
    fn generic(
        &mut self,
        function: &'static Function,
        operands: &[LiteralOperand],
        accepts: &dyn Fn(usize) -> Accepts,
        at: SourcePlace,
    ) -> Option<TypeId> {
        let text = (0..operands.len()).any(|nth| accepts(nth) == Accepts::AnyText);
        let mut common: Option<LiteralOperand> = None;
        for (nth, operand) in operands.iter().enumerate() {
            let generic = match accepts(nth) {
                Accepts::Exact(_) => false,
                Accepts::AnyText => true,
                _ => !text,
            };
            if !generic {
                continue;
            }
            common = match common {
                None => Some(operand.clone()),
                Some(so_far) => match self.common(&so_far, operand) {
                    Some(ty) => {
                        let expr = Expr { kind: ExprKind::Constant(0), ty: self.tree_type(ty), at };
                        Some(LiteralOperand::Value(expr, ty))
                    }
                    None => {
                        let (a, b) = (self.own_type(&so_far), self.own_type(operand));
                        let message = format!(
                            "{} does not take {} and {}",
                            function.name,
                            self.type_name(a),
                            self.type_name(b)
                        );
                        self.findings.error(Code::Operator, at, message, "convert one of them");
                        return None;
                    }
                },
            };
        }
        let Some(common) = common else { return Some(self.elementary(Elementary::Bool)) };
        let own = self.own_type(&common);
        let wanted = (0..operands.len()).map(accepts).find(|a| !matches!(a, Accepts::Exact(_)));
        let scalar = self.scalar(own);
        let ty = match wanted {
            Some(Accepts::AnyText) => match *self.ty(own) {
                Type::Text { .. } => Some(own),
                Type::Elementary(Elementary::Char) => {
                    Some(self.intern(Type::Text { wide: false, length: 1 }))
                }
                Type::Elementary(Elementary::Wchar) => {
                    Some(self.intern(Type::Text { wide: true, length: 1 }))
                }
                _ => None,
            },
            Some(Accepts::AnyReal) => match scalar {
                Some(ty) if ty.is_real() => Some(self.elementary(ty)),
                // Literals are as exact as can be.
                Some(ty) if ty.is_integer() => {
                    // Powers soon need more digits than REAL has.
                    let exact = ty.bits() <= 16 && !common.is_literal() && function.name != "EXPT";
                    Some(self.elementary(if exact { Elementary::Real } else { Elementary::Lreal }))
                }
                _ => None,
            },
            Some(Accepts::AnyInt) => scalar.filter(|ty| ty.is_integer()).map(|ty| self.elementary(ty)),
            Some(Accepts::AnyNum) => {
                scalar.filter(|ty| ty.is_integer() || ty.is_real()).map(|ty| self.elementary(ty))
            }
            Some(Accepts::AnyBit) => {
                scalar.filter(|ty| *ty == Elementary::Bool || ty.is_integer()).map(|ty| self.elementary(ty))
            }
            _ => Some(self.elementary(Elementary::Bool)),
        };
        if ty.is_none() && own != WRONG {
            let message = format!("{} is not defined for {}", function.name, self.type_name(own));
            self.findings.error(Code::Operator, at, message, "");
        }
        ty
    }
}
