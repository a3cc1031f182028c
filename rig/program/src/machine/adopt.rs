//! What a program takes from the retained image of another one: the map of an image, and its reader.

use super::Machine;
use crate::program::{Program, Retention};
use std::collections::BTreeMap;
use std::sync::Arc;

/// A variable of a map: its bytes in the image, its name.
struct AdoptedEntry<'a> {
    first: usize,
    bytes: usize,
    name: &'a str,
}

impl Machine {
    /// Says where which variable stands in the images of [`Machine::save_retained`]: the same for every machine of a program.
    /// Empty where nothing is retained.
    pub fn retained_map(&self) -> Vec<u8> {
        let program = &self.program;
        let mut map = Vec::new();
        if self.retained_len() == 0 {
            return map;
        }
        map.extend_from_slice(&program.layout);
        for kept in &program.kept {
            let Some(first) = place(program, kept.address) else { continue };
            map.extend_from_slice(&(first as u32).to_le_bytes());
            map.extend_from_slice(&kept.bytes.to_le_bytes());
            map.extend_from_slice(&(kept.name.len() as u32).to_le_bytes());
            map.extend_from_slice(kept.name.as_bytes());
        }
        map
    }

    /// Takes from an image of another program, which has this map, the persistent variables that both programs have with the
    /// same path and type (controller:REM-02). TRUE where this program has every variable of the map, kept in the same
    /// way (controller:REM-06); FALSE, and nothing changed, where map and image do not belong together.
    pub fn adopt_retained(&mut self, map: &[u8], image: &[u8]) -> bool {
        if map.is_empty() && image.is_empty() {
            return true;
        }
        let program = Arc::clone(&self.program);
        let Some(entries) = read(map, image) else { return false };
        let own: BTreeMap<&str, _> = program.kept.iter().map(|kept| (kept.name.as_str(), kept)).collect();
        let mut all = true;
        for entry in entries {
            let known = own.get(entry.name).filter(|known| known.bytes as usize == entry.bytes);
            let Some(known) = known else {
                all = false;
                continue;
            };
            let (to, values) = (known.address as usize, image.get(entry.first..entry.first + entry.bytes));
            if known.retention == Retention::Persistent
                && let (Some(bytes), Some(values)) = (self.memory.get_mut(to..to + entry.bytes), values)
            {
                bytes.copy_from_slice(values);
            }
        }
        self.tidy(&program);
        all
    }
}

/// Where the variable at an address stands in the image.
fn place(program: &Program, address: u32) -> Option<usize> {
    let mut first = program.layout.len();
    for kept in &program.retained {
        if (kept.address..kept.address + kept.bytes).contains(&address) {
            return Some(first + (address - kept.address) as usize);
        }
        first += kept.bytes as usize;
    }
    None
}

/// The variables of a map, where it is one and belongs to the image.
fn read<'a>(map: &'a [u8], image: &[u8]) -> Option<Vec<AdoptedEntry<'a>>> {
    let (layout, mut rest) = map.split_at_checked(8)?;
    if image.get(..8)? != layout {
        return None;
    }
    let mut entries = Vec::new();
    while !rest.is_empty() {
        let mut number = || {
            let (number, after) = rest.split_first_chunk::<4>()?;
            rest = after;
            Some(u32::from_le_bytes(*number) as usize)
        };
        let (first, bytes, length) = (number()?, number()?, number()?);
        let (name, after) = rest.split_at_checked(length)?;
        rest = after;
        if first.checked_add(bytes)? > image.len() {
            return None;
        }
        entries.push(AdoptedEntry { first, bytes, name: std::str::from_utf8(name).ok()? });
    }
    Some(entries)
}
