//! IEC addresses of the process images and of the mapped memory: `%IX0.4`, `%QW1`, `%MW10.4`.
//!
//! An address is a place: an area, a first bit and a size. Words are little-endian, so that
//! `%MB(2n)` is the low byte of `%MWn` and `%MW(2n)` the low word of `%MDn` (controller:ADDR-01);
//! a bit of a word is the bit of a byte (controller:ADDR-07). Two spellings of one place are equal.

use std::fmt;
use std::str::FromStr;

/// Which memory an address is in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Area {
    /// `%I`: the input image.
    Input,
    /// `%Q`: the output image.
    Output,
    /// `%M`: the mapped memory.
    Memory,
}

impl Area {
    /// `I`, `Q` or `M`.
    const fn letter(self) -> char {
        match self {
            Area::Input => 'I',
            Area::Output => 'Q',
            Area::Memory => 'M',
        }
    }
}

/// How much an address covers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Size {
    /// `X`: one bit.
    Bit,
    /// `B`: 8 bits.
    Byte,
    /// `W`: 16 bits.
    Word,
    /// `D`: 32 bits.
    Double,
    /// `L`: 64 bits.
    Long,
}

impl Size {
    /// Number of bits: 1, 8, 16, 32 or 64.
    #[inline]
    pub const fn bits(self) -> u32 {
        match self {
            Size::Bit => 1,
            Size::Byte => 8,
            Size::Word => 16,
            Size::Double => 32,
            Size::Long => 64,
        }
    }

    /// `X`, `B`, `W`, `D` or `L`.
    const fn letter(self) -> char {
        match self {
            Size::Bit => 'X',
            Size::Byte => 'B',
            Size::Word => 'W',
            Size::Double => 'D',
            Size::Long => 'L',
        }
    }
}

/// A place in an image or in memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Address {
    area: Area,
    /// First bit, counted from bit 0 of byte 0; a multiple of the size.
    first: u32,
    size: Size,
}

/// How far the areas of a controller reach, from its profile.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct AddressLimits {
    /// Bits of the input image.
    pub input_bits: u32,
    /// Bits of the output image.
    pub output_bits: u32,
    /// Words of the mapped memory: 60000 for `%MW0` to `%MW59999` (controller:ADDR-02).
    pub memory_words: u32,
}

impl AddressLimits {
    /// Number of bits of an area.
    #[inline]
    pub const fn bits(&self, area: Area) -> u32 {
        match area {
            Area::Input => self.input_bits,
            Area::Output => self.output_bits,
            Area::Memory => self.memory_words.saturating_mul(16),
        }
    }
}

/// Why a text is no address, with the byte at which it went wrong; or why an address does not exist.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AddressError {
    /// Nothing to read.
    Empty,
    /// An address starts with `%`.
    Percent,
    /// The letter at this byte is no area: I, Q or M.
    UnknownArea(usize),
    /// `%S` and `%K` objects do not exist in these controllers (controller:ADDR-04).
    SystemObject(usize),
    /// A number was expected at this byte.
    Number(usize),
    /// The number at this byte is beyond every controller's memory.
    TooLarge(usize),
    /// A bit address ends before its bit: `.0` to `.7` is missing at this byte.
    MissingBit(usize),
    /// The bit at this byte is above the last one.
    BitTooLarge {
        /// Byte of the text.
        at: usize,
        /// Highest bit: 7 of a byte, 15 of a word.
        last: u8,
    },
    /// The point at this byte asks for a bit of a byte, double or long word: only `X` and `W` have bits.
    NoBits(usize),
    /// The address ends before this byte.
    Trailing(usize),
    /// A well-formed address beyond the end of its area.
    Outside {
        /// The address.
        address: Address,
        /// Number of bits of its area.
        area_bits: u32,
    },
}

impl AddressError {
    /// The byte of the text at which reading stopped, 0 where the address as a whole is at fault.
    pub fn offset(&self) -> usize {
        match *self {
            Self::Empty | Self::Percent | Self::Outside { .. } => 0,
            Self::UnknownArea(at)
            | Self::SystemObject(at)
            | Self::Number(at)
            | Self::TooLarge(at)
            | Self::MissingBit(at)
            | Self::BitTooLarge { at, .. }
            | Self::NoBits(at)
            | Self::Trailing(at) => at,
        }
    }
}

