//! `frames`: names for frames of buses, and for values in them.
//!
//! ```toml
//! [frames]
//! heartbeat = { bus = "machine", id = 0x701, data = "05" }
//! status = { bus = "machine", id = 0x180, mask = 0x780 }
//! speed = { bus = "machine", dbc = "machine.dbc", message = "Engine", signal = "Speed" }
//! ```

use std::collections::BTreeMap;
use std::sync::Arc;

use document::{Fields, Findings, KeySpec, KeyType, Node, Table};

use super::read::{AT_MOST_EVERY, BUILT_IN, DEADBAND, RECORD, recording};
use super::{SignalBinding, SignalSource};
use crate::codes;
use crate::frames::DataPattern;
use crate::frames::can::{
    Databases, DbcDatabase, FieldSpec, FramePattern, FrameSender, FrameSignal, MAX_EXTENDED_ID, MAX_ID,
    MessageSpec,
};
use crate::lang::{is_id, is_path};

pub(crate) const BUS: KeySpec =
    KeySpec::optional("bus", KeyType::Text, "The bus, by its name in the board file.");
pub(crate) const ID: KeySpec =
    KeySpec::optional("id", KeyType::Integer(0, MAX_EXTENDED_ID as i64), "The identifier, as in 0x701.");
pub(crate) const EXTENDED: KeySpec = KeySpec::optional(
    "extended",
    KeyType::Bool,
    "The identifier has 29 bits; those above 0x7FF have if left out.",
);
pub(crate) const FD: KeySpec = KeySpec::optional(
    "fd",
    KeyType::Bool,
    "CAN FD frames are meant, or with `false` classic ones; both if left out.",
);
pub(crate) const BRS: KeySpec =
    KeySpec::optional("brs", KeyType::Bool, "A CAN FD frame that is sent has its data at the data bit rate.");
pub(crate) const REMOTE: KeySpec =
    KeySpec::optional("remote", KeyType::Bool, "Remote frames are meant, which ask for data.");
pub(crate) const DATA: KeySpec = KeySpec::optional(
    "data",
    KeyType::Text,
    "The data, as in \"05 .. *\": digits, a dot for any, `*` for any further bytes; any if left out.",
);
pub(crate) const DBC: KeySpec = KeySpec::optional("dbc", KeyType::Text, "A DBC file, relative to the plan.");
pub(crate) const MESSAGE: KeySpec =
    KeySpec::optional("message", KeyType::Text, "A message of the DBC file, in place of `id`.");

const FRAME_KEYS: &[KeySpec] = &[
    BUS,
    ID,
    KeySpec::optional(
        "mask",
        KeyType::Integer(0, MAX_EXTENDED_ID as i64),
        "Which bits of the identifier count, as in 0x780; all if left out.",
    ),
    EXTENDED,
    FD,
    BRS,
    REMOTE,
    DATA,
    KeySpec::optional(
        "from",
        KeyType::Choice(FrameSender::NAMES),
        "Who sent them: the rig on this bus, others, or any (if left out).",
    ),
    DBC,
    MESSAGE,
    KeySpec::optional(
        "signal",
        KeyType::Text,
        "A signal of the message: the name stands for its value, and not for the number of frames.",
    ),
    DEADBAND,
    AT_MOST_EVERY,
    RECORD,
];

/// An entry of `frames`.
pub(crate) const FRAME_TYPE: KeyType = KeyType::Table(FRAME_KEYS);

/// What a name of `frames` stands for.
#[derive(Clone, Debug)]
pub(crate) struct NamedFrame {
    /// The frames.
    pub(crate) pattern: FramePattern,
    /// Their message, where they have one.
    pub(crate) message: Option<Arc<MessageSpec>>,
}

/// What the table `frames` says.
#[derive(Debug, Default)]
pub(crate) struct PlanFrames {
    /// The names as signals.
    pub(crate) bindings: Vec<SignalBinding>,
    /// The names as frames.
    pub(crate) named: BTreeMap<String, NamedFrame>,
}

