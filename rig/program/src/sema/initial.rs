//! Initial values, as bytes.

use super::declare::initial_at;
use super::late::LateBase;
use super::scope::{Home, ScopeSymbol};
use super::types::{Type, TypeId, elements, stride};
use super::{Sema, State};
use crate::codes::Code;
use crate::findings::count;
use crate::parse::ast::{self, Expr, Initializer, SectionKind};
use crate::tree::{self, ExprKind, Stmt, StmtKind, Target, TreePlace};

/// How deep constants may be made of others that are declared later.
const CONSTANT_DEPTH: u32 = 60;

impl<'a> Sema<'a> {
    /// Writes an initial value into an image, over the default that stands at `offset`.
    pub(super) fn write_initial(
        &mut self,
        ty: TypeId,
        initial: &'a Initializer,
        image: &mut [u8],
        offset: u32,
    ) {
        let outer = std::mem::replace(&mut self.context.constant, true);
        self.write_one(ty, initial, image, offset);
        self.context.constant = outer;
    }

    fn write_one(&mut self, ty: TypeId, initial: &'a Initializer, image: &mut [u8], offset: u32) {
        match (self.ty(ty).clone(), initial) {
            (Type::Wrong, _) => {}
            // Rows in brackets of their own: an array of arrays lies in memory alike.
            (Type::Array { dimensions, of }, Initializer::List(list, _))
                if dimensions.len() > 1
                    && !matches!(self.ty(of), Type::Array { .. })
                    && list.iter().all(|(_, value)| matches!(value, Initializer::List(..))) =>
            {
                let (first, rest) = dimensions.split_at(1);
                let row = self.intern(Type::Array { dimensions: rest.to_vec(), of });
                let rows = self.intern(Type::Array { dimensions: first.to_vec(), of: row });
                self.write_one(rows, initial, image, offset);
            }
            (Type::Array { dimensions, of }, Initializer::List(list, at)) => {
                let step = stride(self.layout(of));
                let room = elements(&dimensions);
                let mut nth = 0u64;
                for (times, value) in list {
                    let times = match times {
                        None => 1,
                        Some(times) => match self.constant_number(times) {
                            Some(n) if n >= 0 => n as u64,
                            Some(_) => {
                                let message = "a value cannot be repeated less than no time";
                                self.findings.error(Code::InitialValue, times.at, message, "");
                                return;
                            }
                            None => return,
                        },
                    };
                    if times > room - nth.min(room) {
                        let message = format!("the array has {}", count(room.min(1 << 30) as u32, "element"));
                        self.findings.error(Code::InitialValue, *at, message, "remove what is too much");
                        return;
                    }
                    if times == 0 {
                        continue;
                    }
                    let first = offset + nth as u32 * step;
                    self.write_one(of, value, image, first);
                    let bytes = image.get(first as usize..(first + step) as usize).map(<[u8]>::to_vec);
                    let Some(bytes) = bytes.or_else(|| {
                        // The last element may end before its stride does.
                        image.get(first as usize..).map(<[u8]>::to_vec)
                    }) else {
                        return;
                    };
                    // What waits is to be noted for each.
                    let again = if self.base != LateBase::None && self.is_late(value) { times } else { 1 };
                    for copy in 1..again {
                        self.write_one(of, value, image, offset + (nth + copy) as u32 * step);
                    }
                    for copy in 1..times {
                        let at = (first + copy as u32 * step) as usize;
                        let end = (at + bytes.len()).min(image.len());
                        if let Some(room) = image.get_mut(at..end) {
                            let length = room.len();
                            room.copy_from_slice(&bytes[..length]);
                        }
                    }
                    nth += times;
                }
            }
            (_, Initializer::Members(members, _)) => {
                for (nth, (name, value)) in members.iter().enumerate() {
                    if members.iter().take(nth).any(|(other, _)| other.key == name.key) {
                        let message = format!("`{}` has a value already", self.shown(*name));
                        self.findings.error(
                            Code::InitialValue,
                            name.at,
                            message,
                            "give each member one value",
                        );
                        continue;
                    }
                    match self.initial_member(ty, *name) {
                        Some((member, at)) => self.write_one(member, value, image, offset + at),
                        None => {
                            if !matches!(self.ty(ty), Type::Structure(_) | Type::Block(_) | Type::Native(_)) {
                                let message = format!("{} has no members", self.type_name(ty));
                                self.findings.error(Code::InitialValue, name.at, message, "");
                                return;
                            }
                            let message = format!(
                                "{} has no member `{}` to give a value to",
                                self.type_name(ty),
                                self.shown(*name)
                            );
                            self.findings.error(Code::InitialValue, name.at, message, "");
                        }
                    }
                }
            }
            (Type::Array { .. }, Initializer::One(value)) => {
                if !matches!(value.kind, ast::ExprKind::Name(_) | ast::ExprKind::Global(_)) {
                    let message = format!("{} takes a list", self.type_name(ty));
                    let help = "write the values in brackets, as in [1, 2, 3(0)]";
                    self.findings.error(Code::InitialValue, value.at, message, help);
                } else if let Some(bytes) = self.constant_bytes(value, ty) {
                    put(image, offset, &bytes);
                }
            }
            (_, Initializer::List(_, at)) => {
                let message = format!("{} takes one value", self.type_name(ty));
                self.findings.error(Code::InitialValue, *at, message, "lists are for arrays");
            }
            (_, Initializer::One(value)) => {
                if self.wait_for(value, ty, offset) {
                    return;
                }
                if let Some(bytes) = self.constant_bytes(value, ty) {
                    put(image, offset, &bytes);
                } else if self.findings_allow(value) {
                    let message = format!("{} takes the values of its members", self.type_name(ty));
                    let help = "write them as in (a := 1, b := 2)";
                    self.findings.error(Code::InitialValue, value.at, message, help);
                }
            }
        }
    }

