//! The counters of a board file, and the channels behind which they count.

use std::path::PathBuf;
use std::sync::Arc;

use document::{Data, Diagnostic, Entry, Fields, Findings, KeySpec, KeyType, Node, suggest};
use signal::Span;

use super::{Bench, DeviceReader, channels, codes, number};
use crate::ChannelId;
use crate::circuit::TallySpec;
use crate::counter::{CountSpec, CounterSpec, CountersSpec, EVENTS, FindCount, FindCounter};
use crate::counting::{CountEdge, CountFunction};

/// Counters.
pub(super) const READER: DeviceReader = DeviceReader {
    tables: &["counters"],
    channel_keys: OF_COUNT,
    bus_kind: None,
    read: |fields, bench, out| Some(Arc::new(counters(fields, bench, out))),
};

/// What a counter makes of its signals.
pub(in crate::file) const FUNCTION: KeyType = KeyType::Choice(&[
    "increase",
    "decrease",
    "pulse-direction",
    "quadrature-x1",
    "quadrature-x1-b",
    "quadrature-x2",
    "quadrature-x2-b",
    "quadrature-x4",
]);

/// The edge that counts.
pub(in crate::file) const EDGE: KeyType = KeyType::Choice(&["rising", "falling", "both"]);

/// The keys of a counter.
pub(in crate::file) const KEYS: &[KeySpec] = &[
    KeySpec::optional("name", KeyType::Text, "What the kernel's driver calls it, as in \"ti-eqep\""),
    KeySpec::optional("path", KeyType::Text, "Its place in /dev or /sys, as in \"/dev/counter0\""),
    KeySpec::optional(
        "count",
        KeyType::Either(&[KeyType::Integer(0, 255), KeyType::Text]),
        "Which of its counts: the number, or the name; 0 if left out",
    ),
    KeySpec::optional("function", FUNCTION, "What it makes of its signals; as it is if left out"),
    KeySpec::optional("edge", EDGE, "The edge of its first signal that it counts; as it is if left out"),
    KeySpec::optional(
        "ceiling",
        KeyType::Integer(1, i64::MAX),
        "The highest number that it shows; as it is if left out",
    ),
    KeySpec::optional("period", KeyType::Duration, "Time between two readings; \"10 ms\""),
    KeySpec::optional(
        "counts-up-to",
        KeyType::Quantity,
        "The most counts a second, as in \"2 MHz\": a count that moves faster is reported as a loss",
    ),
    KeySpec::optional(
        "events",
        KeyType::List(&KeyType::Choice(&[
            "overflow",
            "underflow",
            "overflow-underflow",
            "threshold",
            "index",
            "change-of-state",
            "capture",
        ])),
        "What it reports by itself, with the kernel's stamps; nothing if left out",
    ),
    KeySpec::optional(
        "buffer",
        KeyType::Integer(16, 65_536),
        "Events that the kernel keeps; 1024 if left out",
    ),
];

/// How often a counter is read where the file does not say.
const PERIOD: Span = Span::from_millis(10);
/// Events that the kernel keeps, where the file does not say.
const BUFFER: u32 = 1_024;

/// Keys that only counts have, of real boards and of simulated ones.
const OF_COUNT: &[&str] = &["counter"];
const OF_TALLY: &[&str] = &["of", "function", "edge"];
/// Those of a channel that a count of a real board has.
const KNOWN: &[&str] = &["kind", "counter", "drives", "senses", "of", "function", "edge"];

/// The counters of a file whose channels were read. What is wrong with them is reported.
fn counters(fields: &Fields, bench: &mut Bench, out: &mut Findings) -> CountersSpec {
    let mut spec = CountersSpec::default();
    let table = fields.get("counters").and_then(Node::as_table);
    // Of those that are wrong the names count all the same: each is reported once.
    let mut wrong = Vec::new();
    for entry in table.map_or(&[][..], |table| &table.entries) {
        let Some(table) = entry.node.as_table() else { continue };
        match counter(entry, &Fields::checked(table, KEYS), out) {
            Some(counter) => spec.counters.push(counter),
            None => wrong.push(entry.key.as_str()),
        }
    }
    one_each(&spec.counters, out);
    for (entry, fields) in channels(fields) {
        let Some(channel) = bench.file.find(&entry.key) else { continue };
        if fields.text("kind") != Some("count") {
            foreign(&fields, &[OF_COUNT, OF_TALLY].concat(), out);
            continue;
        }
        for entry in OF_TALLY.iter().filter_map(|key| fields.entry(key)) {
            let message = format!("a count of a real board has no `{}`", entry.key);
            let help = "describe its counter under `counters`, and name that by `counter`";
            out.error(codes::OTHER_BOARD, entry.key_span.clone(), message, help);
        }
        for key in fields.table().entries.iter().filter(|key| !KNOWN.contains(&key.key.as_str())) {
            let message = format!("a count has no `{}`", key.key);
            out.error(
                codes::CHANNEL_PROPERTY,
                key.key_span.clone(),
                message,
                "remove it, or change the kind",
            );
        }
        if fields.boolean("drives") == Some(true) || fields.boolean("senses") == Some(false) {
            let help = "remove `drives` and `senses`: a count is reported, and nothing drives it";
            out.error(codes::CHANNEL_PROPERTY, entry.key_span.clone(), "a count cannot be driven", help);
        }
        let of = &mut bench.file.circuit.channels[usize::from(channel.0)];
        (of.drives, of.senses) = (false, true);
        let Some(counter) = find(entry, &fields, &spec.counters, &wrong, out) else { continue };
        if let Some(first) = spec.counts.iter().find(|count| count.counter == counter) {
            let found = Diagnostic::error(codes::COUNT_TWICE, "the counter has a channel already")
                .at(out.file().to_owned(), entry.key_span.clone(), "")
                .at(out.file().to_owned(), bench.place_of(usize::from(first.channel.0)), "here first")
                .help("keep one of the two: a plan can name one channel as often as it wants");
            out.push(found);
            continue;
        }
        spec.counts.push(CountSpec { channel, counter });
    }
    spec
}

