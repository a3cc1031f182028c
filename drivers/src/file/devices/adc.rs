//! The converters of a board file, and the inputs behind its analog channels.

use std::sync::Arc;

use document::{Data, Entry, Fields, Findings, Node, suggest};
use signal::calendar::Date;
use signal::{Quantity, QuantityRange, Span, Unit};

use crate::file::accuracy::{OF_BOARD, accuracy};

use super::{Bench, DeviceReader, channels, codes, generators, iio, keys, lines, number, spi};
use crate::ChannelId;
use crate::adc::{AdcKind, AdcSpec, AdcsSpec, Certificate, FindInput, Point, SampleSpec, Scale};

/// Converters.
pub(super) const READER: DeviceReader = DeviceReader {
    tables: &["converters"],
    channel_keys: OF_INPUT,
    bus_kind: None,
    read: |fields, bench, out| Some(Arc::new(converters(fields, bench, out))),
};

/// How often an input is read where the file does not say.
const PERIOD: Span = Span::from_millis(10);

/// Keys that only channels behind a converter have.
pub(super) const OF_INPUT: &[&str] = &[
    "converter",
    "input",
    "range",
    "scale",
    "calibration",
    "accuracy",
    "deadband",
    "open-below",
    "short-above",
];

/// The converters of a file whose channels and bindings were read. What is wrong with them is reported.
fn converters(fields: &Fields, bench: &mut Bench, out: &mut Findings) -> AdcsSpec {
    let mut spec = AdcsSpec::default();
    let table = fields.get("converters").and_then(Node::as_table);
    // Of those that are wrong the names count all the same: each is reported once.
    let mut wrong = Vec::new();
    for entry in table.map_or(&[][..], |table| &table.entries) {
        let Some(table) = entry.node.as_table() else { continue };
        let fields = Fields::checked(table, keys::CONVERTER);
        match converter(entry, &fields, out) {
            Some(converter) => spec.converters.push(converter),
            None => wrong.push(entry.key.as_str()),
        }
    }
    for (entry, fields) in channels(fields) {
        let Some(channel) = bench.file.find(&entry.key) else { continue };
        if generators::is_generated(&fields) {
            continue;
        }
        match fields.text("kind") {
            Some("analog") => {}
            Some("count") => continue,
            _ => {
                reject_foreign_keys(&fields, OF_INPUT, "a digital channel", out);
                continue;
            }
        }
        if reject_foreign_keys(&fields, lines::OF_LINE, "an analog channel", out) {
            continue;
        }
        for entry in ["drives", "safe"].iter().filter_map(|key| fields.entry(key)) {
            if !matches!(entry.node.data, Data::Bool(false)) || entry.key == "safe" {
                let help = "remove it: a converter measures, nothing drives the channel";
                let message = format!("an analog channel of a real board has no `{}`", entry.key);
                out.error(codes::CHANNEL_PROPERTY, entry.key_span.clone(), message, help);
            }
        }
        bench.file.circuit.channels[usize::from(channel.0)].drives = false;
        if let Some(sample) = sample(entry, &fields, channel, &spec, &wrong, out) {
            spec.samples.push(sample);
        }
    }
    for (at, converter) in spec.converters.iter().enumerate() {
        match &converter.kind {
            AdcKind::Spi(of) => spi::inputs(converter, of, &spec.inputs_of(at), out),
            AdcKind::Iio(_) => iio::inputs(&spec.inputs_of(at), out),
        }
    }
    spec
}

/// Reports keys that belong to the other kind of channel, if there are any.
fn reject_foreign_keys(fields: &Fields, keys: &[&str], what: &str, out: &mut Findings) -> bool {
    for entry in keys.iter().filter_map(|key| fields.entry(key)) {
        let message = format!("{what} has no `{}`", entry.key);
        out.error(codes::CHANNEL_PROPERTY, entry.key_span.clone(), message, "remove it, or change the kind");
    }
    keys.iter().any(|key| fields.has(key))
}

fn converter(entry: &Entry, fields: &Fields, out: &mut Findings) -> Option<AdcSpec> {
    let period = fields.duration("period").unwrap_or(PERIOD);
    if let Some(node) = fields.get("period").filter(|_| period <= Span::ZERO) {
        out.bad(codes::TIME, node, "no time lies between two readings", "write a duration above 0");
        return None;
    }
    let kind = match fields.text("kind")? {
        "spi" => AdcKind::Spi(spi::spi(entry, fields, out)?),
        // The table of keys has no other kind.
        _ => AdcKind::Iio(iio::iio(entry, fields, out)?),
    };
    Some(AdcSpec { name: entry.key.clone(), place: entry.key_span.clone(), period, kind })
}

