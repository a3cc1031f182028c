//! A tank: what flows in and out, and its level.

use std::sync::Arc;

use document::{KeySpec, KeyType};
use signal::{Random, Span, Time, Value};

use super::decimals::ShownRange;
use super::sampled::SampledValue;
use super::{PlantKind, PlantReader, SwitchSpec, reader, switches};
use crate::channel::ChannelId;
use crate::circuit::{CircuitFault, ParameterKind, Plant, PlantInput, PlantParameter, PlantPort, PlantSpec};
use crate::codes;
use crate::course::Course;
use crate::measure::Dimension;

const FLOW: &[KeySpec] = &[
    KeySpec::optional("name", KeyType::Text, "Its name among the parameters of the plant"),
    KeySpec::optional(
        "channel",
        KeyType::Text,
        "The channel that drives it; it flows all the time if left out",
    ),
    KeySpec::optional(
        "flow",
        KeyType::Quantity,
        "How much flows while a digital channel is 1, or at 100 % of an analog one, as in \"2 l/min\"",
    ),
    KeySpec::optional(
        "at-level",
        KeyType::Quantity,
        "The level at which that flows out; it goes with the square root of the level then",
    ),
];

pub(super) const KIND: PlantKind = PlantKind {
    name: "tank",
    keys: &[
        KeySpec::required("area", KeyType::Quantity, "Its area, as in \"0.5 m2\""),
        KeySpec::required("height", KeyType::Quantity, "The level at which it overflows, as in \"2 m\""),
        KeySpec::optional("inflows", KeyType::List(&KeyType::Table(FLOW)), "What flows in"),
        KeySpec::optional("outflows", KeyType::List(&KeyType::Table(FLOW)), "What flows out"),
        reader::OUTPUT,
        reader::INITIAL,
        reader::SAMPLE,
        switches::SWITCHES,
        KeySpec::optional("overflow", KeyType::Text, "The digital channel that is 1 while it overflows"),
    ],
    read,
};

/// The parameter of every tank: what flows out beside its flows.
const LEAK: &str = "leak";

/// What acts on a flow.
#[derive(Clone, Copy, Debug, PartialEq)]
enum FlowInput {
    /// Nothing: it flows all the time.
    Always,
    /// A digital channel: it flows while that is 1.
    Level(ChannelId),
    /// An analog channel: so much flows for each of its unit.
    Quantity(ChannelId, f64),
}

/// One inflow or outflow.
#[derive(Clone, Debug, PartialEq)]
struct FlowSpec {
    name: String,
    input: FlowInput,
    /// Cubic metres in a second, as far as its input does not say it; 1 where that does.
    flow: f64,
    /// Whether its input says how much flows; `flow` is a factor on that then.
    measured: bool,
    /// 1 for an inflow, -1 for an outflow.
    sign: f64,
    /// Metres: the level at which `flow` flows, where it goes with the square root of the level.
    at_level: Option<f64>,
}

#[derive(Clone, Debug)]
struct TankSpec {
    name: String,
    area: f64,
    height: f64,
    flows: Vec<FlowSpec>,
    output: ChannelId,
    /// The output's unit for a metre, and for the height.
    scale: f64,
    full: f64,
    initial: f64,
    sample: Span,
    switches: Vec<SwitchSpec>,
    overflow: Option<ChannelId>,
}

