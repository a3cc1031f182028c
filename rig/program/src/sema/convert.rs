//! Which values go into which types by themselves.

use super::Sema;
use super::literal::{LiteralOperand, in_range, integer_type, stored};
use super::promote::whole_constant;
use super::types::{Type, TypeId, WRONG};
use crate::codes::Code;
use crate::findings::SourcePlace;
use crate::parse::ast;
use crate::tree::{Expr, ExprKind, Ty};
use crate::types::Elementary;

impl<'a> Sema<'a> {
    /// The expression as a value of a type; `None` where that was reported not to be possible.
    pub(super) fn value(&mut self, written: &ast::Expr, ty: TypeId) -> Option<Expr> {
        let operand = self.expr(written, Some(ty));
        self.give(operand, ty, written.at)
    }

    /// An operand as a value of a type.
    pub(super) fn give(&mut self, operand: LiteralOperand, ty: TypeId, at: SourcePlace) -> Option<Expr> {
        if ty == WRONG {
            return None;
        }
        match operand {
            LiteralOperand::Wrong | LiteralOperand::Nothing(_) => None,
            LiteralOperand::Integer(n) => self.give_integer(n, ty, at),
            LiteralOperand::Real(double, single) => match self.scalar(ty) {
                Some(scalar) if scalar.is_real() => self.give_real((double, single), scalar, at),
                _ => {
                    let message = format!("a number with a point does not go into {}", self.type_name(ty));
                    self.findings.error(Code::Type, at, message, self.conversion_help(Elementary::Lreal, ty));
                    None
                }
            },
            LiteralOperand::Text(wide, units) => self.give_text(wide, &units, ty, at),
            LiteralOperand::Null => {
                if self.is_address(ty) {
                    return Some(Expr { kind: ExprKind::Constant(0), ty: Ty::Address, at });
                }
                let message = format!("NULL is no {}", self.type_name(ty));
                self.findings.error(Code::Type, at, message, "it suits pointers, references and interfaces");
                None
            }
            LiteralOperand::Value(value, from) => self.assigned(value, from, ty, at),
        }
    }

    /// A number with a point, its nearest double and its nearest single, as a constant of REAL or LREAL; reports one
    /// that the type does not hold (controller:DT-01).
    pub(super) fn give_real(
        &mut self,
        (double, single): (f64, f32),
        ty: Elementary,
        at: SourcePlace,
    ) -> Option<Expr> {
        let (normal, cell) = match ty {
            Elementary::Real => (single.is_normal(), i64::from(single.to_bits())),
            _ => (double.is_normal(), double.to_bits() as i64),
        };
        if normal || double == 0.0 {
            return Some(self.constant(cell, ty, at));
        }
        let (least, most) = ty.magnitudes();
        let range = format!("{} takes 0 and magnitudes from {least} to {most}", ty.name());
        let message = format!("{double:E} is outside the range of {}", ty.name());
        self.findings.error(Code::Range, at, message, range);
        None
    }

    fn give_integer(&mut self, n: i128, ty: TypeId, at: SourcePlace) -> Option<Expr> {
        if self.is_address(ty) && in_range(n, Elementary::Udint) {
            return Some(Expr { kind: ExprKind::Constant(n as i64), ty: Ty::Address, at });
        }
        let scalar = self.scalar(ty);
        match scalar {
            Some(Elementary::Bool) if n == 0 || n == 1 => Some(self.constant(n as i64, Elementary::Bool, at)),
            Some(Elementary::Real) => {
                Some(self.constant(i64::from((n as f32).to_bits()), Elementary::Real, at))
            }
            Some(Elementary::Lreal) => {
                Some(self.constant((n as f64).to_bits() as i64, Elementary::Lreal, at))
            }
            Some(scalar) if scalar.is_integer() => {
                // A bit string written with its highest bit, as in INT := 16#FFFF, is a number out of range.
                if !in_range(n, scalar) {
                    let (low, high) = scalar.range();
                    let message = format!("{n} is outside the range of {}", scalar.name());
                    let help = format!("{} takes {low} to {high}", scalar.name());
                    self.findings.error(Code::Range, at, message, help);
                    return None;
                }
                let value = self.constant(scalar.wrap(n as i64), scalar, at);
                self.check_subrange(&value, ty);
                Some(value)
            }
            _ => {
                let message = format!("a number is no {}", self.type_name(ty));
                let help = match scalar {
                    Some(ty) if ty.is_duration() => "write it as in T#5s",
                    Some(Elementary::Bool) => "write TRUE or FALSE",
                    _ => "",
                };
                self.findings.error(Code::Type, at, message, help);
                None
            }
        }
    }

