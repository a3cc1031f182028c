//! What the documents say of a cartridge or an expansion module (io: sections 9 and 10), as data.
//!
//! The figures themselves stand in the pages of the crate `catalogue`; here is what a figure is.

mod analogue;
mod channel_settings;
mod channel_status;
mod composition;
mod configured;
mod digital;
mod layout;

pub use analogue::{AnalogueChannels, AnalogueMode, Conversion};
pub use channel_settings::{
    AnalogueEnds, AnalogueInputSettings, AnalogueOutputSettings, CountRange, TemperatureScope,
};
pub use channel_status::ChannelStatus;
pub use composition::{
    CompositionError, CompositionFault, LOCAL_MODULES, MODULE_INDICES, ModuleChain, REMOTE_MODULES,
    TM4_MODULES, check_modules, module_indices,
};
pub use configured::ConfiguredModule;
pub use digital::{DigitalInputs, DigitalOutputKind, DigitalOutputs};
pub use layout::{ChannelAddresses, ImageFull, ModuleAddresses};

use crate::Profile;

/// A family of modules (io: 10.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ModuleFamily {
    /// Expansion modules of the older family: last in the local configuration (io:BUS-02).
    Tm2,
    /// Expansion modules, local and remote.
    Tm3,
    /// Communication modules, on a connector of their own (io:BUS-04).
    Tm4,
    /// Cartridges in the controller (io:CART-01).
    Tmc4,
}

impl ModuleFamily {
    /// Every family.
    pub const ALL: [ModuleFamily; 4] =
        [ModuleFamily::Tm2, ModuleFamily::Tm3, ModuleFamily::Tm4, ModuleFamily::Tmc4];

    /// The name that references of the family begin with, as in `TM3`.
    pub const fn name(self) -> &'static str {
        match self {
            ModuleFamily::Tm2 => "TM2",
            ModuleFamily::Tm3 => "TM3",
            ModuleFamily::Tm4 => "TM4",
            ModuleFamily::Tmc4 => "TMC4",
        }
    }
}

/// What a module is for, in the words of the hardware guides.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ModuleKind {
    /// Digital inputs, outputs or both.
    Digital,
    /// Analogue and temperature inputs, outputs or both.
    Analogue,
    /// A function of its own: motor starters, fast counting.
    Expert,
    /// A function of machine safety. A rig models it and is no safety device.
    Safety,
    /// A network or fieldbus.
    Communication,
    /// The transmitter, last module of the local configuration (io:BUS-01).
    Transmitter,
    /// The receiver, before the remote modules (io:BUS-01).
    Receiver,
}

impl ModuleKind {
    /// Every kind.
    pub const ALL: [ModuleKind; 7] = [
        ModuleKind::Digital,
        ModuleKind::Analogue,
        ModuleKind::Expert,
        ModuleKind::Safety,
        ModuleKind::Communication,
        ModuleKind::Transmitter,
        ModuleKind::Receiver,
    ];

    /// The word for it.
    pub const fn name(self) -> &'static str {
        match self {
            ModuleKind::Digital => "digital",
            ModuleKind::Analogue => "analogue",
            ModuleKind::Expert => "expert",
            ModuleKind::Safety => "safety",
            ModuleKind::Communication => "communication",
            ModuleKind::Transmitter => "transmitter",
            ModuleKind::Receiver => "receiver",
        }
    }

    /// Whether it is one of the two modules of the link to remote modules, which nothing counts (io:BUS-01).
    pub const fn is_link(self) -> bool {
        matches!(self, ModuleKind::Transmitter | ModuleKind::Receiver)
    }
}

/// Where a figure is from that the documents of the controllers do not give.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FigureSource {
    /// The key of the figure in its page, as in `digital-outputs.on-delay`; `all` for everything of the module.
    pub figure: String,
    /// In plain words, as in `rig definition`.
    pub source: String,
}

/// The function of a safety module (io: 10.3).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SafetyFunction {
    /// How many functions it has.
    pub functions: u8,
    /// The category that it reaches at most.
    pub category: u8,
    /// The numbers of safety inputs that it can be wired for.
    pub inputs: Vec<u8>,
    /// Whether the document says that its start is not monitored.
    pub non_monitored_start: bool,
}

