//! What names mean to the clients of a rig: numbers for signals, and what is behind each.

use super::fault;
use crate::application::catalogue::Catalogue;
use crate::application::observable::Observable;
use crate::application::taken_values::TakenValues;
use crate::prepare::state_labels;
use crate::scan_port::ObservedSource;
use control::{RequestFault, Signal, SignalKind};
use controller::Probe;
use drivers::{BoardFile, Channel, ChannelId, ChannelKind};
use profile::SystemVariable;
use signal::{Address, AddressLimits, Area, Value, ValueKind};
use std::collections::BTreeMap;

/// Names that can be reported of one program: a description stays short enough to be sent.
const MOST_LISTED: usize = 10_000;

/// Names that clients may find beside those that are listed.
const MOST_FOUND: usize = 4_096;

/// A signal with what is behind it.
#[derive(Clone, Debug)]
struct KnownSignal {
    signal: Signal,
    source: u32,
}

/// The directory of a rig.
#[derive(Debug)]
pub struct Directory {
    catalogue: Catalogue,
    limits: AddressLimits,
    /// Name, unit, kind, whether a client may drive it, and the terminal behind each channel.
    channels: Vec<BoardLine>,
    signals: Vec<KnownSignal>,
    /// By names in small letters.
    names: BTreeMap<String, u32>,
    sources: Vec<ObservedSource>,
    /// Signals of each source.
    shown: Vec<Vec<u32>>,
    /// Signals beyond this number were found.
    listed: usize,
}

/// Whether a client may drive the line of a channel: the board can, and nothing of the rig does.
pub(super) fn is_written(file: &BoardFile, id: ChannelId, channel: &Channel) -> bool {
    channel.drives && file.is_driven(id) != Some(true)
}

/// A channel of the board.
#[derive(Clone, Debug)]
struct BoardLine {
    name: String,
    unit: String,
    kind: SignalKind,
    drives: bool,
    terminal: Option<Address>,
}

impl Directory {
    /// What names mean on this board with this controller.
    pub fn new(
        catalogue: Catalogue,
        file: &BoardFile,
        channels: &[Channel],
        limits: AddressLimits,
    ) -> Directory {
        let line = |(place, channel): (usize, &Channel)| {
            let id = ChannelId(place as u16);
            let bound = file.bind.iter().find(|binding| binding.channel == id);
            BoardLine {
                name: channel.name.clone(),
                unit: channel.unit().to_owned(),
                kind: match channel.kind {
                    ChannelKind::Digital => SignalKind::Bool,
                    ChannelKind::Analog { .. } => SignalKind::Real,
                    ChannelKind::Count => SignalKind::Int,
                },
                drives: is_written(file, id, channel),
                terminal: bound.map(|binding| binding.address),
            }
        };
        let mut directory = Directory {
            channels: channels.iter().enumerate().map(line).collect(),
            catalogue,
            limits,
            signals: Vec::new(),
            names: BTreeMap::new(),
            sources: Vec::new(),
            shown: Vec::new(),
            listed: usize::MAX,
        };
        let names: Vec<String> = directory.catalogue.names();
        for name in std::iter::once(String::from("state")).chain(names.into_iter().take(MOST_LISTED)) {
            // Whole arrays are in the list, and are no signals.
            let _ = directory.find(&name);
        }
        directory.listed = directory.signals.len();
        directory
    }

    /// Sources that there can ever be.
    pub fn most(&self) -> usize {
        self.listed + MOST_FOUND
    }

    /// The signals that are listed.
    pub fn listed(&self) -> Vec<Signal> {
        self.signals.iter().take(self.listed).map(|known| known.signal.clone()).collect()
    }

