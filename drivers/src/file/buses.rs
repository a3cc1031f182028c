//! The buses of a board file: CAN buses and serial lines.

use document::{Entry, Fields, Findings, Node};

use super::keys;
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

fn entries<'a>(fields: &Fields<'a>) -> &'a [Entry] {
    let table = fields.get("buses").and_then(Node::as_table);
    table.map_or(&[][..], |table| &table.entries)
}
