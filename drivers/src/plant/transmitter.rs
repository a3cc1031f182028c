//! A transmitter: a quantity as a signal of 4 to 20 mA or 0 to 10 V.

use std::sync::Arc;

use document::{KeySpec, KeyType};
use signal::{Random, Span, Time, Value};

use super::decimals::ShownRange;
use super::sampled::SampledValue;
use super::{PlantKind, PlantReader, reader};
use crate::channel::ChannelId;
use crate::circuit::{CircuitFault, ParameterKind, Plant, PlantInput, PlantParameter, PlantPort, PlantSpec};
use crate::codes;
use crate::course::Course;
use crate::measure::Dimension;

pub(super) const KIND: PlantKind = PlantKind {
    name: "transmitter",
    keys: &[
        reader::INPUT,
        reader::OUTPUT,
        KeySpec::required(
            "range",
            KeyType::Range,
            "What it measures, in the unit of its input, as in \"0 .. 2 m\"",
        ),
        KeySpec::required("signal", KeyType::Range, "What it makes of that, as in \"4 .. 20 mA\""),
        KeySpec::optional(
            "limits",
            KeyType::Range,
            "How far its signal goes beyond, as in \"3.8 .. 20.5 mA\"; as `signal` if left out",
        ),
        reader::SAMPLE,
    ],
    read,
};

#[derive(Clone, Debug)]
struct TransmitterSpec {
    name: String,
    input: ChannelId,
    of: String,
    output: ChannelId,
    range: (f64, f64),
    signal: (f64, f64),
    limits: (f64, f64),
    sample: Span,
}

fn read(reader: &mut PlantReader<'_, '_>) -> Option<Arc<dyn PlantSpec>> {
    let (input, output) = (reader.quantity("input"), reader.quantity("output"));
    let ((input, of), (output, unit)) = (input?, output?);
    let (range, signal) = (reader.range("range", &of), reader.range("signal", &unit));
    let limits = if reader.has("limits") { reader.range("limits", &unit) } else { signal };
    let (signal, limits) = (signal?, limits?);
    if limits.0 > signal.0 || limits.1 < signal.1 {
        let message = String::from("the limits are within the signal");
        reader.error("limits", codes::PLANT_RANGE, message, "make them as wide as `signal`, or wider");
        return None;
    }
    let (range, sample) = (range?, reader.duration("sample")?);
    Some(Arc::new(TransmitterSpec { name: reader.name(), input, of, output, range, signal, limits, sample }))
}

impl PlantSpec for TransmitterSpec {
    fn name(&self) -> &str {
        &self.name
    }

    fn inputs(&self) -> Vec<PlantPort> {
        vec![PlantPort::quantity(self.input)]
    }

    fn outputs(&self) -> Vec<PlantPort> {
        vec![PlantPort::quantity(self.output)]
    }

    fn passes_at_once(&self) -> bool {
        true
    }

    fn check(&self) -> Vec<(Option<usize>, CircuitFault)> {
        Vec::new()
    }

    fn parameters(&self) -> Vec<PlantParameter> {
        let measure = |dimension, least| ParameterKind::Measure { dimension, least, most: 1e9 };
        let own = |least| measure(Dimension::Of(self.of.clone()), least);
        let parameter =
            |name: &str, takes, initial| PlantParameter { name: String::from(name), takes, initial };
        vec![
            parameter("offset", own(-1e9), 0.0),
            parameter("gain", measure(Dimension::Plain, -1e9), 1.0),
            parameter("drift", measure(Dimension::Rate(self.of.clone()), -1e9), 0.0),
            parameter("noise", own(0.0), 0.0),
            parameter("broken", ParameterKind::Flag, 0.0),
        ]
    }

    fn build(&self, random: Random) -> Box<dyn Plant> {
        let ((from, to), (low, high)) = (self.range, self.signal);
        let scale = (high - low) / (to - from);
        let most = libm::fabs(from * scale).max(libm::fabs(to * scale));
        let range = ShownRange::new(self.limits.0, self.limits.1, most);
        Box::new(Transmitter {
            spec: self.clone(),
            errors: Errors::NONE,
            input: NOTHING,
            is_exact: false,
            turns: None,
            range,
            value: SampledValue::new(self.sample, &[]).within(range),
            seed: random,
            random,
            ticks: None,
            started: Time::ZERO,
            outputs: [Value::HighZ],
        })
    }
}

const NOTHING: PlantInput = PlantInput { value: Value::HighZ, course: None };

/// What is wrong with a transmitter, in the unit of its input.
#[derive(Clone, Copy, Debug)]
struct Errors {
    offset: f64,
    gain: f64,
    /// In a second, from an instant on.
    drift: Course,
    noise: f64,
    broken: bool,
}

impl Errors {
    const NONE: Errors = Errors {
        offset: 0.0,
        gain: 1.0,
        drift: Course::constant(Time::ZERO, 0.0),
        noise: 0.0,
        broken: false,
    };
}

/// The signal goes with the measured quantity, held at its limits.
#[derive(Debug)]
struct Transmitter {
    spec: TransmitterSpec,
    errors: Errors,
    input: PlantInput,
    /// It goes by the course of its input, and not by its samples.
    is_exact: bool,
    /// When it comes to a limit, or leaves it.
    turns: Option<Time>,
    range: ShownRange,
    value: SampledValue,
    seed: Random,
    random: Random,
    /// When the next noise comes.
    ticks: Option<Time>,
    started: Time,
    outputs: [Value; 1],
}

/// How finely noise is drawn.
const STEPS: u64 = 1 << 32;

