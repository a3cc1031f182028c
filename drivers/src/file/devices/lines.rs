//! The GPIO lines behind the channels of a board file.

use std::path::PathBuf;
use std::sync::Arc;

use document::{Data, Entry, Fields, Findings, Node, suggest};
use signal::Value;

use super::{Bench, DeviceReader, channels, codes, generators, keys, number};
use crate::ChannelId;
use crate::gpio::{
    Backend, Bias, ChipSpec, Direction, Drive, FindChip, FindLine, GpioSpec, LineSpec, MAX_CONSUMER,
    MAX_LINES, NamedLine,
};

/// GPIO chips and lines.
pub(super) const READER: DeviceReader = DeviceReader {
    tables: &["chips"],
    channel_keys: OF_LINE,
    bus_kind: None,
    read: |fields, bench, out| Some(Arc::new(gpio(fields, bench, out)?)),
};

/// Keys that only channels with a GPIO line have.
pub(super) const OF_LINE: &[&str] =
    &["chip", "line", "bias", "active-low", "debounce", "drive", "readback", "counts-up-to", "pulses-up-to"];

/// The unit of the kernel's debounce times: microseconds in 32 bits.
const MICROSECOND: i64 = 1_000;
/// The fastest pulses whose levels last a nanosecond, in Hz.
const FASTEST: f64 = 500e6;

/// The GPIO lines of a file whose channels and bindings were read. `None` where something is wrong with them.
fn gpio(fields: &Fields, bench: &mut Bench, out: &mut Findings) -> Option<GpioSpec> {
    let board = fields.inner("board")?;
    let backend = match board.text("backend") {
        Some("v2") => Some(Backend::V2),
        Some("v1") => Some(Backend::V1),
        _ => None,
    };
    let consumer = consumer(&board, out)?;
    let chips = chips(fields, out);
    let mut lines = Vec::new();
    for (entry, fields) in channels(fields) {
        // A channel that is no channel was reported where it was read.
        let Some(ChannelId(at)) = bench.file.find(&entry.key) else { continue };
        if fields.text("kind") != Some("digital") || generators::is_generated(&fields) {
            continue;
        }
        lines.extend(line(entry, &fields, usize::from(at), &chips, bench, out));
    }
    lines.sort_by_key(|line: &LineSpec| line.channel);
    crowded(&chips, &lines, out);
    twice(&lines, out);
    (!out.has_errors()).then_some(GpioSpec { backend, consumer, chips, lines })
}

fn consumer(board: &Fields, out: &mut Findings) -> Option<String> {
    let Some(name) = board.text("consumer") else { return Some("rig".into()) };
    let fits = !name.is_empty() && name.len() <= MAX_CONSUMER && name.chars().all(|c| c.is_ascii_graphic());
    if !fits {
        let help = format!("use 1 to {MAX_CONSUMER} letters, digits and signs, without spaces");
        out.bad(codes::LINE_VALUE, board.get("consumer")?, "the kernel keeps no such name of a holder", help);
        return None;
    }
    Some(name.to_owned())
}

fn chips(fields: &Fields, out: &mut Findings) -> Vec<ChipSpec> {
    let mut chips = Vec::new();
    let table = fields.get("chips").and_then(Node::as_table);
    for entry in table.map_or(&[][..], |table| &table.entries) {
        let Some(table) = entry.node.as_table() else { continue };
        let fields = Fields::checked(table, keys::CHIP);
        let found = match (fields.text("label"), fields.text("name"), fields.text("path")) {
            (Some(label), None, None) => FindChip::Label(label.to_owned()),
            (None, Some(name), None) => FindChip::Name(name.to_owned()),
            (None, None, Some(path)) => FindChip::Path(PathBuf::from(path)),
            _ => {
                let message = format!("the chip `{}` needs one of `label`, `name` and `path`", entry.key);
                let help = "take `label`, which stays when the machine starts again";
                out.error(codes::FIND_CHIP, entry.key_span.clone(), message, help);
                continue;
            }
        };
        chips.push(ChipSpec { name: entry.key.clone(), find: found, place: entry.key_span.clone() });
    }
    chips
}

