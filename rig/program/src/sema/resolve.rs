//! Types as they are written: names, arrays, texts, structures.

use super::types::{Enumeration, Structure, Type, TypeField, TypeId, WRONG, elements, stride};
use super::{Global, Sema, State, TYPE_DEPTH};
use crate::codes::Code;
use crate::findings::{SourcePlace, similar};
use crate::parse::ast::{self, Expr, Key, Name, TypeKind, TypeRef, VarDecl};
use crate::types::Elementary;

/// Length of a STRING that does not say one.
const DEFAULT_LENGTH: u32 = 80;

impl<'a> Sema<'a> {
    /// The type that is written there.
    pub(super) fn resolve(&mut self, written: &'a TypeRef) -> TypeId {
        if self.depth >= TYPE_DEPTH {
            let message = "types contain each other too deeply";
            self.findings.error(Code::Depth, written.at, message, "use fewer levels");
            return WRONG;
        }
        self.depth += 1;
        let ty = self.resolve_kind(written);
        self.depth -= 1;
        ty
    }

    fn resolve_kind(&mut self, written: &'a TypeRef) -> TypeId {
        // Only the outermost type may be an array of variable length.
        let in_out = std::mem::take(&mut self.in_out);
        match &written.kind {
            TypeKind::Named(name) => self.named(*name),
            TypeKind::Text { wide, length } => {
                let length = match length {
                    None => DEFAULT_LENGTH,
                    Some(length) => match self.constant_number(length) {
                        Some(n) if (1..=i64::from(self.options.limits.text)).contains(&n) => n as u32,
                        Some(n) => {
                            let message = format!("a text cannot have {n} characters");
                            let help = format!("declare from 1 to {}", self.options.limits.text);
                            self.findings.error(Code::ArrayBounds, length.at, message, help);
                            return WRONG;
                        }
                        None => return WRONG,
                    },
                };
                self.intern(Type::Text { wide: *wide, length })
            }
            TypeKind::Subrange { base, low, high } => self.subrange(*base, low, high),
            TypeKind::Array { ranges, of } => self.array(ranges, of, in_out, written.at),
            TypeKind::Pointer(to) => self.pointing(to, Type::Pointer),
            TypeKind::RefTo(to) => self.pointing(to, Type::RefTo),
            TypeKind::Reference(to) => self.pointing(to, Type::Reference),
            TypeKind::Enumeration { values, base } => {
                let place = (written.at.file, written.at.start);
                if let Some(known) = self.inline_types.get(&place) {
                    return *known;
                }
                let ty = self.enumeration("(..)".into(), values, *base);
                self.inline_types.insert(place, ty);
                ty
            }
            TypeKind::Struct { .. } | TypeKind::Union { .. } => {
                let place = (written.at.file, written.at.start);
                if let Some(known) = self.inline_types.get(&place) {
                    return *known;
                }
                let ty = self.new_structure("STRUCT".into());
                self.inline_types.insert(place, ty);
                self.fill_structure(ty, written);
                ty
            }
        }
    }

    fn pointing(&mut self, to: &'a TypeRef, make: fn(TypeId) -> Type) -> TypeId {
        // What a pointer leads to need not be laid out yet.
        let to = match &to.kind {
            TypeKind::Named(name) => self.named_loosely(*name),
            _ => self.resolve(to),
        };
        if to == WRONG {
            return WRONG;
        }
        self.intern(make(to))
    }

    /// A type by name, laid out.
    fn named(&mut self, name: Name) -> TypeId {
        let ty = self.named_loosely(name);
        match self.ty(ty).clone() {
            Type::Block(place) if !self.resolve_block(place) => {
                let message = format!("`{}` contains itself", self.shown(name));
                self.findings.error(Code::ContainsItself, name.at, message, "use a REFERENCE TO it");
                return WRONG;
            }
            Type::Structure(_) if self.is_open(ty) => {
                let message = format!("`{}` contains itself", self.shown(name));
                self.findings.error(Code::ContainsItself, name.at, message, "use a POINTER TO it");
                return WRONG;
            }
            _ => {}
        }
        ty
    }

    /// Whether a structure is still being laid out.
    fn is_open(&self, ty: TypeId) -> bool {
        matches!(self.ty(ty), Type::Structure(place)
            if self.structures.get(*place as usize).is_some_and(|s| s.align == 0))
    }

