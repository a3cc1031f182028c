//! What a person before the controller sees and can move, and what is forced in it.

use super::Controller;
use crate::{ForcedChannels, ForcedPlaces, Led, LedPattern, State};
use profile::{MODULE_INDICES, ModuleState};
use signal::Time;

/// The controller from outside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrontPanel {
    /// What its indicators show, in the order of [`Led::ALL`].
    pub leds: [LedPattern; Led::ALL.len()],
    /// Since when those that flash do so; a flash begins lit.
    pub since: Time,
    /// The Run/Stop switch is at Run.
    pub switch: bool,
    /// It has its supply.
    pub supply: bool,
    /// The inputs that are forced.
    pub forced_inputs: ForcedChannels,
    /// The outputs that are forced.
    pub forced_outputs: ForcedChannels,
    /// The inputs and outputs of modules that are forced.
    pub forced_places: ForcedPlaces,
    /// The states of the modules by their indices in TM3_MODULE_R.
    pub modules: [ModuleState; MODULE_INDICES],
}

impl Controller {
    /// What it shows now.
    pub fn front_panel(&self) -> FrontPanel {
        let [forced_inputs, forced_outputs] = self.io.forced();
        FrontPanel {
            leds: Led::ALL.map(|led| self.pattern(led)),
            since: self.leds.origin(),
            switch: self.power.switch_at_run,
            supply: self.state != State::Off && self.power.hold_up.is_none(),
            forced_inputs,
            forced_outputs,
            forced_places: self.modules.bus.forced(),
            modules: std::array::from_fn(|index| self.module_state(index)),
        }
    }
}