    fn give_text(&mut self, wide: bool, units: &[u16], ty: TypeId, at: SourcePlace) -> Option<Expr> {
        match *self.ty(ty) {
            Type::Text { wide: into, length } if into == wide => {
                let kept = units.get(..units.len().min(length as usize)).unwrap_or(units);
                if kept.len() < units.len() {
                    let message = format!("the text has {} characters, {length} fit", units.len());
                    self.findings.warning(Code::Range, at, message, "the rest is cut off");
                }
                let length = (kept.len() as u32).max(1);
                let mut bytes = stored(wide, kept);
                let size = Ty::Text { wide, length }.bytes() as usize;
                bytes.resize(size.max(bytes.len()), 0);
                Some(Expr { kind: ExprKind::Text(bytes), ty: Ty::Text { wide, length }, at })
            }
            Type::Elementary(scalar)
                if units.len() == 1
                    && (scalar == Elementary::Char && !wide || scalar == Elementary::Wchar && wide) =>
            {
                Some(self.constant(i64::from(units.first().copied().unwrap_or(0)), scalar, at))
            }
            Type::Text { wide: into, .. } => {
                let help = if into { "write it in \"double quotes\"" } else { "write it in 'single quotes'" };
                let message = format!("this text does not go into {}", self.type_name(ty));
                self.findings.error(Code::Type, at, message, help);
                None
            }
            _ => {
                let message = format!("a text is no {}", self.type_name(ty));
                self.findings.error(Code::Type, at, message, "");
                None
            }
        }
    }

    /// A typed value into a type.
    pub(super) fn assigned(
        &mut self,
        value: Expr,
        from: TypeId,
        to: TypeId,
        at: SourcePlace,
    ) -> Option<Expr> {
        if from == WRONG || to == WRONG {
            return None;
        }
        let value = if from == to { self.cut(value) } else { value };
        if from == to {
            return Some(value);
        }
        let target = self.tree_type(to);
        if let (Some(a), Some(b)) = (self.scalar(from), self.scalar(to)) {
            self.check_subrange_of(&value, to);
            if a == b {
                return Some(self.cut(value));
            }
            if matches!(self.ty(to), Type::Enumeration(_)) && !matches!(self.ty(from), Type::Enumeration(_)) {
                let message = format!("{} becomes {}", self.type_name(from), self.type_name(to));
                self.findings.warning(Code::SignChange, at, message, "not every number is one of its values");
            }
            if let Some(number) = whole_constant(&value)
                && b.is_integer()
                && in_range(number, b)
            {
                return Some(self.constant(b.wrap(number as i64), b, at));
            }
            if let (Elementary::Lreal, Elementary::Real, ExprKind::Constant(cell)) = (a, b, &value.kind) {
                let double = f64::from_bits(*cell as u64);
                self.give_real((double, double as f32), b, at)?;
            }
            return match implicit(a, b) {
                Implicit::Silent => Some(self.widened(value, target)),
                Implicit::Warned(_) if a.bits() == b.bits() && is_direct(&value) => {
                    Some(self.widened(value, target))
                }
                Implicit::Warned(why) => {
                    let message = format!("{} becomes {}{why}", self.type_name(from), self.type_name(to));
                    let help = format!("{}_TO_{} says that this is meant", a.name(), b.name());
                    self.findings.warning(Code::SignChange, at, message, help);
                    Some(self.widened(value, target))
                }
                Implicit::No if a.bits() > b.bits() && goes_back(&value, b) => {
                    let message =
                        format!("{} becomes {}: large numbers are cut", a.name(), self.type_name(to));
                    let help = format!("{}_TO_{} says that this is meant", a.name(), b.name());
                    self.findings.warning(Code::SignChange, at, message, help);
                    Some(self.widened(value, target))
                }
                Implicit::No => {
                    self.mismatch(from, to, at);
                    None
                }
            };
        }
        if let (Type::Reference(of), ExprKind::Load(place)) = (self.ty(to), &value.kind)
            && self.reference_fits(from, *of, false)
        {
            let place = place.clone();
            return Some(self.address_of(place));
        }
        match (self.ty(from).clone(), self.ty(to).clone()) {
            (Type::Text { wide: a, .. }, Type::Text { wide: b, .. }) if a == b => Some(value),
            (Type::Elementary(Elementary::Char), Type::Text { wide: false, .. })
            | (Type::Elementary(Elementary::Wchar), Type::Text { wide: true, .. }) => {
                Some(self.converted(value, target))
            }
            (a, b) if self.pointers_go(&a, &b) => Some(self.reinterpreted(value, target)),
            // The vendor's tool lets addresses be numbers of 32 bits, and of 64 for programs that run there too.
            (Type::Pointer(_), Type::Elementary(ty)) if ty.bits() == 32 && ty.is_integer() => {
                Some(self.reinterpreted(value, target))
            }
            (Type::Pointer(_), Type::Elementary(ty)) if ty.bits() == 64 && ty.is_integer() => {
                let narrow = self.reinterpreted(value, Ty::Scalar(Elementary::Udint));
                Some(self.widened(narrow, target))
            }
            (Type::Elementary(ty), Type::Pointer(_)) if ty.is_integer() => {
                let narrow = self.widened(value, Ty::Scalar(Elementary::Udint));
                Some(self.reinterpreted(narrow, target))
            }
            (Type::Block(_), Type::Interface(interface)) => self.instance_as(value, from, interface, to, at),
            (Type::Block(_) | Type::Native(_), _) => {
                self.not_a_value(at);
                None
            }
            _ => {
                self.mismatch(from, to, at);
                None
            }
        }
    }

