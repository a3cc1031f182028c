//! What a plant is to a circuit and its board, whatever its kind.

use std::fmt;

use signal::{Random, Time, Value};

use super::CircuitFault;
use crate::channel::ChannelId;
use crate::course::Course;
use crate::measure::Dimension;

/// What a terminal of a plant goes with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlantPortKind {
    /// A digital channel.
    Level,
    /// An analog channel.
    Quantity,
    /// A digital or an analog channel.
    Either,
}

/// A terminal of a plant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PlantPort {
    /// The channel that it is at.
    pub channel: ChannelId,
    /// What it goes with.
    pub kind: PlantPortKind,
    /// The switch of the plant that it belongs to, by its place.
    pub switch: Option<usize>,
}

impl PlantPort {
    /// At a digital channel.
    pub const fn level(channel: ChannelId) -> PlantPort {
        PlantPort { channel, kind: PlantPortKind::Level, switch: None }
    }

    /// At an analog channel.
    pub const fn quantity(channel: ChannelId) -> PlantPort {
        PlantPort { channel, kind: PlantPortKind::Quantity, switch: None }
    }

    /// At a channel of either kind.
    pub const fn either(channel: ChannelId) -> PlantPort {
        PlantPort { channel, kind: PlantPortKind::Either, switch: None }
    }

    /// Of a switch, at a digital channel.
    pub const fn of_switch(channel: ChannelId, switch: usize) -> PlantPort {
        PlantPort { channel, kind: PlantPortKind::Level, switch: Some(switch) }
    }
}

/// What a parameter of a plant takes.
#[derive(Clone, Debug, PartialEq)]
pub enum ParameterKind {
    /// TRUE or FALSE, 1 or 0.
    Flag,
    /// A number of what it measures, within these limits.
    Measure {
        /// What it measures.
        dimension: Dimension,
        /// The least.
        least: f64,
        /// The most.
        most: f64,
    },
}

/// What a plan can set of a plant while it is at work.
#[derive(Clone, Debug, PartialEq)]
pub struct PlantParameter {
    /// Its name.
    pub name: String,
    /// What it takes.
    pub takes: ParameterKind,
    /// What it is at the start.
    pub initial: f64,
}

/// The description of a plant that was checked when it was read.
pub trait PlantSpec: Send + Sync + fmt::Debug {
    /// Its name.
    fn name(&self) -> &str;

    /// What acts on it, in the order that its [`Plant::input`] counts.
    fn inputs(&self) -> Vec<PlantPort>;

    /// What it acts on, in the order of its [`Plant::outputs`].
    fn outputs(&self) -> Vec<PlantPort>;

    /// Whether a change of an input is at an output at the same instant. Such plants cannot form a ring.
    fn passes_at_once(&self) -> bool {
        false
    }

    /// What is wrong with it; with the place of one of its switches where it is about that.
    fn check(&self) -> Vec<(Option<usize>, CircuitFault)>;

    /// What a plan can set of it, in the order that its [`Plant::set`] counts.
    fn parameters(&self) -> Vec<PlantParameter> {
        Vec::new()
    }

    /// The plant, not started; `random` is where its noise comes from.
    fn build(&self, random: Random) -> Box<dyn Plant>;
}

/// What is at an input of a plant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlantInput {
    /// What is on the line.
    pub value: Value,
    /// How the line goes on, where a plant gives it its value and nothing lies between: the value on the line is the newest
    /// sample of it.
    pub course: Option<Course>,
}

/// A model of a process in closed form between two changes of its inputs: it never ticks, but for one whose law is a program of
/// the user's.
///
/// Times never go backwards. Inputs and outputs are counted from 0 in the order of the plant's own description.
pub trait Plant: Send + fmt::Debug {
    /// Back to the initial state, with every input undriven.
    fn start(&mut self, now: Time);

    /// From `now` on an input has this value. What was due at `now` stays due; what the input brings about comes
    /// later than `now`, but for what [`PlantSpec::passes_at_once`].
    fn input(&mut self, now: Time, port: usize, input: &PlantInput);

    /// When an output will next change if no input does; after a call of [`Plant::advance`] later than its `now`.
    fn next_event(&self) -> Option<Time>;

    /// Brings the outputs to what they are at `now`.
    fn advance(&mut self, now: Time);

    /// The outputs as of the last start or advance.
    fn outputs(&self) -> &[Value];

    /// Sets a parameter from `now` on. What was due at `now` stays due.
    fn set(&mut self, _now: Time, _parameter: usize, _value: f64) {}

    /// How many changes are on their way through it.
    fn waiting(&self) -> usize {
        0
    }

    /// Why it does nothing any more: its law cannot go on. Its outputs stay.
    fn fault(&self) -> Option<&str> {
        None
    }

    /// How an analog output goes on, if that is known in closed form and nothing else is on it.
    fn course(&self, _output: usize) -> Option<&Course> {
        None
    }
}
