//! The tables of keys of the manual beside the tables of keys that the readers check by.

use serde_json::Value as Json;
use std::collections::{BTreeMap, BTreeSet};

use document::schema::{Grammar, schema};
use runtime::suite::instrument_file;

use crate::manual::markdown::{Table, code, page, pages};

/// A file with a schema.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Format {
    Plan,
    Suite,
    Instrument,
    Board,
}
use Format::{Board, Instrument, Plan, Suite};

/// A table of a page, by its heading and the first cell of its header, and the tables of the schema whose keys it has: names
/// of keys with dots between them, `*` for each entry of a table or list.
type Said = (&'static str, &'static str, &'static str, Format, &'static [&'static str]);

const TABLES: &[Said] = &[
    ("boards/can", "CAN buses", "key of a bus", Board, &["buses.*"]),
    ("boards/converters", "Converters", "key of a converter", Board, &["converters.*"]),
    ("boards/converters", "Converters", "key of a channel", Board, &["channels.*"]),
    (
        "boards/converters",
        "Converters with a driver of the kernel",
        "key of a converter",
        Board,
        &["converters.*"],
    ),
    ("boards/counters", "Counters", "key of a counter", Board, &["counters.*"]),
    ("boards/counters", "Counters", "key of a channel", Board, &["channels.*"]),
    ("boards/fault-relays", "Faults on real wires", "key of a channel", Board, &["fault-relays.*"]),
    ("boards/file", "The file", "key", Board, &[""]),
    ("boards/file", "subject", "key", Board, &["subject"]),
    ("boards/file", "channels", "key", Board, &["channels.*"]),
    ("boards/file", "wires", "key", Board, &["wires.*"]),
    ("boards/plants", "lag", "key", Board, &["plants.*"]),
    ("boards/plants", "second-order", "key", Board, &["plants.*"]),
    ("boards/plants", "tank", "key", Board, &["plants.*"]),
    ("boards/plants", "tank", "key of a flow", Board, &["plants.*.inflows.*", "plants.*.outflows.*"]),
    ("boards/plants", "transmitter", "key", Board, &["plants.*"]),
    ("boards/plants", "dead-time", "key", Board, &["plants.*"]),
    ("boards/plants", "heater", "key", Board, &["plants.*"]),
    ("boards/plants", "valve and cylinder", "key", Board, &["plants.*"]),
    ("boards/plants", "motor", "key", Board, &["plants.*"]),
    ("boards/plants", "conveyor", "key", Board, &["plants.*"]),
    ("boards/plants", "program", "key", Board, &["plants.*"]),
    ("boards/file", "control", "key", Board, &["control"]),
    ("boards/generators", "Generators", "key of a generator", Board, &["generators.*"]),
    ("boards/generators", "Generators", "key of a channel", Board, &["channels.*"]),
    ("boards/gpio", "GPIO lines", "key of a channel", Board, &["channels.*"]),
    ("boards/gpio", "GPIO lines", "key of a chip", Board, &["chips.*"]),
    ("boards/real", "board", "key", Board, &["board"]),
    ("boards/real", "Delays of channels", "key of a channel", Board, &["channels.*"]),
    ("boards/real", "guard", "key", Board, &["guard"]),
    ("boards/real", "realtime", "key", Board, &["realtime"]),
    ("boards/serial", "Serial lines", "key of a bus", Board, &["buses.*"]),
    ("boards/serial", "Serial lines", "key of `rs485`", Board, &["buses.*.rs485"]),
    ("boards/simulated", "faults", "key", Board, &["faults"]),
    ("boards/simulated", "buses of a simulated board", "key of a bus", Board, &["buses.*"]),
    ("boards/simulated", "serial lines of a simulated board", "key", Board, &["buses.*"]),
    ("boards/simulated", "counts of a simulated board", "key of a channel", Board, &["channels.*"]),
    ("plans/cases", "Cases that are refused", "key", Plan, &["refused", "warned"]),
    (
        "plans/expectations",
        "Expectations",
        "key",
        Plan,
        &["expect.*.stays", "expect.*.becomes", "expect.*.value"],
    ),
    ("plans/file", "The file", "key", Plan, &[""]),
    ("plans/frames", "Frames", "key", Plan, &["frames.*"]),
    ("plans/frames", "Frames that are sent", "key", Plan, &["steps.*.send"]),
    ("plans/invariants", "Alarms", "key", Plan, &["alarms.*"]),
    ("plans/invariants", "Suite files", "key", Suite, &[""]),
    ("terminal", "What an instrument may be off", "key of `[timebase]`", Instrument, &["timebase"]),
    ("terminal", "What an instrument may be off", "key of a channel", Instrument, &["channels.*"]),
    ("plans/measurements", "Measurements", "key", Plan, &["measure.*"]),
    ("plans/pulses", "profile", "key", Plan, &["expect.*.profile"]),
    ("plans/pulses", "profile", "key of `move`", Plan, &["expect.*.profile.move"]),
    ("plans/settings", "Settings", "key", Plan, &["settings"]),
    ("plans/settings", "Settings", "key of an input", Plan, &["settings.inputs.*"]),
    ("plans/settings", "Settings", "key of a task", Plan, &["settings.mast", "settings.tasks.*"]),
    ("plans/settings", "Expert functions", "key", Plan, &["settings.expert.*"]),
    ("plans/settings", "Expansion modules", "key", Plan, &["settings.modules.*"]),
    (
        "plans/settings",
        "Expansion modules",
        "key of a channel",
        Plan,
        &["settings.modules.*.inputs.*", "settings.modules.*.outputs.*"],
    ),
    ("plans/signals", "Signals", "key", Plan, &["signals.*"]),
    ("plans/signals", "Recording", "key", Plan, &["signals.*"]),
    ("plans/steps", "Questions", "key", Plan, &["steps.*.ask"]),
    ("plans/steps", "Steps", "key", Plan, &["steps.*"]),
    ("plans/steps", "When a step comes", "key", Plan, &["steps.*.when"]),
    ("plans/stimuli", "Encoders", "key", Plan, &["steps.*.encoder", "steps.*.encoder.moves.*"]),
    ("plans/stimuli", "Sequences", "key", Plan, &["steps.*.sequence"]),
    ("plans/stimuli", "Stimuli", "verb", Plan, &["steps.*"]),
    (
        "plans/stimuli",
        "Waves",
        "key",
        Plan,
        &["steps.*.ramp", "steps.*.sine", "steps.*.triangle", "steps.*.square", "steps.*.noise"],
    ),
];

/// Whether a key may have this number by its type alone: nothing that a user comes near.
fn is_of_the_type(number: i64) -> bool {
    [255, 65_535].contains(&number) || number.abs() > 100_000_000
}

struct Schemas {
    plan: Json,
    suite: Json,
    instrument: Json,
    board: Json,
}

impl Schemas {
    fn new() -> Schemas {
        let board = plans::schema::board(drivers::file::KEYS);
        let instrument = schema("", "", instrument_file::KEYS, &Grammar::default());
        Schemas { plan: plans::schema::plan(), suite: plans::schema::suite(), instrument, board }
    }

    fn of(&self, format: Format) -> &Json {
        match format {
            Plan => &self.plan,
            Suite => &self.suite,
            Instrument => &self.instrument,
            Board => &self.board,
        }
    }

    /// The keys of a table of the schema, each with what it may be.
    fn keys(&self, format: Format, path: &str) -> BTreeMap<String, Json> {
        let root = self.of(format);
        let mut found = forms(root, root);
        for part in path.split('.').filter(|part| !part.is_empty()) {
            let next: Vec<Json> = found.iter().flat_map(|form| entries(form, part)).collect();
            found = next.iter().flat_map(|form| forms(root, form)).collect();
        }
        let tables = found.iter().filter_map(|form| form["properties"].as_object());
        tables.flatten().map(|(name, value)| (name.clone(), value.clone())).collect()
    }
}

/// What a table or list of the schema has below a key; below `*`, what each of its entries is.
fn entries(form: &Json, part: &str) -> Vec<Json> {
    let below = match part {
        "*" => [form.get("items"), form.get("additionalProperties")],
        key => [form["properties"].get(key), None],
    };
    below.into_iter().flatten().cloned().collect()
}

/// What a part of a schema may be: itself, what it refers to, and its alternatives.
fn forms(root: &Json, part: &Json) -> Vec<Json> {
    let mut all = vec![part.clone()];
    if let Some(name) = part["$ref"].as_str().and_then(|path| path.rsplit('/').next()) {
        all.extend(forms(root, &root["definitions"][name]));
    }
    for several in ["anyOf", "allOf"] {
        let parts = part[several].as_array().into_iter().flatten();
        all.extend(parts.flat_map(|part| forms(root, part)));
    }
    all
}

/// The table of a page that an entry speaks of.
fn table(said: &Said) -> Table {
    let tables = page(said.0).tables();
    let found = tables.into_iter().find(|table| table.heading == said.1 && table.header == said.2);
    found.unwrap_or_else(|| {
        panic!("docs/{}.md has no table below `{}` that begins with `{}`", said.0, said.1, said.2)
    })
}

/// A row without the blanks and underlines within its numbers.
fn plain(row: &str) -> String {
    let chars: Vec<char> = row.chars().collect();
    let digit = |at: usize| chars.get(at).is_some_and(char::is_ascii_digit);
    let kept = chars.iter().enumerate().filter(|(at, char)| {
        !(matches!(char, ' ' | '_') && *at > 0 && digit(at - 1) && (1..=3).all(|next| digit(at + next)))
    });
    kept.map(|(_, char)| *char).collect()
}

/// What a row has to say of a key and does not.
fn unsaid(root: &Json, spec: &Json, row: &str) -> Vec<String> {
    let mut unsaid = Vec::new();
    for form in forms(root, spec) {
        let words = form["enum"].as_array().into_iter().flatten().filter_map(Json::as_str);
        unsaid.extend(words.filter(|word| !row.contains(word)).map(str::to_owned));
        for limit in ["minimum", "maximum"] {
            let Some(number) = form[limit].as_i64().filter(|number| !is_of_the_type(*number)) else {
                continue;
            };
            // That there is one of something, or none, goes without saying.
            if ![0, 1].contains(&number) && !plain(row).contains(&number.abs().to_string()) {
                unsaid.push(number.to_string());
            }
        }
    }
    unsaid
}

#[test]
fn the_keys_of_the_manual_are_those_of_the_readers() {
    let schemas = Schemas::new();
    let mut wrong = Vec::new();
    let mut said: BTreeMap<(Format, &str), BTreeSet<String>> = BTreeMap::new();
    // What a key may be, several rows and several tables may say together.
    let mut rows: BTreeMap<(Format, &[&str], String), (String, String)> = BTreeMap::new();
    for entry in TABLES {
        let (_, _, _, format, paths) = *entry;
        for row in table(entry).rows {
            for name in row.names {
                for path in paths {
                    said.entry((format, path)).or_default().insert(name.clone());
                }
                let (place, text) = rows.entry((format, paths, name)).or_default();
                row.place.clone_into(place);
                text.push_str(&row.rest);
            }
        }
    }
    for ((format, paths, name), (place, text)) in &rows {
        let keys: BTreeMap<_, _> = paths.iter().flat_map(|path| schemas.keys(*format, path)).collect();
        match keys.get(name) {
            None => wrong.push(format!("docs/{place}: {paths:?} has no key `{name}`")),
            Some(spec) => {
                let unsaid = unsaid(schemas.of(*format), spec, text).into_iter();
                wrong.extend(unsaid.map(|word| format!("docs/{place}: `{name}` lacks {word}")));
            }
        }
    }
    for ((format, path), said) in &said {
        // The verbs of expectations have a section each, beside the keys that they share.
        if path.starts_with("expect.*") && !path.contains("profile") {
            continue;
        }
        for name in schemas.keys(*format, path).keys().filter(|name| !said.contains(*name)) {
            wrong.push(format!("no table has the key `{name}` of {path} of {format:?}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_table_of_keys_is_compared() {
    let compared = |page: &str, table: &Table| {
        let mut entries = TABLES.iter();
        entries
            .any(|entry| (entry.0, entry.1, entry.2) == (page, table.heading.as_str(), table.header.as_str()))
    };
    let mut left_out = Vec::new();
    for page in ["plans", "boards"].into_iter().flat_map(pages) {
        for table in page.tables() {
            if table.header.starts_with("key") && !compared(&page.name, &table) {
                left_out.push(format!("docs/{}.md: {}, {}", page.name, table.heading, table.header));
            }
        }
    }
    assert!(left_out.is_empty(), "{left_out:?}");
}

// Of what there are kinds: each of them stands in the pages that say what it is.
#[test]
fn every_kind_is_on_a_page() {
    let schemas = Schemas::new();
    let mut missing = Vec::new();
    for (format, path, folder) in [
        (Board, "channels.*", "boards"),
        (Board, "converters.*", "boards"),
        (Board, "generators.*", "boards"),
        (Board, "buses.*", "boards"),
        (Board, "plants.*", "boards"),
        (Plan, "settings.expert.*", "plans"),
        (Plan, "steps.*.fault", "plans"),
    ] {
        let text: String = pages(folder).iter().map(|page| page.sentences()).collect();
        let kind = &schemas.keys(format, path)["kind"];
        let words = forms(schemas.of(format), kind);
        let words: Vec<&str> = words
            .iter()
            .filter_map(|form| form["enum"].as_array())
            .flatten()
            .filter_map(Json::as_str)
            .collect();
        assert!(!words.is_empty(), "{path}");
        let stands = |word: &&str| {
            code(&text).any(|code| code.trim_matches('"') == *word || code.contains(&format!("\"{word}\"")))
        };
        missing.extend(words.into_iter().filter(|word| !stands(word)).map(|word| format!("{path}: {word}")));
    }
    assert!(missing.is_empty(), "{missing:?}");
}

#[test]
fn numbers_are_compared_as_they_are_meant() {
    assert_eq!(plain("2 to 1 000 000, 65_536 and 3 of 40"), "2 to 1000000, 65536 and 3 of 40");
}