fn read(reader: &mut PlantReader<'_, '_>) -> Option<Arc<dyn PlantSpec>> {
    let area = reader.measure("area", &Dimension::Area, 1e-9, 1e9);
    let height = reader.measure("height", &Dimension::Length, 1e-6, 1e6);
    let output = reader.quantity("output");
    let (area, height) = (area?, height?);
    let (output, unit) = output?;
    let (scale, full) = match (Dimension::Length.of_unit(&unit), Dimension::Volume.of_unit(&unit)) {
        (Some(length), _) => (1.0 / length, height / length),
        (None, Some(volume)) => (area / volume, area * height / volume),
        (None, None) if unit == "%" => (100.0 / height, 100.0),
        (None, None) => {
            let message = format!("the level of a tank cannot be in `{unit}`");
            let help =
                "give its channel a unit of length or volume, as in \"m\" or \"l\", or \"%\" of its height";
            reader.error("output", codes::PLANT_UNIT, message, help);
            return None;
        }
    };
    // What is written in decimals is met in decimals: a switch at the height is on in a full tank.
    let full = libm::round(full * 1e9) / 1e9;
    let initial = match reader.has("initial") {
        true => reader.measure("initial", &Dimension::Of(unit.clone()), 0.0, full),
        false => Some(0.0),
    };
    let inflows = flows(reader, "inflows", 1.0);
    let outflows = flows(reader, "outflows", -1.0);
    let switches = switches::read(reader, &unit);
    if let Some(beyond) = switches.iter().flatten().find(|switch| switch.on_above > full) {
        let message = format!(
            "a switch goes on above {} {unit}, and the tank is full at {full} {unit}",
            beyond.on_above
        );
        let help = format!("write a level of up to {full} {unit}; a number without a unit is in {unit}");
        reader.error("switches", codes::PLANT_RANGE, message, &help);
        return None;
    }
    let overflow = match reader.has("overflow") {
        true => Some(reader.level("overflow")?),
        false => None,
    };
    let sample = reader.duration("sample");
    let flows: Vec<FlowSpec> = inflows?.into_iter().chain(outflows?).collect();
    if let Some(twin) =
        flows.iter().enumerate().find(|(at, flow)| flows[..*at].iter().any(|f| f.name == flow.name))
    {
        let message = format!("two flows are called `{}`", twin.1.name);
        reader.error("name", codes::PLANT_FLOW, message, "give each of them a `name` of its own");
        return None;
    }
    if flows.iter().any(|flow| flow.name == LEAK) {
        let message = format!("a flow cannot be called `{LEAK}`");
        reader.error(
            "name",
            codes::PLANT_FLOW,
            message,
            "every tank has that parameter: choose another name",
        );
        return None;
    }
    Some(Arc::new(TankSpec {
        name: reader.name(),
        area,
        height,
        flows,
        output,
        scale,
        full,
        initial: (initial? / scale).min(height),
        sample: sample?,
        switches: switches?,
        overflow,
    }))
}

/// The flows of a list, `sign` 1 or -1.
fn flows(reader: &mut PlantReader<'_, '_>, key: &str, sign: f64) -> Option<Vec<FlowSpec>> {
    let single = key.trim_end_matches('s');
    let count = reader.count(key);
    let mut place = 0;
    reader.each(key, FLOW, |reader| {
        place += 1;
        let name = match reader.text("name") {
            Some(name) => name.to_owned(),
            None if count == 1 => single.to_owned(),
            None => format!("{single}-{place}"),
        };
        let flow = reader.has("flow").then(|| reader.measure("flow", &Dimension::Flow, 0.0, 1e6));
        let at_level = match reader.has("at-level") {
            true => Some(reader.measure("at-level", &Dimension::Length, 1e-6, 1e6)?),
            false => None,
        };
        if at_level.is_some() && sign > 0.0 {
            let message = String::from("what flows in does not depend on the level");
            reader.error_of_key("at-level", codes::PLANT_FLOW, message, "remove it");
            return None;
        }
        let unit = match reader.has("channel") {
            true => Some(reader.channel("channel")?),
            false => None,
        };
        let needs = "say how much flows, as in flow = \"2 l/min\"";
        let (input, flow, measured) = match (unit, flow) {
            (None, Some(flow)) => (FlowInput::Always, flow?, false),
            (Some((channel, None)), Some(flow)) => (FlowInput::Level(channel), flow?, false),
            (Some((channel, Some(unit))), flow) => match (Dimension::Flow.of_unit(&unit), flow) {
                (Some(each), None) => (FlowInput::Quantity(channel, each), 1.0, true),
                (Some(_), Some(_)) => {
                    let message = format!("its channel says in {unit} how much flows");
                    reader.error_of_key("flow", codes::PLANT_FLOW, message, "remove it");
                    return None;
                }
                (None, Some(flow)) if unit == "%" => (FlowInput::Quantity(channel, 0.01), flow?, false),
                (None, None) if unit == "%" => {
                    reader.error("flow", codes::PLANT_FLOW, String::from("it has no `flow`"), needs);
                    return None;
                }
                (None, _) => {
                    let message = format!("a channel in `{unit}` does not say how much flows");
                    let help =
                        "name a digital channel, or an analog one in \"%\" or in a unit such as \"l/min\"";
                    reader.error("channel", codes::PLANT_UNIT, message, help);
                    return None;
                }
            },
            (_, None) => {
                reader.error("flow", codes::PLANT_FLOW, String::from("it has no `flow`"), needs);
                return None;
            }
        };
        Some(FlowSpec { name, input, flow, measured, sign, at_level })
    })
}

