//! The buses of a board file: CAN buses and serial lines.

use document::{Entry, Fields, Findings, Node};

use super::keys;

/// The buses that the file describes, in its order: that of their numbers.
pub(super) fn buses<'a>(fields: &Fields<'a>, out: &mut Findings) -> Vec<(&'a Entry, Fields<'a>)> {
    let table = fields.get("buses").and_then(Node::as_table);
    let entries = table.map_or(&[][..], |table| &table.entries);
    let checked = entries.iter().filter_map(|entry| {
        let table = entry.node.as_table()?;
        Some((entry, Fields::check(table, entry.node.span.clone(), "bus", keys::BUS, out)))
    });
    checked.collect()
}
