//! Functions of the library: those that are operations of the machine, conversions, and the table's.

use super::Sema;
use super::literal::LiteralOperand;
use super::place::PathMeaning;
use super::scope::SymbolKind;
use super::types::{Type, TypeId, WRONG};
use crate::codes::Code;
use crate::findings::SourcePlace;
use crate::library::parse_conversion;
use crate::parse::ast::{self, Argument, BinaryOp as Written, Name};
use crate::tree::{BinaryOp, Expr, ExprKind, Stmt, StmtKind, TreeRoot, Ty, UnaryOp};
use crate::types::Elementary;

/// What a function that is an operation does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Operation {
    /// An operator under a name; TRUE where it takes more than two operands.
    Operator(Written, bool),
    Move,
    Not,
    Absolute,
    Least,
    Greatest,
    Limit,
    Select,
    Multiplex,
    Shift(BinaryOp),
    SizeOf,
    Address,
    Reference,
    ValidReference,
    QueryInterface,
    /// LOWER_BOUND, UPPER_BOUND where TRUE.
    Bound(bool),
}

const OPERATIONS: &[(&str, &[&str], Operation)] = &[
    ("ADD", &["IN1", "IN2"], Operation::Operator(Written::Add, true)),
    ("SUB", &["IN1", "IN2"], Operation::Operator(Written::Subtract, false)),
    ("MUL", &["IN1", "IN2"], Operation::Operator(Written::Multiply, true)),
    ("DIV", &["IN1", "IN2"], Operation::Operator(Written::Divide, false)),
    ("MOD", &["IN1", "IN2"], Operation::Operator(Written::Mod, false)),
    ("AND", &["IN1", "IN2"], Operation::Operator(Written::And, true)),
    ("OR", &["IN1", "IN2"], Operation::Operator(Written::Or, true)),
    ("XOR", &["IN1", "IN2"], Operation::Operator(Written::Xor, true)),
    ("EQ", &["IN1", "IN2"], Operation::Operator(Written::Equal, false)),
    ("NE", &["IN1", "IN2"], Operation::Operator(Written::NotEqual, false)),
    ("LT", &["IN1", "IN2"], Operation::Operator(Written::Less, false)),
    ("LE", &["IN1", "IN2"], Operation::Operator(Written::LessEqual, false)),
    ("GT", &["IN1", "IN2"], Operation::Operator(Written::Greater, false)),
    ("GE", &["IN1", "IN2"], Operation::Operator(Written::GreaterEqual, false)),
    ("MOVE", &["IN"], Operation::Move),
    ("NOT", &["IN"], Operation::Not),
    ("ABS", &["IN"], Operation::Absolute),
    ("MIN", &["IN1", "IN2"], Operation::Least),
    ("MAX", &["IN1", "IN2"], Operation::Greatest),
    ("LIMIT", &["MN", "IN", "MX"], Operation::Limit),
    ("SEL", &["G", "IN0", "IN1"], Operation::Select),
    ("MUX", &["K", "IN0"], Operation::Multiplex),
    ("SHL", &["IN", "N"], Operation::Shift(BinaryOp::ShiftLeft)),
    ("SHR", &["IN", "N"], Operation::Shift(BinaryOp::ShiftRight)),
    ("ROL", &["IN", "N"], Operation::Shift(BinaryOp::RotateLeft)),
    ("ROR", &["IN", "N"], Operation::Shift(BinaryOp::RotateRight)),
    ("SIZEOF", &["IN"], Operation::SizeOf),
    ("ADR", &["IN"], Operation::Address),
    ("REF", &["IN"], Operation::Reference),
    ("LOWER_BOUND", &["ARR", "DIM"], Operation::Bound(false)),
    ("UPPER_BOUND", &["ARR", "DIM"], Operation::Bound(true)),
    ("__ISVALIDREF", &["IN"], Operation::ValidReference),
    ("__QUERYINTERFACE", &["IN", "OUT"], Operation::QueryInterface),
];

/// Names for suggestions.
pub(super) fn names() -> impl Iterator<Item = &'static str> {
    OPERATIONS.iter().map(|(name, ..)| *name)
}

