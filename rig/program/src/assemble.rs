//! What a program knows of itself when its parts are there: the variables by their paths, the digest, the layout of
//! what is retained.

use crate::native::Native;
use crate::program::{Program, Retained, RetainedVariable, Variable};
use crate::shape::MemoryLayout;
use crate::walk::{Leaf, index, leaves};
use sha2::{Digest, Sha256};
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

impl Hasher {
    /// The first 8 bytes of the hash.
    fn short(self) -> [u8; 8] {
        let digest: [u8; 32] = self.0.finalize().into();
        let mut short = [0; 8];
        short.iter_mut().zip(digest).for_each(|(to, from)| *to = from);
        short
    }
}

/// Fills in what is derived.
pub(crate) fn finish(mut program: Program) -> Program {
    program.index = index(&program);
    let ImageLayout { retained, names, digest: layout } = retained(&program);
    program.retained = retained;
    program.kept = names;
    program.layout = layout;
    program.declarations = declarations(&program);
    program.variables = variables(&program);
    program.digest = digest(&program);
    program
}

/// The table of variables.
fn variables(program: &Program) -> Vec<Variable> {
    let mut table = Vec::new();
    leaves(program, &|_, _| true, &mut |leaf| {
        if let (Some(ty), Some(storage)) = (leaf.ty, leaf.storage()) {
            let dimensions = match program.shape(leaf.shape) {
                Some(MemoryLayout::Array { dimensions, .. }) => dimensions.clone(),
                _ => Vec::new(),
            };
            let retention = program.retention_at(leaf.address);
            table.push(Variable {
                path: leaf.path.to_owned(),
                ty,
                dimensions,
                retention,
                storage,
                file: leaf.root.file,
            });
        }
        table.len() < MAX_VARIABLES
    });
    table
}

/// What is retained.
struct ImageLayout {
    retained: Vec<Retained>,
    names: Vec<RetainedVariable>,
    digest: [u8; 8],
}

/// The retained bytes without those that mean nothing to another program - classes, addresses, gaps - the names and
/// types that they have, and the hash of these.
fn retained(program: &Program) -> ImageLayout {
    let mut kept: Vec<Retained> = Vec::new();
    let mut names: Vec<RetainedVariable> = Vec::new();
    let of = &program.retained;
    let within = |first: u32, end: u32| {
        let place = of.partition_point(|kept| kept.address.saturating_add(kept.bytes) <= first);
        of.get(place).is_some_and(|kept| kept.address < end)
    };
    let mut keep = |address: u32, bytes: u32, path: &str, shape: &str| {
        let place = of.partition_point(|kept| kept.address.saturating_add(kept.bytes) <= address);
        let Some(retention) = of.get(place).filter(|kept| kept.address <= address).map(|kept| kept.retention)
        else {
            return;
        };
        kept.push(Retained { address, bytes, retention });
        let name = format!("{} {shape} {retention:?}", path.to_ascii_uppercase());
        names.push(RetainedVariable { address, bytes, retention, name });
    };
    leaves(program, &within, &mut |leaf| {
        if let Some(shape) = shape_of(program, leaf) {
            keep(leaf.address, leaf.bytes, leaf.path, &shape);
        }
        true
    });
    names.sort_by(|one, other| (one.address, &one.name).cmp(&(other.address, &other.name)));
    let mut hasher = Hasher(Sha256::new());
    for RetainedVariable { name, .. } in &names {
        let _ = write!(hasher, "{name};");
    }
    ImageLayout { retained: merged(kept), names, digest: hasher.short() }
}

/// The type of a variable as text; nothing for an address, which means nothing to another program.
fn shape_of(program: &Program, leaf: &Leaf<'_>) -> Option<String> {
    match program.shape(leaf.shape)? {
        MemoryLayout::Address => None,
        MemoryLayout::Array { dimensions, .. } => Some(format!("{:?} {dimensions:?}", leaf.ty)),
        MemoryLayout::Text { wide, length } => Some(format!("{wide} {length}")),
        MemoryLayout::Members { name, .. } => Some(name.clone()),
        _ => Some(format!("{:?}", leaf.ty)),
    }
}

/// What is declared: variables with their types, initial values and what becomes of them, wherever they lie.
fn declarations(program: &Program) -> [u8; 8] {
    let mut hasher = Hasher(Sha256::new());
    leaves(program, &|_, _| true, &mut |leaf| {
        let shape = shape_of(program, leaf).unwrap_or_default();
        let retention = program.retention_at(leaf.address);
        let _ = write!(hasher, "{} {shape} {retention:?};", leaf.path.to_ascii_uppercase());
        let (first, end) = (leaf.address as usize, (leaf.address + leaf.bytes) as usize);
        if !shape.is_empty() {
            hasher.0.update(program.image.get(first..end).unwrap_or_default());
        }
        true
    });
    let _ = write!(hasher, "{:?}", program.located);
    hasher.short()
}

/// Sorted and disjoint, neighbours joined. Members of a union are kept once.
fn merged(mut kept: Vec<Retained>) -> Vec<Retained> {
    kept.sort_by_key(|kept| (kept.address, kept.bytes));
    let mut all: Vec<Retained> = Vec::new();
    for next in kept {
        let end = next.address.saturating_add(next.bytes);
        match all.last_mut() {
            Some(last) if last.retention == next.retention && last.address + last.bytes >= next.address => {
                last.bytes = last.bytes.max(end - last.address);
            }
            Some(last) if last.address + last.bytes > next.address => {}
            _ => all.push(next),
        }
    }
    all
}

/// Behaviour and variables, without lines and the names of files. Writing to a hash cannot fail.
fn digest(program: &Program) -> [u8; 32] {
    let mut hasher = Hasher(Sha256::new());
    for step in &program.code {
        for word in [u32::from(step.op as u16), step.a, step.b, step.c, step.cost] {
            hasher.0.update(word.to_le_bytes());
        }
    }
    for unit in &program.units {
        let _ = write!(hasher, "{:?};", (unit.entry, unit.frame, &unit.template, &unit.writes));
    }
    let _ = write!(hasher, "{:?}{:?}", program.indexes, program.texts);
    for call in &program.library {
        let code = match call.code {
            crate::code::LibraryCode::Function(function) => function.name.to_owned(),
            crate::code::LibraryCode::ToText(ty) => format!("to {ty:?}"),
            crate::code::LibraryCode::FromText(ty) => format!("from {ty:?}"),
        };
        let _ = write!(hasher, "{:?};", (code, call.generic, &call.arguments, call.result));
    }
    let natives: Vec<&str> = program.natives.iter().map(|native: &&Native| native.name).collect();
    let _ = write!(hasher, "{:?}{:?}{:?}{:?}", natives, program.classes, program.kinds, program.located);
    let _ = write!(hasher, "{:?}{:?}", program.programs, program.program_names);
    hasher.0.update(&program.image);
    let _ = write!(
        hasher,
        "{:?}",
        (program.variables_from, program.variables_to, program.limits, &program.retained)
    );
    for root in &program.roots {
        let _ = write!(hasher, "{:?};", (&root.path, root.shape, root.address, root.bit));
    }
    let _ = write!(hasher, "{:?}", program.shapes);
    for task in &program.tasks {
        let _ = write!(hasher, "{:?};", (&task.name, task.interval, task.priority, &task.programs));
    }
    hasher.0.finalize().into()
}
