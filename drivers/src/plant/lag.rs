//! First-order lag with comparators, in closed form.

use std::sync::Arc;

use document::{KeySpec, KeyType};
use signal::{Random, Span, Time, Value};

use super::decimals::Decimals;
use super::{PlantKind, PlantReader, SwitchSpec, reader, switches};
use crate::channel::ChannelId;
use crate::circuit::{CircuitFault, ParameterKind, Plant, PlantInput, PlantParameter, PlantPort, PlantSpec};
use crate::codes;
use crate::course::{Course, span_seconds};
use crate::measure::Dimension;

pub(super) const LOW: KeySpec =
    KeySpec::optional("low", KeyType::Quantity, "Where it goes while a digital input is 0");
pub(super) const HIGH: KeySpec =
    KeySpec::optional("high", KeyType::Quantity, "Where it goes while a digital input is 1");
pub(super) const OFFSET: KeySpec =
    KeySpec::optional("offset", KeyType::Quantity, "Where it goes while an analog input is 0");
pub(super) const GAIN: KeySpec =
    KeySpec::optional("gain", KeyType::Number, "How much further it goes for each unit of an analog input");
pub(super) const TAU: KeySpec = KeySpec::required("tau", KeyType::Duration, "Time constant");

pub(super) const KIND: PlantKind = PlantKind {
    name: "lag",
    keys: &[
        reader::INPUT,
        reader::OUTPUT,
        LOW,
        HIGH,
        OFFSET,
        GAIN,
        reader::INITIAL,
        TAU,
        reader::SAMPLE,
        switches::SWITCHES,
    ],
    read,
};

/// What a lag strives for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LagTarget {
    /// For a digital input: `low` while it is 0 or undriven, `high` while it is 1.
    Levels {
        /// In the output's unit.
        low: f64,
        /// In the output's unit.
        high: f64,
    },
    /// For an analog input `x`: `offset + gain x`.
    Linear {
        /// In the output's unit.
        offset: f64,
        /// Output's unit per input's unit.
        gain: f64,
    },
}

impl LagTarget {
    /// Where an input sends it.
    pub(super) fn of(&self, input: Value) -> f64 {
        match *self {
            LagTarget::Levels { low, high } => {
                if input == Value::Bool(true) {
                    high
                } else {
                    low
                }
            }
            LagTarget::Linear { offset, gain } => {
                Decimals::sum(offset, gain * input.as_real().unwrap_or(0.0))
            }
        }
    }

    /// Where no input sends it.
    pub(super) fn lowest(&self) -> f64 {
        match *self {
            LagTarget::Levels { low, .. } => low,
            LagTarget::Linear { offset, .. } => offset,
        }
    }

    /// The terminal of its input.
    pub(super) fn port(&self, input: ChannelId) -> PlantPort {
        match self {
            LagTarget::Levels { .. } => PlantPort::level(input),
            LagTarget::Linear { .. } => PlantPort::quantity(input),
        }
    }

    /// What a plan can set of it, in the order that [`LagTarget::set`] counts.
    pub(super) fn parameters(&self, unit: &str) -> [PlantParameter; 2] {
        let number = |name: &str, dimension, initial| {
            let takes = ParameterKind::Measure { dimension, least: -1e9, most: 1e9 };
            PlantParameter { name: String::from(name), takes, initial }
        };
        let own = || Dimension::Of(unit.to_owned());
        match *self {
            LagTarget::Levels { low, high } => [number("low", own(), low), number("high", own(), high)],
            LagTarget::Linear { offset, gain } => {
                [number("offset", own(), offset), number("gain", Dimension::Plain, gain)]
            }
        }
    }

    /// Sets the first or the second of its numbers.
    pub(super) fn set(&mut self, place: usize, value: f64) {
        let (LagTarget::Levels { low: first, high: second }
        | LagTarget::Linear { offset: first, gain: second }) = self;
        *(if place == 0 { first } else { second }) = value;
    }

    pub(super) fn is_finite(&self) -> bool {
        let (LagTarget::Levels { low: one, high: other } | LagTarget::Linear { offset: one, gain: other }) =
            self;
        one.is_finite() && other.is_finite()
    }
}

