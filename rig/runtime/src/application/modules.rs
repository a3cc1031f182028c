//! Expansion modules of a plan's settings, as the controller is configured with them.

use crate::codes;
use controller::is_module_modelled;
use document::Diagnostic;
use plans::plan::ModuleSettings;
use profile::{
    CompositionError, CompositionFault, ConfiguredModule, ModuleType, Profile, Reference, check_modules,
};

/// The configured modules.
///
/// # Errors
/// The first rule that a controller of the profile finds broken, at the module of the plan.
pub fn configure(
    settings: &[ModuleSettings],
    profile: Profile,
    reference: &'static Reference,
    plan: &str,
) -> Result<Vec<ConfiguredModule<'static>>, Vec<Diagnostic>> {
    let modules = configured(settings);
    let refused = |place: usize, code, message: String, help: &str| {
        let at = settings.get(place).map_or(0..0, |one| one.place.clone());
        vec![Diagnostic::error(code, message).at(plan, at, "").help(help)]
    };
    if let Err(error) = check_modules(profile, reference, &modules) {
        let (code, help) = answer(&error);
        return Err(refused(error.place, code, error.to_string(), help));
    }
    if let Some(place) = modules.iter().position(|one| !is_module_modelled(one.module)) {
        let message = format!("the rig has no model of `{}` yet", modules[place].module.reference);
        let help = "leave the module out: all others of the catalogue have one";
        return Err(refused(place, codes::MODULE_NOT_MODELLED, message, help));
    }
    if let Err(full) = reference.module_addresses(&modules) {
        let help = "leave modules out until their channels fit";
        return Err(refused(full.place, codes::IMAGE_FULL, full.to_string(), help));
    }
    Ok(modules)
}

/// The modules of a board file, which was held against the catalogue.
pub(crate) fn fitted(references: &[String]) -> Vec<&'static ModuleType> {
    references.iter().filter_map(|reference| catalogue::find(reference)).collect()
}

/// The modules as they stand in the plan.
pub(crate) fn configured(settings: &[ModuleSettings]) -> Vec<ConfiguredModule<'static>> {
    let one = |one: &ModuleSettings| ConfiguredModule {
        module: one.module,
        optional: one.optional,
        status_enabled: one.status,
        sampling: one.sampling,
        always_update: one.always_update,
        inputs: one.inputs.clone(),
        outputs: one.outputs.clone(),
    };
    settings.iter().map(one).collect()
}

/// The code of what is wrong with a list of modules, and what to do.
fn answer(error: &CompositionError) -> (&'static str, &'static str) {
    match error.fault {
        CompositionFault::NotOfProfile(_) => (
            codes::MODULE_OF_ANOTHER_PROFILE,
            "`rig explain` with its reference names the profiles that have it",
        ),
        CompositionFault::TooMany { .. } => (codes::TOO_MANY_MODULES, "leave one out"),
        CompositionFault::SecondLink | CompositionFault::NoTransmitter | CompositionFault::NoReceiver => (
            codes::MODULE_LINK,
            "write TM3XTRA1 and TM3XREC1 once, one after the other, before the remote modules",
        ),
        CompositionFault::Tm2WithLink { .. } | CompositionFault::Tm2BeforeTm3 { .. } => {
            (codes::MODULE_ORDER, "write TM2 modules last, in a list without TM3XTRA1 and TM3XREC1")
        }
        CompositionFault::NeverOptional | CompositionFault::NoOptionalModules(_) => {
            (codes::MODULE_NEVER_OPTIONAL, "remove `optional = true`")
        }
        CompositionFault::NoUpdateOfOne(_) => {
            (codes::CONFIGURATION_REFUSED, "remove it, and write `always-update` of the settings")
        }
        CompositionFault::OptionalTwin { .. } => {
            (codes::OPTIONAL_TWINS, "write a mandatory module between the two, or make one of them mandatory")
        }
    }
}
