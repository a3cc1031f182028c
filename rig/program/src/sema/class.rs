//! What blocks extend and implement.

use super::scope::{Callable, CallableKind, MethodSelector, SelectorKind, SymbolKind};
use super::types::TypeId;
use super::{Global, Sema, State};
use crate::code::ObjectClass;
use crate::codes::Code;
use crate::findings::SourcePlace;
use crate::parse::ast::{self, Name, PouKind, SectionKind};
use std::collections::{BTreeMap, BTreeSet};

/// Most methods and properties that all interfaces inherit together.
const MOST_HEADS: usize = 100_000;
/// Most entries of the tables by which methods are chosen while a program runs.
const MOST_TARGETS: usize = 10_000_000;

impl<'a> Sema<'a> {
    /// EXTENDS and IMPLEMENTS of every block and interface.
    pub(super) fn resolve_inheritance(&mut self) {
        for place in 0..self.interfaces.len() as u32 {
            self.kinds.push(SymbolKind::Interface(place));
            let ast = self.interfaces[place as usize].ast;
            let extends = ast.extends.iter().filter_map(|name| self.interface(*name)).collect();
            self.interfaces[place as usize].extends = extends;
        }
        let mut class = 0;
        for place in 0..self.pous.len() as u32 {
            let ast = self.pous[place as usize].ast;
            if ast.kind != PouKind::FunctionBlock {
                if let Some(name) = ast.extends.as_ref().or(ast.implements.first()) {
                    let message = format!("a {} extends and implements nothing", ast.kind.keyword());
                    self.findings.error(Code::Section, name.at, message, "FUNCTION_BLOCKs do");
                }
                if let Some(name) =
                    ast.methods.first().map(|m| m.name).or(ast.properties.first().map(|p| p.name))
                    && ast.kind == PouKind::Function
                {
                    let message = "a FUNCTION has no methods";
                    self.findings.error(Code::Section, name.at, message, "FUNCTION_BLOCKs have");
                }
                continue;
            }
            self.kinds.push(SymbolKind::Block(place));
            self.pous[place as usize].class = class;
            class += 1;
            if let Some(name) = ast.extends {
                match self.outside.get(&name.key) {
                    Some(Global::Pou(base))
                        if self.pous[*base as usize].ast.kind == PouKind::FunctionBlock =>
                    {
                        let base = *base;
                        if self.pous[base as usize].ast.modifiers.is_final {
                            let message = format!("`{}` is FINAL", self.shown(name));
                            self.findings.error(Code::Type, name.at, message, "it cannot be extended");
                        }
                        self.pous[place as usize].base = Some(base);
                    }
                    _ => {
                        let message = format!("there is no FUNCTION_BLOCK `{}`", self.shown(name));
                        let help = "declare it, or remove EXTENDS";
                        self.findings.error(Code::UnknownType, name.at, message, help);
                    }
                }
            }
            let implements: Vec<u32> =
                ast.implements.iter().filter_map(|name| self.interface(*name)).collect();
            self.pous[place as usize].interfaces = implements;
        }
        self.break_circles();
        for place in 0..self.interfaces.len() as u32 {
            self.resolve_interface(place);
        }
    }

    fn interface(&mut self, name: Name) -> Option<u32> {
        match self.outside.get(&name.key) {
            Some(Global::Interface(place)) => Some(*place),
            _ => {
                let message = format!("there is no INTERFACE `{}`", self.shown(name));
                self.findings.error(Code::UnknownType, name.at, message, "declare it with INTERFACE");
                None
            }
        }
    }

    /// A block that extends itself through others loses its base, and so does one that extends too many: what follows
    /// goes through all that a block extends, for each block.
    fn break_circles(&mut self) {
        for place in 0..self.pous.len() as u32 {
            let mut at = self.pous[place as usize].base;
            let mut levels = 0;
            while let Some(base) = at {
                let name = self.pous[place as usize].ast.name;
                if base == place {
                    let message = format!("`{}` extends itself", self.shown(name));
                    self.findings.error(Code::ContainsItself, name.at, message, "remove EXTENDS");
                } else if levels >= super::TYPE_DEPTH {
                    let message = "blocks extend each other too deeply";
                    self.findings.error(Code::Depth, name.at, message, "use fewer levels");
                } else {
                    levels += 1;
                    at = self.pous[base as usize].base;
                    continue;
                }
                self.pous[place as usize].base = None;
                break;
            }
        }
    }