impl fmt::Display for AddressError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Empty => f.write_str("an address is missing, as in %IX0.4"),
            Self::Percent => f.write_str("an address starts with %, as in %IX0.4"),
            Self::UnknownArea(_) => f.write_str("no memory area: use I (inputs), Q (outputs) or M (memory)"),
            Self::SystemObject(_) => f.write_str(
                "the controller has no %S or %K objects: read the structure PLC_R, write PLC_W, as in PLC_R.i_wStatus",
            ),
            Self::Number(_) => f.write_str("a decimal number is expected here"),
            Self::TooLarge(_) => f.write_str("the number is beyond every controller's memory"),
            Self::MissingBit(_) => f.write_str("the bit is missing: write .0 to .7 after the byte, as in %IX0.4"),
            Self::BitTooLarge { last, .. } => write!(f, "no such bit: the last one here is {last}"),
            Self::NoBits(_) => f.write_str("only bytes and words have bits: write %MX5.3 or %MW2.11"),
            Self::Trailing(_) => f.write_str("the address should end here"),
            Self::Outside { address, area_bits } => {
                let count = area_bits / address.size.bits();
                match count.checked_sub(1).and_then(|last| Address::new(address.area, address.size, last)) {
                    Some(last) => write!(f, "{address} does not exist: the last one is {last}")?,
                    None => write!(f, "{address} does not exist: the controller has no %{}", address.area.letter())?,
                }
                if address.area == Area::Memory {
                    f.write_str("; system variables are reached by name, as in PLC_R.i_wStatus")?;
                }
                Ok(())
            }
        }
    }
}

impl std::error::Error for AddressError {}

impl Address {
    /// The `index`th object of this size: for bits, counted through the area (`%IX1.2` is 10).
    ///
    /// `None` where its bits do not fit into 32-bit offsets.
    #[inline]
    pub fn new(area: Area, size: Size, index: u32) -> Option<Self> {
        let first = index.checked_mul(size.bits())?;
        first.checked_add(size.bits())?;
        Some(Address { area, first, size })
    }

    /// The `bit`th bit of an area, from bit 0 of byte 0.
    #[inline]
    pub const fn bit(area: Area, bit: u32) -> Self {
        // The very last bit would end beyond the 32-bit offsets.
        Address { area, first: if bit == u32::MAX { u32::MAX - 1 } else { bit }, size: Size::Bit }
    }

    /// The area.
    #[inline]
    pub const fn area(self) -> Area {
        self.area
    }

    /// The size.
    #[inline]
    pub const fn size(self) -> Size {
        self.size
    }

    /// The place among the objects of its size: 10 for `%MW10`, 10 for `%IX1.2`.
    const fn index(self) -> u32 {
        self.first / self.size.bits()
    }

    /// First bit, from bit 0 of byte 0 of the area.
    #[inline]
    pub const fn bit_offset(self) -> u32 {
        self.first
    }

    /// Number of bits: 1, 8, 16, 32 or 64.
    #[inline]
    pub const fn bit_len(self) -> u32 {
        self.size.bits()
    }

    /// The byte of the area that holds the first bit.
    #[inline]
    pub(crate) const fn byte_offset(self) -> u32 {
        self.first / 8
    }

    /// Whether a write to one place can change the other (controller:ADDR-01).
    pub const fn overlaps(&self, other: &Address) -> bool {
        self.area as u8 == other.area as u8
            && self.first < other.first + other.size.bits()
            && other.first < self.first + self.size.bits()
    }

    /// Whether the place exists in a controller with these limits (controller:ADDR-02).
    ///
    /// # Errors
    /// [`AddressError::Outside`].
    #[inline]
    pub const fn check(&self, limits: &AddressLimits) -> Result<(), AddressError> {
        let area_bits = limits.bits(self.area);
        if self.first + self.size.bits() <= area_bits {
            Ok(())
        } else {
            Err(AddressError::Outside { address: *self, area_bits })
        }
    }

