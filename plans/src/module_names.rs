//! References of modules in a plan.

use document::{Findings, Node, suggest};
use profile::ModuleType;

use crate::codes;

/// The module of a reference that a plan writes, in any case.
pub(crate) fn find_module(reference: &Node, out: &mut Findings) -> Option<&'static ModuleType> {
    let name = reference.as_text()?.trim();
    let found = catalogue::find(name);
    if found.is_none() {
        let known = catalogue::modules().iter().map(|module| module.reference.as_str());
        let help = match suggest(&name.to_uppercase(), known) {
            Some(near) => format!("did you mean `{near}`? `rig explain modules` lists them"),
            None => String::from("`rig explain modules` lists them"),
        };
        out.bad(codes::MODULE, reference, format!("the catalogue has no module `{name}`"), help);
    }
    found
}
