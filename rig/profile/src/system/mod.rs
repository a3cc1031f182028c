//! The system variables: structures by which the controller speaks of itself and is commanded (plcsystem: sections 1 to 7).
//!
//! The tables of the members in this folder are the only place that says what there is: the compiler's declarations, the
//! registers, the relocation table, the names that clients use and the page of the manual are made from them.

mod bus;
mod enumeration;
mod ethernet;
mod member;
mod plc;
mod registers;
mod serial;

pub use bus::{BusWrite, ModuleRead, ProfibusRead};
pub use enumeration::{ENUMERATIONS, Enumeration};
pub use ethernet::{EthernetRead, EthernetWrite};
pub use member::{MemberSource, MemberType, SystemMember};
pub use plc::{PlcRead, PlcWrite};
pub use registers::{
    READ_TABLE, REGISTER_RANGES, RESERVED_REGISTERS, RegisterPermission, RegisterRange, RegisterRangeKind,
    SYSTEM_REGISTERS, SYSTEM_WRITE_REGISTERS, TABLE_WORDS, WRITE_TABLE,
};
pub use serial::{SerialRead, SerialWrite};

use crate::{MODULE_INDICES, Profile, REFERENCES, Reference};
use std::fmt;

/// Version of the rig's firmware and of its boot firmware, aa.bb.cc.dd (rig definition).
pub const FIRMWARE_VERSION: [u8; 4] = [1, 0, 0, 0];
/// Vendor: Schneider Electric (controller:SYS-06).
pub const VENDOR_ID: u16 = 0x101A;
/// Name of the vendor (controller:SYS-06).
pub const VENDOR_NAME: &str = "Schneider Electric";
/// Serial number of the rig's controllers (rig definition).
pub const SERIAL_NUMBER: u32 = 0x0005_CA17;
/// Handles of files that can be open at once (rig definition).
pub const FILE_HANDLES: u16 = 64;
/// Elements of SERIAL_R and SERIAL_W (plcsystem: section 4).
pub const SERIAL_INDICES: usize = 2;

/// What may stand before the name of a structure (plcsystem:GVL-01).
pub const SYSTEM_NAMESPACE: &str = "PLC_GVL";

/// A system structure. Those whose names end in `_R` are only read (plcsystem:GVL-02).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum SystemStructure {
    /// The controller.
    PlcR,
    /// Commands to it.
    PlcW,
    /// Its serial lines.
    SerialR,
    /// Commands to them.
    SerialW,
    /// Its Ethernet interfaces.
    EthR,
    /// Commands to them.
    EthW,
    /// Its expansion modules.
    Tm3ModuleR,
    /// Commands to the expansion bus.
    Tm3BusW,
    /// A PROFIBUS slave.
    ProfibusR,
}

/// A member of a system structure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum SystemField {
    /// Of PLC_R.
    PlcR(PlcRead),
    /// Of PLC_W.
    PlcW(PlcWrite),
    /// Of an element of SERIAL_R.
    SerialR(SerialRead),
    /// Of an element of SERIAL_W.
    SerialW(SerialWrite),
    /// Of ETH_R.
    EthR(EthernetRead),
    /// Of ETH_W.
    EthW(EthernetWrite),
    /// Of an element of TM3_MODULE_R.
    Tm3ModuleR(ModuleRead),
    /// Of TM3_BUS_W.
    Tm3BusW(BusWrite),
    /// Of PROFIBUS_R.
    ProfibusR(ProfibusRead),
}

/// A single value of a system structure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SystemVariable {
    /// The member.
    pub field: SystemField,
    /// Which element of an array of structures, or which byte of a member that is an array of bytes; else 0.
    pub part: u8,
}

impl SystemStructure {
    /// Every structure, in the order of the documents.
    pub const ALL: [SystemStructure; 9] = [
        SystemStructure::PlcR,
        SystemStructure::PlcW,
        SystemStructure::SerialR,
        SystemStructure::SerialW,
        SystemStructure::EthR,
        SystemStructure::EthW,
        SystemStructure::Tm3ModuleR,
        SystemStructure::Tm3BusW,
        SystemStructure::ProfibusR,
    ];

