//! `send`: frames that the rig puts on a bus.
//!
//! ```toml
//! { id = "beat", at = "start + 1 s", send = { frame = "heartbeat", period = "100 ms", count = 50, jitter = "2 ms" } }
//! { id = "raw", at = "start + 2 s", send = { bus = "machine", id = 0x123, data = "01 02" } }
//! { id = "set", at = "start + 3 s", send = { frame = "engine", values = { Speed = "1500 rpm" } } }
//! ```

use std::collections::BTreeMap;
use std::fmt;

use document::{Fields, Findings, KeySpec, KeyType, Node};
use signal::{Random, SignalInfo, Span, ValueKind};

use super::drive::above_zero;
use super::{MAX_PULSES, StepNames, StepVerb, Stimulus, table_fields};
use crate::codes;
use crate::frames::can::{FieldSpec, FramePattern, MAX_EXTENDED_ID, MessageSpec};
use crate::lang::Literal;
use crate::signals::frames::{self, BRS, BUS, DATA, DBC, EXTENDED, FD, ID, MESSAGE, NamedFrame, REMOTE};
use crate::value_of;

const KEYS: &[KeySpec] = &[
    KeySpec::optional("frame", KeyType::Text, "A name of `frames`, in place of `bus` and `id`."),
    BUS,
    ID,
    EXTENDED,
    FD,
    BRS,
    REMOTE,
    DATA,
    KeySpec::optional(
        "length",
        KeyType::Integer(0, 8),
        "Of a remote frame: how many bytes it asks for; 0 if left out.",
    ),
    DBC,
    MESSAGE,
    KeySpec::optional(
        "values",
        KeyType::Map(&KeyType::Value),
        "Values of the message's signals; those that are left out have bits of 0.",
    ),
    KeySpec::optional("period", KeyType::Duration, "From one frame to the next, of several."),
    KeySpec::optional("count", KeyType::Integer(1, MAX_PULSES as i64), "How many frames; 1 if left out."),
    KeySpec::optional(
        "jitter",
        KeyType::Duration,
        "How far each frame may be moved to either side, drawn from the seed; less than half of the period.",
    ),
];

pub(super) const SEND: StepVerb = StepVerb {
    name: "send",
    doc: "Puts a frame, or several one after another, on a bus.",
    value: KeyType::Table(KEYS),
    needs: &[],
    read: read_send,
};

/// A frame that is sent.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OutFrame {
    /// The bus, by its name in the board file.
    pub bus: String,
    /// Its identifier.
    pub id: u32,
    /// Whether that has 29 bits.
    pub extended: bool,
    /// A remote frame.
    pub remote: bool,
    /// A CAN FD frame.
    pub fd: bool,
    /// Its data at the data bit rate.
    pub brs: bool,
    /// Number of data bytes; of a remote frame the number that it asks for.
    pub length: u8,
    /// Its data.
    pub data: Vec<u8>,
}

impl fmt::Display for OutFrame {
    /// `701#05`, as analyzers write it.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = if self.extended { 8 } else { 3 };
        write!(f, "{:0width$X}#", self.id)?;
        match self.remote {
            true => write!(f, "R{}", self.length),
            false => self.data.iter().try_for_each(|byte| write!(f, "{byte:02X}")),
        }
    }
}

/// Frames that a step sends.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SendFrames {
    /// Each of them.
    pub frame: OutFrame,
    /// The name of `frames`, where the plan gives one.
    pub name: Option<String>,
    /// From one to the next.
    pub period: Span,
    /// How many, from 1.
    pub count: u32,
    /// How far each may be moved to either side.
    pub jitter: Span,
}

impl SendFrames {
    /// When frame `n` from 0 comes after the beginning, without jitter.
    pub fn nominal(&self, n: u64) -> Span {
        let nanos = i128::from(self.period.as_nanos()) * i128::from(n);
        Span::from_nanos(i64::try_from(nanos).unwrap_or(i64::MAX))
    }

    /// The same with the jitter that this seed draws. None before the beginning.
    pub fn after(&self, n: u64, seed: u64) -> Span {
        let nominal = self.nominal(n);
        if self.jitter == Span::ZERO {
            return nominal;
        }
        // The jitter of a frame depends on its number alone.
        let mut random = Random::new(seed ^ (n + 1).wrapping_mul(0x9e37_79b9));
        let width = self.jitter.as_nanos().unsigned_abs() * 2 + 1;
        let moved = Span::from_nanos(i64::try_from(random.below(width)).unwrap_or(0)) - self.jitter;
        (nominal + moved).max(Span::ZERO)
    }