    /// Heads of the methods of an interface, inherited ones too.
    fn resolve_interface(&mut self, place: u32) {
        match self.interfaces[place as usize].state {
            State::Untouched => {}
            State::Done(()) => return,
            State::Busy => {
                let name = self.interfaces[place as usize].ast.name;
                let message = format!("`{}` extends itself", self.shown(name));
                self.findings.error(Code::ContainsItself, name.at, message, "remove EXTENDS");
                return;
            }
        }
        if self.depth >= super::TYPE_DEPTH {
            let at = self.interfaces[place as usize].ast.name.at;
            let message = "interfaces extend each other too deeply";
            self.findings.error(Code::Depth, at, message, "use fewer levels");
            return;
        }
        self.depth += 1;
        self.interfaces[place as usize].state = State::Busy;
        let mut heads: Vec<(MethodSelector, Callable<'a>)> = Vec::new();
        for base in self.interfaces[place as usize].extends.clone() {
            self.resolve_interface(base);
            for (selector, head) in self.interfaces[base as usize].heads.clone() {
                if !heads.iter().any(|(known, _)| *known == selector) {
                    heads.push((selector, head));
                }
            }
        }
        self.heads += heads.len();
        if self.heads > MOST_HEADS {
            let at = self.interfaces[place as usize].ast.name.at;
            let message = format!("the interfaces inherit more than {MOST_HEADS} methods together");
            self.findings.error(Code::Length, at, message, "let fewer interfaces extend large ones");
            heads.clear();
        }
        let ast = self.interfaces[place as usize].ast;
        let shown = self.interfaces[place as usize].shown.clone();
        let outer = std::mem::take(&mut self.context);
        self.context.constant = true;
        for method in &ast.methods {
            let callable = self.method_callable(method, &shown);
            self.head(&mut heads, SelectorKind::Method, method.name, callable);
        }
        for property in &ast.properties {
            for (kind, selector, accessor) in [
                (CallableKind::Getter, SelectorKind::Get, &property.get),
                (CallableKind::Setter, SelectorKind::Set, &property.set),
            ] {
                let Some(accessor) = accessor else { continue };
                let callable = self.accessor_callable(property, accessor, kind, &shown);
                self.head(&mut heads, selector, property.name, callable);
            }
        }
        self.context = outer;
        self.depth -= 1;
        self.interfaces[place as usize].heads = heads;
        self.interfaces[place as usize].state = State::Done(());
    }

    fn head(
        &mut self,
        heads: &mut Vec<(MethodSelector, Callable<'a>)>,
        kind: SelectorKind,
        name: Name,
        callable: Callable<'a>,
    ) {
        let selector = MethodSelector { key: name.key, kind };
        if heads.iter().any(|(known, head)| *known == selector && head.name.at != name.at) {
            let message = format!("`{}` is there already", self.shown(name));
            self.findings.error(Code::Duplicate, name.at, message, "an interface does not override");
            return;
        }
        if let Some(callable) = self.head_signature(callable) {
            heads.push((selector, callable));
        }
    }

    /// Methods that override others or implement an interface are called alike.
    pub(super) fn check_overrides(&mut self) {
        for place in 0..self.pous.len() as u32 {
            let pou = &self.pous[place as usize];
            if pou.ast.kind != PouKind::FunctionBlock {
                continue;
            }
            let base = pou.base;
            let own: Vec<u32> =
                sorted(pou.methods.values().chain(pou.getters.values()).chain(pou.setters.values()));
            for method in own {
                self.check_override(method, base);
            }
            self.check_interfaces(place);
            self.check_abstract(place);
        }
    }

    fn check_override(&mut self, method: u32, base: Option<u32>) {
        let Some(callable) = self.callables.get(method as usize) else { return };
        let (name, modifiers, kind) = (callable.name, callable.modifiers, callable.kind);
        let inherited = base.and_then(|base| match kind {
            CallableKind::Getter => self.accessor(base, name.key, SelectorKind::Get),
            CallableKind::Setter => self.accessor(base, name.key, SelectorKind::Set),
            _ => self.method(base, name.key),
        });
        match inherited.and_then(|place| self.callables.get(place as usize)) {
            Some(over) => {
                let is_final = over.modifiers.is_final;
                let (other, of) = (over.name.at, over.shown.clone());
                let alike = self.alike(&self.callables[method as usize], over);
                if is_final {
                    let message = format!("`{of}` is FINAL");
                    self.findings.error(Code::Override, name.at, message, "it cannot be overridden");
                } else if !alike && self.names.key_text(name.key) != "FB_INIT" {
                    let message = format!("`{}` takes or gives other types than `{of}`", self.shown(name));
                    let help = "a method that overrides another has the same parameters and result";
                    self.findings.error_with(Code::Override, name.at, message, help, (other, "this one"));
                }
            }
            None if modifiers.is_override => {
                let message = format!("`{}` overrides nothing", self.shown(name));
                self.findings.error(Code::Override, name.at, message, "remove OVERRIDE");
            }
            None => {}
        }
    }

    /// Whether two callables have the same parameters, in the same places, and the same result.
    fn alike(&self, a: &Callable<'a>, b: &Callable<'a>) -> bool {
        let parameters = |callable: &Callable<'a>| -> Vec<(ast::Key, SectionKind, TypeId)> {
            let pins = callable.symbols.iter().filter(|symbol| super::is_pin(symbol.kind));
            pins.map(|symbol| (symbol.name.key, symbol.kind, symbol.type_id())).collect()
        };
        let homes = |callable: &Callable<'a>| -> Vec<super::scope::Home> {
            let pins = callable.symbols.iter().filter(|symbol| super::is_pin(symbol.kind));
            pins.map(|symbol| symbol.home).collect()
        };
        a.result == b.result && parameters(a) == parameters(b) && homes(a) == homes(b)
    }

