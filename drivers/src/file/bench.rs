//! Channels and bindings of a board file, by name.

use std::ops::Range;

use document::{Data, Entry, Fields, Findings, Node, suggest};
use signal::{Address, AddressError, Area, Size, Value};

use super::{Binding, BoardFile, Terminals, codes, keys, number};
use crate::circuit::{ChannelSpec, MAX_PARTS, PlantPrograms, Pull};
use crate::plant::ChannelNames;
use crate::{ChannelId, ChannelKind};

/// The board being read, with the place of every channel that the file itself describes.
pub(super) struct Bench<'t> {
    pub(super) file: BoardFile,
    terminals: &'t Terminals,
    programs: Option<&'t dyn PlantPrograms>,
    /// Place of the channel's key, and whether its pull is written; by channel.
    written: Vec<Option<(Range<usize>, bool)>>,
    /// Channels that are relays, which the rig drives although no terminal needs them.
    pub(super) relays: Vec<ChannelId>,
}

impl<'t> Bench<'t> {
    /// A bench of the default board, whose plants have their programs from there.
    pub(super) fn new(
        file: BoardFile,
        terminals: &'t Terminals,
        programs: Option<&'t dyn PlantPrograms>,
    ) -> Self {
        let written = vec![None; file.circuit.channels.len()];
        Bench { file, terminals, programs, written, relays: Vec::new() }
    }

    /// Where the file describes a channel.
    pub(super) fn place_of(&self, channel: usize) -> Range<usize> {
        self.written.get(channel).and_then(Option::as_ref).map_or(0..0, |(span, _)| span.clone())
    }

    /// Adds the file's channels; one of a default channel's name takes its place.
    pub(super) fn channels(&mut self, entries: &[Entry], out: &mut Findings) {
        for entry in entries {
            let Some(table) = entry.node.as_table() else { continue };
            let fields = Fields::check(table, entry.key_span.clone(), "channel", keys::CHANNEL, out);
            let name_is_good = !entry.key.is_empty()
                && entry.key.len() <= 64
                && entry.key.chars().all(|c| c.is_alphanumeric() || "_-.".contains(c));
            if !name_is_good {
                let help = "use at most 64 letters, digits, `_`, `-` and `.`";
                out.error(codes::CHANNEL_NAME, entry.key_span.clone(), "this is no name for a channel", help);
                continue;
            }
            let Some(spec) = channel(&entry.key, &fields, out) else { continue };
            let written = Some((entry.key_span.clone(), fields.has("pull")));
            match self.file.find(&entry.key) {
                Some(ChannelId(at)) => {
                    self.file.circuit.channels[usize::from(at)] = spec;
                    self.written[usize::from(at)] = written;
                }
                None if self.file.circuit.channels.len() >= MAX_PARTS => {
                    let message = format!("the board has more than {MAX_PARTS} channels");
                    out.error(codes::TOO_MANY, entry.key_span.clone(), message, "remove channels");
                    return;
                }
                None => {
                    self.file.circuit.channels.push(spec);
                    self.written.push(written);
                }
            }
        }
    }

    /// Binds the terminals whose default channel the file describes: `I0` is the first input.
    pub(super) fn bind_by_name(&mut self) {
        let Terminals { inputs, outputs, .. } = self.terminals;
        for (letter, addresses) in [('I', inputs), ('Q', outputs)] {
            for (number, address) in addresses.iter().enumerate() {
                if let Some(channel) = self.file.find(&format!("{letter}{number}")) {
                    self.file.bind.push(Binding { address: *address, channel });
                }
            }
        }
        self.file.bind.sort_by_key(|binding| binding.address);
    }

    /// Binds terminals as the file says.
    pub(super) fn bind(&mut self, entries: &[Entry], out: &mut Findings) {
        let mut bound: Vec<(Address, Range<usize>)> = Vec::new();
        let mut places: Vec<(Address, Range<usize>)> = Vec::new();
        for entry in entries {
            let Some(address) = self.terminal(entry, out) else { continue };
            if let Some((_, first)) = bound.iter().find(|(other, _)| *other == address) {
                let message = format!("{address} is bound already");
                let found = document::Diagnostic::error(codes::BOUND_TWICE, message)
                    .at(out.file().to_owned(), entry.key_span.clone(), "")
                    .at(out.file().to_owned(), first.clone(), "here first")
                    .help("keep one of the two");
                out.push(found);
                continue;
            }
            bound.push((address, entry.key_span.clone()));
            let Some(channel) = self.channel(&entry.node, out) else { continue };
            if !self.suits(address, channel, &entry.node, out) {
                continue;
            }
            places.push((address, entry.node.span.clone()));
            match self.file.bind.iter_mut().find(|binding| binding.address == address) {
                Some(binding) => *binding = Binding { address, channel },
                None => self.file.bind.push(Binding { address, channel }),
            }
        }
        self.file.bind.sort_by_key(|binding| binding.address);
        self.check_defaults(&bound, out);
        self.check_outputs(&places, out);
        for Binding { address, channel } in &self.file.bind {
            let at = usize::from(channel.0);
            let is_level = address.size() == Size::Bit;
            if is_level
                && address.area() == Area::Output
                && self.written[at].as_ref().is_some_and(|(_, pull)| !pull)
            {
                self.file.circuit.channels[at].pull = Pull::None;
            }
        }
    }