/// The input of a channel.
fn sample(
    entry: &Entry,
    fields: &Fields,
    channel: ChannelId,
    spec: &AdcsSpec,
    wrong: &[&str],
    out: &mut Findings,
) -> Option<SampleSpec> {
    let converter = find(entry, fields, &spec.converters, wrong, out)?;
    let Some(node) = fields.get("input") else {
        let message = format!("the channel `{}` has no input", entry.key);
        let help = "add `input`: its number on the converter, or its name";
        out.error(codes::INPUT, entry.key_span.clone(), message, help);
        return None;
    };
    let input = match &node.data {
        Data::Integer(number) => FindInput::Number(u16::try_from(*number).ok()?),
        Data::Text(name) => FindInput::Name(name.clone()),
        _ => return None,
    };
    let place = node.span.clone();
    let before = spec.samples.iter().find(|other| other.converter == converter && other.input == input);
    if let Some(first) = before {
        let found = document::Diagnostic::error(codes::INPUT, "the input is used already")
            .at(out.file().to_owned(), place, "")
            .at(out.file().to_owned(), first.place.clone(), "here first")
            .help("give each channel an input of its own");
        out.push(found);
        return None;
    }
    let place_of = |key: &str| fields.get(key).map_or(entry.key_span.clone(), |node| node.span.clone());
    let range = match fields.get("range") {
        None => None,
        Some(node) => Some(volts(node, out)?),
    };
    let unit = fields.text("unit").unwrap_or_default();
    let base = match (&spec.converters[converter].kind, &input) {
        (AdcKind::Iio(_), FindInput::Name(name)) => crate::adc::iio::unit_of(name),
        _ => "V",
    };
    let mut scale = scale(fields, base, unit, place_of("unit"), out)?;
    let mut certificate = None;
    if let (Some(node), Some(inner)) = (fields.get("calibration"), fields.inner("calibration")) {
        let read = calibration(node, &inner, unit, out)?;
        (scale.calibration, certificate) = (read.0, Some(read.1));
    }
    scale.accuracy = accuracy(fields, unit, OF_BOARD, out)?;
    Some(SampleSpec {
        channel,
        converter,
        input,
        place,
        range,
        range_place: place_of("range"),
        scale,
        accuracy_place: place_of("accuracy"),
        certificate,
        certificate_place: place_of("calibration"),
    })
}

/// The converter that a channel names, or the only one.
fn find(
    entry: &Entry,
    fields: &Fields,
    converters: &[AdcSpec],
    wrong: &[&str],
    out: &mut Findings,
) -> Option<usize> {
    let names = || converters.iter().map(|converter| converter.name.as_str());
    let listed = || names().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
    let Some(node) = fields.get("converter") else {
        if converters.len() + wrong.len() == 1 {
            return (!converters.is_empty()).then_some(0);
        }
        let message = format!("no device measures `{}`", entry.key);
        let help = match converters {
            [] => String::from(
                "describe its converter, as in: [converters] adc = { kind = \"spi\", path = \"/dev/spidev0.0\", part = \"mcp3008\" }",
            ),
            _ => format!("add `converter`: {}", listed()),
        };
        out.error(codes::FIND_CONVERTER, entry.key_span.clone(), message, help);
        return None;
    };
    let name = node.as_text()?;
    let found = names().position(|other| other == name);
    if found.is_none() && !wrong.contains(&name) {
        let help = match suggest(name, names()) {
            Some(meant) => format!("did you mean `{meant}`?"),
            None if converters.is_empty() => String::from("describe it under `converters`"),
            None => format!("the file's converters are {}", listed()),
        };
        out.bad(codes::FIND_CONVERTER, node, format!("the file has no converter `{name}`"), help);
    }
    found
}

/// A range of voltages.
fn volts(node: &Node, out: &mut Findings) -> Option<(f64, f64)> {
    let read = node.as_text().and_then(|text| QuantityRange::parse(text).ok());
    let end = |end: Option<Quantity>| Some(end?.in_unit(&Unit::new("V"))?.as_f64());
    let ends = read.and_then(|range| Some((end(range.min)?, end(range.max)?)));
    if ends.is_none() {
        let help = "write both ends in volts, as in \"-10.24 V .. 10.24 V\"";
        out.bad(codes::RANGE, node, "this is no range of voltages", help);
    }
    ends
}

