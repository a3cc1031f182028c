//! Forced variables: held at a value from outside, at the begin and at the end of every cycle, as the vendor's tool does.

use super::Machine;
use crate::program::VarRef;
use signal::Value;

/// A variable that is held.
#[derive(Clone, Copy, Debug)]
pub(super) struct ForcedVariable {
    pub variable: VarRef,
    pub cell: i64,
}

impl Machine {
    /// Holds a variable at a value: at once, and at the begin and the end of every cycle. In between the program may
    /// change it. FALSE, and nothing done, where the value has no number or there is no such variable.
    pub fn force(&mut self, variable: VarRef, value: Value) -> bool {
        let cell = variable.ty().and_then(|ty| Some(ty.wrap(ty.cell(value)?)));
        let Some(cell) = cell.filter(|cell| self.set_cell(variable, *cell)) else { return false };
        self.release(variable);
        self.forced.push(ForcedVariable { variable, cell });
        true
    }

    /// Lets go of a variable, which keeps its value. FALSE where it was not held.
    pub fn release(&mut self, variable: VarRef) -> bool {
        let held = self.forced.len();
        self.forced.retain(|forced| forced.variable != variable);
        self.forced.len() < held
    }

    /// Lets go of all variables.
    pub fn release_all(&mut self) {
        self.forced.clear();
    }

    /// What is held at which value, in the order in which it was forced.
    pub fn forced(&self) -> impl Iterator<Item = (VarRef, Value)> + '_ {
        self.forced
            .iter()
            .filter_map(|forced| Some((forced.variable, forced.variable.ty()?.value(forced.cell))))
    }

    /// Sets what is held.
    pub(super) fn apply_forced(&mut self) {
        for place in 0..self.forced.len() {
            if let Some(ForcedVariable { variable, cell }) = self.forced.get(place).copied() {
                self.set_cell(variable, cell);
            }
        }
    }
}
