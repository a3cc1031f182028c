//! A motor with inertia that turns an encoder.

use std::sync::Arc;

use document::{KeySpec, KeyType};
use signal::{Random, Span, Time, Value};

use super::decimals::Decimals;
use super::drive::{self, Drive, DriveSpec};
use super::sampled::SampledValue;
use super::{PlantKind, PlantReader, lag, reader};
use crate::channel::ChannelId;
use crate::circuit::{CircuitFault, ParameterKind, Plant, PlantInput, PlantParameter, PlantPort, PlantSpec};
use crate::codes;
use crate::course::{Course, margin, span_seconds};
use crate::measure::Dimension;

/// The most edges of A and B together in a second.
const MAX_EDGES: f64 = 2e6;

pub(super) const KIND: PlantKind = PlantKind {
    name: "motor",
    keys: &[
        reader::INPUT,
        drive::SPEED,
        drive::FULL,
        drive::REVERSE,
        lag::TAU,
        KeySpec::optional("lines", KeyType::Integer(1, 1_000_000), "Lines of the disc of its encoder"),
        KeySpec::optional(
            "a",
            KeyType::Text,
            "The digital channel of phase A, which leads while it turns forwards",
        ),
        KeySpec::optional("b", KeyType::Text, "The digital channel of phase B"),
        KeySpec::optional("index", KeyType::Text, "The digital channel that is 1 for one count of each turn"),
        reader::VALUE,
        reader::SAMPLE_OF_VALUE,
    ],
    read,
};

#[derive(Clone, Debug)]
struct MotorSpec {
    name: String,
    drive: DriveSpec,
    tau: Span,
    lines: i64,
    phases: Option<(ChannelId, ChannelId)>,
    index: Option<ChannelId>,
    /// The channel of its speed, and how much of its unit a turn in a second is.
    output: Option<(ChannelId, f64)>,
    sample: Span,
}

fn read(reader: &mut PlantReader<'_, '_>) -> Option<Arc<dyn PlantSpec>> {
    let lines = reader.integer("lines").unwrap_or(1);
    let drive = drive::read(reader, &Dimension::Rotation, 1e6);
    let (a, b) = (reader.level("a"), reader.level("b"));
    for (key, with) in [("a", "b"), ("b", "a"), ("index", "a"), ("lines", "a"), ("a", "lines")] {
        if reader.has(key) && !reader.has(with) {
            let message = format!("`{key}` goes with `{with}`");
            reader.error_of_key(key, codes::PLANT_ENCODER, message, &format!("add `{with} = ...`"));
            return None;
        }
    }
    let index = match reader.has("index") {
        true => Some(reader.level("index")?),
        false => None,
    };
    let output = match reader.has("output") {
        true => {
            let (output, unit) = reader.quantity("output")?;
            let Some(turn) = Dimension::Rotation.of_unit(&unit) else {
                let message = format!("the speed of a motor cannot be in `{unit}`");
                reader.error(
                    "output",
                    codes::PLANT_UNIT,
                    message,
                    "give its channel the unit \"rpm\" or \"Hz\"",
                );
                return None;
            };
            Some((output, 1.0 / turn))
        }
        false => None,
    };
    let tau = reader.duration("tau");
    let sample = reader.sample_of_value(output.is_some())?;
    let drive = drive?;
    if a.is_some() && drive.speed * 4.0 * lines as f64 > MAX_EDGES {
        let message = String::from("its encoder would have more than 2 000 000 edges in a second");
        reader.error("speed", codes::PLANT_ENCODER, message, "make it slower, or give its disc fewer lines");
        return None;
    }
    if a.is_none() && output.is_none() {
        let message = String::from("nothing shows how the motor turns");
        reader.error(
            "name",
            codes::PLANT_ENCODER,
            message,
            "add `a`, `b` and `lines` of an encoder, or `output`",
        );
        return None;
    }
    let phases = if a.is_some() || reader.has("a") { Some((a?, b?)) } else { None };
    Some(Arc::new(MotorSpec { name: reader.name(), drive, tau: tau?, lines, phases, index, output, sample }))
}

impl PlantSpec for MotorSpec {
    fn name(&self) -> &str {
        &self.name
    }

    fn inputs(&self) -> Vec<PlantPort> {
        self.drive.inputs()
    }

    fn outputs(&self) -> Vec<PlantPort> {
        let output = self.output.map(|(channel, _)| PlantPort::quantity(channel));
        let lines = self.phases.into_iter().flat_map(|(a, b)| [a, b]).chain(self.index);
        output.into_iter().chain(lines.map(PlantPort::level)).collect()
    }

    fn check(&self) -> Vec<(Option<usize>, CircuitFault)> {
        Vec::new()
    }

    fn parameters(&self) -> Vec<PlantParameter> {
        let most = self.drive.speed.max(MAX_EDGES / (4.0 * self.lines as f64)).min(1e6);
        let takes = ParameterKind::Measure { dimension: Dimension::Rotation, least: 0.0, most };
        vec![
            PlantParameter { name: String::from("speed"), takes, initial: self.drive.speed },
            PlantParameter { name: String::from("blocked"), takes: ParameterKind::Flag, initial: 0.0 },
        ]
    }