    /// Whether nothing was reported for this value yet: a block or structure cannot take it.
    fn findings_allow(&self, value: &Expr) -> bool {
        !self.findings.reported_within(value.at)
    }

    /// A member that an initial value may name: fields, pins and variables, but not in-outs.
    fn initial_member(&mut self, ty: TypeId, name: ast::Name) -> Option<(TypeId, u32)> {
        match self.ty(ty).clone() {
            Type::Structure(place) => {
                let structure = self.structures.get(place as usize)?;
                structure.fields.iter().find(|f| f.key == name.key).map(|f| (f.ty, f.offset))
            }
            Type::Block(place) => {
                let (owner, nth) = self.member(place, name.key)?;
                let symbol = self.member_symbol(owner, nth)?;
                match (symbol.home, symbol.constant) {
                    (Home::This(offset), false) => Some((symbol.type_id(), offset)),
                    _ => None,
                }
            }
            Type::Native(place) => {
                let native = self.options.blocks.get(usize::from(place))?;
                let key = self.names.key_text(name.key);
                let nth = native
                    .pins
                    .iter()
                    .position(|pin| pin.name == key && pin.kind != crate::native::PinKind::Hidden)?;
                let offset = *self.native_layouts.get(usize::from(place))?.0.get(nth)?;
                let ty = self.elementary(native.pins.get(nth)?.ty);
                Some((ty, u32::from(offset)))
            }
            _ => None,
        }
    }

    /// The cell of an initial value of a scalar type.
    pub(super) fn constant_initial(&mut self, initial: &'a Initializer, ty: TypeId) -> Option<i64> {
        match initial {
            Initializer::One(value) => self.constant_cell(value, ty),
            other => {
                let message = format!("{} takes one value", self.type_name(ty));
                self.findings.error(Code::InitialValue, initial_at(other), message, "");
                None
            }
        }
    }

    /// Initial values in the frame of a callable: constants into its image. What is no constant is assigned when the
    /// call begins, which is noted here and made by [`Self::prologue`].
    pub(super) fn frame_initials(&mut self, place: u32) {
        let result = self.callables.get(place as usize).and_then(|c| Some((c.result_ref?, c.result?)));
        if let Some((written, ty)) = result
            && let Some(initial) = self.type_initial(written)
        {
            self.frame_initial(place, ty, initial, 0);
        }
        let symbols = self.callables.get(place as usize).map_or(Vec::new(), |c| c.symbols.clone());
        for symbol in symbols {
            let inherited = self.type_initial(&symbol.decl.ty);
            let Some(initial) = symbol.decl.initial.as_ref().or(inherited) else {
                self.check_constant(&symbol);
                continue;
            };
            match symbol.home {
                Home::Frame(at) => {
                    if self.is_dynamic(&symbol, initial) {
                        continue;
                    }
                    self.frame_initial(place, symbol.type_id(), initial, at);
                }
                Home::Absolute(address) => self.data_initial(&symbol, address),
                Home::FrameAddress(_) => {
                    let message = "an in-out has no initial value";
                    self.findings.error(Code::InitialValue, initial_at(initial), message, "remove it");
                }
                _ => {}
            }
        }
    }

    /// Writes an initial value to an offset of a callable's frame.
    fn frame_initial(&mut self, place: u32, ty: TypeId, initial: &'a Initializer, at: u32) {
        let callable = self.callables.get_mut(place as usize);
        let mut frame = callable.map_or(Vec::new(), |c| std::mem::take(&mut c.frame));
        self.write_initial(ty, initial, &mut frame, at);
        if let Some(callable) = self.callables.get_mut(place as usize) {
            callable.frame = frame;
        }
    }

