//! The documented controllers as tables: profiles, references, channels, limits, codes and figures.
//!
//! Everything that differs between the M241 of 2014, the M241 of 2019 and the M251 of 2024 is read from here, and
//! every figure names the requirement behind it. Figures that no document gives are marked `rig definition`.
//! Not goals: behaviour. These are constants and look-ups only.

mod channel;
mod channel_set;
mod codes;
mod expert;
mod figures;
mod input;
mod io_channel;
mod limits;
mod module;
mod port;
mod reference;
mod system;
mod tree;

pub use channel::{
    EmbeddedInput, EmbeddedOutput, InputKind, OutputKind, inputs, outputs, protection_groups,
    rearming_command, short_circuit_status,
};
pub use channel_set::{ChannelNumbers, ChannelSet};
pub use codes::{
    ApplicationError, BootProjectStatus, ExchangeCode, IoStatus, ModuleState, NO_FIRMWARE_VERSION, PLC_W_KEY,
    PlcCommand, PlcStatus, StopCause, Tm3BusState,
};
pub use expert::{
    ExpertLimits, FAST_INPUTS, FAST_OUTPUTS, GENERATOR_TENTHS, PWM_TENTHS, REGULAR_OUTPUT_TENTHS,
};
pub use figures::{
    BOOT_APPLICATION_SAVE, BOOT_STAGES, CLOCK_AT_FIRST_POWER_ON, EVENT_LATENCY, EVENT_WINDOW,
    FREEWHEELING_PAUSE, InstructionCosts, LOAD_PERIOD, LOAD_WINDOW, MINIMUM_CYCLE, NON_VOLATILE_SAVE,
    OUTPUT_INITIALIZATION, OVERLOAD_PERCENT, PROTECTION_RETRY, PROTECTION_TEST, RequestCosts, SHORT_INTERVAL,
    SHORT_INTERVAL_TOLERANCE, SYSTEM_WATCHDOG_FULL_LOAD, SYSTEM_WATCHDOG_OVERLOAD, SYSTEM_WATCHDOG_STARVED,
    TIME_SLICE, TRIGGER_TICK,
};
pub use input::{EventEdges, input_level};
pub use io_channel::IoChannel;
pub use limits::{
    APPLICATION_BYTES, BounceFilter, DEFAULT_PRIORITY, FOREGROUND_PRIORITIES, IMAGE_BITS, InputFilter,
    MEMORY_WORDS, PRIORITIES, REMANENT_BYTES, REMANENT_WORDS, TaskLimits,
};
pub use module::{
    AnalogueChannels, AnalogueEnds, AnalogueInputSettings, AnalogueMode, AnalogueOutputSettings,
    ChannelAddresses, ChannelStatus, CompositionError, CompositionFault, ConfiguredModule, Conversion,
    CountRange, DigitalInputs, DigitalOutputKind, DigitalOutputs, FigureSource, ImageFull, LOCAL_MODULES,
    MODULE_INDICES, ModuleAddresses, ModuleChain, ModuleFamily, ModuleKind, ModuleType, REMOTE_MODULES,
    SafetyFunction, TM4_MODULES, TemperatureScope, check_modules, module_indices,
};
pub use port::{Port, PortKind, SerialMedia};
pub use reference::{Family, REFERENCES, Reference, RegularOutputs};
pub use system::{
    BusWrite, ENUMERATIONS, Enumeration, EthernetRead, EthernetWrite, FILE_HANDLES, FIRMWARE_VERSION,
    MemberSource, MemberType, ModuleRead, PlcRead, PlcWrite, ProfibusRead, READ_TABLE, REGISTER_RANGES,
    RESERVED_REGISTERS, RegisterPermission, RegisterRange, RegisterRangeKind, SERIAL_INDICES, SERIAL_NUMBER,
    SYSTEM_NAMESPACE, SYSTEM_REGISTERS, SYSTEM_WRITE_REGISTERS, SerialRead, SerialWrite, SystemField,
    SystemMember, SystemStructure, SystemVariable, TABLE_WORDS, VENDOR_ID, VENDOR_NAME, WRITE_TABLE,
    text_words,
};
pub use tree::{FLASH_BYTES, SYSTEM_LOG_BYTES, TreeEntry, USER_DISK_BYTES};

use signal::{AddressLimits, Span};
use std::fmt;

/// Which documented controller is reproduced (controller:CONV-01). Figures of two profiles are never mixed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Profile {
    /// M241 as of 2014 (`P14` in the specification).
    M241_2014,
    /// M241 as of 2019 (`P19`), the default.
    #[default]
    M241_2019,
    /// M251 as of 2024 (`P51`).
    M251_2024,
}

/// A text that names no profile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnknownProfile;

impl fmt::Display for UnknownProfile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("no such profile: use m241-2014, m241-2019 or m251-2024")
    }
}

impl std::error::Error for UnknownProfile {}

impl Profile {
    /// Every profile, oldest first.
    pub const ALL: [Profile; 3] = [Profile::M241_2014, Profile::M241_2019, Profile::M251_2024];

