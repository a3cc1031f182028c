//! `settings.modules`: the expansion modules and cartridges that the application is configured with (io: sections 9, 10).
//!
//! ```toml
//! settings = { modules = ["TM3DI16", { type = "TM3DQ16T", optional = true }] }
//! ```
//! What may stand where in the list is the controller's to say; here each is looked up in the catalogue.

use std::ops::Range;

use document::{Fields, Findings, KeySpec, KeyType, Node};
use profile::ModuleType;

use crate::codes;
use crate::module_names::find_module;

/// The keys of a module.
const MODULE_KEYS: &[KeySpec] = &[
    KeySpec::required("type", KeyType::Text, "Its reference, as in TM3DI16."),
    KeySpec::optional("optional", KeyType::Bool, "Whether it may be missing on the bus; FALSE if left out."),
];

/// A module: its reference alone, or a table.
const MODULE_TYPE: KeyType = KeyType::Either(&[KeyType::Text, KeyType::Table(MODULE_KEYS)]);

/// The type of `settings.modules`.
pub(super) const MODULES_TYPE: KeyType = KeyType::List(&MODULE_TYPE);

/// More than any controller takes: 14 modules, the link between them, TM4 modules and cartridges.
const MOST: usize = 32;

/// What a plan says of a module.
#[derive(Clone, Debug, PartialEq)]
pub struct ModuleSettings {
    /// What the catalogue says of its reference.
    pub module: &'static ModuleType,
    /// The parameter *Optional module* (io:OPT-01).
    pub optional: bool,
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
    Some(ModuleSettings {
        module: find_module(reference, out)?,
        optional: fields.as_ref().and_then(|fields| fields.boolean("optional")).unwrap_or(false),
        place: reference.span.clone(),
    })
}
