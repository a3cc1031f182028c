//! The devices of this machine behind a board file.

use document::{Entry, Fields, Findings, Node};

use super::bench::Bench;
use super::buses::buses;
use super::{codes, keys, lines};
use crate::convert::ConvertersSpec;
use crate::real::{RealSpec, SILENT_AFTER};

/// What only a board of real devices has: tables of the file, keys of its board, keys of a channel.
const TABLES: &[&str] = &["chips", "converters", "buses", "fault-relays"];
const OF_BOARD: &[&str] = &["backend", "check", "consumer", "retake", "silent-after"];
const OF_CHANNEL: &[&str] =
    &["chip", "line", "bias", "active-low", "debounce", "drive", "readback", "converter", "input"];

/// Reports keys of real devices on a simulated board.
pub(super) fn strangers(fields: &Fields, out: &mut Findings) {
    let help = "remove it, or make the board one of kind = \"real\"";
    let mut strange = |fields: &Fields, keys: &[&str]| {
        for entry in keys.iter().filter_map(|key| fields.entry(key)) {
            let message = format!("a simulated board has no `{}`", entry.key);
            out.error(codes::OTHER_BOARD, entry.key_span.clone(), message, help);
        }
    };
    strange(fields, TABLES);
    if let Some(board) = fields.inner("board") {
        strange(&board, OF_BOARD);
    }
    for (_, fields) in channels(fields) {
        strange(&fields, OF_CHANNEL);
    }
}

/// The devices of a file whose channels and bindings were read. `None` where something is wrong with them.
pub(super) fn real(fields: &Fields, bench: &mut Bench, out: &mut Findings) -> Option<RealSpec> {
    for entry in ["wires", "plants", "faults"].iter().filter_map(|key| fields.entry(key)) {
        let message = format!("a board of real devices has no `{}`", entry.key);
        let help = "remove it, and wire the lines themselves";
        out.error(codes::OTHER_BOARD, entry.key_span.clone(), message, help);
    }
    let board = fields.inner("board")?;
    let silent_after = board.duration("silent-after").unwrap_or(SILENT_AFTER);
    if let Some(node) = board.get("silent-after").filter(|_| silent_after.as_nanos() == 0) {
        out.bad(codes::TIME, node, "every call on a device lasts longer than 0", "write a duration above 0");
    }
    let gpio = lines::gpio(fields, silent_after, bench, out);
    for (entry, fields) in channels(fields) {
        if fields.text("kind") == Some("analog") {
            let message = format!("no device measures `{}`", entry.key);
            out.error(
                codes::CHANNEL_PROPERTY,
                entry.key_span.clone(),
                message,
                "make it digital, or remove it",
            );
        }
    }
    for (entry, _) in buses(fields, out) {
        let message = format!("no device carries `{}`", entry.key);
        out.error(codes::OTHER_BOARD, entry.key_span.clone(), message, "remove it");
    }
    let gpio = gpio.filter(|_| !out.has_errors())?;
    Some(RealSpec {
        silent_after,
        retake: board.boolean("retake").unwrap_or(false),
        gpio,
        converters: ConvertersSpec::default(),
    })
}

/// The channels that the file describes.
pub(super) fn channels<'a>(fields: &Fields<'a>) -> impl Iterator<Item = (&'a Entry, Fields<'a>)> {
    let table = fields.get("channels").and_then(Node::as_table);
    let entries = table.map_or(&[][..], |table| &table.entries);
    entries.iter().filter_map(|entry| Some((entry, Fields::checked(entry.node.as_table()?, keys::CHANNEL))))
}
