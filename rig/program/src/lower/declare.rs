//! Declarations: names, types, places and initial values.

use super::layout::Cells;
use super::{ArrayType, Compiler, Home, Member, Pou, Progress, Scope, Symbol, Type};
use crate::code::Bounds;
use crate::codes::Code;
use crate::findings::{At, similar};
use crate::parse::ast::{self, Initial, Name, PouKind, Section, SectionKind, TypeRef, VarDecl};
use crate::program::Retention;
use crate::types::Elementary;

/// Blocks inside each other.
const MAX_LEVEL: u32 = 64;

impl Compiler<'_> {
    /// Reads all declarations.
    pub(super) fn declare(&mut self, tree: &ast::Unit) {
        for pou in &tree.pous {
            self.announce(pou);
        }
        if tree.pous.len() > usize::from(u16::MAX) {
            let message = format!("{} units are too many", tree.pous.len());
            self.findings.error(Code::SourceSize, At::default(), message, "an application has at most 65535");
            return;
        }
        // Constants first: bounds of arrays anywhere may use them.
        let mut cells = Cells::default();
        for pass in [true, false] {
            for section in tree.globals.iter().filter(|section| section.constant == pass) {
                self.globals_section(section, tree, &mut cells);
            }
        }
        self.cells = cells;
        for place in 0..tree.pous.len() {
            self.declare_pou(place, tree, None);
        }
        if !tree.pous.iter().any(|pou| pou.kind == PouKind::Program) && !self.findings.failed() {
            let help = "a task runs programs: write PROGRAM name ... END_PROGRAM";
            self.findings.error(Code::NoProgram, At::default(), "the sources have no PROGRAM", help);
        }
    }

    /// Makes the name of a unit known.
    fn announce(&mut self, pou: &ast::Pou) {
        let place = self.pous.len();
        self.pous.push(Pou {
            kind: pou.kind,
            name: pou.name.text.clone(),
            at: pou.name.at,
            scope: Scope::default(),
            progress: Progress::Waiting,
            result: Type::Wrong,
            cells: Cells::default(),
            level: 1,
        });
        let key = &pou.name.key;
        let native = self.options.blocks.iter().any(|native| native.name == key.as_str());
        if Elementary::named(key).is_some() || native || super::standard::is_function(key) {
            let message = format!("`{}` belongs to the language", pou.name.text);
            self.findings.error(Code::Reserved, pou.name.at, message, "choose another name");
        } else if let Some(other) = self.pou_index.get(key).and_then(|other| self.pous.get(*other)) {
            let other = (other.at, "declared here first");
            let message = format!("`{}` is declared twice", pou.name.text);
            self.findings.error_with(Code::Duplicate, pou.name.at, message, "rename one of them", other);
        } else {
            self.pou_index.insert(key.clone(), place);
        }
    }

    fn globals_section(&mut self, section: &Section, tree: &ast::Unit, cells: &mut Cells) {
        for variable in &section.variables {
            if let Some(pou) = self.pou_index.get(&variable.name.key).and_then(|pou| self.pous.get(*pou)) {
                let other = (pou.at, "declared here");
                let message = format!("`{}` is the name of a unit", variable.name.text);
                self.findings.error_with(
                    Code::Duplicate,
                    variable.name.at,
                    message,
                    "rename one of them",
                    other,
                );
                continue;
            }
            self.variable(variable, section, PouKind::Program, tree, cells);
        }
    }

    /// Reads the declarations of a unit, once. `user` is where a variable of this type is declared.
    pub(super) fn declare_pou(&mut self, place: usize, tree: &ast::Unit, user: Option<At>) {
        let (Some(info), Some(pou)) = (self.pous.get_mut(place), tree.pous.get(place)) else { return };
        match (info.progress, user) {
            (Progress::Ready, _) => return,
            (Progress::Reading, Some(at)) => {
                let message = format!("the block `{}` contains itself", info.name);
                self.findings.error(Code::ContainsItself, at, message, "remove the instance");
                return;
            }
            (Progress::Reading, None) => return,
            (Progress::Waiting, Some(at)) if self.declaring >= MAX_LEVEL => {
                let message = format!("more than {MAX_LEVEL} blocks inside each other");
                self.findings.error(Code::Depth, at, message, "flatten the blocks");
                return;
            }
            (Progress::Waiting, _) => info.progress = Progress::Reading,
        }
        self.declaring += 1;
        let outer = self.context.pou.replace(place);
        let mut cells = match pou.kind {
            PouKind::Program => std::mem::take(&mut self.cells),
            PouKind::Function | PouKind::FunctionBlock => Cells::default(),
        };
        if let Some(result) = &pou.result {
            let ty = self.type_of(result, tree);
            if !matches!(ty, Type::One(_) | Type::Wrong) {
                let help = "a function returns one value of an elementary type";
                self.findings.error(
                    Code::Unsupported,
                    result.at(),
                    "such a result is not supported yet",
                    help,
                );
            }
            self.place_cells(&mut cells, Type::One(elementary(ty)), Retention::None, result.at());
            let symbol =
                Symbol::Variable { ty, home: Home::Frame(0), retention: Retention::None, constant: false };
            self.add(&pou.name, SectionKind::Local, symbol, false);
            if let Some(info) = self.pous.get_mut(place) {
                info.result = ty;
            }
        }
        // The inputs of a function come first, because its frame is filled with them.
        for inputs in [true, false] {
            for section in &pou.sections {
                if (section.kind == SectionKind::Input) == inputs && self.allowed(section, pou.kind) {
                    for variable in &section.variables {
                        self.variable(variable, section, pou.kind, tree, &mut cells);
                    }
                }
            }
        }
        match pou.kind {
            PouKind::Program => self.cells = cells,
            _ => self.pous[place].cells = cells,
        }
        self.pous[place].progress = Progress::Ready;
        self.declaring -= 1;
        self.context.pou = outer;
    }

    /// Whether such a section can be in such a unit; reports it otherwise.
    fn allowed(&mut self, section: &Section, kind: PouKind) -> bool {
        let at = section.at;
        if section.kind == SectionKind::Global {
            let message = format!("VAR_GLOBAL cannot be inside a {}", kind.keyword());
            self.findings.error(Code::Section, at, message, "move it outside");
            return false;
        }
        if kind == PouKind::Function && section.kind == SectionKind::Output {
            self.findings.error(Code::Unsupported, at, "VAR_OUTPUT of a function is not supported yet", "");
            return false;
        }
        if kind == PouKind::Function && section.retention != Retention::None {
            let message = "a function keeps nothing from call to call";
            self.findings.error(
                Code::Section,
                at,
                message,
                "remove RETAIN or PERSISTENT, or use a function block",
            );
            return false;
        }
        true
    }

    fn variable(
        &mut self,
        decl: &VarDecl,
        section: &Section,
        kind: PouKind,
        tree: &ast::Unit,
        cells: &mut Cells,
    ) {
        let name = &decl.name;
        if Elementary::named(&name.key).is_some() {
            let message = format!("`{}` belongs to the language", name.text);
            self.findings.error(Code::Reserved, name.at, message, "choose another name");
            return;
        }
        if section.constant && matches!(section.kind, SectionKind::Input | SectionKind::Output) {
            let message = format!("the parameter `{}` cannot be CONSTANT", name.text);
            self.findings.error(Code::Section, section.at, message, "declare constants in VAR CONSTANT");
            return;
        }
        if section.constant && section.retention != Retention::None {
            let message = format!("the constant `{}` cannot be RETAIN or PERSISTENT", name.text);
            self.findings.error(Code::Section, section.at, message, "a constant needs no keeping");
            return;
        }
        let ty = self.type_of(&decl.ty, tree);
        if let (Type::Block(block), Some(place)) = (self.element(ty), self.context.pou) {
            let level = self.pous[usize::from(block)].level + 1;
            if level > MAX_LEVEL {
                let message = format!("more than {MAX_LEVEL} blocks inside each other");
                self.findings.error(Code::Depth, name.at, message, "flatten the blocks");
                return;
            }
            self.pous[place].level = self.pous[place].level.max(level);
        }
        if kind == PouKind::Function && matches!(self.element(ty), Type::Block(_) | Type::Native(_)) {
            let message = format!("`{}` cannot be in a function: it would forget at every call", name.text);
            self.findings.error(Code::Section, name.at, message, "use a function block instead");
            return;
        }
        if kind == PouKind::Function
            && section.kind == SectionKind::Input
            && !matches!(ty, Type::One(_) | Type::Wrong)
        {
            self.findings.error(Code::Unsupported, decl.ty.at(), "such a parameter is not supported yet", "");
            return;
        }
        if let Some(address) = &decl.address {
            self.located_variable(decl, address, section, kind, ty);
            return;
        }
        if let (true, Type::One(ty)) = (section.constant, ty) {
            self.constant(decl, section.kind, ty);
            return;
        }
        if section.constant && decl.initial.is_none() {
            let message = format!("the constant `{}` has no value", name.text);
            self.findings.error(Code::ConstantValue, name.at, message, "give it one with :=");
        }
        let first = self.place_cells(cells, ty, section.retention, name.at);
        if let Some(initial) = &decl.initial {
            let values = self.initial_values(initial, ty);
            for (cell, value) in cells.initial.iter_mut().skip(first as usize).zip(values) {
                *cell = value;
            }
        }
        let home = match kind {
            PouKind::Program => Home::Absolute(first),
            PouKind::Function => Home::Frame(first),
            PouKind::FunctionBlock => Home::Member(first),
        };
        let symbol = Symbol::Variable { ty, home, retention: section.retention, constant: section.constant };
        self.add(name, section.kind, symbol, decl.initial.is_some());
    }

    fn constant(&mut self, decl: &VarDecl, kind: SectionKind, ty: Elementary) {
        let value = match &decl.initial {
            Some(Initial::One(value)) => self.constant_of(value, ty),
            Some(Initial::List(_, at)) => {
                self.findings.error(Code::InitialValue, *at, format!("{} takes one value", ty.name()), "");
                None
            }
            None => {
                let message = format!("the constant `{}` has no value", decl.name.text);
                self.findings.error(Code::ConstantValue, decl.name.at, message, "give it one with :=");
                None
            }
        };
        self.add(&decl.name, kind, Symbol::Constant(ty.number(value.unwrap_or(0)), ty), true);
    }

    pub(super) fn add(&mut self, name: &Name, kind: SectionKind, symbol: Symbol, given: bool) {
        let scope = match self.context.pou {
            Some(pou) => &mut self.pous[pou].scope,
            None => &mut self.globals,
        };
        if let Some(other) = scope.get(&name.key) {
            let other = (other.at, "declared here first");
            let message = format!("`{}` is declared twice", name.text);
            self.findings.error_with(Code::Duplicate, name.at, message, "rename one of them", other);
            return;
        }
        scope.index.insert(name.key.clone(), scope.members.len());
        scope.members.push(Member { name: name.text.clone(), at: name.at, kind, symbol, given });
    }

    /// The type of the elements of an array, else the type itself.
    pub(super) fn element(&self, ty: Type) -> Type {
        match ty {
            Type::Array(array) => self.arrays.get(array as usize).map_or(Type::Wrong, |array| array.of),
            other => other,
        }
    }

    fn type_of(&mut self, ty: &TypeRef, tree: &ast::Unit) -> Type {
        match ty {
            TypeRef::Named(name) => self.named_type(name, tree),
            TypeRef::Array { ranges, of, at } => {
                let of = self.named_type(of, tree);
                self.array_type(ranges, of, *at)
            }
        }
    }

    fn named_type(&mut self, name: &Name, tree: &ast::Unit) -> Type {
        if let Some(ty) = Elementary::named(&name.key) {
            return Type::One(ty);
        }
        if let Some(&place) = self.pou_index.get(&name.key) {
            if self.pous[place].kind == PouKind::FunctionBlock {
                self.declare_pou(place, tree, Some(name.at));
                return match self.pous[place].progress {
                    Progress::Ready => Type::Block(place as u16),
                    _ => Type::Wrong,
                };
            }
            let message = format!("`{}` is a {}, not a type", name.text, self.pous[place].kind.keyword());
            self.findings.error(
                Code::UnknownType,
                name.at,
                message,
                "variables are of elementary types or function blocks",
            );
            return Type::Wrong;
        }
        if let Some(native) = self.options.blocks.iter().position(|native| native.name == name.key.as_str()) {
            return Type::Native(native as u16);
        }
        let known = Elementary::ALL.iter().map(|ty| ty.name());
        let known = known.chain(self.options.blocks.iter().map(|native| native.name));
        let known = known.chain(self.pou_index.keys().map(String::as_str));
        let help = similar(&name.key, known).map_or(String::new(), |near| format!("did you mean {near}?"));
        self.findings.error(
            Code::UnknownType,
            name.at,
            format!("the type `{}` is not known", name.text),
            help,
        );
        Type::Wrong
    }

    fn array_type(&mut self, ranges: &[(ast::Expr, ast::Expr)], of: Type, at: At) -> Type {
        let mut dimensions = Vec::new();
        for (low, high) in ranges {
            let (low_at, bounds) =
                (low.at, (self.constant_of(low, Elementary::Dint), self.constant_of(high, Elementary::Dint)));
            let (Some(low), Some(high)) = bounds else { return Type::Wrong };
            if low > high {
                let message = format!("the lower bound {low} is above the upper bound {high}");
                self.findings.error(Code::ArrayBounds, low_at, message, "write the lower one first");
                return Type::Wrong;
            }
            dimensions.push((low, high));
        }
        let count = dimensions.iter().try_fold(1u64, |n, (low, high)| n.checked_mul((high - low + 1) as u64));
        let limit = u64::from(self.options.limits.cells);
        let size = count.and_then(|n| n.checked_mul(u64::from(self.size(of)))).filter(|n| *n <= limit);
        let (Some(size), true) = (size, count.is_some_and(|n| n <= limit)) else {
            let help = format!("an application has at most {limit} elementary variables");
            self.findings.error(Code::DataSize, at, "the array is too large", help);
            return Type::Wrong;
        };
        let bounds = self.bounds.len() as u32;
        let mut stride = self.size(of);
        for (low, high) in dimensions.iter().rev() {
            self.bounds.push(Bounds { low: *low, high: *high, stride });
            stride = stride.saturating_mul((high - low + 1) as u32);
        }
        self.bounds[bounds as usize..].reverse();
        self.arrays.push(ArrayType { of, dimensions, size: size as u32, bounds });
        Type::Array(self.arrays.len() as u32 - 1)
    }

    /// The cells that an initial value gives, from the first on.
    fn initial_values(&mut self, initial: &Initial, ty: Type) -> Vec<i64> {
        match (initial, ty) {
            (Initial::One(value), Type::One(ty)) => self.constant_of(value, ty).into_iter().collect(),
            (Initial::List(values, at), Type::Array(array)) => {
                let (of, size) = self.arrays.get(array as usize).map_or((Type::Wrong, 0), |a| (a.of, a.size));
                let Type::One(of) = of else {
                    self.findings.error(
                        Code::Unsupported,
                        *at,
                        "initial values of blocks are not supported yet",
                        "",
                    );
                    return Vec::new();
                };
                let mut cells = Vec::new();
                for (times, value) in values {
                    let times =
                        times.as_ref().map_or(Some(1), |times| self.constant_of(times, Elementary::Udint));
                    let (Some(times), Some(value)) = (times, self.constant_of(value, of)) else {
                        return cells;
                    };
                    if times > i64::from(size) - cells.len() as i64 {
                        let message = format!("more values than the {size} elements of the array");
                        self.findings.error(Code::InitialValue, *at, message, "remove the last ones");
                        return cells;
                    }
                    cells.extend(std::iter::repeat_n(value, times as usize));
                }
                cells
            }
            (_, Type::Wrong) => Vec::new(),
            (Initial::One(value), _) => {
                let (code, message, help) = match ty {
                    Type::Array(_) => {
                        (Code::InitialValue, "an array takes a list of values", "write it as in [1, 2, 3(0)]")
                    }
                    _ => (Code::Unsupported, "initial values of blocks are not supported yet", ""),
                };
                self.findings.error(code, value.at, message, help);
                Vec::new()
            }
            (Initial::List(_, at), _) => {
                self.findings.error(Code::InitialValue, *at, "a list of values needs an array", "");
                Vec::new()
            }
        }
    }
}

fn elementary(ty: Type) -> Elementary {
    match ty {
        Type::One(ty) => ty,
        _ => Elementary::Int,
    }
}
