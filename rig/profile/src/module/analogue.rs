//! Analogue and temperature channels of a module.

use super::FigureSource;
use signal::{Decimal, Span, Unit};

/// One of the modes that an analogue channel can be configured for: a range of a voltage or a current, or a sensor.
///
/// All figures are exact and in [`AnalogueMode::unit`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AnalogueMode {
    /// Its name, as in `4..20 mA` or `thermocouple K`.
    pub name: String,
    /// What the channel carries.
    pub unit: Unit,
    /// The value at which the channel has its *Minimum*.
    pub low: Option<Decimal>,
    /// The value at which the channel has its *Maximum*.
    pub high: Option<Decimal>,
    /// From this value up an input is over range; an output has no such limit.
    pub over_range: Option<Decimal>,
    /// From this value down an input is under range; an output has no such limit.
    pub under_range: Option<Decimal>,
    /// What one count is, where the counts of the mode are fixed: 0.1 °C of a temperature.
    pub step: Option<Decimal>,
    /// Whether it is one of the extended ranges, which report that they are beyond their ends before they are out of range.
    pub extended: bool,
    /// The figures that are not from the documents of the controllers.
    pub sources: Vec<FigureSource>,
}

impl AnalogueMode {
    /// Whether its channel is at a sensor and not at a voltage or a current: an open one is a fault of the sensor.
    pub fn is_sensor(&self) -> bool {
        self.unit != Unit::new("V") && self.unit != Unit::new("mA")
    }
}

/// How long a conversion takes: a part that is always the same, and a part for each channel that is in use.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Conversion {
    /// The part that is always the same.
    pub fixed: Span,
    /// For each channel in use: the values that can be configured, the default first.
    pub per_channel: Vec<Span>,
}

/// The analogue inputs, or outputs, of a module.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AnalogueChannels {
    /// How many.
    pub count: u32,
    /// Resolution in bits, the sign included.
    pub bits: Option<u8>,
    /// The modes that each channel can be configured for.
    pub modes: Vec<AnalogueMode>,
    /// The conversion of voltages and currents.
    pub conversion: Option<Conversion>,
    /// The conversion of temperatures.
    pub temperature_conversion: Option<Conversion>,
}

impl AnalogueChannels {
    /// The mode of this name.
    pub fn mode(&self, name: &str) -> Option<&AnalogueMode> {
        self.modes.iter().find(|mode| mode.name == name)
    }
}
