//! Forced inputs and outputs of modules on the bus (controller:FRC-02).

use signal::{Address, Area};

/// So many places at most are forced at once.
const MOST: usize = 64;

/// A place that is forced.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct ForcedPlace {
    address: Address,
    value: u64,
    /// What acts on an output: the value that its task has come to (controller:FRC-05).
    acting: Option<u64>,
}

/// Places of %I and %Q that are forced, with their values. It has room for 64.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ForcedPlaces {
    places: [Option<ForcedPlace>; MOST],
    /// How many of them are taken.
    count: usize,
}

impl Default for ForcedPlaces {
    fn default() -> ForcedPlaces {
        ForcedPlaces { places: [None; MOST], count: 0 }
    }
}

impl ForcedPlaces {
    /// Each place with its value: a bit, or a word in counts.
    pub fn iter(&self) -> impl Iterator<Item = (Address, u64)> {
        self.places.iter().flatten().map(|place| (place.address, place.value))
    }

    /// Whether none is forced.
    #[inline]
    pub const fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Forces a place. Whether there was room.
    pub(crate) fn force(&mut self, address: Address, value: u64) -> bool {
        let known = self.places.iter().position(|place| place.is_some_and(|place| place.address == address));
        let at = known.or_else(|| self.places.iter().position(Option::is_none));
        let Some(slot) = at.and_then(|at| self.places.get_mut(at)) else { return false };
        let acting = slot.and_then(|before| before.acting);
        self.count += usize::from(slot.is_none());
        *slot = Some(ForcedPlace { address, value, acting });
        true
    }

    /// A place is no longer forced.
    pub(crate) fn release(&mut self, address: Address) {
        for slot in &mut self.places {
            if slot.is_some_and(|place| place.address == address) {
                *slot = None;
                self.count -= 1;
            }
        }
    }

    /// The same places, of which none acts yet.
    pub(crate) fn waiting(self) -> ForcedPlaces {
        let waits = |place: ForcedPlace| ForcedPlace { acting: None, ..place };
        ForcedPlaces { places: self.places.map(|slot| slot.map(waits)), ..self }
    }

    /// The forced inputs.
    pub(super) fn inputs(&self) -> impl Iterator<Item = (Address, u64)> {
        self.iter().filter(|(address, _)| address.area() == Area::Input)
    }

    /// The outputs on which forcing acts, after it came to those that `comes_to` says.
    pub(super) fn outputs(
        &mut self,
        comes_to: impl Fn(Address) -> bool,
    ) -> impl Iterator<Item = (Address, u64)> {
        self.places.iter_mut().flatten().filter(|place| place.address.area() == Area::Output).filter_map(
            move |place| {
                if comes_to(place.address) {
                    place.acting = Some(place.value);
                }
                Some((place.address, place.acting?))
            },
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(text: &str) -> Address {
        text.parse().unwrap()
    }

    #[test]
    fn forcing_comes_to_an_output_with_its_task() {
        let mut forced = ForcedPlaces::default();
        assert!(forced.force(at("%QW4"), 7));
        assert_eq!(forced.outputs(|_| false).count(), 0);
        assert_eq!(forced.outputs(|_| true).next(), Some((at("%QW4"), 7)));
        assert!(forced.force(at("%QW4"), 8));
        assert_eq!(forced.outputs(|_| false).next(), Some((at("%QW4"), 7)));
        assert_eq!(forced.waiting().outputs(|_| false).count(), 0);
        forced.release(at("%QW4"));
        assert!(forced.is_empty());
    }

    #[test]
    fn there_is_room_for_so_many() {
        let mut forced = ForcedPlaces::default();
        let place = |bit| Address::bit(Area::Input, bit);
        assert!((0..MOST as u32).all(|bit| forced.force(place(bit), 1)));
        assert!(!forced.force(place(MOST as u32), 1));
        assert!(forced.force(place(0), 0));
        assert_eq!(forced.inputs().count(), MOST);
    }
}
