//! How a sample of one input lies in the buffer of a device, and how samples of several lie beside each other.

/// A sample of one input, as its driver says in `scan_elements/in_..._type`, such as `le:s12/16>>4`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Element {
    /// The first byte is the highest one.
    pub big_endian: bool,
    /// The code is of two's complement.
    pub signed: bool,
    /// Bits of the code, 1 to 64.
    pub bits: u8,
    /// Bytes that it takes in the buffer: 1, 2, 4 or 8.
    pub bytes: u8,
    /// Bits below the code that mean nothing.
    pub shift: u8,
}

impl Element {
    /// Reads the description of a sample. `None` where it is none, or of more numbers than one.
    pub fn parse(text: &str) -> Option<Element> {
        let (order, rest) = text.trim().split_once(':')?;
        let big_endian = match order {
            "be" => true,
            "le" => false,
            _ => return None,
        };
        let signed = match rest.chars().next()? {
            's' | 'S' => true,
            'u' | 'U' => false,
            _ => return None,
        };
        let (bits, rest) = rest.get(1..)?.split_once('/')?;
        let (storage, shift) = rest.split_once(">>").unwrap_or((rest, "0"));
        let storage = match storage.split_once('X') {
            Some((storage, "1")) => storage,
            Some(_) => return None,
            None => storage,
        };
        let (bits, shift): (u8, u8) = (bits.parse().ok()?, shift.parse().ok()?);
        let storage: u8 = storage.parse().ok()?;
        let fits = [8, 16, 32, 64].contains(&storage)
            && bits > 0
            && bits.checked_add(shift).is_some_and(|used| used <= storage);
        fits.then_some(Element { big_endian, signed, bits, bytes: storage / 8, shift })
    }

    /// The code in the bytes of a sample, of which there are as many as it takes.
    pub fn code(self, sample: &[u8]) -> i128 {
        let mut word = 0u64;
        let bytes = usize::from(self.bytes);
        for at in 0..bytes.min(sample.len()) {
            let byte = if self.big_endian { sample[at] } else { sample[bytes.min(sample.len()) - 1 - at] };
            word = word << 8 | u64::from(byte);
        }
        let code = i128::from(word >> self.shift) & self.mask();
        if self.signed && code > self.highest() { code - self.mask() - 1 } else { code }
    }

    /// The lowest code.
    pub fn lowest(self) -> i128 {
        if self.signed { -(1i128 << (self.bits - 1)) } else { 0 }
    }

    /// The highest code.
    pub fn highest(self) -> i128 {
        if self.signed { (1i128 << (self.bits - 1)) - 1 } else { self.mask() }
    }

    fn mask(self) -> i128 {
        (1i128 << self.bits) - 1
    }
}

/// Where the samples of one scan lie in the buffer.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SampleLayout {
    /// The first byte of each element, in the order in which they were given.
    pub places: Vec<usize>,
    /// Bytes of a scan.
    pub size: usize,
}

