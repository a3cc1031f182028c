//! A compiled program: code, the layout of its variables, and what is known of them.

use crate::code::{CodeStep, CodeUnit, IndexOf, LibraryCall, ObjectClass, Op, Statement, TextPair};
use crate::native::Native;
use crate::shape::{MemoryLayout, Root, ShapeId};
use crate::types::Elementary;
use document::Diagnostic;
use signal::{Address, Area, Size, Span};
use std::collections::BTreeMap;
use std::ops::Range;

/// What becomes of a variable at a restart (controller:REM-01, controller:REM-02).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Retention {
    /// Initialised.
    #[default]
    None,
    /// Kept over power cycles and Reset warm.
    Retain,
    /// Kept over Reset cold and downloads too: PERSISTENT and RETAIN PERSISTENT are the same in these controllers.
    Persistent,
}

/// Where a variable is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Storage {
    /// In the program's own memory: a variable, or the first one of an array.
    Cell(VarRef),
    /// In the images or the mapped memory.
    Located(Address),
}

/// An elementary variable: its address in the machine's own memory, times 32, and the place of its type in
/// [`Elementary::ALL`]. Valid for the program that gave it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct VarRef(pub u32);

impl VarRef {
    pub(crate) const fn new(address: u32, ty: Elementary) -> VarRef {
        VarRef(address << 5 | ty as u32)
    }

    pub(crate) const fn address(self) -> u32 {
        self.0 >> 5
    }

    pub(crate) fn ty(self) -> Option<Elementary> {
        Elementary::ALL.get((self.0 & 31) as usize).copied()
    }

    /// Its bytes in the machine's memory.
    pub(crate) fn bytes(self) -> Option<Range<usize>> {
        let first = self.address() as usize;
        Some(first..first + self.ty()?.bytes())
    }
}

/// What the first names of a path mean: a root, or a member of one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct NameEntry {
    pub root: u32,
    pub member: Option<u32>,
}

/// A variable, or an array of elementary variables as a whole.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Variable {
    /// `MAIN.n`, `MAIN.t1.Q`, or the bare name of a global one, as declared.
    pub path: String,
    /// Type, of the elements for an array.
    pub ty: Elementary,
    /// Lower and upper bound of each dimension; empty for a single variable.
    pub dimensions: Vec<(i64, i64)>,
    /// What becomes of it at a restart.
    pub retention: Retention,
    /// Where it is.
    pub storage: Storage,
    /// Place of the source file that declares it.
    pub file: u16,
}

/// A variable at an address (controller:REM-03). Arrays and structures are one, whatever their size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Located {
    /// Where it begins.
    pub address: Address,
    /// Bits that it covers from there on.
    pub bits: u32,
    /// The declared initial value as raw bits.
    pub initial: Option<u64>,
}

impl Located {
    /// Whether it covers any bit of a place.
    pub fn overlaps(&self, place: &Address) -> bool {
        let (first, other) = (self.address.bit_offset(), place.bit_offset());
        self.address.area() == place.area()
            && first < other.saturating_add(place.bit_len())
            && other < first.saturating_add(self.bits)
    }
}

/// A place of %I or %Q that the user's sources name, in a declaration or in an expression.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ImagePlace {
    /// Where it begins.
    pub address: Address,
    /// Bits that are used from there on.
    pub bits: u32,
    /// Place of the source file that names it first.
    pub file: u16,
    /// Bytes of the address in that file.
    pub span: Range<usize>,
}

/// A VAR_INPUT or VAR_OUTPUT of a PROGRAM: what whoever runs it connects.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ProgramPin {
    /// As declared.
    pub name: String,
    /// With its PROGRAM: `MAIN.level`.
    pub path: String,
    /// VAR_INPUT.
    pub is_input: bool,
    /// Its type; `None` for one that has no elementary one.
    pub ty: Option<Elementary>,
}

/// A task that the sources configure (CONFIGURATION).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ConfiguredTask {
    /// As declared.
    pub name: String,
    /// INTERVAL; `None` for a task with SINGLE.
    pub interval: Option<Span>,
    /// SINGLE: the Boolean variable that releases it, as written.
    pub single: Option<String>,
    /// PRIORITY as written.
    pub priority: Option<u32>,
    /// Places in [`Program::programs`] of what it runs, in order.
    pub programs: Vec<usize>,
    /// Place of the source file that configures it.
    pub file: u16,
    /// Bytes of its name in that file.
    pub span: std::ops::Range<usize>,
}

/// Bytes that are kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Retained {
    pub address: u32,
    pub bytes: u32,
    pub retention: Retention,
}