impl Transmitter {
    /// What it would signal without limits, as its input goes on; `None` where that is no course.
    fn exact(&self, now: Time) -> Option<Course> {
        let input = self.input.course?.mapped(self.errors.offset, self.errors.gain);
        let drifted = if self.errors.drift.is_settled(now) && self.errors.drift.value(now) == 0.0 {
            input
        } else {
            input.plus(&self.errors.drift, now)?
        };
        Some(self.signal_of(&drifted))
    }

    /// The same from the value of its input.
    fn sampled(&self, now: Time) -> Course {
        let value = self.input.value.as_real().unwrap_or(0.0);
        let held = Course::constant(now, self.errors.offset + self.errors.gain * value);
        self.signal_of(&held.plus(&self.errors.drift, now).unwrap_or(held))
    }

    fn signal_of(&self, measured: &Course) -> Course {
        let ((from, to), (low, high)) = (self.spec.range, self.spec.signal);
        let scale = (high - low) / (to - from);
        measured.mapped(low - from * scale, scale)
    }

    fn replan(&mut self, now: Time) {
        let exact = self.exact(now);
        self.is_exact = exact.is_some();
        let raw = exact.unwrap_or_else(|| self.sampled(now));
        let (low, high) = self.spec.limits;
        let (value, slope) = (raw.value(now), raw.slope(now));
        let course = if value < low || (value == low && slope < 0.0) {
            self.turns = raw.rises_to(low, now);
            Course::constant(now, low)
        } else if value > high || (value == high && slope > 0.0) {
            self.turns = raw.falls_to(high, now);
            Course::constant(now, high)
        } else {
            // Beyond a limit by more than rounding.
            let margin = (high - low) * 1e-12;
            let turns = [raw.falls_to(low - margin, now), raw.rises_to(high + margin, now)];
            self.turns = turns.into_iter().flatten().min();
            // What stays is what is shown of it, for what comes after this transmitter, too.
            if raw.is_constant() { Course::constant(now, self.range.shown(value)) } else { raw }
        };
        let before = self.value.course().value(now);
        let jumps = libm::fabs(course.value(now) - before) > (high - low) * 1e-9;
        let jumps = jumps || self.outputs[0] == Value::HighZ;
        if self.errors.broken {
            self.value.pause(course);
            self.outputs[0] = Value::HighZ;
        } else if self.is_noisy() {
            self.value.pause(course);
            if jumps {
                self.outputs[0] = Value::Real(course.value(now));
                self.add_noise();
            }
        } else if jumps {
            self.value.jump(now, course, &mut self.outputs[0]);
        } else {
            self.value.go_on(now, course, self.outputs[0]);
        }
        self.ticks = if self.is_noisy() { self.ticks.or_else(|| self.next_tick(now)) } else { None };
    }

    fn is_noisy(&self) -> bool {
        self.errors.noise > 0.0 && !self.errors.broken
    }

    fn next_tick(&self, now: Time) -> Option<Time> {
        let sample = self.spec.sample.as_nanos();
        let passed = now.as_nanos().saturating_sub(self.started.as_nanos()) / sample;
        let at = passed.checked_add(1)?.checked_mul(sample)?;
        self.started.as_nanos().checked_add(at).map(Time::from_nanos)
    }

    /// Each sample is off by up to the noise, all values as likely.
    fn add_noise(&mut self) {
        let ((from, to), (low, high)) = (self.spec.range, self.spec.signal);
        if let (true, Value::Real(value)) = (self.errors.noise > 0.0, self.outputs[0]) {
            let part = self.random.below(STEPS + 1) as f64 / STEPS as f64 * 2.0 - 1.0;
            let noisy = value + part * self.errors.noise * (high - low) / (to - from);
            self.outputs[0] = Value::Real(noisy.clamp(self.spec.limits.0, self.spec.limits.1));
        }
    }
}

impl Plant for Transmitter {
    fn start(&mut self, now: Time) {
        self.errors = Errors::NONE;
        self.input = NOTHING;
        self.random = self.seed;
        self.started = now;
        (self.turns, self.ticks) = (None, None);
        self.value.start(now, Course::constant(now, self.spec.limits.0), &mut self.outputs);
        self.replan(now);
    }

    fn input(&mut self, now: Time, _port: usize, input: &PlantInput) {
        // A further sample of a course that is known changes nothing.
        if self.is_exact && self.input.course == input.course {
            self.input.value = input.value;
            return;
        }
        let before = std::mem::replace(&mut self.input, *input);
        if before != *input {
            self.replan(now);
        }
    }

    fn next_event(&self) -> Option<Time> {
        self.turns.into_iter().chain(self.ticks).chain(self.value.next()).min()
    }

    fn advance(&mut self, now: Time) {
        self.value.advance(now, &mut self.outputs);
        if self.turns.is_some_and(|due| due <= now) {
            self.replan(now);
        }
        if self.ticks.is_some_and(|due| due <= now) {
            self.ticks = self.next_tick(now);
            self.outputs[0] = Value::Real(self.value.course().value(now));
            self.add_noise();
        }
    }

    fn outputs(&self) -> &[Value] {
        &self.outputs
    }

    fn course(&self, _output: usize) -> Option<&Course> {
        (!self.errors.broken && self.errors.noise == 0.0).then_some(self.value.course())
    }

    fn set(&mut self, now: Time, parameter: usize, value: f64) {
        match parameter {
            0 => self.errors.offset = value,
            1 => self.errors.gain = value,
            // What it has drifted up to now stays, unless it drifts no longer.
            2 if value == 0.0 => self.errors.drift = Course::constant(now, 0.0),
            2 => self.errors.drift = Course::line(now, self.errors.drift.value(now), value),
            3 => self.errors.noise = value,
            _ => self.errors.broken = value != 0.0,
        }
        self.replan(now);
    }
}
