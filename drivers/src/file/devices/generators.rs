//! The generators of a board file, and the outputs behind its channels.

use std::sync::Arc;

use document::{Data, Diagnostic, Entry, Fields, Findings, Node, suggest};
use signal::{Area, Span, Value};

use super::lines::OF_LINE;
use super::{Bench, DeviceReader, adc, channels, codes, keys, number};
use crate::ChannelId;
use crate::file::clock::of_device;
use crate::generator::{
    BUFFER, BitClock, FindPwm, GeneratorKind, GeneratorSpec, GeneratorsSpec, OutputSpec, PwmSpec, StreamSpec,
};

/// Generators of pulses.
pub(super) const READER: DeviceReader = DeviceReader {
    tables: &["generators"],
    channel_keys: OF_OUTPUT,
    bus_kind: None,
    read: |fields, bench, out| Some(Arc::new(generators(fields, bench, out))),
};

/// Keys that only channels behind a generator have.
const OF_OUTPUT: &[&str] = &["generator", "output"];

/// The one key of a GPIO line that they have, too.
const SHARED: &str = "active-low";

/// A bit clock that hardly any wiring is too long for.
const USUAL: u32 = 1_000_000;

/// What every kernel can keep as a period, in ns.
const LONGEST: Span = Span::from_nanos(i32::MAX as i64);

/// Keys of the one kind and of the other.
const OF_STREAM: &[&str] = &["clock-error", "mode", "lsb-first", "buffer"];
const OF_PWM: &[&str] = &["name", "label", "shortest", "longest"];

/// Whether a channel has its pulses from a generator.
pub(in crate::file) fn is_generated(fields: &Fields) -> bool {
    fields.has("generator")
}

/// The generators of a file whose channels and bindings were read. What is wrong with them is reported.
fn generators(fields: &Fields, bench: &mut Bench, out: &mut Findings) -> GeneratorsSpec {
    let mut spec = GeneratorsSpec::default();
    let table = fields.get("generators").and_then(Node::as_table);
    // Of those that are wrong the names count all the same: each is reported once.
    let mut wrong = Vec::new();
    for entry in table.map_or(&[][..], |table| &table.entries) {
        let Some(table) = entry.node.as_table() else { continue };
        match generator(entry, &Fields::checked(table, keys::GENERATOR), out) {
            Some(kind) => spec.generators.push(GeneratorSpec {
                name: entry.key.clone(),
                place: entry.key_span.clone(),
                kind,
            }),
            None => wrong.push(entry.key.as_str()),
        }
    }
    twice(&spec.generators, out);
    for (entry, fields) in channels(fields).filter(|(_, fields)| is_generated(fields)) {
        let Some(channel) = bench.file.find(&entry.key) else { continue };
        if let Some(output) = output(entry, &fields, channel, &spec, &wrong, bench, out) {
            spec.outputs.push(output);
        }
    }
    spec.outputs.sort_by_key(|output| output.channel);
    spec
}

fn generator(entry: &Entry, fields: &Fields, out: &mut Findings) -> Option<GeneratorKind> {
    let is_stream = fields.text("kind")? == "spi";
    let (what, other, strange) = match is_stream {
        true => ("a stream of an SPI bus", "pwm", OF_PWM),
        false => ("a PWM chip", "spi", OF_STREAM),
    };
    for entry in strange.iter().filter_map(|key| fields.entry(key)) {
        let message = format!("{what} has no `{}`", entry.key);
        let help = format!("remove it, or write kind = \"{other}\"");
        out.error(codes::GENERATOR_VALUE, entry.key_span.clone(), message, help);
    }
    let clock = match fields.get("clock") {
        None => None,
        Some(node) => {
            let hz = number::quantity(node, "Hz", out)?;
            if !(1.0..=f64::from(u32::MAX)).contains(&hz) {
                let help = format!("write a rate of 1 Hz to {} Hz", u32::MAX);
                out.bad(codes::GENERATOR_VALUE, node, "there is no such clock", help);
                return None;
            }
            Some(BitClock::new(hz as u32))
        }
    };
    if is_stream { stream(entry, fields, clock, out) } else { pwm(entry, fields, clock, out) }
}