impl PlantSpec for TankSpec {
    fn name(&self) -> &str {
        &self.name
    }

    fn inputs(&self) -> Vec<PlantPort> {
        let port = |flow: &FlowSpec| match flow.input {
            FlowInput::Always => None,
            FlowInput::Level(channel) => Some(PlantPort::level(channel)),
            FlowInput::Quantity(channel, _) => Some(PlantPort::quantity(channel)),
        };
        self.flows.iter().filter_map(port).collect()
    }

    fn outputs(&self) -> Vec<PlantPort> {
        let output = std::iter::once(PlantPort::quantity(self.output));
        let overflow = self.overflow.map(PlantPort::level);
        output.chain(switches::ports(&self.switches)).chain(overflow).collect()
    }

    fn check(&self) -> Vec<(Option<usize>, CircuitFault)> {
        switches::check(&self.switches)
    }

    fn parameters(&self) -> Vec<PlantParameter> {
        let of = |dimension, most| ParameterKind::Measure { dimension, least: 0.0, most };
        let flow = |flow: &FlowSpec| {
            let takes = if flow.measured { of(Dimension::Part, 1e3) } else { of(Dimension::Flow, 1e6) };
            PlantParameter { name: flow.name.clone(), takes, initial: flow.flow }
        };
        let leak = PlantParameter { name: String::from(LEAK), takes: of(Dimension::Flow, 1e6), initial: 0.0 };
        self.flows.iter().map(flow).chain([leak]).collect()
    }

    fn build(&self, _random: Random) -> Box<dyn Plant> {
        Box::new(Tank::new(self))
    }
}

/// One flow at work.
#[derive(Clone, Copy, Debug)]
struct Flow {
    input: FlowInput,
    flow: f64,
    sign: f64,
    at_level: Option<f64>,
    /// What acts on it.
    driven: PlantInput,
}

impl Flow {
    /// The part of its flow that its input lets through, by its value.
    fn opening(&self) -> f64 {
        match self.input {
            FlowInput::Always => 1.0,
            FlowInput::Level(_) => f64::from(u8::from(self.driven.value == Value::Bool(true))),
            FlowInput::Quantity(_, each) => each * self.driven.value.as_real().unwrap_or(0.0),
        }
    }

    /// How it goes on from `now`: as its input does, where that is known.
    fn course(&self, now: Time, exact: bool) -> Course {
        match (self.input, self.driven.course) {
            (FlowInput::Quantity(_, each), Some(course)) if exact => {
                course.mapped(0.0, self.sign * self.flow * each)
            }
            _ => Course::constant(now, self.sign * self.flow * self.opening()),
        }
    }
}

/// Where the level is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    /// Between the ends.
    Between,
    /// At 0, and no more flows in than out.
    Empty,
    /// At its height, and no less flows in than out.
    Full,
}

/// The volume changes by what flows in and out: `area h' = inflows - outflows`; an outflow by its own weight goes with the
/// square root of the level. The level stays at 0 while more flows out than in, and at its height while it overflows.
#[derive(Debug)]
struct Tank {
    area: f64,
    height: f64,
    scale: f64,
    full: f64,
    initial: f64,
    /// The flows as the board file has them.
    planned: Vec<f64>,
    flows: Vec<Flow>,
    /// The flows with an input, by the number of the input.
    driven: Vec<usize>,
    leak: f64,
    /// The level in metres.
    level: Course,
    /// All flows together while the level stays at an end.
    net: Course,
    place: Place,
    /// When the level comes to an end, or leaves it.
    turns: Option<Time>,
    value: SampledValue,
    /// The place of the overflow's channel among the outputs.
    overflow: Option<usize>,
    /// Whether more flows in than out while it is full.
    overflows: bool,
    /// When the overflow changes.
    overflow_changes: Option<Time>,
    outputs: Vec<Value>,
}