    /// Reads `%IX0.4`, `%Q0.4` (X may be left out), `%QB1`, `%IW2`, `%MD3`, `%ML1` or `%MW10.4`, in capitals or not.
    ///
    /// # Errors
    /// [`AddressError`] with the byte of the first fault.
    pub fn parse(text: &str) -> Result<Address, AddressError> {
        let bytes = text.as_bytes();
        if bytes.is_empty() {
            return Err(AddressError::Empty);
        }
        if bytes[0] != b'%' {
            return Err(AddressError::Percent);
        }
        let area = match bytes.get(1).map(u8::to_ascii_uppercase) {
            Some(b'I') => Area::Input,
            Some(b'Q') => Area::Output,
            Some(b'M') => Area::Memory,
            Some(b'S' | b'K') => return Err(AddressError::SystemObject(1)),
            _ => return Err(AddressError::UnknownArea(1)),
        };
        let (size, number_at) = match bytes.get(2).map(u8::to_ascii_uppercase) {
            Some(b'X') => (Size::Bit, 3),
            Some(b'B') => (Size::Byte, 3),
            Some(b'W') => (Size::Word, 3),
            Some(b'D') => (Size::Double, 3),
            Some(b'L') => (Size::Long, 3),
            _ => (Size::Bit, 2),
        };
        let (number, mut at) = decimal(bytes, number_at)?;
        let too_large = AddressError::TooLarge(number_at);
        let address = if bytes.get(at) == Some(&b'.') {
            let (holder, last) = match size {
                Size::Bit => (Size::Byte, 7),
                Size::Word => (Size::Word, 15),
                Size::Byte | Size::Double | Size::Long => return Err(AddressError::NoBits(at)),
            };
            let bit_at = at + 1;
            let (bit, end) = decimal(bytes, bit_at)?;
            at = end;
            if bit > last {
                return Err(AddressError::BitTooLarge { at: bit_at, last: last as u8 });
            }
            let holder = Address::new(area, holder, number).ok_or(too_large)?;
            Address::bit(area, holder.first + bit)
        } else if size == Size::Bit {
            return Err(AddressError::MissingBit(at));
        } else {
            Address::new(area, size, number).ok_or(too_large)?
        };
        if at < bytes.len() { Err(AddressError::Trailing(at)) } else { Ok(address) }
    }
}

/// A decimal number and the byte after it.
fn decimal(bytes: &[u8], start: usize) -> Result<(u32, usize), AddressError> {
    let mut at = start;
    let mut number = 0u32;
    while let Some(digit @ b'0'..=b'9') = bytes.get(at) {
        number = number
            .checked_mul(10)
            .and_then(|n| n.checked_add(u32::from(digit - b'0')))
            .ok_or(AddressError::TooLarge(start))?;
        at += 1;
    }
    if at == start { Err(AddressError::Number(start)) } else { Ok((number, at)) }
}

impl FromStr for Address {
    type Err = AddressError;

    fn from_str(text: &str) -> Result<Self, AddressError> {
        Address::parse(text)
    }
}