impl SampleLayout {
    /// Lays out elements in the order of their numbers: each begins at a multiple of its own size, and a scan at a
    /// multiple of the largest.
    pub fn new(elements: impl IntoIterator<Item = Element>) -> SampleLayout {
        let mut layout = SampleLayout::default();
        let mut largest = 1;
        for element in elements {
            let bytes = usize::from(element.bytes);
            let place = layout.size.next_multiple_of(bytes);
            layout.places.push(place);
            layout.size = place + bytes;
            largest = largest.max(bytes);
        }
        layout.size = layout.size.next_multiple_of(largest);
        layout
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn element(text: &str) -> Element {
        Element::parse(text).unwrap()
    }

    #[test]
    fn descriptions_of_drivers_are_read() {
        let twelve = Element { big_endian: false, signed: true, bits: 12, bytes: 2, shift: 4 };
        assert_eq!(element("le:s12/16>>4"), twelve);
        assert_eq!(element("le:s12/16X1>>4\n"), twelve);
        let stamp = Element { big_endian: false, signed: true, bits: 64, bytes: 8, shift: 0 };
        assert_eq!(element("le:s64/64>>0"), stamp);
        for none in ["", "le", "le:", "le:s12", "xe:s12/16>>4", "le:f32/32>>0", "le:s0/16>>0", "le:s12/24>>0"]
        {
            assert_eq!(Element::parse(none), None, "{none}");
        }
        // More bits than there are, and four numbers in one element.
        assert_eq!(Element::parse("le:u12/16>>8"), None);
        assert_eq!(Element::parse("le:s16/16X4>>0"), None);
    }

    #[test]
    fn codes_come_out_of_their_bytes_by_order_shift_and_sign() {
        assert_eq!(element("le:u16/16>>0").code(&[0x34, 0x12]), 0x1234);
        assert_eq!(element("be:u16/16>>0").code(&[0x12, 0x34]), 0x1234);
        assert_eq!(element("le:s12/16>>4").code(&[0xF0, 0xFF]), -1);
        assert_eq!(element("be:s24/32>>8").code(&[0x80, 0, 0, 0xEE]), -(1 << 23));
        assert_eq!(element("be:u24/32>>0").code(&[0xAA, 0x80, 0, 1]), 0x80_0001);
        assert_eq!(element("le:s64/64>>0").code(&[0xFF; 8]), -1);
        assert_eq!(element("le:u64/64>>0").code(&[0xFF; 8]), i128::from(u64::MAX));
        assert_eq!((element("le:s8/8>>0").lowest(), element("le:s8/8>>0").highest()), (-128, 127));
    }

    #[test]
    fn elements_are_aligned_as_the_kernel_aligns_them() {
        let of = |texts: &[&str]| SampleLayout::new(texts.iter().map(|text| element(text)));
        let stamp = "le:s64/64>>0";
        assert_eq!(of(&["le:u16/16>>0", stamp]), SampleLayout { places: vec![0, 8], size: 16 });
        let three = of(&["le:u16/16>>0", "le:u32/32>>0", "le:u8/8>>0"]);
        assert_eq!(three, SampleLayout { places: vec![0, 4, 8], size: 12 });
        assert_eq!(of(&["le:u16/16>>0"; 4]), SampleLayout { places: vec![0, 2, 4, 6], size: 8 });
        assert_eq!(SampleLayout::new([]).size, 0);
    }

    proptest! {
        #[test]
        fn any_text_and_any_bytes_are_survived(text in ".{0,24}", bytes in prop::collection::vec(any::<u8>(), 0..16)) {
            if let Some(element) = Element::parse(&text) {
                element.code(&bytes);
            }
        }

        #[test]
        fn a_code_lies_within_its_bits(
            (storage, bits, shift) in prop::sample::select(vec![8u8, 16, 32, 64])
                .prop_flat_map(|storage| (Just(storage), 1..=storage))
                .prop_flat_map(|(storage, bits)| (Just(storage), Just(bits), 0..=storage - bits)),
            signed: bool, big: bool, bytes: [u8; 8],
        ) {
            let (order, sign) = (if big { "be" } else { "le" }, if signed { 's' } else { 'u' });
            let element = element(&format!("{order}:{sign}{bits}/{storage}>>{shift}"));
            let sample = &bytes[..usize::from(storage / 8)];
            let code = element.code(sample);
            prop_assert!((element.lowest()..=element.highest()).contains(&code), "{code}");
            // What was decoded is what was put in.
            let mut word = [0u8; 8];
            for (at, byte) in sample.iter().enumerate() {
                word[if big { sample.len() - 1 - at } else { at }] = *byte;
            }
            let kept = (u64::MAX >> (64 - bits)) << shift;
            prop_assert_eq!(u64::from_le_bytes(word) & kept, (code as u64) << shift & kept);
        }
    }
}
