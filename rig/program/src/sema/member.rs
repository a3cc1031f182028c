//! Members of structures, blocks, interfaces and programs.

use super::Sema;
use super::literal::LiteralOperand;
use super::place::{ObjectAccess, PathMeaning};
use super::scope::{FoundName, Home, SelectorKind};
use super::types::{Type, TypeId};
use crate::codes::Code;
use crate::findings::similar;
use crate::native::PinKind;
use crate::parse::ast::{Name, SectionKind};
use crate::program::Retention;
use crate::tree::{self, Expr, ExprKind, TreePlace, Ty};
use crate::types::Elementary;

impl Sema<'_> {
    /// A member of what a path means.
    pub(super) fn member_meaning(&mut self, of: PathMeaning, name: Name) -> PathMeaning {
        match of {
            PathMeaning::Wrong => PathMeaning::Wrong,
            PathMeaning::Place(place, ty, fixed) => self.place_member(place, ty, fixed, name),
            PathMeaning::Type(ty) => self.enumerator_of(ty, name),
            PathMeaning::Program(pou) => self.program_member(pou, name),
            PathMeaning::Super(base) => self.super_member(base, name),
            // What a reference that was given refers to is no copy.
            PathMeaning::Operand(LiteralOperand::Value(Expr { kind: ExprKind::Load(place), .. }, ty))
                if matches!(place.root, tree::TreeRoot::Address(_)) =>
            {
                self.place_member(place, ty, None, name)
            }
            PathMeaning::Operand(operand) => {
                let Some((value, ty)) = self.own_value(operand, name.at) else { return PathMeaning::Wrong };
                let place = self.held_value(value, name.at);
                self.place_member(place, ty, Some("it is a value"), name)
            }
            PathMeaning::Property(instance, property) => {
                let value = self.get_property(&instance, property);
                self.member_meaning(PathMeaning::Operand(value), name)
            }
            PathMeaning::Bit(..)
            | PathMeaning::Function(_)
            | PathMeaning::Method(..)
            | PathMeaning::Action(..) => {
                let message = format!("there is no member `{}` here", self.shown(name));
                self.findings.error(Code::NotAValue, name.at, message, "");
                PathMeaning::Wrong
            }
        }
    }

    fn place_member(
        &mut self,
        place: TreePlace,
        ty: TypeId,
        fixed: Option<&'static str>,
        name: Name,
    ) -> PathMeaning {
        match *self.ty(ty) {
            Type::Structure(of) => {
                let field = self
                    .structures
                    .get(of as usize)
                    .and_then(|s| s.fields.iter().find(|field| field.key == name.key))
                    .map(|field| (field.offset, field.ty));
                let Some((offset, field)) = field else {
                    let keys: Vec<&str> = self.structures.get(of as usize).map_or(Vec::new(), |s| {
                        s.fields.iter().map(|field| self.names.key_text(field.key)).collect()
                    });
                    let near = similar(self.names.key_text(name.key), keys.into_iter());
                    self.unknown_member(name, near, &self.type_name(ty));
                    return PathMeaning::Wrong;
                };
                let inner = self.inside(place, offset, field, name.at);
                self.followed(inner, field, fixed)
            }
            Type::Block(of) => self.block_member(place, of, name),
            Type::Native(of) => self.native_member(place, of, name),
            Type::Interface(_) => {
                let address = Expr { kind: ExprKind::Load(place), ty: Ty::Address, at: name.at };
                let Type::Interface(interface) = *self.ty(ty) else { return PathMeaning::Wrong };
                self.interface_member(address, interface, name)
            }
            Type::Pointer(to) | Type::RefTo(to) => {
                let message = format!("this is a pointer, which has no `{}`", self.shown(name));
                let _ = to;
                self.findings.error(Code::NotAValue, name.at, message, "write ^ after it, as in p^.a");
                PathMeaning::Wrong
            }
            Type::Wrong => PathMeaning::Wrong,
            _ => {
                if self.scalar(ty).is_some_and(Elementary::is_integer)
                    && let Some(number) = self.named_bit(name)
                {
                    return self.part_of(place, ty, fixed, (1, number), name.at);
                }
                let message =
                    format!("there is no member `{}`: this is {}", self.shown(name), self.type_name(ty));
                self.findings.error(Code::NotAValue, name.at, message, "structures and blocks have members");
                PathMeaning::Wrong
            }
        }
    }

    /// How the object at a place is reached.
    pub(super) fn instance_at(&mut self, place: TreePlace, block: u32) -> ObjectAccess {
        match place.root {
            tree::TreeRoot::Address(_) => {
                let address = self.address_of(place);
                ObjectAccess::Block(address, block)
            }
            tree::TreeRoot::This if place.offset == 0 && place.indices.is_empty() => ObjectAccess::Same,
            _ => ObjectAccess::Exact(place, block),
        }
    }

    fn block_member(&mut self, place: TreePlace, of: u32, name: Name) -> PathMeaning {
        if let Some((owner, nth)) = self.member(of, name.key) {
            let Some(symbol) = self.member_symbol(owner, nth).cloned() else { return PathMeaning::Wrong };
            let inside = self.context.pou.is_some_and(|pou| self.extends(pou, owner));
            let ty = symbol.type_id();
            if symbol.is_value()
                && let Some(cell) = self.symbol_value(FoundName::Member(owner, nth))
                && let Some(scalar) = self.scalar(ty)
            {
                return PathMeaning::Operand(LiteralOperand::Value(self.constant(cell, scalar, name.at), ty));
            }
            let fixed = match symbol.kind {
                _ if symbol.is_value() => Some("it is a constant"),
                _ if inside => None,
                SectionKind::Output => Some("it is an output of the block"),
                SectionKind::Input | SectionKind::InOut => None,
                _ => Some("it belongs to the block alone"),
            };
            let kept = place.retained || symbol.retention != Retention::None;
            let (home, offset) = match symbol.home {
                Home::This(offset) => (None, offset),
                Home::ThisAddress(offset) => (Some(offset), 0),
                Home::Absolute(address) => {
                    let place = self.place(tree::TreeRoot::Absolute, address, ty, kept, name.at);
                    return self.followed(place, ty, fixed);
                }
                _ => return PathMeaning::Wrong,
            };
            if let Some(offset) = home {
                // An in-out: what it was given last.
                let slot = TreePlace { ty: Ty::Address, ..self.inside(place, offset, ty, name.at) };
                let address = Expr { kind: ExprKind::Load(slot), ty: Ty::Address, at: name.at };
                let place = self.place(tree::TreeRoot::Address(Box::new(address)), 0, ty, false, name.at);
                return PathMeaning::Place(place, ty, fixed);
            }
            let inner = TreePlace { retained: kept, ..self.inside(place, offset, ty, name.at) };
            return self.followed(inner, ty, fixed);
        }
        if let Some(method) = self.method(of, name.key) {
            self.check_access(method, name.at);
            let instance = self.instance_at(place, of);
            return PathMeaning::Method(instance, name);
        }
        let getter = self.accessor(of, name.key, SelectorKind::Get);
        if let Some(accessor) = getter.or_else(|| self.accessor(of, name.key, SelectorKind::Set)) {
            self.check_access(accessor, name.at);
            let instance = self.instance_at(place, of);
            return PathMeaning::Property(instance, name);
        }
        if let Some(action) = self.action(of, name.key) {
            let same =
                matches!(place.root, tree::TreeRoot::This) && place.offset == 0 && place.indices.is_empty();
            return PathMeaning::Action(action, if same { None } else { Some(place) });
        }
        let mut keys: Vec<&str> = Vec::new();
        for owner in self.lineage(of) {
            let pou = &self.pous[owner as usize];
            keys.extend(pou.symbols.iter().map(|symbol| self.names.key_text(symbol.name.key)));
            keys.extend(pou.ast.methods.iter().map(|method| self.names.key_text(method.name.key)));
        }
        let near = similar(self.names.key_text(name.key), keys.into_iter());
        let shown = self.pous[of as usize].shown.clone();
        self.unknown_member(name, near, &shown);
        PathMeaning::Wrong
    }

    fn native_member(&mut self, place: TreePlace, of: u16, name: Name) -> PathMeaning {
        let Some(native) = self.options.blocks.get(usize::from(of)) else { return PathMeaning::Wrong };
        let key = self.names.key_text(name.key);
        let found =
            native.pin(key).filter(|nth| native.pins.get(*nth).is_some_and(|p| p.kind != PinKind::Hidden));
        match found.and_then(|nth| {
            Some((native.pins.get(nth)?, self.native_layouts.get(usize::from(of))?.0.get(nth)?))
        }) {
            Some((pin, offset)) => {
                let fixed = (pin.kind == PinKind::Output).then_some("it is an output of the block");
                let offset = u32::from(*offset);
                let ty = self.elementary(pin.ty);
                PathMeaning::Place(self.inside(place, offset, ty, name.at), ty, fixed)
            }
            None => {
                let pins = native.pins.iter().filter(|pin| pin.kind != PinKind::Hidden);
                let names: Vec<&str> = pins.map(|pin| pin.name).collect();
                let help = format!("{} has {}", native.name, names.join(", "));
                let message = format!("`{}` has no `{}`", native.name, self.shown(name));
                self.findings.error(Code::UnknownName, name.at, message, help);
                PathMeaning::Wrong
            }
        }
    }

    pub(super) fn interface_member(&mut self, address: Expr, interface: u32, name: Name) -> PathMeaning {
        let heads = self.interfaces.get(interface as usize).map_or(&[][..], |i| i.heads.as_slice());
        let found =
            heads.iter().find(|(selector, _)| selector.key == name.key).map(|(selector, _)| selector.kind);
        let instance = ObjectAccess::Interface(address, interface);
        match found {
            Some(SelectorKind::Method) => PathMeaning::Method(instance, name),
            Some(_) => PathMeaning::Property(instance, name),
            None => {
                let keys: Vec<&str> =
                    heads.iter().map(|(selector, _)| self.names.key_text(selector.key)).collect();
                let near = similar(self.names.key_text(name.key), keys.into_iter());
                let shown =
                    self.interfaces.get(interface as usize).map_or(String::new(), |i| i.shown.clone());
                self.unknown_member(name, near, &shown);
                PathMeaning::Wrong
            }
        }
    }

    fn super_member(&mut self, base: u32, name: Name) -> PathMeaning {
        if self.method(base, name.key).is_some() {
            return PathMeaning::Method(ObjectAccess::Super(base), name);
        }
        if self.accessor(base, name.key, SelectorKind::Get).is_some()
            || self.accessor(base, name.key, SelectorKind::Set).is_some()
        {
            return PathMeaning::Property(ObjectAccess::Super(base), name);
        }
        if let Some((owner, nth)) = self.member(base, name.key) {
            return self.symbol_meaning(FoundName::Member(owner, nth), name);
        }
        if let Some(action) = self.action(base, name.key) {
            return PathMeaning::Action(action, None);
        }
        let shown = self.pous[base as usize].shown.clone();
        self.unknown_member(name, None, &shown);
        PathMeaning::Wrong
    }

    /// A variable or action of another program.
    fn program_member(&mut self, pou: u32, name: Name) -> PathMeaning {
        let Some(nth) = self.pous[pou as usize].index.get(&name.key).copied() else {
            if let Some(action) = self.action(pou, name.key) {
                return PathMeaning::Action(action, None);
            }
            let symbols = &self.pous[pou as usize].symbols;
            let keys = symbols.iter().map(|symbol| self.names.key_text(symbol.name.key));
            let near = similar(self.names.key_text(name.key), keys);
            let shown = self.pous[pou as usize].shown.clone();
            self.unknown_member(name, near, &shown);
            return PathMeaning::Wrong;
        };
        let input = self.member_symbol(pou, nth).is_some_and(|symbol| symbol.kind == SectionKind::Input);
        let own = self.context.pou == Some(pou);
        match self.symbol_meaning(FoundName::Member(pou, nth), name) {
            PathMeaning::Place(place, ty, fixed) if !input && !own => {
                PathMeaning::Place(place, ty, fixed.or(Some("only inputs of another program can be")))
            }
            PathMeaning::Bit(place, bit, fixed) if !own => {
                PathMeaning::Bit(place, bit, fixed.or(Some("only inputs of another program can be")))
            }
            meaning => meaning,
        }
    }
}