/// A retained variable, or an array of elementary ones.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct RetainedVariable {
    pub address: u32,
    pub bytes: u32,
    pub retention: Retention,
    /// Path in capitals, type, retention.
    pub name: String,
}

/// A compiled program. Immutable: machines share it.
#[derive(Clone, Debug)]
pub struct Program {
    pub(crate) code: Vec<CodeStep>,
    /// The line of each operation, from 1.
    pub(crate) lines: Vec<u32>,
    pub(crate) indexes: Vec<IndexOf>,
    pub(crate) texts: Vec<TextPair>,
    pub(crate) library: Vec<LibraryCall>,
    pub(crate) units: Vec<CodeUnit>,
    pub(crate) natives: Vec<&'static Native>,
    pub(crate) classes: Vec<ObjectClass>,
    /// Names of the blocks and interfaces that [`crate::code::Op::IsKind`] asks for.
    pub(crate) kinds: Vec<String>,
    /// In the order of the code.
    pub(crate) statements: Vec<Statement>,
    pub(crate) located: Vec<Located>,
    /// Units of the PROGRAMs.
    pub(crate) programs: Vec<u16>,
    pub(crate) program_names: Vec<String>,
    /// The machine's own memory at the start, from address 0: nothing up to [`crate::code::map::FIRST`], then the
    /// variables from `variables_from` to `variables_to` and the constants, in either order. Only variables are
    /// ever written.
    pub(crate) image: Vec<u8>,
    pub(crate) variables_from: u32,
    /// After the last variable.
    pub(crate) variables_to: u32,
    /// How far the images and the mapped memory reach: pointers may hold any address.
    pub(crate) limits: signal::AddressLimits,
    /// Sorted by address, disjoint.
    pub(crate) retained: Vec<Retained>,
    pub(crate) roots: Vec<Root>,
    pub(crate) shapes: Vec<MemoryLayout>,
    pub(crate) tasks: Vec<ConfiguredTask>,
    /// VAR_INPUT and VAR_OUTPUT of the PROGRAMs: no part of what the program does.
    pub(crate) pins: Vec<ProgramPin>,
    /// Places of %I and %Q by their addresses: no part of what the program does.
    pub(crate) images: Vec<ImagePlace>,
    /// Source file and bytes of the first LREAL: no part of what the program does.
    pub(crate) lreal: Option<(u16, std::ops::Range<usize>)>,
    /// What [`Program::variables`] lists: derived.
    pub(crate) variables: Vec<Variable>,
    /// First names in capitals, full and short; `None` where a short one means several: derived.
    pub(crate) index: BTreeMap<String, Option<NameEntry>>,
    pub(crate) files: Vec<String>,
    /// Derived.
    pub(crate) digest: [u8; 32],
    /// Derived.
    pub(crate) layout: [u8; 8],
    /// What stands in the retained image, sorted by address: derived.
    pub(crate) kept: Vec<RetainedVariable>,
    /// Derived.
    pub(crate) declarations: [u8; 8],
    /// Findings that did not prevent the compilation.
    pub warnings: Vec<Diagnostic>,
}

impl Program {
    /// The place of the first declaration with the type LREAL, which the documents of some controllers do not list
    /// (controller:DT-04): the source file's place and bytes of its text.
    pub fn lreal(&self) -> Option<(u16, std::ops::Range<usize>)> {
        self.lreal.clone()
    }

    /// The places of %I and %Q that the user's sources name, in the order of their addresses, each with where it is named first.
    pub fn images(&self) -> &[ImagePlace] {
        &self.images
    }

    /// Names of the PROGRAMs in the order of the sources. A place in this list is what [`crate::Machine::new`] takes.
    pub fn programs(&self) -> &[String] {
        &self.program_names
    }

    /// The variables by their roots, structures, blocks and arrays of them opened up: single ones and arrays of
    /// elementary types, without texts and addresses. At most 200,000; [`Program::find`] knows the rest too.
    pub fn variables(&self) -> &[Variable] {
        &self.variables
    }

    /// The variables that are no part of others: global ones, instances of programs, located ones of programs.
    pub fn roots(&self) -> &[Root] {
        &self.roots
    }

    /// The source file of an operation, by its place, and its line from 1; of an operation that a unit has.
    pub(crate) fn source_of(&self, unit: u16, operation: usize) -> (u16, u32) {
        let file = self.units.get(usize::from(unit)).map_or(0, |unit| unit.file);
        (file, self.lines.get(operation).copied().unwrap_or(0))
    }

    /// Variables at addresses, in the order of their declaration.
    pub fn located(&self) -> &[Located] {
        &self.located
    }

