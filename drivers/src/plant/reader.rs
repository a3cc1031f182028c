//! What the readers of plants share: keys of a table as channels, numbers and durations, with what is wrong reported.

use std::ops::Range;
use std::sync::Arc;

use document::{Data, Entry, Fields, Findings, KeySpec, KeyType, Node};
use signal::{Quantity, QuantityRange, Span, Unit};

use crate::channel::{ChannelId, ChannelKind};
use crate::circuit::{ChannelSpec, PlantProgram, PlantProgramError, PlantPrograms};
use crate::measure::Dimension;
use crate::{codes, number};

pub(super) const INPUT: KeySpec = KeySpec::required("input", KeyType::Text, "The channel that drives it");
pub(super) const OUTPUT: KeySpec =
    KeySpec::required("output", KeyType::Text, "The analog channel that carries its value");
pub(super) const INITIAL: KeySpec = KeySpec::optional(
    "initial",
    KeyType::Quantity,
    "Value at the start; where it is without any input if left out",
);
/// The output of a kind that may do without.
pub(super) const VALUE: KeySpec = KeySpec { required: false, ..OUTPUT };
/// The samples of such an output.
pub(super) const SAMPLE_OF_VALUE: KeySpec = KeySpec { required: false, ..SAMPLE };
pub(super) const SAMPLE: KeySpec =
    KeySpec::required("sample", KeyType::Duration, "Time between two samples of the output");

/// The channels of a board that is read.
pub(crate) trait ChannelNames {
    /// The channel that a text names; reports one that is not there.
    fn channel(&self, node: &Node, out: &mut Findings) -> Option<ChannelId>;
    /// What it is.
    fn spec(&self, channel: ChannelId) -> &ChannelSpec;
    /// Where the programs of its plants come from; `None` for a file that is read without what stands beside it.
    fn programs(&self) -> Option<&dyn PlantPrograms>;
}

/// The table of a plant, or one within it. Its methods report what is wrong with a value, and nothing where a key is left out.
pub(crate) struct PlantReader<'a, 'n> {
    fields: Fields<'n>,
    node: &'n Node,
    names: &'a dyn ChannelNames,
    out: &'a mut Findings,
}

impl<'a, 'n> PlantReader<'a, 'n> {
    pub(super) fn new(
        fields: Fields<'n>,
        node: &'n Node,
        names: &'a dyn ChannelNames,
        out: &'a mut Findings,
    ) -> Self {
        PlantReader { fields, node, names, out }
    }

    pub(super) fn name(&self) -> String {
        self.fields.text("name").unwrap_or_default().to_owned()
    }

    pub(super) fn has(&self, key: &str) -> bool {
        self.fields.has(key)
    }