    pub(super) fn not_a_value(&mut self, at: SourcePlace) {
        let message = "this is an instance of a function block, not a value";
        self.findings.error(Code::NotAValue, at, message, "name one of its outputs, as in t1.Q");
    }

    /// A constant, or a value of another subrange, that can be seen not to fit.
    fn check_subrange_of(&mut self, value: &Expr, to: TypeId) {
        self.check_subrange(value, to);
    }

    /// Whether an address of one type goes into another.
    fn pointers_go(&self, from: &Type, to: &Type) -> bool {
        match (from, to) {
            (Type::Pointer(_), Type::Pointer(_)) => true,
            (Type::RefTo(a) | Type::Pointer(a), Type::RefTo(b) | Type::Pointer(b))
            | (Type::Reference(a), Type::Reference(b)) => a == b || self.block_extends(*a, *b),
            (Type::Interface(a), Type::Interface(b)) => self.interface_extends(*a, *b),
            _ => false,
        }
    }

    /// Whether both are blocks and the first extends the second.
    pub(super) fn block_extends(&self, a: TypeId, b: TypeId) -> bool {
        match (self.ty(a), self.ty(b)) {
            (Type::Block(a), Type::Block(b)) => self.extends(*a, *b),
            (Type::Structure(_), Type::Structure(_)) => false,
            _ => false,
        }
    }

    /// An instance as a value of an interface: its address.
    fn instance_as(
        &mut self,
        value: Expr,
        from: TypeId,
        interface: u32,
        to: TypeId,
        at: SourcePlace,
    ) -> Option<Expr> {
        let Type::Block(block) = *self.ty(from) else { return None };
        if !self.implements(block, interface) {
            self.mismatch(from, to, at);
            return None;
        }
        match value.kind {
            ExprKind::Load(place) => Some(self.address_of(place)),
            _ => {
                self.mismatch(from, to, at);
                None
            }
        }
    }

    pub(super) fn mismatch(&mut self, from: TypeId, to: TypeId, at: SourcePlace) {
        let message = format!("{} does not go into {}", self.type_name(from), self.type_name(to));
        let help = match (self.scalar(from), self.scalar(to)) {
            (Some(a), Some(_)) => self.conversion_help(a, to),
            _ => String::new(),
        };
        self.findings.error(Code::Type, at, message, help);
    }

    pub(super) fn conversion_help(&self, from: Elementary, to: TypeId) -> String {
        match self.scalar(to) {
            Some(to) => format!("convert it with {}_TO_{}", from.name(), to.name()),
            None => String::new(),
        }
    }

