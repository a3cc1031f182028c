//! Online change: another program takes over, and variables keep their values.

use super::{Machine, MachineError};
use crate::code::map;
use crate::program::{Program, VarRef};
use crate::shape::{Member, MemoryLayout, Root, ShapeId, count};
use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;

/// Types that stand inside each other, at most.
const DEPTH: u32 = 200;

/// Why a program cannot take over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChangeError {
    /// A task is in the middle of a cycle.
    Busy {
        /// Its place.
        task: usize,
    },
    /// There is no machine for it.
    Machine(MachineError),
}

impl fmt::Display for ChangeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ChangeError::Busy { task } => write!(f, "task {task} is in the middle of a cycle"),
            ChangeError::Machine(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for ChangeError {}

/// What became of the variables: counted as single ones or arrays of elementary types.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ChangeReport {
    /// They are in both programs and keep their values, arrays as far as their bounds agree.
    pub kept: usize,
    /// They are only in the new one, or of another type there, and have their initial values.
    pub new: usize,
    /// They were only in the old one, or of another type there.
    pub lost: usize,
}

impl Machine {
    /// Goes on with another program. Values of variables with the same path and type are kept, retained or not; the others have
    /// their initial values, and so have pointers, references and interfaces, because what they lead to has moved. Forced variables stay forced.
    /// Watches, breakpoints and coverage start again, and references of the old program are not valid any more.
    ///
    /// # Errors
    /// [`ChangeError`], and nothing has changed.
    pub fn change(
        &mut self,
        program: Arc<Program>,
        tasks: &[Vec<usize>],
    ) -> Result<ChangeReport, ChangeError> {
        if let Some(task) = self.tasks.iter().position(|task| !task.idle()) {
            return Err(ChangeError::Busy { task });
        }
        let mut machine = Machine::new(Arc::clone(&program), tasks).map_err(ChangeError::Machine)?;
        let old = Arc::clone(&self.program);
        let mut known: BTreeMap<String, &Root> = BTreeMap::new();
        for root in &old.roots {
            known.insert(root.path.to_ascii_uppercase(), root);
        }
        let mut change = ProgramChange {
            old: &old,
            new: &program,
            from: self,
            to: &mut machine,
            report: ChangeReport::default(),
        };
        for root in &program.roots {
            match known.remove(&root.path.to_ascii_uppercase()) {
                Some(was) => change.pair((was.shape, was.address), (root.shape, root.address), 0),
                None => change.report.new += leaves(&program, root.shape, 0),
            }
        }
        for root in known.values() {
            change.report.lost += leaves(&old, root.shape, 0);
        }
        let report = change.report;
        machine.dirty |= self.dirty || !program.retained.is_empty();
        *self = machine;
        Ok(report)
    }
}

struct ProgramChange<'a> {
    old: &'a Program,
    new: &'a Program,
    from: &'a Machine,
    to: &'a mut Machine,
    report: ChangeReport,
}

