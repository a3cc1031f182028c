//! Dead time: a quantity arrives later than it was.

use std::collections::VecDeque;
use std::sync::Arc;

use document::{KeySpec, KeyType};
use signal::{Random, Span, Time, Value};

use super::{PlantKind, PlantReader, reader};
use crate::channel::ChannelId;
use crate::circuit::{CircuitFault, Plant, PlantInput, PlantPort, PlantSpec};
use crate::codes;
use crate::course::Course;

pub(super) const KIND: PlantKind = PlantKind {
    name: "dead-time",
    keys: &[
        reader::INPUT,
        reader::OUTPUT,
        KeySpec::required("delay", KeyType::Duration, "How much later the output is what the input was"),
        reader::INITIAL,
    ],
    read,
};

#[derive(Clone, Debug)]
struct DeadTimeSpec {
    name: String,
    input: ChannelId,
    output: ChannelId,
    delay: Span,
    initial: f64,
}

fn read(reader: &mut PlantReader<'_, '_>) -> Option<Arc<dyn PlantSpec>> {
    let (input, output) = (reader.quantity("input"), reader.quantity("output"));
    let ((input, of), (output, unit)) = (input?, output?);
    if of != unit {
        let message = format!("the input is in `{of}`, the output in `{unit}`");
        reader.error("output", codes::PLANT_UNIT, message, "give both channels the same unit");
        return None;
    }
    let delay = reader.duration("delay");
    let initial = if reader.has("initial") { reader.number("initial", &unit) } else { Some(0.0) };
    Some(Arc::new(DeadTimeSpec { name: reader.name(), input, output, delay: delay?, initial: initial? }))
}

impl PlantSpec for DeadTimeSpec {
    fn name(&self) -> &str {
        &self.name
    }

    fn inputs(&self) -> Vec<PlantPort> {
        vec![PlantPort::quantity(self.input)]
    }

    fn outputs(&self) -> Vec<PlantPort> {
        vec![PlantPort::quantity(self.output)]
    }

    fn check(&self) -> Vec<(Option<usize>, CircuitFault)> {
        Vec::new()
    }

    fn build(&self, _random: Random) -> Box<dyn Plant> {
        Box::new(DeadTime {
            delay: self.delay,
            initial: self.initial,
            waiting: VecDeque::new(),
            course: None,
            outputs: [Value::Real(self.initial)],
        })
    }
}

/// What is on its way, and what arrived last.
#[derive(Debug)]
struct DeadTime {
    delay: Span,
    initial: f64,
    waiting: VecDeque<(Time, PlantInput)>,
    course: Option<Course>,
    outputs: [Value; 1],
}

impl Plant for DeadTime {
    fn start(&mut self, _now: Time) {
        self.waiting.clear();
        self.course = None;
        self.outputs = [Value::Real(self.initial)];
    }

    fn input(&mut self, now: Time, _port: usize, input: &PlantInput) {
        let newest =
            self.waiting.back().map_or((self.outputs[0], self.course), |(_, one)| (one.value, one.course));
        let course = input.course.map(|course| course.delayed(self.delay));
        if newest != (input.value, course) {
            let at = now.saturating_add(self.delay);
            self.waiting.push_back((at, PlantInput { value: input.value, course }));
        }
    }

    fn next_event(&self) -> Option<Time> {
        self.waiting.front().map(|(due, _)| *due)
    }

    fn advance(&mut self, now: Time) {
        while let Some((_, input)) = self.waiting.front().copied().filter(|(due, _)| *due <= now) {
            self.waiting.pop_front();
            // A line that nobody drives carries nothing.
            self.outputs = [if input.value == Value::HighZ { Value::Real(0.0) } else { input.value }];
            self.course = input.course;
        }
    }

    fn outputs(&self) -> &[Value] {
        &self.outputs
    }

    fn course(&self, _output: usize) -> Option<&Course> {
        self.course.as_ref()
    }

    fn waiting(&self) -> usize {
        self.waiting.len()
    }
}
