//! A module as an application configures it.

use super::ModuleType;

/// A module of a configuration. A list of them is in the order of the device tree: local modules from the controller on,
/// transmitter and receiver, remote modules; cartridges and TM4 modules may stand anywhere in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ConfiguredModule<'a> {
    /// Which module.
    pub module: &'a ModuleType,
    /// The parameter *Optional module*; default No (io:OPT-01).
    pub optional: bool,
    /// The parameter *Status Enabled*: an analogue module has its status bytes in %I (io:DIAG-06).
    pub status_enabled: bool,
}

impl<'a> ConfiguredModule<'a> {
    /// The module with the defaults of its parameters: mandatory (io:OPT-01), with status bytes (manufacturer's product
    /// help, TM3 analogue modules).
    pub const fn new(module: &'a ModuleType) -> ConfiguredModule<'a> {
        ConfiguredModule { module, optional: false, status_enabled: true }
    }
}
