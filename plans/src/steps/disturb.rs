//! `short-circuit`, `over-temperature`, `supply-io`, `external-error` and `module-fault`: what goes wrong around the controller;
//! `internal-error`: what goes wrong in it.

use document::{Findings, KeySpec, KeyType, Node};
use signal::{Address, Area, Span};

use super::drive::above_zero;
use super::{DisturbanceKind, InternalErrorKind, StepVerb, Stimulus};
use super::{StepNames, table_fields};
use crate::codes;
use crate::lang::terminal;

const OUTPUT_KEYS: &[KeySpec] = &[
    KeySpec::required("output", KeyType::Text, "The output, as in %QX0.0."),
    KeySpec::optional("duration", KeyType::Duration, "How long it lasts; to the end if left out.").was("for"),
];

const ERROR_KEYS: &[KeySpec] = &[
    KeySpec::required("bit", KeyType::Integer(0, 63), "The bit of PLC_R.i_lwSystemFault_1."),
    KeySpec::optional("on", KeyType::Bool, "Whether the error comes or goes; TRUE if left out."),
];

pub(super) const SHORT_CIRCUIT: StepVerb = StepVerb {
    name: "short-circuit",
    doc: "Puts a short circuit on an output.",
    value: KeyType::Table(OUTPUT_KEYS),
    needs: &["faults"],
    read: |node, scope, out| {
        let (output, lasts) = at_output(node, scope, out)?;
        Some(Stimulus::Disturb { what: DisturbanceKind::ShortCircuit(output), on: true, lasts })
    },
};

pub(super) const OVER_TEMPERATURE: StepVerb = StepVerb {
    name: "over-temperature",
    doc: "Makes an output too hot.",
    value: KeyType::Table(OUTPUT_KEYS),
    needs: &["faults"],
    read: |node, scope, out| {
        let (output, lasts) = at_output(node, scope, out)?;
        Some(Stimulus::Disturb { what: DisturbanceKind::OverTemperature(output), on: true, lasts })
    },
};

pub(super) const SUPPLY_IO: StepVerb = StepVerb {
    name: "supply-io",
    doc: "Switches the supply of the inputs and outputs.",
    value: KeyType::Choice(&["on", "off"]),
    needs: &["faults"],
    read: |node, _, _| {
        let on = node.as_text()? == "off";
        Some(Stimulus::Disturb { what: DisturbanceKind::NoIoSupply, on, lasts: None })
    },
};

pub(super) const EXTERNAL_ERROR: StepVerb = StepVerb {
    name: "external-error",
    doc: "Puts a part outside of the controller in error, or takes the error back.",
    value: KeyType::Table(ERROR_KEYS),
    needs: &["faults"],
    read: read_external,
};

const MODULE_KEYS: &[KeySpec] = &[
    KeySpec::required("index", KeyType::Integer(0, 13), "The index of the module in TM3_MODULE_R."),
    KeySpec::required("kind", KeyType::Choice(&["silent"]), "What it does: it does not answer."),
    KeySpec::optional(
        "exchanges",
        KeyType::Integer(1, 1_000_000),
        "For how many exchanges of the bus; until it is taken back if left out.",
    ),
    KeySpec::optional("on", KeyType::Bool, "Whether the fault comes or goes; TRUE if left out."),
];

pub(super) const MODULE_FAULT: StepVerb = StepVerb {
    name: "module-fault",
    doc: "Puts a fault on an expansion module, or takes it back.",
    value: KeyType::Table(MODULE_KEYS),
    needs: &["faults"],
    read: read_module,
};

const INTERNAL_ERRORS: [&str; 3] = [
    InternalErrorKind::HardwareWatchdog.name(),
    InternalErrorKind::Firmware.name(),
    InternalErrorKind::FirmwareException.name(),
];

pub(super) const INTERNAL_ERROR: StepVerb = StepVerb {
    name: "internal-error",
    doc: "Puts the controller itself in error: its hardware watchdog expires, its firmware finds an error or has an exception.",
    value: KeyType::Choice(&INTERNAL_ERRORS),
    needs: &["faults"],
    read: |node, _, _| {
        let kind = InternalErrorKind::ALL.into_iter().find(|kind| node.as_text() == Some(kind.name()))?;
        Some(Stimulus::Disturb { what: DisturbanceKind::Internal(kind), on: true, lasts: None })
    },
};

/// An output and for how long something is wrong with it.
fn at_output(node: &Node, _: &dyn StepNames, out: &mut Findings) -> Option<(Address, Option<Span>)> {
    let fields = table_fields(node, OUTPUT_KEYS)?;
    let place = fields.get("output")?;
    let address = terminal(place, place.as_text()?, Area::Output, out);
    let lasts = if fields.has("duration") { Some(above_zero(&fields, "duration", out)?) } else { None };
    Some((address?, lasts))
}

fn read_external(node: &Node, _: &dyn StepNames, _: &mut Findings) -> Option<Stimulus> {
    let fields = table_fields(node, ERROR_KEYS)?;
    let bit = u8::try_from(fields.integer("bit")?).ok()?;
    let on = fields.boolean("on").unwrap_or(true);
    Some(Stimulus::Disturb { what: DisturbanceKind::External(bit), on, lasts: None })
}

fn read_module(node: &Node, _: &dyn StepNames, out: &mut Findings) -> Option<Stimulus> {
    let fields = table_fields(node, MODULE_KEYS)?;
    let index = u8::try_from(fields.integer("index")?).ok()?;
    let on = fields.boolean("on").unwrap_or(true);
    let exchanges = fields.integer("exchanges").and_then(|exchanges| u32::try_from(exchanges).ok());
    if let (false, Some(place)) = (on, fields.get("exchanges")) {
        let help = "remove it, or remove `on = false`";
        out.bad(codes::STIMULUS, place, "a fault that goes has no number of exchanges", help);
        return None;
    }
    Some(Stimulus::Disturb { what: DisturbanceKind::SilentModule { index, exchanges }, on, lasts: None })
}
