//! What is fitted on the bus, and how far the controller reaches.
//!
//! The modules are a chain: each passes bus and supply on to the next. So where one is pulled the controller reaches none of
//! those after it either, and those of them that are supplied by the bus are off. Remote modules are supplied by the receiver
//! (io: 10.3).

use super::start::{ConfiguredPosition, ExtraModules, compare_modules};
use profile::ModuleType;

/// A place on the bus.
#[derive(Clone, Copy, Debug)]
struct Slot {
    /// What is fitted there at first.
    first: Option<&'static ModuleType>,
    /// What is fitted there now.
    module: Option<&'static ModuleType>,
    /// Nothing is: the chain is interrupted.
    pulled: bool,
    /// It disturbs the exchange with the modules beside it (io:ERR-15).
    disturbs: bool,
}

/// The fitted modules: a place for each configured one, empty where nothing of its code is fitted, and then one for each of
/// those that are left.
#[derive(Debug)]
pub(super) struct FittedModules {
    slots: Vec<Slot>,
    /// How many of the places are local; the others come after the receiver.
    local: usize,
    /// The bus has its supply (io:HW-04).
    supplied: bool,
    /// Transmitter and receiver are joined.
    linked: bool,
}

impl FittedModules {
    /// What is fitted, next to what is configured; `local` positions of it are before the transmitter.
    pub(super) fn new(
        configured: &[ConfiguredPosition],
        local: usize,
        fitted: &[&'static ModuleType],
    ) -> FittedModules {
        let slot = |module| Slot { first: module, module, pulled: false, disturbs: false };
        let ids: Vec<Option<u8>> = fitted.iter().map(|module| module.id).collect();
        let start = compare_modules(configured, &ids, ExtraModules::default());
        let places = configured.iter().map(|one| start.modules.get(one.index).and_then(|found| found.place));
        let mut slots: Vec<Slot> =
            places.map(|place| slot(place.and_then(|place| fitted.get(place).copied()))).collect();
        let left = fitted.len().saturating_sub(start.extra);
        slots.extend(fitted.iter().skip(left).map(|module| slot(Some(*module))));
        // What is left over is at the end of the chain.
        let local = if local == configured.len() { slots.len() } else { local };
        FittedModules { slots, local, supplied: true, linked: true }
    }

    /// What is fitted at a place.
    pub(super) fn module(&self, place: usize) -> Option<&'static ModuleType> {
        self.slots.get(place).and_then(|slot| slot.module)
    }

    /// The places that the controller reaches and that are not empty, in the order of the bus.
    pub(super) fn reached(&self) -> impl Iterator<Item = usize> {
        let whole = self.slots.iter().take_while(|slot| !slot.pulled).enumerate();
        let reached = whole.filter(|(place, slot)| {
            self.supplied && (self.linked || *place < self.local) && slot.module.is_some()
        });
        reached.map(|(place, _)| place)
    }

    /// Whether what is fitted at a place has its supply: from the controller through all modules before it, or from the
    /// receiver.
    pub(super) fn is_supplied(&self, place: usize) -> bool {
        let (first, supplied) = if place < self.local { (0, self.supplied) } else { (self.local, true) };
        let chain = self.slots.get(first..=place);
        supplied
            && self.module(place).is_some()
            && chain.is_some_and(|all| all.iter().all(|slot| !slot.pulled))
    }

    /// Whether a module beside this place disturbs its exchange.
    pub(super) fn is_disturbed(&self, place: usize) -> bool {
        let reached: Vec<usize> = self.reached().collect();
        let Some(at) = reached.iter().position(|one| *one == place) else { return false };
        let beside = [at.checked_sub(1), Some(at + 1)].into_iter().flatten();
        beside.filter_map(|at| self.slots.get(*reached.get(at)?)).any(|slot| slot.disturbs)
    }

    /// A module is pulled out, or put back.
    pub(super) fn pull(&mut self, place: usize, pulled: bool) {
        if let Some(slot) = self.slots.get_mut(place) {
            slot.pulled = pulled;
        }
    }