    /// Its name.
    pub const fn name(self) -> &'static str {
        match self {
            SystemStructure::PlcR => "PLC_R",
            SystemStructure::PlcW => "PLC_W",
            SystemStructure::SerialR => "SERIAL_R",
            SystemStructure::SerialW => "SERIAL_W",
            SystemStructure::EthR => "ETH_R",
            SystemStructure::EthW => "ETH_W",
            SystemStructure::Tm3ModuleR => "TM3_MODULE_R",
            SystemStructure::Tm3BusW => "TM3_BUS_W",
            SystemStructure::ProfibusR => "PROFIBUS_R",
        }
    }

    /// How many elements it has where it is an array of structures.
    pub const fn elements(self) -> Option<usize> {
        match self {
            SystemStructure::SerialR | SystemStructure::SerialW => Some(SERIAL_INDICES),
            SystemStructure::Tm3ModuleR => Some(MODULE_INDICES),
            _ => None,
        }
    }

    /// Whether programs and clients only read it (plcsystem:GVL-02).
    pub const fn is_read_only(self) -> bool {
        matches!(
            self,
            SystemStructure::PlcR
                | SystemStructure::SerialR
                | SystemStructure::EthR
                | SystemStructure::Tm3ModuleR
                | SystemStructure::ProfibusR
        )
    }

    /// Its members, in their order.
    pub const fn members(self) -> &'static [SystemMember] {
        match self {
            SystemStructure::PlcR => plc::PLC_R,
            SystemStructure::PlcW => plc::PLC_W,
            SystemStructure::SerialR => serial::SERIAL_R,
            SystemStructure::SerialW => serial::SERIAL_W,
            SystemStructure::EthR => ethernet::ETH_R,
            SystemStructure::EthW => ethernet::ETH_W,
            SystemStructure::Tm3ModuleR => bus::TM3_MODULE_R,
            SystemStructure::Tm3BusW => bus::TM3_BUS_W,
            SystemStructure::ProfibusR => bus::PROFIBUS_R,
        }
    }

    /// The members that a controller of this profile has, in their order.
    pub fn members_of(self, profile: Profile) -> impl Iterator<Item = &'static SystemMember> {
        self.members().iter().filter(move |member| member.exists(profile))
    }

    /// Whether a controller of this profile has it.
    pub fn exists(self, profile: Profile) -> bool {
        self.members_of(profile).next().is_some()
    }

    /// The structure of this name, in any case of letters.
    pub fn find(name: &str) -> Option<SystemStructure> {
        SystemStructure::ALL.into_iter().find(|structure| structure.name().eq_ignore_ascii_case(name))
    }
}

impl SystemField {
    /// The structure that it is a member of.
    pub const fn structure(self) -> SystemStructure {
        match self {
            SystemField::PlcR(_) => SystemStructure::PlcR,
            SystemField::PlcW(_) => SystemStructure::PlcW,
            SystemField::SerialR(_) => SystemStructure::SerialR,
            SystemField::SerialW(_) => SystemStructure::SerialW,
            SystemField::EthR(_) => SystemStructure::EthR,
            SystemField::EthW(_) => SystemStructure::EthW,
            SystemField::Tm3ModuleR(_) => SystemStructure::Tm3ModuleR,
            SystemField::Tm3BusW(_) => SystemStructure::Tm3BusW,
            SystemField::ProfibusR(_) => SystemStructure::ProfibusR,
        }
    }

    /// Its line in the table.
    pub const fn member(self) -> &'static SystemMember {
        // The variants stand in the order of the table.
        let place = match self {
            SystemField::PlcR(field) => field as usize,
            SystemField::PlcW(field) => field as usize,
            SystemField::SerialR(field) => field as usize,
            SystemField::SerialW(field) => field as usize,
            SystemField::EthR(field) => field as usize,
            SystemField::EthW(field) => field as usize,
            SystemField::Tm3ModuleR(field) => field as usize,
            SystemField::Tm3BusW(field) => field as usize,
            SystemField::ProfibusR(field) => field as usize,
        };
        &self.structure().members()[place]
    }

    /// Whether programs and clients write it.
    pub const fn is_writable(self) -> bool {
        !self.structure().is_read_only()
    }

    /// The located member that covers a register, and which of its registers that is (controller:SYS-06).
    pub fn located(profile: Profile, register: u16) -> Option<(SystemField, u16)> {
        SystemStructure::ALL.into_iter().flat_map(|structure| structure.members_of(profile)).find_map(
            |member| {
                let word = register.checked_sub(member.register?)?;
                (word < member.ty(profile).words()).then_some((member.field, word))
            },
        )
    }

    /// Its single values in a controller of this profile; none of a text.
    pub fn variables(self, profile: Profile) -> impl Iterator<Item = SystemVariable> {
        let bytes = match self.member().ty(profile) {
            MemberType::Bytes(bytes) => usize::from(bytes),
            MemberType::Text(_) => 0,
            _ => 1,
        };
        let parts = self.structure().elements().map_or(bytes, |elements| elements * bytes);
        (0..parts).map(move |part| SystemVariable { field: self, part: part as u8 })
    }
}

