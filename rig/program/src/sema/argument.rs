//! Arguments of calls: which parameter each one is for, and what goes there.

use super::Sema;
use super::place::PathMeaning;
use super::scope::{Callable, Home, ScopeSymbol};
use super::types::{Type, TypeId};
use crate::codes::Code;
use crate::findings::{SourcePlace, count};
use crate::native::PinKind;
use crate::parse::ast::{self, Argument, Key, SectionKind};
use crate::tree::{CallInput, CallOutput, Expr, ExprKind, Slot, Target, TreePlace, Ty};
use crate::types::Elementary;

/// A parameter of whatever is called.
#[derive(Clone, Debug)]
pub(super) struct CallParameter {
    pub key: Key,
    pub shown: String,
    pub kind: SectionKind,
    pub ty: TypeId,
    pub slot: Slot,
    /// May be left out.
    pub optional: bool,
    /// In-out that is only read.
    pub constant: bool,
    /// Input of any type.
    pub any: Option<super::any::Any>,
}

impl<'a> Sema<'a> {
    /// Parameters that stand in the callee's frame.
    pub(super) fn frame_parameters(&self, callable: &Callable<'a>) -> Vec<CallParameter> {
        let pins = callable.symbols.iter().filter(|symbol| super::is_pin(symbol.kind));
        pins.filter_map(|symbol| {
            let (offset, ty) = match symbol.home {
                Home::Frame(offset) => (offset, self.tree_type(symbol.type_id())),
                Home::FrameAddress(offset) => (offset, Ty::Address),
                _ => return None,
            };
            Some(self.parameter(symbol, Slot::Frame(offset, ty), symbol.given()))
        })
        .collect()
    }

    fn parameter(&self, symbol: &ScopeSymbol<'a>, slot: Slot, optional: bool) -> CallParameter {
        CallParameter {
            key: symbol.name.key,
            shown: symbol.shown.to_string(),
            kind: symbol.kind,
            ty: symbol.type_id(),
            slot,
            optional,
            constant: symbol.constant,
            any: match symbol.decl.ty.kind {
                ast::TypeKind::Named(name) => self.any_named(name),
                _ => None,
            },
        }
    }

    /// The value of a property that is set.
    pub(super) fn setter_parameter(&self, callable: &Callable<'a>) -> Option<(TypeId, Slot)> {
        let ty = callable.result?;
        Some((ty, Slot::Frame(0, self.tree_type(ty))))
    }

    /// Pins of an instance of a block at a place, of what it extends first.
    pub(super) fn block_parameters(&self, block: u32, place: &TreePlace) -> Vec<CallParameter> {
        let mut lineage: Vec<u32> = self.lineage(block).collect();
        lineage.reverse();
        let mut list = Vec::new();
        for owner in lineage {
            let Some(pou) = self.pous.get(owner as usize) else { continue };
            for symbol in pou.symbols.iter().filter(|symbol| super::is_pin(symbol.kind)) {
                let at = place.at;
                let inner = match symbol.home {
                    Home::This(offset) => self.inside(place.clone(), offset, symbol.type_id(), at),
                    Home::ThisAddress(offset) => TreePlace {
                        ty: Ty::Address,
                        ..self.inside(place.clone(), offset, symbol.type_id(), at)
                    },
                    // Of a program.
                    Home::Absolute(address) => {
                        self.place(crate::tree::TreeRoot::Absolute, address, symbol.type_id(), false, at)
                    }
                    Home::AbsoluteAddress(address) => TreePlace {
                        ty: Ty::Address,
                        ..self.place(crate::tree::TreeRoot::Absolute, address, symbol.type_id(), false, at)
                    },
                    _ => continue,
                };
                let kept = symbol.retention != crate::program::Retention::None;
                let inner = TreePlace { retained: inner.retained || kept, ..inner };
                let optional = symbol.kind != SectionKind::InOut;
                list.push(self.parameter(symbol, Slot::Place(inner), optional));
            }
        }
        list
    }

    pub(super) fn native_parameters(&mut self, native: u16, place: &TreePlace) -> Vec<CallParameter> {
        let Some(block) = self.options.blocks.get(usize::from(native)) else { return Vec::new() };
        let offsets = self.native_layouts.get(usize::from(native)).map_or(Vec::new(), |(o, _)| o.clone());
        let mut list = Vec::new();
        for (pin, offset) in block.pins.iter().zip(offsets) {
            let kind = match pin.kind {
                PinKind::Input => SectionKind::Input,
                PinKind::Output => SectionKind::Output,
                PinKind::Hidden => continue,
            };
            let ty = self.elementary(pin.ty);
            let inner = self.inside(place.clone(), u32::from(offset), ty, place.at);
            list.push(CallParameter {
                // Names of pins that no source uses have no key.
                key: self.names.get(pin.name).unwrap_or(Key(u32::MAX)),
                shown: pin.name.to_string(),
                kind,
                ty,
                slot: Slot::Place(inner),
                optional: true,
                constant: false,
                any: None,
            });
        }
        list
    }

