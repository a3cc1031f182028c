//! What is known only when all units are there: circles of calls, sizes, the table of variables, the digest.

use super::{Compiler, Home, Scope, Symbol, Type};
use crate::code::Need;
use crate::codes::Code;
use crate::findings::At;
use crate::fuse::fuse;
use crate::machine::OPERANDS;
use crate::native::PinKind;
use crate::parse::ast::PouKind;
use crate::program::{Program, Retention, Storage, VarRef, Variable};
use document::{Diagnostic, SourceFile};
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::fmt::Write;

/// Variables that the table holds.
const MAX_VARIABLES: usize = 200_000;

/// Lets the hash take formatted text.
struct Hasher(Sha256);

impl Write for Hasher {
    fn write_str(&mut self, text: &str) -> std::fmt::Result {
        self.0.update(text.as_bytes());
        Ok(())
    }
}

impl Compiler<'_> {
    pub(super) fn finish(mut self, sources: &[SourceFile]) -> Result<Program, Vec<Diagnostic>> {
        self.needs();
        let variables = self.table();
        let kept =
            self.cells.retention.iter().zip(&self.cells.types).filter(|(kept, _)| **kept != Retention::None);
        let bytes: usize = kept.map(|(_, ty)| ty.bytes()).sum();
        // The image carries eight bytes of its own.
        if bytes > 0 && bytes + 8 > self.options.limits.retained {
            let message = format!("the retained variables need {} bytes", bytes + 8);
            let help = format!("the controller keeps {}", self.options.limits.retained);
            self.findings.error(Code::RetainedSize, At::default(), message, help);
        }
        if self.findings.failed() {
            return Err(self.findings.finish());
        }
        let programs: Vec<u16> = (0..self.pous.len())
            .filter(|place| self.pous[*place].kind == PouKind::Program)
            .map(|place| place as u16)
            .collect();
        let mut program = Program {
            program_names: programs.iter().map(|place| self.pous[usize::from(*place)].name.clone()).collect(),
            programs,
            code: fuse(&self.code),
            plain: self.code,
            wide: self.wide,
            bounds: self.bounds,
            units: self.units,
            natives: self.options.blocks.iter().collect(),
            located: self.located,
            initial: self.cells.initial,
            types: self.cells.types,
            retention: self.cells.retention,
            index: BTreeMap::new(),
            variables,
            files: sources.iter().map(|source| source.name.clone()).collect(),
            digest: [0; 32],
            layout: [0; 8],
            warnings: self.findings.finish(),
        };
        program.index = index(&program);
        program.digest = digest(&program);
        program.layout = layout(&program);
        Ok(program)
    }

    /// Room that each unit needs with all that it calls; reports circles of calls.
    fn needs(&mut self) {
        let count = self.units.len();
        let mut waiting: Vec<usize> = vec![0; count];
        let mut callers: Vec<Vec<usize>> = vec![Vec::new(); count];
        for (caller, calls) in self.calls.iter().enumerate() {
            for (callee, _) in calls.iter().filter(|(callee, _)| usize::from(*callee) < count) {
                waiting[caller] += 1;
                callers[usize::from(*callee)].push(caller);
            }
        }
        let mut ready: Vec<usize> = (0..count).filter(|unit| waiting[*unit] == 0).collect();
        let mut done = 0;
        while let Some(unit) = ready.pop() {
            done += 1;
            let mut need = self.units[unit].need;
            for (callee, operands) in &self.calls[unit] {
                let inner =
                    self.units.get(usize::from(*callee)).map_or(Need::default(), |callee| callee.need);
                need.operands = need.operands.max(operands + inner.operands + 1);
                need.frame = need.frame.max(self.units[unit].frame + inner.frame);
                need.calls = need.calls.max(inner.calls + 1);
            }
            self.units[unit].need = need;
            if need.operands as usize >= OPERANDS {
                let message = format!(
                    "an expression in `{}` keeps {} values at a time",
                    self.units[unit].name, need.operands
                );
                let at = self.pous[unit].at;
                self.findings.error(
                    Code::Depth,
                    at,
                    message,
                    "compute parts of it in statements of their own",
                );
                return;
            }
            for caller in std::mem::take(&mut callers[unit]) {
                waiting[caller] -= 1;
                if waiting[caller] == 0 {
                    ready.push(caller);
                }
            }
        }
        if done < count
            && let Some(unit) = self.in_circle(&waiting)
        {
            let pou = &self.pous[unit];
            let message = format!("`{}` calls itself, directly or through others", pou.name);
            self.findings.error(Code::Recursion, pou.at, message, "IEC 61131-3 has no recursion: use a loop");
        }
    }

    /// A unit of a circle of calls, among those that still wait.
    fn in_circle(&self, waiting: &[usize]) -> Option<usize> {
        let mut unit = waiting.iter().position(|n| *n > 0)?;
        // Every waiting unit calls a waiting one: after as many steps as there are units, the walk is in a circle.
        let next = |unit: usize| {
            let mut callees = self.calls.get(unit)?.iter().map(|(callee, _)| usize::from(*callee));
            callees.find(|callee| waiting.get(*callee).is_some_and(|n| *n > 0))
        };
        for _ in 0..waiting.len() {
            unit = next(unit)?;
        }
        let (start, mut first) = (unit, unit);
        loop {
            unit = next(unit)?;
            first = first.min(unit);
            if unit == start {
                return Some(first);
            }
        }
    }

    /// All variables, instances opened up.
    fn table(&mut self) -> Vec<Variable> {
        let mut table = Vec::new();
        let mut complete = self.list(&self.globals, "", 0, None, &mut table);
        for pou in self.pous.iter().filter(|pou| pou.kind == PouKind::Program) {
            complete &= self.list(&pou.scope, &pou.name, 0, None, &mut table);
        }
        if !complete {
            let message = format!("the application has more than {MAX_VARIABLES} named variables");
            self.findings.error(Code::DataSize, At::default(), message, "use arrays");
        }
        table
    }

    /// The variables of a scope; FALSE where there are too many. Members of an instance are `first` cells into the memory.
    fn list(
        &self,
        scope: &Scope,
        prefix: &str,
        first: u32,
        kept: Option<Retention>,
        table: &mut Vec<Variable>,
    ) -> bool {
        scope.members.iter().all(|member| {
            let Symbol::Variable { ty, home, retention, .. } = member.symbol else { return true };
            let path =
                if prefix.is_empty() { member.name.clone() } else { format!("{prefix}.{}", member.name) };
            let retention = retention.max(kept.unwrap_or_default());
            match home {
                Home::Absolute(at) | Home::Member(at) => {
                    self.open(ty, path, first + at, retention, member.at.file, table)
                }
                Home::Located(entry) => {
                    let Some(located) = self.located.get(entry as usize) else { return true };
                    table.push(Variable {
                        path,
                        ty: located.ty,
                        dimensions: Vec::new(),
                        retention,
                        storage: Storage::Located(located.address),
                        file: member.at.file,
                    });
                    table.len() <= MAX_VARIABLES
                }
                Home::Frame(_) => true,
            }
        })
    }

    fn open(
        &self,
        ty: Type,
        path: String,
        cell: u32,
        retention: Retention,
        file: u8,
        table: &mut Vec<Variable>,
    ) -> bool {
        let storage = Storage::Cell(VarRef(cell));
        let mut one = |ty, path, dimensions, storage| {
            table.push(Variable { path, ty, dimensions, retention, storage, file });
            table.len() <= MAX_VARIABLES
        };
        match ty {
            Type::One(ty) => one(ty, path, Vec::new(), storage),
            Type::Native(native) => {
                let pins = self.native(native).map_or(&[][..], |native| native.pins).iter().enumerate();
                pins.filter(|(_, pin)| pin.kind != PinKind::Hidden).all(|(offset, pin)| {
                    let storage = Storage::Cell(VarRef(cell + offset as u32));
                    one(pin.ty, format!("{path}.{}", pin.name), Vec::new(), storage)
                })
            }
            // A block without cells may be inside others very many times.
            Type::Block(_) if self.size(ty) == 0 => true,
            Type::Block(block) => {
                let scope = self.pous.get(usize::from(block)).map(|pou| &pou.scope);
                scope.is_none_or(|scope| self.list(scope, &path, cell, Some(retention), table))
            }
            Type::Array(array) => {
                let Some(array) = self.arrays.get(array as usize) else { return true };
                if let Type::One(ty) = array.of {
                    return one(ty, path, array.dimensions.clone(), storage);
                }
                let size = self.size(array.of);
                let count = array.size.checked_div(size).unwrap_or(0);
                (0..count).all(|nth| {
                    let path = format!("{path}[{}]", indices(&array.dimensions, nth));
                    self.open(array.of, path, cell + nth * size, retention, file, table)
                })
            }
            Type::Wrong => true,
        }
    }
}

