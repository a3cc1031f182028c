//! Memory beyond the plain case: the host's areas, watched and retained bytes, constants, bad references. Slow
//! paths, kept out of the loop of the machine.

use crate::code::map;
use crate::host::Host;
use crate::program::Program;
use crate::state::{READ_ONLY, WATCHED};
use signal::{Address, Area, Size};

/// How a store went.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stored {
    Fine,
    /// Something watched changed.
    Touched,
    /// There is nothing that may be written; nothing was.
    Bad,
}

impl Stored {
    /// Both, the first having been done.
    pub fn and(self, then: impl FnOnce() -> Stored) -> Stored {
        match self {
            Stored::Bad => Stored::Bad,
            Stored::Fine => then(),
            Stored::Touched => match then() {
                Stored::Bad => Stored::Bad,
                _ => Stored::Touched,
            },
        }
    }
}

/// Which operation of which unit stores.
#[derive(Clone, Copy, Debug)]
pub(super) struct By {
    pub pc: usize,
    pub unit: u16,
}

/// What all operations of a slice share.
pub(super) struct ProgramMemory<'a> {
    pub program: &'a Program,
    pub flags: &'a [u8],
    pub host: &'a mut dyn Host,
    /// Flags of the bytes that changed.
    pub changed: u8,
}

/// Area and offset of an address in the host's areas.
fn area(at: u32) -> Option<(Area, u32)> {
    match at {
        map::INPUTS..map::OUTPUTS => Some((Area::Input, at - map::INPUTS)),
        map::OUTPUTS..map::MEMORY => Some((Area::Output, at - map::OUTPUTS)),
        map::MEMORY..map::END => Some((Area::Memory, at - map::MEMORY)),
        _ => None,
    }
}

/// Whether an address is in the host's areas.
fn foreign(at: u32) -> bool {
    (map::INPUTS..map::END).contains(&at)
}