/// Reads the frames of a plan; `taken` says which names its signals have.
pub(crate) fn read(
    table: &Table,
    databases: &Databases,
    taken: &dyn Fn(&str) -> bool,
    out: &mut Findings,
) -> PlanFrames {
    let mut frames = PlanFrames::default();
    for entry in &table.entries {
        let (name, place) = (&entry.key, entry.key_span.clone());
        if BUILT_IN.contains(&name.as_str()) || taken(name) {
            let message = format!("`{name}` is the name of a signal already");
            out.error(codes::NAME_TWICE, place, message, "take another name");
            continue;
        }
        if !is_id(name) && !is_path(name) {
            let help = "a name has letters, digits and `_`, and begins with a letter";
            out.error(codes::FRAME, place, format!("`{name}` cannot be the name of a frame"), help);
            continue;
        }
        // Held against its keys with the plan.
        let Some(inner) = entry.node.as_table() else { continue };
        let fields = Fields::checked(inner, FRAME_KEYS);
        let (Some(named), Some(recording)) =
            (named(&entry.node, &fields, databases, out), recording(&fields, out))
        else {
            continue;
        };
        let Some(source) = source(&fields, &named, out) else { continue };
        frames.bindings.push(SignalBinding {
            name: name.clone(),
            source,
            recording,
            record: fields.boolean("record").unwrap_or(false),
            file: None,
            span: place,
        });
        frames.named.insert(name.clone(), named);
    }
    frames
}

/// The number of frames, or a value in them.
fn source(fields: &Fields<'_>, named: &NamedFrame, out: &mut Findings) -> Option<SignalSource> {
    let pattern = named.pattern.clone();
    let Some(node) = fields.get("signal") else {
        if fields.has("signal") {
            return None;
        }
        return Some(SignalSource::Frames(Arc::new(pattern)));
    };
    let Some(message) = &named.message else {
        let help = "name a `dbc` file and a `message` of it, or bind the frames without `signal`";
        out.bad(codes::FRAME, node, "a signal stands in a message of a DBC file", help);
        return None;
    };
    let field = field(message, node, out)?.clone();
    Some(SignalSource::FrameSignal(Arc::new(FrameSignal { pattern, field })))
}

/// The signal of a message; reports one that it does not have.
pub(crate) fn field<'m>(message: &'m MessageSpec, node: &Node, out: &mut Findings) -> Option<&'m FieldSpec> {
    let name = node.as_text()?;
    let found = message.field(name);
    if found.is_none() {
        let help = unknown(name, message.fields.iter().map(|field| field.name.as_str()));
        let text = format!("the message `{}` has no signal `{name}`", message.name);
        out.bad(codes::DBC_NAME, node, text, help);
    }
    found
}

/// What may have been meant by a name.
pub(crate) fn unknown<'a>(name: &str, known: impl Iterator<Item = &'a str> + Clone) -> String {
    match document::suggest(name, known.clone()) {
        Some(meant) => format!("did you mean `{meant}`?"),
        None => {
            let few: Vec<&str> = known.take(10).collect();
            if few.is_empty() {
                String::from("there are none")
            } else {
                format!("there are {}", few.join(", "))
            }
        }
    }
}

/// The frames that a table describes.
pub(crate) fn named(
    node: &Node,
    fields: &Fields<'_>,
    databases: &Databases,
    out: &mut Findings,
) -> Option<NamedFrame> {
    let Some(bus) = fields.text("bus") else {
        if !fields.has("bus") {
            let help = "add bus = \"...\", a name of the board file's `buses`";
            out.bad(codes::FRAME, node, "no bus is named", help);
        }
        return None;
    };
    let message = match fields.get("dbc") {
        Some(file) => Some(message(file, fields, databases, out)?),
        None if fields.has("dbc") => return None,
        None => None,
    };
    if let (None, Some(node)) = (&message, fields.get("message")) {
        out.bad(codes::FRAME, node, "a message stands in a DBC file", "add dbc = \"...\"");
        return None;
    }
    let (id, extended) = match &message {
        Some(message) => {
            for key in ["id", "mask", "extended", "remote"] {
                if let Some(entry) = fields.entry(key) {
                    let text = format!("the message `{}` says what `{key}` is", message.name);
                    out.error(codes::FRAME, entry.key_span.clone(), text, "remove it, or name no message");
                    return None;
                }
            }
            (message.id, message.extended)
        }
        None => identifier(node, fields, out)?,
    };
    let mask = fields.integer("mask").and_then(|mask| u32::try_from(mask).ok()).unwrap_or(MAX_EXTENDED_ID);
    if let Some(node) = fields.get("mask").filter(|_| id & !mask & MAX_EXTENDED_ID != 0) {
        let text = format!("{id:#X} has bits that the mask {mask:#X} leaves out: they say nothing");
        out.bad(codes::FRAME_ID, node, text, "clear them in `id`, or set them in `mask`");
        return None;
    }
    let remote = fields.boolean("remote").unwrap_or(false);
    let fd = fields.boolean("fd").or_else(|| message.as_ref().filter(|one| one.size > 8).map(|_| true));
    if let Some(entry) = fields.entry("data").or_else(|| fields.entry("fd")).filter(|_| remote)
        && (entry.key == "data" || fd == Some(true))
    {
        let text = format!("a remote frame has no `{}`", entry.key);
        out.error(codes::FRAME, entry.key_span.clone(), text, "remove one of the two");
        return None;
    }
    let data = match fields.get("data") {
        Some(node) => data(node, out)?,
        None if fields.has("data") => return None,
        None => DataPattern::ANY,
    };
    if let Some(node) = fields.get("data").filter(|_| data.least() > 8 && fd == Some(false)) {
        let help = "write fd = true, or leave it out";
        out.bad(codes::FRAME, node, "a classic frame has at most 8 bytes", help);
        return None;
    }
    let length = message.as_ref().and_then(|message| u8::try_from(message.size).ok());
    let pattern = FramePattern {
        bus: bus.to_owned(),
        id,
        mask,
        extended,
        remote,
        fd,
        data,
        from: fields.text("from").and_then(FrameSender::find).unwrap_or_default(),
        brs: fields.boolean("brs").unwrap_or(false),
        message: message.as_ref().map(|message| message.name.clone()),
        length,
    };
    Some(NamedFrame { pattern, message })
}

