//! A conveyor: a belt that carries parts past photo eyes.

use std::collections::VecDeque;
use std::sync::Arc;

use document::{KeySpec, KeyType};
use signal::{Random, Time, Value};

use super::drive::{self, Drive, DriveSpec};
use super::{PlantKind, PlantReader, reader};
use crate::channel::ChannelId;
use crate::circuit::{CircuitFault, ParameterKind, Plant, PlantInput, PlantParameter, PlantPort, PlantSpec};
use crate::codes;
use crate::course::{Course, margin};
use crate::measure::Dimension;

/// The most parts on a belt: one more pushes off the one that is there longest.
const MAX_PARTS: usize = 1_000;

const EYE: &[KeySpec] = &[
    KeySpec::required("channel", KeyType::Text, "The digital channel that is 1 while a part is before it"),
    KeySpec::required(
        "at",
        KeyType::Quantity,
        "How far from the beginning of the belt it is, as in \"1.5 m\"",
    ),
];

pub(super) const KIND: PlantKind = PlantKind {
    name: "conveyor",
    keys: &[
        reader::INPUT,
        drive::SPEED,
        drive::FULL,
        drive::REVERSE,
        KeySpec::required("length", KeyType::Quantity, "How long the belt is, as in \"3 m\""),
        KeySpec::required("part-length", KeyType::Quantity, "How long a part is, as in \"20 cm\""),
        KeySpec::required(
            "feed",
            KeyType::Text,
            "The digital channel on whose rising edge a part begins to come onto the belt",
        ),
        KeySpec::required("eyes", KeyType::List(&KeyType::Table(EYE)), "Photo eyes along the belt"),
    ],
    read,
};

#[derive(Clone, Debug)]
struct ConveyorSpec {
    name: String,
    drive: DriveSpec,
    feed: ChannelId,
    length: f64,
    part: f64,
    eyes: Vec<(ChannelId, f64)>,
}

fn read(reader: &mut PlantReader<'_, '_>) -> Option<Arc<dyn PlantSpec>> {
    let drive = drive::read(reader, &Dimension::Speed, 1e3);
    let length = reader.measure("length", &Dimension::Length, 1e-6, 1e6);
    let part = reader.measure("part-length", &Dimension::Length, 1e-6, 1e6);
    let feed = reader.level("feed");
    let length = length?;
    let eyes = reader.each("eyes", EYE, |reader| {
        let channel = reader.level("channel");
        let at = reader.measure("at", &Dimension::Length, 0.0, length);
        channel.zip(at)
    });
    let eyes = eyes?;
    if eyes.is_empty() {
        let message = String::from("the conveyor has no photo eye");
        reader.error(
            "eyes",
            codes::PLANT_RANGE,
            message,
            "add one, as in eyes = [{ channel = \"I0\", at = \"1 m\" }]",
        );
        return None;
    }
    Some(Arc::new(ConveyorSpec {
        name: reader.name(),
        drive: drive?,
        feed: feed?,
        length,
        part: part?,
        eyes,
    }))
}

impl PlantSpec for ConveyorSpec {
    fn name(&self) -> &str {
        &self.name
    }

    fn inputs(&self) -> Vec<PlantPort> {
        // The feed is the first, since a drive has one input or two.
        std::iter::once(PlantPort::level(self.feed)).chain(self.drive.inputs()).collect()
    }

    fn outputs(&self) -> Vec<PlantPort> {
        self.eyes.iter().map(|(channel, _)| PlantPort::level(*channel)).collect()
    }

    fn check(&self) -> Vec<(Option<usize>, CircuitFault)> {
        Vec::new()
    }

    fn parameters(&self) -> Vec<PlantParameter> {
        let takes = ParameterKind::Measure { dimension: Dimension::Speed, least: 0.0, most: 1e3 };
        vec![
            PlantParameter { name: String::from("speed"), takes, initial: self.drive.speed },
            PlantParameter { name: String::from("blocked"), takes: ParameterKind::Flag, initial: 0.0 },
        ]
    }

    fn build(&self, _random: Random) -> Box<dyn Plant> {
        Box::new(Conveyor {
            drive: Drive::new(&self.drive),
            length: self.length,
            part: self.part,
            eyes: self.eyes.iter().map(|(_, at)| *at).collect(),
            feeding: false,
            moved: Course::constant(Time::ZERO, 0.0),
            parts: VecDeque::with_capacity(MAX_PARTS + 1),
            due: None,
            outputs: vec![Value::Bool(false); self.eyes.len()],
        })
    }
}

