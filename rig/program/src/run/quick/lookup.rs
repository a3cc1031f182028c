//! Places in memory, and elements that the operation finds that uses them.

use super::OperandBase;
use crate::code::map;

/// Types of indices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum IndexType {
    /// `add` is the place of the element.
    Constant,
    /// 16 bits.
    Narrow,
    /// 32 bits.
    Wide,
}

/// An operation that finds an element. Bounds are those of the index's type, so that numbers that wrap around at its
/// width do: signed or not makes no difference.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Lookup {
    /// The index.
    pub index: u32,
    /// What makes the element's place of the index: a constant that the program adds, less the lower bound.
    pub add: u32,
    /// The place of the last element.
    pub last: u32,
    /// The array.
    pub of: u32,
    pub stride: u32,
    pub index_from: OperandBase,
    pub from: OperandBase,
    pub ty: IndexType,
    pub indirect: bool,
}

#[inline(always)]
pub(super) fn read<const N: usize>(memory: &[u8], at: usize) -> Option<[u8; N]> {
    memory.get(at..at + N)?.first_chunk().copied()
}

/// Where an offset leads.
#[inline(always)]
pub(super) fn place(bases: &[u32; 3], from: OperandBase, offset: u32) -> usize {
    bases[from as usize].wrapping_add(offset) as usize
}

/// The address that stands at a place.
#[inline(always)]
pub(super) fn follow(memory: &[u8], at: usize) -> Option<usize> {
    let at = u32::from_le_bytes(read(memory, at)?);
    if at < map::FIRST { None } else { Some(at as usize) }
}

impl Lookup {
    /// The address of the element.
    #[inline(always)]
    pub fn find(&self, memory: &[u8], bases: &[u32; 3]) -> Option<usize> {
        let at = place(bases, self.index_from, self.index);
        let nth = match self.ty {
            IndexType::Wide => u32::from_le_bytes(read(memory, at)?).wrapping_add(self.add),
            IndexType::Narrow => {
                u32::from(u16::from_le_bytes(read(memory, at)?).wrapping_add(self.add as u16))
            }
            IndexType::Constant => self.add,
        };
        // An index below the lower bound wraps to beyond the last element.
        if nth > self.last {
            return None;
        }
        let mut first = place(bases, self.from, self.of);
        if self.indirect {
            first = follow(memory, first)?;
        }
        Some((first as u32).wrapping_add(nth.wrapping_mul(self.stride)) as usize)
    }
}