    /// The place of a parameter by its name; native blocks have several names for some.
    fn parameter_named(
        &self,
        parameters: &[CallParameter],
        name: ast::Name,
        native: Option<u16>,
        output: bool,
    ) -> Option<usize> {
        let fits = |parameter: &CallParameter| output == (parameter.kind == SectionKind::Output);
        if let Some(block) = native.and_then(|native| self.options.blocks.get(usize::from(native))) {
            let pin = block.pins.get(block.pin(self.names.key_text(name.key))?)?;
            return parameters.iter().position(|p| p.shown == pin.name && fits(p));
        }
        parameters.iter().position(|parameter| parameter.key == name.key && fits(parameter))
    }

    /// Inputs and outputs of a call. `None` where something was reported.
    pub(super) fn arguments(
        &mut self,
        shown: &str,
        parameters: &[CallParameter],
        arguments: &[Argument],
        native: Option<u16>,
        at: SourcePlace,
    ) -> Option<(Vec<CallInput>, Vec<CallOutput>)> {
        let mut given = vec![false; parameters.len()];
        let mut inputs = Vec::new();
        let mut outputs = Vec::new();
        let mut whole = true;
        let takes: Vec<usize> =
            (0..parameters.len()).filter(|nth| parameters[*nth].kind != SectionKind::Output).collect();
        // A list without names gives the inputs, or everything in the order of the declaration.
        let all = takes.len() < parameters.len()
            && arguments.len() == parameters.len()
            && arguments.iter().all(|argument| matches!(argument, Argument::Positional(_)));
        for (nth, argument) in arguments.iter().enumerate() {
            let (place, value, place_at) = match argument {
                Argument::Positional(target) if all && parameters[nth].kind == SectionKind::Output => {
                    match self.output(&parameters[nth], false, target) {
                        Some(output) => outputs.push(output),
                        None => whole = false,
                    }
                    continue;
                }
                Argument::Positional(value) if all => (Some(nth), value, value.at),
                Argument::Positional(value) => (takes.get(nth).copied(), value, value.at),
                Argument::Input(name, value) => {
                    let found = self.parameter_named(parameters, *name, native, false);
                    if found.is_none() {
                        self.unknown_parameter(*name, shown, parameters, false);
                        whole = false;
                        // Faults of the value are found in the same run.
                        self.expr(value, None);
                        continue;
                    }
                    (found, value, name.at)
                }
                Argument::Empty(name) => {
                    if self.parameter_named(parameters, *name, native, false).is_none() {
                        self.unknown_parameter(*name, shown, parameters, false);
                        whole = false;
                    }
                    continue;
                }
                Argument::Output { name, negated, target } => {
                    match self.parameter_named(parameters, *name, native, true) {
                        Some(place) => {
                            let Some(target) = target else { continue };
                            match self.output(&parameters[place], *negated, target) {
                                Some(output) => outputs.push(output),
                                None => whole = false,
                            }
                        }
                        None => {
                            self.unknown_parameter(*name, shown, parameters, true);
                            whole = false;
                        }
                    }
                    continue;
                }
            };
            let Some(place) = place else {
                let message = format!("`{shown}` has {}", count(takes.len(), "input"));
                self.findings.error(Code::Arguments, place_at, message, "remove what is too much");
                whole = false;
                continue;
            };
            if std::mem::replace(&mut given[place], true) {
                self.findings.error(Code::Arguments, place_at, "this parameter is given twice", "");
                whole = false;
                continue;
            }
            let parameter = &parameters[place];
            let written = value;
            if let Some(any) = parameter.any {
                match self.any_inputs(value, parameter, any) {
                    Some(list) => inputs.extend(list),
                    None => whole = false,
                }
                continue;
            }
            let value = if parameter.kind == SectionKind::InOut {
                self.by_reference(value, parameter)
            } else {
                self.value(value, parameter.ty)
            };
            match value {
                Some(value) => {
                    inputs.push(CallInput { to: parameter.slot.clone(), value });
                    inputs.extend(self.open_inputs(written, parameter));
                }
                None => whole = false,
            }
        }
        // A list with names may be incomplete: what is left out has its initial value, or that of its type.
        let named = arguments.iter().any(|argument| matches!(argument, Argument::Input(..)));
        let missing: Vec<&str> = takes
            .iter()
            .filter(|nth| !given[**nth] && !parameters[**nth].optional)
            .filter(|nth| !named || parameters[**nth].kind == SectionKind::InOut)
            .map(|nth| parameters[*nth].shown.as_str())
            .collect();
        if !missing.is_empty() && whole {
            let message = format!("`{shown}` needs a value for {}", missing.join(", "));
            let help = "name the parameters that are given, as in x := 1: inputs that are left out have initial values then";
            self.findings.error(Code::Arguments, at, message, help);
            return None;
        }
        whole.then_some((inputs, outputs))
    }

