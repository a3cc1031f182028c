//! `signals`: names and what they stand for.

use document::{Data, Fields, Findings, KeySpec, KeyType, Node, Table};
use signal::{Address, Area, Decimal, Size, Span, Value};

use super::{FileFigure, RecordingPolicy, RowFigure, SignalBinding, SignalSource, TaskFigure};
use crate::codes;
use crate::lang::{Literal, address, is_id, is_path};

const PATH: KeySpec = KeySpec::optional("path", KeyType::Text, "A variable, or a channel of the board.");
const ADDRESS: KeySpec = KeySpec::optional(
    "address",
    KeyType::Text,
    "The terminal of an input or output, as in %IX0.0, or a place of memory.",
);
const IMAGE: KeySpec = KeySpec::optional(
    "image",
    KeyType::Text,
    "An input or output as the program sees it: the bit of the process image.",
);
const CHANNEL: KeySpec = KeySpec::optional("channel", KeyType::Text, "A channel of the board.");
const TASK: KeySpec = KeySpec::optional("task", KeyType::Text, "A task, whose `figure` is meant.");
const FIGURE: KeySpec = KeySpec::optional(
    "figure",
    KeyType::Choice(FIGURES),
    "Which figure of the task, the file, the register or the row of the relocation table.",
);
const LOG: KeySpec =
    KeySpec::optional("log", KeyType::Text, "A text: how many entries of the controller's log hold it.");
const FILE: KeySpec =
    KeySpec::optional("file", KeyType::Text, "A file of the controller: whether it is there.");
const CONTAINS: KeySpec =
    KeySpec::optional("contains", KeyType::Text, "A text: whether the file contains it.").was("holds");
const REGISTER: KeySpec = KeySpec::optional(
    "register",
    KeyType::Integer(0, 65_535),
    "A register as a client in the network reads it.",
);
const RELOCATION: KeySpec =
    KeySpec::optional("relocation", KeyType::Text, "A row of the relocation table, whose `figure` is meant.");

/// Figures of what is no task.
const OTHER_FIGURES: &[&str] = &["size", "exception", "address", "length", "valid"];

/// Every figure.
const FIGURES: &[&str] = &figures();

/// [`TaskFigure::NAMES`] and after them [`OTHER_FIGURES`]; `lost` is a figure of tasks and of files.
const fn figures() -> [&'static str; TaskFigure::NAMES.len() + OTHER_FIGURES.len()] {
    let mut all = [""; TaskFigure::NAMES.len() + OTHER_FIGURES.len()];
    let mut place = 0;
    while place < all.len() {
        let tasks = TaskFigure::NAMES.len();
        all[place] = if place < tasks { TaskFigure::NAMES[place] } else { OTHER_FIGURES[place - tasks] };
        place += 1;
    }
    all
}
pub(crate) const DEADBAND: KeySpec = KeySpec::optional(
    "deadband",
    KeyType::Quantity,
    "Only changes by more than this are recorded: a number above 0 in the signal's unit.",
);
pub(crate) const AT_MOST_EVERY: KeySpec =
    KeySpec::optional("at-most-every", KeyType::Duration, "At most one value is recorded in this time.");

pub(crate) const RECORD: KeySpec =
    KeySpec::optional("record", KeyType::Bool, "It is bound to be recorded, even if nothing speaks of it.");

/// What names a signal.
pub(crate) const SOURCE_KEYS: &[KeySpec] =
    &[PATH, ADDRESS, IMAGE, CHANNEL, TASK, FIGURE, LOG, FILE, CONTAINS, REGISTER, RELOCATION];

/// What names a signal that is bound, and how it is recorded.
const BINDING_KEYS: &[KeySpec] = &[
    PATH,
    ADDRESS,
    IMAGE,
    CHANNEL,
    TASK,
    FIGURE,
    LOG,
    FILE,
    CONTAINS,
    REGISTER,
    RELOCATION,
    DEADBAND,
    AT_MOST_EVERY,
    RECORD,
];

/// What a name can stand for.
pub(crate) const SIGNAL_TYPE: KeyType = KeyType::Either(&[KeyType::Text, KeyType::Table(BINDING_KEYS)]);

/// Names that the trace has by itself.
pub(crate) const BUILT_IN: &[&str] = &["state"];