    /// Reports a constant that nothing gives a value to. Structures bring their own: libraries keep their settings so.
    pub(super) fn check_constant(&mut self, symbol: &ScopeSymbol<'a>) {
        let ty = symbol.type_id();
        let own = matches!(self.ty(ty), Type::Structure(_) | Type::Block(_) | Type::Native(_));
        if symbol.is_value() && !super::is_wrong(ty) && !own {
            let message = format!("the constant `{}` has no value", symbol.shown);
            self.findings.error(Code::ConstantValue, symbol.name.at, message, "write := and the value");
        }
    }

    /// Whether an initial value of a local variable has to be computed at each call.
    fn is_dynamic(&mut self, symbol: &ScopeSymbol<'a>, initial: &'a Initializer) -> bool {
        let Initializer::One(value) = initial else { return false };
        matches!(symbol.kind, SectionKind::Local | SectionKind::Temp)
            && !symbol.constant
            && !self.is_constant_expr(value)
    }

    /// Whether an expression is made of constants alone, by its looks.
    pub(super) fn is_constant_expr(&self, value: &Expr) -> bool {
        match &value.kind {
            ast::ExprKind::Name(name) => match self.find(name.key) {
                Some(found) => self.is_constant_symbol(found),
                None => true,
            },
            ast::ExprKind::Unary(_, of) => self.is_constant_expr(of),
            ast::ExprKind::Chain(first, rest) => {
                self.is_constant_expr(first) && rest.iter().all(|(_, _, e)| self.is_constant_expr(e))
            }
            ast::ExprKind::Call(callee, arguments) => {
                let user = matches!(&callee.kind, ast::ExprKind::Name(name)
                    if self.find(name.key).is_none());
                user && arguments.iter().all(|argument| match argument {
                    ast::Argument::Positional(e) | ast::Argument::Input(_, e) => self.is_constant_expr(e),
                    _ => true,
                }) && !self.is_address_call(callee)
            }
            ast::ExprKind::Member(..)
            | ast::ExprKind::Index(..)
            | ast::ExprKind::Deref(_)
            | ast::ExprKind::This
            | ast::ExprKind::Super
            | ast::ExprKind::Direct(_)
            | ast::ExprKind::Part { .. } => self.enumerator_member(value),
            _ => true,
        }
    }

    pub(super) fn is_address_call(&self, callee: &Expr) -> bool {
        matches!(&callee.kind, ast::ExprKind::Name(name) if matches!(self.names.key_text(name.key), "ADR" | "REF"))
    }

    /// `colour.red`.
    fn enumerator_member(&self, value: &Expr) -> bool {
        let ast::ExprKind::Member(of, _) = &value.kind else { return false };
        matches!(&of.kind, ast::ExprKind::Name(name)
            if matches!(self.find(name.key), Some(super::scope::FoundName::Type(_))))
    }

    /// Assignments at the begin of a call, of initial values that are no constants. The context is that of the body.
    pub(super) fn prologue(&mut self, place: u32) -> Vec<Stmt> {
        let symbols = self.callables.get(place as usize).map_or(Vec::new(), |c| c.symbols.clone());
        let mut list = self.edges(place);
        for symbol in &symbols {
            if let (Home::Frame(offset), SectionKind::Local | SectionKind::Temp) = (symbol.home, symbol.kind)
            {
                self.made_variable(symbol, (tree::TreeRoot::Frame, offset), &mut list);
            }
        }
        for symbol in symbols {
            let (Some(initial), Home::Frame(offset)) = (&symbol.decl.initial, symbol.home) else { continue };
            let Initializer::One(value) = initial else { continue };
            if !self.is_dynamic(&symbol, initial) {
                continue;
            }
            let Some(typed) = self.value(value, symbol.type_id()) else { continue };
            let place = TreePlace {
                root: tree::TreeRoot::Frame,
                offset,
                indices: Vec::new(),
                ty: self.tree_type(symbol.type_id()),
                retained: false,
                at: symbol.name.at,
            };
            list.push(Stmt { kind: StmtKind::Assign(Target::Place(place), typed), at: value.at });
        }
        list
    }