    /// Places in `%Q` that a program writes, itself or by what it calls, in order. `program` is a place in
    /// [`Program::programs`]; none for another.
    pub fn outputs_of(&self, program: usize) -> Vec<Address> {
        self.places_of(program, Area::Output, |unit| &unit.writes)
    }

    /// Places in `%I` that a program reads, in the same way. What it reads through pointers is not among them.
    pub fn inputs_of(&self, program: usize) -> Vec<Address> {
        self.places_of(program, Area::Input, |unit| &unit.reads)
    }

    fn places_of(&self, program: usize, area: Area, of: fn(&CodeUnit) -> &[(u32, u32)]) -> Vec<Address> {
        let mut waiting: Vec<u16> = self.programs.get(program).copied().into_iter().collect();
        let mut seen = vec![false; self.units.len()];
        let mut bits: Vec<(u32, u32)> = Vec::new();
        while let Some(place) = waiting.pop() {
            let (Some(unit), Some(seen)) =
                (self.units.get(usize::from(place)), seen.get_mut(usize::from(place)))
            else {
                continue;
            };
            if !std::mem::replace(seen, true) {
                waiting.extend(&unit.calls);
                bits.extend(of(unit));
            }
        }
        let limit = self.limits.bits(area);
        let mut found: Vec<Address> = Vec::new();
        for (first, number) in bits {
            let mut at = first.min(limit);
            let end = first.saturating_add(number).min(limit);
            while at < end {
                let whole = at.is_multiple_of(8) && end - at >= 8;
                let byte = if whole { Address::new(area, Size::Byte, at / 8) } else { None };
                found.push(byte.unwrap_or(Address::bit(area, at)));
                at += if whole { 8 } else { 1 };
            }
        }
        found.sort_unstable();
        found.dedup();
        found
    }

    /// Bytes of its variables and constants.
    pub fn memory_bytes(&self) -> usize {
        self.image.len()
    }

    /// Names of the sources; their places are those of `file` everywhere.
    pub fn files(&self) -> &[String] {
        &self.files
    }

    /// SHA-256 over code, costs and variables: equal for programs that behave alike in every respect that is
    /// modelled. Comments, layout and the names of files do not enter.
    pub fn digest(&self) -> [u8; 32] {
        self.digest
    }

    /// The first 64 bits of [`Program::digest`]: identity of code and variables (controller:STATE-10).
    pub fn signature(&self) -> u64 {
        self.digest.iter().take(8).fold(0, |n, byte| n << 8 | u64::from(*byte))
    }

    /// Identity of what is declared: the same for programs that differ in code alone (controller:REM-02).
    pub fn declarations(&self) -> u64 {
        u64::from_le_bytes(self.declarations)
    }

    /// Place of the source file of an operation.
    pub(crate) fn file_at(&self, pc: u32) -> u16 {
        let after = self.units.iter().filter(|unit| unit.entry <= pc);
        after.max_by_key(|unit| unit.entry).map_or(0, |unit| unit.file)
    }

    /// VAR_INPUT and VAR_OUTPUT of the PROGRAMs, in the order of the sources; constants and in-outs are not among them.
    pub fn pins(&self) -> &[ProgramPin] {
        &self.pins
    }

    /// The first call of a function that asks the controller ([`crate::StopReason::Service`]): place of the source file, and line
    /// from 1.
    pub fn asks_controller(&self) -> Option<(u16, u32)> {
        let asks = |step: &CodeStep| {
            let call = self.library.get(step.b as usize).filter(|_| step.op == Op::CallLibrary);
            call.is_some_and(LibraryCall::asks)
        };
        let pc = self.code.iter().position(asks)?;
        Some((self.file_at(pc as u32), self.lines.get(pc).copied().unwrap_or(0)))
    }

    /// The tasks that the sources configure, in their order.
    pub fn tasks(&self) -> &[ConfiguredTask] {
        &self.tasks
    }

    /// What becomes of the byte at an address at a restart.
    pub(crate) fn retention_at(&self, address: u32) -> Retention {
        let place = self.retained.partition_point(|kept| kept.address + kept.bytes <= address);
        let kept = self.retained.get(place).filter(|kept| kept.address <= address);
        kept.map_or(Retention::None, |kept| kept.retention)
    }

    /// The native block of this name.
    pub(crate) fn native(&self, name: &str) -> Option<&'static Native> {
        self.natives.iter().find(|native| native.name.eq_ignore_ascii_case(name)).copied()
    }

    /// The type at a place of the table.
    pub(crate) fn shape(&self, id: ShapeId) -> Option<&MemoryLayout> {
        self.shapes.get(id.0 as usize)
    }
}
