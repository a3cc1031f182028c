//! Calls of functions, methods, blocks, programs and actions.

use super::Sema;
use super::argument::CallParameter;
use super::literal::LiteralOperand;
use super::place::{ObjectAccess, PathMeaning};
use super::scope::{Callable, CallableKind, FoundName, MethodSelector, SelectorKind};
use super::types::{Type, TypeId, WRONG};
use crate::codes::Code;
use crate::findings::{SourcePlace, similar};
use crate::parse::ast::{self, Argument, Name, PouKind};
use crate::tree::{CallInput, Callee, Expr, ExprKind, TreeCall, TreePlace, TreeRoot, Ty};

impl<'a> Sema<'a> {
    /// A call inside an expression.
    pub(super) fn call_value(
        &mut self,
        callee: &ast::Expr,
        arguments: &[Argument],
        at: SourcePlace,
    ) -> LiteralOperand {
        if let ast::ExprKind::Name(name) = &callee.kind
            && let Some(result) = self.named_call(*name, arguments, at)
        {
            return result;
        }
        // `Standard.CONCAT(...)`: a function with the name of its library before it.
        if let ast::ExprKind::Member(of, name) = &callee.kind
            && let ast::ExprKind::Name(library) = &of.kind
            && self.find(library.key).is_none()
            && let key = self.names.key_text(name.key)
            && let Some(result) = self.standard(*name, key, arguments, at)
        {
            return result;
        }
        let meaning = self.meaning(callee);
        if self.context.constant && !matches!(meaning, PathMeaning::Wrong) {
            self.not_constant(at, "a constant is needed here");
            return LiteralOperand::Wrong;
        }
        match meaning {
            PathMeaning::Wrong => {
                // Faults of the arguments are found in the same run.
                LiteralOperand::Wrong
            }
            PathMeaning::Function(pou) => self.function_call(pou, arguments, at),
            PathMeaning::Method(instance, name) => self.method_call(instance, name, arguments, at),
            PathMeaning::Program(pou) => self.program_call(pou, arguments, at),
            PathMeaning::Action(callable, place) => self.action_call(callable, place, arguments, at),
            PathMeaning::Super(base) => self.super_call(base, arguments, at),
            PathMeaning::Place(place, ty, fixed) => self.place_call(place, ty, fixed, callee, arguments, at),
            _ => {
                self.not_callable(callee.at);
                LiteralOperand::Wrong
            }
        }
    }

    fn not_callable(&mut self, at: SourcePlace) {
        let message = format!("`{}` cannot be called", self.text(at));
        let help = "functions, methods, programs and instances of function blocks can";
        self.findings.error(Code::NotCallable, at, message, help);
    }

    /// Calls by a name that needs no path: user functions, then the library.
    fn named_call(&mut self, name: Name, arguments: &[Argument], at: SourcePlace) -> Option<LiteralOperand> {
        let found = self.find(name.key);
        let key = self.names.key_text(name.key);
        match found {
            // The function's own name is its result too.
            Some(FoundName::Result) => {
                let place = self.context.callable?;
                match self.callables.get(place as usize)?.kind {
                    CallableKind::Function => {
                        let pou = match self.find_outside(name.key) {
                            Some(FoundName::Pou(pou)) => pou,
                            _ => return None,
                        };
                        Some(self.function_call(pou, arguments, at))
                    }
                    CallableKind::Method => Some(self.method_call(ObjectAccess::Same, name, arguments, at)),
                    _ => None,
                }
            }
            // A variable does not hide a function of the library from calls.
            Some(FoundName::Local(_) | FoundName::Member(..) | FoundName::Global(_)) => {
                let meaning_is_block = match found {
                    Some(FoundName::Local(place)) => {
                        self.running()?.symbols.get(place as usize).map(|s| s.type_id())
                    }
                    Some(FoundName::Member(owner, place)) => {
                        self.member_symbol(owner, place).map(|s| s.type_id())
                    }
                    Some(FoundName::Global(place)) => Some(self.global_type(place)),
                    _ => None,
                };
                let callable = meaning_is_block.is_some_and(|ty| {
                    let ty = match self.ty(ty) {
                        Type::Reference(to) => *to,
                        _ => ty,
                    };
                    matches!(self.ty(ty), Type::Block(_) | Type::Native(_) | Type::Wrong)
                });
                if callable {
                    return None;
                }
                if let Some(result) = self.standard(name, key, arguments, at) {
                    return Some(result);
                }
                self.not_callable(name.at);
                Some(LiteralOperand::Wrong)
            }
            Some(FoundName::Type(_) | FoundName::Enumerator(..) | FoundName::Ambiguous) | None => {
                if let Some(result) = self.standard(name, key, arguments, at) {
                    return Some(result);
                }
                if found.is_some() {
                    return None;
                }
                self.unknown_function(name);
                for argument in arguments {
                    if let Argument::Positional(value) | Argument::Input(_, value) = argument {
                        self.expr(value, None);
                    }
                }
                Some(LiteralOperand::Wrong)
            }
            _ => None,
        }
    }

