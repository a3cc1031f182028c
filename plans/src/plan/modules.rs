//! `settings.modules`: the expansion modules and cartridges that the application is configured with (io: sections 9, 10).
//!
//! ```toml
//! settings = { modules = ["TM3DI16", { type = "TM3AI4", inputs = [{ mode = "4..20 mA", min = 0, max = 10000 }] }] }
//! ```
//! What may stand where in the list is the controller's to say; here each is looked up in the catalogue.

use std::ops::Range;

use document::{Fields, Findings, KeySpec, KeyType, Node};
use profile::{AnalogueInputSettings, AnalogueOutputSettings, ModuleType};
use signal::Span;

use super::analogue;
use crate::codes;
use crate::module_names::find_module;

/// The keys of a module.
const MODULE_KEYS: &[KeySpec] = &[
    KeySpec::required("type", KeyType::Text, "Its reference, as in TM3DI16."),
    KeySpec::optional("optional", KeyType::Bool, "Whether it may be missing on the bus; FALSE if left out."),
    KeySpec::optional("inputs", analogue::INPUTS_TYPE, "Its analogue inputs, from the first on."),
    KeySpec::optional("outputs", analogue::OUTPUTS_TYPE, "Its analogue outputs, from the first on."),
    KeySpec::optional(
        "status",
        KeyType::Bool,
        "Whether an analogue module has status bytes in %I; TRUE if left out.",
    ),
    KeySpec::optional("sampling", KeyType::Duration, "The time of a conversion for each channel in use."),
    KeySpec::optional(
        "always-update",
        KeyType::Bool,
        "In 2014: the bus cycle task exchanges all of its channels, used or not; FALSE if left out.",
    ),
];

/// A module: its reference alone, or a table.
const MODULE_TYPE: KeyType = KeyType::Either(&[KeyType::Text, KeyType::Table(MODULE_KEYS)]);

/// The type of `settings.modules`.
pub(super) const MODULES_TYPE: KeyType = KeyType::List(&MODULE_TYPE);

/// More than any controller takes: 14 modules, the link between them, TM4 modules and cartridges.
const MOST: usize = 32;

/// What a plan says of a module.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ModuleSettings {
    /// What the catalogue says of its reference.
    pub module: &'static ModuleType,
    /// The parameter *Optional module* (io:OPT-01).
    pub optional: bool,
    /// The parameter *Status Enabled*.
    pub status: bool,
    /// The time of a conversion, where the module has a choice.
    pub sampling: Option<Span>,
    /// The bus cycle task exchanges all of its channels, whatever the controller's choice is (io:BUS-11).
    pub always_update: bool,
    /// Its analogue inputs from the first on; none for one that is not used.
    pub inputs: Vec<Option<AnalogueInputSettings<'static>>>,
    /// Its analogue outputs from the first on; none for one that is not used.
    pub outputs: Vec<Option<AnalogueOutputSettings<'static>>>,
    /// Its bytes of the plan.
    pub place: Range<usize>,
}

/// Reads the modules of settings that were held against their keys.
pub(super) fn read(fields: &Fields<'_>, out: &mut Findings) -> Vec<ModuleSettings> {
    let list = fields.each("modules");
    if let Some(node) = list.get(MOST) {
        out.bad(codes::MODULE, node, format!("more than {MOST} modules"), "no controller takes so many");
    }
    list.iter().take(MOST).filter_map(|node| module(node, out)).collect()
}

fn module(node: &Node, out: &mut Findings) -> Option<ModuleSettings> {
    let fields = node.as_table().map(|table| Fields::checked(table, MODULE_KEYS));
    let reference = match &fields {
        Some(fields) => fields.get("type")?,
        None => node,
    };
    let module = find_module(reference, out)?;
    let mut settings = ModuleSettings {
        module,
        optional: false,
        status: true,
        sampling: None,
        always_update: false,
        inputs: Vec::new(),
        outputs: Vec::new(),
        place: reference.span.clone(),
    };
    if let Some(fields) = &fields {
        if let Some(entry) = fields.entry("status").filter(|_| module.status_bytes() == 0) {
            let message = format!("{} has no status bytes", module.reference);
            let help = "remove `status`: only a module with analogue channels has it";
            out.error(codes::CHANNEL_KEY, entry.key_span.clone(), message, help);
        }
        settings.optional = fields.boolean("optional").unwrap_or(false);
        settings.status = fields.boolean("status").unwrap_or(true);
        settings.always_update = fields.boolean("always-update").unwrap_or(false);
        settings.sampling = analogue::sampling(fields, module, out);
        settings.inputs = analogue::inputs(fields, module, out);
        settings.outputs = analogue::outputs(fields, module, out);
    }
    Some(settings)
}