/// The line of a channel, which learns whether it is driven and sensed.
fn line(
    entry: &Entry,
    fields: &Fields,
    at: usize,
    chips: &[ChipSpec],
    bench: &mut Bench,
    out: &mut Findings,
) -> Option<LineSpec> {
    if let Some(pull) = fields.entry("pull") {
        let help = "the pull of a real line is its `bias`";
        out.error(codes::OTHER_BOARD, pull.key_span.clone(), "a GPIO line has no `pull`", help);
    }
    let chip = chip(entry, fields, chips, out)?;
    let Some(line) = fields.get("line").and_then(named) else {
        let message = format!("the channel `{}` has no line", entry.key);
        let help = "add `line`: its number on the chip, or its name";
        out.error(codes::NO_LINE_SAID, entry.key_span.clone(), message, help);
        return None;
    };
    let readback = fields.get("readback").and_then(named);
    let debounce_us = debounce(fields, out)?;
    let (counts_hz, pulses_hz) = promises(fields, debounce_us, out)?;
    let direction = direction(fields, at, bench);
    unsuitable(fields, direction, out);
    let channel = &mut bench.file.circuit.channels[at];
    let safe = channel.safe == Value::Bool(true);
    match direction {
        Direction::Input => channel.drives = false,
        Direction::Output => channel.safe = Value::Bool(safe),
    }
    Some(LineSpec {
        channel: ChannelId(u16::try_from(at).ok()?),
        chip,
        line,
        direction,
        bias: match fields.text("bias") {
            Some("pull-up") => Some(Bias::PullUp),
            Some("pull-down") => Some(Bias::PullDown),
            Some("disabled") => Some(Bias::Disabled),
            _ => None,
        },
        active_low: fields.boolean("active-low").unwrap_or(false),
        debounce_us,
        drive: match fields.text("drive") {
            Some("open-drain") => Drive::OpenDrain,
            Some("open-source") => Drive::OpenSource,
            _ => Drive::PushPull,
        },
        safe,
        readback,
        counts_hz,
        pulses_hz,
    })
}

/// What the file promises of the line: the fastest pulses that are reported without a loss, and the fastest that are emitted;
/// none where it does not say.
fn promises(fields: &Fields, debounce_us: u32, out: &mut Findings) -> Option<(Option<u64>, u64)> {
    let counts = fields.get("counts-up-to").map(|node| hertz(node, out));
    let pulses = fields.get("pulses-up-to").map(|node| hertz(node, out));
    let (counts, pulses) = (counts.map_or(Some(None), |hz| hz.map(Some))?, pulses.unwrap_or(Some(0))?);
    if let (Some(hz), Some(node)) = (counts, fields.get("counts-up-to"))
        && u128::from(hz) * 2 * u128::from(debounce_us) > 1_000_000
    {
        let message =
            format!("a line that is debounced for {debounce_us} us does not keep pulses of {hz} Hz");
        let help = "lower it, or shorten `debounce`: each level has to last longer than that";
        out.bad(codes::FREQUENCY, node, message, help);
        return None;
    }
    Some((counts, pulses))
}

/// A frequency in whole Hz.
fn hertz(node: &Node, out: &mut Findings) -> Option<u64> {
    let hz = number::quantity(node, "Hz", out)?;
    let fits = (1.0..=FASTEST).contains(&hz) && hz.fract() == 0.0;
    if !fits {
        let help = "write whole Hz from 1 Hz to 500 MHz, as in \"20 kHz\"";
        out.bad(codes::FREQUENCY, node, "no line has pulses of this frequency", help);
    }
    fits.then_some(hz as u64)
}

/// The chip that a channel names, or the only one.
fn chip(entry: &Entry, fields: &Fields, chips: &[ChipSpec], out: &mut Findings) -> Option<usize> {
    let Some(node) = fields.get("chip") else {
        if chips.len() != 1 {
            let message = format!("the channel `{}` does not say on which chip its line is", entry.key);
            let help = match chips {
                [] => String::from("describe it, as in: [chips] main = { label = \"gpio-f7188x\" }"),
                _ => format!("add `chip`: {}", names(chips)),
            };
            out.error(codes::FIND_CHIP, entry.key_span.clone(), message, help);
            return None;
        }
        return Some(0);
    };
    let name = node.as_text()?;
    let found = chips.iter().position(|chip| chip.name == name);
    if found.is_none() {
        let help = match suggest(name, chips.iter().map(|chip| chip.name.as_str())) {
            Some(meant) => format!("did you mean `{meant}`?"),
            None if chips.is_empty() => String::from("describe it under `chips`"),
            None => format!("the file's chips are {}", names(chips)),
        };
        out.bad(codes::CHIP, node, format!("the file has no chip `{name}`"), help);
    }
    found
}

