//! Names of everything at the outside, and the units that the sources declare.

use super::scope::{Callable, CallableKind, Home, MethodSelector, Pou, ScopeSymbol, SelectorKind};
use super::{Global, Interface, KeyMap, Sema, State, TypeEntry, TypeId};
use crate::codes::Code;
use crate::findings::SourcePlace;
use crate::parse::ast::{self, Key, Name, PouKind, Section, SectionKind};
use crate::program::Retention;
use crate::types::Elementary;

impl<'a> Sema<'a> {
    /// Takes in every name at the outside.
    pub(super) fn collect(&mut self) {
        for (place, native) in self.options.blocks.iter().enumerate() {
            self.native_layouts.push(native.layout());
            if let Some(key) = self.names.get(native.name) {
                self.native_index.insert(key, place as u16);
            }
        }
        let unit = self.unit;
        for decl in &unit.types {
            if self.declare(decl.name, Global::Type(self.type_decls.len() as u32)) {
                self.type_decls.push(TypeEntry { decl, state: State::Untouched });
            }
        }
        for interface in &unit.interfaces {
            if self.declare(interface.name, Global::Interface(self.interfaces.len() as u32)) {
                let shown = self.shown(interface.name).to_string();
                self.interfaces.push(Interface {
                    ast: interface,
                    shown,
                    extends: Vec::new(),
                    heads: Vec::new(),
                    state: State::Untouched,
                });
            }
        }
        for (nth, configuration) in unit.configurations.iter().enumerate() {
            let same = |other: &&ast::Configuration| other.name.key == configuration.name.key;
            if let Some(first) = unit.configurations.iter().take(nth).find(same) {
                self.twice(configuration.name, first.name.at);
            }
        }
        let outer = unit.configurations.iter().flat_map(|configuration| &configuration.globals);
        let mut persistent: Option<SourcePlace> = None;
        for section in unit.globals.iter().chain(outer) {
            // controller:REM-04
            if section.retention == Retention::Persistent
                && let Some(first) = persistent.replace(section.at)
            {
                self.findings.error_with(
                    Code::Section,
                    section.at,
                    "a second list of persistent variables: an application has one, PersistentVars",
                    "move these variables into the other VAR_GLOBAL PERSISTENT",
                    (first, "the other one"),
                );
            }
            for decl in &section.variables {
                if self.declare(decl.name, Global::Variable(self.globals.len() as u32)) {
                    let symbol = self.symbol(section, decl);
                    self.globals.push(symbol);
                }
            }
        }
        for pou in &unit.pous {
            if self.declare(pou.name, Global::Pou(self.pous.len() as u32)) {
                self.collect_pou(pou);
            }
        }
    }

    /// Takes a name at the outside; FALSE where it is taken.
    fn declare(&mut self, name: Name, meaning: Global) -> bool {
        let key = self.names.key_text(name.key);
        if Elementary::named(key).is_some() || matches!(key, "STRING" | "WSTRING") {
            let message = format!("`{}` is a type of the language", self.shown(name));
            self.findings.error(Code::Reserved, name.at, message, "choose another name");
            return false;
        }
        if let Some(first) = self.outside.get(&name.key).copied() {
            // A declaration of the user's goes before that of a library.
            if usize::from(name.at.file) < self.own {
                let first = self.place_of(first);
                self.twice(name, first);
            }
            return false;
        }
        self.outside.insert(name.key, meaning);
        true
    }

    fn place_of(&self, global: Global) -> SourcePlace {
        match global {
            Global::Variable(place) => self.globals.get(place as usize).map(|symbol| symbol.name.at),
            Global::Pou(place) => self.pous.get(place as usize).map(|pou| pou.ast.name.at),
            Global::Type(place) => self.type_decls.get(place as usize).map(|entry| entry.decl.name.at),
            Global::Interface(place) => self.interfaces.get(place as usize).map(|i| i.ast.name.at),
        }
        .unwrap_or_default()
    }