    fn check_interfaces(&mut self, place: u32) {
        let name = self.pous[place as usize].ast.name;
        for interface in self.pous[place as usize].interfaces.clone() {
            for (selector, head) in self.interfaces[interface as usize].heads.clone() {
                let found = match selector.kind {
                    SelectorKind::Method => self.method(place, selector.key),
                    kind => self.accessor(place, selector.key, kind),
                };
                let alike = found
                    .and_then(|f| self.callables.get(f as usize))
                    .map(|f| (self.alike(f, &head), f.name.at));
                match alike {
                    Some((true, _)) => {}
                    Some((false, at)) => {
                        let message = format!("`{}` has other parameters here", head.shown);
                        let help = "an implementation has the parameters of its interface, declared in the same order";
                        self.findings.error_with(
                            Code::Override,
                            at,
                            message,
                            help,
                            (head.name.at, "this one"),
                        );
                    }
                    None if self.pous[place as usize].ast.modifiers.is_abstract => {}
                    None => {
                        let message = format!("`{}` does not implement `{}`", self.shown(name), head.shown);
                        let help = "write the method, or make the block ABSTRACT";
                        self.findings.error(Code::Override, name.at, message, help);
                    }
                }
            }
        }
    }

    fn check_abstract(&mut self, place: u32) {
        let pou = &self.pous[place as usize];
        if pou.ast.modifiers.is_abstract {
            return;
        }
        let name = pou.ast.name;
        let lineage: Vec<u32> = self.lineage(place).collect();
        for owner in lineage {
            for method in sorted(self.pous[owner as usize].methods.values()) {
                let callable = &self.callables[method as usize];
                let final_one = self.method(place, callable.name.key);
                if callable.modifiers.is_abstract && final_one == Some(method) {
                    let message =
                        format!("`{}` does not write the method `{}`", self.shown(name), callable.shown);
                    let help = "write it, or make the block ABSTRACT";
                    self.findings.error(Code::Override, name.at, message, help);
                }
            }
        }
    }

    /// Whether an instance of block `place` is one of `other` too.
    pub(super) fn extends(&self, place: u32, other: u32) -> bool {
        self.lineage(place).any(|owner| owner == other)
    }

    /// Whether a block implements an interface, itself or through what it extends.
    pub(super) fn implements(&self, place: u32, interface: u32) -> bool {
        self.bases(self.implemented(place)).contains(&interface)
    }

    /// The interfaces that a block and those that it extends name.
    fn implemented(&self, place: u32) -> Vec<u32> {
        let owners = self.lineage(place).filter_map(|owner| self.pous.get(owner as usize));
        owners.flat_map(|pou| pou.interfaces.iter().copied()).collect()
    }

