//! A plant that runs a program of the user's, at a period of its own.

use std::sync::Arc;

use document::{Data, Entry, KeySpec, KeyType, suggest};
use signal::{Random, Span, Time, Value};

use super::{PlantKind, PlantReader};
use crate::channel::ChannelId;
use crate::circuit::{
    CircuitFault, ParameterKind, Plant, PlantInput, PlantMachine, PlantParameter, PlantPort, PlantProgram,
    PlantSpec, PlantVariable, PlantVariableKind,
};
use crate::codes;
use crate::measure::Dimension;

const NAMES: KeyType = KeyType::Map(&KeyType::Text);

pub(super) const KIND: PlantKind = PlantKind {
    name: "program",
    keys: &[
        KeySpec::required(
            "program",
            KeyType::OneOrMore(&KeyType::Text),
            "Files of Structured Text with one PROGRAM, relative to the board file",
        ),
        KeySpec::required("period", KeyType::Duration, "Time between two cycles of its program"),
        KeySpec::optional("inputs", NAMES, "VAR_INPUT of its program and the channels that give them"),
        KeySpec::optional("outputs", NAMES, "VAR_OUTPUT of its program and the channels that they drive"),
        KeySpec::optional(
            "parameters",
            KeyType::Map(&KeyType::Either(&[KeyType::Bool, KeyType::Number])),
            "VAR_INPUT of its program that no channel gives, and their values",
        ),
    ],
    read,
};

/// The shortest period: shorter ones are those of circuits, which no controller sees.
const LEAST_PERIOD: Span = Span::from_micros(1);

/// A variable of the program, by its place, and its channel.
#[derive(Clone, Copy, Debug)]
struct Pin {
    variable: usize,
    channel: ChannelId,
    is_level: bool,
}

impl Pin {
    const fn port(self) -> PlantPort {
        if self.is_level { PlantPort::level(self.channel) } else { PlantPort::quantity(self.channel) }
    }

    fn value(self, number: f64) -> Value {
        if self.is_level { Value::Bool(number != 0.0) } else { Value::Real(number) }
    }
}

#[derive(Clone, Debug)]
struct ProgramSpec {
    name: String,
    program: Arc<dyn PlantProgram>,
    period: Span,
    inputs: Vec<Pin>,
    outputs: Vec<Pin>,
    /// Inputs without a channel, with the values that the board file gives them.
    parameters: Vec<(usize, Option<f64>)>,
}

fn read(reader: &mut PlantReader<'_, '_>) -> Option<Arc<dyn PlantSpec>> {
    let period = reader.duration("period");
    if period.is_some_and(|period| period < LEAST_PERIOD) {
        let message = String::from("`period` is below 1 us");
        reader.error("period", codes::PLANT_RANGE, message, "write 1 us or more, as in \"1 ms\"");
        return None;
    }
    let program = reader.program("program")?;
    let variables = program.variables();
    let mut pins = PinReader { variables, taken: vec![false; variables.len()] };
    let inputs = pins.pins(reader, "inputs", true);
    let outputs = pins.pins(reader, "outputs", false);
    let given = pins.values(reader);
    let parameters = variables
        .iter()
        .enumerate()
        .filter(|(place, variable)| {
            variable.is_input
                && variable.kind != PlantVariableKind::Other
                && inputs.iter().all(|pin| pin.variable != *place)
        })
        .map(|(place, _)| (place, given.iter().find(|(known, _)| *known == place).map(|(_, value)| *value)));
    let parameters = parameters.collect();
    let (name, period) = (reader.name(), period?);
    Some(Arc::new(ProgramSpec { name, program: Arc::clone(&program), period, inputs, outputs, parameters }))
}

/// Reads the keys that name variables, each of which may be named once.
struct PinReader<'p> {
    variables: &'p [PlantVariable],
    taken: Vec<bool>,
}

