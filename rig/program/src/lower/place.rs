//! Places that are read and written: variables, members of instances, elements of arrays, addresses.

use super::fold::Operand;
use super::{Compiler, Home, Member, Symbol, Type};
use crate::code::Op;
use crate::codes::Code;
use crate::findings::{At, count, similar};
use crate::native::PinKind;
use crate::parse::ast::{Expr, ExprKind, Name, Path, PouKind, SectionKind, Segment};
use crate::program::{Located, Retention};
use crate::types::Elementary;
use signal::{Address, Area};

/// A place. Where it is `dynamic`, an offset to it is on the operand stack.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub home: Home,
    pub dynamic: bool,
    pub ty: Type,
    pub retention: Retention,
    /// Why it cannot be assigned to.
    pub fixed: Option<&'static str>,
    /// A direct address, whose bits have no sign.
    pub loose: bool,
}

/// What a path means.
#[derive(Clone, Copy, Debug)]
pub(super) enum Meaning {
    Constant(i128, Elementary),
    Place(Place),
    /// A unit of this place; of a PROGRAM or FUNCTION.
    Unit(u16),
    Wrong,
}

impl Compiler<'_> {
    /// The value of a path.
    pub(super) fn read_path(&mut self, path: &Path) -> Operand {
        match self.meaning(path) {
            Meaning::Constant(n, ty) => Operand::Known(n, ty),
            Meaning::Place(place) => self.load(&place, path.at),
            Meaning::Unit(unit) => {
                let pou = &self.pous[usize::from(unit)];
                let message = format!("`{}` is a {}, not a value", path.root.text, pou.kind.keyword());
                self.findings.error(Code::NotAValue, path.at, message, "");
                Operand::Wrong
            }
            Meaning::Wrong => Operand::Wrong,
        }
    }

    pub(super) fn read_direct(&mut self, text: &str, at: At) -> Operand {
        match self.direct(text, at) {
            Some(place) => self.load(&place, at),
            None => Operand::Wrong,
        }
    }

    fn direct(&mut self, text: &str, at: At) -> Option<Place> {
        let address = self.address(text, at)?;
        let ty = Elementary::of_size(address.size());
        let entry = self.locate(address, ty);
        Some(Place { loose: true, ..self.located_place(entry) })
    }

    /// The entry of a located place, new or old.
    pub(super) fn locate(&mut self, address: Address, ty: Elementary) -> u32 {
        let next = self.located.len() as u32;
        let entry = *self.located_index.entry((address, ty)).or_insert(next);
        if entry == next {
            self.located.push(Located {
                address,
                ty,
                read: false,
                written: false,
                declared: false,
                initial: None,
            });
        }
        entry
    }

    fn located_place(&self, entry: u32) -> Place {
        let located = &self.located[entry as usize];
        let fixed = (located.address.area() == Area::Input).then_some("inputs are read only");
        Place {
            home: Home::Located(entry),
            dynamic: false,
            ty: Type::One(located.ty),
            retention: Retention::None,
            fixed,
            loose: false,
        }
    }

    /// What is assigned to; reports what cannot be.
    pub(super) fn target(&mut self, expr: &Expr) -> Option<Place> {
        let place = match &expr.kind {
            ExprKind::Direct(text) => self.direct(text, expr.at)?,
            ExprKind::Path(path) => match self.meaning(path) {
                Meaning::Place(place) => place,
                Meaning::Wrong => return None,
                Meaning::Constant(..) => {
                    let message = format!("`{}` is a constant", path.root.text);
                    self.findings.error(Code::ReadOnly, expr.at, message, "assign to a variable");
                    return None;
                }
                Meaning::Unit(_) => {
                    let message = format!("`{}` is no variable", path.root.text);
                    self.findings.error(Code::ReadOnly, expr.at, message, "assign to a variable");
                    return None;
                }
            },
            _ => {
                self.findings.error(
                    Code::ReadOnly,
                    expr.at,
                    "a value cannot be assigned to",
                    "assign to a variable",
                );
                return None;
            }
        };
        if let Some(why) = place.fixed {
            self.findings.error(Code::ReadOnly, expr.at, format!("this cannot be assigned to: {why}"), "");
            return None;
        }
        Some(place)
    }

    /// The elementary type of a place; reports another.
    pub(super) fn elementary(&mut self, place: &Place, at: At) -> Option<Elementary> {
        let what = match place.ty {
            Type::One(ty) => return Some(ty),
            Type::Wrong => return None,
            Type::Array(_) => "an array as a whole",
            Type::Block(_) | Type::Native(_) => "an instance of a function block",
        };
        let help = match place.ty {
            Type::Array(_) => "name one element, as in a[1]",
            _ => "name one of its outputs, as in t1.Q",
        };
        self.findings.error(Code::NotAValue, at, format!("this is {what}, not a value"), help);
        None
    }

    /// Reads a place onto the operand stack.
    pub(super) fn load(&mut self, place: &Place, at: At) -> Operand {
        let Some(ty) = self.elementary(place, at) else { return Operand::Wrong };
        let op = match (place.home, place.dynamic) {
            (Home::Absolute(at), false) => Op::Load(at),
            (Home::Absolute(at), true) => Op::LoadAt(at),
            (Home::Member(at), false) => Op::LoadThis(at),
            (Home::Member(at), true) => Op::LoadThisAt(at),
            (Home::Frame(at), false) => Op::LoadLocal(at),
            (Home::Frame(at), true) => Op::LoadLocalAt(at),
            (Home::Located(entry), _) => {
                self.located[entry as usize].read = true;
                Op::LoadIo(entry)
            }
        };
        let cost = self.options.costs.load(ty) + self.kept(place);
        self.emit(op, cost, at);
        Operand::Stack { ty, loose: place.loose }
    }

    /// Writes the operand stack's top to a place. The offset of a dynamic place is below it.
    pub(super) fn store(&mut self, place: &Place, ty: Elementary, at: At) {
        let op = match (place.home, place.dynamic) {
            (Home::Absolute(at), false) => Op::Store(at),
            (Home::Absolute(at), true) => Op::StoreAt(at),
            (Home::Member(at), false) => Op::StoreThis(at),
            (Home::Member(at), true) => Op::StoreThisAt(at),
            (Home::Frame(at), false) => Op::StoreLocal(at),
            (Home::Frame(at), true) => Op::StoreLocalAt(at),
            (Home::Located(entry), _) => {
                self.located[entry as usize].written = true;
                self.context.writes.push(entry);
                Op::StoreIo(entry)
            }
        };
        let cost = self.options.costs.store(ty) + self.kept(place);
        self.emit(op, cost, at);
    }

    fn kept(&self, place: &Place) -> u32 {
        if place.retention == Retention::None { 0 } else { self.options.costs.retained }
    }

    /// What a path means. Indices that are not constant are emitted.
    pub(super) fn meaning(&mut self, path: &Path) -> Meaning {
        let own = self.context.pou;
        let symbol = own
            .and_then(|pou| self.pous[pou].scope.get(&path.root.key))
            .or_else(|| self.globals.get(&path.root.key))
            .map(|member| member.symbol);
        let (mut place, mut rest) = match symbol {
            Some(Symbol::Constant(n, ty)) => {
                if let Some(segment) = path.rest.first() {
                    self.no_member(&path.root.text, segment);
                    return Meaning::Wrong;
                }
                return Meaning::Constant(n, ty);
            }
            Some(Symbol::Variable { ty, home, retention, constant }) => {
                (self.variable_place(ty, home, retention, constant), path.rest.as_slice())
            }
            None => match (self.pou_index.get(&path.root.key).copied(), path.rest.split_first()) {
                (Some(unit), None) => return Meaning::Unit(unit as u16),
                (Some(unit), Some((Segment::Member(name), rest)))
                    if self.pous[unit].kind == PouKind::Program =>
                {
                    match self.program_member(unit, name) {
                        Meaning::Place(place) => (place, rest),
                        other => return other,
                    }
                }
                _ => {
                    self.unknown(&path.root);
                    return Meaning::Wrong;
                }
            },
        };
        if let Home::Located(entry) = place.home {
            place = self.located_place(entry);
        }
        while let Some((segment, after)) = rest.split_first() {
            let next = match segment {
                Segment::Member(name) => self.member(place, name),
                Segment::Index(indices, at) => self.index(place, indices, *at),
            };
            let Some(next) = next else { return Meaning::Wrong };
            (place, rest) = (next, after);
        }
        if place.ty == Type::Wrong { Meaning::Wrong } else { Meaning::Place(place) }
    }

    fn variable_place(&self, ty: Type, home: Home, retention: Retention, constant: bool) -> Place {
        let fixed = constant.then_some("it is a constant");
        Place { home, dynamic: false, ty, retention, fixed, loose: false }
    }

    fn no_member(&mut self, of: &str, segment: &Segment) {
        let (at, what) = match segment {
            Segment::Member(name) => (name.at, "members"),
            Segment::Index(_, at) => (*at, "elements"),
        };
        self.findings.error(Code::NotAValue, at, format!("`{of}` has no {what}"), "");
    }

    fn unknown(&mut self, name: &Name) {
        let own = self.context.pou.map(|pou| &self.pous[pou].scope);
        let known = own.into_iter().chain([&self.globals]).flat_map(|scope| scope.index.keys());
        let near = similar(&name.key, known.chain(self.pou_index.keys()).map(String::as_str));
        let help = near
            .map_or("declare it in VAR".to_string(), |near| format!("did you mean {}?", self.written(&near)));
        self.findings.error(Code::UnknownName, name.at, format!("`{}` is not known", name.text), help);
    }

    /// A name as it was declared.
    fn written(&self, key: &str) -> String {
        let own =
            self.context.pou.and_then(|pou| self.pous[pou].scope.get(key)).or_else(|| self.globals.get(key));
        let unit = self.pou_index.get(key).map(|pou| &self.pous[*pou].name);
        own.map(|member| &member.name).or(unit).map_or(key.to_string(), String::clone)
    }

    /// A variable of another program.
    fn program_member(&mut self, unit: usize, name: &Name) -> Meaning {
        match self.pous[unit].scope.get(&name.key).map(|member| (member.symbol, member.kind)) {
            Some((Symbol::Constant(n, ty), _)) => Meaning::Constant(n, ty),
            Some((Symbol::Variable { ty, home, retention, constant }, kind)) => {
                let mut place = match home {
                    Home::Located(entry) => self.located_place(entry),
                    _ => self.variable_place(ty, home, retention, constant),
                };
                if kind != SectionKind::Input {
                    place.fixed = Some("only inputs of another program can be");
                }
                Meaning::Place(place)
            }
            None => {
                let keys = self.pous[unit].scope.index.keys().map(String::as_str);
                self.unknown_member(name, similar(&name.key, keys), &self.pous[unit].name.clone());
                Meaning::Wrong
            }
        }
    }

    fn unknown_member(&mut self, name: &Name, near: Option<String>, of: &str) {
        let help = near.map_or(String::new(), |near| format!("did you mean {near}?"));
        self.findings.error(Code::UnknownName, name.at, format!("`{of}` has no `{}`", name.text), help);
    }

    /// A member of an instance.
    fn member(&mut self, place: Place, name: &Name) -> Option<Place> {
        match place.ty {
            Type::Block(block) => {
                let pou = &self.pous[usize::from(block)];
                let Some(member) = pou.scope.get(&name.key) else {
                    let near = similar(&name.key, pou.scope.index.keys().map(String::as_str));
                    let of = pou.name.clone();
                    self.unknown_member(name, near, &of);
                    return None;
                };
                let member = member.clone();
                self.block_member(place, &member, name)
            }
            Type::Native(native) => {
                let native = self.native(native)?;
                let pins = native.pins.iter().enumerate().filter(|(_, pin)| pin.kind != PinKind::Hidden);
                match pins.clone().find(|(_, pin)| pin.name == name.key.as_str()) {
                    Some((offset, pin)) => {
                        let fixed = (pin.kind == PinKind::Output).then_some("it is an output of the block");
                        Some(Place { fixed, ..inside(place, offset as u32, Type::One(pin.ty)) })
                    }
                    None => {
                        let names: Vec<&str> = pins.map(|(_, pin)| pin.name).collect();
                        let help = format!("{} has {}", native.name, names.join(", "));
                        let message = format!("`{}` has no `{}`", native.name, name.text);
                        self.findings.error(Code::UnknownName, name.at, message, help);
                        None
                    }
                }
            }
            Type::Wrong => None,
            Type::One(_) | Type::Array(_) => {
                let message =
                    format!("there is no member `{}`: this is no instance of a function block", name.text);
                self.findings.error(Code::NotAValue, name.at, message, "");
                None
            }
        }
    }

    fn block_member(&mut self, place: Place, member: &Member, name: &Name) -> Option<Place> {
        let Symbol::Variable { ty, home: Home::Member(offset), retention, constant } = member.symbol else {
            let message = format!("the constant `{}` belongs to the block alone", name.text);
            self.findings.error(Code::NotAValue, name.at, message, "");
            return None;
        };
        let fixed = match member.kind {
            _ if constant => Some("it is a constant"),
            SectionKind::Input => None,
            SectionKind::Output => Some("it is an output of the block"),
            SectionKind::Local | SectionKind::Global => Some("it belongs to the block alone"),
        };
        let inner = inside(place, offset, ty);
        Some(Place { fixed, retention: inner.retention.max(retention), ..inner })
    }

    /// An element of an array. A dynamic index leaves its offset on the operand stack.
    fn index(&mut self, place: Place, indices: &[Expr], at: At) -> Option<Place> {
        let Type::Array(array) = place.ty else {
            if place.ty != Type::Wrong {
                self.findings.error(Code::Index, at, "this is no array", "");
            }
            return None;
        };
        let array = self.arrays.get(array as usize)?.clone();
        if indices.len() != array.dimensions.len() {
            let message = format!(
                "the array has {}, not {}",
                count(array.dimensions.len(), "dimension"),
                indices.len()
            );
            self.findings.error(Code::Index, at, message, "give one index for each");
            return None;
        }
        let (mut offset, mut dynamic) = (0i64, place.dynamic);
        for (nth, index) in indices.iter().enumerate() {
            let entry = array.bounds + nth as u32;
            let bounds = *self.bounds.get(entry as usize)?;
            let operand = self.expr(index);
            match (operand.known(), operand.ty()) {
                (_, None) => return None,
                (_, Some(ty)) if !ty.is_integer() => {
                    self.findings.error(
                        Code::Index,
                        index.at,
                        format!("an index cannot be {}", ty.name()),
                        "",
                    );
                    return None;
                }
                (Some(n), _) => {
                    if n < i128::from(bounds.low) || n > i128::from(bounds.high) {
                        let message = format!("the index {n} is outside {}..{}", bounds.low, bounds.high);
                        self.findings.error(Code::Index, index.at, message, "");
                        return None;
                    }
                    offset += (n as i64 - bounds.low) * i64::from(bounds.stride);
                }
                (None, Some(_)) => {
                    self.emit(Op::Index(entry), self.options.costs.index, index.at);
                    if dynamic {
                        self.emit(Op::Add(Elementary::Lint), 0, index.at);
                    }
                    dynamic = true;
                }
            }
        }
        Some(Place { dynamic, ..inside(place, offset as u32, array.of) })
    }
}

/// A part of a place, `offset` cells behind its start.
pub(super) fn inside(place: Place, offset: u32, ty: Type) -> Place {
    let home = match place.home {
        Home::Absolute(at) => Home::Absolute(at + offset),
        Home::Member(at) => Home::Member(at + offset),
        Home::Frame(at) => Home::Frame(at + offset),
        Home::Located(entry) => Home::Located(entry),
    };
    Place { home, ty, ..place }
}