/// The belt has moved by so many metres since the start; a part is where the belt was when the part came onto it.
#[derive(Debug)]
struct Conveyor {
    drive: Drive,
    length: f64,
    part: f64,
    eyes: Vec<f64>,
    feeding: bool,
    /// Metres that the belt has moved.
    moved: Course,
    /// The displacement at which each part's front was at the beginning of the belt, the oldest first.
    parts: VecDeque<f64>,
    /// When a part next comes before an eye, leaves it, or leaves the belt.
    due: Option<Time>,
    outputs: Vec<Value>,
}

/// From where on the belt is at a place, both in metres: where rounding has put it just short of the place it is there. On its way
/// back it leaves the place below this.
fn edge(place: f64) -> f64 {
    place - margin(place, 1e-13)
}

/// Whether the belt is at a place or beyond it.
fn is_at(moved: f64, place: f64) -> bool {
    moved >= edge(place)
}

impl Conveyor {
    fn plan_belt(&mut self, now: Time) {
        let moved = self.moved.value(now);
        let speed = if self.drive.blocked { Course::constant(now, 0.0) } else { self.drive.course(now) };
        let sampled =
            || Course::line(now, moved, if self.drive.blocked { 0.0 } else { self.drive.command() });
        self.moved = speed.integral(now, moved).unwrap_or_else(sampled);
    }

    /// The displacements at which something happens with the part that came at `came`.
    fn places(&self, came: f64) -> impl Iterator<Item = f64> + '_ {
        let eyes = self.eyes.iter().flat_map(move |at| [came + at, came + at + self.part]);
        eyes.chain([came, came + self.length + self.part])
    }

    fn plan_parts(&mut self, now: Time) {
        let moved = self.moved.value(now);
        let (mut above, mut below) = (f64::INFINITY, f64::NEG_INFINITY);
        for place in self.parts.iter().flat_map(|came| self.places(*came)) {
            if !is_at(moved, place) {
                above = above.min(place);
            } else {
                below = below.max(place);
            }
        }
        let moves = !(self.moved.is_constant());
        let up = (moves && above.is_finite()).then(|| self.moved.rises_to(edge(above), now)).flatten();
        let down =
            (moves && below.is_finite()).then(|| self.moved.falls_to(edge(below).next_down(), now)).flatten();
        self.due = up.into_iter().chain(down).min();
    }

    /// Lets parts leave and shows what is before the eyes.
    fn show(&mut self, now: Time) {
        let moved = self.moved.value(now);
        let (part, length) = (self.part, self.length);
        self.parts.retain(|came| is_at(moved, *came) && !is_at(moved, came + length + part));
        for (output, at) in self.outputs.iter_mut().zip(&self.eyes) {
            let before = |came: &f64| is_at(moved, came + at) && !is_at(moved, came + at + part);
            *output = Value::Bool(self.parts.iter().any(before));
        }
    }
}

impl Plant for Conveyor {
    fn start(&mut self, now: Time) {
        self.drive.start();
        self.feeding = false;
        self.moved = Course::constant(now, 0.0);
        self.parts.clear();
        self.due = None;
        self.outputs.fill(Value::Bool(false));
    }

    fn input(&mut self, now: Time, port: usize, input: &PlantInput) {
        let due = self.due.filter(|due| *due <= now);
        if port == 0 {
            let feeding = input.value == Value::Bool(true);
            if std::mem::replace(&mut self.feeding, feeding) || !feeding {
                return;
            }
            if self.parts.len() >= MAX_PARTS {
                self.parts.pop_front();
            }
            self.parts.push_back(self.moved.value(now));
            // An eye at the beginning of the belt sees it at once.
            self.due = Some(now.saturating_add(signal::Span::from_nanos(1)));
        } else if self.drive.input(
            port - 1,
            input,
            input.course.is_none_or(|course| course.integral(now, 0.0).is_some()),
        ) {
            self.plan_belt(now);
            self.plan_parts(now);
        }
        self.due = due.or(self.due);
    }

    fn next_event(&self) -> Option<Time> {
        self.due
    }

    fn advance(&mut self, now: Time) {
        if self.due.is_some_and(|due| due <= now) {
            self.show(now);
            self.plan_parts(now);
        }
    }

    fn outputs(&self) -> &[Value] {
        &self.outputs
    }

    fn set(&mut self, now: Time, parameter: usize, value: f64) {
        match parameter {
            0 => self.drive.speed = value,
            _ => self.drive.blocked = value != 0.0,
        }
        let due = self.due.filter(|due| *due <= now);
        self.plan_belt(now);
        self.plan_parts(now);
        self.due = due.or(self.due);
    }
}