    /// From the step to its last frame.
    pub fn length(&self) -> Span {
        match self.count {
            1 => Span::ZERO,
            count => self.nominal(u64::from(count - 1)) + self.jitter,
        }
    }
}

fn read_send(node: &Node, scope: &dyn StepNames, out: &mut Findings) -> Option<Stimulus> {
    let fields = table_fields(node, KEYS)?;
    let (named, name) = described(node, &fields, scope, out)?;
    let frame = out_frame(node, &fields, &named, out)?;
    let count = fields.integer("count").map_or(1, |count| u32::try_from(count).unwrap_or(MAX_PULSES));
    let period = match (count, fields.has("period")) {
        (_, true) => above_zero(&fields, "period", out)?,
        (1, false) => Span::ZERO,
        (_, false) => {
            out.bad(codes::SEND, node, "several frames need a time between them", "add period = \"100 ms\"");
            return None;
        }
    };
    if let Some(entry) = fields.entry("period").filter(|_| !fields.has("count")) {
        let help = "add `count`, or let the step come again with `every`";
        out.error(codes::SEND, entry.key_span.clone(), "one frame has no period", help);
        return None;
    }
    let jitter = fields.duration("jitter").unwrap_or(Span::ZERO);
    if let Some(node) = fields.get("jitter").filter(|_| jitter.as_nanos() >= (period.as_nanos() + 1) / 2) {
        let help = "take less, so that frames keep their order";
        out.bad(codes::SEND, node, "the jitter is not less than half of the period", help);
        return None;
    }
    let send = SendFrames { frame, name, period, count, jitter };
    if send.length() == Span::MAX {
        out.bad(codes::SEND, node, "the frames last longer than there is time", "send fewer");
        return None;
    }
    Some(Stimulus::Send(Box::new(send)))
}

/// What frame is meant: one of `frames`, or one that the step describes.
fn described(
    node: &Node,
    fields: &Fields<'_>,
    scope: &dyn StepNames,
    out: &mut Findings,
) -> Option<(NamedFrame, Option<String>)> {
    let Some(place) = fields.get("frame") else {
        if fields.has("frame") {
            return None;
        }
        return Some((frames::named(node, fields, scope.databases(), out)?, None));
    };
    let name = place.as_text()?;
    if let Some(entry) =
        ["bus", "id", "extended", "fd", "remote", "dbc", "message"].iter().find_map(|key| fields.entry(key))
    {
        let text = format!("`{name}` says what `{}` is", entry.key);
        out.error(
            codes::SEND,
            entry.key_span.clone(),
            text,
            "remove it, or describe the frame without `frame`",
        );
        return None;
    }
    let Some(named) = scope.frame(name) else {
        let help = frames::unknown(name, scope.frame_names().into_iter());
        out.bad(codes::UNKNOWN_FRAME, place, format!("the plan has no frame `{name}`"), help);
        return None;
    };
    Some((named, Some(name.to_owned())))
}

/// The frame with its data.
fn out_frame(node: &Node, fields: &Fields<'_>, named: &NamedFrame, out: &mut Findings) -> Option<OutFrame> {
    let pattern = &named.pattern;
    let place = fields.get("frame").unwrap_or(node);
    if !pattern.is_one() {
        let text = format!("`{pattern}` stands for frames of several identifiers");
        out.bad(codes::SEND, place, text, "send one with an `id` of its own");
        return None;
    }
    if let Some(entry) = fields.entry("length").filter(|_| !pattern.remote) {
        let help = "the data say how long a frame is";
        out.error(codes::SEND, entry.key_span.clone(), "only a remote frame has a `length`", help);
        return None;
    }
    let data = if pattern.remote { Vec::new() } else { data(place, fields, named, out)? };
    let fd = pattern.fd.unwrap_or(data.len() > 8 || pattern.brs);
    let length = match pattern.remote {
        true => fields.integer("length").and_then(|length| u8::try_from(length).ok()).unwrap_or(0),
        false => u8::try_from(data.len()).ok()?,
    };
    let fits = match fd {
        true => matches!(length, 0..=8 | 12 | 16 | 20 | 24 | 32 | 48 | 64),
        false => length <= 8,
    };
    if !fits {
        let (text, help) = match fd {
            true => {
                let help = "CAN FD has 0 to 8, 12, 16, 20, 24, 32, 48 or 64 bytes";
                (format!("no frame has {length} data bytes"), help)
            }
            false => (format!("a classic frame has no {length} data bytes"), "write fd = true to its frame"),
        };
        out.bad(codes::SEND, fields.get("data").unwrap_or(place), text, help);
        return None;
    }
    let brs = pattern.brs || fields.boolean("brs").unwrap_or(false);
    if brs && !fd {
        out.bad(codes::SEND, place, "a classic frame has one bit rate", "write fd = true, or remove `brs`");
        return None;
    }
    let FramePattern { bus, id, extended, remote, .. } = pattern.clone();
    Some(OutFrame { bus, id: id & MAX_EXTENDED_ID, extended, remote, fd, brs, length, data })
}

