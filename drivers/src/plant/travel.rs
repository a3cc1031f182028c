//! What moves evenly between two ends: the law of cylinders and valves.

use std::sync::Arc;

use document::{KeySpec, KeyType};
use signal::{Random, Span, Time, Value};

use super::PlantReader;
use super::decimals::ShownRange;
use super::position::{self, SAME, WAY, travelled};
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
        let range = ShownRange::new(0.0, 100.0, 100.0);
        Box::new(Travel {
            initial: position::of(self.initial, 1),
            reach: position::of(self.reach, 1),
            spec: self.clone(),
            times: [1; 2],
            stuck: false,
            out: Value::HighZ,
            back: Value::HighZ,
            since: Time::ZERO,
            from: 0,
            target: 0,
            due: None,
            shown: self.output.map(|_| SampledValue::new(self.sample, &[]).within(range)),
            outputs: vec![Value::HighZ; self.outputs().len()],
        })
    }
}

/// The position moves evenly to where it is sent and stays there.
#[derive(Debug)]
struct Travel {
    spec: TravelSpec,
    /// Positions, as all here.
    initial: i128,
    reach: i128,
    /// Nanoseconds from end to end, out and back.
    times: [i64; 2],
    stuck: bool,
    out: Value,
    back: Value,
    /// It was at `from` then, and goes to `target` since.
    since: Time,
    from: i128,
    target: i128,
    /// When it arrives, or an end switch changes.
    due: Option<Time>,
    shown: Option<SampledValue>,
    outputs: Vec<Value>,
}

impl Travel {
    /// Where it is sent; `None`: it stays.
    fn sent(&self) -> Option<i128> {
        let on = |value: Value| value == Value::Bool(true);
        let end = |out: bool| if out { WAY } else { 0 };
        match self.out {
            _ if self.stuck => None,
            Value::Real(percent) => Some(position::of(percent, 100)),
            out if self.spec.back.is_none() => Some(end(on(out))),
            out => match (on(out), on(self.back)) {
                (true, false) => Some(end(true)),
                (false, true) => Some(end(false)),
                _ => None,
            },
        }
    }

    /// How long it takes from end to end, the way it goes.
    fn time(&self) -> i64 {
        self.times[usize::from(self.target < self.from)]
    }

    /// Its position, held at where it is sent.
    fn at(&self, now: Time) -> i128 {
        let nanos = now.as_nanos().saturating_sub(self.since.as_nanos()).max(0);
        let travelled = travelled(nanos, self.time());
        let left = (self.target - self.from).abs() - travelled;
        match left <= SAME {
            true => self.target,
            false => self.from + if self.target > self.from { travelled } else { -travelled },
        }
    }

    /// Which end switches are on at a position: from their thresholds on, whichever way it comes there.
    fn ends(&self, position: i128) -> [bool; 2] {
        [position >= WAY - self.reach - SAME, position <= self.reach + SAME]
    }

    /// It goes on from a position.
    fn plan(&mut self, now: Time, position: i128) {
        (self.since, self.from) = (now, position);
        self.target = self.sent().unwrap_or(position);
        let distance = (self.target - position).abs();
        let (time, out) = (self.time(), self.target > position);
        // Those after which `ends` says otherwise.
        let [high, low] = [WAY - self.reach - SAME, self.reach + SAME];
        let places = if out { [high, low + 1] } else { [high - 1, low] };
        let passed = places.map(|place| if out { place - position } else { position - place });
        let passed = passed.into_iter().filter(|passed| *passed > 0 && *passed <= distance);
        let nearest = passed.chain((distance > 0).then(|| (distance - SAME).max(1))).min();
        self.due = nearest.and_then(|distance| {
            now.as_nanos().checked_add(position::nanos_to(distance, time)).map(Time::from_nanos)
        });
        if let Some(shown) = &mut self.shown {
            let slope = 1e11 / time as f64;
            let course = match distance {
                0 => Course::constant(now, position::percent(position)),
                _ => Course::line(now, position::percent(position), if out { slope } else { -slope }),
            };
            shown.go_on(now, course, self.outputs[0]);
        }
    }

    fn show_ends(&mut self, position: i128) {
        let on = self.ends(position);
        let first = usize::from(self.shown.is_some());
        let ends = self.spec.ends.iter().zip(on).filter(|(end, _)| end.is_some());
        for (output, (_, on)) in self.outputs[first..].iter_mut().zip(ends) {
            *output = Value::Bool(on);
        }
    }

    /// Something else sends it somewhere: it goes on from where it is.
    fn change(&mut self, now: Time, change: impl FnOnce(&mut Travel)) {
        // What is due at this very instant still comes then.
        let due = self.due.filter(|due| *due <= now);
        let position = self.at(now);
        change(self);
        self.plan(now, position);
        self.due = due.or(self.due);
    }
}

impl Plant for Travel {
    fn start(&mut self, now: Time) {
        self.times = self.spec.times.map(Span::as_nanos);
        self.stuck = false;
        (self.out, self.back) = (Value::HighZ, Value::HighZ);
        let initial = self.initial;
        if let Some(shown) = &mut self.shown {
            shown.start(now, Course::constant(now, position::percent(initial)), &mut self.outputs[..1]);
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
        // The range of a time fits into nanoseconds.
        let nanos = (libm::round(value * 1e9) as i64).max(1);
        self.change(now, |travel| match parameter {
            0 => travel.stuck = value != 0.0,
            // A valve has one time for both ways.
            1 if travel.spec.keys[0] == travel.spec.keys[1] => travel.times = [nanos; 2],
            1 => travel.times[0] = nanos,
            _ => travel.times[1] = nanos,
        });
    }
}
