//! `short-circuit`, `over-temperature`, `supply-io`, `external-error`, `module-fault`, `supply-bus` and `link-cut`: what goes wrong
//! around the controller;
//! `internal-error`: what goes wrong in it.

use document::{Fields, Findings, KeySpec, KeyType, Node};
use profile::ModuleType;
use signal::{Address, Area, Span};

use super::drive::above_zero;
use super::{DisturbanceKind, InternalErrorKind, ModuleFaultKind, StepVerb, Stimulus};
use super::{StepNames, table_fields};
use crate::codes;
use crate::lang::terminal;
use crate::module_names::find_module;

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

const LINK_KEYS: &[KeySpec] = &[
    KeySpec::optional("duration", KeyType::Duration, "How long; until it is joined again if left out."),
    KeySpec::optional("on", KeyType::Bool, "Whether the link is cut or joined again; TRUE if left out."),
];

pub(super) const SUPPLY_BUS: StepVerb = StepVerb {
    name: "supply-bus",
    doc: "Switches the supply of the expansion bus.",
    value: KeyType::Choice(&["on", "off"]),
    needs: &["faults"],
    read: |node, _, _| {
        let on = node.as_text()? == "off";
        Some(Stimulus::Disturb { what: DisturbanceKind::NoBusSupply, on, lasts: None })
    },
};

pub(super) const LINK_CUT: StepVerb = StepVerb {
    name: "link-cut",
    doc: "Cuts the link between transmitter and receiver, or joins it again.",
    value: KeyType::Table(LINK_KEYS),
    needs: &["faults"],
    read: |node, _, out| {
        let fields = table_fields(node, LINK_KEYS)?;
        let (on, lasts) = comes_and_goes(&fields, out)?;
        Some(Stimulus::Disturb { what: DisturbanceKind::NoBusLink, on, lasts })
    },
};

const MODULE_KEYS: &[KeySpec] = &[
    KeySpec::required("index", KeyType::Integer(0, 13), "The index of the module in TM3_MODULE_R."),
    KeySpec::required(
        "kind",
        KeyType::Choice(&["silent", "pulled", "replaced", "disturbs", "unsupplied"]),
        "What is wrong: it does not answer, is pulled out, is another one, disturbs those beside it, or its own supply is off.",
    ),
    KeySpec::optional(
        "exchanges",
        KeyType::Integer(1, 1_000_000),
        "With `silent`: for how many exchanges of the bus; until it is taken back if left out.",
    ),
    KeySpec::optional("type", KeyType::Text, "With `replaced`: the reference of the other module."),
    KeySpec::optional(
        "duration",
        KeyType::Duration,
        "How long it lasts; until it is taken back if left out.",
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

/// Whether something begins or is over, and for how long what begins lasts.
fn comes_and_goes(fields: &Fields<'_>, out: &mut Findings) -> Option<(bool, Option<Span>)> {
    let on = fields.boolean("on").unwrap_or(true);
    let lasts = if fields.has("duration") { Some(above_zero(fields, "duration", out)?) } else { None };
    if let (false, Some(place)) = (on, fields.get("duration")) {
        out.bad(codes::STIMULUS, place, "what is over does not last", "remove it, or remove `on = false`");
        return None;
    }
    Some((on, lasts))
}

fn read_module(node: &Node, _: &dyn StepNames, out: &mut Findings) -> Option<Stimulus> {
    let fields = table_fields(node, MODULE_KEYS)?;
    let index = u8::try_from(fields.integer("index")?).ok()?;
    let kind = fields.text("kind")?;
    let (on, lasts) = comes_and_goes(&fields, out)?;
    for (key, of, why) in [("exchanges", "silent", "answers"), ("type", "replaced", "stays what it is")] {
        let strange = fields.get(key).filter(|_| kind != of || !on);
        if let Some(place) = strange {
            let message = match on {
                true => format!("a module that is not {of} {why}"),
                false => format!("a fault that goes has no `{key}`"),
            };
            out.bad(codes::STIMULUS, place, message, format!("remove `{key}`"));
            return None;
        }
    }
    if let (Some(place), Some(_)) = (fields.get("exchanges"), lasts) {
        let help = "remove `exchanges` or `duration`";
        out.bad(codes::STIMULUS, place, "it is silent for a number of exchanges or for a time", help);
        return None;
    }
    let fault = match kind {
        "pulled" => ModuleFaultKind::Pulled,
        "disturbs" => ModuleFaultKind::Disturbs,
        "unsupplied" => ModuleFaultKind::Unsupplied,
        "replaced" if !on => ModuleFaultKind::Replaced(None),
        "replaced" => match fields.get("type") {
            Some(place) => ModuleFaultKind::Replaced(Some(on_bus(place, out)?)),
            None => {
                out.bad(codes::STIMULUS, node, "which module is there now is not said", "write its `type`");
                return None;
            }
        },
        _ => {
            let exchanges = fields.integer("exchanges");
            ModuleFaultKind::Silent(exchanges.and_then(|exchanges| u32::try_from(exchanges).ok()))
        }
    };
    Some(Stimulus::Disturb { what: DisturbanceKind::Module { index, fault }, on, lasts })
}

/// The module of a reference, which has to be one of the bus.
fn on_bus(place: &Node, out: &mut Findings) -> Option<&'static ModuleType> {
    let module = find_module(place, out)?;
    if !module.is_on_bus() {
        let message = format!("`{}` is no module with an ID code on the TM3 bus", module.reference);
        out.bad(codes::MODULE, place, message, "write a TM3 or TM2 module with channels");
        return None;
    }
    Some(module)
}
