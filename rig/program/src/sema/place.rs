//! What paths mean: variables, members, elements, bits, and what can be called.

use super::Sema;
use super::block::home_of;
use super::literal::LiteralOperand;
use super::scope::{FoundName, Home, ScopeSymbol};
use super::types::{Type, TypeId, WRONG};
use crate::codes::Code;
use crate::findings::{SourcePlace, similar};
use crate::parse::ast::{self, Key, Name};
use crate::program::Retention;
use crate::tree::{self, Expr, ExprKind, Target, TreePlace, Ty};
use crate::types::Elementary;
use signal::{Address, Area};

/// How an object is reached.
#[derive(Clone, Debug)]
pub(super) enum ObjectAccess {
    /// The running one.
    Same,
    /// The running one as what it extends.
    Super(u32),
    /// One whose class is known.
    Exact(TreePlace, u32),
    /// The one at an address, of this block or one that extends it.
    Block(Expr, u32),
    /// The one at an address, of whatever class.
    Interface(Expr, u32),
}

/// What a path means.
#[derive(Clone, Debug)]
pub(super) enum PathMeaning {
    /// A place, and why it cannot be assigned to.
    Place(TreePlace, TypeId, Option<&'static str>),
    /// A bit of the memory at a place.
    Bit(TreePlace, u32, Option<&'static str>),
    Operand(LiteralOperand),
    Property(ObjectAccess, Name),
    Method(ObjectAccess, Name),
    /// An action: its callable, the instance's place where it is not the running one.
    Action(u32, Option<TreePlace>),
    Function(u32),
    Program(u32),
    Type(TypeId),
    /// The running block as what it extends: `SUPER^`.
    Super(u32),
    Wrong,
}

impl<'a> Sema<'a> {
    /// What an expression denotes, before its value is asked for.
    pub(super) fn meaning(&mut self, written: &ast::Expr) -> PathMeaning {
        match &written.kind {
            ast::ExprKind::Name(name) => self.name_meaning(*name),
            ast::ExprKind::Global(name) => match self.find_outside(name.key) {
                Some(found) => self.found_meaning(found, *name),
                None => self.unknown(*name),
            },
            ast::ExprKind::Qualified(ty, name) => match self.find_outside(ty.key) {
                Some(FoundName::Type(place)) => {
                    let of = self.named_type(place);
                    self.enumerator_of(of, *name)
                }
                _ => self.unknown(*ty),
            },
            ast::ExprKind::Member(of, name) => match self.listed(of, *name) {
                Some(place) => self.symbol_meaning(FoundName::Global(place), *name),
                None if self.of_library(of, *name) => self.name_meaning_outside(*name),
                None => {
                    let of = self.meaning(of);
                    self.member_meaning(of, *name)
                }
            },
            ast::ExprKind::Index(of, indices) => self.index_meaning(of, indices, written.at),
            ast::ExprKind::Deref(of) => self.deref_meaning(of, written.at),
            ast::ExprKind::Part { of, bits, number } => self.part_meaning(of, *bits, *number, written.at),
            ast::ExprKind::Direct(text) => self.direct(text, written.at),
            _ => match self.expr(written, None) {
                // A function gave a reference: it stands for what it refers to.
                LiteralOperand::Value(Expr { kind: ExprKind::Load(place), .. }, ty) => {
                    PathMeaning::Place(place, ty, None)
                }
                operand => PathMeaning::Operand(operand),
            },
        }
    }

    /// A global variable with the name of its list before it, as in `LIMITS.HIGHEST`: exported lists do not say their
    /// name, it is that of their file.
    fn listed(&self, of: &ast::Expr, name: Name) -> Option<u32> {
        let ast::ExprKind::Name(list) = &of.kind else { return None };
        let Some(FoundName::Global(place)) = self.find_outside(name.key) else { return None };
        if self.find(list.key).is_some() {
            return None;
        }
        let file = self.globals.get(place as usize)?.name.at.file;
        let path = self.sources.get(usize::from(file))?.name.as_str();
        let last = path.rsplit(['/', '\\']).next()?;
        let stem = last.rsplit_once('.').map_or(last, |(stem, _)| stem);
        stem.eq_ignore_ascii_case(self.names.key_text(list.key)).then_some(place)
    }

    /// Whether a name that nothing has stands before a type, function or program, as the name of its library.
    pub(super) fn of_library(&self, of: &ast::Expr, name: Name) -> bool {
        let ast::ExprKind::Name(library) = &of.kind else { return false };
        let known = matches!(
            self.find_outside(name.key),
            Some(FoundName::Pou(_) | FoundName::Type(_) | FoundName::Interface(_) | FoundName::Native(_))
        );
        known && self.find(library.key).is_none()
    }

    fn name_meaning_outside(&mut self, name: Name) -> PathMeaning {
        match self.find_outside(name.key) {
            Some(found) => self.found_meaning(found, name),
            None => self.unknown(name),
        }
    }

    fn name_meaning(&mut self, name: Name) -> PathMeaning {
        match self.find(name.key) {
            Some(found) => self.found_meaning(found, name),
            None => self.unknown(name),
        }
    }

    fn found_meaning(&mut self, found: FoundName, name: Name) -> PathMeaning {
        match found {
            FoundName::Local(_) | FoundName::Member(..) | FoundName::Global(_) => {
                self.symbol_meaning(found, name)
            }
            FoundName::Result => {
                let ty = self.running().and_then(|callable| callable.result).unwrap_or(WRONG);
                let place = self.place(tree::TreeRoot::Frame, 0, ty, false, name.at);
                self.followed(place, ty, None)
            }
            FoundName::Pou(place) => match self.pous.get(place as usize).map(|pou| pou.ast.kind) {
                Some(ast::PouKind::Program) => PathMeaning::Program(place),
                Some(ast::PouKind::Function) => PathMeaning::Function(place),
                _ => {
                    let ty = self.intern(Type::Block(place));
                    PathMeaning::Type(ty)
                }
            },
            FoundName::Type(place) => PathMeaning::Type(self.named_type(place)),
            FoundName::Interface(place) => PathMeaning::Type(self.intern(Type::Interface(place))),
            FoundName::Native(place) => PathMeaning::Type(self.intern(Type::Native(place))),
            FoundName::Method(_) => PathMeaning::Method(ObjectAccess::Same, name),
            FoundName::Property => PathMeaning::Property(ObjectAccess::Same, name),
            FoundName::Action(callable) => PathMeaning::Action(callable, None),
            FoundName::Enumerator(ty, cell) => self.enumerator(ty, cell, name.at),
            FoundName::Ambiguous => {
                let message = format!("several enumerations have a value `{}`", self.shown(name));
                self.findings.error(
                    Code::UnknownName,
                    name.at,
                    message,
                    "write it with its type, as in colour.red",
                );
                PathMeaning::Wrong
            }
        }
    }

    pub(super) fn running(&self) -> Option<&super::scope::Callable<'a>> {
        self.context.callable.and_then(|place| self.callables.get(place as usize))
    }

    fn enumerator(&mut self, ty: TypeId, cell: i64, at: SourcePlace) -> PathMeaning {
        let base = self.scalar(ty).unwrap_or(Elementary::Int);
        PathMeaning::Operand(LiteralOperand::Value(self.constant(cell, base, at), ty))
    }

    pub(super) fn enumerator_of(&mut self, ty: TypeId, name: Name) -> PathMeaning {
        if let Type::Enumeration(place) = *self.ty(ty)
            && let Some(enumeration) = self.enumerations.get(place as usize)
        {
            match enumeration.values.iter().find(|(key, ..)| *key == name.key) {
                Some((_, _, cell)) => {
                    let cell = *cell;
                    return self.enumerator(ty, cell, name.at);
                }
                None => {
                    let keys = enumeration.values.iter().map(|(key, ..)| self.names.key_text(*key));
                    let near = similar(self.names.key_text(name.key), keys);
                    self.unknown_member(name, near, &self.type_name(ty));
                    return PathMeaning::Wrong;
                }
            }
        }
        if ty != WRONG {
            let message = format!("{} has no `{}`", self.type_name(ty), self.shown(name));
            self.findings.error(Code::NotAValue, name.at, message, "enumerations have values");
        }
        PathMeaning::Wrong
    }

    pub(super) fn unknown(&mut self, name: Name) -> PathMeaning {
        let mut known: Vec<Key> = Vec::new();
        if let Some(callable) = self.running() {
            known.extend(callable.symbols.iter().map(|symbol| symbol.name.key));
        }
        if let Some(pou) = self.context.pou {
            for owner in self.lineage(pou) {
                known.extend(self.pous[owner as usize].symbols.iter().map(|symbol| symbol.name.key));
            }
        }
        known.extend(self.globals.iter().map(|symbol| symbol.name.key));
        known.extend(self.pous.iter().map(|pou| pou.ast.name.key));
        let text = self.names.key_text(name.key);
        let near = similar(text, known.iter().map(|key| self.names.key_text(*key)));
        let help = match near {
            Some(near) => format!("did you mean {}?", self.written(&near)),
            None => "declare it in VAR".to_string(),
        };
        let message = format!("`{}` is not known", self.shown(name));
        self.findings.error(Code::UnknownName, name.at, message, help);
        PathMeaning::Wrong
    }

    /// A name as it was declared.
    pub(super) fn written(&self, key: &str) -> String {
        let of = |symbols: &[ScopeSymbol<'a>]| {
            symbols.iter().find(|s| self.names.key_text(s.name.key) == key).map(|s| s.shown.to_string())
        };
        let local = self.running().and_then(|callable| of(&callable.symbols));
        let member = || {
            let pou = self.context.pou?;
            self.lineage(pou).find_map(|owner| of(&self.pous[owner as usize].symbols))
        };
        let unit =
            || self.pous.iter().find(|p| self.names.key_text(p.ast.name.key) == key).map(|p| p.shown.clone());
        local.or_else(member).or_else(|| of(&self.globals)).or_else(unit).unwrap_or_else(|| key.to_string())
    }

    pub(super) fn unknown_member(&mut self, name: Name, near: Option<String>, of: &str) {
        let help = near.map_or(String::new(), |near| format!("did you mean {near}?"));
        let message = format!("`{of}` has no `{}`", self.shown(name));
        self.findings.error(Code::UnknownName, name.at, message, help);
    }

    pub(super) fn place(
        &self,
        root: tree::TreeRoot,
        offset: u32,
        ty: TypeId,
        retained: bool,
        at: SourcePlace,
    ) -> TreePlace {
        TreePlace { root, offset, indices: Vec::new(), ty: self.tree_type(ty), retained, at }
    }

    /// A variable or constant.
    pub(super) fn symbol_meaning(&mut self, found: FoundName, name: Name) -> PathMeaning {
        let symbol = match found {
            FoundName::Local(place) => self.running().and_then(|c| c.symbols.get(place as usize)).cloned(),
            FoundName::Member(owner, place) => self.member_symbol(owner, place).cloned(),
            FoundName::Global(place) => {
                self.global_type(place);
                self.globals.get(place as usize).cloned()
            }
            _ => None,
        };
        let Some(mut symbol) = symbol else { return PathMeaning::Wrong };
        if let (Some(edge), FoundName::Member(..)) = (symbol.edge, found) {
            // Inside of the block the input stands for its edge.
            symbol.home = Home::This(edge);
            symbol.constant = true;
            return self.home_meaning(&symbol, name.at);
        }
        if symbol.is_value() {
            let value = self.symbol_value(found);
            let ty = match found {
                FoundName::Global(place) => self.globals[place as usize].type_id(),
                FoundName::Member(owner, place) => {
                    self.member_symbol(owner, place).map_or(WRONG, ScopeSymbol::type_id)
                }
                _ => symbol.type_id(),
            };
            if let (Some(cell), Some(scalar)) = (value, self.scalar(ty)) {
                return PathMeaning::Operand(LiteralOperand::Value(self.constant(cell, scalar, name.at), ty));
            }
            if self.scalar(ty).is_some() {
                return PathMeaning::Wrong;
            }
        }
        let meaning = self.home_meaning(&symbol, name.at);
        let written = self.text(symbol.name.at);
        match (meaning, found) {
            (PathMeaning::Place(place, ty, None), FoundName::Global(_))
                if self.options.read_only.iter().any(|known| known.eq_ignore_ascii_case(written)) =>
            {
                PathMeaning::Place(place, ty, Some("it is a system variable that programs only read"))
            }
            (meaning, _) => meaning,
        }
    }

    /// The place of a variable of the running unit or of the outside.
    fn home_meaning(&mut self, symbol: &ScopeSymbol<'a>, at: SourcePlace) -> PathMeaning {
        let ty = symbol.type_id();
        let kept = symbol.retention != Retention::None;
        let fixed = symbol.constant.then_some("it is a constant");
        let (root, offset) = match symbol.home {
            Home::Nowhere => {
                if self.context.constant && ty != WRONG {
                    self.not_constant(at, "a constant is needed here");
                }
                return PathMeaning::Wrong;
            }
            Home::Absolute(address) => (tree::TreeRoot::Absolute, address),
            Home::This(offset) => (tree::TreeRoot::This, offset),
            Home::Frame(offset) => (tree::TreeRoot::Frame, offset),
            Home::ThisAddress(offset) => (self.address_at(tree::TreeRoot::This, offset, at), 0),
            Home::FrameAddress(offset) => (self.address_at(tree::TreeRoot::Frame, offset, at), 0),
            Home::AbsoluteAddress(address) => (self.address_at(tree::TreeRoot::Absolute, address, at), 0),
            Home::Bit(address, bit) => {
                let place = self.place(tree::TreeRoot::Absolute, address, ty, kept, at);
                return PathMeaning::Bit(place, bit, read_only(address).or(fixed));
            }
        };
        let fixed = match root {
            tree::TreeRoot::Absolute => read_only(offset).or(fixed),
            _ => fixed,
        };
        let place = self.place(root, offset, ty, kept, at);
        self.followed(place, ty, fixed)
    }

    /// The address that stands at a place.
    fn address_at(&self, root: tree::TreeRoot, offset: u32, at: SourcePlace) -> tree::TreeRoot {
        let place = TreePlace { root, offset, indices: Vec::new(), ty: Ty::Address, retained: false, at };
        tree::TreeRoot::Address(Box::new(Expr { kind: ExprKind::Load(place), ty: Ty::Address, at }))
    }

    /// A reference stands for what it refers to.
    pub(super) fn followed(
        &mut self,
        place: TreePlace,
        ty: TypeId,
        fixed: Option<&'static str>,
    ) -> PathMeaning {
        let Type::Reference(to) = *self.ty(ty) else { return PathMeaning::Place(place, ty, fixed) };
        let at = place.at;
        let address = Expr { kind: ExprKind::Load(place), ty: Ty::Address, at };
        let place = self.place(tree::TreeRoot::Address(Box::new(address)), 0, to, false, at);
        PathMeaning::Place(place, to, None)
    }

    /// The place of a reference itself, for `REF=`.
    pub(super) fn reference_place(&mut self, written: &ast::Expr) -> Option<(TreePlace, TypeId)> {
        let PathMeaning::Place(place, _, _) = self.meaning(written) else { return None };
        let tree::TreeRoot::Address(address) = place.root else { return None };
        let ExprKind::Load(slot) = address.kind else { return None };
        let to = self.reference_type(written)?;
        Some((slot, to))
    }

    /// The declared type of a variable that is a reference.
    fn reference_type(&mut self, written: &ast::Expr) -> Option<TypeId> {
        let ty = match &written.kind {
            ast::ExprKind::Name(name) | ast::ExprKind::Global(name) => match self.find(name.key)? {
                FoundName::Local(place) => self.running()?.symbols.get(place as usize)?.type_id(),
                FoundName::Member(owner, place) => self.member_symbol(owner, place)?.type_id(),
                FoundName::Global(place) => self.global_type(place),
                FoundName::Result => self.running()?.result?,
                _ => return None,
            },
            ast::ExprKind::Member(of, name) if self.listed(of, *name).is_some() => {
                let place = self.listed(of, *name)?;
                self.global_type(place)
            }
            ast::ExprKind::Member(of, name) => {
                let PathMeaning::Place(_, ty, _) = self.meaning(of) else { return None };
                match *self.ty(ty) {
                    Type::Structure(place) => {
                        let structure = self.structures.get(place as usize)?;
                        structure.fields.iter().find(|field| field.key == name.key)?.ty
                    }
                    Type::Block(place) => {
                        let (owner, nth) = self.member(place, name.key)?;
                        self.member_symbol(owner, nth)?.type_id()
                    }
                    _ => return None,
                }
            }
            _ => return None,
        };
        matches!(self.ty(ty), Type::Reference(_)).then_some(ty)
    }

    /// A value in a variable without a name, so that it has a place.
    pub(super) fn held_value(&mut self, value: Expr, at: SourcePlace) -> TreePlace {
        let ty = value.ty;
        let offset = self.hidden(ty);
        let place =
            TreePlace { root: tree::TreeRoot::Frame, offset, indices: Vec::new(), ty, retained: false, at };
        let store = tree::Stmt { kind: tree::StmtKind::Assign(Target::Place(place.clone()), value), at };
        let address = Expr { kind: ExprKind::AddressOf(place), ty: Ty::Address, at };
        let address = Expr { kind: ExprKind::Sequence(vec![store], Box::new(address)), ty: Ty::Address, at };
        TreePlace {
            root: tree::TreeRoot::Address(Box::new(address)),
            offset: 0,
            indices: Vec::new(),
            ty,
            retained: false,
            at,
        }
    }

    /// A part of a place.
    pub(super) fn inside(&self, place: TreePlace, offset: u32, ty: TypeId, at: SourcePlace) -> TreePlace {
        TreePlace {
            offset: place.offset.wrapping_add(offset),
            ty: self.tree_type(ty),
            at: place.at.to(at),
            ..place
        }
    }

    fn deref_meaning(&mut self, of: &ast::Expr, at: SourcePlace) -> PathMeaning {
        match &of.kind {
            ast::ExprKind::This => {
                let Some(block) = self.this_block(of.at) else { return PathMeaning::Wrong };
                let ty = self.intern(Type::Block(block));
                return PathMeaning::Place(
                    self.place(tree::TreeRoot::This, 0, ty, false, at),
                    ty,
                    Some("it is the instance"),
                );
            }
            ast::ExprKind::Super => {
                let Some(block) = self.this_block(of.at) else { return PathMeaning::Wrong };
                match self.pous[block as usize].base {
                    Some(base) => return PathMeaning::Super(base),
                    None => {
                        let message = "this block extends no other";
                        self.findings.error(Code::NotAValue, of.at, message, "SUPER needs EXTENDS");
                        return PathMeaning::Wrong;
                    }
                }
            }
            _ => {}
        }
        let operand = self.expr(of, None);
        let Some((pointer, ty)) = self.own_value(operand, of.at) else { return PathMeaning::Wrong };
        match *self.ty(ty) {
            Type::Pointer(to) | Type::RefTo(to) => {
                let place = self.place(tree::TreeRoot::Address(Box::new(pointer)), 0, to, false, at);
                self.followed(place, to, None)
            }
            Type::Wrong => PathMeaning::Wrong,
            _ => {
                let message = format!("{} is no pointer", self.type_name(ty));
                self.findings.error(Code::NotAValue, at, message, "remove the ^");
                PathMeaning::Wrong
            }
        }
    }

    /// The block whose code this is.
    pub(super) fn this_block(&mut self, at: SourcePlace) -> Option<u32> {
        let block = self.context.pou.filter(|pou| {
            self.pous.get(*pou as usize).is_some_and(|p| p.ast.kind == ast::PouKind::FunctionBlock)
        });
        if block.is_none() || self.context.constant {
            let message = "THIS and SUPER belong into function blocks and their methods";
            self.findings.error(Code::NotAValue, at, message, "");
            return None;
        }
        block
    }

    /// Keeps where the user's sources name a place of %I or %Q first.
    pub(super) fn note_image(&mut self, address: Address, bits: u32, at: SourcePlace) {
        if matches!(address.area(), Area::Input | Area::Output) && usize::from(at.file) < self.own {
            let first = self.image_places.entry((address, bits)).or_insert(at);
            if (at.file, at.start) < (first.file, first.start) {
                *first = at;
            }
        }
    }

    fn direct(&mut self, text: &str, at: SourcePlace) -> PathMeaning {
        let Some(address) = self.address(text, at) else { return PathMeaning::Wrong };
        self.note_image(address, address.size().bits(), at);
        let scalar = Elementary::of_size(address.size());
        let ty = self.elementary(scalar);
        let fixed = (address.area() == Area::Input).then_some("inputs are read only");
        match home_of(address) {
            Home::Bit(byte, bit) => {
                let place = self.place(tree::TreeRoot::Absolute, byte, ty, false, at);
                PathMeaning::Bit(place, bit, fixed)
            }
            Home::Absolute(byte) => {
                PathMeaning::Place(self.place(tree::TreeRoot::Absolute, byte, ty, false, at), ty, fixed)
            }
            _ => PathMeaning::Wrong,
        }
    }

    /// What is assigned to, with its type; reports what cannot be.
    pub(super) fn target(&mut self, written: &ast::Expr) -> Option<(Target, TypeId)> {
        let (target, ty, fixed) = match self.meaning(written) {
            PathMeaning::Place(place, ty, fixed) => (Target::Place(place), ty, fixed),
            PathMeaning::Bit(place, bit, fixed) => {
                (Target::Bit(place, bit), self.elementary(Elementary::Bool), fixed)
            }
            PathMeaning::Wrong => return None,
            PathMeaning::Operand(LiteralOperand::Wrong) => return None,
            meaning => {
                let (message, help) = match meaning {
                    PathMeaning::Operand(_) if matches!(written.kind, ast::ExprKind::Name(_)) => {
                        (format!("`{}` is a constant", self.text(written.at)), "assign to a variable")
                    }
                    PathMeaning::Operand(_) => {
                        ("a value cannot be assigned to".into(), "assign to a variable")
                    }
                    _ => (format!("`{}` is no variable", self.text(written.at)), "assign to a variable"),
                };
                self.findings.error(Code::ReadOnly, written.at, message, help);
                return None;
            }
        };
        if ty == WRONG {
            return None;
        }
        if let Some(why) = fixed {
            let message = format!("this cannot be assigned to: {why}");
            self.findings.error(Code::ReadOnly, written.at, message, "");
            return None;
        }
        Some((target, ty))
    }

    /// The address of a place.
    pub(super) fn address_of(&mut self, place: TreePlace) -> Expr {
        let at = place.at;
        if let (tree::TreeRoot::Absolute, true) = (&place.root, place.indices.is_empty()) {
            return Expr { kind: ExprKind::Constant(i64::from(place.offset)), ty: Ty::Address, at };
        }
        if let (tree::TreeRoot::Address(address), true, 0) =
            (&place.root, place.indices.is_empty(), place.offset)
        {
            return (**address).clone();
        }
        Expr { kind: ExprKind::AddressOf(place), ty: Ty::Address, at }
    }
}

fn read_only(address: u32) -> Option<&'static str> {
    use crate::code::map;
    (map::INPUTS..map::OUTPUTS).contains(&address).then_some("inputs are read only")
}