    pub(super) fn text(&self, key: &str) -> Option<&'n str> {
        self.fields.text(key)
    }

    pub(super) fn integer(&self, key: &str) -> Option<i64> {
        self.fields.integer(key)
    }

    /// Reports at a key, or at the table where it is left out.
    pub(super) fn error(&mut self, key: &str, code: &'static str, message: String, help: &str) {
        let entry = self.fields.table().entry(key);
        let span = entry.map_or_else(|| self.node.span.clone(), |entry| entry.node.span.clone());
        self.out.error(code, span, message, help);
    }

    /// Reports at a place.
    pub(super) fn error_at(&mut self, span: Range<usize>, code: &'static str, message: String, help: &str) {
        self.out.error(code, span, message, help);
    }

    /// Reports at the name of a key that is there.
    pub(super) fn error_of_key(&mut self, key: &str, code: &'static str, message: String, help: &str) {
        if let Some(entry) = self.fields.table().entry(key) {
            self.out.error(code, entry.key_span.clone(), message, help);
        }
    }

    /// The entries of a table with free keys.
    pub(super) fn entries(&self, key: &str) -> &'n [Entry] {
        self.fields.get(key).and_then(Node::as_table).map_or(&[], |table| &table.entries)
    }

    /// The program of the files of a key.
    pub(super) fn program(&mut self, key: &str) -> Option<Arc<dyn PlantProgram>> {
        let files: Vec<&str> = self.fields.each(key).iter().filter_map(Node::as_text).collect();
        let loaded = match self.names.programs() {
            Some(programs) => programs.load(&files),
            None => Err(PlantProgramError::Unsuited(
                String::from("the files beside this board file are not read here"),
                String::from("read it from where its programs are"),
            )),
        };
        match loaded {
            Ok(program) => return Some(program),
            Err(PlantProgramError::Unsuited(message, help)) => {
                self.error(key, codes::PLANT_PROGRAM, message, &help);
            }
            Err(PlantProgramError::Findings(found)) => {
                let entry = self.fields.table().entry(key);
                let span = entry.map_or_else(|| self.node.span.clone(), |entry| entry.node.span.clone());
                let file = self.out.file().to_owned();
                for one in found {
                    let is_placed = !one.labels.is_empty();
                    self.out.push(if is_placed { one } else { one.at(file.clone(), span.clone(), "") });
                }
            }
        }
        None
    }

    /// The channel of a key, with its unit; `None` for the unit of a digital one.
    pub(super) fn channel(&mut self, key: &str) -> Option<(ChannelId, Option<String>)> {
        self.channel_at(self.fields.get(key)?)
    }

    /// The channel that a value names, in the same way.
    pub(super) fn channel_at(&mut self, node: &Node) -> Option<(ChannelId, Option<String>)> {
        let id = self.names.channel(node, self.out)?;
        match &self.names.spec(id).kind {
            ChannelKind::Digital => Some((id, None)),
            ChannelKind::Analog { unit } => Some((id, Some(unit.clone()))),
            ChannelKind::Count => {
                let message = String::from("a plant has nothing to do with a count");
                let help = "name a digital or an analog channel";
                self.out.error(codes::PLANT_CHANNEL, node.span.clone(), message, help);
                None
            }
        }
    }

    /// The digital channel of a key.
    pub(super) fn level(&mut self, key: &str) -> Option<ChannelId> {
        let (id, unit) = self.channel(key)?;
        if unit.is_some() {
            let message = format!("`{key}` needs a digital channel");
            let help = "name a terminal or a digital channel of `channels` here";
            self.error(key, codes::PLANT_CHANNEL, message, help);
            return None;
        }
        Some(id)
    }

    /// The analog channel of a key, with its unit.
    pub(super) fn quantity(&mut self, key: &str) -> Option<(ChannelId, String)> {
        let (id, unit) = self.channel(key)?;
        if unit.is_none() {
            let message = format!("`{key}` needs an analog channel");
            let help = "describe an analog channel under `channels` and name it here";
            self.error(key, codes::PLANT_CHANNEL, message, help);
        }
        unit.map(|unit| (id, unit))
    }

    /// The number of a key in the unit of its channel.
    pub(super) fn number(&mut self, key: &str, unit: &str) -> Option<f64> {
        number::quantity(self.fields.get(key)?, unit, self.out)
    }

    /// The number of a key by what it measures, which has to lie within these limits.
    pub(super) fn measure(&mut self, key: &str, dimension: &Dimension, least: f64, most: f64) -> Option<f64> {
        let node = self.fields.get(key)?;
        let read = match &node.data {
            Data::Integer(number) => Quantity::parse(&number.to_string()).ok(),
            Data::Float(text) | Data::Text(text) => Quantity::parse(text).ok(),
            _ => None,
        };
        let Some(read) = read else {
            let help = format!("write {}", dimension.example());
            self.out.bad(codes::UNREADABLE, node, "this does not read as a finite number", help);
            return None;
        };
        let Some(number) = dimension.number(&read) else {
            let message = format!("`{key}` cannot be {read}");
            self.error(key, codes::PLANT_UNIT, message, &format!("write {}", dimension.example()));
            return None;
        };
        if !(least..=most).contains(&number) {
            let message = format!("`{key}` is out of its range: {read}");
            let help = format!("write {}", dimension.limits(least, most));
            self.error(key, codes::PLANT_RANGE, message, &help);
            return None;
        }
        Some(number)
    }

    /// How many entries a list has.
    pub(super) fn count(&self, key: &str) -> usize {
        self.fields.each(key).len()
    }

    /// The time between two samples of an output that there may be: needed where there is one, refused where there is none.
    pub(super) fn sample_of_value(&mut self, output: bool) -> Option<Span> {
        match (output, self.has("sample")) {
            (true, true) => self.duration("sample"),
            (false, false) => Some(Span::from_millis(1)),
            (true, false) => {
                let message = String::from("an output needs `sample`");
                self.error("output", codes::PLANT_SAMPLE, message, "add `sample`, as in sample = \"10 ms\"");
                None
            }
            (false, true) => {
                let message = String::from("there is no output to sample");
                self.error_of_key("sample", codes::PLANT_SAMPLE, message, "remove it, or add `output`");
                None
            }
        }
    }

    /// A duration, 0 included.
    pub(super) fn any_duration(&self, key: &str) -> Option<Span> {
        self.fields.duration(key)
    }

    /// A duration above 0.
    pub(super) fn duration(&mut self, key: &str) -> Option<Span> {
        let span = self.fields.duration(key)?;
        if span <= Span::ZERO {
            let message = format!("`{key}` is not above 0");
            self.error(key, codes::TIME, message, "write a duration above 0");
            return None;
        }
        Some(span)
    }

    /// Both ends of a range in the unit of its channel.
    pub(super) fn range(&mut self, key: &str, unit: &str) -> Option<(f64, f64)> {
        let text = match &self.fields.get(key)?.data {
            Data::Text(text) => text,
            _ => "",
        };
        let read = QuantityRange::parse(text);
        let ends = read.as_ref().ok().and_then(|range| range.min.clone().zip(range.max.clone()));
        let Some((min, max)) = ends.filter(|(min, max)| min != max) else {
            let message = match read {
                Err(why) => format!("`{key}` does not read as a range: {why}"),
                Ok(_) => format!("`{key}` does not read as a range from one number to another"),
            };
            let help = "write both ends, the lower one first, as in \"4 .. 20 mA\"";
            self.error(key, codes::UNREADABLE, message, help);
            return None;
        };
        let number = |end: &Quantity| match end.unit.is_none() {
            true => Some(end.number),
            false => end.in_unit(&Unit::new(unit)),
        };
        let numbers = number(&min).zip(number(&max));
        if numbers.is_none() {
            let message = format!("`{key}` is in {}", max.unit);
            let help = format!("its channel is in {unit}: write how much it is in {unit}");
            self.error(
                key,
                codes::UNIT,
                message,
                if unit.is_empty() { "its channel has no unit" } else { &help },
            );
        }
        numbers.map(|(min, max)| (min.as_f64(), max.as_f64()))
    }

    /// The entries of a list of tables with these keys. `None` where one of them is wrong.
    pub(super) fn each<T>(
        &mut self,
        key: &str,
        keys: &'static [KeySpec],
        mut read: impl FnMut(&mut PlantReader<'_, '_>) -> Option<T>,
    ) -> Option<Vec<T>> {
        let mut list = Some(Vec::new());
        for node in self.fields.each(key) {
            let Some(table) = node.as_table() else { continue };
            let fields = Fields::checked(table, keys);
            let one = read(&mut PlantReader { fields, node, names: self.names, out: &mut *self.out });
            match (one, &mut list) {
                (Some(one), Some(list)) => list.push(one),
                _ => list = None,
            }
        }
        list
    }
}