/// The data: those of the step, of its frame, or made of values.
fn data(place: &Node, fields: &Fields<'_>, named: &NamedFrame, out: &mut Findings) -> Option<Vec<u8>> {
    let values = fields.get("values");
    if let Some(node) = fields.get("data") {
        if let Some(values) = values {
            let help = "remove one of the two";
            out.bad(codes::SEND, values, "the data are given already: values say them twice", help);
            return None;
        }
        let exact = frames::data(node, out)?.exact();
        if exact.is_none() {
            out.bad(codes::SEND, node, "data that are sent leave nothing open", "write every digit");
        }
        return exact;
    }
    if fields.has("data") {
        return None;
    }
    match (&named.message, values) {
        (Some(message), values) => encoded(message, values, out),
        (None, Some(values)) => {
            let help = "name a `dbc` file and a `message`, or write `data`";
            out.bad(codes::SEND, values, "values belong to the signals of a message", help);
            None
        }
        (None, None) => {
            let exact = named.pattern.data.exact();
            if exact.is_none() {
                let help = "add data = \"01 02\" to the step; \"\" for a frame without";
                out.bad(codes::SEND, place, "the frame's data are not known", help);
            }
            exact
        }
    }
}

/// The data of a message with these values.
fn encoded(message: &MessageSpec, values: Option<&Node>, out: &mut Findings) -> Option<Vec<u8>> {
    let mut data = vec![0; message.size];
    let mut given: BTreeMap<&str, u64> = BTreeMap::new();
    let entries = values.and_then(Node::as_table).map_or(&[][..], |table| &table.entries);
    for entry in entries {
        let Some(field) = message.field(&entry.key) else {
            let help = frames::unknown(&entry.key, message.fields.iter().map(|field| field.name.as_str()));
            let text = format!("the message `{}` has no signal `{}`", message.name, entry.key);
            out.error(codes::DBC_NAME, entry.key_span.clone(), text, help);
            return None;
        };
        let bits = code(field, &entry.node, out)?;
        field.coding.put(bits, &mut data);
        given.insert(&field.name, bits);
    }
    // What selects a signal that is given follows from it.
    for entry in entries {
        let Some(field) = message.field(&entry.key) else { continue };
        select(message, field, &given, &mut data);
    }
    let hidden = entries.iter().find(|entry| {
        let selector = message.field(&entry.key).and_then(|field| field.selector.as_ref());
        selector.is_some_and(|selector| !selector.selects(&data))
    });
    if let Some(entry) = hidden {
        let text = format!("the other values leave no room for `{}`", entry.key);
        out.error(codes::FRAME_VALUE, entry.key_span.clone(), text, "its multiplexer has another value");
        return None;
    }
    Some(data)
}

/// Lets a signal be selected, and what selects it in its turn, where the plan does not say otherwise.
fn select(message: &MessageSpec, field: &FieldSpec, given: &BTreeMap<&str, u64>, data: &mut [u8]) {
    let (mut by, mut selector) = (field.selected_by.as_deref(), field.selector.as_ref());
    while let (Some(name), Some(needed)) = (by, selector) {
        if !given.contains_key(name)
            && let Some((first, _)) = needed.ranges.first()
        {
            needed.of.put(*first, data);
        }
        by = message.field(name).and_then(|field| field.selected_by.as_deref());
        selector = needed.under.as_deref();
    }
}

/// The bits of a value.
fn code(field: &FieldSpec, node: &Node, out: &mut Findings) -> Option<u64> {
    let literal = Literal::read(node, out)?;
    let info = SignalInfo {
        unit: field.unit.clone(),
        labels: field.labels.clone(),
        ..SignalInfo::exact(&field.name, ValueKind::Real)
    };
    let value = match value_of(&literal, &info) {
        Ok(value) => value,
        Err(why) => {
            out.bad(
                codes::FRAME_VALUE,
                node,
                why,
                "write a number, a quantity in its unit or a name of the file",
            );
            return None;
        }
    };
    let code = match &literal {
        // A name stands for bits, not for a value.
        Literal::Label(_) => value.as_int().and_then(|whole| field.coding.whole_code(whole)),
        _ => value.as_real().and_then(|number| field.coding.code(number)),
    };
    if code.is_none() {
        let text = format!("{literal} does not fit the bits of `{}`", field.name);
        out.bad(codes::FRAME_VALUE, node, text, "take a value that they can hold");
    }
    code
}