fn stream(
    entry: &Entry,
    fields: &Fields,
    clock: Option<BitClock>,
    out: &mut Findings,
) -> Option<GeneratorKind> {
    let Some(path) = fields.text("path") else {
        let message = format!("the generator `{}` has no `path`", entry.key);
        let help = "add the device of its chip select, as in path = \"/dev/spidev0.0\"";
        out.error(codes::FIND_GENERATOR, entry.key_span.clone(), message, help);
        return None;
    };
    Some(GeneratorKind::Stream(StreamSpec {
        path: path.into(),
        clock: clock.unwrap_or(BitClock::new(USUAL)).off_by(of_device(fields, out)),
        mode: fields.integer("mode").and_then(|mode| u8::try_from(mode).ok()).unwrap_or(0),
        lsb_first: fields.boolean("lsb-first").unwrap_or(false),
        buffer: fields.integer("buffer").and_then(|bytes| u32::try_from(bytes).ok()).unwrap_or(BUFFER),
    }))
}

fn pwm(entry: &Entry, fields: &Fields, clock: Option<BitClock>, out: &mut Findings) -> Option<GeneratorKind> {
    let find = match (fields.text("label"), fields.text("name"), fields.text("path")) {
        (Some(label), None, None) => FindPwm::Label(label.to_owned()),
        (None, Some(name), None) => FindPwm::Name(name.to_owned()),
        (None, None, Some(path)) => FindPwm::Path(path.into()),
        _ => {
            let message = format!("the generator `{}` needs one of `label`, `name` and `path`", entry.key);
            let help = "take `label`, the name of its device, which stays when the machine starts again";
            out.error(codes::FIND_GENERATOR, entry.key_span.clone(), message, help);
            return None;
        }
    };
    let step = clock.map_or(Span::from_nanos(1), BitClock::period);
    let shortest = fields.duration("shortest").unwrap_or(step);
    let longest = fields.duration("longest").unwrap_or(LONGEST);
    if let Some(node) = fields.get("shortest").filter(|_| shortest < step) {
        let help = format!("its steps are {step}: write no less, or a faster `clock`");
        out.bad(codes::GENERATOR_VALUE, node, "a level is never shorter than a step", help);
        return None;
    }
    if let Some(node) =
        fields.get("longest").or(fields.get("shortest")).filter(|_| longest < shortest + shortest)
    {
        let help = "make `longest` longer, or `shortest` shorter";
        out.bad(codes::GENERATOR_VALUE, node, "a period has room for two levels", help);
        return None;
    }
    Some(GeneratorKind::Pwm(PwmSpec { find, clock, shortest, longest }))
}

/// A bus has one stream.
fn twice(generators: &[GeneratorSpec], out: &mut Findings) {
    for (at, later) in generators.iter().enumerate() {
        let path = |generator: &GeneratorSpec| match &generator.kind {
            GeneratorKind::Stream(stream) => Some(stream.path.clone()),
            GeneratorKind::Pwm(_) => None,
        };
        let first = generators[..at].iter().find(|first| path(first).is_some() && path(first) == path(later));
        let Some(first) = first else { continue };
        let found = Diagnostic::error(codes::GENERATOR_TWICE, "the device is a generator already")
            .at(out.file().to_owned(), later.place.clone(), "")
            .at(out.file().to_owned(), first.place.clone(), "here first")
            .help("describe it once, and name it in its channel");
        out.push(found);
    }
}