    /// The bytes of a constant of a type; `None` where it is none, reported where that is for sure.
    fn constant_bytes(&mut self, value: &'a Expr, ty: TypeId) -> Option<Vec<u8>> {
        let typed = self.constant_value(value, ty)?;
        let size = self.layout(ty).size as usize;
        match typed.kind {
            ExprKind::Constant(cell) => {
                let mut bytes = cell.to_le_bytes().to_vec();
                bytes.truncate(size.min(8));
                Some(bytes)
            }
            ExprKind::Text(mut bytes) | ExprKind::Bytes(mut bytes) => {
                if bytes.len() > size {
                    // Cut, with the closing unit kept.
                    let unit = if matches!(self.ty(ty), Type::Text { wide: true, .. }) { 2 } else { 1 };
                    bytes.truncate(size);
                    let from = size.saturating_sub(unit);
                    bytes.iter_mut().skip(from).for_each(|byte| *byte = 0);
                }
                Some(bytes)
            }
            _ => None,
        }
    }

    /// The value of a symbol that is a constant of a scalar type.
    pub(super) fn symbol_value(&mut self, found: super::scope::FoundName) -> Option<i64> {
        use super::scope::FoundName;
        let symbol = match found {
            FoundName::Local(place) => self
                .context
                .callable
                .and_then(|c| self.callables.get(c as usize))?
                .symbols
                .get(place as usize)?,
            FoundName::Member(owner, place) => self.member_symbol(owner, place)?,
            FoundName::Global(place) => self.globals.get(place as usize)?,
            _ => return None,
        }
        .clone();
        if !symbol.is_value() {
            return None;
        }
        match symbol.value {
            State::Done(value) => return value,
            State::Busy => {
                let message = format!("the constant `{}` is defined by itself", symbol.shown);
                self.findings.error(Code::ConstantValue, symbol.name.at, message, "");
                return None;
            }
            State::Untouched => {}
        }
        if self.depth >= CONSTANT_DEPTH {
            let message = "constants are made of each other too deeply";
            self.findings.error(Code::Depth, symbol.name.at, message, "declare the inner ones first");
            return None;
        }
        self.depth += 1;
        self.keep_value(found, State::Busy);
        let outer = self.context.callable;
        let (pou, constant) = (self.context.pou, self.context.constant);
        match found {
            FoundName::Member(owner, _) => {
                self.context.pou = Some(owner);
                self.context.callable = None;
            }
            FoundName::Global(_) => {
                self.context.pou = None;
                self.context.callable = None;
            }
            _ => {}
        }
        self.context.constant = true;
        let ty = match (found, symbol.ty) {
            (_, State::Done(ty)) => ty,
            (FoundName::Global(place), _) => self.global_type(place),
            _ => self.resolve(&symbol.decl.ty),
        };
        let value = match (&symbol.decl.initial, self.scalar(ty)) {
            (Some(initial), Some(_)) => self.constant_initial(initial, ty),
            _ => None,
        };
        self.depth -= 1;
        self.context.callable = outer;
        self.context.pou = pou;
        self.context.constant = constant;
        self.keep_value(found, State::Done(value));
        if let (FoundName::Member(owner, place), State::Untouched) = (found, symbol.ty)
            && let Some(symbol) =
                self.pous.get_mut(owner as usize).and_then(|pou| pou.symbols.get_mut(place as usize))
        {
            symbol.ty = State::Done(ty);
        }
        value
    }

    fn keep_value(&mut self, found: super::scope::FoundName, value: State<Option<i64>>) {
        use super::scope::FoundName;
        let symbol = match found {
            FoundName::Local(place) => self
                .context
                .callable
                .and_then(|c| self.callables.get_mut(c as usize))
                .and_then(|c| c.symbols.get_mut(place as usize)),
            FoundName::Member(owner, place) => {
                self.pous.get_mut(owner as usize).and_then(|pou| pou.symbols.get_mut(place as usize))
            }
            FoundName::Global(place) => self.globals.get_mut(place as usize),
            _ => None,
        };
        if let Some(symbol) = symbol {
            symbol.value = value;
        }
    }

    /// Whether a name means a constant.
    pub(super) fn is_constant_symbol(&self, found: super::scope::FoundName) -> bool {
        use super::scope::FoundName;
        match found {
            FoundName::Local(place) => self
                .context
                .callable
                .and_then(|c| self.callables.get(c as usize))
                .and_then(|c| c.symbols.get(place as usize))
                .is_some_and(|symbol| symbol.is_value()),
            FoundName::Member(owner, place) => self.member_symbol(owner, place).is_some_and(|s| s.is_value()),
            FoundName::Global(place) => self.globals.get(place as usize).is_some_and(|s| s.is_value()),
            FoundName::Enumerator(..) | FoundName::Ambiguous => true,
            _ => false,
        }
    }
}

/// Bytes over an image; what does not fit is left out.
fn put(image: &mut [u8], offset: u32, bytes: &[u8]) {
    let from = offset as usize;
    let end = (from + bytes.len()).min(image.len());
    if let Some(room) = image.get_mut(from..end) {
        let length = room.len();
        room.copy_from_slice(&bytes[..length]);
    }
}