    /// A key of `bind` as a terminal of the controller.
    fn terminal(&self, entry: &Entry, out: &mut Findings) -> Option<Address> {
        let address = match Address::parse(&entry.key) {
            Ok(address) => address,
            Err(error) => {
                out.error(codes::ADDRESS, entry.key_span.clone(), bad_address(&entry.key, error), READABLE);
                return None;
            }
        };
        let Terminals { inputs, outputs, .. } = self.terminals;
        if inputs.contains(&address) || outputs.contains(&address) {
            return Some(address);
        }
        let message = format!("the controller has no terminal {address}");
        let mut help = format!("its inputs are {}, its outputs {}", ranges(inputs), ranges(outputs));
        if !self.file.subject.is_external() {
            help += OF_MODULE;
        }
        out.error(codes::TERMINAL, entry.key_span.clone(), message, help);
        None
    }

    /// Whether a terminal can be wired to a channel.
    fn suits(&self, address: Address, channel: ChannelId, node: &Node, out: &mut Findings) -> bool {
        let spec = &self.file.circuit.channels[usize::from(channel.0)];
        let external = self.file.subject.is_external();
        let (message, help) = match (address.size(), &spec.kind, address.area()) {
            (Size::Bit, ChannelKind::Count, Area::Input) if !external => return true,
            (_, ChannelKind::Count, _) => (
                format!("{address} carries no count, as `{}` does", spec.name),
                "a count goes with an input of the rig's own controller: name its channel in the plan",
            ),
            // The terminal makes a level of a voltage; nothing else has one to make it of (io:STD-IN-02).
            (Size::Bit, ChannelKind::Analog { unit }, area) if area != Area::Input || unit != "V" => (
                format!("{address} is a level, `{}` an analog channel", spec.name),
                "bind it to a digital channel, or an input to an analog one in V",
            ),
            (_, ChannelKind::Digital, _) if address.size() != Size::Bit => (
                format!("{address} is a number, `{}` a digital channel", spec.name),
                "bind it to an analog channel",
            ),
            // Of a real controller the rig drives the inputs and sees the outputs.
            (_, _, area) if (area == Area::Output) != external && !spec.drives => {
                let what = if external { "input" } else { "output" };
                (format!("the {what} {address} needs a channel that is driven"), "remove `drives = false`")
            }
            (_, _, area) if (area == Area::Input) != external && !spec.senses => {
                let what = if external { "output" } else { "input" };
                (format!("the {what} {address} needs a channel that is sensed"), "remove `senses = false`")
            }
            _ => return true,
        };
        out.error(codes::BINDING, node.span.clone(), message, help);
        false
    }

    /// Terminals that keep their default channel may find it changed by the file.
    fn check_defaults(&self, bound: &[(Address, Range<usize>)], out: &mut Findings) {
        for Binding { address, channel } in &self.file.bind {
            if bound.iter().any(|(other, _)| other == address) {
                continue;
            }
            let place = self.place_of(usize::from(channel.0));
            let node = Node::new(place, Data::Bool(true));
            self.suits(*address, *channel, &node, out);
        }
    }

    /// A channel has one driver of writes: two outputs on it would undo each other.
    fn check_outputs(&self, places: &[(Address, Range<usize>)], out: &mut Findings) {
        let outputs: Vec<&Binding> =
            self.file.bind.iter().filter(|binding| binding.address.area() == Area::Output).collect();
        for (at, later) in outputs.iter().enumerate() {
            let Some(first) = outputs[..at].iter().find(|first| first.channel == later.channel) else {
                continue;
            };
            let place = |binding: &Binding| {
                places.iter().find(|(address, _)| *address == binding.address).map(|(_, span)| span.clone())
            };
            let span = place(later).or_else(|| place(first)).unwrap_or(0..0);
            let message = format!("{} and {} drive the same channel", first.address, later.address);
            out.error(codes::OUTPUTS_MEET, span, message, "give each its own channel and join them by wires");
        }
    }