    /// The type in which two operands meet: the one that holds both, else the smallest signed one that does. A
    /// literal takes the type of the other where it fits.
    pub(super) fn common(&mut self, a: &LiteralOperand, b: &LiteralOperand) -> Option<TypeId> {
        match (a, b) {
            (LiteralOperand::Integer(_) | LiteralOperand::Real(..), LiteralOperand::Value(_, ty))
            | (LiteralOperand::Value(_, ty), LiteralOperand::Integer(_) | LiteralOperand::Real(..)) => {
                let literal = if a.is_literal() { a } else { b };
                self.literal_beside(literal, *ty)
            }
            (LiteralOperand::Real(..), LiteralOperand::Real(..) | LiteralOperand::Integer(_))
            | (LiteralOperand::Integer(_), LiteralOperand::Real(..)) => {
                Some(self.elementary(Elementary::Lreal))
            }
            (LiteralOperand::Integer(x), LiteralOperand::Integer(y)) => {
                let ty = meet(integer_type(*x)?, integer_type(*y)?)?;
                Some(self.elementary(ty))
            }
            (LiteralOperand::Text(a, units), LiteralOperand::Text(b, other)) if a == b => {
                let length = units.len().max(other.len()).max(1) as u32;
                Some(self.intern(Type::Text { wide: *a, length }))
            }
            // As long as the longer one: what is compared or chosen is not cut.
            (LiteralOperand::Text(wide, units), LiteralOperand::Value(_, ty))
            | (LiteralOperand::Value(_, ty), LiteralOperand::Text(wide, units))
                if matches!(self.ty(*ty), Type::Text { wide: own, .. } if own == wide) =>
            {
                let literal = self.intern(Type::Text { wide: *wide, length: (units.len() as u32).max(1) });
                self.common_type(*ty, literal)
            }
            (LiteralOperand::Text(..) | LiteralOperand::Null, LiteralOperand::Value(_, ty))
            | (LiteralOperand::Value(_, ty), LiteralOperand::Text(..) | LiteralOperand::Null) => Some(*ty),
            (LiteralOperand::Value(_, a), LiteralOperand::Value(_, b)) => self.common_type(*a, *b),
            _ => None,
        }
    }

    fn literal_beside(&mut self, literal: &LiteralOperand, ty: TypeId) -> Option<TypeId> {
        if self.is_address(ty) {
            return Some(ty);
        }
        let scalar = self.scalar(ty)?;
        match literal {
            LiteralOperand::Real(..) if scalar.is_real() => Some(self.elementary(scalar)),
            LiteralOperand::Real(..) if scalar.is_integer() => {
                // REAL holds the small ones exactly.
                let real = if scalar.bits() <= 16 { Elementary::Real } else { Elementary::Lreal };
                Some(self.elementary(real))
            }
            LiteralOperand::Integer(_) if scalar.is_real() => Some(self.elementary(scalar)),
            LiteralOperand::Integer(n) => {
                if scalar == Elementary::Bool && (*n == 0 || *n == 1)
                    || scalar.is_integer() && in_range(*n, scalar)
                {
                    return Some(self.elementary(scalar));
                }
                let ty = meet(scalar, integer_type(*n)?)?;
                Some(self.elementary(ty))
            }
            _ => None,
        }
    }

    pub(super) fn common_type(&mut self, a: TypeId, b: TypeId) -> Option<TypeId> {
        if a == b {
            return Some(a);
        }
        if let (Some(x), Some(y)) = (self.scalar(a), self.scalar(b)) {
            let ty = meet(x, y)?;
            return Some(self.elementary(ty));
        }
        match (self.ty(a).clone(), self.ty(b).clone()) {
            (Type::Text { wide, length }, Type::Text { wide: other, length: more }) if wide == other => {
                Some(self.intern(Type::Text { wide, length: length.max(more) }))
            }
            (Type::Text { wide: false, .. }, Type::Elementary(Elementary::Char))
            | (Type::Text { wide: true, .. }, Type::Elementary(Elementary::Wchar)) => Some(a),
            (Type::Elementary(Elementary::Char), Type::Text { wide: false, .. })
            | (Type::Elementary(Elementary::Wchar), Type::Text { wide: true, .. }) => Some(b),
            (Type::Pointer(_) | Type::RefTo(_), Type::Pointer(_) | Type::RefTo(_)) => Some(a),
            (Type::Interface(_), Type::Interface(_)) => Some(a),
            (Type::Pointer(_), Type::Elementary(ty)) if ty.is_integer() => Some(a),
            (Type::Elementary(ty), Type::Pointer(_)) if ty.is_integer() => Some(b),
            _ => None,
        }
    }
}