/// A first-order lag: an oven, a filter.
#[derive(Clone, Debug, PartialEq)]
pub struct LagSpec {
    /// Name for messages.
    pub name: String,
    /// The channel that drives it.
    pub input: ChannelId,
    /// The analog channel that carries its sampled value.
    pub output: ChannelId,
    /// The unit of that channel.
    pub unit: String,
    /// Where the input sends it.
    pub target: LagTarget,
    /// Value at the start.
    pub initial: f64,
    /// Time constant, above 0.
    pub tau: Span,
    /// Time between two samples of the output, above 0.
    pub sample: Span,
    /// Comparators on its value.
    pub switches: Vec<SwitchSpec>,
}

impl PlantSpec for LagSpec {
    fn name(&self) -> &str {
        &self.name
    }

    fn inputs(&self) -> Vec<PlantPort> {
        vec![self.target.port(self.input)]
    }

    fn outputs(&self) -> Vec<PlantPort> {
        std::iter::once(PlantPort::quantity(self.output)).chain(switches::ports(&self.switches)).collect()
    }

    fn check(&self) -> Vec<(Option<usize>, CircuitFault)> {
        let mut faults = switches::check(&self.switches);
        if !(self.target.is_finite() && self.initial.is_finite()) {
            faults.insert(0, (None, CircuitFault::NotFinite));
        } else if self.tau <= Span::ZERO || self.sample <= Span::ZERO {
            faults.insert(0, (None, CircuitFault::BadTime));
        }
        faults
    }

    fn parameters(&self) -> Vec<PlantParameter> {
        std::iter::once(time_constant(self.tau)).chain(self.target.parameters(&self.unit)).collect()
    }

    fn build(&self, _random: Random) -> Box<dyn Plant> {
        Box::new(Lag::new(self))
    }
}

/// The time constant of a plant as a parameter.
pub(super) fn time_constant(initial: Span) -> PlantParameter {
    let takes = ParameterKind::Measure { dimension: Dimension::Time, least: 1e-9, most: 1e9 };
    PlantParameter { name: String::from("tau"), takes, initial: span_seconds(initial) }
}

fn read(reader: &mut PlantReader<'_, '_>) -> Option<Arc<dyn PlantSpec>> {
    let (input, output) = (reader.channel("input"), reader.quantity("output"));
    let ((input, of), (output, unit)) = (input?, output?);
    let target = target(reader, of.is_none(), &unit, "lag");
    let initial = reader.has("initial").then(|| reader.number("initial", &unit));
    let switches = switches::read(reader, &unit);
    let target = target?;
    let initial = initial.unwrap_or(Some(target.lowest()))?;
    // Times of 0 are found with the board as a whole.
    let (tau, sample) = (reader.any_duration("tau")?, reader.any_duration("sample")?);
    let name = reader.name();
    Some(Arc::new(LagSpec { name, input, output, unit, target, initial, tau, sample, switches: switches? }))
}

/// Where the input of a plant sends it: by `low` and `high`, or by `offset` and `gain`.
pub(super) fn target(
    reader: &mut PlantReader<'_, '_>,
    digital: bool,
    unit: &str,
    what: &str,
) -> Option<LagTarget> {
    let (own, other) =
        if digital { (["low", "high"], ["offset", "gain"]) } else { (["offset", "gain"], ["low", "high"]) };
    let kind = if digital { "a digital" } else { "an analog" };
    for key in other {
        let message = format!("a {what} with {kind} input has no `{key}`");
        let help = format!("say where it goes by `{}` and `{}`", own[0], own[1]);
        reader.error_of_key(key, codes::PLANT_TARGET, message, &help);
    }
    let mut numbers = [None; 2];
    for (number, key) in numbers.iter_mut().zip(own) {
        if reader.has(key) {
            *number = reader.number(key, if key == "gain" { "" } else { unit });
        } else {
            let message = format!("a {what} with {kind} input needs `{key}`");
            reader.error(key, codes::PLANT_TARGET, message, &format!("add `{key}`"));
        }
    }
    let [Some(first), Some(second)] = numbers else { return None };
    Some(if digital {
        LagTarget::Levels { low: first, high: second }
    } else {
        LagTarget::Linear { offset: first, gain: second }
    })
}

