//! The map of the 65,536 registers that the network sees (controller:MEM-06, controller:MEM-07): the only place that says what
//! a register is and who may read and write it.

use crate::Profile;

/// First register of the located system variables (controller:MEM-06).
pub const SYSTEM_REGISTERS: u16 = 60_000;
/// First register of the read part of the relocation table (controller:REL-02).
pub const READ_TABLE: u16 = 60_200;
/// First register of the system variables that may be written; none is documented there (controller:MEM-06).
pub const SYSTEM_WRITE_REGISTERS: u16 = 62_000;
/// First register of the write part of the relocation table (controller:REL-02).
pub const WRITE_TABLE: u16 = 62_200;
/// Registers of each part of the relocation table (controller:REL-02).
pub const TABLE_WORDS: u16 = 1_800;
/// First register that nobody can reach (controller:MEM-06).
pub const RESERVED_REGISTERS: u16 = 64_000;

/// What the registers of a range are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum RegisterRangeKind {
    /// The words %MW of the program.
    Memory,
    /// The located system variables.
    System,
    /// The read part of the relocation table.
    ReadTable,
    /// System variables that may be written, of which there is none.
    SystemWrite,
    /// The write part of the relocation table.
    WriteTable,
    /// Nothing.
    Reserved,
}

/// What a request to a register may do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum RegisterPermission {
    /// Nothing.
    Nothing,
    /// Read.
    Read,
    /// Write.
    Write,
    /// Read and write.
    ReadWrite,
    /// Read 0, and write what is ignored.
    Ignored,
}

impl RegisterPermission {
    /// Whether it may read.
    pub const fn reads(self) -> bool {
        matches!(self, RegisterPermission::Read | RegisterPermission::ReadWrite | RegisterPermission::Ignored)
    }

    /// Whether it may write.
    pub const fn writes(self) -> bool {
        matches!(
            self,
            RegisterPermission::Write | RegisterPermission::ReadWrite | RegisterPermission::Ignored
        )
    }

    /// In words.
    pub const fn name(self) -> &'static str {
        match self {
            RegisterPermission::Nothing => "exception 02",
            RegisterPermission::Read => "read",
            RegisterPermission::Write => "write",
            RegisterPermission::ReadWrite => "read and write",
            RegisterPermission::Ignored => "reads 0, writes are ignored",
        }
    }
}

/// A range of registers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RegisterRange {
    /// The first register.
    pub first: u16,
    /// The last one.
    pub last: u16,
    /// What they are.
    pub kind: RegisterRangeKind,
    /// The same in words.
    pub meaning: &'static str,
    /// The requirement that says so.
    pub requirement: &'static str,
}

const fn range(
    first: u16,
    last: u16,
    kind: RegisterRangeKind,
    meaning: &'static str,
    requirement: &'static str,
) -> RegisterRange {
    RegisterRange { first, last, kind, meaning, requirement }
}

/// Every register, in order and without a gap.
pub const REGISTER_RANGES: [RegisterRange; 6] = [
    range(
        0,
        SYSTEM_REGISTERS - 1,
        RegisterRangeKind::Memory,
        "the words %MW0 to %MW59999",
        "plcsystem:GVL-05",
    ),
    range(
        SYSTEM_REGISTERS,
        READ_TABLE - 1,
        RegisterRangeKind::System,
        "located system variables; 0 between them",
        "plcsystem:GVL-03",
    ),
    range(
        READ_TABLE,
        READ_TABLE + TABLE_WORDS - 1,
        RegisterRangeKind::ReadTable,
        "the read part of the relocation table",
        "plcsystem:GVL-10",
    ),
    range(
        SYSTEM_WRITE_REGISTERS,
        WRITE_TABLE - 1,
        RegisterRangeKind::SystemWrite,
        "no variable is documented here",
        "plcsystem:GVL-07",
    ),
    range(
        WRITE_TABLE,
        WRITE_TABLE + TABLE_WORDS - 1,
        RegisterRangeKind::WriteTable,
        "the write part of the relocation table",
        "plcsystem:GVL-10",
    ),
    range(RESERVED_REGISTERS, u16::MAX, RegisterRangeKind::Reserved, "reserved", "plcsystem:GVL-07"),
];

impl RegisterRange {
    /// The range of a register.
    pub const fn of(register: u16) -> &'static RegisterRange {
        let mut place = 0;
        while register > REGISTER_RANGES[place].last {
            place += 1;
        }
        &REGISTER_RANGES[place]
    }

    /// What a request may do with one of its registers (controller:MEM-07, plcsystem:GVL-13); `declared` says whether a row of
    /// the relocation table covers it, which matters in its two parts alone.
    pub const fn permission(&self, profile: Profile, declared: bool) -> RegisterPermission {
        let first_edition = matches!(profile, Profile::M241_2014);
        match self.kind {
            RegisterRangeKind::Memory => RegisterPermission::ReadWrite,
            RegisterRangeKind::System => RegisterPermission::Read,
            RegisterRangeKind::ReadTable if first_edition && !declared => RegisterPermission::ReadWrite,
            RegisterRangeKind::ReadTable => RegisterPermission::Read,
            RegisterRangeKind::WriteTable if first_edition && declared => RegisterPermission::Write,
            RegisterRangeKind::WriteTable => RegisterPermission::ReadWrite,
            RegisterRangeKind::SystemWrite => RegisterPermission::Ignored,
            RegisterRangeKind::Reserved => RegisterPermission::Nothing,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // controller:MEM-06
    #[test]
    fn the_ranges_are_every_register_once() {
        let mut next = 0u32;
        for range in REGISTER_RANGES {
            assert_eq!(u32::from(range.first), next);
            for register in [range.first, range.last] {
                assert_eq!(RegisterRange::of(register), &range, "{register}");
            }
            next = u32::from(range.last) + 1;
        }
        assert_eq!(next, 65_536);
    }

    // plcsystem:GVL-13
    #[test]
    fn who_may_do_what() {
        use RegisterPermission::{Ignored, Nothing, Read, ReadWrite, Write};
        for (register, first, later) in [
            (59_999, [ReadWrite; 2], [ReadWrite; 2]),
            (60_199, [Read; 2], [Read; 2]),
            (61_999, [ReadWrite, Read], [Read; 2]),
            (62_199, [Ignored; 2], [Ignored; 2]),
            (63_999, [ReadWrite, Write], [ReadWrite; 2]),
            (64_000, [Nothing; 2], [Nothing; 2]),
        ] {
            let of = |profile| {
                [false, true].map(|declared| RegisterRange::of(register).permission(profile, declared))
            };
            assert_eq!(of(Profile::M241_2014), first, "{register}");
            assert_eq!(of(Profile::M241_2019), later, "{register}");
            assert_eq!(of(Profile::M251_2024), later, "{register}");
        }
    }
}
