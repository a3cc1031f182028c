//! What a list of configured modules may be (io: sections 9, 10 and 12).

use super::{ConfiguredModule, ModuleFamily, ModuleKind};
use crate::{Family, Profile, Reference};
use std::fmt;

/// Most local TM3 and TM2 modules (io:BUS-01).
pub const LOCAL_MODULES: usize = 7;

/// Most remote TM3 modules (io:BUS-01).
pub const REMOTE_MODULES: usize = 7;

/// Most TM4 modules (io:BUS-01).
pub const TM4_MODULES: usize = 3;

/// The indices of TM3_MODULE_R: local modules from 0 on, remote ones from [`LOCAL_MODULES`] on (io:BUS-05; which index the
/// first remote module has beside fewer than seven local ones is a rig definition).
pub const MODULE_INDICES: usize = LOCAL_MODULES + REMOTE_MODULES;

/// A part of a configuration with a limit of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ModuleChain {
    /// TM3 and TM2 modules before the transmitter.
    Local,
    /// TM3 modules after the receiver.
    Remote,
    /// TM4 modules.
    Tm4,
    /// Cartridges.
    Cartridges,
}

impl fmt::Display for ModuleChain {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            ModuleChain::Local => "local TM3 and TM2 modules",
            ModuleChain::Remote => "remote TM3 modules",
            ModuleChain::Tm4 => "TM4 modules",
            ModuleChain::Cartridges => "cartridges",
        })
    }
}

/// Why a module cannot be where it is in the list. Places are those of the list, from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CompositionFault {
    /// The profile does not know the module (io: 10.1, io:CART-01).
    NotOfProfile(Profile),
    /// It is one too many of its chain (io:BUS-01; for cartridges a rig definition).
    TooMany {
        /// The chain.
        chain: ModuleChain,
        /// How many it takes.
        most: usize,
    },
    /// A second transmitter or receiver.
    SecondLink,
    /// A receiver without a transmitter directly before it on the bus.
    NoTransmitter,
    /// A transmitter without a receiver directly after it on the bus.
    NoReceiver,
    /// A TM2 module in a configuration with a transmitter or receiver, which is at this place (io:BUS-03).
    Tm2WithLink {
        /// Place of the transmitter or receiver.
        link: usize,
    },
    /// A TM2 module before the TM3 module at this place (io:BUS-02).
    Tm2BeforeTm3 {
        /// Place of the TM3 module.
        tm3: usize,
    },
    /// It is optional and is no TM3 or TM2 module with channels (io:OPT-01, io:CART-02).
    NeverOptional,
    /// It is optional, and the profile has no optional modules (io: section 12 is of 2019 and later).
    NoOptionalModules(Profile),
    /// All of its variables are to be updated, which is set for the controller as a whole in this profile (io:BUS-10).
    NoUpdateOfOne(Profile),
    /// It and the module at this place are optional and of one internal ID code, and no mandatory one is between them
    /// (io:OPT-05).
    OptionalTwin {
        /// Place of the other one, before it.
        other: usize,
        /// The ID code of both.
        id: u8,
    },
}

/// A module that cannot be where it is, and why.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CompositionError {
    /// Its place in the list, from 0.
    pub place: usize,
    /// What is wrong.
    pub fault: CompositionFault,
}

impl fmt::Display for CompositionError {
    /// After the name of the module: places are counted from 1 here.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "module {} of the list ", self.place + 1)?;
        match self.fault {
            CompositionFault::NotOfProfile(profile) => write!(f, "is none of profile {profile}"),
            CompositionFault::TooMany { chain, most } => write!(f, "is one too many: at most {most} {chain}"),
            CompositionFault::SecondLink => f.write_str("is a second transmitter or receiver"),
            CompositionFault::NoTransmitter => f.write_str("is a receiver without a transmitter before it"),
            CompositionFault::NoReceiver => f.write_str("is a transmitter without a receiver after it"),
            CompositionFault::Tm2WithLink { link } => {
                write!(f, "is of TM2, which goes with no transmitter or receiver (module {})", link + 1)
            }
            CompositionFault::Tm2BeforeTm3 { tm3 } => {
                write!(f, "is of TM2 and stands before module {}, which is of TM3", tm3 + 1)
            }
            CompositionFault::NeverOptional => f.write_str("cannot be optional"),
            CompositionFault::NoOptionalModules(profile) => {
                write!(f, "is optional, which profile {profile} does not know")
            }
            CompositionFault::NoUpdateOfOne(profile) => {
                write!(f, "has `always-update` of its own, which profile {profile} does not know")
            }
            CompositionFault::OptionalTwin { other, id } => write!(
                f,
                "and module {} are optional and of ID code {id}, and no mandatory module is between them",
                other + 1
            ),
        }
    }
}

impl std::error::Error for CompositionError {}

impl Profile {
    /// Whether modules can be optional (io: section 12): not in the document of 2014.
    pub const fn has_optional_modules(self) -> bool {
        matches!(self, Profile::M241_2019 | Profile::M251_2024)
    }
}

impl Reference {
    /// How many cartridges it takes: 1 with 24 channels and 2 with 40 (rig definition), none of an M251 (io:CART-01).
    pub const fn cartridge_slots(&self) -> usize {
        match self.family {
            Family::M251 => 0,
            Family::M241 if self.input_count() > 14 => 2,
            Family::M241 => 1,
        }
    }
}

