//! `task`: a figure of a task is within limits.
//!
//! ```toml
//! { task = { name = "MAST", figure = "max-cycle", max = "5 ms" } }
//! { task = { name = "MAST", figure = "lost", is = 0, from = "start", until = "end" } }
//! ```
//! At the instant `when`, or with `from` or `until` all along.

use std::sync::Arc;

use document::{Fields, KeySpec, KeyType};

use super::common::{FROM, UNTIL, WHEN, anchor};
use super::condition::{IS, MAX, MIN, ONE_OF, ValueCondition};
use super::{ExpectVerb, ReadContext, TraceClaim, entry, keeps, value};
use crate::codes;
use crate::lang::Anchor;
use crate::signals::TaskFigure;

/// `task`.
pub(super) const TASK: ExpectVerb = ExpectVerb {
    name: "task",
    doc: "A figure of a task is within limits, at an instant or all along",
    keys: &[
        KeySpec::required("name", KeyType::Text, "The task, as in \"MAST\""),
        KeySpec::required("figure", KeyType::Choice(TaskFigure::NAMES), "Which figure; times in nanoseconds"),
        IS,
        ONE_OF,
        MIN,
        MAX,
        WHEN,
        FROM,
        UNTIL,
    ],
    read,
};

fn read(fields: &Fields<'_>, cx: &mut ReadContext<'_>) -> Option<Arc<dyn TraceClaim>> {
    let condition = ValueCondition::read(fields, None, cx);
    let (name, figure) = (fields.get("name")?, fields.get("figure")?);
    let keys = [("task", name.data.clone()), ("figure", figure.data.clone())];
    let signal = cx.names.signal(&entry::source(name, &keys), cx.out);
    let throughout = fields.has("from") || fields.has("until");
    if let (true, Some(node)) = (throughout, fields.get("when")) {
        let message = "the figure is claimed at an instant and all along";
        cx.out.bad(codes::CLAIM, node, message, "leave `when` out, or `from` and `until`");
        return None;
    }
    if throughout {
        return keeps::read_window(fields, signal, condition, cx);
    }
    let when = anchor(fields, "when", Anchor::END, cx);
    Some(value::at_instant(signal?, condition?, when?))
}
