//! The registers that the network sees: %MW, the system variables and the relocation table (controller:MEM-06,
//! controller:MEM-07).

use crate::config::RelocationPart;
use crate::relocation::RelocationTable;
use profile::{RegisterRangeKind, TABLE_WORDS};
use signal::{Address, Area, Size};

/// Why registers were not read or written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RegisterError {
    /// No service answers in this state.
    NoAnswer,
    /// Illegal data address, exception 02: reserved, or closed to this kind of access.
    IllegalAddress,
}

/// The part of the relocation table that a range of the register map is.
pub(crate) const fn part_of(kind: RegisterRangeKind) -> Option<RelocationPart> {
    match kind {
        RegisterRangeKind::ReadTable => Some(RelocationPart::Read),
        RegisterRangeKind::WriteTable => Some(RelocationPart::Write),
        _ => None,
    }
}

/// Registers that belong to no variable, and the relocation table.
#[derive(Debug)]
pub(crate) struct Registers {
    table: RelocationTable,
    /// Registers of the read and the write table that no row covers.
    loose: [Box<[u16]>; 2],
}

impl Default for Registers {
    fn default() -> Self {
        let words = || vec![0; usize::from(TABLE_WORDS)].into_boxed_slice();
        Registers { table: RelocationTable::default(), loose: [words(), words()] }
    }
}

impl Registers {
    /// The relocation table.
    pub(crate) const fn table(&self) -> &RelocationTable {
        &self.table
    }

    /// The relocation table is this one from now on.
    pub(crate) fn set_table(&mut self, table: RelocationTable) {
        self.table = table;
    }

    /// A register that no row of the table covers.
    pub(crate) fn loose(&self, part: RelocationPart, register: u16) -> u16 {
        self.loose[part as usize].get(usize::from(register - part.first())).copied().unwrap_or(0)
    }

    /// Writes a register that no row of the table covers.
    pub(crate) fn set_loose(&mut self, part: RelocationPart, register: u16, value: u16) {
        if let Some(place) = self.loose[part as usize].get_mut(usize::from(register - part.first())) {
            *place = value;
        }
    }
}

/// The word of memory behind a register.
pub(crate) fn word_address(register: u16) -> Option<Address> {
    Address::new(Area::Memory, Size::Word, u32::from(register))
}

/// One of the four words of an application's signature, which change together.
pub(crate) fn signature_word(signature: u64, place: u8) -> u64 {
    if signature == 0 {
        return 0;
    }
    let mut mixed = signature ^ u64::from(place).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    mixed = (mixed ^ mixed >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    (mixed ^ mixed >> 31) & 0xFFFF_FFFF
}
