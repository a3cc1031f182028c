//! What a simulated board is made of, as data, and what is refused before it is built.

mod bus;
mod order;
mod plant;
mod program;
mod tally;

use std::fmt;
use std::sync::Arc;

use signal::{Address, Area, Size, Span, Value};
use thiserror::Error;

use crate::channel::{ChannelId, ChannelKind};

pub use bus::{BusSpec, BusSpecKind, CanRates, SerialEnd, SerialMedium};
pub use plant::{ParameterKind, Plant, PlantInput, PlantParameter, PlantPort, PlantPortKind, PlantSpec};
pub use program::{
    PlantFault, PlantMachine, PlantProgram, PlantProgramError, PlantPrograms, PlantVariable,
    PlantVariableKind,
};
pub use tally::TallySpec;

/// What an undriven digital line reads.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Pull {
    /// High impedance, reported as such: a controller's output terminal.
    None,
    /// 1.
    Up,
    /// 0, as every 24 V input.
    #[default]
    Down,
}

/// One channel of a simulated board.
#[derive(Clone, Debug, PartialEq)]
pub struct ChannelSpec {
    /// Its name, unique on the board.
    pub name: String,
    /// What it carries.
    pub kind: ChannelKind,
    /// Whether writes may drive it.
    pub drives: bool,
    /// Whether polls report it.
    pub senses: bool,
    /// What it is driven to at the start and by the safe state; [`Value::HighZ`] for not at all.
    pub safe: Value,
    /// What it reads while nobody drives it. An analog channel reads 0 but with [`Pull::None`].
    pub pull: Pull,
}

impl ChannelSpec {
    /// The channel that a simulated board has for a terminal that its file says nothing of: digital for a bit, with a pull
    /// for an input, and analog for more.
    pub(crate) fn default_of(name: String, address: Address) -> ChannelSpec {
        match address.size() {
            Size::Bit => ChannelSpec::digital_at(name, address),
            _ => ChannelSpec::analog(name, ""),
        }
    }

    /// The digital channel of a terminal that the file says nothing of, with a pull for an input.
    pub(crate) fn digital_at(name: String, address: Address) -> ChannelSpec {
        let pull = if address.area() == Area::Input { Pull::Down } else { Pull::None };
        ChannelSpec::digital(name, pull)
    }

    /// A digital channel that is driven and sensed, let go when safe.
    pub fn digital(name: impl Into<String>, pull: Pull) -> Self {
        let kind = ChannelKind::Digital;
        ChannelSpec { name: name.into(), kind, drives: true, senses: true, safe: Value::HighZ, pull }
    }

    /// An analog channel that is driven and sensed, let go when safe.
    pub fn analog(name: impl Into<String>, unit: impl Into<String>) -> Self {
        let kind = ChannelKind::Analog { unit: unit.into() };
        ChannelSpec {
            name: name.into(),
            kind,
            drives: true,
            senses: true,
            safe: Value::HighZ,
            pull: Pull::Down,
        }
    }
}

impl ChannelSpec {
    /// How far a counter has counted: nothing drives it.
    pub fn count(name: impl Into<String>) -> Self {
        let kind = ChannelKind::Count;
        let safe = Value::HighZ;
        ChannelSpec { name: name.into(), kind, drives: false, senses: true, safe, pull: Pull::None }
    }
}

/// How the further edges of a bouncing contact lie in their time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Spacing {
    /// Drawn again from the board's seed at every change.
    #[default]
    Random,
    /// At equal distances, the last at the end of the time.
    Even,
}

/// Contact bounce: further edges after every change of a wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Bounce {
    /// Further edges: even, so that the line ends where it belongs; at most [`MAX_BOUNCE_EDGES`].
    pub edges: u16,
    /// Time from the change within which they all come, at least one nanosecond for each.
    pub over: Span,
    /// How they lie in it.
    pub spacing: Spacing,
}

/// The most further edges of one bounce.
pub const MAX_BOUNCE_EDGES: u16 = 1_000;

