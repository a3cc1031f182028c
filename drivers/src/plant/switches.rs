//! Comparators with hysteresis on the value of a plant.

use document::{KeySpec, KeyType};
use signal::{Time, Value};

use super::PlantReader;
use crate::channel::ChannelId;
use crate::circuit::{CircuitFault, PlantPort};
use crate::course::Course;

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

/// A comparator at work.
#[derive(Clone, Copy, Debug)]
struct Switch {
    on_above: f64,
    off_below: f64,
    on: bool,
    flips: Option<Time>,
}

/// The comparators of a plant at work.
#[derive(Clone, Debug)]
pub(super) struct Switches {
    list: Vec<Switch>,
}

impl Switches {
    pub(super) fn new(list: &[SwitchSpec]) -> Switches {
        let switch = |spec: &SwitchSpec| Switch {
            on_above: spec.on_above,
            off_below: spec.off_below,
            on: false,
            flips: None,
        };
        Switches { list: list.iter().map(switch).collect() }
    }

    /// Thresholds of a value that rounding can have moved by so much: one that it exactly reaches is reached, also where it turns
    /// back or stops there.
    pub(super) fn eased(mut self, room: f64) -> Switches {
        for switch in &mut self.list {
            let room = room.min((switch.on_above - switch.off_below) / 4.0);
            switch.on_above -= room;
            switch.off_below += room;
        }
        self
    }

    /// At the start each is on where the value has reached its upper threshold.
    pub(super) fn start(&mut self, value: f64, outputs: &mut [Value]) {
        for (switch, output) in self.list.iter_mut().zip(outputs) {
            switch.on = value >= switch.on_above;
            switch.flips = None;
            *output = Value::Bool(switch.on);
        }
    }

    /// The value goes on by this course from `now`.
    pub(super) fn plan(&mut self, now: Time, course: &Course) {
        for switch in &mut self.list {
            // A flip that is due at the very instant of the change still happens then.
            if switch.flips.is_some_and(|due| due <= now) {
                continue;
            }
            switch.flips = switch.next(now, course);
        }
    }

    pub(super) fn next(&self) -> Option<Time> {
        self.list.iter().filter_map(|switch| switch.flips).min()
    }

    /// Lets flip what is due at `now`.
    pub(super) fn advance(&mut self, now: Time, course: &Course, outputs: &mut [Value]) {
        for (switch, output) in self.list.iter_mut().zip(outputs) {
            if switch.flips.is_some_and(|due| due <= now) {
                switch.on = !switch.on;
                switch.flips = switch.next(now, course);
                *output = Value::Bool(switch.on);
            }
        }
    }
}

impl Switch {
    fn next(&self, now: Time, course: &Course) -> Option<Time> {
        match self.on {
            false => course.rises_to(self.on_above, now),
            true => course.falls_to(self.off_below, now),
        }
    }
}
