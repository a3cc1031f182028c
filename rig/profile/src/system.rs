//! System variables that the network sees: fields of PLC_R and PLC_W with their registers (controller:SYS-06).

use crate::{Profile, REFERENCES, Reference};

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

/// A field of a system structure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SystemField {
    /// PLC_R.i_wVendorID.
    VendorId,
    /// PLC_R.i_wProductID.
    ProductId,
    /// PLC_R.i_dwSerialNumber.
    SerialNumber,
    /// PLC_R.i_byFirmVersion.
    FirmwareVersion,
    /// PLC_R.i_byBootVersion.
    BootVersion,
    /// PLC_R.i_dwHardVersion.
    HardwareVersion,
    /// PLC_R.i_dwChipVersion.
    CoprocessorVersion,
    /// PLC_R.i_wStatus.
    Status,
    /// PLC_R.i_wBootProjectStatus.
    BootProjectStatus,
    /// PLC_R.i_wLastStopCause.
    LastStopCause,
    /// PLC_R.i_wLastApplicationError.
    LastApplicationError,
    /// PLC_R.i_lwSystemFault_1.
    SystemFault1,
    /// PLC_R.i_lwSystemFault_2.
    SystemFault2,
    /// PLC_R.i_wIOStatus1.
    IoStatus1,
    /// PLC_R.i_wIOStatus2.
    IoStatus2,
    /// PLC_R.i_wClockBatterystatus.
    Battery,
    /// PLC_R.i_dwAppliSignature1 to 4, from 0.
    Signature(u8),
    /// PLC_R.i_sVendorName.
    VendorName,
    /// PLC_R.i_sProductRef.
    ProductReference,
    /// PLC_R.i_sNodeName.
    NodeName,
    /// PLC_R.i_dwLastStopTime.
    LastStopTime,
    /// PLC_R.i_dwLastPowerOffDate.
    LastPowerOffDate,
    /// PLC_R.i_wUsrFreeFileHdl.
    FreeFileHandles,
    /// PLC_R.i_udiUsrFsTotalBytes.
    TotalBytes,
    /// PLC_R.i_udiUsrFsFreeBytes.
    FreeBytes,
    /// PLC_R.i_wTerminalPortStatus.
    TerminalPort,
    /// PLC_R.i_wSdCardStatus.
    SdCard,
    /// PLC_R.i_uiTM3BusState.
    Tm3Bus,
    /// PLC_R.i_uiEventsCounter.
    EventsCounter,
    /// PLC_R.i_ExpertIO_RunStop_Input.
    RunStopInput,
    /// PLC_W.q_wPLCControl.
    PlcControl,
    /// PLC_W.q_uiOpenPLCControl.
    OpenPlcControl,
    /// A word that a client writes, by its place: PLC_W.q_wResetCounterEvent, ETH_W.q_wResetCounter.
    Writable(u8),
}

/// Words of [`SystemField::Writable`].
pub const WRITABLE_FIELDS: usize = 2;

use SystemField as Field;

/// Name, field, and register where it is located (controller:SYS-06).
const FIELDS: &[(&str, SystemField, Option<u16>)] = &[
    ("PLC_R.i_wVendorID", Field::VendorId, Some(60_000)),
    ("PLC_R.i_wProductID", Field::ProductId, Some(60_001)),
    ("PLC_R.i_dwSerialNumber", Field::SerialNumber, Some(60_002)),
    ("PLC_R.i_byFirmVersion", Field::FirmwareVersion, Some(60_004)),
    ("PLC_R.i_byBootVersion", Field::BootVersion, Some(60_006)),
    ("PLC_R.i_dwHardVersion", Field::HardwareVersion, Some(60_008)),
    ("PLC_R.i_dwChipVersion", Field::CoprocessorVersion, Some(60_010)),
    ("PLC_R.i_wStatus", Field::Status, Some(60_012)),
    ("PLC_R.i_wBootProjectStatus", Field::BootProjectStatus, Some(60_013)),
    ("PLC_R.i_wLastStopCause", Field::LastStopCause, Some(60_014)),
    ("PLC_R.i_wLastApplicationError", Field::LastApplicationError, Some(60_015)),
    ("PLC_R.i_lwSystemFault_1", Field::SystemFault1, Some(60_016)),
    ("PLC_R.i_lwSystemFault_2", Field::SystemFault2, Some(60_020)),
    ("PLC_R.i_wIOStatus1", Field::IoStatus1, Some(60_024)),
    ("PLC_R.i_wIOStatus2", Field::IoStatus2, Some(60_025)),
    ("PLC_R.i_wClockBatterystatus", Field::Battery, Some(60_026)),
    ("PLC_R.i_dwAppliSignature1", Field::Signature(0), Some(60_028)),
    ("PLC_R.i_dwAppliSignature2", Field::Signature(1), Some(60_030)),
    ("PLC_R.i_dwAppliSignature3", Field::Signature(2), Some(60_032)),
    ("PLC_R.i_dwAppliSignature4", Field::Signature(3), Some(60_034)),
    ("PLC_R.i_sVendorName", Field::VendorName, None),
    ("PLC_R.i_sProductRef", Field::ProductReference, None),
    ("PLC_R.i_sNodeName", Field::NodeName, None),
    ("PLC_R.i_dwLastStopTime", Field::LastStopTime, None),
    ("PLC_R.i_dwLastPowerOffDate", Field::LastPowerOffDate, None),
    ("PLC_R.i_wUsrFreeFileHdl", Field::FreeFileHandles, None),
    ("PLC_R.i_udiUsrFsTotalBytes", Field::TotalBytes, None),
    ("PLC_R.i_udiUsrFsFreeBytes", Field::FreeBytes, None),
    ("PLC_R.i_wTerminalPortStatus", Field::TerminalPort, None),
    ("PLC_R.i_wSdCardStatus", Field::SdCard, None),
    ("PLC_R.i_uiTM3BusState", Field::Tm3Bus, None),
    ("PLC_R.i_uiEventsCounter", Field::EventsCounter, None),
    ("PLC_R.i_ExpertIO_RunStop_Input", Field::RunStopInput, None),
    ("PLC_W.q_wPLCControl", Field::PlcControl, None),
    ("PLC_W.q_uiOpenPLCControl", Field::OpenPlcControl, None),
    ("PLC_W.q_wResetCounterEvent", Field::Writable(0), None),
    ("ETH_W.q_wResetCounter", Field::Writable(1), None),
];