/// The indices of the `nth` element.
fn indices(dimensions: &[(i64, i64)], nth: u32) -> String {
    let mut rest = i64::from(nth);
    let mut list: Vec<String> = Vec::new();
    for (low, high) in dimensions.iter().rev() {
        let width = high - low + 1;
        list.push((low + rest % width).to_string());
        rest /= width;
    }
    list.reverse();
    list.join(",")
}

/// Full paths, and short ones where the first name is that of a program.
fn index(program: &Program) -> BTreeMap<String, Option<u32>> {
    let mut index: BTreeMap<String, Option<u32>> = BTreeMap::new();
    let paths: Vec<String> =
        program.variables.iter().map(|variable| variable.path.to_ascii_uppercase()).collect();
    let units: Vec<String> = program.program_names.iter().map(|name| name.to_ascii_uppercase()).collect();
    for (place, path) in paths.iter().enumerate() {
        if let Some((unit, short)) = path.split_once('.')
            && units.iter().any(|name| name == unit)
        {
            index.entry(short.to_string()).and_modify(|entry| *entry = None).or_insert(Some(place as u32));
        }
    }
    // Full paths come last: they go before short ones.
    for (place, path) in paths.into_iter().enumerate() {
        index.insert(path, Some(place as u32));
    }
    index
}

