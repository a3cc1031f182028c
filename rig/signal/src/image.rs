//! A process image or the mapped memory: bytes that are read and written through addresses.

use crate::{Address, Size};

/// The bytes of one area, little-endian (controller:ADDR-01). Its size never changes.
///
/// An image does not know which area it is: the caller picks the image by [`Address::area`]. Addresses are
/// checked against the profile when a program or plan is loaded, so a place beyond the end is not an error
/// here: it reads 0 and takes no value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    bytes: Box<[u8]>,
}

impl Image {
    /// An image of zeros with room for `bits` bits, rounded up to whole bytes.
    pub fn new(bits: u32) -> Self {
        Image { bytes: vec![0; bits.div_ceil(8) as usize].into_boxed_slice() }
    }

    /// All bytes.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// All bytes, to be filled from a driver, a frame or a stored context.
    pub fn bytes_mut(&mut self) -> &mut [u8] {
        &mut self.bytes
    }

    /// Sets every bit to 0.
    pub fn clear(&mut self) {
        self.bytes.fill(0);
    }

    /// The value at `address`, in the low bits; 0 beyond the end.
    #[inline]
    pub fn get(&self, address: Address) -> u64 {
        let at = address.byte_offset() as usize;
        match address.size() {
            Size::Bit => u64::from(self.get_bit(address.bit_offset())),
            Size::Byte => self.bytes.get(at).map_or(0, |b| u64::from(*b)),
            Size::Word => self.read::<2>(at).map_or(0, |b| u64::from(u16::from_le_bytes(b))),
            Size::Double => self.read::<4>(at).map_or(0, |b| u64::from(u32::from_le_bytes(b))),
            Size::Long => self.read::<8>(at).map_or(0, u64::from_le_bytes),
        }
    }

    /// Stores the low bits of `value` at `address`; whether any bit changed. Beyond the end nothing does.
    #[inline]
    pub fn set(&mut self, address: Address, value: u64) -> bool {
        let at = address.byte_offset() as usize;
        match address.size() {
            Size::Bit => self.set_bit(address.bit_offset(), value & 1 == 1),
            Size::Byte => self.write(at, [value as u8]),
            Size::Word => self.write(at, (value as u16).to_le_bytes()),
            Size::Double => self.write(at, (value as u32).to_le_bytes()),
            Size::Long => self.write(at, value.to_le_bytes()),
        }
    }

    /// The `place`th word of 64 bits, from that of bit 0; what is beyond the end reads 0.
    #[inline]
    pub fn word(&self, place: usize) -> u64 {
        match self.bytes.get(place * 8..) {
            Some([a, b, c, d, e, f, g, h, ..]) => u64::from_le_bytes([*a, *b, *c, *d, *e, *f, *g, *h]),
            Some(rest) => rest.iter().rev().fold(0, |word, byte| word << 8 | u64::from(*byte)),
            None => 0,
        }
    }

    /// Stores those bits of the `place`th word of 64 that are 1 in `mask`; whether any changed. Beyond the end nothing does.
    #[inline]
    pub fn set_bits(&mut self, place: usize, mask: u64, bits: u64) -> bool {
        let old = self.word(place);
        let new = (old & !mask | bits & mask).to_le_bytes();
        let before = old.to_le_bytes();
        if new == before {
            return false;
        }
        let Some(bytes) = self.bytes.get_mut(place * 8..) else { return false };
        let mut changed = false;
        for (byte, new) in bytes.iter_mut().zip(new) {
            changed |= std::mem::replace(byte, new) != new;
        }
        changed
    }

    /// The `bit`th bit, from bit 0 of byte 0; FALSE beyond the end.
    #[inline]
    fn get_bit(&self, bit: u32) -> bool {
        self.bytes.get(bit as usize / 8).is_some_and(|b| b >> (bit % 8) & 1 == 1)
    }

    /// Stores the `bit`th bit; whether it changed.
    #[inline]
    fn set_bit(&mut self, bit: u32, on: bool) -> bool {
        let Some(byte) = self.bytes.get_mut(bit as usize / 8) else { return false };
        let mask = 1 << (bit % 8);
        let new = if on { *byte | mask } else { *byte & !mask };
        std::mem::replace(byte, new) != new
    }

    #[inline]
    fn read<const N: usize>(&self, at: usize) -> Option<[u8; N]> {
        self.bytes.get(at..)?.first_chunk().copied()
    }