impl SystemField {
    /// The field of this name, in any case of letters; `PLC_GVL.` may stand before it.
    pub fn find(name: &str) -> Option<SystemField> {
        let prefix = "PLC_GVL.";
        let name = match name.get(..prefix.len()) {
            Some(start) if start.eq_ignore_ascii_case(prefix) => &name[prefix.len()..],
            _ => name,
        };
        FIELDS.iter().find(|(known, ..)| known.eq_ignore_ascii_case(name)).map(|(_, field, _)| *field)
    }

    /// The located field that covers a register, and which of its words it is. An M251 has no second error field and
    /// no embedded inputs and outputs: those registers are empty there.
    pub fn located(profile: Profile, register: u16) -> Option<(SystemField, u16)> {
        let covers = |(_, field, first): &(&str, SystemField, Option<u16>)| {
            let word = register.checked_sub((*first)?)?;
            (word < field.words(profile)).then_some((*field, word))
        };
        let missing = |field| matches!(field, Field::SystemFault2 | Field::IoStatus1);
        let found = FIELDS.iter().find_map(covers);
        found.filter(|(field, _)| profile != Profile::M251_2024 || !missing(*field))
    }

    /// How many registers it takes (controller:REL-04). A text of n characters takes n + 1 bytes.
    pub const fn words(self, profile: Profile) -> u16 {
        match self {
            Field::SerialNumber
            | Field::FirmwareVersion
            | Field::BootVersion
            | Field::HardwareVersion
            | Field::CoprocessorVersion
            | Field::Signature(_)
            | Field::LastStopTime
            | Field::LastPowerOffDate
            | Field::TotalBytes
            | Field::FreeBytes => 2,
            Field::SystemFault1 | Field::SystemFault2 => 4,
            Field::VendorName | Field::ProductReference => text_words(31),
            Field::NodeName => match profile {
                Profile::M241_2014 | Profile::M241_2019 => text_words(31),
                Profile::M251_2024 => text_words(99),
            },
            _ => 1,
        }
    }

    /// Whether the application or a client may write it.
    pub const fn is_writable(self) -> bool {
        matches!(self, Field::PlcControl | Field::OpenPlcControl | Field::Writable(_))
    }
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
mod tests {
    use super::*;

    // controller:SYS-06
    #[test]
    fn fields_fill_the_block_without_overlap() {
        let profile = Profile::M241_2019;
        let mut next = SYSTEM_REGISTERS;
        for (name, field, register) in FIELDS {
            let Some(register) = register else { continue };
            // 60027 is empty.
            let gap = if *register == 60_028 { 1 } else { 0 };
            assert_eq!(*register, next + gap, "{name}");
            next = register + field.words(profile);
            assert_eq!(SystemField::located(profile, *register), Some((*field, 0)));
        }
        assert_eq!(next, 60_036);
        assert_eq!(SystemField::located(profile, 60_027), None);
        assert_eq!(SystemField::located(Profile::M251_2024, 60_020), None);
        assert_eq!(SystemField::find("plc_gvl.plc_r.I_WSTATUS"), Some(Field::Status));
    }
}