/// The part of all flows together that is rounding where they cancel out.
const ROUNDING: f64 = 1e-12;

const NOTHING: PlantInput = PlantInput { value: Value::HighZ, course: None };

impl Tank {
    fn new(spec: &TankSpec) -> Tank {
        let flow = |flow: &FlowSpec| Flow {
            input: flow.input,
            flow: flow.flow,
            sign: flow.sign,
            at_level: flow.at_level,
            driven: NOTHING,
        };
        let driven = spec.flows.iter().enumerate().filter(|(_, flow)| flow.input != FlowInput::Always);
        let count = 1 + spec.switches.len();
        Tank {
            area: spec.area,
            height: spec.height,
            scale: spec.scale,
            full: spec.full,
            initial: spec.initial,
            planned: spec.flows.iter().map(|flow| flow.flow).collect(),
            flows: spec.flows.iter().map(flow).collect(),
            driven: driven.map(|(place, _)| place).collect(),
            leak: 0.0,
            level: Course::constant(Time::ZERO, spec.initial),
            net: Course::constant(Time::ZERO, 0.0),
            place: Place::Between,
            turns: None,
            value: SampledValue::new(spec.sample, &spec.switches)
                .within(ShownRange::new(0.0, spec.full, spec.full)),
            overflow: spec.overflow.map(|_| count),
            overflows: false,
            overflow_changes: None,
            outputs: vec![Value::HighZ; count + usize::from(spec.overflow.is_some())],
        }
    }

    /// What flows in less what flows out, but for outflows that go with the level; `exact` as their inputs go on, else as they
    /// are now. `None` where that is no course.
    fn flowing(&self, now: Time, exact: bool) -> Option<Course> {
        let mut sum = Course::constant(now, -self.leak);
        for flow in self.flows.iter().filter(|flow| flow.at_level.is_none()) {
            sum = sum.plus(&flow.course(now, exact), now)?;
        }
        Some(sum)
    }

    /// The level goes on from this one, by the flows as they are known now.
    fn plan(&mut self, now: Time, level: f64) {
        let drain: f64 = self
            .flows
            .iter()
            .filter_map(|flow| Some(flow.flow * flow.opening().max(0.0) / libm::sqrt(flow.at_level?)))
            .sum();
        let constant = Course::constant(now, 0.0);
        // An outflow that goes with the level has a closed form where the others are constant.
        let exact = if drain > 0.0 { None } else { self.flowing(now, true) };
        let net = exact.or_else(|| self.flowing(now, false)).unwrap_or(constant);
        let rate = net.mapped(0.0, 1.0 / self.area);
        let free = if drain > 0.0 {
            Course::draining(now, level, rate.value(now), drain / self.area)
        } else {
            let exactly = rate.integral(now, level);
            exactly.unwrap_or_else(|| Course::line(now, level, rate.value(now)))
        };
        let out = drain * libm::sqrt(level);
        let net = net.mapped(-out, 1.0);
        let rounding = self.rounding(out);
        // Above 0 where more flows in than out; where as much flows in as out the next moments decide.
        let value = net.value(now);
        let balance = if libm::fabs(value) > rounding { value } else { net.slope(now) };
        self.place = if level <= 0.0 && balance <= 0.0 {
            Place::Empty
        } else if level >= self.height && balance >= 0.0 {
            Place::Full
        } else {
            Place::Between
        };
        self.overflows = self.place == Place::Full && balance > 0.0;
        self.net = net;
        self.level = match self.place {
            Place::Between => free,
            Place::Empty => constant,
            Place::Full => Course::constant(now, self.height),
        };
        self.turns = match self.place {
            Place::Between => {
                // From an end it first has to get away, by more than rounding.
                let away = self.height * 1e-12;
                let from_empty = if level <= 0.0 { free.rises_to(away, now) } else { Some(now) };
                let from_full =
                    if level >= self.height { free.falls_to(self.height - away, now) } else { Some(now) };
                let empty = from_empty.and_then(|from| free.falls_to(0.0, from));
                let full = from_full.and_then(|from| free.rises_to(self.height, from));
                // Where it turns back within rounding it is at the end again.
                let beyond = [free.falls_to(-away, now), free.rises_to(self.height + away, now)];
                beyond.into_iter().chain([empty, full]).flatten().min()
            }
            Place::Empty => net.rises_to((2.0 * rounding).max(f64::MIN_POSITIVE), now),
            Place::Full => net.falls_to(-(2.0 * rounding).max(f64::MIN_POSITIVE), now),
        };
    }