impl SystemVariable {
    /// Every single value that a controller of this profile has, those of a structure in its order.
    pub fn all(profile: Profile) -> impl Iterator<Item = SystemVariable> {
        let elements = |structure: SystemStructure| 0..structure.elements().unwrap_or(1);
        SystemStructure::ALL.into_iter().flat_map(move |structure| {
            elements(structure).flat_map(move |element| {
                let members = structure.members_of(profile);
                members.flat_map(move |member| {
                    let is_array = structure.elements().is_some();
                    let of_element =
                        move |variable: &SystemVariable| !is_array || usize::from(variable.part) == element;
                    member.field.variables(profile).filter(of_element)
                })
            })
        })
    }

    /// The single value of this name that a controller of the profile has: as in `PLC_R.i_wStatus`, `TM3_MODULE_R[3].i_wModuleState`
    /// or `ETH_R.i_byIPAddress[0]`, in any case of letters, with or without `PLC_GVL.` before it.
    pub fn find(name: &str, profile: Profile) -> Option<SystemVariable> {
        let (name, byte) = match name.strip_suffix(']').and_then(|name| name.rsplit_once('[')) {
            Some((name, byte)) => (name, Some(index(byte)?)),
            None => (name, None),
        };
        let (member, element) = SystemMember::find(name, profile)?;
        let part = match (member.ty(profile), byte) {
            (MemberType::Bytes(bytes), Some(byte)) if byte < bytes => byte,
            (MemberType::Bytes(_) | MemberType::Text(_), _) | (_, Some(_)) => return None,
            (_, None) => element,
        };
        Some(SystemVariable { field: member.field, part })
    }

    /// Its type in a controller of this profile: BYTE for a byte of an array.
    pub const fn ty(self, profile: Profile) -> MemberType {
        match self.field.member().ty(profile) {
            MemberType::Bytes(_) => MemberType::Byte,
            ty => ty,
        }
    }

    /// Whether programs and clients write it.
    pub const fn is_writable(self) -> bool {
        self.field.is_writable()
    }

    /// Whether a controller of this profile has it.
    pub fn exists(self, profile: Profile) -> bool {
        self.field.member().exists(profile)
    }
}

impl fmt::Display for SystemVariable {
    /// As in `TM3_MODULE_R[3].i_wModuleState`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (structure, member) = (self.field.structure(), self.field.member());
        match structure.elements() {
            Some(_) => write!(f, "{}[{}].{}", structure.name(), self.part, member.name),
            // No byte array has another type in another profile.
            None if matches!(member.ty(Profile::M251_2024), MemberType::Bytes(_)) => {
                write!(f, "{}.{}[{}]", structure.name(), member.name, self.part)
            }
            None => write!(f, "{}.{}", structure.name(), member.name),
        }
    }
}

impl SystemMember {
    /// The member of this name that a controller of the profile has, and the element where its structure is an array: as in
    /// `PLC_R.i_sNodeName` or `SERIAL_R[1].i_uiSlaveNakCount`, in any case of letters, with or without `PLC_GVL.` before it.
    pub fn find(name: &str, profile: Profile) -> Option<(&'static SystemMember, u8)> {
        let (first, rest) = name.split_once('.')?;
        let (structure, member) = match first.eq_ignore_ascii_case(SYSTEM_NAMESPACE) {
            true => rest.split_once('.')?,
            false => (first, rest),
        };
        let (structure, element) = match structure.strip_suffix(']').and_then(|name| name.split_once('[')) {
            Some((structure, element)) => (structure, Some(index(element)?)),
            None => (structure, None),
        };
        let structure = SystemStructure::find(structure)?;
        let element = match (structure.elements(), element) {
            (Some(elements), Some(element)) if usize::from(element) < elements => element,
            (None, None) => 0,
            _ => return None,
        };
        let member = structure.members_of(profile).find(|known| known.is_named(member))?;
        Some((member, element))
    }
}

/// An index as it is written: digits alone.
fn index(text: &str) -> Option<u8> {
    text.bytes().all(|c| c.is_ascii_digit()).then(|| text.parse().ok()).flatten()
}

impl Reference {
    /// PLC_R.i_wProductID: its place in the table, from 1 (rig definition: the documents give no numbers).
    pub fn product_id(&self) -> u16 {
        let place = REFERENCES.iter().position(|reference| reference.name == self.name);
        place.and_then(|place| u16::try_from(place + 1).ok()).unwrap_or(0)
    }
}

/// Registers of a text of so many characters.
pub const fn text_words(characters: u16) -> u16 {
    (characters + 1).div_ceil(2)
}

#[cfg(test)]
mod tests;