/// What the channel shows of its input. `None` where something is wrong, which was reported.
fn scale(
    fields: &Fields,
    base: &'static str,
    unit: &str,
    unit_place: std::ops::Range<usize>,
    out: &mut Findings,
) -> Option<Scale> {
    let inner = fields.inner("scale");
    let has = |key: &str| inner.and_then(|inner| inner.get(key));
    if let (Some(node), Some(_)) = (has("shunt"), has("divider")) {
        let help = "keep the one that the input is wired to";
        out.bad(codes::SCALE, node, "an input is behind a shunt or behind a divider", help);
        return None;
    }
    // What is there, in volts or amperes (or in what else its converter measures), for each volt at the input.
    let (each, of) = match (has("shunt"), has("divider")) {
        (Some(node), _) => (1.0 / ohms(node, out)?, "A"),
        (None, Some(node)) => {
            let (above, below) = two(node, "Ohm", codes::SCALE, out)?;
            if above < 0.0 || below <= 0.0 {
                let help = "write the resistor to the signal, then the one to ground, as in [\"100 kOhm\", \"10 kOhm\"]";
                out.bad(codes::SCALE, node, "this divides nothing", help);
                return None;
            }
            ((above + below) / below, "V")
        }
        (None, None) => (1.0, base),
    };
    let (gain, offset) = match (has("from"), has("to")) {
        (Some(from), Some(to)) => {
            let ((a, b), (x, y)) = (two(from, of, codes::SCALE, out)?, two(to, unit, codes::SCALE, out)?);
            if a == b || x == y {
                out.bad(codes::SCALE, to, "two points that are one make no line", "write two that differ");
                return None;
            }
            let slope = (y - x) / (b - a);
            (slope, x - slope * a)
        }
        (None, None) => {
            let one = Quantity { number: 1.into(), unit: Unit::new(of) };
            let Some(factor) = one.in_unit(&Unit::new(unit)) else {
                let message = format!("the input is in {of}, and the channel in another unit");
                let help =
                    "say by `scale` what the ends are, as in { from = [\"0 V\", \"10 V\"], to = [0, 100] }";
                out.error(codes::SCALE, unit_place, message, help);
                return None;
            };
            (factor.as_f64(), 0.0)
        }
        (Some(node), None) | (None, Some(node)) => {
            let help =
                "`from` and `to` go together: two points of the input, and what the channel shows there";
            out.bad(codes::SCALE, node, "half a scale leads nowhere", help);
            return None;
        }
    };
    let mut limit = |key: &str| match fields.get(key) {
        None => Some(None),
        Some(node) => Some(Some(number::quantity(node, of, out)? / each)),
    };
    let (open_below, short_above) = (limit("open-below")?, limit("short-above")?);
    let deadband = match fields.get("deadband") {
        None => 0.0,
        Some(node) => {
            let deadband = number::quantity(node, unit, out)?;
            if deadband < 0.0 {
                out.bad(codes::SCALE, node, "a deadband is a width", "write a number of at least 0");
                return None;
            }
            deadband
        }
    };
    Some(Scale { gain: gain * each, offset, open_below, short_above, deadband, ..Scale::default() })
}

fn ohms(node: &Node, out: &mut Findings) -> Option<f64> {
    let ohms = number::quantity(node, "Ohm", out)?;
    if ohms <= 0.0 {
        out.bad(codes::SCALE, node, "no current shows on such a shunt", "write its resistance, above 0");
    }
    (ohms > 0.0).then_some(ohms)
}

/// A list of two quantities.
fn two(node: &Node, unit: &str, code: &'static str, out: &mut Findings) -> Option<(f64, f64)> {
    let list = match &node.data {
        Data::Array(list) => &list[..],
        _ => &[],
    };
    let [first, second] = list else {
        out.bad(code, node, "two values are expected here", "write [ first, second ]");
        return None;
    };
    Some((number::quantity(first, unit, out)?, number::quantity(second, unit, out)?))
}

/// Points and certificate of a calibration.
fn calibration(
    node: &Node,
    fields: &Fields,
    unit: &str,
    out: &mut Findings,
) -> Option<(Vec<Point>, Certificate)> {
    let mut points: Vec<Point> = Vec::new();
    for node in fields.each("points") {
        let (shown, truly) = two(node, unit, codes::CALIBRATION, out)?;
        if points.last().is_some_and(|last| last.shown >= shown || last.truly >= truly) {
            let help = "sort the points by what was shown; what it truly was has to rise with it";
            out.bad(codes::CALIBRATION, node, "this point does not lie above the one before", help);
            return None;
        }
        points.push(Point { shown, truly });
    }
    if points.is_empty() {
        out.bad(
            codes::CALIBRATION,
            node,
            "a calibration without points",
            "write [shown, true] at least once",
        );
        return None;
    }
    let mut day = |key: &str| -> Option<Option<Date>> {
        let Some(node) = fields.get(key) else { return Some(None) };
        let read = node.as_text().and_then(Date::parse);
        if read.is_none() {
            out.bad(codes::CALIBRATION, node, "there is no such day", "write it as in \"2026-01-31\"");
        }
        Some(Some(read?))
    };
    let (date, expires) = (day("date")?, day("expires")?);
    if let (Some(date), Some(last), Some(node)) = (date, expires, fields.get("expires"))
        && last < date
    {
        let help = "`date` is the day of the calibration, `expires` the last on which it counts";
        out.bad(codes::CALIBRATION, node, "it expired before it was made", help);
        return None;
    }
    let text = |key| fields.text(key).map(str::to_owned);
    Some((points, Certificate { date, expires, by: text("by"), number: text("certificate") }))
}