impl<'a> Sema<'a> {
    /// A call of a function of the library; `None` where the name is none of one.
    pub(super) fn standard(
        &mut self,
        name: Name,
        key: &str,
        arguments: &[Argument],
        at: SourcePlace,
    ) -> Option<LiteralOperand> {
        if let Some((_, parameters, operation)) = OPERATIONS.iter().find(|(known, ..)| *known == key) {
            let many = matches!(
                operation,
                Operation::Operator(_, true) | Operation::Least | Operation::Greatest | Operation::Multiplex
            );
            let Some(values) = self.in_order(parameters, many, name, key, arguments) else {
                return Some(LiteralOperand::Wrong);
            };
            return Some(self.operation_call(*operation, key, &values, at));
        }
        if let Some(function) = crate::library::find(key) {
            let Some(values) = self.library_arguments(function, name, arguments) else {
                return Some(LiteralOperand::Wrong);
            };
            let operands: Vec<LiteralOperand> = values.iter().map(|value| self.expr(value, None)).collect();
            return Some(self.library_call(function, operands, at));
        }
        let conversion = parse_conversion(key)?;
        let Some(values) = self.in_order(&["IN"], false, name, key, arguments) else {
            return Some(LiteralOperand::Wrong);
        };
        Some(values.first().map_or(LiteralOperand::Wrong, |value| self.conversion(conversion, value, at)))
    }