    fn unknown_function(&mut self, name: Name) {
        let mut known: Vec<&str> = super::standard::names().chain(crate::library::names()).collect();
        for pou in &self.pous {
            if pou.ast.kind == PouKind::Function {
                known.push(self.names.key_text(pou.ast.name.key));
            }
        }
        // An instance of a block is called alike.
        let members = self.context.pou.into_iter().flat_map(|pou| self.lineage(pou));
        let members = members.filter_map(|owner| self.pous.get(owner as usize)).flat_map(|pou| &pou.symbols);
        let local = self.running().into_iter().flat_map(|callable| &callable.symbols);
        for symbol in local.chain(members).chain(&self.globals) {
            if matches!(self.ty(symbol.type_id()), Type::Block(_) | Type::Native(_)) {
                known.push(self.names.key_text(symbol.name.key));
            }
        }
        let near = similar(self.names.key_text(name.key), known.into_iter());
        let help = near.map_or(String::new(), |near| format!("did you mean {}?", self.written(&near)));
        let message = format!("the function `{}` is not known", self.shown(name));
        self.findings.error(Code::UnknownName, name.at, message, help);
    }

    fn function_call(&mut self, pou: u32, arguments: &[Argument], at: SourcePlace) -> LiteralOperand {
        if self.context.constant {
            let message = "a constant is needed here";
            self.findings.error(Code::NotConstant, at, message, "the result of a function is none");
            return LiteralOperand::Wrong;
        }
        let Some(place) = self.pous.get(pou as usize).map(|pou| pou.callable) else {
            return LiteralOperand::Wrong;
        };
        self.frame_call(place, Callee::Unit(place as u16), arguments, at)
    }

    /// A call with its parameters in the frame.
    fn frame_call(
        &mut self,
        callable: u32,
        callee: Callee,
        arguments: &[Argument],
        at: SourcePlace,
    ) -> LiteralOperand {
        let Some(callable) = self.callables.get(callable as usize) else { return LiteralOperand::Wrong };
        let parameters = self.frame_parameters(callable);
        let (shown, result) = (self.text(callable.name.at).to_string(), callable.result);
        self.call_with(&shown, parameters, callee, result, arguments, at)
    }

    fn call_with(
        &mut self,
        shown: &str,
        parameters: Vec<CallParameter>,
        callee: Callee,
        result: Option<TypeId>,
        arguments: &[Argument],
        at: SourcePlace,
    ) -> LiteralOperand {
        let native = match &callee {
            Callee::Native(native, _) => Some(*native),
            _ => None,
        };
        let Some((inputs, outputs)) = self.arguments(shown, &parameters, arguments, native, at) else {
            return LiteralOperand::Wrong;
        };
        self.finished_call(TreeCall { callee, inputs, outputs, result: result.map(|_| 0), at }, result)
    }

    fn finished_call(&mut self, call: TreeCall, result: Option<TypeId>) -> LiteralOperand {
        let at = call.at;
        let Some(ty) = result else {
            let kind = ExprKind::Call(Box::new(call));
            return LiteralOperand::Nothing(Expr { kind, ty: Ty::Block { bytes: 0 }, at });
        };
        if ty == WRONG {
            return LiteralOperand::Wrong;
        }
        let value = Expr { kind: ExprKind::Call(Box::new(call)), ty: self.tree_type(ty), at };
        if let Type::Reference(to) = *self.ty(ty) {
            let place = self.place(TreeRoot::Address(Box::new(value)), 0, to, false, at);
            return LiteralOperand::Value(
                Expr { kind: ExprKind::Load(place), ty: self.tree_type(to), at },
                to,
            );
        }
        LiteralOperand::Value(value, ty)
    }