fn names(chips: &[ChipSpec]) -> String {
    let names: Vec<String> = chips.iter().map(|chip| format!("`{}`", chip.name)).collect();
    names.join(", ")
}

fn named(node: &Node) -> Option<NamedLine> {
    let find = match &node.data {
        Data::Integer(number) => FindLine::Number(u32::try_from(*number).ok()?),
        Data::Text(name) => FindLine::Name(name.clone()),
        _ => return None,
    };
    Some(NamedLine { find, place: node.span.clone() })
}

/// A line is driven where the file says so, or where somebody needs it: the model drives its outputs, and the rig the
/// inputs of a real controller. A line that nobody is known to drive is left alone.
fn direction(fields: &Fields, at: usize, bench: &Bench) -> Direction {
    let is_relay = bench.relays.iter().any(|relay| usize::from(relay.0) == at);
    let to = match (fields.has("readback"), fields.boolean("drives"), fields.boolean("senses")) {
        (true, ..) | (_, Some(true), _) => true,
        _ if is_relay => true,
        (_, Some(false), _) => false,
        (_, None, Some(false)) => true,
        _ => u16::try_from(at).ok().and_then(|at| bench.file.is_driven(ChannelId(at))).unwrap_or(false),
    };
    if to { Direction::Output } else { Direction::Input }
}

/// Reports what is said of an input that only outputs have, and the other way round.
fn unsuitable(fields: &Fields, direction: Direction, out: &mut Findings) {
    let (what, keys): (_, &[&str]) = match (direction, fields.has("readback")) {
        (Direction::Input, _) => ("an input line", &["drive", "safe", "pulses-up-to"]),
        // Its other line is an input.
        (Direction::Output, true) => return,
        (Direction::Output, false) => ("an output line", &["debounce", "counts-up-to"]),
    };
    for entry in keys.iter().filter_map(|key| fields.entry(key)) {
        let message = format!("{what} has no `{}`", entry.key);
        let help = "remove it, or say by `drives` which way the line goes";
        out.error(codes::LINE_PROPERTY, entry.key_span.clone(), message, help);
    }
}

fn debounce(fields: &Fields, out: &mut Findings) -> Option<u32> {
    let Some(time) = fields.duration("debounce") else { return Some(0) };
    let time = time.as_nanos();
    match u32::try_from(time / MICROSECOND) {
        Ok(micros) if time % MICROSECOND == 0 => Some(micros),
        _ => {
            let help = "write whole microseconds, at most an hour";
            out.bad(
                codes::LINE_VALUE,
                fields.get("debounce")?,
                "the kernel cannot debounce for this long",
                help,
            );
            None
        }
    }
}

/// A claim has one bit for each line.
fn crowded(chips: &[ChipSpec], lines: &[LineSpec], out: &mut Findings) {
    for (at, chip) in chips.iter().enumerate() {
        let here = || lines.iter().filter(|line| line.chip == at);
        let driven = here().filter(|line| line.direction == Direction::Output).count();
        let read =
            here().filter(|line| line.direction == Direction::Input || line.readback.is_some()).count();
        if driven > MAX_LINES || read > MAX_LINES {
            let message =
                format!("the chip `{}` has more than {MAX_LINES} lines of one direction", chip.name);
            out.error(codes::TOO_MANY_LINES, chip.place.clone(), message, "remove channels");
        }
    }
}

/// A line has one channel. Names that mean the same line show when the chip is there.
fn twice(lines: &[LineSpec], out: &mut Findings) {
    let all: Vec<(usize, &NamedLine)> = lines
        .iter()
        .flat_map(|line| {
            let back = line.readback.iter().map(|back| (line.chip, back));
            std::iter::once((line.chip, &line.line)).chain(back)
        })
        .collect();
    for (at, (chip, line)) in all.iter().enumerate() {
        let first = all[..at].iter().find(|(other, first)| other == chip && first.find == line.find);
        let Some((_, first)) = first else { continue };
        let found = document::Diagnostic::error(codes::LINE_TWICE, "the line is used already")
            .at(out.file().to_owned(), line.place.clone(), "")
            .at(out.file().to_owned(), first.place.clone(), "here first")
            .help("give each channel a line of its own; several terminals can be bound to one channel");
        out.push(found);
    }
}