impl ProgramMemory<'_> {
    /// The place of `width` bytes that are aligned so; or of one of several bytes.
    fn natural(&self, at: u32, width: u32) -> Option<Address> {
        let (area, offset) = area(at)?;
        let size = match width {
            1 => Size::Byte,
            2 => Size::Word,
            4 => Size::Double,
            _ => Size::Long,
        };
        let address = Address::new(area, size, offset / width)?;
        address.check(&self.program.limits).ok()?;
        Some(address)
    }

    /// Whether all of `width` bytes from `at` on exist in one of the host's areas.
    fn exists(&self, at: u32, width: u32) -> bool {
        let last = width.checked_sub(1).and_then(|more| at.checked_add(more));
        let Some(last) = last else { return false };
        let same = area(at).map(|(area, _)| area) == area(last).map(|(area, _)| area);
        same && self.natural(last, 1).is_some()
    }

    /// 1, 2, 4 or 8 bytes from anywhere.
    #[cold]
    #[inline(never)]
    pub fn load(&mut self, memory: &[u8], at: u32, width: u32) -> Option<u64> {
        if !foreign(at) {
            let bytes = memory.get(at as usize..)?.get(..width as usize)?;
            return Some(bytes.iter().rev().fold(0, |n, byte| n << 8 | u64::from(*byte)));
        }
        if at.is_multiple_of(width) {
            let address = self.natural(at, width)?;
            return Some(self.host.load(address));
        }
        if !self.exists(at, width) {
            return None;
        }
        (0..width).rev().try_fold(0, |n, i| {
            let address = self.natural(at + i, 1)?;
            Some(n << 8 | (self.host.load(address) & 0xFF))
        })
    }

    /// 1, 2, 4 or 8 bytes to anywhere.
    #[cold]
    #[inline(never)]
    pub fn store(&mut self, memory: &mut [u8], at: u32, width: u32, value: u64, by: By) -> Stored {
        let bytes = value.to_le_bytes();
        let bytes = bytes.get(..width as usize).unwrap_or(&bytes);
        if !foreign(at) {
            return self.write(memory, at, bytes, by);
        }
        if !self.exists(at, width) {
            return Stored::Bad;
        }
        if at.is_multiple_of(width) {
            return self.natural(at, width).map_or(Stored::Bad, |address| self.out(address, value, by));
        }
        bytes.iter().zip(at..).fold(Stored::Fine, |stored, (byte, at)| {
            stored.and(|| match self.natural(at, 1) {
                Some(address) => self.out(address, u64::from(*byte), by),
                None => Stored::Bad,
            })
        })
    }

    /// A store in the host's areas.
    fn out(&mut self, address: Address, value: u64, by: By) -> Stored {
        if address.area() == Area::Input {
            return Stored::Bad;
        }
        let mask = if address.bit_len() == 64 { u64::MAX } else { (1 << address.bit_len()) - 1 };
        let (file, line) = self.program.source_of(by.unit, by.pc);
        if self.host.store(address, value & mask, file, line) { Stored::Touched } else { Stored::Fine }
    }

    /// Takes note of the bytes that will change; `Bad` where one may not.
    fn note(&mut self, old: &[u8], flags: &[u8], new: impl Iterator<Item = u8>) -> Stored {
        let mut changed = 0;
        for ((old, flag), new) in old.iter().zip(flags).zip(new) {
            if flag & READ_ONLY != 0 {
                return Stored::Bad;
            }
            if *old != new {
                changed |= flag;
            }
        }
        self.changed |= changed;
        if changed & WATCHED != 0 { Stored::Touched } else { Stored::Fine }
    }

    /// Bytes to anywhere.
    pub fn write(&mut self, memory: &mut [u8], at: u32, bytes: &[u8], by: By) -> Stored {
        if foreign(at) {
            return self.write_out(at, bytes, by);
        }
        let range = at as usize..(at as usize).saturating_add(bytes.len());
        let flags = self.flags;
        let (Some(old), Some(flags)) = (memory.get_mut(range.clone()), flags.get(range)) else {
            return Stored::Bad;
        };
        let mut stored = Stored::Fine;
        if flags.iter().any(|flag| *flag != 0) {
            stored = self.note(old, flags, bytes.iter().copied());
        }
        if stored != Stored::Bad {
            old.copy_from_slice(bytes);
        }
        stored
    }

    /// Bytes to the host's areas, in words where they are aligned.
    fn write_out(&mut self, at: u32, bytes: &[u8], by: By) -> Stored {
        let Ok(length) = u32::try_from(bytes.len()) else { return Stored::Bad };
        if length == 0 {
            return Stored::Fine;
        }
        if !self.exists(at, length) {
            return Stored::Bad;
        }
        let (mut stored, mut at, mut rest) = (Stored::Fine, at, bytes);
        while let Some(first) = rest.first() {
            let (width, value) = match rest.get(1) {
                Some(second) if at.is_multiple_of(2) => (2, u64::from(*second) << 8 | u64::from(*first)),
                _ => (1, u64::from(*first)),
            };
            stored = stored.and(|| match self.natural(at, width) {
                Some(address) => self.out(address, value, by),
                None => Stored::Bad,
            });
            at += width;
            rest = rest.get(width as usize..).unwrap_or_default();
        }
        stored
    }

    /// Fills `out` from anywhere.
    pub fn read(&mut self, memory: &[u8], at: u32, out: &mut [u8]) -> Option<()> {
        if !foreign(at) {
            out.copy_from_slice(memory.get(at as usize..)?.get(..out.len())?);
            return Some(());
        }
        for (byte, at) in out.iter_mut().zip(at..) {
            *byte = self.load(memory, at, 1)? as u8;
        }
        Some(())
    }

    /// `length` bytes from anywhere to anywhere; they may overlap. `None` where the source is bad, which is looked at first.
    pub fn copy(&mut self, memory: &mut [u8], to: u32, from: u32, length: u32, by: By) -> Option<Stored> {
        if length == 0 {
            return Some(Stored::Fine);
        }
        if foreign(to) || foreign(from) {
            return self.copy_out(memory, to, from, length, by);
        }
        let (to, from, length) = (to as usize, from as usize, length as usize);
        let source = from..from + length;
        let target = to..to + length;
        let flags = self.flags;
        let new = memory.get(source.clone())?;
        let (Some(old), Some(flags)) = (memory.get(target.clone()), flags.get(target)) else {
            return Some(Stored::Bad);
        };
        let mut stored = Stored::Fine;
        if flags.iter().any(|flag| *flag != 0) {
            stored = self.note(old, flags, new.iter().copied());
        }
        if stored != Stored::Bad {
            memory.copy_within(source, to);
        }
        Some(stored)
    }

    /// The same with one end in the host's areas: in words where both ends are aligned.
    fn copy_out(&mut self, memory: &mut [u8], to: u32, from: u32, length: u32, by: By) -> Option<Stored> {
        let inside = |at: u32| memory.get(at as usize..).is_some_and(|rest| rest.len() >= length as usize);
        let is_there = |at: u32| if foreign(at) { self.exists(at, length) } else { inside(at) };
        if !is_there(from) {
            return None;
        }
        if !is_there(to) {
            return Some(Stored::Bad);
        }
        let width = if (to | from | length).is_multiple_of(2) { 2 } else { 1 };
        let count = length / width;
        // Backwards where the target begins inside the source.
        let backwards = to > from && to - from < length;
        let mut stored = Stored::Fine;
        for nth in 0..count {
            let at = if backwards { count - 1 - nth } else { nth } * width;
            let value = self.load(memory, from + at, width)?;
            stored = stored.and(|| self.store(memory, to + at, width, value, by));
            if stored == Stored::Bad {
                break;
            }
        }
        Some(stored)
    }

    /// The place of a bit, counted from the byte at `at` on, and whether it is in the host's areas.
    fn bit_address(&self, at: u32, bit: u32) -> Option<Address> {
        let (area, offset) = area(at)?;
        let first = offset.checked_mul(8)?.checked_add(bit)?;
        let address = Address::bit(area, first);
        address.check(&self.program.limits).ok()?;
        Some(address)
    }

    /// A bit of the memory from `at` on.
    #[inline(never)]
    pub fn load_bit(&mut self, memory: &[u8], at: u32, bit: u32) -> Option<bool> {
        if foreign(at) {
            let address = self.bit_address(at, bit)?;
            return Some(self.host.load(address) & 1 != 0);
        }
        let byte = memory.get(at.checked_add(bit / 8)? as usize)?;
        Some(byte >> (bit % 8) & 1 != 0)
    }

    /// Sets a bit of the memory from `at` on.
    #[inline(never)]
    pub fn store_bit(&mut self, memory: &mut [u8], at: u32, bit: u32, on: bool, by: By) -> Stored {
        if foreign(at) {
            return self
                .bit_address(at, bit)
                .map_or(Stored::Bad, |address| self.out(address, u64::from(on), by));
        }
        let Some(at) = at.checked_add(bit / 8) else { return Stored::Bad };
        let Some(byte) = memory.get(at as usize) else { return Stored::Bad };
        let mask = 1 << (bit % 8);
        let byte = if on { byte | mask } else { byte & !mask };
        self.write(memory, at, &[byte], by)
    }
}
