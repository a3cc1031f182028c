//! The buses of a board file: CAN buses and serial lines.

use document::{Entry, Fields, Findings, Node};

use super::devices::{can, serial};
use super::{codes, keys};
use crate::BusId;

/// The buses that the file describes, in its order: that of their numbers. Reports keys that no bus has.
pub(super) fn buses<'a>(fields: &Fields<'a>, out: &mut Findings) -> Vec<(&'a Entry, Fields<'a>)> {
    let checked = entries(fields).iter().filter_map(|entry| {
        let table = entry.node.as_table()?;
        Some((entry, Fields::check(table, entry.node.span.clone(), "bus", keys::BUS, out)))
    });
    checked.collect()
}

/// Those of one kind, each with its number; their keys were checked.
pub(super) fn of_kind<'a>(
    fields: &Fields<'a>,
    kind: &str,
) -> impl Iterator<Item = (&'a Entry, Fields<'a>, BusId)> {
    let tables = entries(fields).iter().filter_map(|entry| Some((entry, entry.node.as_table()?)));
    let all =
        (0..).zip(tables).map(|(at, (entry, table))| (entry, Fields::checked(table, keys::BUS), BusId(at)));
    all.filter(move |(_, fields, _)| fields.text("kind") == Some(kind))
}

/// Reports keys that no bus of this kind has on this kind of board, `keys` those that it has.
pub(super) fn misplaced(fields: &Fields, is_simulated: bool, keys: &[&str], out: &mut Findings) {
    let is_serial = fields.text("kind") == Some("serial");
    let kind = if is_serial { "serial line" } else { "CAN bus" };
    let board = if is_simulated { "simulated" } else { "real" };
    for strange in fields.table().entries.iter().filter(|entry| !keys.contains(&entry.key.as_str())) {
        // A key that no bus has was reported where the table was read.
        if fields.entry(&strange.key).is_some() {
            let message = format!("a {kind} of a {board} board has no `{}`", strange.key);
            let help = instead(&strange.key, is_serial, is_simulated);
            out.error(codes::BUS_KEY, strange.key_span.clone(), message, help);
        }
    }
}

/// What to write in place of a key that a bus does not have.
fn instead(key: &str, is_serial: bool, is_simulated: bool) -> &'static str {
    match (key, is_serial) {
        ("bitrate", true) => "write `baud`: this is how the speed of a serial line is named",
        ("baud", false) => "write `bitrate`: this is how the speed of a CAN bus is named",
        ("interface" | "path", _) if is_simulated => "remove it: a bus of a simulated board has no device",
        ("interface", true) => "write `path`: a serial line is a device, as in \"/dev/ttyS1\"",
        ("path", false) => "write `interface`: a CAN bus has one, as in \"can0\"",
        ("joins" | "delay", _) if !is_simulated => "remove it: only a bus of a simulated board has it",
        (_, true) if can::KEYS.contains(&key) => "remove it: only a CAN bus has it",
        (_, false) if key == "delay" || serial::KEYS.contains(&key) => "remove it: only a serial line has it",
        _ => "remove it: only a bus of a real board has it",
    }
}

fn entries<'a>(fields: &Fields<'a>) -> &'a [Entry] {
    let table = fields.get("buses").and_then(Node::as_table);
    table.map_or(&[][..], |table| &table.entries)
}