    fn build(&self, _random: Random) -> Box<dyn Plant> {
        let count = self.outputs().len();
        Box::new(Motor {
            drive: Drive::new(&self.drive),
            tau: span_seconds(self.tau),
            counts: 4 * self.lines,
            speed: Course::constant(Time::ZERO, 0.0),
            angle: Course::constant(Time::ZERO, 0.0),
            count: 0,
            edge: None,
            shown: self.output.map(|(_, scale)| {
                let decimals = Decimals::new(self.drive.speed * scale, 0.0);
                (SampledValue::new(self.sample, &[]).resting_at(decimals), scale)
            }),
            encoder: self.phases.map(|_| usize::from(self.output.is_some())),
            outputs: vec![Value::HighZ; count],
        })
    }
}

/// The speed follows its command with a time constant; the angle is its integral, and each count of the encoder an instant of
/// that.
#[derive(Debug)]
struct Motor {
    drive: Drive,
    tau: f64,
    /// Counts in a turn.
    counts: i64,
    /// Turns in a second.
    speed: Course,
    /// In counts. It begins in the middle of count 0.
    angle: Course,
    count: i64,
    /// When the next count comes, and whether it is one more or one less.
    edge: Option<(Time, i64)>,
    /// The speed as its output shows it, in the unit of its channel.
    shown: Option<(SampledValue, f64)>,
    /// The place of A among the outputs; B and the index come after it.
    encoder: Option<usize>,
    outputs: Vec<Value>,
}

/// How far below a count the one before it begins, in counts: backwards an edge comes where it comes forwards.
const MARGIN: f64 = 1e-9;

impl Motor {
    /// The speed that is commanded: with an encoder at most what it can count, whatever an analog input says.
    fn command(&self) -> f64 {
        let most = if self.encoder.is_some() { MAX_EDGES / self.counts as f64 } else { f64::MAX };
        self.drive.command().clamp(-most, most)
    }

    /// The shaft goes on from this speed and angle.
    fn plan(&mut self, now: Time, speed: f64, angle: f64) {
        self.speed = match self.drive.blocked {
            true => Course::constant(now, 0.0),
            false => Course::lag(now, speed, self.command(), self.tau),
        };
        let counts = self.speed.mapped(0.0, self.counts as f64);
        self.angle = counts.integral(now, angle).unwrap_or_else(|| Course::constant(now, angle));
        self.plan_count(now);
    }

    fn plan_count(&mut self, now: Time) {
        if self.encoder.is_none() || (self.speed.is_settled(now) && self.speed.value(now) == 0.0) {
            self.edge = None;
            return;
        }
        let count = self.count as f64;
        let up = self.angle.rises_to(count + 1.0, now).map(|at| (at, 1));
        let down = self.angle.falls_to(count - margin(count, MARGIN), now).map(|at| (at, -1));
        self.edge = up.into_iter().chain(down).min();
    }

    fn replan(&mut self, now: Time) {
        let due = self.edge.filter(|(at, _)| *at <= now);
        self.plan(now, self.speed.value(now), self.angle.value(now));
        // A count that is due at this very instant comes.
        self.edge = due.or(self.edge);
        if let Some((shown, scale)) = &mut self.shown {
            let course = self.speed.mapped(0.0, *scale);
            // Only what blocks a shaft makes its speed jump.
            if self.drive.blocked {
                shown.jump(now, course, &mut self.outputs[0]);
            } else {
                shown.go_on(now, course, self.outputs[0]);
            }
        }
    }

    fn show_count(&mut self) {
        let Some(place) = self.encoder else { return };
        let phase = self.count.rem_euclid(4);
        let levels =
            [matches!(phase, 1 | 2), matches!(phase, 2 | 3), self.count.rem_euclid(self.counts) == 0];
        for (output, level) in self.outputs[place..].iter_mut().zip(levels) {
            *output = Value::Bool(level);
        }
    }
}

impl Plant for Motor {
    fn start(&mut self, now: Time) {
        self.drive.start();
        self.count = 0;
        self.plan(now, 0.0, 0.5);
        if let Some((shown, scale)) = &mut self.shown {
            shown.start(now, self.speed.mapped(0.0, *scale), &mut self.outputs[..1]);
        }
        self.show_count();
    }

    fn input(&mut self, now: Time, port: usize, input: &PlantInput) {
        // What its command does between two samples has no closed form with the inertia.
        if self.drive.input(port, input, false) {
            self.replan(now);
        }
    }

    fn next_event(&self) -> Option<Time> {
        let shown = self.shown.as_ref().and_then(|(shown, _)| shown.next());
        self.edge.map(|(at, _)| at).into_iter().chain(shown).min()
    }

    fn advance(&mut self, now: Time) {
        if let Some((shown, _)) = &mut self.shown {
            shown.advance(now, &mut self.outputs[..1]);
        }
        if let Some((_, by)) = self.edge.filter(|(at, _)| *at <= now) {
            self.count += by;
            self.show_count();
            self.plan_count(now);
        }
    }

    fn outputs(&self) -> &[Value] {
        &self.outputs
    }

    fn course(&self, output: usize) -> Option<&Course> {
        let (shown, _) = self.shown.as_ref()?;
        (output == 0).then_some(shown.course())
    }

    fn set(&mut self, now: Time, parameter: usize, value: f64) {
        match parameter {
            0 => self.drive.speed = value,
            _ => self.drive.blocked = value != 0.0,
        }
        self.replan(now);
    }
}