impl PinReader<'_> {
    /// The variable of an entry.
    fn variable(
        &mut self,
        reader: &mut PlantReader<'_, '_>,
        entry: &Entry,
        is_input: bool,
    ) -> Option<(usize, PlantVariableKind)> {
        let word = |is_input| if is_input { "VAR_INPUT" } else { "VAR_OUTPUT" };
        let named = |variable: &PlantVariable| variable.name.eq_ignore_ascii_case(&entry.key);
        let span = entry.key_span.clone();
        let Some(place) = self.variables.iter().position(named) else {
            let names = self.variables.iter().filter(|variable| variable.is_input == is_input);
            let names: Vec<&str> = names.map(|variable| variable.name.as_str()).collect();
            let help = match (suggest(&entry.key, names.iter().copied()), names.as_slice()) {
                (Some(near), _) => format!("did you mean `{near}`?"),
                (None, []) => format!("its PROGRAM has no {}: declare it there", word(is_input)),
                (None, names) => format!("it has {}", names.join(", ")),
            };
            let message = format!("its program has no {} `{}`", word(is_input), entry.key);
            reader.error_at(span, codes::PLANT_VARIABLE, message, &help);
            return None;
        };
        let PlantVariable { name, is_input: known, kind, .. } = &self.variables[place];
        if *known != is_input {
            let message = format!("`{name}` is a {}, not a {}", word(*known), word(is_input));
            let help = if *known { "name it under `inputs`" } else { "name it under `outputs`" };
            reader.error_at(span, codes::PLANT_VARIABLE, message, help);
            return None;
        }
        if std::mem::replace(&mut self.taken[place], true) {
            let message = format!("`{name}` has a channel or a value already");
            reader.error_at(span, codes::PLANT_VARIABLE, message, "keep one of the two");
            return None;
        }
        if *kind == PlantVariableKind::Other {
            let message = format!("no channel or number goes with the type of `{name}`");
            let help = "give it the type BOOL, REAL, LREAL or one of whole numbers";
            reader.error_at(span, codes::PLANT_VARIABLE_TYPE, message, help);
            return None;
        }
        Some((place, *kind))
    }

    /// The variables and channels of a key.
    fn pins(&mut self, reader: &mut PlantReader<'_, '_>, key: &str, is_input: bool) -> Vec<Pin> {
        let mut pins = Vec::new();
        for entry in reader.entries(key) {
            let variable = self.variable(reader, entry, is_input);
            let channel = reader.channel_at(&entry.node);
            let (Some((variable, kind)), Some((channel, unit))) = (variable, channel) else { continue };
            let is_level = kind == PlantVariableKind::Level;
            if is_level != unit.is_none() {
                let (is, needs) = if is_level { ("a BOOL", "a digital") } else { ("a number", "an analog") };
                let message = format!("`{}` is {is} and needs {needs} channel", entry.key);
                let help = "name another channel, or give the variable another type";
                reader.error_at(entry.node.span.clone(), codes::PLANT_VARIABLE_TYPE, message, help);
                continue;
            }
            pins.push(Pin { variable, channel, is_level });
        }
        pins
    }

    /// The variables of `parameters` and their values.
    fn values(&mut self, reader: &mut PlantReader<'_, '_>) -> Vec<(usize, f64)> {
        let mut values = Vec::new();
        for entry in reader.entries("parameters") {
            let Some((variable, kind)) = self.variable(reader, entry, true) else { continue };
            let span = entry.node.span.clone();
            let number = match &entry.node.data {
                Data::Integer(number) => Some(*number as f64),
                Data::Float(text) => text.parse().ok(),
                _ => None,
            };
            match (kind, &entry.node.data, number) {
                (PlantVariableKind::Level, Data::Bool(on), _) => values.push((variable, f64::from(*on))),
                (PlantVariableKind::Number { least, most }, _, Some(number)) => {
                    if (least..=most).contains(&number) {
                        values.push((variable, number));
                    } else {
                        let message = format!("`{}` is out of the range of its type", entry.key);
                        let help = format!("write {least} to {most}");
                        reader.error_at(span, codes::PLANT_RANGE, message, &help);
                    }
                }
                (kind, ..) => {
                    let is_level = kind == PlantVariableKind::Level;
                    let (is, help) = match is_level {
                        true => ("a BOOL", "write true or false"),
                        false => ("a number", "write a number without quotes"),
                    };
                    let message = format!("`{}` is {is}", entry.key);
                    reader.error_at(span, codes::PLANT_VARIABLE_TYPE, message, help);
                }
            }
        }
        values
    }
}

impl PlantSpec for ProgramSpec {
    fn name(&self) -> &str {
        &self.name
    }

    fn inputs(&self) -> Vec<PlantPort> {
        self.inputs.iter().map(|pin| pin.port()).collect()
    }

    fn outputs(&self) -> Vec<PlantPort> {
        self.outputs.iter().map(|pin| pin.port()).collect()
    }

    fn check(&self) -> Vec<(Option<usize>, CircuitFault)> {
        Vec::new()
    }