/// Reads the bindings of a plan whose table was held against its keys.
pub(crate) fn read(table: &Table, out: &mut Findings) -> Vec<SignalBinding> {
    let mut list = Vec::with_capacity(table.entries.len());
    for entry in &table.entries {
        let (name, place) = (&entry.key, entry.key_span.clone());
        if BUILT_IN.contains(&name.as_str()) {
            let message = format!("`{name}` is built in and cannot be bound");
            out.error(codes::NAME_TWICE, place, message, "take another name");
            continue;
        }
        if !is_id(name) && !is_path(name) {
            let help = "a name has letters, digits and `_`, and begins with a letter";
            out.error(codes::SIGNAL, place, format!("`{name}` cannot be the name of a signal"), help);
            continue;
        }
        if let Some((source, recording)) = binding(&entry.node, out) {
            let written = entry.node.as_table().and_then(|table| table.get("record"));
            let record = written.is_some_and(|node| node.data == Data::Bool(true));
            list.push(SignalBinding {
                name: name.clone(),
                source,
                recording,
                record,
                file: None,
                span: place,
            });
        }
    }
    list
}

/// What a text or table binds a name to; reports what is wrong with it.
fn binding(node: &Node, out: &mut Findings) -> Option<(SignalSource, RecordingPolicy)> {
    if let Some(text) = node.as_text() {
        return Some((text_source(node, text, out)?, RecordingPolicy::Changes));
    }
    let fields = fields(node, BINDING_KEYS, out)?;
    let (source, recording) = (table_source(node, &fields, out), recording(&fields, out));
    Some((source?, recording?))
}

/// What a text or table stands for; reports what is wrong with it.
pub(crate) fn source(node: &Node, out: &mut Findings) -> Option<SignalSource> {
    match node.as_text() {
        Some(text) => text_source(node, text, out),
        None => table_source(node, &fields(node, SOURCE_KEYS, out)?, out),
    }
}

/// The fields of a table in which nothing is wrong.
fn fields<'n>(node: &'n Node, keys: &'static [KeySpec], out: &mut Findings) -> Option<Fields<'n>> {
    let Some(table) = node.as_table() else {
        let help = "as in \"%QX0.4\", \"MAIN.n\" or { image = \"%IX0.0\" }";
        out.bad(codes::WRONG_TYPE, node, format!("a signal is no {}", &node.kind()[2..]), help);
        return None;
    };
    let before = out.errors();
    let fields = Fields::check(table, node.span.clone(), "signal", keys, out);
    (out.errors() == before).then_some(fields)
}

/// What a table stands for.
fn table_source(node: &Node, fields: &Fields<'_>, out: &mut Findings) -> Option<SignalSource> {
    let given: Vec<&str> = SOURCE_KEYS.iter().map(|key| key.name).filter(|key| fields.has(key)).collect();
    match given.as_slice() {
        ["path"] => {
            let path = fields.get("path")?;
            let text = path.as_text()?.trim();
            if !is_path(text) {
                let help = match text.starts_with('%') {
                    true => format!("an address stands under `address`: {{ address = \"{text}\" }}"),
                    false => "write the name of a variable, as in \"MAIN.n\"".to_owned(),
                };
                out.bad(codes::SIGNAL, path, format!("`{text}` is no variable"), help);
                return None;
            }
            Some(SignalSource::Path(text.to_owned()))
        }
        ["address"] => {
            let place = fields.get("address")?;
            Some(addressed(address(place, place.as_text()?, out)?))
        }
        ["image"] => {
            let image = fields.get("image")?;
            let address = address(image, image.as_text()?, out)?;
            if address.area() == Area::Memory {
                let help = "memory has no image beside it: bind the address itself";
                out.bad(codes::ADDRESS, image, format!("{address} is no input or output"), help);
                return None;
            }
            Some(SignalSource::Image(address))
        }
        ["channel"] => Some(SignalSource::Channel(fields.text("channel")?.to_owned())),
        ["task", "figure"] => match TaskFigure::find(fields.text("figure")?) {
            Some(figure) => Some(SignalSource::Task { task: fields.text("task")?.to_owned(), figure }),
            None => no_figure("a task", TaskFigure::NAMES, fields, out),
        },
        ["log"] => Some(SignalSource::Log(fields.text("log")?.to_owned())),
        ["file", ..] | ["figure", "file", ..] => file_source(fields, out),
        ["register"] | ["figure", "register"] => {
            let register = fields.integer("register").and_then(|number| u16::try_from(number).ok())?;
            match fields.text("figure") {
                None => Some(SignalSource::Register { register, exception: false }),
                Some("exception") => Some(SignalSource::Register { register, exception: true }),
                Some(_) => no_figure("a register", &["exception"], fields, out),
            }
        }
        ["figure", "relocation"] => {
            let figure = match fields.text("figure")? {
                "address" => RowFigure::Address,
                "length" => RowFigure::Length,
                "valid" => RowFigure::Valid,
                _ => {
                    let known = &["address", "length", "valid"];
                    return no_figure("a row of the relocation table", known, fields, out);
                }
            };
            Some(SignalSource::Relocation { row: fields.text("relocation")?.to_owned(), figure })
        }
        several => {
            let message = match several {
                [] => "the table names no signal",
                ["task"] => "the table names no figure of the task",
                ["relocation"] => "the table names no figure of the row",
                ["figure"] => "the table names no task",
                _ => "the table names several signals",
            };
            let help = "as in { path = \"MAIN.n\" }, { address = \"%MW10\" }, { image = \"%IX0.0\" }, \
                        { channel = \"temperature\" } or { task = \"MAST\", figure = \"max-cycle\" }";
            out.bad(codes::SIGNAL, node, message, help);
            None
        }
    }
}