/// The output behind a channel.
fn output(
    entry: &Entry,
    fields: &Fields,
    channel: ChannelId,
    spec: &GeneratorsSpec,
    wrong: &[&str],
    bench: &mut Bench,
    out: &mut Findings,
) -> Option<OutputSpec> {
    let mut sound = fields.text("kind") == Some("digital");
    let strange = OF_LINE.iter().chain(adc::OF_INPUT).chain(&["pull", "drives"]);
    for entry in strange.filter(|key| **key != SHARED).filter_map(|key| fields.entry(key)) {
        let message = format!("a channel behind a generator has no `{}`", entry.key);
        let help = "remove it, or its `generator`";
        out.error(codes::CHANNEL_PROPERTY, entry.key_span.clone(), message, help);
        sound = false;
    }
    if fields.text("kind") == Some("analog") {
        let help = "make the channel a digital one";
        out.error(
            codes::CHANNEL_PROPERTY,
            entry.key_span.clone(),
            "a generator makes levels, no quantities",
            help,
        );
    }
    let generator = find(fields.get("generator")?, spec, wrong, out)?;
    let kind = &spec.generators[generator].kind;
    let is_stream = matches!(kind, GeneratorKind::Stream(_));
    let (output, place) = match fields.get("output") {
        None => (0, fields.get("generator")?.span.clone()),
        Some(node) => match &node.data {
            Data::Integer(number) => (u16::try_from(*number).ok()?, node.span.clone()),
            _ => return None,
        },
    };
    if let Some(node) = fields.get("output").filter(|_| is_stream && output != 0) {
        let help = "remove it: the data line is its only output";
        out.bad(codes::OUTPUT, node, format!("a stream of an SPI bus has no output {output}"), help);
        return None;
    }
    if let Some(first) =
        spec.outputs.iter().find(|other| other.generator == generator && other.output == output)
    {
        let found = Diagnostic::error(codes::OUTPUT, "the output is used already")
            .at(out.file().to_owned(), place, "")
            .at(out.file().to_owned(), first.place.clone(), "here first")
            .help("say by `output` which of its generator's each channel has");
        out.push(found);
        return None;
    }
    let safe = bench.file.circuit.channels[usize::from(channel.0)].safe == Value::Bool(true);
    if let Some(node) = fields.get("safe").filter(|_| is_stream && safe) {
        let help = "remove it; where the wire is to be high at rest, write active-low = true";
        out.bad(codes::GENERATOR_LEVEL, node, "a stream rests at 0 of its channel", help);
        return None;
    }
    sound &= wired(entry, channel, is_stream, bench, out);
    let known = &mut bench.file.circuit.channels[usize::from(channel.0)];
    known.safe = Value::Bool(safe);
    known.drives = !is_stream;
    // What a PWM chip puts out nobody reports.
    known.senses &= is_stream;
    let active_low = fields.boolean(SHARED).unwrap_or(false);
    sound.then_some(OutputSpec { channel, generator, output, place, active_low, safe })
}

/// The generator that a channel names.
fn find(node: &Node, spec: &GeneratorsSpec, wrong: &[&str], out: &mut Findings) -> Option<usize> {
    let name = node.as_text()?;
    let names = || spec.generators.iter().map(|generator| generator.name.as_str());
    let found = names().position(|other| other == name);
    if found.is_none() && !wrong.contains(&name) {
        let listed = || names().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
        let help = match suggest(name, names()) {
            Some(meant) => format!("did you mean `{meant}`?"),
            None if spec.generators.is_empty() => String::from(
                "describe it, as in: [generators] stream = { kind = \"spi\", path = \"/dev/spidev0.0\" }",
            ),
            None => format!("the file's generators are {}", listed()),
        };
        out.bad(codes::FIND_GENERATOR, node, format!("the file has no generator `{name}`"), help);
    }
    found
}

/// Whether what the channel is bound to can live with a generator.
fn wired(entry: &Entry, channel: ChannelId, is_stream: bool, bench: &Bench, out: &mut Findings) -> bool {
    let external = bench.file.subject.is_external();
    let of_model = |area| {
        bench.file.bind.iter().any(|binding| binding.channel == channel && binding.address.area() == area)
    };
    let lines = bench.file.lines;
    let is_line = [lines.power, lines.run_stop, lines.alarm].contains(&Some(channel));
    let (message, help) = if is_stream && (is_line || !external && of_model(Area::Output)) {
        ("a stream of an SPI bus keeps no level", "bind it to a GPIO line or to an output of a PWM chip")
    } else if !is_stream && bench.file.is_driven(channel) == Some(false) {
        (
            "an output of a PWM chip reports no level",
            "bind it to a channel that is sensed, such as a GPIO line",
        )
    } else {
        return true;
    };
    out.error(codes::GENERATOR_LEVEL, entry.key_span.clone(), message, help);
    false
}