    fn parameters(&self) -> Vec<PlantParameter> {
        let parameter = |(place, given): &(usize, Option<f64>)| {
            let PlantVariable { name, kind, initial, .. } = &self.program.variables()[*place];
            let takes = match *kind {
                PlantVariableKind::Number { least, most } => {
                    ParameterKind::Measure { dimension: Dimension::Plain, least, most }
                }
                PlantVariableKind::Level | PlantVariableKind::Other => ParameterKind::Flag,
            };
            PlantParameter { name: name.clone(), takes, initial: given.unwrap_or(*initial) }
        };
        self.parameters.iter().map(parameter).collect()
    }

    fn build(&self, _random: Random) -> Box<dyn Plant> {
        let outputs = self.outputs.iter().map(|pin| pin.value(0.0)).collect();
        Box::new(ProgramPlant {
            machine: self.program.machine(),
            period: self.period,
            pins: self.inputs.clone(),
            inputs: vec![UNDRIVEN; self.inputs.len()],
            late: vec![None; self.inputs.len()],
            late_parameters: vec![None; self.parameters.len()],
            results: self.outputs.clone(),
            parameters: self.parameters.clone(),
            outputs,
            next: None,
            fault: None,
        })
    }
}

const UNDRIVEN: PlantInput = PlantInput { value: Value::HighZ, course: None };

/// The program at work. A cycle sees the inputs as they stand up to its instant; the outputs come at it.
#[derive(Debug)]
struct ProgramPlant {
    machine: Box<dyn PlantMachine>,
    period: Span,
    pins: Vec<Pin>,
    inputs: Vec<PlantInput>,
    /// What came at the very instant of a cycle that is still due: it counts after that, however calls are ordered.
    late: Vec<Option<PlantInput>>,
    late_parameters: Vec<Option<f64>>,
    results: Vec<Pin>,
    parameters: Vec<(usize, Option<f64>)>,
    outputs: Vec<Value>,
    next: Option<Time>,
    fault: Option<String>,
}

impl ProgramPlant {
    fn is_due(&self, now: Time) -> bool {
        self.next.is_some_and(|due| due <= now)
    }

    /// One cycle at its instant.
    fn cycle(&mut self, at: Time) {
        for (pin, input) in self.pins.iter().zip(&self.inputs) {
            // A line that nobody drives carries nothing.
            let value = match (input.course, input.value) {
                (Some(course), _) => course.value(at),
                (None, Value::Bool(on)) => f64::from(on),
                (None, value) => value.as_real().unwrap_or(0.0),
            };
            if value.is_finite() {
                self.machine.set(pin.variable, value);
            }
        }
        match self.machine.cycle(at) {
            Ok(()) => self.show(),
            Err(why) => self.fault = Some(why),
        }
        for (input, late) in self.inputs.iter_mut().zip(&mut self.late) {
            if let Some(late) = late.take() {
                *input = late;
            }
        }
        for ((variable, _), late) in self.parameters.iter().zip(&mut self.late_parameters) {
            if let Some(value) = late.take() {
                self.machine.set(*variable, value);
            }
        }
    }

    fn show(&mut self) {
        for (pin, output) in self.results.iter().zip(&mut self.outputs) {
            *output = pin.value(self.machine.get(pin.variable));
        }
    }

    fn after(&self, at: Time) -> Option<Time> {
        at.as_nanos().checked_add(self.period.as_nanos()).map(Time::from_nanos)
    }
}

impl Plant for ProgramPlant {
    fn start(&mut self, now: Time) {
        self.machine.reset();
        for (variable, given) in &self.parameters {
            if let Some(value) = given {
                self.machine.set(*variable, *value);
            }
        }
        self.inputs.fill(UNDRIVEN);
        self.late.fill(None);
        self.late_parameters.fill(None);
        self.fault = None;
        self.show();
        self.next = self.after(now);
    }

    fn input(&mut self, now: Time, port: usize, input: &PlantInput) {
        if self.is_due(now) {
            self.late[port] = Some(*input);
        } else {
            self.inputs[port] = *input;
        }
    }

    fn next_event(&self) -> Option<Time> {
        self.next
    }

    fn advance(&mut self, now: Time) {
        while let Some(due) = self.next.filter(|due| *due <= now) {
            self.cycle(due);
            self.next = if self.fault.is_some() { None } else { self.after(due) };
        }
    }

    fn outputs(&self) -> &[Value] {
        &self.outputs
    }

    fn set(&mut self, now: Time, parameter: usize, value: f64) {
        let Some((variable, _)) = self.parameters.get(parameter) else { return };
        if self.is_due(now) {
            self.late_parameters[parameter] = Some(value);
        } else {
            self.machine.set(*variable, value);
        }
    }

    fn fault(&self) -> Option<&str> {
        self.fault.as_deref()
    }
}