impl fmt::Display for Address {
    /// The canonical spelling: `%IX0.4` for bits, `%MW10` for the rest; a bit of a word as the bit of its byte.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let area = self.area.letter();
        match self.size {
            Size::Bit => write!(f, "%{area}X{}.{}", self.first / 8, self.first % 8),
            size => write!(f, "%{area}{}{}", size.letter(), self.index()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const LIMITS: AddressLimits = AddressLimits { input_bits: 24, output_bits: 24, memory_words: 60_000 };

    fn at(text: &str) -> Address {
        Address::parse(text).unwrap()
    }

    #[test]
    fn spellings_of_one_place_are_equal() {
        // controller:ADDR-07 - %MW10.4 is the fifth bit of word 10.
        assert_eq!(at("%MW10.4"), at("%MX20.4"));
        assert_eq!(at("%MW10.11"), at("%MX21.3"));
        assert_eq!(at("%q0.4"), at("%QX0.4"));
        assert_eq!(at("%iw9.8"), at("%IX19.0"));
        assert_eq!(at("%MW10.11").to_string(), "%MX21.3");
        assert_eq!(at("%md3").to_string(), "%MD3");
        assert_eq!(at("%IX1.2").index(), 10);
    }

    #[test]
    fn faults_name_their_place() {
        let fault = |text: &str| Address::parse(text).unwrap_err();
        assert_eq!(fault(""), AddressError::Empty);
        assert_eq!(fault("IX0.4"), AddressError::Percent);
        assert_eq!(fault("%"), AddressError::UnknownArea(1));
        assert_eq!(fault("%AX0.4"), AddressError::UnknownArea(1));
        assert_eq!(fault("%IX"), AddressError::Number(3));
        assert_eq!(fault("%IX0"), AddressError::MissingBit(4));
        assert_eq!(fault("%IX0."), AddressError::Number(5));
        assert_eq!(fault("%IX0.8"), AddressError::BitTooLarge { at: 5, last: 7 });
        assert_eq!(fault("%MW0.16"), AddressError::BitTooLarge { at: 5, last: 15 });
        assert_eq!(fault("%MB0.1"), AddressError::NoBits(4));
        assert_eq!(fault("%MW10x"), AddressError::Trailing(5));
        assert_eq!(fault("%MW10.4.1"), AddressError::Trailing(7));
        assert_eq!(fault("%MW99999999999"), AddressError::TooLarge(3));
        assert_eq!(fault("%ML4294967295"), AddressError::TooLarge(3));
        assert_eq!(fault("%M\u{b5}"), AddressError::Number(2));
    }

    #[test]
    fn system_objects_are_refused_with_their_structure() {
        // controller:ADDR-04
        for text in ["%S6", "%SW30", "%SB1", "%KW4", "%kw4"] {
            let error = Address::parse(text).unwrap_err();
            assert_eq!(error, AddressError::SystemObject(1));
            assert!(error.to_string().contains("PLC_R") && error.to_string().contains("PLC_W"));
        }
    }

    #[test]
    fn the_ends_of_memory_are_exact() {
        // controller:ADDR-02, controller:MEM-09
        for (last, beyond) in [
            ("%MW59999", "%MW60000"),
            ("%MD29999", "%MD30000"),
            ("%MB119999", "%MB120000"),
            ("%MX119999.7", "%MX120000.0"),
            ("%ML14999", "%ML15000"),
            ("%IX2.7", "%IX3.0"),
            ("%QB2", "%QB3"),
            ("%IW0", "%IW1"),
        ] {
            assert_eq!(at(last).check(&LIMITS), Ok(()), "{last}");
            let error = at(beyond).check(&LIMITS).unwrap_err();
            assert!(error.to_string().contains(&format!("the last one is {last}")), "{error}");
        }
        let none = AddressLimits { input_bits: 0, ..LIMITS };
        assert!(at("%IX0.0").check(&none).unwrap_err().to_string().contains("has no %I"));
    }

    #[test]
    fn the_documented_overlaps() {
        // controller:ADDR-01
        for (a, b) in [
            ("%MD0", "%MB0"),
            ("%MD0", "%MB3"),
            ("%MD0", "%MW1"),
            ("%MD1", "%MW2"),
            ("%MD1", "%MB7"),
            ("%MW0", "%MB1"),
            ("%MW1", "%MX3.7"),
        ] {
            assert!(at(a).overlaps(&at(b)) && at(b).overlaps(&at(a)), "{a} {b}");
        }
        for (a, b) in [("%MD0", "%MW2"), ("%MW0", "%MB2"), ("%MX0.0", "%MX0.1"), ("%IW0", "%QW0")] {
            assert!(!at(a).overlaps(&at(b)) && !at(b).overlaps(&at(a)), "{a} {b}");
        }
    }

    pub(crate) fn any_address() -> impl Strategy<Value = Address> {
        let area = prop_oneof![Just(Area::Input), Just(Area::Output), Just(Area::Memory)];
        let size = prop_oneof![
            Just(Size::Bit),
            Just(Size::Byte),
            Just(Size::Word),
            Just(Size::Double),
            Just(Size::Long)
        ];
        (area, size, 0u32..70_000).prop_map(|(area, size, index)| Address::new(area, size, index).unwrap())
    }

    proptest! {
        #[test]
        fn what_is_written_reads_back(address in any_address()) {
            prop_assert_eq!(Address::parse(&address.to_string()), Ok(address));
            prop_assert_eq!(Address::parse(&address.to_string().to_lowercase()), Ok(address));
        }

        #[test]
        fn no_text_panics(text in "%?[IQMSK]?[XBWDL]?\\PC*") {
            if let Err(error) = Address::parse(&text) {
                prop_assert!(error.offset() <= text.len().max(1));
                let _ = error.to_string();
            }
        }
    }
}