    /// The values of parameters in their order; reports what is missing, unknown or too much.
    fn in_order<'e>(
        &mut self,
        parameters: &[&str],
        many: bool,
        name: Name,
        key: &str,
        arguments: &'e [Argument],
    ) -> Option<Vec<&'e ast::Expr>> {
        let positional: Vec<&ast::Expr> = arguments
            .iter()
            .filter_map(|argument| match argument {
                Argument::Positional(value) => Some(value),
                _ => None,
            })
            .collect();
        if positional.len() == arguments.len()
            && (positional.len() == parameters.len() || many && positional.len() > parameters.len())
        {
            return Some(positional);
        }
        let mut values: Vec<Option<&ast::Expr>> = vec![None; parameters.len()];
        let mut good = positional.is_empty();
        for argument in arguments {
            if let Argument::Input(parameter, value) = argument {
                let written = self.names.key_text(parameter.key);
                let numbered = |prefix: &str, first: usize| {
                    let n: usize = written.strip_prefix(prefix)?.parse().ok()?;
                    n.checked_sub(first)
                };
                let place = parameters.iter().position(|known| *known == written).or_else(|| {
                    // IN3 of ADD, IN2 of MUX.
                    if !many {
                        None
                    } else if key == "MUX" {
                        numbered("IN", 0).map(|n| n + 1)
                    } else {
                        numbered("IN", 1)
                    }
                });
                match place {
                    Some(place) if place < arguments.len() => {
                        if values.len() <= place {
                            values.resize(place + 1, None);
                        }
                        if values[place].replace(value).is_some() {
                            good = false;
                        }
                    }
                    _ => good = false,
                }
            }
        }
        good &= values.len() == arguments.len();
        if let (true, Some(values)) = (good, values.into_iter().collect::<Option<Vec<_>>>()) {
            return Some(values);
        }
        let message = format!("{key} takes {}", parameters.join(", "));
        let help = if many {
            format!("{key} takes {} values or more", parameters.len())
        } else {
            "give each once".to_string()
        };
        self.findings.error(Code::Arguments, name.at, message, help);
        None
    }

    fn operation_call(
        &mut self,
        operation: Operation,
        key: &str,
        values: &[&ast::Expr],
        at: SourcePlace,
    ) -> LiteralOperand {
        match operation {
            Operation::Operator(op, _) => {
                let mut result = match values.first() {
                    Some(first) => self.expr(first, None),
                    None => return LiteralOperand::Wrong,
                };
                for value in values.iter().skip(1) {
                    let right = self.expr(value, None);
                    result = self.operate(op, result, right, at);
                }
                result
            }
            Operation::Move => values.first().map_or(LiteralOperand::Wrong, |value| self.expr(value, None)),
            Operation::Not => match values.first().map(|value| self.expr(value, None)) {
                Some(LiteralOperand::Value(value, ty))
                    if self.scalar(ty).is_some_and(|ty| ty == Elementary::Bool || ty.is_integer()) =>
                {
                    LiteralOperand::Value(self.unary(UnaryOp::Not, value, at), ty)
                }
                Some(LiteralOperand::Wrong) | None => LiteralOperand::Wrong,
                Some(operand) => {
                    let ty = self.own_type(&operand);
                    self.no_operator("NOT", ty, at)
                }
            },
            Operation::Absolute => self.absolute(values, at),
            Operation::Least => self.extremes(BinaryOp::Least, key, values, at),
            Operation::Greatest => self.extremes(BinaryOp::Greatest, key, values, at),
            Operation::Limit => self.limit(values, at),
            Operation::Select => self.select(values, at),
            Operation::Multiplex => self.multiplex(values, at),
            Operation::Shift(op) => self.shift(op, key, values, at),
            Operation::SizeOf => self.size_of(values, at),
            Operation::Address | Operation::Reference => {
                self.address_call(operation == Operation::Reference, values)
            }
            Operation::Bound(upper) => self.bound_call(upper, values, at),
            Operation::ValidReference => self.valid_reference(values, at),
            Operation::QueryInterface => self.query_interface(values, at),
        }
    }

    fn absolute(&mut self, values: &[&ast::Expr], at: SourcePlace) -> LiteralOperand {
        let Some(value) = values.first() else { return LiteralOperand::Wrong };
        match self.expr(value, None) {
            LiteralOperand::Integer(n) => self.literal(n.abs(), at),
            LiteralOperand::Real(double, single) => LiteralOperand::Real(double.abs(), single.abs()),
            LiteralOperand::Wrong => LiteralOperand::Wrong,
            operand => {
                let Some((value, ty)) = self.own_value(operand, at) else { return LiteralOperand::Wrong };
                match self.scalar(ty) {
                    Some(scalar) if scalar.is_integer() || scalar.is_real() => {
                        let id = self.elementary(scalar);
                        let value = self.promoted(value);
                        let value = self.unary(UnaryOp::Absolute, value, at);
                        LiteralOperand::Value(self.uncut(value), id)
                    }
                    _ => self.no_operator("ABS", ty, at),
                }
            }
        }
    }

    /// The operands in the type where all meet.
    fn together(&mut self, values: &[&ast::Expr], key: &str, at: SourcePlace) -> Option<(Vec<Expr>, TypeId)> {
        let mut operands = Vec::with_capacity(values.len());
        for value in values {
            let operand = self.expr(value, None);
            if matches!(operand, LiteralOperand::Wrong) {
                return None;
            }
            operands.push((operand, value.at));
        }
        // Values with a type of their own decide before literals do.
        let mut common: Option<LiteralOperand> = None;
        let mut order: Vec<&(LiteralOperand, SourcePlace)> =
            operands.iter().filter(|(o, _)| !o.is_literal()).collect();
        order.extend(operands.iter().filter(|(o, _)| o.is_literal()));
        for (operand, operand_at) in order {
            common = Some(match common {
                None => operand.clone(),
                Some(so_far) => match self.common(&so_far, operand) {
                    Some(ty) => {
                        let kind = ExprKind::Constant(0);
                        LiteralOperand::Value(Expr { kind, ty: self.tree_type(ty), at: *operand_at }, ty)
                    }
                    None => {
                        let (a, b) = (self.own_type(&so_far), self.own_type(operand));
                        let message =
                            format!("{key} does not take {} and {}", self.type_name(a), self.type_name(b));
                        self.findings.error(Code::Operator, at, message, "convert one of them");
                        return None;
                    }
                },
            });
        }
        let ty = match common? {
            LiteralOperand::Value(_, ty) => ty,
            literal => self.own_type(&literal),
        };
        let mut list = Vec::with_capacity(operands.len());
        for (operand, operand_at) in operands {
            let value = match operand {
                LiteralOperand::Value(value, from)
                    if self.scalar(from).is_some() && self.scalar(ty).is_some() =>
                {
                    let to = self.tree_type(ty);
                    self.widened(value, to)
                }
                operand => self.give(operand, ty, operand_at)?,
            };
            list.push(value);
        }
        Some((self.all_promoted(list), ty))
    }

    fn extremes(
        &mut self,
        op: BinaryOp,
        key: &str,
        values: &[&ast::Expr],
        at: SourcePlace,
    ) -> LiteralOperand {
        let Some((list, ty)) = self.together(values, key, at) else { return LiteralOperand::Wrong };
        if matches!(self.ty(ty), Type::Text { .. }) {
            return self.extreme_text(op, list, ty, at);
        }
        if self.scalar(ty).is_none() {
            return self.no_operator(key, ty, at);
        }
        list.iter().for_each(|value| self.check_below_0(value));
        let mut list = list.into_iter();
        let Some(first) = list.next() else { return LiteralOperand::Wrong };
        let value = list.fold(first, |so_far, next| self.binary(op, so_far, next, at));
        LiteralOperand::Value(self.uncut(value), ty)
    }

    /// The least or greatest text. Each is used twice, to be compared and to be chosen: what has to be computed is put
    /// into a variable first.
    fn extreme_text(
        &mut self,
        op: BinaryOp,
        mut list: Vec<Expr>,
        ty: TypeId,
        at: SourcePlace,
    ) -> LiteralOperand {
        let constant = |value: &Expr| matches!(value.kind, ExprKind::Text(_));
        let variable = |value: &Expr| {
            matches!(&value.kind, ExprKind::Load(place)
                if place.indices.is_empty() && !matches!(place.root, TreeRoot::Address(_)))
        };
        let mut before = Vec::new();
        if !list.iter().all(|value| constant(value) || variable(value)) {
            for value in list.iter_mut().filter(|value| !constant(value)) {
                self.set_aside(value, &mut before);
            }
        }
        let compare = if op == BinaryOp::Least { BinaryOp::Greater } else { BinaryOp::Less };
        let mut list = list.into_iter();
        let Some(mut best) = list.next() else { return LiteralOperand::Wrong };
        for next in list {
            if !constant(&best) && !variable(&best) {
                self.set_aside(&mut best, &mut before);
            }
            let chosen = self.binary(compare, best.clone(), next.clone(), at);
            let kind = ExprKind::Select(Box::new(chosen), vec![best, next]);
            best = Expr { kind, ty: self.tree_type(ty), at };
        }
        if !before.is_empty() {
            let ty = best.ty;
            best = Expr { kind: ExprKind::Sequence(before, Box::new(best)), ty, at };
        }
        LiteralOperand::Value(best, ty)
    }

    fn limit(&mut self, values: &[&ast::Expr], at: SourcePlace) -> LiteralOperand {
        let Some((list, ty)) = self.together(values, "LIMIT", at) else { return LiteralOperand::Wrong };
        let text = matches!(self.ty(ty), Type::Text { .. });
        if self.scalar(ty).is_none() && !text {
            return self.no_operator("LIMIT", ty, at);
        }
        let Ok([low, value, high]) = <[Expr; 3]>::try_from(list) else { return LiteralOperand::Wrong };
        if text {
            return match self.extreme_text(BinaryOp::Greatest, vec![low, value], ty, at) {
                LiteralOperand::Value(raised, _) => {
                    self.extreme_text(BinaryOp::Least, vec![raised, high], ty, at)
                }
                other => other,
            };
        }
        [&low, &value, &high].into_iter().for_each(|value| self.check_below_0(value));
        let raised = self.binary(BinaryOp::Greatest, low, value, at);
        let limited = self.binary(BinaryOp::Least, raised, high, at);
        LiteralOperand::Value(self.uncut(limited), ty)
    }

    fn select(&mut self, values: &[&ast::Expr], at: SourcePlace) -> LiteralOperand {
        let Some((selector, rest)) = values.split_first() else { return LiteralOperand::Wrong };
        let bool_type = self.elementary(Elementary::Bool);
        let selector = self.value(selector, bool_type);
        let Some((list, ty)) = self.together(rest, "SEL", at) else { return LiteralOperand::Wrong };
        let Some(selector) = selector else { return LiteralOperand::Wrong };
        self.selected(selector, list, ty, at)
    }

    fn multiplex(&mut self, values: &[&ast::Expr], at: SourcePlace) -> LiteralOperand {
        let Some((selector, rest)) = values.split_first() else { return LiteralOperand::Wrong };
        let operand = self.expr(selector, None);
        let selector = self.own_value(operand, selector.at);
        let Some((list, ty)) = self.together(rest, "MUX", at) else { return LiteralOperand::Wrong };
        let Some((selector, selector_type)) = selector else { return LiteralOperand::Wrong };
        if !self.scalar(selector_type).is_some_and(Elementary::is_integer) {
            return self.no_operator("MUX", selector_type, at);
        }
        let selector = self.promoted(selector);
        self.selected(selector, list, ty, at)
    }

    fn selected(&mut self, selector: Expr, list: Vec<Expr>, ty: TypeId, at: SourcePlace) -> LiteralOperand {
        let own = self.tree_type(ty);
        // Promoted values are all promoted; texts may differ in length.
        let common = list.first().map_or(own, |value| value.ty);
        let tree_type = if matches!(common, Ty::Promoted(_)) { common } else { own };
        let value = Expr { kind: ExprKind::Select(Box::new(selector), list), ty: tree_type, at };
        LiteralOperand::Value(self.uncut(value), ty)
    }

    fn shift(&mut self, op: BinaryOp, key: &str, values: &[&ast::Expr], at: SourcePlace) -> LiteralOperand {
        let [value, times] = values else { return LiteralOperand::Wrong };
        let operand = self.expr(value, None);
        if matches!(operand, LiteralOperand::Integer(_)) {
            let help = "give it one, as in WORD#16#1";
            self.findings.error(Code::Operator, value.at, format!("{key} needs a value with a type"), help);
            return LiteralOperand::Wrong;
        }
        let Some((value, ty)) = self.own_value(operand, value.at) else { return LiteralOperand::Wrong };
        let Some(scalar) = self.scalar(ty).filter(|ty| ty.is_integer()) else {
            if ty != WRONG {
                let message = format!("{key} is not defined for {}", self.type_name(ty));
                self.findings.error(Code::Operator, at, message, "");
            }
            return LiteralOperand::Wrong;
        };
        let lint = self.elementary(Elementary::Lint);
        let times_operand = self.expr(times, None);
        let times = match times_operand {
            LiteralOperand::Value(value, from) if self.scalar(from).is_some_and(Elementary::is_integer) => {
                Some(self.widened(value, Ty::Scalar(Elementary::Lint)))
            }
            operand => self.give(operand, lint, times.at),
        };
        let Some(times) = times else { return LiteralOperand::Wrong };
        let id = self.elementary(scalar);
        LiteralOperand::Value(self.binary(op, value, times, at), id)
    }

    fn size_of(&mut self, values: &[&ast::Expr], at: SourcePlace) -> LiteralOperand {
        let Some(value) = values.first() else { return LiteralOperand::Wrong };
        let outer = self.context.constant;
        let ty = match self.meaning_of_type(value) {
            Some(ty) => ty,
            None => {
                // What is measured is not computed.
                self.context.constant = false;
                let meaning = self.meaning(value);
                self.context.constant = outer;
                match meaning {
                    PathMeaning::Place(_, ty, _) | PathMeaning::Type(ty) => ty,
                    PathMeaning::Bit(..) => self.elementary(Elementary::Bool),
                    PathMeaning::Operand(operand) => self.own_type(&operand),
                    PathMeaning::Wrong => return LiteralOperand::Wrong,
                    _ => {
                        self.findings.error(Code::NotAValue, at, "this has no size", "");
                        return LiteralOperand::Wrong;
                    }
                }
            }
        };
        if ty == WRONG {
            return LiteralOperand::Wrong;
        }
        // It goes into whatever type holds it, as a literal does.
        let size = self.layout(ty).size;
        self.literal(i128::from(size), at)
    }

    /// An elementary type by its name, as in SIZEOF(DINT).
    fn meaning_of_type(&mut self, value: &ast::Expr) -> Option<TypeId> {
        let ast::ExprKind::Name(name) = &value.kind else { return None };
        let ty = Elementary::named(self.names.key_text(name.key))?;
        self.find(name.key).is_none().then(|| self.elementary(ty))
    }

    fn address_call(&mut self, reference: bool, values: &[&ast::Expr]) -> LiteralOperand {
        let Some(value) = values.first() else { return LiteralOperand::Wrong };
        let outer = std::mem::replace(&mut self.context.constant, false);
        let meaning = self.meaning(value);
        self.context.constant = outer;
        match meaning {
            PathMeaning::Place(place, ty, _) => {
                let address = self.address_of(place);
                let pointer =
                    if reference { self.intern(Type::RefTo(ty)) } else { self.intern(Type::Pointer(ty)) };
                LiteralOperand::Value(address, pointer)
            }
            PathMeaning::Wrong | PathMeaning::Operand(LiteralOperand::Wrong) => LiteralOperand::Wrong,
            PathMeaning::Bit(..) => {
                let message = "a single bit has no address";
                self.findings.error(
                    Code::Output,
                    value.at,
                    message,
                    "take that of a BOOL variable or a byte",
                );
                LiteralOperand::Wrong
            }
            PathMeaning::Operand(LiteralOperand::Text(wide, units)) if !reference => {
                // The text stands in the memory for good, as pointers to it may be kept.
                let ty = self.intern(Type::Text { wide, length: (units.len() as u32).max(1) });
                let bytes = super::literal::stored(wide, &units);
                if !self.has_room(bytes.len() as u32, value.at) {
                    return LiteralOperand::Wrong;
                }
                let address = self.allocate(&bytes, 2);
                let place = self.place(TreeRoot::Absolute, address, ty, false, value.at);
                let pointer = self.intern(Type::Pointer(ty));
                LiteralOperand::Value(self.address_of(place), pointer)
            }
            _ => {
                let message = "only variables have an address";
                self.findings.error(Code::Output, value.at, message, "put the value into a variable first");
                LiteralOperand::Wrong
            }
        }
    }

    /// Whether an object is of the interface of a variable, which then gets it.
    fn query_interface(&mut self, values: &[&ast::Expr], at: SourcePlace) -> LiteralOperand {
        let [object, target] = values else { return LiteralOperand::Wrong };
        let operand = self.expr(object, None);
        let (Some((object, from)), Some((place, ty))) = (self.own_value(operand, at), self.target(target))
        else {
            return LiteralOperand::Wrong;
        };
        let (Type::Interface(_), Type::Interface(wanted)) = (self.ty(from), self.ty(ty)) else {
            let message = "__QUERYINTERFACE takes two variables of interfaces";
            self.findings.error(Code::Type, at, message, "declare them with INTERFACE types");
            return LiteralOperand::Wrong;
        };
        let wanted = SymbolKind::Interface(*wanted);
        let kind = self.kinds.iter().position(|kind| *kind == wanted).unwrap_or(0) as u32;
        let bool_type = self.elementary(Elementary::Bool);
        let boolean = Ty::Scalar(Elementary::Bool);
        let is = Expr { kind: ExprKind::IsKind(Box::new(object.clone()), kind), ty: boolean, at };
        let null = Expr { kind: ExprKind::Constant(0), ty: Ty::Address, at };
        let assign = |value: Expr| Stmt { kind: StmtKind::Assign(place.clone(), value), at };
        let arms = vec![(is.clone(), vec![assign(object)])];
        let decide = Stmt { kind: StmtKind::If { arms, otherwise: vec![assign(null)] }, at };
        let kind = ExprKind::Sequence(vec![decide], Box::new(is));
        LiteralOperand::Value(Expr { kind, ty: boolean, at }, bool_type)
    }

    fn valid_reference(&mut self, values: &[&ast::Expr], at: SourcePlace) -> LiteralOperand {
        let Some(value) = values.first() else { return LiteralOperand::Wrong };
        let slot = match self.reference_place(value) {
            Some((slot, _)) => slot,
            None => match self.meaning(value) {
                PathMeaning::Place(place, ty, _) if self.is_address(ty) => place,
                PathMeaning::Wrong => return LiteralOperand::Wrong,
                _ => {
                    let message = "__ISVALIDREF takes a reference, a pointer or an interface";
                    self.findings.error(Code::Type, value.at, message, "");
                    return LiteralOperand::Wrong;
                }
            },
        };
        let address = Expr { kind: ExprKind::Load(slot), ty: Ty::Address, at };
        let null = Expr { kind: ExprKind::Constant(0), ty: Ty::Address, at };
        let ty = self.elementary(Elementary::Bool);
        LiteralOperand::Value(self.binary(BinaryOp::NotEqual, address, null, at), ty)
    }
}
