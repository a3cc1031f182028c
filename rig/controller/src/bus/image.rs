//! The virtual image of inputs and outputs on the bus (io:BUS-09).

use crate::memory::Memory;
use profile::Profile;
use signal::{Address, Area, Image};

/// The bits of the images that somebody exchanges with the virtual image, by words of 64: a rack has some hundred bytes, and a
/// cycle does not go through them one by one.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct SharedBits {
    /// Words of %I, each with the bits that are meant.
    inputs: Vec<(usize, u64)>,
    /// Words of %Q, each with the bits that are meant.
    outputs: Vec<(usize, u64)>,
}

impl SharedBits {
    /// Those of the places that are meant.
    pub(crate) fn of(
        places: impl Iterator<Item = Address>,
        is_meant: impl Fn(Address) -> bool,
    ) -> SharedBits {
        let mut shared = SharedBits::default();
        for place in places.filter(|place| is_meant(*place)) {
            let list = match place.area() {
                Area::Input => &mut shared.inputs,
                Area::Output => &mut shared.outputs,
                Area::Memory => continue,
            };
            let first = place.bit_offset();
            for bit in first..first + place.bit_len() {
                let (word, mask) = (bit as usize / 64, 1 << (bit % 64));
                match list.last_mut() {
                    Some((last, bits)) if *last == word => *bits |= mask,
                    _ => list.push((word, mask)),
                }
            }
        }
        for list in [&mut shared.inputs, &mut shared.outputs] {
            list.sort_unstable();
            list.dedup_by(|later, first| {
                let same = later.0 == first.0;
                if same {
                    first.1 |= later.1;
                }
                same
            });
        }
        shared
    }

    /// Whether a place is among them, whole.
    pub(super) fn has(&self, address: Address) -> bool {
        let list = match address.area() {
            Area::Input => &self.inputs,
            Area::Output => &self.outputs,
            Area::Memory => return false,
        };
        let first = address.bit_offset();
        let has =
            |bit: u32| list.iter().any(|(at, mask)| *at == bit as usize / 64 && mask >> (bit % 64) & 1 == 1);
        (first..first + address.bit_len()).all(has)
    }

    /// Sets their %Q to 0; whether that changed.
    pub(crate) fn clear_outputs(&self, memory: &mut Memory) -> bool {
        let clear = |(at, mask): &(usize, u64)| memory.clear_output_bits(*at, *mask);
        self.outputs.iter().map(clear).fold(false, |any, changed| any | changed)
    }
}

/// What the bus cycle last read, and what it writes next. Places are those of %I and %Q.
#[derive(Clone, Debug)]
pub(crate) struct VirtualImage {
    pub(crate) inputs: Image,
    pub(crate) outputs: Image,
}

impl VirtualImage {
    /// An image of zeros.
    pub(crate) fn new(profile: Profile) -> VirtualImage {
        let image = |area| Image::new(profile.address_limits().bits(area));
        VirtualImage { inputs: image(Area::Input), outputs: image(Area::Output) }
    }

    /// Sets every bit to 0.
    pub(crate) fn clear(&mut self) {
        self.inputs.clear();
        self.outputs.clear();
    }

    /// Inputs -> %I; whether that changed.
    #[inline]
    pub(crate) fn to_inputs(&self, shared: &SharedBits, memory: &mut Memory) -> bool {
        let put = |(at, mask): &(usize, u64)| memory.set_input_bits(*at, *mask, self.inputs.word(*at));
        shared.inputs.iter().map(put).fold(false, |any, changed| any | changed)
    }

    /// %Q -> outputs.
    #[inline]
    pub(crate) fn take_outputs(&mut self, shared: &SharedBits, memory: &Memory) {
        for (at, mask) in &shared.outputs {
            self.outputs.set_bits(*at, *mask, memory.output_word(*at));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn places(texts: &[&str]) -> impl Iterator<Item = Address> {
        texts.iter().map(|text| text.parse().unwrap())
    }

    #[test]
    fn bits_and_words_become_words_with_masks() {
        let all = places(&["%IX3.6", "%IX3.7", "%IX4.0", "%IW4", "%IX0.0", "%QX2.1", "%QW2"]);
        let shared = SharedBits::of(all, |address| address != "%IX3.6".parse().unwrap());
        assert_eq!(shared.inputs, [(0, 0x01_8000_0001), (1, 0xFFFF)]);
        assert_eq!(shared.outputs, [(0, 0xFFFF_0002_0000)]);
    }

    #[test]
    fn only_the_bits_that_are_meant_are_exchanged() {
        let mut memory = Memory::new(Profile::default());
        let mut image = VirtualImage::new(Profile::default());
        image.inputs.bytes_mut()[3] = 0xFF;
        let shared = SharedBits::of(places(&["%IX3.6", "%QX2.1"]), |_| true);
        assert!(image.to_inputs(&shared, &mut memory));
        assert!(!image.to_inputs(&shared, &mut memory), "nothing is new");
        assert_eq!(memory.load("%IB3".parse().unwrap()), 0x40);
        memory.store("%QB2".parse().unwrap(), 0xFF);
        image.take_outputs(&shared, &memory);
        assert_eq!(image.outputs.bytes()[2], 0x02);
    }
}