    #[inline]
    fn write<const N: usize>(&mut self, at: usize, new: [u8; N]) -> bool {
        let place = self.bytes.get_mut(at..).and_then(|rest| rest.first_chunk_mut());
        place.is_some_and(|place| std::mem::replace(place, new) != new)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Area;
    use proptest::prelude::*;

    fn at(text: &str) -> Address {
        Address::parse(text).unwrap()
    }

    #[test]
    fn views_are_little_endian() {
        // controller:ADDR-01, controller:ADDR-07
        let mut image = Image::new(64);
        assert!(image.set(at("%MD0"), 0x1234_5678));
        assert_eq!(image.get(at("%MW0")), 0x5678);
        assert_eq!(image.get(at("%MW1")), 0x1234);
        assert_eq!(image.get(at("%MB0")), 0x78);
        assert_eq!(image.get(at("%MB3")), 0x12);
        assert_eq!(image.get(at("%ML0")), 0x1234_5678);
        assert!(image.set(at("%MW2.9"), 1));
        assert_eq!(image.get(at("%MX5.1")), 1);
        assert_eq!(image.get(at("%MW2")), 0x0200);
        assert!(!image.set(at("%MB5"), 0x02), "nothing changed");
        assert_eq!(image.get(at("%MD2")), 0, "beyond the end");
        assert!(!image.set(at("%MD2"), 1));
        assert!(!image.set(at("%MX8.0"), 1));
    }

    #[test]
    fn words_end_with_the_image() {
        let mut image = Image::new(80);
        assert!(image.set_bits(0, 0xF0, 0xA5));
        assert!(!image.set_bits(0, 0xF0, 0xAF), "no bit of the mask changed");
        assert!(image.set_bits(1, u64::MAX, 0x1234_5678));
        assert_eq!((image.word(0), image.word(1), image.word(2)), (0xA0, 0x5678, 0));
        assert!(!image.set_bits(1, 0xFFFF_0000, u64::MAX), "beyond the end");
        assert!(!image.set_bits(2, u64::MAX, 1));
        assert_eq!(image.get(at("%MW4")), 0x5678);
    }

    proptest! {
        /// Words against an oracle of single bits.
        #[test]
        fn words_equal_single_bits(ops in proptest::collection::vec((0usize..4, any::<u64>(), any::<u64>()), 1..20)) {
            let mut image = Image::new(160);
            let mut oracle = [false; 160];
            for (place, mask, bits) in ops {
                let mut changed = false;
                for bit in (0..64).filter(|bit| mask >> bit & 1 == 1) {
                    if let Some(one) = oracle.get_mut(place * 64 + bit) {
                        let new = bits >> bit & 1 == 1;
                        changed |= std::mem::replace(one, new) != new;
                    }
                }
                prop_assert_eq!(image.set_bits(place, mask, bits), changed);
                for (bit, on) in oracle.iter().enumerate() {
                    prop_assert_eq!(image.get_bit(bit as u32), *on);
                    prop_assert_eq!(image.word(bit / 64) >> (bit % 64) & 1 == 1, *on);
                }
            }
        }

        /// Every access against an oracle of single bits.
        #[test]
        fn accesses_equal_single_bits(ops in proptest::collection::vec((0u8..5, 0u32..200, any::<u64>()), 1..60)) {
            let mut image = Image::new(160);
            let mut oracle = [false; 160];
            for (size, index, value) in ops {
                let size = [Size::Bit, Size::Byte, Size::Word, Size::Double, Size::Long][usize::from(size)];
                let address = Address::new(Area::Memory, size, index).unwrap();
                let (first, len) = (address.bit_offset() as usize, address.bit_len() as usize);
                let mut changed = false;
                if first + len <= oracle.len() {
                    for k in 0..len {
                        let bit = value >> k & 1 == 1;
                        changed |= oracle[first + k] != bit;
                        oracle[first + k] = bit;
                    }
                    prop_assert_eq!(image.set(address, value), changed);
                    prop_assert_eq!(image.get(address), value & (u64::MAX >> (64 - len)));
                } else {
                    prop_assert!(!image.set(address, value));
                    prop_assert_eq!(image.get(address), 0);
                }
                for (k, bit) in oracle.iter().enumerate() {
                    prop_assert_eq!(image.get_bit(k as u32), *bit);
                }
            }
        }
    }
}
