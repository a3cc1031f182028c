//! A module as an application configures it.

use super::{AnalogueInputSettings, AnalogueOutputSettings, ModuleType};
use signal::Span;

/// A module of a configuration. A list of them is in the order of the device tree: local modules from the controller on,
/// transmitter and receiver, remote modules; cartridges and TM4 modules may stand anywhere in it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ConfiguredModule<'a> {
    /// Which module.
    pub module: &'a ModuleType,
    /// The parameter *Optional module*; default No (io:OPT-01).
    pub optional: bool,
    /// The parameter *Status Enabled*: an analogue module has its status bytes in %I (io:DIAG-06).
    pub status_enabled: bool,
    /// The parameter *Sampling*: the time of a conversion for each channel; none for the default of the module.
    pub sampling: Option<Span>,
    /// "Update all variables" of the module alone: the bus cycle task exchanges all of its channels (io:BUS-11, 2014).
    pub always_update: bool,
    /// Analogue inputs from the first on; none for one that is not used, as those beyond the list are.
    pub inputs: Vec<Option<AnalogueInputSettings<'a>>>,
    /// Analogue outputs from the first on; none for one that is not used, as those beyond the list are.
    pub outputs: Vec<Option<AnalogueOutputSettings<'a>>>,
}

impl<'a> ConfiguredModule<'a> {
    /// The module with the defaults of its parameters: mandatory (io:OPT-01), with status bytes, no analogue channel used
    /// (manufacturer's product help, TM3 analogue modules).
    pub const fn new(module: &'a ModuleType) -> ConfiguredModule<'a> {
        ConfiguredModule {
            module,
            optional: false,
            status_enabled: true,
            sampling: None,
            always_update: false,
            inputs: Vec::new(),
            outputs: Vec::new(),
        }
    }

    /// How an analogue input is configured; none where it is not used.
    pub fn input(&self, input: usize) -> Option<&AnalogueInputSettings<'a>> {
        self.inputs.get(input)?.as_ref()
    }

    /// How an analogue output is configured; none where it is not used.
    pub fn output(&self, output: usize) -> Option<&AnalogueOutputSettings<'a>> {
        self.outputs.get(output)?.as_ref()
    }
}