/// A module as it can be chosen by its reference. What nobody knows is absent.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ModuleType {
    /// The commercial reference, as in `TM3AI4`.
    pub reference: String,
    /// Its family.
    pub family: ModuleFamily,
    /// What it is for.
    pub kind: ModuleKind,
    /// The internal ID code, by which alone the controller knows modules (io:OPT-04); none for links, TM4 and cartridges.
    pub id: Option<u8>,
    /// The profiles that know it (io: 10.1).
    pub profiles: Vec<Profile>,
    /// How wires are connected, in the words of the hardware guide.
    pub terminals: Option<String>,
    /// Digital inputs.
    pub digital_inputs: Option<DigitalInputs>,
    /// Digital outputs.
    pub digital_outputs: Option<DigitalOutputs>,
    /// Analogue inputs.
    pub analogue_inputs: Option<AnalogueChannels>,
    /// Analogue outputs.
    pub analogue_outputs: Option<AnalogueChannels>,
    /// The function of a safety module.
    pub safety: Option<SafetyFunction>,
    /// The version that TM3_GetModuleFWVersion gives (io:DIAG-05).
    pub firmware: Option<u16>,
    /// What else is to be known, a sentence.
    pub note: Option<String>,
    /// The figures that are not from the documents of the controllers.
    pub sources: Vec<FigureSource>,
}

impl ModuleType {
    /// A module of which nothing but its reference is known yet.
    pub fn new(reference: impl Into<String>, family: ModuleFamily, kind: ModuleKind) -> ModuleType {
        ModuleType {
            reference: reference.into(),
            family,
            kind,
            id: None,
            profiles: Vec::new(),
            terminals: None,
            digital_inputs: None,
            digital_outputs: None,
            analogue_inputs: None,
            analogue_outputs: None,
            safety: None,
            firmware: None,
            note: None,
            sources: Vec::new(),
        }
    }

    /// Whether it takes one of the positions of the expansion bus, and so an index of TM3_MODULE_R (io:BUS-05).
    pub const fn is_on_bus(&self) -> bool {
        matches!(self.family, ModuleFamily::Tm2 | ModuleFamily::Tm3) && !self.kind.is_link()
    }

    /// Whether it has terminals for a supply of its own, which its analogue channels and transistor outputs need (rig definition:
    /// no document says of each module where it takes its supply from). Relays and safety modules work from the bus.
    pub fn has_own_supply(&self) -> bool {
        let transistors =
            |outputs: &DigitalOutputs| outputs.kind.is_some_and(|kind| kind != DigitalOutputKind::Relay);
        self.kind == ModuleKind::Analogue || self.digital_outputs.as_ref().is_some_and(transistors)
    }

    /// Number of digital inputs.
    pub fn digital_input_count(&self) -> u32 {
        self.digital_inputs.as_ref().map_or(0, |inputs| inputs.count)
    }

    /// Number of digital outputs.
    pub fn digital_output_count(&self) -> u32 {
        self.digital_outputs.as_ref().map_or(0, |outputs| outputs.count)
    }

    /// Number of analogue inputs, each a word of %I.
    pub fn analogue_input_count(&self) -> u32 {
        self.analogue_inputs.as_ref().map_or(0, |inputs| inputs.count)
    }

    /// Number of analogue outputs, each a word of %Q.
    pub fn analogue_output_count(&self) -> u32 {
        self.analogue_outputs.as_ref().map_or(0, |outputs| outputs.count)
    }

    /// Number of status bytes where *Status Enabled* is chosen: one for each analogue channel, inputs first
    /// (io:DIAG-06).
    pub fn status_bytes(&self) -> u32 {
        self.analogue_input_count() + self.analogue_output_count()
    }

    /// Where a figure is from, if it is not from the documents.
    pub fn source(&self, figure: &str) -> Option<&str> {
        let of = |name: &str| self.sources.iter().find(|one| one.figure == name);
        of(figure).or_else(|| of("all")).map(|one| one.source.as_str())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_figure_has_the_source_of_its_own_before_that_of_all() {
        let mut module = ModuleType::new("TM3DI8", ModuleFamily::Tm3, ModuleKind::Digital);
        assert_eq!(module.source("id"), None);
        for (figure, source) in [("all", "rig definition"), ("id", "a data sheet")] {
            module.sources.push(FigureSource { figure: figure.into(), source: source.into() });
        }
        assert_eq!(
            (module.source("id"), module.source("firmware")),
            (Some("a data sheet"), Some("rig definition"))
        );
    }

    // io:BUS-01, io:BUS-05
    #[test]
    fn links_communication_modules_and_cartridges_have_no_position() {
        let on_bus = |family, kind| ModuleType::new("", family, kind).is_on_bus();
        assert!(
            on_bus(ModuleFamily::Tm2, ModuleKind::Analogue) && on_bus(ModuleFamily::Tm3, ModuleKind::Safety)
        );
        assert!(!on_bus(ModuleFamily::Tm3, ModuleKind::Receiver));
        assert!(!on_bus(ModuleFamily::Tm4, ModuleKind::Communication));
        assert!(!on_bus(ModuleFamily::Tmc4, ModuleKind::Analogue));
    }
}
