//! Second-order response with damping, in closed form.

use std::sync::Arc;

use document::{KeySpec, KeyType};
use signal::{Random, Span, Time, Value};

use super::lag::{LagTarget, target};
use super::sampled::SampledValue;
use super::{PlantKind, PlantReader, SwitchSpec, lag, reader, switches};
use crate::channel::ChannelId;
use crate::circuit::{CircuitFault, ParameterKind, Plant, PlantInput, PlantParameter, PlantPort, PlantSpec};
use crate::course::{Course, span_seconds};
use crate::measure::Dimension;

pub(super) const KIND: PlantKind = PlantKind {
    name: "second-order",
    keys: &[
        reader::INPUT,
        reader::OUTPUT,
        lag::LOW,
        lag::HIGH,
        lag::OFFSET,
        lag::GAIN,
        reader::INITIAL,
        lag::TAU,
        KeySpec::required("damping", KeyType::Number, "From 0.01 on; below 1 it overshoots"),
        reader::SAMPLE,
        switches::SWITCHES,
    ],
    read,
};

/// `tau^2 y'' + 2 damping tau y' + y = target`.
#[derive(Clone, Debug)]
struct SecondOrderSpec {
    name: String,
    input: ChannelId,
    output: ChannelId,
    unit: String,
    target: LagTarget,
    initial: f64,
    tau: Span,
    damping: f64,
    sample: Span,
    switches: Vec<SwitchSpec>,
}

/// Damping within these is that of a response without overshoot at its fastest: the difference of its two time constants could
/// not be computed.
const CRITICAL: std::ops::RangeInclusive<f64> = 0.999_999_999..=1.000_000_001;

fn read(reader: &mut PlantReader<'_, '_>) -> Option<Arc<dyn PlantSpec>> {
    let (input, output) = (reader.channel("input"), reader.quantity("output"));
    let ((input, of), (output, unit)) = (input?, output?);
    let target = target(reader, of.is_none(), &unit, "second-order plant");
    let initial = reader.has("initial").then(|| reader.number("initial", &unit));
    let damping = reader.measure("damping", &Dimension::Plain, 0.01, 1e3);
    let (tau, sample) = (reader.duration("tau"), reader.duration("sample"));
    let switches = switches::read(reader, &unit);
    let target = target?;
    Some(Arc::new(SecondOrderSpec {
        name: reader.name(),
        input,
        output,
        unit,
        target,
        initial: initial.unwrap_or(Some(target.lowest()))?,
        tau: tau?,
        damping: damping?,
        sample: sample?,
        switches: switches?,
    }))
}

impl PlantSpec for SecondOrderSpec {
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
        switches::check(&self.switches)
    }

    fn parameters(&self) -> Vec<PlantParameter> {
        let takes = ParameterKind::Measure { dimension: Dimension::Plain, least: 0.01, most: 1e3 };
        let damping = PlantParameter { name: String::from("damping"), takes, initial: self.damping };
        [damping, lag::time_constant(self.tau)]
            .into_iter()
            .chain(self.target.parameters(&self.unit))
            .collect()
    }

    fn build(&self, _random: Random) -> Box<dyn Plant> {
        let response = SecondOrder::new(self.sample, &self.switches, span_seconds(self.tau), self.damping);
        Box::new(SecondOrderPlant { spec: self.clone(), input: Value::HighZ, target: self.target, response })
    }
}

/// The response of second order to a target that jumps, with samples and comparators.
#[derive(Debug)]
pub(super) struct SecondOrder {
    tau: f64,
    damping: f64,
    target: f64,
    value: SampledValue,
    outputs: Vec<Value>,
}

impl SecondOrder {
    /// `tau` in seconds.
    pub(super) fn new(sample: Span, switches: &[SwitchSpec], tau: f64, damping: f64) -> SecondOrder {
        let value = SampledValue::new(sample, switches);
        SecondOrder { tau, damping, target: 0.0, value, outputs: vec![Value::HighZ; 1 + switches.len()] }
    }

    fn response(&self, now: Time, value: f64, slope: f64) -> Course {
        let damping = if CRITICAL.contains(&self.damping) { 1.0 } else { self.damping };
        Course::second_order(now, value, slope, self.target, 1.0 / self.tau, damping)
    }

    pub(super) fn start(&mut self, now: Time, initial: f64, target: f64) {
        self.target = target;
        let course = self.response(now, initial, 0.0);
        self.value.start(now, course, &mut self.outputs);
    }

    pub(super) fn aim(&mut self, now: Time, target: f64) {
        if target != self.target && target.is_finite() {
            self.target = target;
            self.replan(now);
        }
    }

    fn replan(&mut self, now: Time) {
        let before = self.value.course();
        let course = self.response(now, before.value(now), before.slope(now));
        self.value.go_on(now, course, self.outputs[0]);
    }

    /// It goes on from where it is, as fast as it moves there, with another time constant in seconds or another damping.
    fn change(&mut self, now: Time, tau: f64, damping: f64) {
        (self.tau, self.damping) = (tau, damping);
        self.replan(now);
    }

    pub(super) fn next(&self) -> Option<Time> {
        self.value.next()
    }

    pub(super) fn advance(&mut self, now: Time) {
        self.value.advance(now, &mut self.outputs);
    }

    pub(super) fn outputs(&self) -> &[Value] {
        &self.outputs
    }

    pub(super) fn course(&self, output: usize) -> Option<&Course> {
        (output == 0).then_some(self.value.course())
    }
}

#[derive(Debug)]
struct SecondOrderPlant {
    spec: SecondOrderSpec,
    input: Value,
    target: LagTarget,
    response: SecondOrder,
}

impl Plant for SecondOrderPlant {
    fn start(&mut self, now: Time) {
        self.input = Value::HighZ;
        self.target = self.spec.target;
        (self.response.tau, self.response.damping) = (span_seconds(self.spec.tau), self.spec.damping);
        self.response.start(now, self.spec.initial, self.target.of(Value::HighZ));
    }

    fn input(&mut self, now: Time, _port: usize, input: &PlantInput) {
        self.input = input.value;
        self.response.aim(now, self.target.of(self.input));
    }

    fn next_event(&self) -> Option<Time> {
        self.response.next()
    }

    fn advance(&mut self, now: Time) {
        self.response.advance(now);
    }

    fn outputs(&self) -> &[Value] {
        self.response.outputs()
    }

    fn course(&self, output: usize) -> Option<&Course> {
        self.response.course(output)
    }

    fn set(&mut self, now: Time, parameter: usize, value: f64) {
        match parameter {
            0 => self.response.change(now, self.response.tau, value),
            1 => self.response.change(now, value, self.response.damping),
            _ => {
                self.target.set(parameter - 2, value);
                self.response.aim(now, self.target.of(self.input));
            }
        }
    }
}