    /// What is left where flows cancel out; `out` is what the level lets flow out.
    fn rounding(&self, out: f64) -> f64 {
        let each = self.flows.iter().filter(|flow| flow.at_level.is_none());
        let gross: f64 = each.map(|flow| libm::fabs(flow.flow * flow.opening())).sum();
        ROUNDING * (gross + self.leak + out)
    }

    fn replan(&mut self, now: Time) {
        // An end that is reached at this very instant is reached first.
        let due = self.turns.is_some_and(|due| due <= now) && self.place == Place::Between;
        let mut level = self.level.value(now).clamp(0.0, self.height);
        if due {
            level = if level < self.height / 2.0 { 0.0 } else { self.height };
        }
        self.plan(now, level);
        self.value.go_on(now, self.shown_level(now), self.outputs[0]);
        let shown = self.overflow.map(|place| self.outputs[place]);
        self.overflow_changes = shown
            .is_some_and(|shown| shown != Value::Bool(self.overflows))
            .then(|| now.saturating_add(Span::from_nanos(1)));
    }

    /// The level in the unit of the output.
    fn shown_level(&self, now: Time) -> Course {
        match self.place {
            Place::Full => Course::constant(now, self.full),
            _ => self.level.mapped(0.0, self.scale),
        }
    }

    fn show_overflow(&mut self) {
        self.overflow_changes = None;
        if let Some(place) = self.overflow {
            self.outputs[place] = Value::Bool(self.overflows);
        }
    }

    fn shown(&self) -> usize {
        self.overflow.unwrap_or(self.outputs.len())
    }
}

impl Plant for Tank {
    fn start(&mut self, now: Time) {
        for (flow, planned) in self.flows.iter_mut().zip(&self.planned) {
            (flow.driven, flow.flow) = (NOTHING, *planned);
        }
        self.leak = 0.0;
        self.plan(now, self.initial);
        let (course, shown) = (self.shown_level(now), self.shown());
        self.value.start(now, course, &mut self.outputs[..shown]);
        self.show_overflow();
    }

    fn input(&mut self, now: Time, port: usize, input: &PlantInput) {
        let Some(flow) = self.driven.get(port).and_then(|place| self.flows.get_mut(*place)) else { return };
        let before = std::mem::replace(&mut flow.driven, *input);
        // A further sample of a course that is known changes nothing, but where samples are all that can be taken.
        let sampled =
            self.flows.iter().any(|flow| flow.at_level.is_some()) || self.flowing(now, true).is_none();
        if before != *input && (sampled || before.course.is_none() || before.course != input.course) {
            self.replan(now);
        }
    }

    fn next_event(&self) -> Option<Time> {
        self.turns.into_iter().chain(self.value.next()).chain(self.overflow_changes).min()
    }

    fn advance(&mut self, now: Time) {
        let shown = self.shown();
        self.value.advance(now, &mut self.outputs[..shown]);
        let reached = self.turns.is_some_and(|due| due <= now);
        if reached {
            self.replan(now);
            // The end is reached at this instant, and its switches may be at it.
            self.value.advance(now, &mut self.outputs[..shown]);
        }
        if self.overflow_changes.is_some_and(|due| due <= now) {
            self.show_overflow();
        }
    }

    fn outputs(&self) -> &[Value] {
        &self.outputs
    }

    fn course(&self, output: usize) -> Option<&Course> {
        (output == 0).then_some(self.value.course())
    }

    fn set(&mut self, now: Time, parameter: usize, value: f64) {
        match self.flows.get_mut(parameter) {
            Some(flow) => flow.flow = value,
            None => self.leak = value,
        }
        self.replan(now);
    }
}