/// The identifier that a table gives.
fn identifier(node: &Node, fields: &Fields<'_>, out: &mut Findings) -> Option<(u32, bool)> {
    let Some(id) = fields.integer("id") else {
        if !fields.has("id") {
            let help = "add id = 0x..., or a `dbc` file with a `message`";
            out.bad(codes::FRAME, node, "no identifier is given", help);
        }
        return None;
    };
    let id = u32::try_from(id).ok()?;
    let extended = fields.boolean("extended").unwrap_or(id > MAX_ID);
    if let Some(node) = fields.get("id").filter(|_| !extended && id > MAX_ID) {
        let text = format!("{id:#X} has more than 11 bits");
        out.bad(codes::FRAME_ID, node, text, "leave `extended` out, or take an identifier up to 0x7FF");
        return None;
    }
    Some((id, extended))
}

/// Data as they are written; reports what is wrong with them.
pub(crate) fn data(node: &Node, out: &mut Findings) -> Option<DataPattern> {
    let text = node.as_text()?;
    match DataPattern::parse(text) {
        Ok(pattern) => Some(pattern),
        Err((at, fault)) => {
            let end = text[at..].chars().next().map_or(at, |c| at + c.len_utf8());
            let message = format!("the data do not read: {fault}");
            out.bad_inside(codes::FRAME_DATA, node, Some(at..end), message, "as in \"01 2A .. *\"");
            None
        }
    }
}

/// The message that a table names.
fn message(
    file: &Node,
    fields: &Fields<'_>,
    databases: &Databases,
    out: &mut Findings,
) -> Option<Arc<MessageSpec>> {
    let base = database(file, databases, out)?;
    let Some(node) = fields.get("message") else {
        if !fields.has("message") {
            let help = unknown("", base.messages.keys().map(String::as_str));
            out.bad(codes::FRAME, file, "no message of the DBC file is named", help);
        }
        return None;
    };
    let name = node.as_text()?;
    let found = base.messages.get(name).cloned();
    if found.is_none() {
        let help = unknown(name, base.messages.keys().map(String::as_str));
        out.bad(codes::DBC_NAME, node, format!("the DBC file has no message `{name}`"), help);
    }
    found
}

/// The DBC file of a name; reports why there is none.
fn database(file: &Node, databases: &Databases, out: &mut Findings) -> Option<Arc<DbcDatabase>> {
    let name = file.as_text()?;
    match databases.get(name) {
        Some(Ok(base)) => Some(Arc::clone(base)),
        Some(Err(found)) => {
            for one in found {
                match one.labels.is_empty() {
                    true => {
                        let text = format!("`{name}` cannot be read: {}", one.message);
                        out.bad(
                            codes::DBC_FILE,
                            file,
                            text,
                            "name a file beside the plan, as in \"machine.dbc\"",
                        );
                    }
                    false => out.push(one.clone()),
                }
            }
            None
        }
        None => {
            let text = format!("`{name}` is no file of the plan that ends in `.dbc`");
            out.bad(codes::DBC_FILE, file, text, "name a file beside the plan, as in \"machine.dbc\"");
            None
        }
    }
}
