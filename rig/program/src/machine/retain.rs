//! What survives: Reset, and the retained image.

use super::Machine;
use crate::program::{Program, Retention};
use crate::types::Elementary;
use crate::walk::{Leaf, leaves};
use std::sync::Arc;

/// Bytes of the retained variables of a program.
fn kept_bytes(program: &Program) -> usize {
    program.retained.iter().map(|kept| kept.bytes as usize).sum()
}

impl Machine {
    /// Abandons all cycles and puts the variables back to their initial values, but for the RETAIN ones
    /// where `keep_retain`, and the PERSISTENT ones where `keep_persistent` (controller:REM-02).
    pub fn reset(&mut self, keep_retain: bool, keep_persistent: bool) {
        for task in &mut self.tasks {
            task.position = task.programs.len();
            task.stopped = false;
            task.stepping = false;
        }
        let program = Arc::clone(&self.program);
        let mut at = program.variables_from as usize;
        for kept in &program.retained {
            let keep = match kept.retention {
                Retention::None => false,
                Retention::Retain => keep_retain,
                Retention::Persistent => keep_persistent,
            };
            let (first, end) = (kept.address as usize, (kept.address + kept.bytes) as usize);
            if keep {
                self.initialize(&program, at, first);
                at = end;
            }
        }
        self.initialize(&program, at, program.variables_to as usize);
    }

    /// Puts the bytes of a range back to their initial values.
    fn initialize(&mut self, program: &Program, from: usize, to: usize) {
        if let Some(initial) = program.image.get(from..to) {
            self.set_bytes(from, initial);
        }
    }

    /// Bytes of the retained image, at most 64 Kbytes (controller:MEM-08); 0 where nothing is retained.
    pub fn retained_len(&self) -> usize {
        let bytes = kept_bytes(&self.program);
        if bytes == 0 { 0 } else { bytes + self.program.layout.len() }
    }

    /// Writes the retained variables into the first [`Machine::retained_len`] bytes of `out`: names and types as a hash of
    /// 8 bytes, then the values, little-endian. FALSE where `out` is too short, and then nothing is written.
    pub fn save_retained(&self, out: &mut [u8]) -> bool {
        let length = self.retained_len();
        let Some(out) = out.get_mut(..length) else { return false };
        if length == 0 {
            return true;
        }
        let (head, mut rest) = out.split_at_mut(self.program.layout.len());
        head.copy_from_slice(&self.program.layout);
        for kept in &self.program.retained {
            let (place, after) = rest.split_at_mut(kept.bytes as usize);
            let first = kept.address as usize;
            if let Some(bytes) = self.memory.get(first..first + place.len()) {
                place.copy_from_slice(bytes);
            }
            rest = after;
        }
        true
    }

    /// Takes the retained variables from an image that [`Machine::save_retained`] wrote. FALSE, and nothing changed, where the
    /// image is not of these variables in name, type and number (controller:REM-06).
    pub fn restore_retained(&mut self, image: &[u8]) -> bool {
        let length = self.retained_len();
        if image.len() != length {
            return false;
        }
        if length == 0 {
            return true;
        }
        let program = Arc::clone(&self.program);
        let Some((head, mut rest)) = image.split_at_checked(program.layout.len()) else { return false };
        if head != program.layout {
            return false;
        }
        for kept in &program.retained {
            let Some((place, after)) = rest.split_at_checked(kept.bytes as usize) else { return false };
            let first = kept.address as usize;
            if let Some(bytes) = self.memory.get_mut(first..first + place.len()) {
                bytes.copy_from_slice(place);
            }
            rest = after;
        }
        self.tidy(&program);
        true
    }

    /// BOOLs hold 0 or 1 whatever the image held.
    pub(super) fn tidy(&mut self, program: &Program) {
        let within = |first: u32, end: u32| {
            let place = program.retained.partition_point(|kept| kept.address + kept.bytes <= first);
            program.retained.get(place).is_some_and(|kept| kept.address < end)
        };
        let memory = &mut self.memory;
        leaves(program, &within, &mut |leaf: &Leaf<'_>| {
            if leaf.ty == Some(Elementary::Bool) && within(leaf.address, leaf.address + leaf.bytes) {
                let range = leaf.address as usize..(leaf.address + leaf.bytes) as usize;
                if let Some(bytes) = memory.get_mut(range) {
                    bytes.iter_mut().for_each(|byte| *byte &= 1);
                }
            }
            true
        });
    }

    /// Whether a retained variable changed since the last call of this.
    pub fn retained_dirty(&mut self) -> bool {
        std::mem::take(&mut self.dirty)
    }
}
