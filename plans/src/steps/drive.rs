//! `set`, `pulse`, `force`, `release` and `write`: values put on lines, inputs, outputs and memory.

use document::{Data, Fields, Findings, KeySpec, KeyType, Node};
use signal::Span;

use super::{StepNames, table_fields};
use super::{StepVerb, Stimulus};
use crate::codes;
use crate::lang::Literal;

const SIGNAL: KeySpec = KeySpec::required("signal", KeyType::SignalRef, "The signal.");

const VALUED: &[KeySpec] = &[SIGNAL, KeySpec::required("value", KeyType::Value, "The value that it gets.")];
const VALUED_TABLE: KeyType = KeyType::Table(VALUED);

const PULSE_KEYS: &[KeySpec] = &[
    SIGNAL,
    KeySpec::optional("value", KeyType::Value, "The value during the pulse; TRUE if left out."),
    KeySpec::required("width", KeyType::Duration, "How long the pulse lasts."),
];

const WRITE_KEYS: &[KeySpec] = &[
    KeySpec::required("of", KeyType::SignalRef, "The variable or place of memory."),
    KeySpec::required("value", KeyType::Value, "The value that is written."),
];

pub(super) const SET: StepVerb = StepVerb {
    name: "set",
    doc: "Drives one line, or several at once, until something else drives them.",
    value: KeyType::OneOrMore(&VALUED_TABLE),
    needs: &[],
    read: read_set,
};

pub(super) const PULSE: StepVerb = StepVerb {
    name: "pulse",
    doc: "Drives a line for a time, then back to what it was.",
    value: KeyType::Table(PULSE_KEYS),
    needs: &[],
    read: read_pulse,
};

pub(super) const FORCE: StepVerb = StepVerb {
    name: "force",
    doc: "Forces an input or output of the controller until it is released.",
    value: KeyType::Table(VALUED),
    needs: &["force"],
    read: read_force,
};

pub(super) const RELEASE: StepVerb = StepVerb {
    name: "release",
    doc: "Ends the forcing of an input or output.",
    value: KeyType::Table(&[SIGNAL]),
    needs: &["force"],
    read: read_release,
};

pub(super) const WRITE: StepVerb = StepVerb {
    name: "write",
    doc: "Writes a variable or a place of memory once.",
    value: KeyType::Table(WRITE_KEYS),
    needs: &["memory-access"],
    read: read_write,
};

/// The signal and the value of one table; reports what is wrong with either.
fn pair(
    fields: &Fields<'_>,
    key: &str,
    scope: &dyn StepNames,
    out: &mut Findings,
) -> Option<(String, Literal)> {
    let signal = scope.signal(fields.get(key)?, out);
    let value = Literal::read(fields.get("value")?, out);
    Some((signal?, value?))
}

/// A duration above 0; reports one that is not.
pub(crate) fn above_zero(fields: &Fields<'_>, key: &str, out: &mut Findings) -> Option<Span> {
    let span = fields.duration(key)?;
    if span == Span::ZERO {
        let node = fields.get(key)?;
        out.bad(codes::STIMULUS, node, format!("`{key}` is 0"), "nothing can last no time at all");
        return None;
    }
    Some(span)
}

fn read_set(node: &Node, scope: &dyn StepNames, out: &mut Findings) -> Option<Stimulus> {
    let tables = match &node.data {
        Data::Array(list) => list.as_slice(),
        _ => std::slice::from_ref(node),
    };
    let mut list: Vec<(String, Literal)> = Vec::with_capacity(tables.len());
    let mut right = true;
    for table in tables {
        let fields = table_fields(table, VALUED)?;
        match pair(&fields, "signal", scope, out) {
            Some((signal, _)) if list.iter().any(|(known, _)| *known == signal) => {
                let message = format!("`{signal}` is set twice at one instant");
                out.bad(codes::STIMULUS, table, message, "leave one of the two");
                right = false;
            }
            Some(pair) => list.push(pair),
            None => right = false,
        }
    }
    right.then_some(Stimulus::Set(list))
}

fn read_pulse(node: &Node, scope: &dyn StepNames, out: &mut Findings) -> Option<Stimulus> {
    let fields = table_fields(node, PULSE_KEYS)?;
    let signal = scope.signal(fields.get("signal")?, out);
    let width = above_zero(&fields, "width", out);
    let value = match fields.get("value") {
        Some(value) => Literal::read(value, out),
        None => Some(Literal::TRUE),
    };
    Some(Stimulus::Pulse { signal: signal?, value: value?, width: width? })
}

fn read_force(node: &Node, scope: &dyn StepNames, out: &mut Findings) -> Option<Stimulus> {
    let (signal, value) = pair(&table_fields(node, VALUED)?, "signal", scope, out)?;
    Some(Stimulus::Force { signal, value })
}

fn read_release(node: &Node, scope: &dyn StepNames, out: &mut Findings) -> Option<Stimulus> {
    let fields = table_fields(node, &[SIGNAL])?;
    Some(Stimulus::Release { signal: scope.signal(fields.get("signal")?, out)? })
}

fn read_write(node: &Node, scope: &dyn StepNames, out: &mut Findings) -> Option<Stimulus> {
    let (of, written) = pair(&table_fields(node, WRITE_KEYS)?, "of", scope, out)?;
    // What a unit means is known where the variable's type is: a place of memory has none, and a TIME there counts milliseconds.
    let has_unit = written.quantity().is_some_and(|quantity| !quantity.unit.is_none());
    let value = if has_unit { written } else { written.value().map_or(written, Literal::Value) };
    Some(Stimulus::Write { of, value })
}
