//! Standard functions: conversions, selection, shifting (controller:LIB-01, library Standard).

use super::Compiler;
use super::fold::{Operand, common};
use crate::code::Op;
use crate::codes::Code;
use crate::findings::At;
use crate::parse::ast::{Argument, Expr, Name};
use crate::types::Elementary;

/// Names and parameters of the functions with parameters of their own; MIN and MAX take two or more.
const FUNCTIONS: &[(&str, &[&str])] = &[
    ("ABS", &["IN"]),
    ("MIN", &["IN1", "IN2"]),
    ("MAX", &["IN1", "IN2"]),
    ("LIMIT", &["MN", "IN", "MX"]),
    ("SEL", &["G", "IN0", "IN1"]),
    ("SHL", &["IN", "N"]),
    ("SHR", &["IN", "N"]),
    ("ROL", &["IN", "N"]),
    ("ROR", &["IN", "N"]),
];

/// Whether this is the name of a standard function, in capitals.
pub(super) fn is_function(key: &str) -> bool {
    FUNCTIONS.iter().any(|(name, _)| *name == key) || conversion(key).is_some()
}

/// Names for suggestions.
pub(super) fn names() -> impl Iterator<Item = &'static str> {
    FUNCTIONS.iter().map(|(name, _)| *name)
}

/// The types of `A_TO_B`, and of `TO_B`.
fn conversion(key: &str) -> Option<(Option<Elementary>, Elementary)> {
    if let Some(to) = key.strip_prefix("TO_") {
        return Some((None, Elementary::named(to)?));
    }
    let (from, to) = key.split_once("_TO_")?;
    Some((Some(Elementary::named(from)?), Elementary::named(to)?))
}

