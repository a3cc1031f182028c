//! `fault` and `clear`: what is broken between the controller and the world.

use document::{Fields, Findings, KeySpec, KeyType, Node};

use super::drive::above_zero;
use super::{LineFault, StepVerb, Stimulus};
use super::{StepNames, table_fields};
use crate::codes;
use crate::lang::Literal;

const KINDS: &[&str] = &["stuck", "open", "short-to-ground", "short-to-supply", "glitch", "late", "lost"];

const KEYS: &[KeySpec] = &[
    KeySpec::required("signal", KeyType::SignalRef, "The line."),
    KeySpec::required("kind", KeyType::Choice(KINDS), "What is wrong with the line."),
    KeySpec::optional("value", KeyType::Value, "The value of a line that is stuck or has a glitch."),
    KeySpec::optional("width", KeyType::Duration, "How long a glitch lasts."),
    KeySpec::optional("delay", KeyType::Duration, "How much later the changes of a late line come."),
    KeySpec::optional(
        "duration",
        KeyType::Duration,
        "How long the fault stays; until it is cleared if left out.",
    )
    .was("for"),
];

const CLEAR_KEYS: &[KeySpec] = &[KeySpec::required("signal", KeyType::SignalRef, "The line.")];

pub(super) const FAULT: StepVerb = StepVerb {
    name: "fault",
    doc: "Puts a fault on a line.",
    value: KeyType::Table(KEYS),
    needs: &["faults"],
    read,
};

pub(super) const CLEAR: StepVerb = StepVerb {
    name: "clear",
    doc: "Takes every fault off a line.",
    value: KeyType::Table(CLEAR_KEYS),
    needs: &["faults"],
    read: read_clear,
};

/// Whether the kind stays for a `duration`; a glitch lasts for its `width`.
fn has_duration(kind: &str) -> bool {
    kind != "glitch"
}

/// The keys that each kind takes besides `signal`, `kind` and `duration`.
fn own_keys(kind: &str) -> &'static [&'static str] {
    match kind {
        "stuck" => &["value"],
        "glitch" => &["value", "width"],
        "late" => &["delay"],
        _ => &[],
    }
}

fn read(node: &Node, scope: &dyn StepNames, out: &mut Findings) -> Option<Stimulus> {
    let fields = table_fields(node, KEYS)?;
    let kind = fields.text("kind")?;
    if !keys_fit(&fields, node, kind, out) {
        return None;
    }
    let signal = scope.signal(fields.get("signal")?, out);
    let lasts = if fields.has("duration") { Some(above_zero(&fields, "duration", out)?) } else { None };
    let value = fields.get("value").map(|value| Literal::read(value, out));
    let kind = match kind {
        "stuck" => LineFault::Stuck(value??),
        "open" => LineFault::Open,
        "short-to-ground" => LineFault::ShortToGround,
        "short-to-supply" => LineFault::ShortToSupply,
        "glitch" => LineFault::Glitch { value: value??, width: above_zero(&fields, "width", out)? },
        "late" => LineFault::Late(above_zero(&fields, "delay", out)?),
        _ => LineFault::Lost,
    };
    Some(Stimulus::Fault { signal: signal?, kind, lasts })
}

/// Reports keys that the kind lacks or cannot have.
fn keys_fit(fields: &Fields<'_>, node: &Node, kind: &str, out: &mut Findings) -> bool {
    let own = own_keys(kind);
    let before = out.errors();
    for key in own.iter().filter(|key| !fields.has(key)) {
        let message = format!("a fault of kind \"{kind}\" has no `{key}`");
        out.bad(codes::STIMULUS, node, message, format!("add `{key} = ...`"));
    }
    for key in ["value", "width", "delay"].iter().filter(|key| !own.contains(key)) {
        if let Some(entry) = fields.table().entry(key) {
            let message = format!("a fault of kind \"{kind}\" takes no `{key}`");
            out.error(codes::STIMULUS, entry.key_span.clone(), message, "remove it");
        }
    }
    if let Some(entry) = fields.table().entry("duration").filter(|_| !has_duration(kind)) {
        let message = format!("a fault of kind \"{kind}\" takes no `duration`");
        out.error(codes::STIMULUS, entry.key_span.clone(), message, "say with `width` how long it lasts");
    }
    out.errors() == before
}

fn read_clear(node: &Node, scope: &dyn StepNames, out: &mut Findings) -> Option<Stimulus> {
    let fields = table_fields(node, CLEAR_KEYS)?;
    Some(Stimulus::Clear { signal: scope.signal(fields.get("signal")?, out)? })
}