/// Reports keys of counts on another kind of channel.
fn foreign(fields: &Fields, keys: &[&str], out: &mut Findings) {
    for entry in keys.iter().filter_map(|key| fields.entry(key)) {
        let message = format!("no channel but a count has `{}`", entry.key);
        out.error(codes::CHANNEL_PROPERTY, entry.key_span.clone(), message, "remove it, or change the kind");
    }
}

/// The counts of a simulated board whose channels were read. What is wrong with them is reported.
pub(in crate::file) fn tallies(fields: &Fields, bench: &mut Bench, out: &mut Findings) {
    for (entry, fields) in channels(fields) {
        let Some(channel) = bench.file.find(&entry.key) else { continue };
        if fields.text("kind") != Some("count") {
            foreign(&fields, OF_TALLY, out);
            continue;
        }
        for key in fields.table().entries.iter().filter(|key| {
            let key = key.key.as_str();
            key != "kind" && !OF_TALLY.contains(&key) && !OF_COUNT.contains(&key)
        }) {
            let message = format!("a count has no `{}`", key.key);
            out.error(
                codes::CHANNEL_PROPERTY,
                key.key_span.clone(),
                message,
                "remove it, or change the kind",
            );
        }
        bench.file.circuit.tallies.extend(tally(entry, &fields, channel, bench, out));
    }
}

/// What a channel of a simulated board counts.
fn tally(
    entry: &Entry,
    fields: &Fields,
    channel: ChannelId,
    bench: &Bench,
    out: &mut Findings,
) -> Option<TallySpec> {
    let function = fields.text("function").and_then(CountFunction::named).unwrap_or(CountFunction::Increase);
    let single = matches!(function, CountFunction::Increase | CountFunction::Decrease);
    if let Some(edge) = fields.entry("edge").filter(|_| !single) {
        let help = "remove it: `edge` goes with \"increase\" and \"decrease\" alone";
        let message = "the function itself says which edges count";
        out.error(codes::COUNTER_VALUE, edge.key_span.clone(), message, help);
        return None;
    }
    let signals = fields.each("of");
    let (few, what) = if single { (1, "one line") } else { (2, "two lines, A and B") };
    if signals.len() != few {
        let message = format!("\"{}\" counts {what}", function.name());
        let help = match few {
            1 => "name it, as in of = [\"I0\"]",
            _ => "name them, as in of = [\"I0\", \"I1\"]",
        };
        out.error(codes::TALLY, entry.key_span.clone(), message, help);
        return None;
    }
    let lines: Vec<ChannelId> = signals.iter().filter_map(|node| bench.channel(node, out)).collect();
    let (a, b) = match lines[..] {
        [a] => (a, None),
        [a, b] => (a, Some(b)),
        _ => return None,
    };
    // A wrong name was reported.
    if lines.len() != signals.len() {
        return None;
    }
    let edge = match fields.text("edge") {
        Some("falling") => CountEdge::Falling,
        Some("both") => CountEdge::Both,
        _ => CountEdge::Rising,
    };
    Some(TallySpec { channel, a, b, function, edge })
}