    /// The code that a method or accessor of an instance runs, and its head.
    fn bound(
        &mut self,
        instance: &ObjectAccess,
        name: Name,
        kind: SelectorKind,
    ) -> Option<(Callee, Callable<'a>)> {
        let selector = MethodSelector { key: name.key, kind };
        let find = |sema: &Self, block: u32| match kind {
            SelectorKind::Method => sema.method(block, name.key),
            kind => sema.accessor(block, name.key, kind),
        };
        let (callee, head) = match instance {
            ObjectAccess::Same => {
                let block = self.context.pou?;
                let method = find(self, block)?;
                let head = self.callables.get(method as usize)?.clone();
                let number = head.selector.unwrap_or(0);
                let is_program = self.pous.get(block as usize)?.ast.kind == PouKind::Program;
                if is_program {
                    (Callee::Unit(method as u16), head)
                } else if self.is_overridden(block, number) && !head.modifiers.private {
                    let place = TreePlace {
                        root: TreeRoot::This,
                        offset: 0,
                        indices: Vec::new(),
                        ty: Ty::Address,
                        retained: false,
                        at: name.at,
                    };
                    (Callee::Virtual(number, self.address_of(place)), head)
                } else {
                    (Callee::Same(method as u16), head)
                }
            }
            ObjectAccess::Super(base) => {
                let method = find(self, *base)?;
                (Callee::Same(method as u16), self.callables.get(method as usize)?.clone())
            }
            ObjectAccess::Exact(place, block) => {
                let method = find(self, *block)?;
                (Callee::Of(method as u16, place.clone()), self.callables.get(method as usize)?.clone())
            }
            ObjectAccess::Block(address, block) => {
                let method = find(self, *block)?;
                let head = self.callables.get(method as usize)?.clone();
                let number = head.selector.unwrap_or(0);
                if self.is_overridden(*block, number) || head.modifiers.is_abstract {
                    (Callee::Virtual(number, address.clone()), head)
                } else {
                    let place = TreePlace {
                        root: TreeRoot::Address(Box::new(address.clone())),
                        offset: 0,
                        indices: Vec::new(),
                        ty: Ty::Address,
                        retained: false,
                        at: name.at,
                    };
                    (Callee::Of(method as u16, place), head)
                }
            }
            ObjectAccess::Interface(address, interface) => {
                let heads = &self.interfaces.get(*interface as usize)?.heads;
                let head = heads.iter().find(|(known, _)| *known == selector)?.1.clone();
                let number = self.selector(selector);
                (Callee::Virtual(number, address.clone()), head)
            }
        };
        Some((callee, head))
    }

    fn method_call(
        &mut self,
        instance: ObjectAccess,
        name: Name,
        arguments: &[Argument],
        at: SourcePlace,
    ) -> LiteralOperand {
        let Some((callee, head)) = self.bound(&instance, name, SelectorKind::Method) else {
            self.not_callable(name.at);
            return LiteralOperand::Wrong;
        };
        let parameters = self.frame_parameters(&head);
        let shown = self.shown(name).to_string();
        self.call_with(&shown, parameters, callee, head.result, arguments, at)
    }

    /// The value of a property.
    pub(super) fn get_property(&mut self, instance: &ObjectAccess, name: Name) -> LiteralOperand {
        if self.context.constant {
            self.not_constant(name.at, "a constant is needed here");
            return LiteralOperand::Wrong;
        }
        match self.bound(instance, name, SelectorKind::Get) {
            Some((callee, head)) => {
                let call = TreeCall {
                    callee,
                    inputs: Vec::new(),
                    outputs: Vec::new(),
                    result: Some(0),
                    at: name.at,
                };
                self.finished_call(call, head.result)
            }
            None => {
                let message = format!("the property `{}` cannot be read", self.shown(name));
                self.findings.error(Code::NotAValue, name.at, message, "it has no GET");
                LiteralOperand::Wrong
            }
        }
    }