impl ProgramChange<'_> {
    /// A variable of both programs: type and address in each.
    fn pair(&mut self, was: (ShapeId, u32), is: (ShapeId, u32), depth: u32) {
        let (Some(old), Some(new)) = (self.old.shape(was.0), self.new.shape(is.0)) else { return };
        if depth > DEPTH {
            return;
        }
        match (old, new) {
            (
                MemoryLayout::Members { name, members, .. },
                MemoryLayout::Members { name: other, members: those, .. },
            ) => {
                // The state of a native block is more than its pins.
                let native = |program: &Program, name: &str| program.native(name).map(|native| native.name);
                let (before, after) = (native(self.old, name), native(self.new, other));
                if before.is_some() && before == after && old.bytes() == new.bytes() {
                    self.keep(was.1, is.1, old.bytes());
                }
                self.members((members, was.1), (those, is.1), depth);
            }
            (
                MemoryLayout::Array { dimensions, of, stride },
                MemoryLayout::Array { dimensions: bounds, of: item, stride: step },
            ) if dimensions.len() == bounds.len() => {
                let elementary =
                    |program: &Program, of: ShapeId| program.shape(of).and_then(MemoryLayout::elementary);
                let (before, after) = (elementary(self.old, *of), elementary(self.new, *item));
                if before.is_some() && before == after && dimensions == bounds {
                    self.keep(was.1, is.1, old.bytes());
                    self.report.kept += 1;
                    return;
                }
                let counts = self.report;
                for nth in 0..count(bounds) {
                    let at =
                        |first: u32, nth: u32, stride: u32| first.saturating_add(nth.saturating_mul(stride));
                    match same_element(bounds, nth, dimensions) {
                        Some(place) => {
                            self.pair(
                                (*of, at(was.1, place, *stride)),
                                (*item, at(is.1, nth, *step)),
                                depth + 1,
                            );
                        }
                        None => self.report.new += leaves(self.new, *item, depth),
                    }
                }
                if before.is_some() && after.is_some() {
                    // An array of elementary types is one variable.
                    let same = before == after;
                    self.report = counts;
                    self.count(same, was.0, is.0);
                } else {
                    let gone =
                        (0..count(dimensions)).filter(|nth| same_element(dimensions, *nth, bounds).is_none());
                    self.report.lost += gone.count() * leaves(self.old, *of, depth);
                }
            }
            (MemoryLayout::Text { wide, length }, MemoryLayout::Text { wide: other, length: room }) => {
                let same = (wide, length) == (other, room);
                if same {
                    self.keep(was.1, is.1, old.bytes());
                }
                self.count(same, was.0, is.0);
            }
            _ => {
                let same = old.elementary().is_some()
                    && old.elementary() == new.elementary()
                    && within(new, self.from, was.1);
                if same {
                    self.keep(was.1, is.1, old.bytes());
                }
                self.count(same, was.0, is.0);
            }
        }
    }

    fn members(&mut self, (members, was): (&[Member], u32), (those, is): (&[Member], u32), depth: u32) {
        for (place, member) in those.iter().enumerate() {
            let same = |known: &Member| known.name.eq_ignore_ascii_case(&member.name);
            // Members stand at their old places most of the time.
            let known = members
                .get(place)
                .filter(|known| same(known))
                .or_else(|| members.iter().find(|known| same(known)));
            let address = is.saturating_add(member.offset);
            match known {
                Some(known) => {
                    self.pair(
                        (known.shape, was.saturating_add(known.offset)),
                        (member.shape, address),
                        depth + 1,
                    );
                }
                None => self.report.new += leaves(self.new, member.shape, depth),
            }
        }
        for (place, member) in members.iter().enumerate() {
            let same = |known: &Member| known.name.eq_ignore_ascii_case(&member.name);
            if !those.get(place).is_some_and(same) && !those.iter().any(same) {
                self.report.lost += leaves(self.old, member.shape, depth);
            }
        }
    }

    fn count(&mut self, kept: bool, was: ShapeId, is: ShapeId) {
        if kept {
            self.report.kept += 1;
        } else {
            self.report.lost += leaves(self.old, was, 0);
            self.report.new += leaves(self.new, is, 0);
        }
    }

    /// Takes bytes over, and what is forced among them.
    fn keep(&mut self, was: u32, is: u32, bytes: u32) {
        let range = was as usize..was as usize + bytes as usize;
        // Located variables are the host's.
        let Some(values) = self.from.memory.get(range) else { return };
        self.to.set_bytes(is as usize, values);
        for forced in &self.from.forced {
            let at = forced.variable.address();
            if let (true, Some(ty)) = (at >= was && at < was + bytes, forced.variable.ty()) {
                let moved =
                    super::ForcedVariable { variable: VarRef::new(at - was + is, ty), cell: forced.cell };
                if !self.to.forced.iter().any(|known| known.variable == moved.variable) {
                    self.to.forced.push(moved);
                }
            }
        }
    }
}

/// Whether a value is one of the new type: limits of a subrange and names of an enumeration may have changed.
fn within(shape: &MemoryLayout, machine: &Machine, address: u32) -> bool {
    let Some(ty) = shape.elementary().filter(|_| address < map::OWN_END) else { return true };
    let Some((_, cell)) = machine.cell(VarRef::new(address, ty)) else { return true };
    match shape {
        MemoryLayout::Subrange { low, high, .. } => cell >= *low && cell <= *high,
        _ => true,
    }
}

/// Leaves of a type: an array of elementary types is one, an address is one.
fn leaves(program: &Program, id: ShapeId, depth: u32) -> usize {
    match program.shape(id) {
        Some(shape) if depth > DEPTH || shape.bytes() == 0 => 0,
        Some(MemoryLayout::Members { members, .. }) => {
            members.iter().map(|member| leaves(program, member.shape, depth + 1)).sum()
        }
        Some(MemoryLayout::Array { dimensions, of, .. }) => {
            match program.shape(*of).and_then(MemoryLayout::elementary) {
                Some(_) => 1,
                None => (count(dimensions) as usize).saturating_mul(leaves(program, *of, depth + 1)),
            }
        }
        Some(_) => 1,
        None => 0,
    }
}

/// The place in an array of other bounds of the element that is the `nth` of `dimensions`.
fn same_element(dimensions: &[(i64, i64)], nth: u32, bounds: &[(i64, i64)]) -> Option<u32> {
    if dimensions == bounds {
        return Some(nth);
    }
    let (mut rest, mut place, mut unit) = (i64::from(nth), 0i64, 1i64);
    for ((low, high), (first, last)) in dimensions.iter().zip(bounds).rev() {
        let width = high.checked_sub(*low)?.checked_add(1)?;
        let index = low.checked_add(rest.checked_rem(width)?)?;
        rest = rest.checked_div(width)?;
        if index < *first || index > *last {
            return None;
        }
        place = place.checked_add(index.checked_sub(*first)?.checked_mul(unit)?)?;
        unit = unit.checked_mul(last.checked_sub(*first)?.checked_add(1)?)?;
    }
    u32::try_from(place).ok()
}