/// Time constants after which the value is the target.
const SETTLED: i64 = 40;

/// `y(t) = target + (y0 - target) exp(-(t - t0) / tau)`, sampled for its output, with switches at the computed
/// instants of crossing.
///
/// Input 0 sets the target. Output 0 is the value, sampled every `sample` from the start; outputs 1 and up are
/// the switches, by the true value and not by its samples.
#[derive(Debug)]
pub struct Lag {
    /// As the board file has it.
    planned: (LagTarget, Span),
    initial: f64,
    input: Value,
    target_of: LagTarget,
    tau: Span,
    sample: Span,
    switches: Vec<Switch>,
    started: Time,
    since: Time,
    from: f64,
    target: f64,
    /// The same as a course.
    course: Course,
    next_sample: Option<Time>,
    outputs: Vec<Value>,
}

#[derive(Clone, Copy, Debug)]
struct Switch {
    on_above: f64,
    off_below: f64,
    on: bool,
    flips: Option<Time>,
}

impl Lag {
    /// The lag of a checked description, not started.
    pub fn new(spec: &LagSpec) -> Self {
        let switch = |spec: &SwitchSpec| Switch {
            on_above: spec.on_above,
            off_below: spec.off_below,
            on: false,
            flips: None,
        };
        let mut lag = Lag {
            planned: (spec.target, spec.tau),
            initial: spec.initial,
            input: Value::HighZ,
            target_of: spec.target,
            tau: spec.tau,
            sample: spec.sample,
            switches: spec.switches.iter().map(switch).collect(),
            started: Time::ZERO,
            since: Time::ZERO,
            from: spec.initial,
            target: spec.initial,
            course: Course::constant(Time::ZERO, spec.initial),
            next_sample: None,
            outputs: vec![Value::HighZ; 1 + spec.switches.len()],
        };
        lag.start(Time::ZERO);
        lag
    }

    /// The value at an instant that is not before the last change of the target. After 40 time constants it is
    /// the target itself: what is left is below the rounding of the sum.
    pub fn value(&self, at: Time) -> f64 {
        let elapsed = elapsed(self.since, at);
        if elapsed >= self.tau.as_nanos().saturating_mul(SETTLED) {
            return self.target;
        }
        self.target + (self.from - self.target) * libm::exp(-(elapsed as f64) / self.tau.as_nanos() as f64)
    }

    /// The first nanosecond after `since` at which the value has reached `level` on its way to the target.
    fn crossing(&self, level: f64) -> Option<Time> {
        let (whole, rest) = (self.from - self.target, level - self.target);
        if rest == 0.0 || (whole > 0.0) != (rest > 0.0) || libm::fabs(rest) >= libm::fabs(whole) {
            return None;
        }
        let nanos = libm::ceil(self.tau.as_nanos() as f64 * libm::log(whole / rest));
        let settled = self.tau.as_nanos().saturating_mul(SETTLED);
        let nanos = if nanos < settled as f64 { (nanos as i64).max(1) } else { settled };
        self.since.as_nanos().checked_add(nanos).map(Time::from_nanos)
    }

    /// Sets when the switches flip after a change of the target at `since`. After a flip there is nothing to
    /// plan: the value moves on, away from the threshold that flips it back.
    fn plan_switches(&mut self) {
        for place in 0..self.switches.len() {
            let Switch { on_above, off_below, on, flips } = self.switches[place];
            // A flip that is due at the very instant of the change still happens then.
            if flips.is_some_and(|due| due <= self.since) {
                continue;
            }
            self.switches[place].flips = match on {
                // Rounding can bring the value to the threshold a nanosecond before the computed crossing.
                false if self.from >= on_above => Some(self.since.saturating_add(Span::from_nanos(1))),
                true if self.from <= off_below => Some(self.since.saturating_add(Span::from_nanos(1))),
                false if self.target > self.from => self.crossing(on_above),
                true if self.target < self.from => self.crossing(off_below),
                _ => None,
            };
        }
    }