    /// Another module takes the place of what is fitted; with none, what was fitted at first.
    pub(super) fn replace(&mut self, place: usize, module: Option<&'static ModuleType>) {
        if let Some(slot) = self.slots.get_mut(place) {
            slot.module = module.or(slot.first);
        }
    }

    /// A module disturbs those beside it, or stops.
    pub(super) fn disturb(&mut self, place: usize, disturbs: bool) {
        if let Some(slot) = self.slots.get_mut(place) {
            slot.disturbs = disturbs;
        }
    }

    /// The bus has its supply, or not.
    pub(super) fn supply(&mut self, supplied: bool) {
        self.supplied = supplied;
    }

    /// Whether the bus has its supply.
    pub(super) fn has_supply(&self) -> bool {
        self.supplied
    }

    /// Transmitter and receiver are joined, or not.
    pub(super) fn link(&mut self, linked: bool) {
        self.linked = linked;
    }
}

#[cfg(test)]
mod tests {
    use super::super::start::tests::positions;
    use super::*;
    use profile::{ModuleFamily, ModuleKind};

    fn module(id: u8) -> &'static ModuleType {
        let mut module = ModuleType::new("TM3TEST", ModuleFamily::Tm3, ModuleKind::Digital);
        module.id = Some(id);
        Box::leak(Box::new(module))
    }

    fn fitted(codes: &[i16], local: usize, ids: &[u8]) -> FittedModules {
        let modules: Vec<&'static ModuleType> = ids.iter().map(|id| module(*id)).collect();
        FittedModules::new(&positions(codes), local, &modules)
    }

    fn ids(all: &FittedModules) -> Vec<Option<u8>> {
        (0..all.slots.len()).map(|place| all.module(place).and_then(|module| module.id)).collect()
    }

    fn reached(all: &FittedModules) -> Vec<usize> {
        all.reached().collect()
    }

    #[test]
    fn each_configured_module_has_a_place() {
        assert_eq!(ids(&fitted(&[-1, 2, 3], 3, &[2, 3])), [None, Some(2), Some(3)]);
        assert_eq!(ids(&fitted(&[1, 2], 2, &[1])), [Some(1), None]);
        assert_eq!(ids(&fitted(&[1], 1, &[1, 7, 8])), [Some(1), Some(7), Some(8)]);
        assert_eq!(reached(&fitted(&[-1, 2, 3], 3, &[2, 3])), [1, 2]);
    }

    #[test]
    fn a_module_that_is_pulled_takes_those_after_it_along() {
        let mut all = fitted(&[1, 2, 3, 4], 2, &[1, 2, 3, 4]);
        all.pull(1, true);
        assert_eq!(reached(&all), [0]);
        // Remote modules have a supply of their own.
        assert_eq!([0, 1, 2, 3].map(|place| all.is_supplied(place)), [true, false, true, true]);
        all.pull(1, false);
        all.pull(2, true);
        assert_eq!(reached(&all), [0, 1]);
        assert_eq!([0, 1, 2, 3].map(|place| all.is_supplied(place)), [true, true, false, false]);
    }

    #[test]
    fn supply_and_link_reach_so_far() {
        let mut all = fitted(&[1, 2, 3], 2, &[1, 2, 3]);
        all.link(false);
        assert_eq!(reached(&all), [0, 1]);
        assert!(all.is_supplied(2));
        all.link(true);
        all.supply(false);
        assert_eq!(reached(&all), [0; 0]);
        assert_eq!([0, 1, 2].map(|place| all.is_supplied(place)), [false, false, true]);
    }

    #[test]
    fn those_beside_a_module_are_disturbed() {
        let mut all = fitted(&[1, -2, 3, 4], 4, &[1, 3, 4]);
        all.disturb(2, true);
        // The place between them is empty.
        assert_eq!([0, 1, 2, 3].map(|place| all.is_disturbed(place)), [true, false, false, true]);
    }
}