    fn named_loosely(&mut self, name: Name) -> TypeId {
        let text = self.names.key_text(name.key);
        if let Some(ty) = Elementary::named(text) {
            if ty == Elementary::Lreal && self.lreal.is_none() {
                self.lreal = Some(name.at);
            }
            return self.elementary(ty);
        }
        match self.outside.get(&name.key).copied() {
            Some(Global::Type(place)) => return self.named_type(place),
            Some(Global::Interface(place)) => return self.intern(Type::Interface(place)),
            Some(Global::Pou(place))
                if self
                    .pous
                    .get(place as usize)
                    .is_some_and(|p| p.ast.kind == ast::PouKind::FunctionBlock) =>
            {
                return self.intern(Type::Block(place));
            }
            _ => {}
        }
        if let Some(native) = self.native_index.get(&name.key) {
            let native = *native;
            return self.intern(Type::Native(native));
        }
        if self.any_named(name).is_some() {
            return self.any_type(name);
        }
        self.unknown_type(name);
        WRONG
    }

    fn unknown_type(&mut self, name: Name) {
        let key = self.names.key_text(name.key);
        let known: Vec<&str> = Elementary::ALL
            .iter()
            .map(|ty| ty.name())
            .chain(["STRING", "WSTRING", "TOD", "DT"])
            .chain(self.options.blocks.iter().map(|native| native.name))
            .chain(self.type_decls.iter().map(|entry| self.names.key_text(entry.decl.name.key)))
            .chain(self.pous.iter().map(|pou| self.names.key_text(pou.ast.name.key)))
            .collect();
        let help = match similar(key, known.into_iter()) {
            Some(near) => format!("did you mean {near}?"),
            None => "declare it with TYPE or FUNCTION_BLOCK".into(),
        };
        let message = format!("the type `{}` is not known", self.shown(name));
        self.findings.error(Code::UnknownType, name.at, message, help);
    }

    /// A TYPE of the sources.
    pub(super) fn named_type(&mut self, place: u32) -> TypeId {
        let Some(entry) = self.type_decls.get(place as usize) else { return WRONG };
        let decl = entry.decl;
        match entry.state {
            State::Done(ty) => return ty,
            State::Busy => {
                let message = format!("`{}` is defined by itself", self.shown(decl.name));
                self.findings.error(Code::ContainsItself, decl.name.at, message, "");
                return WRONG;
            }
            State::Untouched => {}
        }
        self.type_decls[place as usize].state = State::Busy;
        let outer = std::mem::take(&mut self.context);
        let ty = match &decl.ty.kind {
            TypeKind::Struct { .. } | TypeKind::Union { .. } => {
                let name = self.shown(decl.name).to_string();
                let ty = self.new_structure(name);
                // Pointers to it may stand inside it.
                self.type_decls[place as usize].state = State::Done(ty);
                self.fill_structure(ty, &decl.ty);
                if let Some(initial) = &decl.initial {
                    self.structure_default(ty, initial);
                }
                ty
            }
            TypeKind::Enumeration { values, base } => {
                let name = self.shown(decl.name).to_string();
                let ty = self.enumeration(name, values, *base);
                self.type_decls[place as usize].state = State::Done(ty);
                if let (Some(initial), Type::Enumeration(at)) = (&decl.initial, self.ty(ty).clone())
                    && let Some(cell) = self.constant_initial(initial, ty)
                    && let Some(enumeration) = self.enumerations.get_mut(at as usize)
                {
                    enumeration.default = cell;
                }
                ty
            }
            _ => self.resolve(&decl.ty),
        };
        self.context = outer;
        self.type_decls[place as usize].state = State::Done(ty);
        ty
    }