    fn unknown_parameter(&mut self, name: ast::Name, of: &str, parameters: &[CallParameter], output: bool) {
        let known: Vec<&str> = parameters
            .iter()
            .filter(|parameter| output == (parameter.kind == SectionKind::Output))
            .map(|parameter| parameter.shown.as_str())
            .collect();
        let help = match known.as_slice() {
            [] => format!("`{of}` has no such parameters"),
            known => format!("`{of}` has {}", known.join(", ")),
        };
        let message = format!("`{of}` has no parameter `{}`", self.shown(name));
        self.findings.error(Code::UnknownParameter, name.at, message, help);
    }

    /// The address of a variable for an in-out.
    pub(super) fn by_reference(&mut self, written: &ast::Expr, parameter: &CallParameter) -> Option<Expr> {
        let at = written.at;
        let (place, ty, fixed) = match self.meaning(written) {
            PathMeaning::Place(place, ty, fixed) => (place, ty, fixed),
            PathMeaning::Wrong => return None,
            PathMeaning::Bit(..) => {
                let message = "a single bit cannot be passed by reference";
                self.findings.error(Code::Output, at, message, "pass a BOOL variable and copy it");
                return None;
            }
            meaning if parameter.constant => {
                let operand = self.operand_of(meaning, at);
                let value = self.give(operand, parameter.ty, at)?;
                let place = self.held_value(value, at);
                return Some(self.address_of(place));
            }
            _ => {
                let message = format!("`{}` takes a variable, this is a value", parameter.shown);
                self.findings.error(Code::Output, at, message, "put the value into a variable first");
                return None;
            }
        };
        if let Some(why) = fixed.filter(|_| !parameter.constant) {
            let message = format!("`{}` may be changed, but this cannot: {why}", parameter.shown);
            self.findings.error(Code::ReadOnly, at, message, "pass a variable");
            return None;
        }
        if !self.reference_fits(ty, parameter.ty, parameter.constant) {
            if ty != super::WRONG && parameter.ty != super::WRONG {
                let message = format!(
                    "`{}` takes a variable of type {}, this is {}",
                    parameter.shown,
                    self.type_name(parameter.ty),
                    self.type_name(ty)
                );
                let help = "an in-out takes a variable of its own type";
                self.findings.error(Code::Type, at, message, help);
            }
            return None;
        }
        Some(self.address_of(place))
    }

    /// Whether a variable of one type can stand for one of another.
    pub(super) fn reference_fits(&self, from: TypeId, to: TypeId, read_only: bool) -> bool {
        if from == to {
            return from != super::WRONG;
        }
        match (self.ty(from), self.ty(to)) {
            (Type::Text { wide: a, length }, Type::Text { wide: b, length: needed }) => {
                a == b && (read_only || length >= needed)
            }
            (Type::Array { dimensions, of }, Type::Open { dimensions: number, of: needed }) => {
                dimensions.len() == *number as usize && of == needed
            }
            (Type::Subrange { base, .. }, Type::Elementary(ty)) => base == ty,
            (Type::Pointer(_), Type::Pointer(_)) => true,
            _ => self.block_extends(from, to),
        }
    }

    /// What an output is assigned to.
    fn output(&mut self, parameter: &CallParameter, negated: bool, target: &ast::Expr) -> Option<CallOutput> {
        let (target_place, ty) = self.target(target)?;
        let bool_type = self.elementary(Elementary::Bool);
        if negated && parameter.ty != bool_type {
            let message =
                format!("NOT needs BOOL, `{}` is {}", parameter.shown, self.type_name(parameter.ty));
            self.findings.error(Code::Type, target.at, message, "");
            return None;
        }
        // Whether the value goes there; the conversion itself is part of the output.
        let probe = TreePlace {
            root: crate::tree::TreeRoot::Frame,
            offset: 0,
            indices: Vec::new(),
            ty: self.tree_type(parameter.ty),
            retained: false,
            at: target.at,
        };
        let probe = Expr { kind: ExprKind::Load(probe), ty: self.tree_type(parameter.ty), at: target.at };
        self.assigned(probe, parameter.ty, ty, target.at)?;
        let _: &Target = &target_place;
        Some(CallOutput { from: parameter.slot.clone(), negated, target: target_place })
    }
}