/// A wire that carries the level or value of one channel to another.
///
/// An undriven source does not drive the wire's end either, but for an inverting wire: like the break contact of
/// a relay it drives 1 then.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WireSpec {
    /// The channel that it listens to.
    pub from: ChannelId,
    /// The channel that it drives.
    pub to: ChannelId,
    /// Transport delay, 0 or more: every change arrives that much later, however short the pulse.
    pub delay: Span,
    /// The delay, 0 or more, of changes of its end to anything but 1, where that is another one; `delay` is that of changes
    /// to 1 then. A change that arrives before an earlier one takes its place: a pulse that is too short for the difference does
    /// not come through. Digital only.
    pub off_delay: Option<Span>,
    /// Whether it drives the opposite level. Digital only.
    pub invert: bool,
    /// Contact bounce, of digital wires only. A new change ends a bounce that still goes on.
    pub bounce: Option<Bounce>,
}

impl WireSpec {
    /// How much later its end changes to a value.
    pub(crate) fn delay_to(&self, value: Value) -> Span {
        self.off_delay.filter(|_| value != Value::Bool(true)).unwrap_or(self.delay)
    }

    /// Whether a change may arrive at once.
    pub(crate) fn may_be_immediate(&self) -> bool {
        self.delay == Span::ZERO || self.off_delay == Some(Span::ZERO)
    }
}

/// A simulated board as data.
#[derive(Clone, Debug, Default)]
pub struct Circuit {
    /// Its channels; a [`ChannelId`] is a place in here.
    pub channels: Vec<ChannelSpec>,
    /// Its wires.
    pub wires: Vec<WireSpec>,
    /// Its plants.
    pub plants: Vec<Arc<dyn PlantSpec>>,
    /// What is counted of its lines; each on a channel of kind [`ChannelKind::Count`].
    pub tallies: Vec<TallySpec>,
    /// Its buses, which nothing else of it reaches.
    pub buses: Vec<BusSpec>,
}

/// Which part of a circuit is meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CircuitPart {
    /// The channel of this place.
    Channel(usize),
    /// The wire of this place.
    Wire(usize),
    /// The plant of this place.
    Plant(usize),
    /// A switch of a plant.
    Switch {
        /// Place of the plant.
        plant: usize,
        /// Place of the switch in the plant.
        switch: usize,
    },
}

impl fmt::Display for CircuitPart {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            CircuitPart::Channel(n) => write!(f, "channel {n}"),
            CircuitPart::Wire(n) => write!(f, "wire {n}"),
            CircuitPart::Plant(n) => write!(f, "plant {n}"),
            CircuitPart::Switch { plant, switch } => write!(f, "plant {plant}, switch {switch}"),
        }
    }
}

/// What is wrong with a part of a circuit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum CircuitFault {
    /// More channels, wires or plants than [`MAX_PARTS`].
    #[error("more than {} channels, wires or plants", MAX_PARTS)]
    TooMany,
    /// A channel before it has the same name.
    #[error("a channel before it has the same name")]
    DuplicateName {
        /// Place of the first.
        first: usize,
    },
    /// The safe value does not fit the kind of channel.
    #[error("the safe value does not fit the kind of channel")]
    BadSafeValue,
    /// It names a channel that the circuit does not have.
    #[error("no such channel")]
    NoChannel(ChannelId),
    /// It would have to be a digital channel.
    #[error("a digital channel is needed here")]
    NotDigital(ChannelId),
    /// It would have to be an analog channel.
    #[error("an analog channel is needed here")]
    NotAnalog(ChannelId),
    /// It would have to be a count.
    #[error("a count is needed here")]
    NotCount(ChannelId),
    /// A wire from a digital to an analog channel or the reverse.
    #[error("a wire joins channels of different kinds, or a count")]
    KindsDiffer,
    /// A wire between analog channels with inversion or bounce.
    #[error("an analog wire has one delay, and can neither invert nor bounce")]
    NotForAnalog,
    /// An analog channel that more than one wire or plant drives.
    #[error("an analog channel is driven from two sides")]
    TwoSources(ChannelId),
    /// A delay below 0, or a time constant or sample time that is not above 0.
    #[error("a delay is below 0, or another time is not above 0")]
    BadTime,
    /// A bounce of an odd number of edges, of none or of too many.
    #[error("the edges of a bounce must be an even number from 2 to {}", MAX_BOUNCE_EDGES)]
    BounceEdges,
    /// A bounce with less than a nanosecond for each edge.
    #[error("a bounce needs at least a nanosecond for each edge")]
    BounceTime,
    /// A wire or plant that closes a ring of what has no delay: the value of such a ring is not defined.
    #[error("it closes a ring of wires without delay, or of plants that pass on a change at once")]
    Loop,
    /// A number that is infinite or no number.
    #[error("a number is infinite or no number")]
    NotFinite,
    /// A switch that would go off where it goes on, or above.
    #[error("a switch must go off below where it goes on")]
    NoHysteresis,
}