impl Compiler<'_> {
    /// Emits a call of a standard function; `None` where the name is none of one.
    pub(super) fn standard(&mut self, name: &Name, arguments: &[Argument], at: At) -> Option<Operand> {
        if let Some((from, to)) = conversion(&name.key) {
            let Some(values) = self.in_order(&["IN"], false, name, arguments) else {
                return Some(Operand::Wrong);
            };
            return Some(values.first().map_or(Operand::Wrong, |value| self.conversion(from, to, value, at)));
        }
        let (_, parameters) = FUNCTIONS.iter().find(|(known, _)| *known == name.key.as_str())?;
        let many = matches!(name.key.as_str(), "MIN" | "MAX");
        let Some(values) = self.in_order(parameters, many, name, arguments) else {
            return Some(Operand::Wrong);
        };
        Some(match name.key.as_str() {
            "ABS" => self.absolute(values[0], at),
            "MIN" | "MAX" => self.extremes(name.key == "MIN", &values, at),
            "LIMIT" => self.limit(&values, at),
            "SEL" => self.select(&values, at),
            _ => self.shift(&name.key, &values, at),
        })
    }

    /// The values of parameters in their order; reports what is missing, unknown or too much.
    fn in_order<'a>(
        &mut self,
        parameters: &[&str],
        many: bool,
        name: &Name,
        arguments: &'a [Argument],
    ) -> Option<Vec<&'a Expr>> {
        let positional: Vec<&Expr> = arguments
            .iter()
            .filter_map(|argument| match argument {
                Argument::Positional(value) => Some(value),
                _ => None,
            })
            .collect();
        if positional.len() == arguments.len()
            && (positional.len() == parameters.len() || many && positional.len() > parameters.len())
        {
            return Some(positional);
        }
        let mut values: Vec<Option<&Expr>> = vec![None; parameters.len()];
        let mut good = positional.is_empty() && arguments.len() == parameters.len();
        for argument in arguments {
            if let Argument::Input(parameter, value) = argument {
                match parameters.iter().position(|known| *known == parameter.key) {
                    Some(place) => values[place] = Some(value),
                    None => good = false,
                }
            }
        }
        if let (true, Some(values)) = (good, values.into_iter().collect::<Option<Vec<_>>>()) {
            return Some(values);
        }
        let message = format!("{} takes {}", name.key, parameters.join(", "));
        let help = if many { "MIN and MAX take two values or more, without names" } else { "give each once" };
        self.findings.error(Code::Arguments, name.at, message, help);
        None
    }

    fn conversion(&mut self, from: Option<Elementary>, to: Elementary, value: &Expr, at: At) -> Operand {
        let operand = self.expr(value);
        let from = match from {
            Some(from) => from,
            None => match operand.ty() {
                Some(ty) => ty,
                None => return Operand::Wrong,
            },
        };
        if !self.convert(operand, from, value.at) {
            return Operand::Wrong;
        }
        let wider = if from.bits() > to.bits() { from } else { to };
        let op = if to == Elementary::Bool { Op::Truth } else { Op::Wrap(to) };
        self.emit(op, self.options.costs.op(wider), at);
        Operand::stack(to)
    }

    /// Emits values that meet in one type; reports where there is none.
    fn together(&mut self, values: &[&Expr], at: At) -> Option<Elementary> {
        let (mut literals, mut all): (Vec<(Operand, At)>, Option<Operand>) = (Vec::new(), None);
        for value in values {
            let operand = self.expr(value);
            self.push(operand, value.at);
            match operand {
                Operand::Wrong => return None,
                Operand::Literal(_) => literals.push((operand, value.at)),
                typed => all = Some(self.meet(all, typed, value.at)?),
            }
        }
        // Literals take the type of the others, so they come last.
        for (literal, at) in literals {
            all = Some(self.meet(all, literal, at)?);
        }
        let ty = all.and_then(Operand::ty);
        if ty.is_none() {
            self.findings.error(Code::Range, at, "a value does not fit into 64 bits", "");
        }
        ty
    }

    /// The type that holds what was there before and one more.
    fn meet(&mut self, before: Option<Operand>, operand: Operand, at: At) -> Option<Operand> {
        let Some(before) = before else { return operand.ty().map(Operand::stack) };
        if let Some(ty) = common(before, operand) {
            return Some(Operand::stack(ty));
        }
        let (a, b) = (before.ty()?, operand.ty()?);
        let message = format!("{} and {} do not go together", a.name(), b.name());
        let help = format!("convert one of them, as with {}_TO_{}(...)", b.name(), a.name());
        self.findings.error(Code::Operator, at, message, help);
        None
    }

    fn absolute(&mut self, value: &Expr, at: At) -> Operand {
        let Some(ty) = self.together(&[value], at) else { return Operand::Wrong };
        if !ty.is_integer() {
            let message = format!("ABS is not defined for {}", ty.name());
            self.findings.error(Code::Operator, value.at, message, "");
            return Operand::Wrong;
        }
        let cost = self.options.costs.op(ty);
        self.emit(if ty.signed() { Op::Abs(ty) } else { Op::Wrap(ty) }, cost, at);
        Operand::stack(ty)
    }

    fn extremes(&mut self, least: bool, values: &[&Expr], at: At) -> Operand {
        let Some(ty) = self.together(values, at) else { return Operand::Wrong };
        for _ in 1..values.len() {
            self.emit(extreme(least, ty), self.options.costs.op(ty), at);
        }
        Operand::stack(ty)
    }

    /// MIN(MAX(IN, MN), MX), the last one winning where the limits cross.
    fn limit(&mut self, values: &[&Expr], at: At) -> Operand {
        let [low, value, high] = values else { return Operand::Wrong };
        let Some(ty) = self.together(&[high, value, low], at) else { return Operand::Wrong };
        self.emit(extreme(false, ty), self.options.costs.op(ty), at);
        self.emit(extreme(true, ty), self.options.costs.op(ty), at);
        Operand::stack(ty)
    }

    fn select(&mut self, values: &[&Expr], at: At) -> Operand {
        let [which, if_false, if_true] = values else { return Operand::Wrong };
        if !self.value(which, Elementary::Bool) {
            return Operand::Wrong;
        }
        let Some(ty) = self.together(&[if_false, if_true], at) else { return Operand::Wrong };
        self.emit(Op::Sel, self.options.costs.op(ty), at);
        Operand::stack(ty)
    }

    fn shift(&mut self, key: &str, values: &[&Expr], at: At) -> Operand {
        let [value, count] = values else { return Operand::Wrong };
        let operand = self.expr(value);
        let ty = match operand {
            Operand::Literal(_) => {
                let help = "give it one, as in WORD#16#1";
                self.findings.error(
                    Code::Operator,
                    value.at,
                    format!("{key} needs a value with a type"),
                    help,
                );
                return Operand::Wrong;
            }
            operand => match operand.ty() {
                Some(ty) if ty.is_integer() => ty,
                Some(ty) => {
                    let message = format!("{key} is not defined for {}", ty.name());
                    self.findings.error(Code::Operator, value.at, message, "");
                    return Operand::Wrong;
                }
                None => return Operand::Wrong,
            },
        };
        self.push(operand, value.at);
        if !self.value(count, Elementary::Lint) {
            return Operand::Wrong;
        }
        let op = match key {
            "SHL" => Op::Shl(ty),
            "SHR" => Op::Shr(ty),
            "ROL" => Op::Rol(ty),
            _ => Op::Ror(ty),
        };
        self.emit(op, self.options.costs.op(ty), at);
        Operand::stack(ty)
    }
}

fn extreme(least: bool, ty: Elementary) -> Op {
    match (least, ty.wide_unsigned()) {
        (true, false) => Op::Min,
        (true, true) => Op::MinWide,
        (false, false) => Op::Max,
        (false, true) => Op::MaxWide,
    }
}
