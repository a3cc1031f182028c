//! Texts in memory: units of one or two bytes, ended by 0 or by the storage.

use super::world::{By, ProgramMemory, Stored};
use crate::code::TextAt;
use std::cmp::Ordering;

/// What stands for a character that a STRING cannot hold.
const UNKNOWN: u32 = b'?' as u32;

/// A text whose place is known.
#[derive(Clone, Copy)]
pub(super) struct TextSpan {
    pub at: u32,
    pub bytes: u32,
    pub wide: bool,
}

impl TextSpan {
    pub fn new(at: u32, text: &TextAt) -> TextSpan {
        TextSpan { at, bytes: text.bytes, wide: text.wide }
    }

    /// Bytes of a unit.
    pub fn unit(self) -> u32 {
        1 + u32::from(self.wide)
    }

    /// Units of the storage.
    fn units(self) -> u32 {
        self.bytes / self.unit()
    }

    /// Address of a unit. It may be beyond the address space.
    fn address(self, nth: u32) -> u32 {
        self.at.saturating_add(nth * self.unit())
    }
}

/// Places of the two texts of a pair.
pub(super) struct TextOperands {
    pub to: TextSpan,
    pub of: TextSpan,
}

impl ProgramMemory<'_> {
    /// A unit; 0 after the storage.
    fn unit(&mut self, memory: &[u8], text: TextSpan, nth: u32) -> Option<u32> {
        if nth >= text.units() {
            return Some(0);
        }
        let (at, width) = (text.address(nth), text.unit());
        match (width, memory.get(at as usize)) {
            (1, Some(byte)) => Some(u32::from(*byte)),
            _ => self.load(memory, at, width).map(|unit| unit as u32),
        }
    }

    /// Units before the closing 0, at most `most`.
    fn length(&mut self, memory: &[u8], text: TextSpan, most: u32) -> Option<u32> {
        let most = most.min(text.units());
        let end = text.at as usize + most as usize;
        if let (false, Some(bytes)) = (text.wide, memory.get(text.at as usize..end)) {
            return Some(bytes.iter().position(|byte| *byte == 0).map_or(most, |n| n as u32));
        }
        for nth in 0..most {
            if self.unit(memory, text, nth)? == 0 {
                return Some(nth);
            }
        }
        Some(most)
    }

    /// Copies a text, cut to the room that there is. What stands after its closing 0 stays as it is.
    #[inline(never)]
    pub fn move_text(&mut self, memory: &mut [u8], pair: &TextOperands, by: By) -> Option<Stored> {
        let TextOperands { to, of } = *pair;
        let Some(room) = to.units().checked_sub(1) else { return Some(Stored::Fine) };
        let length = self.length(memory, of, room)?;
        let stored = if to.wide == of.wide {
            self.copy(memory, to.at, of.at, length * to.unit(), by)?
        } else {
            let mut stored = Stored::Fine;
            for nth in 0..length {
                let unit = self.unit(memory, of, nth)?;
                let unit = if !to.wide && unit > 0xFF { UNKNOWN } else { unit };
                stored = stored.and(|| self.store(memory, to.address(nth), to.unit(), u64::from(unit), by));
            }
            stored
        };
        Some(stored.and(|| self.store(memory, to.address(length), to.unit(), 0, by)))
    }

    /// Compares two texts by their units: -1, 0 or 1.
    #[inline(never)]
    pub fn compare_text(&mut self, memory: &[u8], pair: &TextOperands) -> Option<i8> {
        for nth in 0.. {
            let (a, b) = (self.unit(memory, pair.to, nth)?, self.unit(memory, pair.of, nth)?);
            match a.cmp(&b) {
                Ordering::Less => return Some(-1),
                Ordering::Greater => return Some(1),
                // After the longer storage both are 0.
                Ordering::Equal if a == 0 => return Some(0),
                Ordering::Equal => {}
            }
        }
        Some(0)
    }

    /// Stores the units that a function of the library wrote.
    pub fn store_text(&mut self, memory: &mut [u8], to: TextSpan, units: &[u8], by: By) -> Stored {
        let Some(room) = to.units().checked_sub(1) else { return Stored::Fine };
        let length = (room * to.unit()).min(units.len() as u32);
        let units = units.get(..length as usize).unwrap_or_default();
        let zero = [0; 2];
        let zero = if to.wide { &zero[..] } else { &zero[..1] };
        self.write(memory, to.at, units, by)
            .and(|| self.write(memory, to.at.saturating_add(length), zero, by))
    }
}
