//! Calls of functions, function blocks, native blocks and programs.

use super::fold::Operand;
use super::place::{Meaning, Place, inside};
use super::{Compiler, Home, Member, Symbol, Type};
use crate::code::Op;
use crate::codes::Code;
use crate::findings::{At, count, similar};
use crate::native::PinKind;
use crate::parse::ast::{Argument, Expr, Name, Path, PouKind, SectionKind};
use crate::program::Retention;
use crate::types::Elementary;

/// A parameter of a block or program.
#[derive(Clone, Debug)]
struct Parameter {
    key: String,
    output: bool,
    /// Offset in the instance, or the place of the variable of a program.
    home: Home,
    ty: Type,
    retention: Retention,
}

/// An input of a function.
#[derive(Clone, Debug)]
struct Input {
    name: String,
    ty: Type,
    /// What it is where the call leaves it out.
    initial: Option<i64>,
}

impl Compiler<'_> {
    /// A call inside an expression.
    pub(super) fn call_function(&mut self, name: &Name, arguments: &[Argument], at: At) -> Operand {
        let unit = match self.pou_index.get(&name.key).copied() {
            Some(unit) if self.pous[unit].kind == PouKind::Function => unit,
            Some(unit) => {
                let kind = self.pous[unit].kind.keyword();
                let message = format!("`{}` is a {kind}: it has no value", name.text);
                self.findings.error(Code::NotCallable, name.at, message, "call it in a statement of its own");
                return Operand::Wrong;
            }
            None => {
                if let Some(result) = self.standard(name, arguments, at) {
                    return result;
                }
                self.unknown_function(name);
                return Operand::Wrong;
            }
        };
        if self.in_constant {
            self.findings.error(
                Code::NotConstant,
                at,
                "a constant is needed here",
                "the result of a function is none",
            );
            return Operand::Wrong;
        }
        let inputs = self.inputs(unit);
        let Some(values) = self.function_arguments(&inputs, name, arguments) else { return Operand::Wrong };
        for (value, input) in values.iter().zip(&inputs) {
            match (value, input.ty) {
                (Some(value), Type::One(ty)) => {
                    if !self.value(value, ty) {
                        return Operand::Wrong;
                    }
                }
                (None, _) => self.push_cell(input.initial.unwrap_or(0), at),
                _ => return Operand::Wrong,
            }
        }
        let Type::One(result) = self.pous[unit].result else { return Operand::Wrong };
        self.context.depth = self.context.depth.saturating_sub(inputs.len() as u32);
        self.context.calls.push((unit as u16, self.context.depth));
        self.emit(Op::CallFunction(unit as u16), self.options.costs.call, at);
        self.context.depth += 1;
        self.context.deepest = self.context.deepest.max(self.context.depth);
        Operand::stack(result)
    }

    fn unknown_function(&mut self, name: &Name) {
        let own = self.context.pou.and_then(|pou| self.pous[pou].scope.get(&name.key));
        if own.or_else(|| self.globals.get(&name.key)).is_some() {
            let message = format!("`{}` is no function", name.text);
            let help = "call an instance of a block in a statement of its own, then read its output";
            self.findings.error(Code::NotCallable, name.at, message, help);
            return;
        }
        let mut known: Vec<&str> = super::standard::names().collect();
        for (key, unit) in &self.pou_index {
            if self.pous[*unit].kind == PouKind::Function {
                known.push(key);
            }
        }
        let near = similar(&name.key, known.into_iter());
        let help = near.map_or(String::new(), |near| format!("did you mean {near}?"));
        self.findings.error(
            Code::UnknownName,
            name.at,
            format!("the function `{}` is not known", name.text),
            help,
        );
    }

    /// Inputs of a function, in the order of its frame.
    fn inputs(&self, unit: usize) -> Vec<Input> {
        let pou = &self.pous[unit];
        let members = pou.scope.members.iter().filter(|member| member.kind == SectionKind::Input);
        let input = |member: &Member| match member.symbol {
            Symbol::Variable { ty, home: Home::Frame(at), .. } => {
                let initial = pou.cells.initial.get(at as usize).copied().filter(|_| member.given);
                Some(Input { name: member.name.clone(), ty, initial })
            }
            _ => None,
        };
        members.filter_map(input).collect()
    }

    /// The value of each input, `None` for its initial value, in the order of the declaration, in which they are
    /// computed too.
    fn function_arguments<'a>(
        &mut self,
        inputs: &[Input],
        name: &Name,
        arguments: &'a [Argument],
    ) -> Option<Vec<Option<&'a Expr>>> {
        let mut values: Vec<Option<&Expr>> = vec![None; inputs.len()];
        for (nth, argument) in arguments.iter().enumerate() {
            let (place, value, at) = match argument {
                Argument::Positional(value) => (Some(nth).filter(|nth| *nth < inputs.len()), value, value.at),
                Argument::Input(input, value) => {
                    let place = inputs.iter().position(|known| known.name.eq_ignore_ascii_case(&input.key));
                    if place.is_none() {
                        let of = name.text.clone();
                        self.unknown_parameter(input, &of, inputs.iter().map(|i| i.name.clone()).collect());
                        return None;
                    }
                    (place, value, input.at)
                }
                Argument::Output(output, _) => {
                    let message = "outputs of functions are not supported yet";
                    self.findings.error(Code::Unsupported, output.at, message, "");
                    return None;
                }
            };
            match place.and_then(|place| values.get_mut(place)) {
                Some(slot @ None) => *slot = Some(value),
                Some(Some(_)) => {
                    self.findings.error(Code::Arguments, at, "this parameter is given twice", "");
                    return None;
                }
                None => {
                    let message = format!("`{}` has {}", name.text, count(inputs.len(), "input"));
                    self.findings.error(Code::Arguments, at, message, "remove what is too much");
                    return None;
                }
            }
        }
        let missing: Vec<&str> = inputs
            .iter()
            .zip(&values)
            .filter(|(input, value)| value.is_none() && input.initial.is_none())
            .map(|(input, _)| input.name.as_str())
            .collect();
        if !missing.is_empty() {
            let message = format!("`{}` needs a value for {}", name.text, missing.join(", "));
            self.findings.error(
                Code::Arguments,
                name.at,
                message,
                "only inputs with an initial value can be left out",
            );
            return None;
        }
        Some(values)
    }

    fn unknown_parameter(&mut self, name: &Name, of: &str, known: Vec<String>) {
        let help = match known.as_slice() {
            [] => format!("`{of}` has no such parameters"),
            known => format!("`{of}` has {}", known.join(", ")),
        };
        let message = format!("`{of}` has no parameter `{}`", name.text);
        self.findings.error(Code::UnknownParameter, name.at, message, help);
    }

    /// A call as a statement.
    pub(super) fn call_statement(&mut self, path: &Path, arguments: &[Argument], at: At) {
        let known = self.context.pou.and_then(|pou| self.pous[pou].scope.get(&path.root.key));
        let is_variable = known.or_else(|| self.globals.get(&path.root.key)).is_some();
        let unit = self.pou_index.get(&path.root.key).copied();
        let function = unit.is_none_or(|unit| self.pous[unit].kind == PouKind::Function);
        if path.rest.is_empty() && !is_variable && function {
            let result = self.call_function(&path.root, arguments, at);
            if matches!(result, Operand::Stack { .. }) {
                let unused = self.temporary();
                self.emit(Op::StoreLocal(unused), 0, at);
                self.context.frame -= 1;
            }
            return;
        }
        let instance = match self.meaning(path) {
            Meaning::Wrong => return,
            Meaning::Unit(unit) if self.pous[usize::from(unit)].kind == PouKind::Program => {
                self.call_block(None, Type::Block(unit), arguments, at);
                return;
            }
            Meaning::Place(place) if matches!(place.ty, Type::Block(_) | Type::Native(_)) => place,
            Meaning::Place(_) | Meaning::Constant(..) | Meaning::Unit(_) => {
                let message = format!("`{}` cannot be called", path.root.text);
                let help = "functions, programs and instances of function blocks can";
                self.findings.error(Code::NotCallable, path.at, message, help);
                return;
            }
        };
        if instance.fixed == Some("it belongs to the block alone") {
            self.findings.error(
                Code::NotCallable,
                path.at,
                "an inner instance of a block cannot be called here",
                "",
            );
            return;
        }
        self.call_block(Some(instance), instance.ty, arguments, at);
    }

    /// Inputs are assigned as they are written, then the body runs, then outputs are fetched as they are written.
    fn call_block(&mut self, instance: Option<Place>, ty: Type, arguments: &[Argument], at: At) {
        let frame = self.context.frame;
        // The offset of an element of an array of blocks is needed for each parameter.
        let offset = instance.filter(|place| place.dynamic).map(|_| {
            let offset = self.temporary();
            self.emit(Op::StoreLocal(offset), 0, at);
            offset
        });
        let (name, parameters) = self.parameters(ty);
        let inputs: Vec<usize> = (0..parameters.len()).filter(|nth| !parameters[*nth].output).collect();
        let mut given = vec![false; parameters.len()];
        for (nth, argument) in arguments.iter().enumerate() {
            let (place, value, at) = match argument {
                Argument::Positional(value) => (inputs.get(nth).copied(), value, value.at),
                Argument::Input(input, value) => {
                    match parameters.iter().position(|p| p.key == input.key && !p.output) {
                        Some(place) => (Some(place), value, input.at),
                        None => {
                            let keys = inputs.iter().map(|nth| parameters[*nth].key.clone()).collect();
                            self.unknown_parameter(input, &name, keys);
                            continue;
                        }
                    }
                }
                Argument::Output(..) => continue,
            };
            let Some(parameter) = place else {
                let message = format!("`{name}` has {}", count(inputs.len(), "input"));
                self.findings.error(Code::Arguments, at, message, "remove what is too much");
                continue;
            };
            if std::mem::replace(&mut given[parameter], true) {
                self.findings.error(Code::Arguments, at, "this parameter is given twice", "");
                continue;
            }
            let place = self.pin(instance, offset, &parameters[parameter], at);
            if let Some(ty) = self.elementary(&place, at)
                && self.value(value, ty)
            {
                self.store(&place, ty, at);
            }
        }
        self.emit_call(instance, offset, ty, at);
        for argument in arguments {
            let Argument::Output(output, target) = argument else { continue };
            let Some(parameter) = parameters.iter().find(|p| p.key == output.key && p.output) else {
                let keys = parameters.iter().filter(|p| p.output).map(|p| p.key.clone()).collect();
                self.unknown_parameter(output, &name, keys);
                continue;
            };
            let Some(target_place) = self.target(target) else { continue };
            let Some(ty) = self.elementary(&target_place, target.at) else { continue };
            let place = self.pin(instance, offset, parameter, output.at);
            let value = self.load(&place, output.at);
            if self.convert(value, ty, target.at) {
                self.store(&target_place, ty, target.at);
            }
        }
        self.context.frame = frame;
    }

    fn emit_call(&mut self, instance: Option<Place>, offset: Option<u32>, ty: Type, at: At) {
        if let Some(offset) = offset {
            self.emit(Op::LoadLocal(offset), 0, at);
        }
        let (first, this) = match instance.map(|place| place.home) {
            Some(Home::Member(first)) => (first, true),
            Some(Home::Absolute(first)) => (first, false),
            _ => (0, false),
        };
        let dynamic = offset.is_some();
        let (op, cost) = match ty {
            Type::Block(unit) => {
                self.context.calls.push((unit, self.context.depth));
                let op = match (this, dynamic) {
                    (false, false) => Op::CallBlock(unit, first),
                    (true, false) => Op::CallBlockThis(unit, first),
                    (false, true) => Op::CallBlockAt(unit, first),
                    (true, true) => Op::CallBlockThisAt(unit, first),
                };
                (op, self.options.costs.call)
            }
            Type::Native(native) => {
                let op = match (this, dynamic) {
                    (false, false) => Op::CallNative(native, first),
                    (true, false) => Op::CallNativeThis(native, first),
                    (false, true) => Op::CallNativeAt(native, first),
                    (true, true) => Op::CallNativeThisAt(native, first),
                };
                (op, self.options.costs.block)
            }
            _ => return,
        };
        self.emit(op, cost, at);
    }

    /// The place of a parameter; the offset of a dynamic instance goes onto the operand stack.
    fn pin(&mut self, instance: Option<Place>, offset: Option<u32>, parameter: &Parameter, at: At) -> Place {
        if let Some(offset) = offset {
            self.emit(Op::LoadLocal(offset), 0, at);
        }
        let own = Place {
            home: parameter.home,
            dynamic: false,
            ty: parameter.ty,
            retention: parameter.retention,
            fixed: None,
            loose: false,
        };
        match (instance, parameter.home) {
            (Some(instance), Home::Member(at)) => {
                let pin = inside(instance, at, parameter.ty);
                Place { retention: pin.retention.max(parameter.retention), fixed: None, ..pin }
            }
            _ => own,
        }
    }

    /// Name and parameters of a block or program.
    fn parameters(&self, ty: Type) -> (String, Vec<Parameter>) {
        match ty {
            Type::Block(unit) => {
                let pou = &self.pous[usize::from(unit)];
                let parameters =
                    pou.scope.members.iter().filter_map(|member| match (member.kind, member.symbol) {
                        (
                            SectionKind::Input | SectionKind::Output,
                            Symbol::Variable { ty, home, retention, .. },
                        ) => Some(Parameter {
                            key: member.name.to_ascii_uppercase(),
                            output: member.kind == SectionKind::Output,
                            home,
                            ty,
                            retention,
                        }),
                        _ => None,
                    });
                (pou.name.clone(), parameters.collect())
            }
            Type::Native(native) => {
                let Some(native) = self.native(native) else { return (String::new(), Vec::new()) };
                let pins = native.pins.iter().enumerate().filter(|(_, pin)| pin.kind != PinKind::Hidden);
                let parameters = pins.map(|(offset, pin)| Parameter {
                    key: pin.name.to_string(),
                    output: pin.kind == PinKind::Output,
                    home: Home::Member(offset as u32),
                    ty: Type::One(pin.ty),
                    retention: Retention::None,
                });
                (native.name.to_string(), parameters.collect())
            }
            _ => (String::new(), Vec::new()),
        }
    }
}

/// What conditions are.
pub(super) const CONDITION: Elementary = Elementary::Bool;