/// A circuit that cannot be built.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("{part}: {fault}")]
pub struct CircuitError {
    /// Where.
    pub part: CircuitPart,
    /// What.
    #[source]
    pub fault: CircuitFault,
}

/// The most channels, and the most wires, and the most plants of a circuit.
pub const MAX_PARTS: usize = 4_096;

impl Circuit {
    /// Everything that is wrong with the circuit, in the order of its parts; empty for a good one.
    pub fn check(&self) -> Vec<CircuitError> {
        let mut errors = Vec::new();
        if self.channels.len().max(self.wires.len()).max(self.plants.len()) > MAX_PARTS {
            return vec![CircuitError { part: CircuitPart::Channel(0), fault: CircuitFault::TooMany }];
        }
        self.check_channels(&mut errors);
        for (place, wire) in self.wires.iter().enumerate() {
            if let Err(fault) = self.check_wire(wire) {
                errors.push(CircuitError { part: CircuitPart::Wire(place), fault });
            }
        }
        for (place, plant) in self.plants.iter().enumerate() {
            self.check_plant(place, plant.as_ref(), &mut errors);
        }
        for tally in &self.tallies {
            if let Err(fault) = self.check_tally(tally) {
                errors.push(CircuitError { part: CircuitPart::Channel(usize::from(tally.channel.0)), fault });
            }
        }
        if errors.is_empty() {
            self.check_sources(&mut errors);
            if let Err(part) = self.order() {
                errors.push(CircuitError { part, fault: CircuitFault::Loop });
            }
        }
        errors
    }

    fn check_channels(&self, errors: &mut Vec<CircuitError>) {
        let mut names: Vec<(&str, usize)> =
            self.channels.iter().enumerate().map(|(place, channel)| (channel.name.as_str(), place)).collect();
        names.sort_unstable();
        let mut twins: Vec<(usize, usize)> = Vec::new();
        for pair in names.windows(2) {
            if pair[0].0 == pair[1].0 {
                twins.push((pair[1].1, pair[0].1));
            }
        }
        twins.sort_unstable();
        for (place, first) in twins {
            let fault = CircuitFault::DuplicateName { first };
            errors.push(CircuitError { part: CircuitPart::Channel(place), fault });
        }
        for (place, channel) in self.channels.iter().enumerate() {
            if fit(&channel.kind, channel.safe).is_none() {
                errors.push(CircuitError {
                    part: CircuitPart::Channel(place),
                    fault: CircuitFault::BadSafeValue,
                });
            }
        }
    }

    fn channel(&self, id: ChannelId) -> Result<&ChannelSpec, CircuitFault> {
        self.channels.get(usize::from(id.0)).ok_or(CircuitFault::NoChannel(id))
    }

    fn digital(&self, id: ChannelId) -> Result<bool, CircuitFault> {
        Ok(self.channel(id)?.kind == ChannelKind::Digital)
    }

    fn counts(&self, id: ChannelId) -> Result<bool, CircuitFault> {
        Ok(self.channel(id)?.kind == ChannelKind::Count)
    }

    fn check_tally(&self, tally: &TallySpec) -> Result<(), CircuitFault> {
        for signal in tally.signals() {
            if !self.digital(signal)? {
                return Err(CircuitFault::NotDigital(signal));
            }
        }
        if self.counts(tally.channel)? { Ok(()) } else { Err(CircuitFault::NotCount(tally.channel)) }
    }

