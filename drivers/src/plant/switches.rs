//! Comparators with hysteresis on the value of a plant.

use document::{KeySpec, KeyType};

use super::PlantReader;
use crate::channel::ChannelId;
use crate::circuit::{CircuitFault, PlantPort};

/// A comparator with hysteresis on the value of a plant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SwitchSpec {
    /// The digital channel that it drives.
    pub channel: ChannelId,
    /// It drives 1 from the first nanosecond at which the value has reached this.
    pub on_above: f64,
    /// It drives 0 from the first nanosecond at which the value has come down to this; below `on_above`.
    pub off_below: f64,
}

const SWITCH: &[KeySpec] = &[
    KeySpec::required("channel", KeyType::Text, "The digital channel that it drives"),
    KeySpec::required("on-above", KeyType::Quantity, "It goes on where the value reaches this"),
    KeySpec::required("off-below", KeyType::Quantity, "It goes off where the value comes down to this"),
];

pub(super) const SWITCHES: KeySpec = KeySpec::optional(
    "switches",
    KeyType::List(&KeyType::Table(SWITCH)),
    "Comparators on the value of its output",
);

/// The comparators of a plant whose output has this unit.
pub(super) fn read(reader: &mut PlantReader<'_, '_>, unit: &str) -> Option<Vec<SwitchSpec>> {
    reader.each("switches", SWITCH, |reader| {
        let channel = reader.channel("channel").map(|(channel, _)| channel);
        let on_above = reader.number("on-above", unit);
        let off_below = reader.number("off-below", unit);
        Some(SwitchSpec { channel: channel?, on_above: on_above?, off_below: off_below? })
    })
}

/// The terminals of the comparators.
pub(super) fn ports(list: &[SwitchSpec]) -> impl Iterator<Item = PlantPort> + '_ {
    list.iter().enumerate().map(|(place, switch)| PlantPort::of_switch(switch.channel, place))
}

/// What is wrong with the comparators, by their places.
pub(super) fn check(list: &[SwitchSpec]) -> Vec<(Option<usize>, CircuitFault)> {
    let fault = |switch: &SwitchSpec| {
        let finite = switch.on_above.is_finite() && switch.off_below.is_finite();
        match finite {
            false => Some(CircuitFault::NotFinite),
            true => (switch.off_below >= switch.on_above).then_some(CircuitFault::NoHysteresis),
        }
    };
    list.iter().enumerate().filter_map(|(place, switch)| Some((Some(place), fault(switch)?))).collect()
}