    /// The signal of a name.
    ///
    /// # Errors
    /// A name that is unknown, or one more than can be found.
    pub fn find(&mut self, name: &str) -> Result<Signal, RequestFault> {
        let name = name.trim();
        let small = name.to_ascii_lowercase();
        if let Some(known) = self.names.get(&small).and_then(|number| self.signals.get(*number as usize)) {
            return Ok(known.signal.clone());
        }
        let (source, signal) = self.meaning(name)?;
        if self.signals.len() >= self.listed.saturating_add(MOST_FOUND) {
            return Err(fault::too_many(&format!("{MOST_FOUND} names were looked up besides those listed")));
        }
        let number = self.signals.len() as u32;
        let place = self.sources.iter().position(|known| *known == source).unwrap_or_else(|| {
            self.sources.push(source);
            self.shown.push(Vec::new());
            self.sources.len() - 1
        });
        self.shown[place].push(number);
        let signal = Signal { number, ..signal };
        self.signals.push(KnownSignal { signal: signal.clone(), source: place as u32 });
        self.names.insert(small, number);
        Ok(signal)
    }

    /// What is behind a signal, under its own number.
    pub fn source(&self, signal: u32) -> Option<(u32, ObservedSource)> {
        let source = self.signals.get(signal as usize)?.source;
        Some((source, *self.sources.get(source as usize)?))
    }

    /// What a source is.
    pub fn of(&self, source: u32) -> Option<ObservedSource> {
        self.sources.get(source as usize).copied()
    }

    /// The signals that show a source.
    pub fn shown(&self, source: u32) -> &[u32] {
        self.shown.get(source as usize).map_or(&[], Vec::as_slice)
    }

    /// The signal of this number.
    pub fn signal(&self, signal: u32) -> Option<&Signal> {
        self.signals.get(signal as usize).map(|known| &known.signal)
    }

    /// The place in %I or %Q of the input or output whose image or line a signal is.
    pub fn forced_place(&self, signal: u32) -> Option<Address> {
        let address = match self.source(signal)?.1 {
            ObservedSource::Inside(Probe::Address(address)) => address,
            ObservedSource::Inside(_) => return None,
            ObservedSource::Channel(channel) => self.channels.get(usize::from(channel.0))?.terminal?,
        };
        self.catalogue.is_channel(address).then_some(address)
    }

    /// The value as a signal takes it.
    ///
    /// # Errors
    /// It cannot be written, or not with this value.
    pub fn fitting(&self, signal: u32, value: Value) -> Result<Value, RequestFault> {
        let Some(known) = self.signal(signal) else { return Err(fault::unknown(&signal.to_string(), None)) };
        if !known.writable {
            return Err(fault::not_written(&known.name));
        }
        // A line of the board is let go: what else drives it shows again.
        let is_line = matches!(self.source(signal), Some((_, ObservedSource::Channel(_))));
        if is_line && value == Value::HighZ {
            return Ok(value);
        }
        let taken = self.taken(signal, known);
        if !taken.takes(value) {
            return Err(fault::bad_value(&known.name, &taken.to_string()));
        }
        Ok(match known.kind {
            SignalKind::Bool => Value::Bool(value.as_bool() == Some(true)),
            SignalKind::Real => value.as_real().map_or(value, Value::Real),
            SignalKind::Int | SignalKind::Word | SignalKind::State => value,
        })
    }

    /// Which values a signal takes: those of its type or place, and of a line or of a variable of several types those of its kind.
    fn taken(&self, signal: u32, known: &Signal) -> TakenValues {
        let of_name = match self.source(signal) {
            Some((_, ObservedSource::Inside(_))) => self.catalogue.taken(&known.name),
            _ => None,
        };
        of_name.unwrap_or(match known.kind {
            SignalKind::Bool => TakenValues::Level,
            SignalKind::Real => TakenValues::Number,
            SignalKind::Int | SignalKind::Word | SignalKind::State => {
                TakenValues::Whole(i128::from(i64::MIN), i128::from(u64::MAX))
            }
        })
    }