    /// The name used in configuration and reports.
    pub const fn name(self) -> &'static str {
        match self {
            Profile::M241_2014 => "m241-2014",
            Profile::M241_2019 => "m241-2019",
            Profile::M251_2024 => "m251-2024",
        }
    }

    /// Least and most correction of the clock in seconds a week (controller:DEV-22). The narrower limits of older
    /// firmware stand for the M241 of 2014.
    pub const fn rtc_drift(self) -> (i64, i64) {
        match self {
            Profile::M241_2014 => (-29, 29),
            Profile::M241_2019 | Profile::M251_2024 => (-36, 73),
        }
    }

    /// The family whose references the profile accepts.
    pub const fn family(self) -> Family {
        match self {
            Profile::M241_2014 | Profile::M241_2019 => Family::M241,
            Profile::M251_2024 => Family::M251,
        }
    }

    /// The reference in use where the configuration names none (controller:CONV-01).
    pub fn default_reference(self) -> &'static Reference {
        // Both names are rows of the table (tested), so the fallback is never taken.
        let name = match self.family() {
            Family::M241 => "TM241CEC24T",
            Family::M251 => "TM251MESC",
        };
        Reference::find(name).unwrap_or(&REFERENCES[0])
    }

    /// Whether the profile describes this reference (io:REF-01, controller:HW-04).
    pub fn accepts(self, reference: &Reference) -> bool {
        reference.family == self.family()
    }

    /// The references that the profile accepts, in the order of the table.
    pub fn references(self) -> impl Iterator<Item = &'static Reference> {
        REFERENCES.iter().filter(move |reference| self.accepts(reference))
    }

    /// How many tasks of each kind an application may have on this reference (controller:TASK-01).
    pub fn task_limits(self, reference: &Reference) -> TaskLimits {
        TaskLimits::of(self, reference)
    }

    /// Most events within [`EVENT_WINDOW`] (controller:TASK-31, controller:TASK-43).
    pub const fn event_limit(self) -> usize {
        match self {
            Profile::M241_2014 => 5,
            Profile::M241_2019 | Profile::M251_2024 => 6,
        }
    }

    /// How far %I, %Q and %M reach (controller:ADDR-02, io:ADR-06).
    pub const fn address_limits(self) -> AddressLimits {
        AddressLimits { input_bits: IMAGE_BITS, output_bits: IMAGE_BITS, memory_words: MEMORY_WORDS }
    }

    /// Most characters that a STRING or WSTRING may be declared with (controller:DT-01): the documents end an M241's at
    /// 255 and state no limit of an M251's.
    pub const fn longest_text(self) -> u32 {
        match self.family() {
            Family::M241 => 255,
            Family::M251 => 65_535,
        }
    }

    /// How long the controller keeps running after its supply is interrupted: 4 ms for an M241
    /// (controller:HW-09), 10 ms for an M251 (controller:HW-08).
    pub const fn hold_up(self) -> Span {
        match self.family() {
            Family::M241 => Span::from_millis(4),
            Family::M251 => Span::from_millis(10),
        }
    }

    /// After how long without a power cycle the controller warns that one is due, none where the documents ask for none
    /// (controller:RB-05).
    pub const fn longest_without_power_cycle(self) -> Option<Span> {
        match self {
            Profile::M241_2014 => None,
            Profile::M241_2019 | Profile::M251_2024 => Some(Span::from_secs(365 * 86_400)),
        }
    }

    /// The highest frequency of a regular input in Hz (controller:HW-03, io:REF-03), none without embedded inputs.
    pub const fn regular_input_hertz(self) -> Option<u32> {
        match self {
            Profile::M241_2014 => Some(5_000),
            Profile::M241_2019 => Some(1_000),
            Profile::M251_2024 => None,
        }
    }

    /// The processor time that requests of clients take (rig definition, the same in every profile).
    pub const fn request_costs(self) -> RequestCosts {
        RequestCosts::RIG
    }

    /// Duration of the instructions (controller:PERF-01, the same in every profile).
    pub const fn instruction_costs(self) -> InstructionCosts {
        InstructionCosts::DOCUMENTED
    }
}

impl fmt::Display for Profile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl std::str::FromStr for Profile {
    type Err = UnknownProfile;

    /// Reads a profile's name, in any case.
    fn from_str(text: &str) -> Result<Self, UnknownProfile> {
        Profile::ALL
            .into_iter()
            .find(|profile| profile.name().eq_ignore_ascii_case(text))
            .ok_or(UnknownProfile)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_read_back() {
        for profile in Profile::ALL {
            assert_eq!(profile.to_string().parse(), Ok(profile));
            assert_eq!(profile.name().to_uppercase().parse(), Ok(profile));
        }
        assert_eq!("m241".parse::<Profile>(), Err(UnknownProfile));
        assert_eq!(Profile::default().name(), "m241-2019");
    }

    // controller:CONV-01
    #[test]
    fn defaults_are_rows_of_the_table() {
        for (profile, name) in Profile::ALL.into_iter().zip(["TM241CEC24T", "TM241CEC24T", "TM251MESC"]) {
            assert_eq!(profile.default_reference().name, name);
            assert!(profile.accepts(profile.default_reference()));
        }
    }

    // io:REF-01, controller:HW-02, controller:HW-04
    #[test]
    fn families_share_out_the_references() {
        assert_eq!(Profile::M241_2014.references().count(), 15);
        assert_eq!(Profile::M241_2019.references().count(), 15);
        assert_eq!(Profile::M251_2024.references().count(), 2);
    }
}
