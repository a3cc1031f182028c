//! What moves evenly between two ends: the law of cylinders and valves.

use std::sync::Arc;

use document::{KeySpec, KeyType};
use signal::{Random, Span, Time, Value};

use super::PlantReader;
use super::sampled::SampledValue;
use crate::channel::ChannelId;
use crate::circuit::{CircuitFault, ParameterKind, Plant, PlantInput, PlantParameter, PlantPort, PlantSpec};
use crate::codes;
use crate::course::{Course, span_seconds};
use crate::measure::Dimension;

pub(super) const REACH: KeySpec = KeySpec::optional(
    "reach",
    KeyType::Quantity,
    "How far from its end an end switch is on already, as in \"2 %\"; 0 if left out",
);

/// Something that travels from 0 to 1 and back.
#[derive(Clone, Debug)]
struct TravelSpec {
    name: String,
    /// What sends it out, or to where it is to go in percent.
    out: PlantPort,
    /// What sends it back; where there is none it goes back whenever it is not sent out.
    back: Option<ChannelId>,
    /// How long it takes from end to end, out and back.
    times: [Span; 2],
    /// Their keys: the same one where it is one time.
    keys: [&'static str; 2],
    /// Where it is at the start, from 0 to 1.
    initial: f64,
    /// How far from its end an end switch is on, from 0 to 1.
    reach: f64,
    /// The end switches: at 1, at 0.
    ends: [Option<ChannelId>; 2],
    /// The channel of its position in percent.
    output: Option<ChannelId>,
    sample: Span,
}

/// What kinds that travel share: `back`, `keys` of the times and `ends` are their keys.
pub(super) fn read(
    reader: &mut PlantReader<'_, '_>,
    back: &str,
    keys: [&'static str; 2],
    ends: [&str; 2],
    positions: bool,
) -> Option<Arc<dyn PlantSpec>> {
    let (input, unit) = reader.channel("input")?;
    let out = match unit.as_deref() {
        None => PlantPort::level(input),
        Some("%") if positions => PlantPort::quantity(input),
        Some(unit) => {
            let message = format!("its input cannot be in `{unit}`");
            let help = if positions {
                "name a digital channel, or an analog one in \"%\""
            } else {
                "name a digital channel"
            };
            reader.error("input", codes::PLANT_UNIT, message, help);
            return None;
        }
    };
    let mut optional = |key: &str| match reader.has(key) {
        true => reader.level(key).map(Some),
        false => Some(None),
    };
    let (back_channel, ends) = (optional(back)?, [optional(ends[0])?, optional(ends[1])?]);
    if back_channel.is_some() && unit.is_some() {
        let message = format!("an analog input says where it goes, and leaves no `{back}`");
        reader.error_of_key(back, codes::PLANT_UNIT, message, "remove it, or name a digital `input`");
        return None;
    }
    let mut part = |key: &str, most: f64| match reader.has(key) {
        true => reader.measure(key, &Dimension::Part, 0.0, most),
        false => Some(0.0),
    };
    let (reach, initial) = (part("reach", 0.5)?, part("initial", 1.0)?);
    let output = match reader.has("output") {
        true => {
            let (channel, unit) = reader.quantity("output")?;
            if unit != "%" {
                let message = format!("a position cannot be in `{unit}`");
                reader.error("output", codes::PLANT_UNIT, message, "give its channel the unit \"%\"");
                return None;
            }
            Some(channel)
        }
        false => None,
    };
    let sample = reader.sample_of_value(output.is_some())?;
    let times = [reader.duration(keys[0])?, reader.duration(keys[1])?];
    let (name, back) = (reader.name(), back_channel);
    Some(Arc::new(TravelSpec { name, out, back, times, keys, initial, reach, ends, output, sample }))
}

impl PlantSpec for TravelSpec {
    fn name(&self) -> &str {
        &self.name
    }

    fn inputs(&self) -> Vec<PlantPort> {
        std::iter::once(self.out).chain(self.back.map(PlantPort::level)).collect()
    }

    fn outputs(&self) -> Vec<PlantPort> {
        let output = self.output.map(PlantPort::quantity);
        output.into_iter().chain(self.ends.into_iter().flatten().map(PlantPort::level)).collect()
    }

    fn check(&self) -> Vec<(Option<usize>, CircuitFault)> {
        Vec::new()
    }

    fn parameters(&self) -> Vec<PlantParameter> {
        let takes = ParameterKind::Measure { dimension: Dimension::Time, least: 1e-9, most: 1e9 };
        let time = |place: usize| PlantParameter {
            name: String::from(self.keys[place]),
            takes: takes.clone(),
            initial: span_seconds(self.times[place]),
        };
        let stuck = PlantParameter { name: String::from("stuck"), takes: ParameterKind::Flag, initial: 0.0 };
        let mut all = vec![stuck, time(0)];
        if self.keys[1] != self.keys[0] {
            all.push(time(1));
        }
        all
    }

    fn build(&self, _random: Random) -> Box<dyn Plant> {
        Box::new(Travel {
            spec: self.clone(),
            times: [0.0; 2],
            stuck: false,
            out: Value::HighZ,
            back: Value::HighZ,
            position: Course::constant(Time::ZERO, 0.0),
            due: None,
            shown: self.output.map(|_| SampledValue::new(self.sample, &[])),
            outputs: vec![Value::HighZ; self.outputs().len()],
        })
    }
}

/// The position moves evenly to where it is sent and stays there.
#[derive(Debug)]
struct Travel {
    spec: TravelSpec,
    times: [f64; 2],
    stuck: bool,
    out: Value,
    back: Value,
    /// From 0 to 1.
    position: Course,
    /// When it arrives, or an end switch changes.
    due: Option<Time>,
    shown: Option<SampledValue>,
    outputs: Vec<Value>,
}

impl Travel {
    /// Where it is sent; `None`: it stays.
    fn target(&self) -> Option<f64> {
        let on = |value: Value| value == Value::Bool(true);
        match self.out {
            _ if self.stuck => None,
            Value::Real(percent) => Some((percent / 100.0).clamp(0.0, 1.0)),
            out if self.spec.back.is_none() => Some(f64::from(u8::from(on(out)))),
            out => match (on(out), on(self.back)) {
                (true, false) => Some(1.0),
                (false, true) => Some(0.0),
                _ => None,
            },
        }
    }

    fn plan(&mut self, now: Time, position: f64) {
        let target = self.target().unwrap_or(position);
        let time = if target > position { self.times[0] } else { -self.times[1] };
        self.position = match target == position {
            true => Course::constant(now, position),
            false => Course::line(now, position, 1.0 / time),
        };
        let arrives = match time > 0.0 {
            true => self.position.rises_to(target, now),
            false => self.position.falls_to(target, now),
        };
        let moves = target != position;
        let [high, low] = [1.0 - self.spec.reach, self.spec.reach];
        // An end switch changes where the position passes its threshold on the way.
        let passes = |at: f64| match time > 0.0 {
            true => (position < at && at <= target).then(|| self.position.rises_to(at, now)).flatten(),
            false => {
                (position >= at && target < at).then(|| self.position.falls_to(at - MARGIN, now)).flatten()
            }
        };
        let passes_low = |at: f64| match time > 0.0 {
            true => {
                (position <= at && at < target).then(|| self.position.rises_to(at + MARGIN, now)).flatten()
            }
            false => (position > at && target <= at).then(|| self.position.falls_to(at, now)).flatten(),
        };
        self.due = match moves {
            true => arrives.into_iter().chain(passes(high)).chain(passes_low(low)).min(),
            false => None,
        };
        if let Some(shown) = &mut self.shown {
            shown.go_on(now, self.position.mapped(0.0, 100.0), self.outputs[0]);
        }
    }

    /// Its position, held at where it is sent.
    fn at(&self, now: Time) -> f64 {
        let value = self.position.value(now);
        let sent = match (self.target(), self.position.slope(now)) {
            (Some(target), slope) if slope > 0.0 => value.min(target),
            (Some(target), slope) if slope < 0.0 => value.max(target),
            _ => value,
        };
        sent.clamp(0.0, 1.0)
    }

    fn show_ends(&mut self, position: f64) {
        let on = [position >= 1.0 - self.spec.reach, position <= self.spec.reach];
        let first = usize::from(self.shown.is_some());
        let ends = self.spec.ends.iter().zip(on).filter(|(end, _)| end.is_some());
        for (output, (_, on)) in self.outputs[first..].iter_mut().zip(ends) {
            *output = Value::Bool(on);
        }
    }

    /// Something else sends it somewhere: it goes on from where it is.
    fn change(&mut self, now: Time, change: impl FnOnce(&mut Travel)) {
        let due = self.due.filter(|due| *due <= now);
        let position = self.at(now);
        change(self);
        self.plan(now, position);
        self.due = due.or(self.due);
    }
}

/// How far beyond the threshold of an end switch the position is when it leaves it.
const MARGIN: f64 = 1e-12;

impl Plant for Travel {
    fn start(&mut self, now: Time) {
        self.times = self.spec.times.map(span_seconds);
        self.stuck = false;
        (self.out, self.back) = (Value::HighZ, Value::HighZ);
        let initial = self.spec.initial;
        if let Some(shown) = &mut self.shown {
            shown.start(now, Course::constant(now, 100.0 * initial), &mut self.outputs[..1]);
        }
        self.show_ends(initial);
        self.plan(now, initial);
    }

    fn input(&mut self, now: Time, port: usize, input: &PlantInput) {
        let before = if port == 0 { self.out } else { self.back };
        if before != input.value {
            let value = input.value;
            self.change(now, |travel| if port == 0 { travel.out = value } else { travel.back = value });
        }
    }

    fn next_event(&self) -> Option<Time> {
        self.due.into_iter().chain(self.shown.as_ref().and_then(SampledValue::next)).min()
    }

    fn advance(&mut self, now: Time) {
        if let Some(shown) = &mut self.shown {
            shown.advance(now, &mut self.outputs[..1]);
        }
        if self.due.is_some_and(|due| due <= now) {
            let position = self.at(now);
            self.show_ends(position);
            self.plan(now, position);
        }
    }

    fn outputs(&self) -> &[Value] {
        &self.outputs
    }

    fn course(&self, output: usize) -> Option<&Course> {
        let shown = self.shown.as_ref()?;
        (output == 0).then_some(shown.course())
    }

    fn set(&mut self, now: Time, parameter: usize, value: f64) {
        self.change(now, |travel| match parameter {
            0 => travel.stuck = value != 0.0,
            // A valve has one time for both ways.
            1 if travel.spec.keys[0] == travel.spec.keys[1] => travel.times = [value; 2],
            1 => travel.times[0] = value,
            _ => travel.times[1] = value,
        });
    }
}
