//! A heater: a body that warms with one time constant, and a sensor that follows it with another.

use std::sync::Arc;

use document::{KeySpec, KeyType};
use signal::{Random, Span, Time, Value};

use super::decimals::Decimals;
use super::second_order::SecondOrder;
use super::{PlantKind, PlantReader, SwitchSpec, lag, reader, switches};
use crate::channel::ChannelId;
use crate::circuit::{CircuitFault, ParameterKind, Plant, PlantInput, PlantParameter, PlantPort, PlantSpec};
use crate::codes;
use crate::course::{Course, span_seconds};
use crate::measure::Dimension;

pub(super) const KIND: PlantKind = PlantKind {
    name: "heater",
    keys: &[
        reader::INPUT,
        reader::OUTPUT,
        KeySpec::required("ambient", KeyType::Quantity, "The temperature around it, with which it begins"),
        KeySpec::required("rise", KeyType::Quantity, "How much warmer it becomes at full power"),
        lag::TAU,
        KeySpec::required("sensor-tau", KeyType::Duration, "Time constant of the sensor"),
        reader::SAMPLE,
        switches::SWITCHES,
    ],
    read,
};

#[derive(Clone, Debug)]
struct HeaterSpec {
    name: String,
    input: PlantPort,
    output: ChannelId,
    unit: String,
    ambient: f64,
    rise: f64,
    tau: Span,
    sensor_tau: Span,
    sample: Span,
    switches: Vec<SwitchSpec>,
}

fn read(reader: &mut PlantReader<'_, '_>) -> Option<Arc<dyn PlantSpec>> {
    let (input, output) = (reader.channel("input"), reader.quantity("output"));
    let ((input, of), (output, unit)) = (input?, output?);
    let input = match of.as_deref() {
        None => PlantPort::level(input),
        Some("%") => PlantPort::quantity(input),
        Some(of) => {
            let message = format!("the power of a heater cannot be in `{of}`");
            let help = "name a digital channel, or an analog one in \"%\"";
            reader.error("input", codes::PLANT_UNIT, message, help);
            return None;
        }
    };
    let (ambient, rise) = (reader.number("ambient", &unit), reader.number("rise", &unit));
    let (tau, sensor_tau) = (reader.duration("tau"), reader.duration("sensor-tau"));
    let (sample, switches) = (reader.duration("sample"), switches::read(reader, &unit));
    Some(Arc::new(HeaterSpec {
        name: reader.name(),
        input,
        output,
        unit,
        ambient: ambient?,
        rise: rise?,
        tau: tau?,
        sensor_tau: sensor_tau?,
        sample: sample?,
        switches: switches?,
    }))
}

impl PlantSpec for HeaterSpec {
    fn name(&self) -> &str {
        &self.name
    }

    fn inputs(&self) -> Vec<PlantPort> {
        vec![self.input]
    }

    fn outputs(&self) -> Vec<PlantPort> {
        std::iter::once(PlantPort::quantity(self.output)).chain(switches::ports(&self.switches)).collect()
    }

    fn check(&self) -> Vec<(Option<usize>, CircuitFault)> {
        switches::check(&self.switches)
    }

    fn parameters(&self) -> Vec<PlantParameter> {
        let takes =
            ParameterKind::Measure { dimension: Dimension::Of(self.unit.clone()), least: -1e9, most: 1e9 };
        vec![
            PlantParameter { name: String::from("ambient"), takes: takes.clone(), initial: self.ambient },
            PlantParameter { name: String::from("rise"), takes, initial: self.rise },
            PlantParameter { name: String::from("broken"), takes: ParameterKind::Flag, initial: 0.0 },
        ]
    }

    fn build(&self, _random: Random) -> Box<dyn Plant> {
        let (body, sensor) = (span_seconds(self.tau), span_seconds(self.sensor_tau));
        // Two lags one after the other are one response of second order.
        let tau = libm::sqrt(body * sensor);
        let response = SecondOrder::new(self.sample, &self.switches, tau, (body + sensor) / (2.0 * tau));
        Box::new(Heater { spec: self.clone(), ambient: 0.0, rise: 0.0, broken: false, power: 0.0, response })
    }
}

#[derive(Debug)]
struct Heater {
    spec: HeaterSpec,
    ambient: f64,
    rise: f64,
    broken: bool,
    power: f64,
    response: SecondOrder,
}

impl Heater {
    fn target(&self) -> f64 {
        Decimals::sum(self.ambient, if self.broken { 0.0 } else { self.rise * self.power })
    }
}

impl Plant for Heater {
    fn start(&mut self, now: Time) {
        self.ambient = self.spec.ambient;
        self.rise = self.spec.rise;
        self.broken = false;
        self.power = 0.0;
        self.response.start(now, self.ambient, self.ambient);
    }

    fn input(&mut self, now: Time, _port: usize, input: &PlantInput) {
        self.power = match input.value {
            Value::Bool(on) => f64::from(u8::from(on)),
            other => other.as_real().unwrap_or(0.0).clamp(0.0, 100.0) / 100.0,
        };
        self.response.aim(now, self.target());
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
            0 => self.ambient = value,
            1 => self.rise = value,
            _ => self.broken = value != 0.0,
        }
        self.response.aim(now, self.target());
    }
}
