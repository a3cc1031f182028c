//! `settings`: what is said of inputs, and of what runs and stops the controller.

use std::ops::Range;

use document::{Data, Entry, Fields, Findings, KeySpec, KeyType, Node};
use profile::{BounceFilter, EventEdges, InputFilter};
use signal::{Address, Area, Span};

use super::settings::PlanSettings;
use crate::codes;
use crate::lang::terminal;

const FILTER_EACH: KeyType = KeyType::Duration;

const INPUT_KEYS: &[KeySpec] = &[
    KeySpec::optional("filter", KeyType::Duration, "0, 1, 4 or 12 ms; 0 with `latch` or `event`."),
    KeySpec::optional("latch", KeyType::Bool, "Whether pulses between two reads of MAST are kept."),
    KeySpec::optional(
        "event",
        KeyType::Choice(&["no", "rising", "falling", "both"]),
        "The edges that raise the input's event.",
    ),
    KeySpec::optional("bounce", KeyType::Duration, "The anti-bounce filter of `latch` and `event`."),
];
const INPUT_TYPE: KeyType = KeyType::Table(INPUT_KEYS);

/// The type of `filter`.
pub(super) const FILTER_TYPE: KeyType = KeyType::Either(&[KeyType::Duration, KeyType::Map(&FILTER_EACH)]);

/// The type of `inputs`.
pub(super) const INPUTS_TYPE: KeyType = KeyType::Map(&INPUT_TYPE);

/// What a plan says of one input.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InputSettings {
    /// The input.
    pub address: Address,
    /// Its filter.
    pub filter: Option<InputFilter>,
    /// Whether it keeps pulses between two reads of MAST.
    pub latch: bool,
    /// The edges that raise its event.
    pub event: Option<EventEdges>,
    /// Its anti-bounce filter.
    pub bounce: Option<BounceFilter>,
    /// Bytes of the plan.
    pub span: Range<usize>,
}

/// Reads `filter`, `inputs`, `run-stop-input` and `switch`, which were held against their keys.
pub(super) fn read(fields: &Fields<'_>, settings: &mut PlanSettings, out: &mut Findings) {
    filters(fields, settings, out);
    inputs(fields, settings, out);
    settings.switch_at_run = fields.text("switch").map(|position| position == "run");
    let run_stop = fields.get("run-stop-input");
    settings.run_stop_input = run_stop
        .and_then(|node| Some((terminal(node, node.as_text()?, Area::Input, out)?, node.span.clone())));
}

fn filters(fields: &Fields<'_>, settings: &mut PlanSettings, out: &mut Findings) {
    let Some(node) = fields.get("filter") else { return };
    let Some(table) = node.as_table() else {
        settings.filter = filter(node, out);
        return;
    };
    for entry in &table.entries {
        let filter = filter(&entry.node, out);
        let address = key(entry, Area::Input, out);
        if let (Some(address), Some(filter)) = (address, filter) {
            settings.filters.push((address, filter));
        }
    }
}

fn inputs(fields: &Fields<'_>, settings: &mut PlanSettings, out: &mut Findings) {
    let Some(table) = fields.get("inputs").and_then(Node::as_table) else { return };
    for entry in &table.entries {
        let Some(own) = entry.node.as_table() else { continue };
        let own = Fields::checked(own, INPUT_KEYS);
        let filter = own.get("filter").and_then(|node| filter(node, out));
        let bounce = own.get("bounce").and_then(|node| bounce(node, out));
        let Some(address) = key(entry, Area::Input, out) else { continue };
        if settings.inputs.iter().any(|known| known.address == address) {
            let message = format!("the input {address} is given twice");
            out.error(codes::NAME_TWICE, entry.key_span.clone(), message, "remove one of them");
            continue;
        }
        settings.inputs.push(InputSettings {
            address,
            filter,
            latch: own.boolean("latch") == Some(true),
            event: match own.text("event") {
                Some("rising") => Some(EventEdges::Rising),
                Some("falling") => Some(EventEdges::Falling),
                Some("both") => Some(EventEdges::Both),
                _ => None,
            },
            bounce,
            span: entry.node.span.clone(),
        });
    }
}

fn filter(node: &Node, out: &mut Findings) -> Option<InputFilter> {
    let span = Span::parse(node.as_text()?).ok()?;
    let filter = InputFilter::from_span(span);
    if filter.is_none() {
        let help = "a filter has 0 ms, 1 ms, 4 ms or 12 ms (io:STD-IN-01)";
        out.bad(codes::SETTING, node, format!("no input has a filter of {span}"), help);
    }
    filter
}

fn bounce(node: &Node, out: &mut Findings) -> Option<BounceFilter> {
    let span = Span::parse(node.as_text()?).ok()?;
    let bounce = BounceFilter::from_span(span);
    if bounce.is_none() {
        let help = "0, 1, 2, 5, 10, 50, 100 or 500 us, 1 or 5 ms (io: section 3)";
        out.bad(codes::SETTING, node, format!("no input has a bounce time of {span}"), help);
    }
    bounce
}

/// The key as the address of an input or output.
pub(super) fn key(entry: &Entry, area: Area, out: &mut Findings) -> Option<Address> {
    let key = Node::new(entry.key_span.clone(), Data::Text(entry.key.clone()));
    terminal(&key, &entry.key, area, out)
}