/// Behaviour and variables. Writing to a hash cannot fail.
fn digest(program: &Program) -> [u8; 32] {
    let mut hasher = Hasher(Sha256::new());
    for step in &program.plain {
        let _ = write!(hasher, "{:?},{};", step.op, step.cost);
    }
    for unit in &program.units {
        let _ =
            write!(hasher, "{:?};", (unit.entry, unit.frame, unit.inputs, &unit.template, unit.has_result));
    }
    let _ = write!(hasher, "{:?}{:?}{:?}", program.wide, program.bounds, program.located);
    let _ = write!(hasher, "{:?}{:?}{:?}", program.initial, program.types, program.retention);
    for variable in &program.variables {
        let _ =
            write!(hasher, "{:?};", (&variable.path, variable.ty, &variable.dimensions, &variable.storage));
    }
    let _ = write!(hasher, "{:?}", (&program.programs, &program.program_names));
    for native in &program.natives {
        let _ = write!(hasher, "{};", native.name);
    }
    hasher.0.finalize().into()
}

/// Names and types of what is retained, in their order.
fn layout(program: &Program) -> [u8; 8] {
    let mut hasher = Hasher(Sha256::new());
    for variable in program.variables.iter().filter(|variable| variable.retention != Retention::None) {
        let path = variable.path.to_ascii_uppercase();
        let _ = write!(hasher, "{:?};", (path, variable.ty, &variable.dimensions, variable.retention));
    }
    let kept = program.retention.iter().zip(&program.types).filter(|(kept, _)| **kept != Retention::None);
    let _ = write!(hasher, "{:?}", kept.map(|(_, ty)| *ty).collect::<Vec<_>>());
    let digest: [u8; 32] = hasher.0.finalize().into();
    let mut layout = [0; 8];
    layout.copy_from_slice(&digest[..8]);
    layout
}