/// Whether a list of modules can be configured on this reference with this profile.
///
/// # Errors
/// The first rule that is broken, in this order: each module by itself, the link, the limits, TM2 modules, optional ones.
pub fn check_modules(
    profile: Profile,
    reference: &Reference,
    modules: &[ConfiguredModule<'_>],
) -> Result<(), CompositionError> {
    for (place, one) in modules.iter().enumerate() {
        if !one.module.profiles.contains(&profile) {
            return fail(place, CompositionFault::NotOfProfile(profile));
        }
        if one.optional && !one.module.is_on_bus() {
            return fail(place, CompositionFault::NeverOptional);
        }
        if one.optional && !profile.has_optional_modules() {
            return fail(place, CompositionFault::NoOptionalModules(profile));
        }
        if one.always_update && profile != Profile::M241_2014 {
            return fail(place, CompositionFault::NoUpdateOfOne(profile));
        }
    }
    check_link(modules)?;
    check_limits(reference, modules)?;
    check_tm2(modules)?;
    check_optional(modules)
}

fn fail(place: usize, fault: CompositionFault) -> Result<(), CompositionError> {
    Err(CompositionError { place, fault })
}

/// The modules of the TM3 and TM2 bus with their places: links are among them.
fn bus<'a>(modules: &'a [ConfiguredModule<'a>]) -> impl Iterator<Item = (usize, &'a ConfiguredModule<'a>)> {
    let families =
        |one: &ConfiguredModule<'_>| matches!(one.module.family, ModuleFamily::Tm2 | ModuleFamily::Tm3);
    modules.iter().enumerate().filter(move |(_, one)| families(one))
}

/// A transmitter and a receiver are there together, the receiver next after the transmitter, or neither (io:BUS-01).
fn check_link(modules: &[ConfiguredModule<'_>]) -> Result<(), CompositionError> {
    let (mut waiting, mut complete) = (None, false);
    for (place, one) in bus(modules) {
        match (one.module.kind, waiting) {
            (ModuleKind::Transmitter, None) if !complete => waiting = Some(place),
            (ModuleKind::Receiver, Some(_)) => (waiting, complete) = (None, true),
            (ModuleKind::Transmitter | ModuleKind::Receiver, None) if complete => {
                return fail(place, CompositionFault::SecondLink);
            }
            (ModuleKind::Receiver, None) => return fail(place, CompositionFault::NoTransmitter),
            (_, Some(transmitter)) => return fail(transmitter, CompositionFault::NoReceiver),
            (_, None) => {}
        }
    }
    waiting.map_or(Ok(()), |transmitter| fail(transmitter, CompositionFault::NoReceiver))
}

/// Each chain against its limit (io:BUS-01, io:CART-01).
fn check_limits(reference: &Reference, modules: &[ConfiguredModule<'_>]) -> Result<(), CompositionError> {
    let mut remote = false;
    // In the order of the chains.
    let mut counts = [0; 4];
    for (place, one) in modules.iter().enumerate() {
        if one.module.kind.is_link() {
            remote = true;
            continue;
        }
        let (chain, most) = match one.module.family {
            ModuleFamily::Tm4 => (ModuleChain::Tm4, TM4_MODULES),
            ModuleFamily::Tmc4 => (ModuleChain::Cartridges, reference.cartridge_slots()),
            _ if remote => (ModuleChain::Remote, REMOTE_MODULES),
            _ => (ModuleChain::Local, LOCAL_MODULES),
        };
        let count = &mut counts[chain as usize];
        *count += 1;
        if *count > most {
            return fail(place, CompositionFault::TooMany { chain, most });
        }
    }
    Ok(())
}

/// TM2 modules are last in the local configuration, and go with no link (io:BUS-02, io:BUS-03).
fn check_tm2(modules: &[ConfiguredModule<'_>]) -> Result<(), CompositionError> {
    let Some((tm2, _)) = bus(modules).find(|(_, one)| one.module.family == ModuleFamily::Tm2) else {
        return Ok(());
    };
    if let Some((link, _)) = bus(modules).find(|(_, one)| one.module.kind.is_link()) {
        return fail(tm2, CompositionFault::Tm2WithLink { link });
    }
    match bus(modules).find(|(place, one)| *place > tm2 && one.module.family == ModuleFamily::Tm3) {
        Some((tm3, _)) => fail(tm2, CompositionFault::Tm2BeforeTm3 { tm3 }),
        None => Ok(()),
    }
}

/// Two optional modules of one ID code have a mandatory one between them (io:OPT-05). A transmitter or receiver has no ID code,
/// so it separates nothing.
fn check_optional(modules: &[ConfiguredModule<'_>]) -> Result<(), CompositionError> {
    // The optional modules since the last mandatory one.
    let mut optional: Vec<(usize, u8)> = Vec::new();
    for (place, one) in bus(modules) {
        match one.module.id {
            Some(id) if one.optional => {
                if let Some((other, _)) = optional.iter().find(|(_, known)| *known == id) {
                    return fail(place, CompositionFault::OptionalTwin { other: *other, id });
                }
                optional.push((place, id));
            }
            Some(_) => optional.clear(),
            None => {}
        }
    }
    Ok(())
}

/// The index in TM3_MODULE_R of each module of a list that was found right: none of a link, a TM4 module or a cartridge
/// (io:BUS-05).
pub fn module_indices(modules: &[ConfiguredModule<'_>]) -> Vec<Option<usize>> {
    let mut next = 0;
    let indices = modules.iter().map(|one| {
        if one.module.kind.is_link() {
            next = LOCAL_MODULES;
        }
        one.module.is_on_bus().then(|| {
            next += 1;
            next - 1
        })
    });
    indices.collect()
}