    /// The initial value that a type's name brings along, for types that do not carry it themselves.
    pub(super) fn type_initial(&self, written: &TypeRef) -> Option<&'a ast::Initializer> {
        let TypeKind::Named(name) = &written.kind else { return None };
        let Some(Global::Type(place)) = self.outside.get(&name.key) else { return None };
        let decl = self.type_decls.get(*place as usize)?.decl;
        match decl.ty.kind {
            TypeKind::Struct { .. } | TypeKind::Union { .. } | TypeKind::Enumeration { .. } => None,
            _ => decl.initial.as_ref().or_else(|| self.type_initial(&decl.ty)),
        }
    }

    fn subrange(&mut self, base: Name, low: &'a Expr, high: &'a Expr) -> TypeId {
        let ty = self.named(base);
        let Some(elementary) = self.scalar(ty).filter(|ty| ty.is_integer()) else {
            if ty != WRONG {
                let message = format!("{} has no subranges", self.type_name(ty));
                self.findings.error(Code::Type, base.at, message, "whole numbers have");
            }
            return WRONG;
        };
        let (Some(lowest), Some(highest)) = (self.constant_number(low), self.constant_number(high)) else {
            return WRONG;
        };
        let (least, most) = elementary.range();
        let fits = |n: i64| (least..=most).contains(&i128::from(n));
        if lowest > highest || !fits(lowest) || !fits(highest) {
            let message = format!("{lowest}..{highest} is no range of {}", elementary.name());
            self.findings.error(Code::Range, low.at.to(high.at), message, "write the lower end first");
            return WRONG;
        }
        self.intern(Type::Subrange { base: elementary, low: lowest, high: highest })
    }

    fn array(
        &mut self,
        ranges: &'a [Option<(Expr, Expr)>],
        of: &'a TypeRef,
        in_out: bool,
        at: SourcePlace,
    ) -> TypeId {
        let element = self.resolve(of);
        if let Some(initial) = self.type_initial(of) {
            let message = "elements of an array do not take the initial value of their type's name";
            let help = "give the array an initial value, or make the type a STRUCT";
            self.findings.error(Code::Unsupported, of.at, message, help);
            let _ = initial;
        }
        if in_out && ranges.iter().all(Option::is_none) {
            let dimensions = ranges.len() as u32;
            return if element == WRONG {
                WRONG
            } else {
                self.intern(Type::Open { dimensions, of: element })
            };
        }
        let mut dimensions = Vec::new();
        for range in ranges {
            let Some((low, high)) = range else {
                let message = "only the type of an in-out may leave its bounds open";
                self.findings.error(Code::ArrayBounds, at, message, "write the bounds, all of them");
                return WRONG;
            };
            let (Some(lowest), Some(highest)) = (self.constant_number(low), self.constant_number(high))
            else {
                return WRONG;
            };
            if lowest > highest {
                let message = format!("the range {lowest}..{highest} is empty");
                self.findings.error(
                    Code::ArrayBounds,
                    low.at.to(high.at),
                    message,
                    "write the lower end first",
                );
                return WRONG;
            }
            dimensions.push((lowest, highest));
        }
        if element == WRONG {
            return WRONG;
        }
        if matches!(self.ty(element), Type::Reference(_)) {
            let message = "there are no arrays of references";
            self.findings.error(Code::Type, of.at, message, "use POINTER TO");
            return WRONG;
        }
        let bytes = elements(&dimensions).saturating_mul(u64::from(stride(self.layout(element))));
        if bytes > u64::from(self.options.limits.memory) {
            let message = format!("the array needs {bytes} bytes");
            let help = format!("there are {} for all variables", self.options.limits.memory);
            self.findings.error(Code::DataSize, at, message, help);
            return WRONG;
        }
        self.intern(Type::Array { dimensions, of: element })
    }

    fn enumeration(
        &mut self,
        name: String,
        values: &'a [(Name, Option<Expr>)],
        base: Option<Name>,
    ) -> TypeId {
        let elementary = match base {
            None => Elementary::Int,
            Some(base) => {
                let ty = self.named(base);
                match self.scalar(ty).filter(|ty| ty.is_integer()) {
                    Some(ty) => ty,
                    None => {
                        let message = "the values of an enumeration are whole numbers";
                        self.findings.error(Code::Type, base.at, message, "");
                        return WRONG;
                    }
                }
            }
        };
        let place = self.enumerations.len() as u32;
        let ty = self.intern(Type::Enumeration(place));
        self.enumerations.push(Enumeration { name, base: elementary, values: Vec::new(), default: 0 });
        let (least, most) = elementary.range();
        let mut next = 0i128;
        for (nth, (value, written)) in values.iter().enumerate() {
            if let Some(written) = written {
                match self.constant_number(written) {
                    Some(n) => next = i128::from(n),
                    None => continue,
                }
            }
            if next < least || next > most {
                let message = format!("{next} is no value of {}", elementary.name());
                self.findings.error(Code::Range, value.at, message, "choose a wider base type");
                continue;
            }
            let shown = self.shown(*value).to_string();
            let entry = &mut self.enumerations[place as usize];
            if entry.values.iter().any(|(key, ..)| *key == value.key) {
                let message = format!("`{shown}` is declared twice");
                self.findings.error(Code::Duplicate, value.at, message, "");
                continue;
            }
            if nth == 0 {
                entry.default = next as i64;
            }
            entry.values.push((value.key, shown, next as i64));
            // Those of a library are named with their type: they must not come between those of the user.
            if usize::from(value.at.file) < self.own {
                self.enumerators.entry(value.key).or_default().push((ty, next as i64));
            }
            next += 1;
        }
        ty
    }

    fn new_structure(&mut self, name: String) -> TypeId {
        let place = self.structures.len() as u32;
        self.structures.push(Structure { name, ..Structure::default() });
        self.intern(Type::Structure(place))
    }

    fn fill_structure(&mut self, ty: TypeId, written: &'a TypeRef) {
        let Type::Structure(place) = *self.ty(ty) else { return };
        let (extends, members, union): (Option<Name>, &'a [VarDecl], bool) = match &written.kind {
            TypeKind::Struct { extends, members } => (*extends, members, false),
            TypeKind::Union { members } => (None, members, true),
            _ => return,
        };
        let mut built = Structure {
            name: self.structures.get(place as usize).map_or(String::new(), |s| s.name.clone()),
            align: 1,
            ..Structure::default()
        };
        if let Some(base) = extends {
            let base_type = self.named(base);
            match self.ty(base_type) {
                Type::Structure(of) => {
                    if let Some(base) = self.structures.get(*of as usize) {
                        built = Structure { name: built.name, ..base.clone() };
                    }
                }
                Type::Wrong => {}
                _ => {
                    let message = format!("`{}` is no STRUCT", self.shown(base));
                    self.findings.error(Code::Type, base.at, message, "");
                }
            }
        }
        let mut initials: Vec<(u32, TypeId, &'a ast::Initializer)> = Vec::new();
        for member in members {
            let key: Key = member.name.key;
            if built.fields.iter().any(|field| field.key == key) {
                let message = format!("`{}` is declared twice", self.shown(member.name));
                self.findings.error(Code::Duplicate, member.name.at, message, "");
                continue;
            }
            if let Some((_, at)) = &member.address {
                let message = "a member of a structure cannot be located";
                self.findings.error(Code::Located, *at, message, "locate the variable");
            }
            let ty = self.resolve(&member.ty);
            if !self.check_depth(ty, member.ty.at) {
                break;
            }
            built.depth = built.depth.max(1 + self.type_depth(ty));
            if self.contains_block(ty) && union {
                let message = "a UNION cannot hold a function block";
                self.findings.error(Code::Type, member.ty.at, message, "use a STRUCT");
                continue;
            }
            let layout = self.layout(ty);
            let offset = if union { 0 } else { built.size.next_multiple_of(layout.align) };
            let end = u64::from(offset) + u64::from(layout.size);
            if end > u64::from(self.options.limits.memory) {
                let message = format!("the structure needs {end} bytes");
                self.findings.error(Code::DataSize, member.name.at, message, "use smaller arrays");
                break;
            }
            built.size = built.size.max(end as u32);
            built.align = built.align.max(layout.align);
            let mut bytes = Vec::new();
            if self.has_image_room(layout.size, member.name.at) {
                self.default_bytes(ty, &mut bytes);
                if built.image.len() < end as usize {
                    built.image.resize(end as usize, 0);
                }
            }
            if !union
                && !bytes.is_empty()
                && let Some(room) = built.image.get_mut(offset as usize..end as usize)
            {
                room.copy_from_slice(&bytes);
            }
            let name = self.shown(member.name).to_string();
            built.fields.push(TypeField { key, name, ty, offset });
            let inherited = self.type_initial(&member.ty);
            if let Some(initial) = member.initial.as_ref().or(inherited) {
                initials.push((offset, ty, initial));
            }
        }
        built.align = built.align.max(1);
        built.size = built.size.max(1).next_multiple_of(built.align);
        if self.has_image_room(0, SourcePlace::default()) {
            built.image.resize(built.size as usize, 0);
        }
        let mut image = std::mem::take(&mut built.image);
        if let Some(structure) = self.structures.get_mut(place as usize) {
            *structure = built;
        }
        for (offset, ty, initial) in initials {
            self.write_initial(ty, initial, &mut image, offset);
        }
        if let Some(structure) = self.structures.get_mut(place as usize) {
            structure.image = image;
        }
    }

    fn structure_default(&mut self, ty: TypeId, initial: &'a ast::Initializer) {
        let Type::Structure(place) = *self.ty(ty) else { return };
        let mut image = self.structures.get(place as usize).map_or(Vec::new(), |s| s.image.clone());
        self.write_initial(ty, initial, &mut image, 0);
        if let Some(structure) = self.structures.get_mut(place as usize) {
            structure.image = image;
        }
    }

    /// Whether a variable of this type is or holds an instance of a block.
    pub(super) fn contains_block(&self, ty: TypeId) -> bool {
        match self.ty(ty) {
            Type::Block(_) | Type::Native(_) => true,
            Type::Array { of, .. } => self.contains_block(*of),
            Type::Structure(place) => self
                .structures
                .get(*place as usize)
                .is_some_and(|s| s.fields.iter().any(|field| self.contains_block(field.ty))),
            _ => false,
        }
    }
}
