//! Digital channels of a module.

use signal::{Quantity, Span};

/// What the digital outputs of a module are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum DigitalOutputKind {
    /// Relay contacts.
    Relay,
    /// Transistors that switch to the supply.
    Source,
    /// Transistors that switch to 0 V.
    Sink,
}

impl DigitalOutputKind {
    /// Every kind.
    pub const ALL: [DigitalOutputKind; 3] =
        [DigitalOutputKind::Relay, DigitalOutputKind::Source, DigitalOutputKind::Sink];

    /// The word for it.
    pub const fn name(self) -> &'static str {
        match self {
            DigitalOutputKind::Relay => "relay",
            DigitalOutputKind::Source => "source",
            DigitalOutputKind::Sink => "sink",
        }
    }
}

/// The digital inputs of a module.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DigitalInputs {
    /// How many.
    pub count: u32,
    /// Voltage and current, as the hardware guide writes them: `24 Vdc 7 mA`.
    pub rating: Option<String>,
    /// From the edge at the terminal to a 1 in the module.
    pub on_delay: Option<Span>,
    /// From the edge at the terminal to a 0 in the module.
    pub off_delay: Option<Span>,
}

/// The digital outputs of a module.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DigitalOutputs {
    /// How many.
    pub count: u32,
    /// What they are.
    pub kind: Option<DigitalOutputKind>,
    /// Voltage as the hardware guide writes it: `24 Vdc / 240 Vac`.
    pub rating: Option<String>,
    /// Most current of one output.
    pub output_current: Option<Quantity>,
    /// Most current of a common line.
    pub common_current: Option<Quantity>,
    /// From the write of a 1 in the module to the edge at the terminal, at most.
    pub on_delay: Option<Span>,
    /// From the write of a 0 in the module to the edge at the terminal, at most.
    pub off_delay: Option<Span>,
}