/// Whether a whole number is wider than the type that it goes into only because of how it was computed: operands of
/// different signs met in a wider type, or TRUNC, which gives an INT in older tools, gave a DINT.
fn goes_back(value: &Expr, to: Elementary) -> bool {
    let (Ty::Scalar(own) | Ty::Promoted(own)) = value.ty else { return false };
    if !own.is_integer() || !to.is_integer() {
        return false;
    }
    if to.bits() >= own.bits() {
        return true;
    }
    match &value.kind {
        ExprKind::Constant(cell) => in_range(own.number(*cell), to),
        ExprKind::Library(function, ..) => function.name == "TRUNC_DINT",
        ExprKind::Reinterpret(of) | ExprKind::Unary(_, of) => goes_back(of, to),
        ExprKind::Binary(op, a, b) => {
            use crate::tree::BinaryOp::{Add, And, Divide, Mod, Multiply, Or, Subtract, Xor};
            matches!(op, Add | Subtract | Multiply | Divide | Mod | And | Or | Xor)
                && goes_back(a, to)
                && goes_back(b, to)
        }
        _ => false,
    }
}

/// Whether a value is read from an address: its bits suit numbers of their width.
fn is_direct(value: &Expr) -> bool {
    matches!(&value.kind, ExprKind::Load(place)
        if matches!(place.root, crate::tree::TreeRoot::Absolute) && place.offset >= crate::code::map::OWN_END)
}

/// The elementary type in which two others meet.
pub(super) fn meet(a: Elementary, b: Elementary) -> Option<Elementary> {
    use Elementary::{Bool, Dint, Int, Lint, Lreal, Real};
    if a == b {
        return Some(a);
    }
    if a.is_real() || b.is_real() {
        let (real, other) = if a.is_real() { (a, b) } else { (b, a) };
        return match other {
            Real | Lreal => Some(Lreal),
            // What REAL does not hold exactly becomes it all the same, as in the vendor's tool.
            other if other.is_integer() => Some(real),
            _ => None,
        };
    }
    if a.is_duration() && b.is_duration() {
        return Some(Elementary::Ltime);
    }
    if a.is_date() && b.is_date() {
        return match implicit(a, b) {
            Implicit::Silent => Some(b),
            _ => matches!(implicit(b, a), Implicit::Silent).then_some(a),
        };
    }
    if a == Bool && b.is_bit_string() {
        return Some(b);
    }
    if b == Bool && a.is_bit_string() {
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
    [Int, Dint, Lint].into_iter().find(|ty| ty.holds(a) && ty.holds(b))
}

/// Whether a scalar goes into another type by itself.
pub(super) enum Implicit {
    Silent,
    /// With a warning that ends like this.
    Warned(&'static str),
    No,
}

pub(super) fn implicit(from: Elementary, to: Elementary) -> Implicit {
    use Elementary::{Bool, Date, Dt, Ldate, Ldt, Lreal, Ltime, Ltod, Real, Time, Tod};
    if from == to {
        return Implicit::Silent;
    }
    if from.is_integer() && to.is_integer() {
        return if to.holds(from) {
            Implicit::Silent
        } else if to.bits() == from.bits() {
            Implicit::Warned(": large numbers change their sign")
        } else {
            Implicit::No
        };
    }
    match (from, to) {
        (Real, Lreal) | (Time, Ltime) | (Date, Ldate) | (Tod, Ltod) | (Dt, Ldt) => Implicit::Silent,
        (Lreal, Real) => Implicit::Warned(": digits are lost"),
        (from, Real) if from.is_integer() => {
            if from.bits() <= 16 {
                Implicit::Silent
            } else {
                Implicit::Warned(": digits of large numbers are lost")
            }
        }
        (from, Lreal) if from.is_integer() => {
            if from.bits() <= 32 {
                Implicit::Silent
            } else {
                Implicit::Warned(": digits of large numbers are lost")
            }
        }
        (Bool, to) if to.is_bit_string() => Implicit::Silent,
        _ => Implicit::No,
    }
}
