//! The catalogue of expansion modules and cartridges (io: sections 9 and 10): pages of TOML by family in `modules/`, which
//! are built in and read once.
//!
//! A module is a table of one page. What a page states without a `source` is in the documents of the controllers; what
//! nobody knows is left out. A page that is wrong fails a test, so [`modules`] has nothing to report.
//! Not goals: behaviour of modules, rules of configurations (see `profile`).

mod channels;
mod modes;
mod page;
mod source;

pub use channels::channels;
pub use page::{PageFindings, read_pages};

use profile::ModuleType;
use std::sync::OnceLock;

/// Every module, by page and in the order of the page; of one with two kinds of terminals the one with screws first.
pub fn modules() -> &'static [ModuleType] {
    static MODULES: OnceLock<Vec<ModuleType>> = OnceLock::new();
    // That there are no findings is tested.
    MODULES.get_or_init(|| read_pages().0)
}

/// The module of this reference, in any case.
pub fn find(reference: &str) -> Option<&'static ModuleType> {
    modules().iter().find(|module| module.reference.eq_ignore_ascii_case(reference))
}

/// The modules that share an internal ID code with this one, itself left out: the controller takes each for the other
/// (io:OPT-04).
pub fn with_the_same_id(module: &ModuleType) -> impl Iterator<Item = &'static ModuleType> {
    let (id, reference) = (module.id, module.reference.clone());
    modules().iter().filter(move |other| id.is_some() && other.id == id && other.reference != reference)
}