/// One counter of the file.
fn counter(entry: &Entry, fields: &Fields, out: &mut Findings) -> Option<CounterSpec> {
    let find = match (fields.text("name"), fields.text("path")) {
        (Some(name), None) => FindCounter::Name(name.to_owned()),
        (None, Some(path)) => FindCounter::Path(PathBuf::from(path)),
        _ => {
            let message = format!("the counter `{}` needs one of `name` and `path`", entry.key);
            let help = "take `name`, which its driver gives it: `rig board scan` shows those of this machine";
            out.error(codes::FIND_COUNTER, entry.key_span.clone(), message, help);
            return None;
        }
    };
    let period = fields.duration("period").unwrap_or(PERIOD);
    if let Some(node) = fields.get("period").filter(|_| period <= Span::ZERO) {
        out.bad(codes::TIME, node, "no time lies between two readings", "write a duration above 0");
        return None;
    }
    let count = match fields.get("count").map(|node| &node.data) {
        Some(Data::Text(name)) => FindCount::Name(name.clone()),
        Some(Data::Integer(number)) => FindCount::Number(u8::try_from(*number).ok()?),
        _ => FindCount::Number(0),
    };
    let function = fields.text("function").and_then(CountFunction::named);
    let single = matches!(function, None | Some(CountFunction::Increase | CountFunction::Decrease));
    if let Some(edge) = fields.entry("edge").filter(|_| !single) {
        let help = "remove it: `edge` goes with \"increase\" and \"decrease\" alone";
        out.error(
            codes::COUNTER_VALUE,
            edge.key_span.clone(),
            "the function itself says which edges count",
            help,
        );
        return None;
    }
    let counts_hz = match fields.get("counts-up-to") {
        None => None,
        Some(node) => {
            let fastest = number::quantity(node, "Hz", out)?;
            if !(1.0..1e12).contains(&fastest) {
                let help = "write counts a second, as in \"200 kHz\"";
                out.bad(codes::COUNTER_VALUE, node, "no counter counts so fast, or so slowly", help);
                return None;
            }
            Some(fastest as u64)
        }
    };
    let mut events = Vec::new();
    for node in fields.each("events") {
        let named = node.as_text().and_then(|text| EVENTS.iter().find(|(name, _)| *name == text));
        // The table of keys has no others.
        let (name, kind) = named?;
        if events.contains(kind) {
            out.bad(
                codes::COUNTER_VALUE,
                node,
                format!("\"{name}\" stands there twice"),
                "remove one of them",
            );
            return None;
        }
        events.push(*kind);
    }
    if let Some(buffer) = fields.entry("buffer").filter(|_| events.is_empty()) {
        let help = "add `events`, or remove it";
        out.error(
            codes::COUNTER_VALUE,
            buffer.key_span.clone(),
            "a counter that reports nothing by itself has no `buffer`",
            help,
        );
        return None;
    }
    Some(CounterSpec {
        name: entry.key.clone(),
        place: entry.key_span.clone(),
        find,
        count,
        function,
        edge: match fields.text("edge") {
            Some("rising") => Some(CountEdge::Rising),
            Some("falling") => Some(CountEdge::Falling),
            Some(_) => Some(CountEdge::Both),
            None => None,
        },
        ceiling: fields.integer("ceiling").and_then(|ceiling| u64::try_from(ceiling).ok()),
        period,
        events,
        buffer: fields.integer("buffer").and_then(|buffer| u32::try_from(buffer).ok()).unwrap_or(BUFFER),
        counts_hz,
    })
}

/// Reports counts that two counters of the file name, and devices whose events two of them want: the kernel hands those of
/// one device to one reader.
fn one_each(counters: &[CounterSpec], out: &mut Findings) {
    for (at, later) in counters.iter().enumerate() {
        let meets = |first: &&CounterSpec| {
            first.find == later.find
                && (first.count == later.count || !(first.events.is_empty() || later.events.is_empty()))
        };
        if let Some(first) = counters[..at].iter().find(meets) {
            let message = match first.count == later.count {
                true => "the count is described already",
                false => "events of the device go to another of its counts already",
            };
            let found = Diagnostic::error(codes::COUNT_TWICE, message)
                .at(out.file().to_owned(), later.place.clone(), "")
                .at(out.file().to_owned(), first.place.clone(), "here first")
                .help("keep one of the two, or let one of them do without `events`");
            out.push(found);
        }
    }
}

/// The counter that a channel names, or the only one.
fn find(
    entry: &Entry,
    fields: &Fields,
    counters: &[CounterSpec],
    wrong: &[&str],
    out: &mut Findings,
) -> Option<usize> {
    let names = || counters.iter().map(|counter| counter.name.as_str());
    let listed = || names().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
    let Some(node) = fields.get("counter") else {
        if counters.len() + wrong.len() == 1 {
            return (!counters.is_empty()).then_some(0);
        }
        let message = format!("no device counts for `{}`", entry.key);
        let help = match counters {
            [] => String::from("describe it, as in: [counters] wheel = { path = \"/dev/counter0\" }"),
            _ => format!("add `counter`: {}", listed()),
        };
        out.error(codes::FIND_COUNTER, entry.key_span.clone(), message, help);
        return None;
    };
    let name = node.as_text()?;
    let found = names().position(|other| other == name);
    if found.is_none() && !wrong.contains(&name) {
        let help = match suggest(name, names()) {
            Some(meant) => format!("did you mean `{meant}`?"),
            None if counters.is_empty() => String::from("describe it under `counters`"),
            None => format!("the file's counters are {}", listed()),
        };
        out.bad(codes::FIND_COUNTER, node, format!("the file has no counter `{name}`"), help);
    }
    found
}