    /// It goes where its input sends it now.
    fn aim(&mut self, now: Time) {
        let target = self.target_of.of(self.input);
        if target != self.target && target.is_finite() {
            self.change(now, |lag| lag.target = target);
        }
    }

    /// It goes on from where it is by another target or time constant.
    fn change(&mut self, now: Time, change: impl FnOnce(&mut Lag)) {
        self.from = self.value(now);
        self.since = now;
        change(self);
        self.note_course();
        self.plan_switches();
        if self.next_sample.is_none_or(|due| due > now) {
            self.plan_sample(now);
        }
    }

    fn note_course(&mut self) {
        self.course = Course::lag(self.since, self.from, self.target, span_seconds(self.tau));
    }

    /// Sets the next instant of the grid of samples: none where the output stands at its target for good.
    fn plan_sample(&mut self, now: Time) {
        if self.value(now) == self.target && self.outputs[0].as_real() == Some(self.target) {
            self.next_sample = None;
            return;
        }
        let sample = self.sample.as_nanos();
        let passed = elapsed(self.started, now) / sample;
        let next = passed.checked_add(1).and_then(|count| count.checked_mul(sample));
        self.next_sample =
            next.and_then(|next| self.started.as_nanos().checked_add(next)).map(Time::from_nanos);
    }
}

/// Nanoseconds between two instants, held at the range and at 0.
fn elapsed(from: Time, to: Time) -> i64 {
    to.as_nanos().saturating_sub(from.as_nanos()).max(0)
}

impl Plant for Lag {
    fn start(&mut self, now: Time) {
        self.started = now;
        self.since = now;
        (self.target_of, self.tau) = self.planned;
        self.input = Value::HighZ;
        self.from = self.initial;
        self.target = self.target_of.of(Value::HighZ);
        self.outputs[0] = Value::Real(self.initial);
        for (switch, output) in self.switches.iter_mut().zip(&mut self.outputs[1..]) {
            switch.on = self.initial >= switch.on_above;
            switch.flips = None;
            *output = Value::Bool(switch.on);
        }
        self.note_course();
        self.plan_switches();
        self.plan_sample(now);
    }

    fn input(&mut self, now: Time, _port: usize, input: &PlantInput) {
        self.input = input.value;
        self.aim(now);
    }

    fn next_event(&self) -> Option<Time> {
        self.switches.iter().filter_map(|switch| switch.flips).chain(self.next_sample).min()
    }

    fn advance(&mut self, now: Time) {
        if self.next_sample == Some(now) {
            let value = self.value(now);
            self.outputs[0] = Value::Real(value);
            let next = now.as_nanos().checked_add(self.sample.as_nanos()).map(Time::from_nanos);
            self.next_sample = if value == self.target { None } else { next };
        } else if self.next_sample.is_some_and(|due| due <= now) {
            // Where a call spans several samples the output is the newest of them.
            let sample = self.sample.as_nanos();
            let grid = Span::from_nanos(elapsed(self.started, now) / sample * sample);
            let at = self.started.saturating_add(grid).max(self.since);
            self.outputs[0] = Value::Real(self.value(at));
            self.plan_sample(now);
        }
        for (switch, output) in self.switches.iter_mut().zip(&mut self.outputs[1..]) {
            if switch.flips.is_some_and(|due| due <= now) {
                switch.on = !switch.on;
                switch.flips = None;
                *output = Value::Bool(switch.on);
            }
        }
    }

    fn outputs(&self) -> &[Value] {
        &self.outputs
    }

    fn set(&mut self, now: Time, parameter: usize, value: f64) {
        match parameter {
            0 => {
                // The range of the parameter fits into the nanoseconds of a duration.
                let tau = Span::from_nanos(libm::round(value * 1e9) as i64).max(Span::from_nanos(1));
                self.change(now, |lag| lag.tau = tau);
            }
            _ => {
                self.target_of.set(parameter - 1, value);
                self.aim(now);
            }
        }
    }

    fn course(&self, output: usize) -> Option<&Course> {
        (output == 0).then_some(&self.course)
    }
}