    /// The channel that a text names, by its name or by the terminal bound to it. Reports one that is not there.
    pub(super) fn channel(&self, node: &Node, out: &mut Findings) -> Option<ChannelId> {
        let text = node.as_text()?;
        if text.starts_with('%') {
            return match Address::parse(text) {
                Err(error) => {
                    out.bad(codes::ADDRESS, node, bad_address(text, error), READABLE);
                    None
                }
                Ok(address) => {
                    let found = self.file.channel_of(address);
                    if found.is_none() {
                        let message = format!("the controller has no terminal {address}");
                        let mut help = String::from("name a channel, or a terminal that is bound to one");
                        if !self.file.subject.is_external() {
                            help += OF_MODULE;
                        }
                        out.bad(codes::TERMINAL, node, message, help);
                    }
                    found
                }
            };
        }
        let found = self.file.find(text);
        if found.is_none() {
            let names = self.file.circuit.channels.iter().map(|channel| channel.name.as_str());
            let help = match suggest(text, names) {
                Some(meant) => format!("did you mean `{meant}`?"),
                None => how_to_describe(text),
            };
            out.bad(codes::UNKNOWN_CHANNEL, node, format!("the board has no channel `{text}`"), help);
        }
        found
    }
}

impl ChannelNames for Bench<'_> {
    fn channel(&self, node: &Node, out: &mut Findings) -> Option<ChannelId> {
        Bench::channel(self, node, out)
    }

    fn spec(&self, channel: ChannelId) -> &ChannelSpec {
        &self.file.circuit.channels[usize::from(channel.0)]
    }

    fn programs(&self) -> Option<&dyn PlantPrograms> {
        self.programs
    }
}

/// Addresses as ranges of one size without a gap: `%IX0.0 to %IX1.5, %IW3 to %IW4`.
fn ranges(list: &[Address]) -> String {
    let follows = |one: &Address, next: &Address| {
        one.size() == next.size() && one.bit_offset() + one.bit_len() == next.bit_offset()
    };
    let range = |range: &[Address]| match range {
        [first, .., last] => format!("{first} to {last}"),
        _ => range.iter().map(Address::to_string).collect(),
    };
    let ranges: Vec<String> = list.chunk_by(follows).map(range).collect();
    if ranges.is_empty() { String::from("none") } else { ranges.join(", ") }
}

/// What to write under `channels` for a channel of this name.
fn how_to_describe(name: &str) -> String {
    let is_bare = |letter: char| letter.is_ascii_alphanumeric() || matches!(letter, '_' | '-');
    let key = if name.chars().all(is_bare) { name.to_owned() } else { format!("\"{name}\"") };
    format!(
        "describe it under `channels`, as in: {key} = {{ kind = \"digital\" }}, or {{ kind = \"analog\", unit = \"V\" }} with its unit"
    )
}

/// What to write for a terminal of a module, whose address follows from a plan.
const OF_MODULE: &str = "; a terminal of a module goes by its name: M1.IW0 = { kind = \"analog\", unit = \"V\" } under `channels`";

/// What to write for an address that does not read.
const READABLE: &str = "write an input as in %IX0.4, an output as in %QX0.4; a bit is .0 to .7";

fn bad_address(text: &str, error: AddressError) -> String {
    format!("`{text}` does not read as an address: {error}")
}

fn channel(name: &str, fields: &Fields, out: &mut Findings) -> Option<ChannelSpec> {
    let kind = fields.text("kind")?;
    if kind == "count" {
        // What else it has depends on the board, and is read there.
        return Some(ChannelSpec::count(name));
    }
    let digital = kind == "digital";
    let mut spec = if digital {
        ChannelSpec::digital(name, Pull::Down)
    } else {
        ChannelSpec::analog(name, fields.text("unit").unwrap_or_default())
    };
    spec.drives = fields.boolean("drives").unwrap_or(true);
    spec.senses = fields.boolean("senses").unwrap_or(true);
    let foreign = if digital { fields.entry("unit") } else { fields.entry("pull") };
    if let Some(entry) = foreign {
        let kind = if digital { "a digital" } else { "an analog" };
        let message = format!("{kind} channel has no `{}`", entry.key);
        out.error(codes::CHANNEL_PROPERTY, entry.key_span.clone(), message, "remove it, or change the kind");
    }
    spec.pull = match fields.text("pull") {
        Some("up") => Pull::Up,
        Some("none") => Pull::None,
        _ => spec.pull,
    };
    if let Some(node) = fields.get("safe") {
        spec.safe = match (&node.data, digital) {
            (Data::Bool(level), true) => Value::Bool(*level),
            (Data::Bool(_), false) | (_, true) => {
                let help =
                    if digital { "write true or false" } else { "write a number in the channel's unit" };
                out.bad(codes::SAFE_VALUE, node, "the safe value does not suit the channel", help);
                return None;
            }
            (_, false) => Value::Real(number::quantity(node, fields.text("unit").unwrap_or_default(), out)?),
        };
    }
    Some(spec)
}
