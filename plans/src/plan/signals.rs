//! `signals`: names and what they stand for.

use document::{Fields, Findings, KeySpec, KeyType, Node, Table};
use signal::{Address, Area, Size};

use super::{SignalBinding, Source, TaskFigure};
use crate::codes;
use crate::lang::{is_id, is_path};

const SOURCE_KEYS: &[KeySpec] = &[
    KeySpec::optional("image", KeyType::Text, "An input or output as the program sees it."),
    KeySpec::optional("channel", KeyType::Text, "A channel of the board."),
    KeySpec::optional("task", KeyType::Text, "A task, whose `figure` is meant."),
    KeySpec::optional("figure", KeyType::Choice(TaskFigure::NAMES), "Which figure of the task."),
];

/// What a name can stand for.
pub(super) const SIGNAL_TYPE: KeyType = KeyType::Either(&[KeyType::Text, KeyType::Table(SOURCE_KEYS)]);

/// Names that the trace has by itself.
pub(super) const BUILT_IN: &[&str] = &["state"];

/// Reads the bindings of a plan whose table was held against its keys.
pub(super) fn read(table: &Table, out: &mut Findings) -> Vec<SignalBinding> {
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
        if let Some(source) = source(&entry.node, out) {
            list.push(SignalBinding { name: name.clone(), source, span: place });
        }
    }
    list
}

/// What a text or table stands for; reports what is wrong with it.
pub(super) fn source(node: &Node, out: &mut Findings) -> Option<Source> {
    if let Some(text) = node.as_text() {
        return text_source(node, text, out);
    }
    let Some(table) = node.as_table() else {
        let help = "as in \"%QX0.4\", \"MAIN.n\" or { image = \"%IX0.0\" }";
        out.bad(codes::WRONG_TYPE, node, format!("a signal is no {}", &node.kind()[2..]), help);
        return None;
    };
    let before = out.errors();
    let fields = Fields::check(table, node.span.clone(), "signal", SOURCE_KEYS, out);
    if out.errors() > before {
        return None;
    }
    match (fields.get("image"), fields.get("channel"), fields.get("task")) {
        (Some(image), None, None) if !fields.has("figure") => {
            let address = address(image, image.as_text()?, out)?;
            if address.area() == Area::Memory {
                let help = "memory has no image beside it: bind the address itself";
                out.bad(codes::ADDRESS, image, format!("{address} is no input or output"), help);
                return None;
            }
            Some(Source::Image(address))
        }
        (None, Some(channel), None) if !fields.has("figure") => {
            Some(Source::Channel(channel.as_text()?.to_owned()))
        }
        (None, None, Some(task)) if fields.has("figure") => Some(Source::Task {
            task: task.as_text()?.to_owned(),
            figure: TaskFigure::find(fields.text("figure")?)?,
        }),
        _ => {
            let help = "as in { image = \"%IX0.0\" }, { channel = \"temperature\" } or \
                        { task = \"MAST\", figure = \"max-cycle\" }";
            out.bad(codes::SIGNAL, node, "the table names no signal", help);
            None
        }
    }
}

/// What a text stands for.
pub(super) fn text_source(node: &Node, text: &str, out: &mut Findings) -> Option<Source> {
    let text = text.trim();
    if text.starts_with('%') {
        let address = address(node, text, out)?;
        let line = address.area() != Area::Memory && address.size() == Size::Bit;
        return Some(if line { Source::Line(address) } else { Source::Memory(address) });
    }
    if is_path(text) {
        return Some(Source::Path(text.to_owned()));
    }
    let help =
        "write an address such as \"%QX0.4\", a variable such as \"MAIN.n\", or the name of a bound signal";
    out.bad(codes::SIGNAL, node, format!("`{text}` cannot be a signal"), help);
    None
}

/// An address; reports what is wrong with it.
pub(super) fn address(node: &Node, text: &str, out: &mut Findings) -> Option<Address> {
    match Address::parse(text.trim()) {
        Ok(address) => Some(address),
        Err(error) => {
            let shift = text.len() - text.trim_start().len();
            let at = (shift + error.offset()).min(text.len());
            out.bad_inside(
                codes::ADDRESS,
                node,
                Some(at..text.trim_end().len().max(at)),
                error.to_string(),
                "",
            );
            None
        }
    }
}
