//! `state`: the controller's state.
//!
//! ```toml
//! { state = { is = "RUNNING", when = "back" } }
//! { state = { becomes = "HALT", from = "busy", within = "100 ms .. 101 ms" } }
//! { state = { stays = "HALT", from = "busy + 102 ms", until = "end" } }
//! ```

use std::sync::Arc;

use document::{Fields, KeySpec, KeyType};

use super::common::{FROM, UNTIL, WHEN, anchor};
use super::condition::ValueCondition;
use super::first_edge::{FirstEdgeKind, WITHIN, read_delay};
use super::{ExpectVerb, ReadContext, TraceClaim, keeps, value};
use crate::codes;
use crate::lang::Anchor;

/// The signal of the controller's state, which every trace has.
const NAME: &str = "state";

/// `state`.
pub(super) const STATE: ExpectVerb = ExpectVerb {
    name: "state",
    doc: "The controller is in a state at an instant, enters it, or stays in it",
    keys: &[
        KeySpec::optional("is", KeyType::Text, "The state at the instant `when`"),
        KeySpec::optional(
            "becomes",
            KeyType::Text,
            "The state that is entered after `from`, `within` a delay",
        ),
        KeySpec::optional("stays", KeyType::Text, "The state that is kept from `from` until `until`"),
        WHEN,
        FROM,
        UNTIL,
        WITHIN,
    ],
    read,
};

fn read(fields: &Fields<'_>, cx: &mut ReadContext<'_>) -> Option<Arc<dyn TraceClaim>> {
    read_of(NAME.to_owned(), fields, cx)
}

/// Reads `is`, `becomes` or `stays` of a signal with named values.
pub(super) fn read_of(
    name: String,
    fields: &Fields<'_>,
    cx: &mut ReadContext<'_>,
) -> Option<Arc<dyn TraceClaim>> {
    let forms: [(&str, &[&str]); 3] =
        [("is", &["when"]), ("becomes", &["from", "within"]), ("stays", &["from", "until"])];
    let given: Vec<_> = forms.iter().filter(|(form, _)| fields.has(form)).collect();
    let [(form, takes)] = given.as_slice() else {
        let message = format!("`{name}` is claimed in no way or in two");
        cx.out.error(codes::CLAIM, cx.place.clone(), message, "give one of `is`, `becomes` and `stays`");
        return None;
    };
    for key in ["when", "from", "until", "within"] {
        if let (Some(node), false) = (fields.get(key), takes.contains(&key)) {
            let help = format!("`{form}` takes `{}`", takes.join("` and `"));
            cx.out.bad(codes::CLAIM, node, format!("`{key}` has no meaning with `{form}`"), help);
            return None;
        }
    }
    let condition = ValueCondition::label(fields.text(form)?);
    let signal = Some(name.clone());
    match *form {
        "becomes" => read_delay(fields, signal, FirstEdgeKind::Becomes(condition), cx),
        "stays" => keeps::read_window(fields, signal, Some(condition), cx),
        _ => {
            let when = anchor(fields, "when", Anchor::END, cx)?;
            Some(value::at_instant(name, condition, when))
        }
    }
}
