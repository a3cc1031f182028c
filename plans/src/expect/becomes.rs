//! `becomes`: the first time after an instant that a signal comes to have a value is within its limits.
//!
//! ```toml
//! { becomes = { signal = "pressure", min = "3 V", from = "valve", within = "200 ms" } }
//! ```
//! The value has to be entered: a signal that has it all along never becomes it.

use std::sync::Arc;

use document::Fields;

use super::common::{FROM, LONGER, SIGNAL, signal};
use super::condition::{IS, MAX, MIN, ONE_OF, ValueCondition};
use super::first_edge::{FirstEdgeKind, WITHIN, read_delay};
use super::{ExpectVerb, ReadContext, TraceClaim};

/// `becomes`.
pub(super) const BECOMES: ExpectVerb = ExpectVerb {
    name: "becomes",
    doc: "The first time after an instant that a signal comes to have a value is within its limits",
    keys: &[SIGNAL, IS, ONE_OF, MIN, MAX, FROM, WITHIN, LONGER],
    read,
};

fn read(fields: &Fields<'_>, cx: &mut ReadContext<'_>) -> Option<Arc<dyn TraceClaim>> {
    let signal = signal(fields, "signal", cx);
    let condition = ValueCondition::read(fields, None, cx)?;
    read_delay(fields, signal, FirstEdgeKind::Becomes(condition), cx)
}