    /// Setting a property: the type of its value, then the call with it.
    pub(super) fn set_property(
        &mut self,
        instance: &ObjectAccess,
        name: Name,
        value: &ast::Expr,
        at: SourcePlace,
    ) -> Option<Expr> {
        let Some((callee, head)) = self.bound(instance, name, SelectorKind::Set) else {
            let message = format!("the property `{}` cannot be set", self.shown(name));
            self.findings.error(Code::ReadOnly, name.at, message, "it has no SET");
            return None;
        };
        let (ty, to) = self.setter_parameter(&head)?;
        let value = self.value(value, ty)?;
        let inputs = vec![CallInput { to, value }];
        let call = TreeCall { callee, inputs, outputs: Vec::new(), result: None, at };
        Some(Expr { kind: ExprKind::Call(Box::new(call)), ty: Ty::Block { bytes: 0 }, at })
    }

    fn program_call(&mut self, pou: u32, arguments: &[Argument], at: SourcePlace) -> LiteralOperand {
        let Some(entry) = self.pous.get(pou as usize) else { return LiteralOperand::Wrong };
        let (unit, shown) = (entry.callable as u16, entry.shown.clone());
        let origin = self.place(TreeRoot::Absolute, 0, WRONG, false, at);
        let parameters = self.block_parameters(pou, &origin);
        self.call_with(&shown, parameters, Callee::Unit(unit), None, arguments, at)
    }

    fn action_call(
        &mut self,
        callable: u32,
        place: Option<TreePlace>,
        arguments: &[Argument],
        at: SourcePlace,
    ) -> LiteralOperand {
        let owner = self.callables.get(callable as usize).and_then(|callable| callable.owner);
        let program = owner
            .and_then(|owner| self.pous.get(owner as usize))
            .is_some_and(|pou| pou.ast.kind == PouKind::Program);
        let callee = match place {
            _ if program => Callee::Unit(callable as u16),
            Some(place) => Callee::Of(callable as u16, place),
            None => Callee::Same(callable as u16),
        };
        self.frame_call(callable, callee, arguments, at)
    }

    /// `SUPER^(..)`: the body of what the block extends.
    fn super_call(&mut self, base: u32, arguments: &[Argument], at: SourcePlace) -> LiteralOperand {
        let Some(entry) = self.pous.get(base as usize) else { return LiteralOperand::Wrong };
        let (unit, shown) = (entry.callable as u16, entry.shown.clone());
        let ty = self.intern(Type::Block(base));
        let origin = self.place(TreeRoot::This, 0, ty, false, at);
        let parameters = self.block_parameters(base, &origin);
        self.call_with(&shown, parameters, Callee::Same(unit), None, arguments, at)
    }

    /// An instance of a block.
    fn place_call(
        &mut self,
        place: TreePlace,
        ty: TypeId,
        fixed: Option<&'static str>,
        callee: &ast::Expr,
        arguments: &[Argument],
        at: SourcePlace,
    ) -> LiteralOperand {
        if fixed == Some("it belongs to the block alone") {
            let message = "an inner instance of a block cannot be called here";
            self.findings.error(Code::NotCallable, callee.at, message, "");
            return LiteralOperand::Wrong;
        }
        match *self.ty(ty) {
            Type::Block(block) => {
                let Some(entry) = self.pous.get(block as usize) else { return LiteralOperand::Wrong };
                let (unit, shown) = (entry.callable as u16, entry.shown.clone());
                if entry.ast.modifiers.is_abstract
                    && !matches!(place.root, TreeRoot::Address(_) | TreeRoot::This)
                {
                    let message = format!("`{shown}` is ABSTRACT");
                    self.findings.error(Code::NotCallable, callee.at, message, "use a block that extends it");
                }
                let parameters = self.block_parameters(block, &place);
                let same =
                    matches!(place.root, TreeRoot::This) && place.offset == 0 && place.indices.is_empty();
                let callee = if same { Callee::Same(unit) } else { Callee::Of(unit, place) };
                self.call_with(&shown, parameters, callee, None, arguments, at)
            }
            Type::Native(native) => {
                let shown = self
                    .options
                    .blocks
                    .get(usize::from(native))
                    .map_or(String::new(), |n| n.name.to_string());
                let parameters = self.native_parameters(native, &place);
                self.call_with(&shown, parameters, Callee::Native(native, place), None, arguments, at)
            }
            Type::Wrong => LiteralOperand::Wrong,
            _ => {
                self.not_callable(callee.at);
                LiteralOperand::Wrong
            }
        }
    }
}
