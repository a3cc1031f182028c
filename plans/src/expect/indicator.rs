//! `led`: what an indicator of the controller shows.
//!
//! ```toml
//! { led = { name = "RUN", is = "on", when = "end" } }
//! { led = { name = "ERR", becomes = "fast-flash", from = "busy", within = "1 s" } }
//! { led = { name = "ERR", stays = "off", from = "start", until = "busy" } }
//! ```

use std::sync::Arc;

use document::{Data, Fields, KeySpec, KeyType, Node};

use super::common::{FROM, UNTIL, WHEN};
use super::first_edge::WITHIN;
use super::{ExpectVerb, ReadContext, TraceClaim, state};

/// The indicators, as the signals `LED.PWR` and so on name them.
const NAMES: &[&str] = &["PWR", "RUN", "ERR", "IO", "TM4", "BAT"];

/// What an indicator can show.
const SHOWS: KeyType = KeyType::Choice(&["off", "on", "fast-flash", "regular-flash", "single-flash"]);

/// `led`.
pub(super) const LED: ExpectVerb = ExpectVerb {
    name: "led",
    doc: "An indicator of the controller shows something at an instant, comes to show it, or shows it all along",
    keys: &[
        KeySpec::required("name", KeyType::Choice(NAMES), "The indicator"),
        KeySpec::optional("is", SHOWS, "What it shows at the instant `when`"),
        KeySpec::optional("becomes", SHOWS, "What it comes to show after `from`, `within` a delay"),
        KeySpec::optional("stays", SHOWS, "What it shows from `from` until `until`"),
        WHEN,
        FROM,
        UNTIL,
        WITHIN,
    ],
    read,
};

fn read(fields: &Fields<'_>, cx: &mut ReadContext<'_>) -> Option<Arc<dyn TraceClaim>> {
    let node = fields.get("name")?;
    let name = format!("LED.{}", node.as_text()?);
    let signal = cx.names.signal(&Node { data: Data::Text(name), content: None, ..node.clone() }, cx.out)?;
    state::read_of(signal, fields, cx)
}
