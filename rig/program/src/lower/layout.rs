//! Cells of instances and of the whole program.

use super::{Compiler, Type};
use crate::codes::Code;
use crate::findings::At;
use crate::program::Retention;
use crate::types::Elementary;

/// Initial value, type and retention of consecutive cells.
#[derive(Clone, Debug, Default)]
pub(super) struct Cells {
    pub initial: Vec<i64>,
    pub types: Vec<Elementary>,
    pub retention: Vec<Retention>,
}

impl Cells {
    pub fn len(&self) -> u32 {
        self.initial.len() as u32
    }

    fn one(&mut self, ty: Elementary, retention: Retention) {
        self.initial.push(0);
        self.types.push(ty);
        self.retention.push(retention);
    }

    /// A copy of `other`, each cell kept at least as well as `retention`.
    fn append(&mut self, other: &Cells, retention: Retention) {
        self.initial.extend_from_slice(&other.initial);
        self.types.extend_from_slice(&other.types);
        self.retention.extend(other.retention.iter().map(|own| (*own).max(retention)));
    }
}

impl Compiler<'_> {
    /// Cells of a value of this type.
    pub(super) fn size(&self, ty: Type) -> u32 {
        match ty {
            Type::One(_) => 1,
            Type::Array(array) => self.arrays.get(array as usize).map_or(0, |array| array.size),
            Type::Block(block) => self.pous.get(usize::from(block)).map_or(0, |pou| pou.cells.len()),
            Type::Native(native) => self.native(native).map_or(0, |native| native.pins.len() as u32),
            Type::Wrong => 0,
        }
    }

    /// Puts a variable behind what is in `cells`; its first cell. Too much memory is reported.
    pub(super) fn place_cells(&mut self, cells: &mut Cells, ty: Type, retention: Retention, at: At) -> u32 {
        let first = cells.len();
        let (of, count) = match ty {
            Type::Array(array) => match self.arrays.get(array as usize) {
                Some(array) => {
                    (array.of, array.dimensions.iter().map(|(low, high)| (high - low + 1) as u64).product())
                }
                None => (Type::Wrong, 0),
            },
            other => (other, 1u64),
        };
        let total = u64::from(first) + count * u64::from(self.size(of));
        if total > u64::from(self.options.limits.cells) {
            let message = format!("the variables need {total} cells up to here");
            let help = format!("a unit, and the application, have at most {}", self.options.limits.cells);
            self.findings.error(Code::DataSize, at, message, help);
            return first;
        }
        for _ in 0..count {
            match of {
                Type::One(ty) => cells.one(ty, retention),
                Type::Native(native) => {
                    for pin in self.native(native).map_or(&[][..], |native| native.pins) {
                        cells.one(pin.ty, retention);
                    }
                }
                Type::Block(block) => {
                    if let Some(pou) = self.pous.get(usize::from(block)) {
                        cells.append(&pou.cells, retention);
                    }
                }
                Type::Array(_) | Type::Wrong => break,
            }
        }
        first
    }
}
