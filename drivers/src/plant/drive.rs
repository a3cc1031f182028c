//! What drives a motor or a belt: a speed commanded by a digital or an analog channel, forwards or backwards.

use document::{KeySpec, KeyType};
use signal::{Time, Value};

use super::PlantReader;
use crate::channel::ChannelId;
use crate::circuit::{PlantInput, PlantPort};
use crate::codes;
use crate::course::Course;
use crate::measure::Dimension;

pub(super) const SPEED: KeySpec = KeySpec::required(
    "speed",
    KeyType::Quantity,
    "How fast it is while a digital input is 1, or where an analog one is at `full`",
);
pub(super) const FULL: KeySpec =
    KeySpec::optional("full", KeyType::Quantity, "Where an analog input commands `speed`, as in \"10 V\"");
pub(super) const REVERSE: KeySpec =
    KeySpec::optional("reverse", KeyType::Text, "The digital channel that is 1 for backwards");

/// What commands a speed.
#[derive(Clone, Debug)]
pub(super) struct DriveSpec {
    input: PlantPort,
    reverse: Option<ChannelId>,
    /// At 1 of a digital input or at `full` of an analog one.
    pub(super) speed: f64,
    /// Of an analog input.
    full: Option<f64>,
}

/// The drive of a plant whose speed is of this kind and at most so high.
pub(super) fn read(reader: &mut PlantReader<'_, '_>, dimension: &Dimension, most: f64) -> Option<DriveSpec> {
    let input = reader.channel("input");
    let speed = reader.measure("speed", dimension, f64::MIN_POSITIVE, most);
    let reverse = match reader.has("reverse") {
        true => Some(reader.level("reverse")?),
        false => None,
    };
    let (input, unit) = input?;
    let full = match (unit, reader.has("full")) {
        (None, false) => None,
        (None, true) => {
            let message = String::from("a digital input has no `full`");
            reader.error_of_key("full", codes::PLANT_UNIT, message, "remove it");
            return None;
        }
        (Some(unit), true) => Some(reader.measure("full", &Dimension::Of(unit), 1e-9, 1e9)?),
        (Some(unit), false) => {
            let message = String::from("an analog input needs `full`");
            let help = format!("add `full`: where it commands `speed`, as in full = \"10 {unit}\"");
            reader.error("input", codes::PLANT_UNIT, message, &help);
            return None;
        }
    };
    let input = if full.is_some() { PlantPort::quantity(input) } else { PlantPort::level(input) };
    Some(DriveSpec { input, reverse, speed: speed?, full })
}

impl DriveSpec {
    pub(super) fn inputs(&self) -> Vec<PlantPort> {
        std::iter::once(self.input).chain(self.reverse.map(PlantPort::level)).collect()
    }
}

/// A drive at work: what it commands.
#[derive(Clone, Debug)]
pub(super) struct Drive {
    spec: DriveSpec,
    pub(super) speed: f64,
    pub(super) blocked: bool,
    input: PlantInput,
    backwards: bool,
}

impl Drive {
    pub(super) fn new(spec: &DriveSpec) -> Drive {
        let input = PlantInput { value: Value::HighZ, course: None };
        Drive { spec: spec.clone(), speed: spec.speed, blocked: false, input, backwards: false }
    }

    pub(super) fn start(&mut self) {
        *self = Drive::new(&self.spec);
    }

    /// Takes an input. Returns whether it commands anything else: where `exact`, a further sample of a course does not.
    pub(super) fn input(&mut self, port: usize, input: &PlantInput, exact: bool) -> bool {
        if port == 1 {
            let backwards = input.value == Value::Bool(true);
            return std::mem::replace(&mut self.backwards, backwards) != backwards;
        }
        let before = std::mem::replace(&mut self.input, *input);
        match (before.course, input.course) {
            (Some(before), Some(course)) if exact => before != course,
            _ => before.value != input.value || before.course != input.course,
        }
    }

    fn factor(&self) -> f64 {
        let speed = if self.backwards { -self.speed } else { self.speed };
        speed / self.spec.full.unwrap_or(1.0)
    }

    /// What is commanded at the moment.
    pub(super) fn command(&self) -> f64 {
        let value = match self.input.value {
            Value::Bool(on) => f64::from(u8::from(on)),
            other => other.as_real().unwrap_or(0.0),
        };
        value * self.factor()
    }

    /// How the command goes on.
    pub(super) fn course(&self, now: Time) -> Course {
        match self.input.course {
            Some(course) => course.mapped(0.0, self.factor()),
            None => Course::constant(now, self.command()),
        }
    }
}