    fn check_wire(&self, wire: &WireSpec) -> Result<(), CircuitFault> {
        let (from, to) = (self.digital(wire.from)?, self.digital(wire.to)?);
        if from != to || self.counts(wire.from)? || self.counts(wire.to)? {
            return Err(CircuitFault::KindsDiffer);
        }
        if !from && (wire.invert || wire.bounce.is_some() || wire.off_delay.is_some()) {
            return Err(CircuitFault::NotForAnalog);
        }
        if wire.delay.is_negative() || wire.off_delay.is_some_and(Span::is_negative) {
            return Err(CircuitFault::BadTime);
        }
        if let Some(bounce) = wire.bounce {
            if bounce.edges == 0 || bounce.edges % 2 != 0 || bounce.edges > MAX_BOUNCE_EDGES {
                return Err(CircuitFault::BounceEdges);
            }
            if bounce.over < Span::from_nanos(i64::from(bounce.edges)) {
                return Err(CircuitFault::BounceTime);
            }
        }
        Ok(())
    }

    fn check_plant(&self, plant: usize, spec: &dyn PlantSpec, errors: &mut Vec<CircuitError>) {
        let part = |switch: Option<usize>| {
            switch.map_or(CircuitPart::Plant(plant), |switch| CircuitPart::Switch { plant, switch })
        };
        for port in spec.inputs().into_iter().chain(spec.outputs()) {
            if let Err(fault) = self.check_port(&port) {
                errors.push(CircuitError { part: part(port.switch), fault });
            }
        }
        let faults = spec.check().into_iter();
        errors.extend(faults.map(|(switch, fault)| CircuitError { part: part(switch), fault }));
    }

    fn check_port(&self, port: &PlantPort) -> Result<(), CircuitFault> {
        let id = port.channel;
        let kind = &self.channel(id)?.kind;
        match (port.kind, kind) {
            (PlantPortKind::Level, ChannelKind::Digital)
            | (PlantPortKind::Quantity, ChannelKind::Analog { .. })
            | (PlantPortKind::Either, ChannelKind::Digital | ChannelKind::Analog { .. }) => Ok(()),
            (PlantPortKind::Level, _) => Err(CircuitFault::NotDigital(id)),
            (PlantPortKind::Quantity | PlantPortKind::Either, _) => Err(CircuitFault::NotAnalog(id)),
        }
    }

    /// The channels that wires and plants drive.
    fn targets(&self) -> impl Iterator<Item = (CircuitPart, ChannelId)> {
        let wires = self.wires.iter().enumerate().map(|(place, wire)| (CircuitPart::Wire(place), wire.to));
        let plants = self.plants.iter().enumerate().flat_map(|(place, plant)| {
            plant.outputs().into_iter().map(move |port| (CircuitPart::Plant(place), port.channel))
        });
        wires.chain(plants)
    }

    /// Whether a wire or a plant drives the channel.
    pub(crate) fn is_target(&self, channel: ChannelId) -> bool {
        self.targets().any(|(_, to)| to == channel)
    }

    /// Levels that meet on a line have a winner; values that meet do not.
    fn check_sources(&self, errors: &mut Vec<CircuitError>) {
        let mut driven = vec![false; self.channels.len()];
        for (part, to) in self.targets() {
            if self.digital(to) == Ok(false) && std::mem::replace(&mut driven[usize::from(to.0)], true) {
                errors.push(CircuitError { part, fault: CircuitFault::TwoSources(to) });
            }
        }
    }
}

/// The value as a channel of this kind carries it; `None` where it does not fit.
pub(crate) fn fit(kind: &ChannelKind, value: Value) -> Option<Value> {
    match (kind, value) {
        (_, Value::HighZ) => Some(Value::HighZ),
        (ChannelKind::Digital, Value::Bool(_)) => Some(value),
        (ChannelKind::Digital, Value::Int(n @ (0 | 1))) => Some(Value::Bool(n == 1)),
        (ChannelKind::Digital, Value::Word(n @ (0 | 1))) => Some(Value::Bool(n == 1)),
        (ChannelKind::Analog { .. }, Value::Real(x)) if x.is_finite() => Some(value),
        (ChannelKind::Analog { .. }, Value::Int(n)) => Some(Value::Real(n as f64)),
        (ChannelKind::Count, Value::Int(_)) => Some(value),
        (ChannelKind::Analog { .. }, Value::Word(n)) => Some(Value::Real(n as f64)),
        _ => None,
    }
}