    fn meaning(&self, name: &str) -> Result<(ObservedSource, Signal), RequestFault> {
        let signal = |name: &str, kind, writable| Signal {
            number: 0,
            name: name.to_owned(),
            kind,
            unit: String::new(),
            labels: Vec::new(),
            writable,
        };
        let place = self.channels.iter().position(|line| line.name.eq_ignore_ascii_case(name));
        // Whoever says Q0 means the terminal, unless the line of this name is the one behind it.
        let terminal = self.of_terminal(name);
        let behind = place.and_then(|place| self.channels[place].terminal);
        if let Some(address) = terminal.filter(|_| terminal != behind) {
            return self.meaning(&address.to_string());
        }
        if let Some(place) = place {
            let line = &self.channels[place];
            let found = Signal { unit: line.unit.clone(), ..signal(&line.name, line.kind, line.drives) };
            return Ok((ObservedSource::Channel(ChannelId(place as u16)), found));
        }
        if name.eq_ignore_ascii_case("state") {
            let found = Signal { labels: state_labels(), ..signal("state", SignalKind::State, false) };
            return Ok((ObservedSource::Inside(Probe::State), found));
        }
        if let Ok(address) = Address::parse(name)
            && let Err(error) = address.check(&self.limits)
        {
            return Err(fault::unknown_address(name, &error.to_string()));
        }
        let Some(found) = self.catalogue.observable(name) else { return Err(self.unknown(name)) };
        let Observable { probe, kind } = found;
        let writable = match probe {
            Probe::Address(_) | Probe::Variable(_) => true,
            Probe::System(variable) => variable.is_writable(),
            _ => false,
        };
        let spelling = match probe {
            Probe::Address(address) if name.starts_with('%') => address.to_string(),
            _ => {
                let mut programs = self.catalogue.programs().iter();
                let path = programs.find_map(|program| program.find(name)).map(|variable| variable.path);
                path.unwrap_or_else(|| name.to_owned())
            }
        };
        let is_time = matches!(probe, Probe::Variable(_)) && self.catalogue.times(name).is_some();
        let unit = if is_time { String::from("ns") } else { String::new() };
        // A trace has the number of a system variable, a client shows and takes the names of its values, too.
        let labels = match probe {
            Probe::System(variable) => labels_of(variable),
            _ => found.labels(),
        };
        let found = Signal { unit, labels, ..signal(&spelling, kind_of(kind), writable) };
        Ok((ObservedSource::Inside(probe), found))
    }

    /// The address of `I3` or `Q0`.
    fn of_terminal(&self, name: &str) -> Option<Address> {
        let (letter, number) = name.split_at_checked(1)?;
        let number: u32 = number.parse().ok().filter(|_| number.bytes().all(|c| c.is_ascii_digit()))?;
        let (area, count) = match letter {
            "I" | "i" => (Area::Input, self.catalogue.reference().input_count()),
            "Q" | "q" => (Area::Output, self.catalogue.reference().output_count()),
            _ => return None,
        };
        ((number as usize) < count).then(|| Address::bit(area, number))
    }

    fn unknown(&self, name: &str) -> RequestFault {
        if let Some(help) = self.catalogue.module_terminals().help(name) {
            return fault::unknown_terminal(name, &help);
        }
        let channels = self.channels.iter().map(|line| line.name.as_str());
        let names = channels.chain(self.signals.iter().map(|known| known.signal.name.as_str()));
        fault::unknown(name, document::suggest(name, names))
    }
}

/// The names of the values of a system variable, by their numbers; none without an enumeration.
fn labels_of(variable: SystemVariable) -> Vec<(i64, String)> {
    let values = variable.field.member().enumeration.map_or(&[][..], |one| one.values);
    values.iter().map(|(name, number)| (i64::from(*number), (*name).to_owned())).collect()
}

const fn kind_of(kind: ValueKind) -> SignalKind {
    match kind {
        ValueKind::Bool => SignalKind::Bool,
        ValueKind::Int | ValueKind::Mark => SignalKind::Int,
        ValueKind::Word => SignalKind::Word,
        ValueKind::Real => SignalKind::Real,
        ValueKind::State => SignalKind::State,
    }
}