    /// Reports a variable with the name of an elementary type. Those that the standard's third edition brought are names
    /// in older libraries.
    pub(super) fn check_name(&mut self, name: Name) {
        let key = self.names.key_text(name.key);
        let new =
            matches!(key, "LDATE" | "LTOD" | "LDT" | "LTIME_OF_DAY" | "LDATE_AND_TIME" | "CHAR" | "WCHAR");
        if Elementary::named(key).is_some() && !new {
            let message = format!("`{}` is a type of the language", self.shown(name));
            self.findings.error(Code::Reserved, name.at, message, "choose another name");
        }
    }

    pub(super) fn twice(&mut self, name: Name, first: SourcePlace) {
        let message = format!("`{}` is declared twice", self.shown(name));
        self.findings.error_with(
            Code::Duplicate,
            name.at,
            message,
            "capitals and small letters make no difference",
            (first, "first here"),
        );
    }

    pub(super) fn symbol(&self, section: &Section, decl: &'a ast::VarDecl) -> ScopeSymbol<'a> {
        ScopeSymbol {
            name: decl.name,
            shown: self.shown(decl.name),
            kind: section.kind,
            decl,
            retention: section.retention,
            constant: section.constant,
            ty: State::Untouched,
            home: Home::Nowhere,
            edge: None,
            value: State::Untouched,
        }
    }

    fn add_callable(&mut self, callable: Callable<'a>) -> u32 {
        self.callables.push(callable);
        (self.callables.len() - 1) as u32
    }

    fn collect_pou(&mut self, pou: &'a ast::Pou) {
        let place = self.pous.len() as u32;
        let shown = self.shown(pou.name).to_string();
        let kind = if pou.kind == PouKind::Function { CallableKind::Function } else { CallableKind::Body };
        let mut body = Callable::new(kind, shown.clone(), pou.name, pou.end);
        body.body = &pou.body;
        body.result_ref = pou.result.as_ref();
        body.sections = &pou.sections;
        body.modifiers = pou.modifiers;
        if kind == CallableKind::Body {
            body.owner = Some(place);
        }
        let callable = self.add_callable(body);
        let mut entry = Pou {
            ast: pou,
            shown,
            callable,
            base: None,
            interfaces: Vec::new(),
            symbols: Vec::new(),
            index: KeyMap::default(),
            methods: KeyMap::default(),
            getters: KeyMap::default(),
            setters: KeyMap::default(),
            actions: KeyMap::default(),
            class: 0,
            size: 0,
            image: Vec::new(),
            depth: 0,
            state: State::Untouched,
            late: Vec::new(),
            maker: None,
        };
        let mut names: KeyMap<Key, SourcePlace> = KeyMap::default();
        for action in &pou.actions {
            if self.own_name(&mut names, action.name) {
                let shown = format!("{}.{}", entry.shown, self.shown(action.name));
                let mut callable = Callable::new(CallableKind::Action, shown, action.name, action.end);
                callable.owner = Some(place);
                callable.body = &action.body;
                let callable = self.add_callable(callable);
                entry.actions.insert(action.name.key, callable);
            }
        }
        for method in &pou.methods {
            if self.own_name(&mut names, method.name) {
                let callable = self.method_callable(method, &entry.shown);
                let callable = Callable { owner: Some(place), ..callable };
                self.check_hook(&callable);
                let callable = self.add_callable(callable);
                entry.methods.insert(method.name.key, callable);
            }
        }
        for property in &pou.properties {
            if self.own_name(&mut names, property.name) {
                for (kind, accessor) in
                    [(CallableKind::Getter, &property.get), (CallableKind::Setter, &property.set)]
                {
                    let Some(accessor) = accessor else { continue };
                    let callable = self.accessor_callable(property, accessor, kind, &entry.shown);
                    let callable = Callable { owner: Some(place), ..callable };
                    let callable = self.add_callable(callable);
                    let map =
                        if kind == CallableKind::Getter { &mut entry.getters } else { &mut entry.setters };
                    map.insert(property.name.key, callable);
                }
            }
        }
        self.pous.push(entry);
    }

    fn own_name(&mut self, names: &mut KeyMap<Key, SourcePlace>, name: Name) -> bool {
        match names.insert(name.key, name.at) {
            None => true,
            Some(first) => {
                self.twice(name, first);
                false
            }
        }
    }

    pub(super) fn method_callable(&mut self, method: &'a ast::Method, of: &str) -> Callable<'a> {
        let shown = format!("{of}.{}", self.shown(method.name));
        let mut callable = Callable::new(CallableKind::Method, shown, method.name, method.end);
        callable.body = &method.body;
        callable.sections = &method.sections;
        callable.result_ref = method.result.as_ref();
        callable.modifiers = method.modifiers;
        callable.selector =
            Some(self.selector(MethodSelector { key: method.name.key, kind: SelectorKind::Method }));
        callable
    }

    pub(super) fn accessor_callable(
        &mut self,
        property: &'a ast::Property,
        accessor: &'a ast::Accessor,
        kind: CallableKind,
        of: &str,
    ) -> Callable<'a> {
        let word = if kind == CallableKind::Getter { "GET" } else { "SET" };
        let shown = format!("{of}.{}.{word}", self.shown(property.name));
        let mut callable = Callable::new(kind, shown, property.name, accessor.end);
        callable.body = &accessor.body;
        callable.sections = &accessor.sections;
        callable.result_ref = Some(&property.ty);
        callable.modifiers = property.modifiers;
        let kind = if kind == CallableKind::Getter { SelectorKind::Get } else { SelectorKind::Set };
        callable.selector = Some(self.selector(MethodSelector { key: property.name.key, kind }));
        callable
    }

    pub(super) fn selector(&mut self, selector: MethodSelector) -> u32 {
        let next = self.selectors.len() as u32;
        let place = *self.selector_index.entry(selector).or_insert(next);
        if place == next {
            self.selectors.push(selector);
        }
        place
    }

    /// Finds out every type that the sources declare; enumerations first, for their values are names for all.
    pub(super) fn resolve_types(&mut self) {
        let is_enumeration =
            |entry: &TypeEntry<'_>| matches!(entry.decl.ty.kind, ast::TypeKind::Enumeration { .. });
        for first in [true, false] {
            for place in 0..self.type_decls.len() {
                if is_enumeration(&self.type_decls[place]) == first {
                    self.named_type(place as u32);
                }
            }
        }
    }

    /// Finds out what blocks and programs consist of and what callables take.
    pub(super) fn resolve_pous(&mut self) {
        self.resolve_inheritance();
        for place in 0..self.pous.len() as u32 {
            if self.pous[place as usize].ast.kind == PouKind::FunctionBlock {
                self.resolve_block(place);
            }
        }
        for place in 0..self.pous.len() as u32 {
            if self.pous[place as usize].ast.kind == PouKind::Program {
                self.resolve_program(place);
            }
        }
        for callable in 0..self.callables.len() as u32 {
            self.signature(callable);
        }
        self.check_overrides();
    }

    /// The frame of a callable: its result, its parameters, its variables.
    fn signature(&mut self, place: u32) {
        let Some(callable) = self.callables.get(place as usize) else { return };
        let outer = std::mem::take(&mut self.context);
        self.context.pou = callable.owner;
        self.context.callable = Some(place);
        self.context.constant = true;
        self.build_signature(place);
        self.frame_initials(place);
        self.context = outer;
    }

    /// The same for a head of an interface, which is in no table.
    pub(super) fn head_signature(&mut self, head: Callable<'a>) -> Option<Callable<'a>> {
        let place = self.add_callable(head);
        let outer = std::mem::take(&mut self.context);
        self.context.callable = Some(place);
        self.context.constant = true;
        self.build_signature(place);
        self.context = outer;
        self.callables.pop()
    }

    fn build_signature(&mut self, place: u32) {
        let Some(callable) = self.callables.get(place as usize) else { return };
        let (kind, sections, result) = (callable.kind, callable.sections, callable.result_ref);
        let mut size = 0u32;
        if let Some(result) = result {
            let ty = self.resolve(result);
            if kind == CallableKind::Method || kind == CallableKind::Function {
                self.refuse_block_value(ty, result.at);
            }
            self.callables[place as usize].result = Some(ty);
            size = self.layout(ty).size;
        }
        for section in super::constants_first(sections.iter()) {
            if !self.is_frame_section(kind, section) {
                continue;
            }
            for decl in &section.variables {
                size = self.frame_variable(place, section, decl, size);
            }
        }
        let at = self.callables[place as usize].name.at;
        if !self.has_image_room(size, at) {
            return;
        }
        // Instances and structures have initial bytes, given values come over them.
        let callable = &mut self.callables[place as usize];
        callable.frame.resize(size as usize, 0);
        let mut places: Vec<(u32, TypeId)> = callable.result.iter().map(|ty| (0, *ty)).collect();
        for symbol in &callable.symbols {
            if let Home::Frame(at) = symbol.home {
                places.push((at, symbol.type_id()));
            }
        }
        for (at, ty) in places {
            let mut bytes = Vec::new();
            self.default_bytes(ty, &mut bytes);
            let frame = &mut self.callables[place as usize].frame;
            if let Some(room) = frame.get_mut(at as usize..at as usize + bytes.len()) {
                room.copy_from_slice(&bytes);
            }
        }
    }

    /// Whether the variables of a section stand in the frame; reports sections that cannot be there.
    fn is_frame_section(&mut self, kind: CallableKind, section: &'a Section) -> bool {
        match (kind, section.kind) {
            // Members of the instance: elsewhere.
            (CallableKind::Body, kind) if kind != SectionKind::Temp => return false,
            (_, SectionKind::External) => {
                self.check_external(section);
                return false;
            }
            (CallableKind::Getter | CallableKind::Setter, kind) if super::is_pin(kind) => {
                let message = "an accessor has no parameters of its own";
                self.findings.error(Code::Section, section.at, message, "declare variables with VAR");
                return false;
            }
            (_, SectionKind::Global) => {
                self.findings.error(Code::Section, section.at, "VAR_GLOBAL stands outside of units", "");
                return false;
            }
            // With the members of the block.
            (CallableKind::Method, SectionKind::Instance) => return false,
            (_, SectionKind::Instance) => {
                self.findings.error(Code::Section, section.at, "VAR_INST belongs into a METHOD", "");
                return false;
            }
            _ => {}
        }
        if section.retention != crate::program::Retention::None && section.kind != SectionKind::Static {
            let message = "variables that live for one call cannot be retained";
            let help = "retain variables of programs, blocks, or VAR_GLOBAL";
            self.findings.error(Code::Section, section.at, message, help);
        }
        true
    }

    /// Gives one variable its place in the frame; the size with it.
    fn frame_variable(
        &mut self,
        place: u32,
        section: &'a Section,
        decl: &'a ast::VarDecl,
        mut size: u32,
    ) -> u32 {
        let symbol = self.symbol(section, decl);
        self.check_name(decl.name);
        let callable = &mut self.callables[place as usize];
        let nth = callable.symbols.len();
        if let Some(first) = callable.index.get(&decl.name.key) {
            let first = callable.symbols.get(*first as usize).map_or(decl.name.at, |s| s.name.at);
            self.twice(decl.name, first);
            return size;
        }
        callable.index.insert(decl.name.key, nth as u32);
        callable.symbols.push(symbol);
        if let Some((_, at)) = &decl.address {
            let message = format!("`{}` cannot be located here", self.shown(decl.name));
            let help = "locate variables in VAR of a PROGRAM or in VAR_GLOBAL";
            self.findings.error(Code::Located, *at, message, help);
        }
        self.in_out = section.kind == SectionKind::InOut;
        self.any = section.kind == SectionKind::Input && matches!(decl.ty.kind, ast::TypeKind::Named(_));
        let ty = self.resolve(&decl.ty);
        (self.in_out, self.any) = (false, false);
        self.check_edge(section, decl, ty, false);
        let layout = self.layout(ty);
        let mut home = Home::Nowhere;
        if section.kind == SectionKind::Static {
            if self.has_room(layout.size, decl.name.at) {
                let mut bytes = Vec::new();
                self.default_bytes(ty, &mut bytes);
                home = Home::Absolute(self.allocate(&bytes, layout.align));
            }
        } else if section.kind == SectionKind::InOut {
            size = size.next_multiple_of(4);
            home = Home::FrameAddress(size);
            size += self.in_out_size(ty);
        } else {
            size = size.next_multiple_of(layout.align);
            home = Home::Frame(size);
            size = size.saturating_add(layout.size);
        }
        let callable = &mut self.callables[place as usize];
        if let Some(symbol) = callable.symbols.get_mut(nth) {
            symbol.ty = State::Done(ty);
            symbol.home = home;
        }
        if size > FRAME_LIMIT {
            let message = format!("the variables of `{}` need too much memory", callable.shown);
            self.findings.error(Code::DataSize, decl.name.at, message, "use VAR_STAT or a block");
            return 0;
        }
        size
    }

    /// A function cannot give an instance of a block.
    fn refuse_block_value(&mut self, ty: TypeId, at: SourcePlace) {
        if self.contains_block(ty) {
            let message = "a result cannot be a function block";
            self.findings.error(Code::Type, at, message, "give a REFERENCE TO it");
        }
    }

    /// VAR_EXTERNAL names global variables, of the same type.
    pub(super) fn check_external(&mut self, section: &'a Section) {
        for decl in &section.variables {
            let ty = self.resolve(&decl.ty);
            match self.outside.get(&decl.name.key).copied() {
                Some(Global::Variable(place)) => {
                    let known = self.global_type(place);
                    if known != ty && !super::is_wrong(known) && !super::is_wrong(ty) {
                        let message = format!(
                            "the global `{}` is {}, not {}",
                            self.shown(decl.name),
                            self.type_name(known),
                            self.type_name(ty)
                        );
                        self.findings.error(Code::Type, decl.ty.at, message, "declare it alike");
                    }
                }
                _ => {
                    let message = format!("there is no global variable `{}`", self.shown(decl.name));
                    let help = "declare it in VAR_GLOBAL";
                    self.findings.error(Code::UnknownName, decl.name.at, message, help);
                }
            }
            if let Some(initial) = &decl.initial {
                let at = initial_at(initial);
                let message = "the initial value belongs to VAR_GLOBAL";
                self.findings.error(Code::InitialValue, at, message, "remove it here");
            }
        }
    }

    /// The type of a global variable.
    pub(super) fn global_type(&mut self, place: u32) -> TypeId {
        let Some(symbol) = self.globals.get(place as usize) else { return super::WRONG };
        match symbol.ty {
            State::Done(ty) => ty,
            State::Busy => super::WRONG,
            State::Untouched => {
                let decl = symbol.decl;
                self.globals[place as usize].ty = State::Busy;
                let outer = std::mem::take(&mut self.context);
                let ty = self.resolve(&decl.ty);
                self.context = outer;
                self.globals[place as usize].ty = State::Done(ty);
                ty
            }
        }
    }
}

/// Bytes that a frame may have.
const FRAME_LIMIT: u32 = 1 << 20;

pub(super) fn initial_at(initial: &ast::Initializer) -> SourcePlace {
    match initial {
        ast::Initializer::One(expr) => expr.at,
        ast::Initializer::List(_, at) | ast::Initializer::Members(_, at) => *at,
    }
}
