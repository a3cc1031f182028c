//! Where figures are from: the key `source` of a module, a page or a mode.

use document::{Data, Findings, KeyType, Node, Table};
use profile::FigureSource;

/// A table of figures, of which some are in a table themselves: `{ id = "...", digital-inputs.on-delay = "..." }`.
pub(crate) const SOURCE: KeyType =
    KeyType::Map(&KeyType::Either(&[KeyType::Text, KeyType::Map(&KeyType::Text)]));

/// For all figures of a module or mode.
const ALL: &str = "all";

/// The sources that a table states of figures that it has. A figure that it has not is an error, unless the sources are
/// those of a whole page.
pub(crate) fn read(
    source: Option<&Node>,
    table: &Table,
    of_page: bool,
    out: &mut Findings,
) -> Vec<FigureSource> {
    let mut read = Vec::new();
    let mut keep = |figure: String, there: bool, node: &Node, out: &mut Findings| {
        if there {
            let source = node.as_text().unwrap_or_default().to_owned();
            read.push(FigureSource { figure, source });
        } else if !of_page {
            out.bad(
                out.codes().unknown_key,
                node,
                format!("there is no figure `{figure}`"),
                "name a key of the table",
            );
        }
    };
    for entry in source.and_then(Node::as_table).map_or(&[][..], |table| &table.entries) {
        match &entry.node.data {
            Data::Table(inner) => {
                let group = table.get(&entry.key).and_then(Node::as_table);
                for one in &inner.entries {
                    let there = group.is_some_and(|group| group.get(&one.key).is_some());
                    keep(format!("{}.{}", entry.key, one.key), there, &one.node, out);
                }
            }
            _ => {
                let there = entry.key == ALL || entry.key == "name" || table.get(&entry.key).is_some();
                keep(entry.key.clone(), there, &entry.node, out);
            }
        }
    }
    read
}