    pub(super) fn interface_extends(&self, place: u32, other: u32) -> bool {
        self.bases([place]).contains(&other)
    }

    /// Interfaces with all that they extend, each looked at once: they may meet in one base by many ways.
    fn bases(&self, interfaces: impl IntoIterator<Item = u32>) -> BTreeSet<u32> {
        let mut found = BTreeSet::new();
        let mut open: Vec<u32> = interfaces.into_iter().collect();
        while let Some(place) = open.pop() {
            if found.insert(place) {
                open.extend(
                    self.interfaces.get(place as usize).iter().flat_map(|interface| &interface.extends),
                );
            }
        }
        found
    }

    /// Whether some block that extends this one overrides the method.
    pub(super) fn is_overridden(&self, place: u32, selector: u32) -> bool {
        let Some(selector) = self.selectors.get(selector as usize).copied() else { return false };
        (0..self.pous.len() as u32).any(|derived| {
            let pou = &self.pous[derived as usize];
            let map = match selector.kind {
                SelectorKind::Method => &pou.methods,
                SelectorKind::Get => &pou.getters,
                SelectorKind::Set => &pou.setters,
            };
            derived != place && map.contains_key(&selector.key) && self.extends(derived, place)
        })
    }

    /// The classes of the blocks, for calls that are bound at run time.
    pub(super) fn classes(&mut self) -> Vec<ObjectClass> {
        if self.kinds.len().saturating_mul(self.selectors.len()) > MOST_TARGETS {
            let message = format!(
                "{} blocks with {} methods that are chosen while the program runs are too many",
                self.kinds.len(),
                self.selectors.len()
            );
            let help = "let fewer blocks have methods that others override";
            self.findings.error(Code::Length, SourcePlace::default(), message, help);
        }
        if self.findings.failed() {
            return Vec::new();
        }
        let blocks = (0..self.pous.len() as u32)
            .filter(|place| self.pous[*place as usize].ast.kind == PouKind::FunctionBlock);
        let (mut block_kinds, mut interface_kinds) = (BTreeMap::new(), BTreeMap::new());
        for (kind, nth) in self.kinds.iter().zip(0u32..) {
            match kind {
                SymbolKind::Block(place) => block_kinds.insert(*place, nth),
                SymbolKind::Interface(place) => interface_kinds.insert(*place, nth),
            };
        }
        let class = |place: u32| {
            let method = |selector: &MethodSelector| {
                let found = match selector.kind {
                    SelectorKind::Method => self.method(place, selector.key),
                    kind => self.accessor(place, selector.key, kind),
                };
                found.map(|unit| unit as u16)
            };
            let of_block = self.lineage(place).filter_map(|owner| block_kinds.get(&owner));
            let bases = self.bases(self.implemented(place));
            let of_interfaces = bases.iter().filter_map(|base| interface_kinds.get(base));
            let mut kinds: Vec<u32> = of_block.chain(of_interfaces).copied().collect();
            kinds.sort_unstable();
            ObjectClass { methods: self.selectors.iter().map(method).collect(), kinds }
        };
        blocks.map(class).collect()
    }

    /// Reports a member that is not for everyone; `from` is the block whose code uses it.
    pub(super) fn check_access(&mut self, method: u32, at: SourcePlace) {
        let Some(callable) = self.callables.get(method as usize) else { return };
        let (modifiers, Some(owner)) = (callable.modifiers, callable.owner) else { return };
        let shown = callable.shown.clone();
        let from = self.context.pou;
        let allowed = if modifiers.private {
            from == Some(owner)
        } else if modifiers.protected {
            from.is_some_and(|from| self.extends(from, owner))
        } else {
            true
        };
        if !allowed {
            let word = if modifiers.private { "PRIVATE" } else { "PROTECTED" };
            let message = format!("`{shown}` is {word}");
            self.findings.error(Code::NotCallable, at, message, "only the block itself may use it");
        }
    }
}

/// Places in order, so that findings do not depend on that of a map.
fn sorted<'m>(places: impl Iterator<Item = &'m u32>) -> Vec<u32> {
    let mut list: Vec<u32> = places.copied().collect();
    list.sort_unstable();
    list
}
