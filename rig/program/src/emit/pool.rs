//! Constants that code reads: each stands once, after the variables.

use std::collections::BTreeMap;

/// The constants from their first address on.
#[derive(Debug)]
pub(super) struct Pool {
    from: u32,
    pub bytes: Vec<u8>,
    cells: BTreeMap<(u8, u64), u32>,
    others: BTreeMap<Vec<u8>, u32>,
}

impl Pool {
    pub fn new(from: u32) -> Self {
        Pool { from, bytes: Vec::new(), cells: BTreeMap::new(), others: BTreeMap::new() }
    }

    /// The address of the low `width` bytes of a cell: 1, 2, 4 or 8.
    pub fn cell(&mut self, value: i64, width: u32) -> u32 {
        let width = width.clamp(1, 8);
        let bytes = value.to_le_bytes();
        let bytes = bytes.get(..width as usize).unwrap_or(&bytes);
        let key = bytes.iter().rev().fold(0u64, |n, byte| n << 8 | u64::from(*byte));
        if let Some(address) = self.cells.get(&(width as u8, key)) {
            return *address;
        }
        let address = self.add(bytes, width);
        self.cells.insert((width as u8, key), address);
        address
    }

    /// The address of a text or a block.
    pub fn block(&mut self, bytes: &[u8]) -> u32 {
        if let Some(address) = self.others.get(bytes) {
            return *address;
        }
        let address = self.add(bytes, 8);
        self.others.insert(bytes.to_vec(), address);
        address
    }

    fn add(&mut self, bytes: &[u8], align: u32) -> u32 {
        let place = self.bytes.len().next_multiple_of(align as usize);
        self.bytes.resize(place, 0);
        self.bytes.extend_from_slice(bytes);
        self.from.saturating_add(u32::try_from(place).unwrap_or(u32::MAX))
    }
}