/// A file and what of it is asked.
fn file_source(fields: &Fields<'_>, out: &mut Findings) -> Option<SignalSource> {
    let node = fields.get("file")?;
    let path = node.as_text()?.to_owned();
    if !path.starts_with('/') {
        out.bad(
            codes::SIGNAL,
            node,
            format!("`{path}` is no path of a file"),
            "as in \"/usr/App/Application.app\"",
        );
        return None;
    }
    let asks = match (fields.text("contains"), fields.text("figure")) {
        (None, None) => FileFigure::Exists,
        (Some(text), None) => FileFigure::Holds(text.to_owned()),
        (None, Some("size")) => FileFigure::Size,
        (None, Some("lost")) => FileFigure::Lost,
        (None, Some(_)) => return no_figure("a file", &["size", "lost"], fields, out),
        (Some(_), Some(_)) => {
            out.bad(
                codes::SIGNAL,
                node,
                "the table names several signals",
                "leave `contains` or `figure` out",
            );
            return None;
        }
    };
    Some(SignalSource::File { path, asks })
}

/// Reports a figure that something else has.
fn no_figure(what: &str, known: &[&str], fields: &Fields<'_>, out: &mut Findings) -> Option<SignalSource> {
    let node = fields.get("figure")?;
    let figure = node.as_text().unwrap_or_default();
    let message = format!("{what} has no figure `{figure}`");
    out.bad(codes::SIGNAL, node, message, format!("it has {}", known.join(", ")));
    None
}

/// Which changes are recorded.
pub(crate) fn recording(fields: &Fields<'_>, out: &mut Findings) -> Option<RecordingPolicy> {
    match (fields.get("deadband"), fields.entry("at-most-every")) {
        (None, None) => Some(RecordingPolicy::Changes),
        (Some(_), Some(entry)) => {
            let message = "a signal is recorded with `deadband` or `at-most-every`, not both";
            let help = "remove one of them, or bind the signal under two names";
            out.error(codes::RECORDING, entry.key_span.clone(), message, help);
            None
        }
        (Some(node), None) => {
            let band = Literal::read(node, out)?;
            let above_0 = match &band {
                Literal::Value(Value::Bool(_)) | Literal::Label(_) => false,
                Literal::Value(value) => value.as_real().is_some_and(|number| number > 0.0),
                Literal::Measure { number, .. } => *number > Decimal::ZERO,
            };
            if !above_0 {
                let help = "without `deadband` every change is recorded";
                out.bad(codes::RECORDING, node, "a deadband is a number above 0", help);
                return None;
            }
            Some(RecordingPolicy::Deadband(band))
        }
        (None, Some(entry)) => {
            let span = fields.duration("at-most-every")?;
            if span == Span::ZERO {
                let help = "without `at-most-every` every change is recorded";
                out.bad(codes::RECORDING, &entry.node, "`at-most-every` is a duration above 0", help);
                return None;
            }
            Some(RecordingPolicy::AtMostEvery(span))
        }
    }
}

/// What a text stands for.
pub(crate) fn text_source(node: &Node, text: &str, out: &mut Findings) -> Option<SignalSource> {
    let text = text.trim();
    if text.starts_with('%') {
        return Some(addressed(address(node, text, out)?));
    }
    if is_path(text) {
        return Some(SignalSource::Path(text.to_owned()));
    }
    let help =
        "write an address such as \"%QX0.4\", a variable such as \"MAIN.n\", or the name of a bound signal";
    out.bad(codes::SIGNAL, node, format!("`{text}` cannot be a signal"), help);
    None
}

/// What an address stands for.
fn addressed(address: Address) -> SignalSource {
    let line = address.area() != Area::Memory && address.size() == Size::Bit;
    if line { SignalSource::Line(address) } else { SignalSource::Memory(address) }
}
