//! What a file states of the errors of a measurement, as it is written: for records, and for whoever reads them.

use document::{Data, Node, Table};

/// One statement of a board file or an instrument file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Statement {
    /// What it is of: a part of the file, or a channel by its name.
    pub of: String,
    /// The key: `resolution`, `accuracy.plus`.
    pub key: String,
    /// The value as the file has it: `10 ns`.
    pub value: String,
}

/// What a table states, those within it included, in the order of the file. `wanted` says of which keys.
pub fn of_table(table: &Table, of: &str, wanted: &dyn Fn(&str) -> bool, out: &mut Vec<Statement>) {
    gather(table, of, "", wanted, out);
}

fn gather(table: &Table, of: &str, before: &str, wanted: &dyn Fn(&str) -> bool, out: &mut Vec<Statement>) {
    for entry in table.entries.iter().filter(|entry| wanted(&entry.key)) {
        let key = format!("{before}{}", entry.key);
        let value = match &entry.node.data {
            Data::Table(inner) => {
                gather(inner, of, &format!("{key}."), &|_| true, out);
                continue;
            }
            Data::Text(text) | Data::Float(text) => text.clone(),
            Data::Integer(number) => number.to_string(),
            // The tables of keys have nothing else.
            _ => continue,
        };
        out.push(Statement { of: of.to_owned(), key, value });
    }
}

/// What a board file states of the errors of what the board sees.
pub(super) fn of_board(tree: &Table) -> Vec<Statement> {
    let clock = |key: &str| key.starts_with("clock-");
    let mut out = Vec::new();
    if let Some(board) = tree.get("board").and_then(Node::as_table) {
        of_table(board, "board", &clock, &mut out);
    }
    let mut each = |of: &str, wanted: &dyn Fn(&str) -> bool| {
        let table = tree.get(of).and_then(Node::as_table);
        for entry in table.map_or(&[][..], |table| &table.entries) {
            if let Some(table) = entry.node.as_table() {
                of_table(table, &entry.key, wanted, &mut out);
            }
        }
    };
    each("converters", &clock);
    each("generators", &clock);
    each("channels", &|key| OF_CHANNEL.contains(&key));
    out
}

/// The keys of a channel that say how far off it may be.
const OF_CHANNEL: &[&str] = &["accuracy", "input-delay", "output-delay"];
