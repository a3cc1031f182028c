//! `log`: entries of the controller's log.
//!
//! ```toml
//! { log = { contains = "RUNNING -> HALT", from = "busy", within = "1 s" } }
//! { log = { never = "watchdog", from = "start", until = "busy" } }
//! ```
//! An entry counts by the instant at which it is written. What the log holds already at `from` is no answer.

use std::sync::Arc;

use document::{Data, Entry, Fields, KeySpec, KeyType, Node, Table};

use super::common::{FROM, UNTIL};
use super::first_edge::{FirstEdgeKind, WITHIN, read_delay};
use super::{ExpectVerb, ReadContext, TraceClaim, edges};
use crate::codes;

/// `log`.
pub(super) const LOG: ExpectVerb = ExpectVerb {
    name: "log",
    doc: "An entry with a text is added to the controller's log in time, or at no time of a window",
    keys: &[
        KeySpec::optional(
            "contains",
            KeyType::Text,
            "The text of an entry that is added `within` a delay after `from`",
        )
        .was("holds"),
        KeySpec::optional(
            "never",
            KeyType::Text,
            "The text of an entry that is not added from `from` until `until`",
        ),
        FROM,
        UNTIL,
        WITHIN,
    ],
    read,
};

fn read(fields: &Fields<'_>, cx: &mut ReadContext<'_>) -> Option<Arc<dyn TraceClaim>> {
    let (key, other) = match (fields.has("contains"), fields.has("never")) {
        (true, false) => ("contains", "until"),
        (false, true) => ("never", "within"),
        _ => {
            let message = "an entry is claimed in no way or in two";
            cx.out.error(codes::CLAIM, cx.place.clone(), message, "give one of `contains` and `never`");
            return None;
        }
    };
    if let Some(node) = fields.get(other) {
        let takes = if key == "contains" { "`from` and `within`" } else { "`from` and `until`" };
        let message = format!("`{other}` has no meaning with `{key}`");
        cx.out.bad(codes::CLAIM, node, message, format!("`{key}` takes {takes}"));
        return None;
    }
    let text = fields.get(key)?;
    if text.as_text().is_some_and(|text| text.trim().is_empty()) {
        cx.out.bad(codes::CLAIM, text, "every entry holds an empty text", "write a part of the entry");
        return None;
    }
    let signal = cx.names.signal(&source(text, &[("log", text.data.clone())]), cx.out);
    match key {
        "contains" => read_delay(fields, signal, FirstEdgeKind::Added, cx),
        _ => edges::read_none(fields, signal, cx),
    }
}

/// A table that names a signal, at the place of what the plan says of it.
pub(super) fn source(at: &Node, keys: &[(&str, Data)]) -> Node {
    let mut table = Table::default();
    for (key, data) in keys {
        let node = Node { data: data.clone(), ..at.clone() };
        table.entries.push(Entry { key: (*key).to_owned(), key_span: at.span.clone(), node });
    }
    Node { data: Data::Table(table), content: None, ..at.clone() }
}
