//! A compiled program: code, the layout of its variables, and what is known of them.

use crate::code::{Bounds, Step, Unit};
use crate::native::Native;
use crate::types::Elementary;
use document::Diagnostic;
use signal::{Address, Area};
use std::collections::BTreeMap;

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
    /// In the program's own cells, from this one on.
    Cell(VarRef),
    /// In the images or the mapped memory.
    Located(Address),
}

/// An elementary variable by its cell. Valid for the program that gave it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct VarRef(pub u32);

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
    pub file: u8,
}

/// A located place that the program reads or writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Located {
    /// The place.
    pub address: Address,
    /// The type that it is read and written as.
    pub ty: Elementary,
    /// Some operation reads it.
    pub read: bool,
    /// Some operation writes it.
    pub written: bool,
    /// It is that of a declared variable (controller:REM-03), not only of direct uses.
    pub declared: bool,
    /// The declared initial value as raw bits.
    pub initial: Option<u64>,
}

/// A compiled program. Immutable: machines share it.
#[derive(Clone, Debug)]
pub struct Program {
    /// What runs: [`Program::plain`] with its runs of operations joined.
    pub(crate) code: Vec<Step>,
    /// The operations as compiled, each by itself; places are those of `code`.
    pub(crate) plain: Vec<Step>,
    pub(crate) wide: Vec<i64>,
    pub(crate) bounds: Vec<Bounds>,
    pub(crate) units: Vec<Unit>,
    pub(crate) natives: Vec<&'static Native>,
    pub(crate) located: Vec<Located>,
    /// Units of the PROGRAMs.
    pub(crate) programs: Vec<u16>,
    pub(crate) program_names: Vec<String>,
    /// Initial value, type and retention of each cell.
    pub(crate) initial: Vec<i64>,
    pub(crate) types: Vec<Elementary>,
    pub(crate) retention: Vec<Retention>,
    pub(crate) variables: Vec<Variable>,
    /// Path in capitals, full and short, to the variable; `None` where a short one means several.
    pub(crate) index: BTreeMap<String, Option<u32>>,
    pub(crate) files: Vec<String>,
    pub(crate) digest: [u8; 32],
    pub(crate) layout: [u8; 8],
    /// Findings that did not prevent the compilation.
    pub warnings: Vec<Diagnostic>,
}

impl Program {
    /// Names of the PROGRAMs in the order of the sources. A place in this list is what [`crate::Machine::new`] takes.
    pub fn programs(&self) -> &[String] {
        &self.program_names
    }

    /// All variables: globals first, then program by program, blocks opened up.
    pub fn variables(&self) -> &[Variable] {
        &self.variables
    }

    /// Located places, of declarations and of direct uses, in the order of appearance.
    pub fn located(&self) -> &[Located] {
        &self.located
    }

    /// Places in `%Q` that a program writes, itself or by what it calls, in order. `program` is a place in
    /// [`Program::programs`]; none for another.
    pub fn outputs_of(&self, program: usize) -> Vec<Address> {
        let mut waiting: Vec<u16> = self.programs.get(program).copied().into_iter().collect();
        let mut seen = vec![false; self.units.len()];
        let mut found: Vec<Address> = Vec::new();
        while let Some(place) = waiting.pop() {
            let Some(unit) = self.units.get(usize::from(place)) else { continue };
            if !std::mem::replace(&mut seen[usize::from(place)], true) {
                waiting.extend(&unit.calls);
                let written = unit.writes.iter().filter_map(|entry| self.located.get(*entry as usize));
                found.extend(written.map(|located| located.address));
            }
        }
        found.retain(|address| address.area() == Area::Output);
        found.sort_unstable();
        found.dedup();
        found
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

    /// The variable with this path, in capitals or not: `MAIN.n`, or `n` where no other program has one. A
    /// global variable goes before those of programs. Elements of arrays of elementary types are part of the array
    /// here; blocks in arrays are single, as in `MAIN.t[2].Q`.
    pub fn find(&self, path: &str) -> Option<&Variable> {
        let key: String =
            path.chars().filter(|c| !c.is_whitespace()).map(|c| c.to_ascii_uppercase()).collect();
        let place = (*self.index.get(&key)?)?;
        self.variables.get(place as usize)
    }

    /// The cell of a path: of a variable as in [`Program::find`], or of an element, `MAIN.a[3]` or `m[1,2]`.
    /// `None` for whole arrays and located variables, which [`Program::find`] describes.
    pub fn resolve(&self, path: &str) -> Option<VarRef> {
        if let Some(variable) = self.find(path) {
            return match variable.storage {
                Storage::Cell(cell) if variable.dimensions.is_empty() => Some(cell),
                _ => None,
            };
        }
        let (array, rest) = path.trim().rsplit_once('[')?;
        let variable = self.find(array)?;
        let Storage::Cell(VarRef(first)) = variable.storage else { return None };
        let mut at = 0i64;
        let mut dimensions = variable.dimensions.iter();
        for text in rest.strip_suffix(']')?.split(',') {
            let (low, high) = *dimensions.next()?;
            let index: i64 = text.trim().parse().ok()?;
            if index < low || index > high {
                return None;
            }
            at = at.checked_mul(high.checked_sub(low)?.checked_add(1)?)?.checked_add(index - low)?;
        }
        if dimensions.next().is_some() {
            return None;
        }
        Some(VarRef(first.checked_add(u32::try_from(at).ok()?)?))
    }
}
