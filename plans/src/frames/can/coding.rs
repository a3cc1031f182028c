//! A number in the data of a frame: where its bits stand and what they mean.

use signal::{Decimal, Value};

use crate::frames::MAX_DATA;

/// Most bits of a number.
pub const MAX_BITS: u16 = 64;

/// The order of the bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ByteOrder {
    /// Little-endian (Intel): the first bit is the lowest one.
    Little,
    /// Big-endian (Motorola): the first bit is the highest one.
    Big,
}

/// What the bits are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum RawKind {
    /// A number without a sign.
    Unsigned,
    /// A number in two's complement.
    Signed,
    /// A float of IEEE 754, by its 32 or 64 bits.
    Float,
}

/// A number in the data of a frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Coding {
    /// Its first bit, counted as DBC does: bit 0 is the lowest of byte 0, bit 8 the lowest of byte 1.
    start: u16,
    /// How many bits, 1 to 64.
    size: u16,
    order: ByteOrder,
    raw: RawKind,
    factor: Decimal,
    offset: Decimal,
    /// Factor and offset for numbers too long to be exact.
    rough: (u64, u64),
}

/// What another number of the frame must be for this one to be there.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FrameSelector {
    /// The other number.
    pub of: Coding,
    /// The values, each from the first to the second, both included.
    pub ranges: Vec<(u64, u64)>,
    /// What selects the selecting number itself.
    pub under: Option<Box<FrameSelector>>,
}

impl FrameSelector {
    /// Whether data have it.
    #[inline]
    pub fn selects(&self, data: &[u8]) -> bool {
        let selected = self.under.as_ref().is_none_or(|under| under.selects(data));
        selected
            && self
                .of
                .bits(data)
                .is_some_and(|bits| self.ranges.iter().any(|(low, high)| (*low..=*high).contains(&bits)))
    }
}

impl Coding {
    /// A number; `None` where its bits lie outside of any frame, or a float has neither 32 nor 64.
    pub fn new(
        (start, size): (u64, u64),
        order: ByteOrder,
        raw: RawKind,
        factor: f64,
        offset: f64,
    ) -> Option<Coding> {
        if start >= 8 * MAX_DATA as u64 || size > u64::from(MAX_BITS) {
            return None;
        }
        let (start, size) = (u16::try_from(start).ok()?, u16::try_from(size).ok()?);
        let sound = match raw {
            RawKind::Float => size == 32 || size == 64,
            _ => (1..=MAX_BITS).contains(&size),
        };
        let coding = Coding {
            start,
            size,
            order,
            raw,
            factor: Decimal::from_f64(factor)?,
            offset: Decimal::from_f64(offset)?,
            rough: (factor.to_bits(), offset.to_bits()),
        };
        let fits = sound && factor != 0.0 && coding.bytes() <= MAX_DATA;
        fits.then_some(coding)
    }

    /// How many data bytes a frame has at least that carries it.
    pub fn bytes(&self) -> usize {
        let last = match self.order {
            ByteOrder::Little => self.start + self.size - 1,
            // Bits go on downwards in their byte, then from the highest of the next one.
            ByteOrder::Big => self.place(self.size - 1).unwrap_or(u16::MAX),
        };
        usize::from(last.max(self.start) / 8) + 1
    }

    /// Whether the bits mean themselves: whole numbers without factor and offset.
    pub fn is_plain(&self) -> bool {
        self.raw != RawKind::Float && self.factor == Decimal::from(1) && self.offset == Decimal::ZERO
    }

    /// The place of bit `n` from the start of the number.
    #[inline]
    fn place(&self, n: u16) -> Option<u16> {
        match self.order {
            ByteOrder::Little => self.start.checked_add(n),
            ByteOrder::Big => {
                let down = (self.start / 8 * 8 + 7 - self.start % 8).checked_add(n)?;
                Some(down / 8 * 8 + 7 - down % 8)
            }
        }
    }

    /// Its bits; `None` where the data are too short.
    #[inline]
    pub fn bits(&self, data: &[u8]) -> Option<u64> {
        let mut bits = 0;
        for n in 0..self.size {
            let place = self.place(n)?;
            let bit = u64::from(data.get(usize::from(place / 8))? >> (place % 8) & 1);
            match self.order {
                ByteOrder::Little => bits |= bit << n,
                ByteOrder::Big => bits = bits << 1 | bit,
            }
        }
        Some(bits)
    }

    /// Puts bits into data that are long enough.
    pub fn put(&self, bits: u64, data: &mut [u8]) {
        for n in 0..self.size {
            let shift = match self.order {
                ByteOrder::Little => n,
                ByteOrder::Big => self.size - 1 - n,
            };
            let place = self.place(n);
            if let Some((byte, place)) = place.and_then(|at| Some((data.get_mut(usize::from(at / 8))?, at))) {
                *byte = *byte & !(1 << (place % 8)) | ((bits >> shift & 1) as u8) << (place % 8);
            }
        }
    }

    /// Its bits with their sign.
    fn whole(&self, bits: u64) -> i128 {
        let negative = self.raw == RawKind::Signed && bits >> (self.size - 1) & 1 == 1;
        i128::from(bits) - if negative { 1 << self.size } else { 0 }
    }

    /// The value in data: the float nearest to the exact one. [`Value::Unknown`] where the data are too short, or hold
    /// no number. Nothing is allocated.
    #[inline]
    pub fn value(&self, data: &[u8]) -> Value {
        let Some(bits) = self.bits(data) else { return Value::Unknown };
        let rough = |raw: f64| {
            let value = raw * f64::from_bits(self.rough.0) + f64::from_bits(self.rough.1);
            if value.is_finite() { Value::Real(value) } else { Value::Unknown }
        };
        match self.raw {
            RawKind::Float if self.size == 32 => rough(f64::from(f32::from_bits(bits as u32))),
            RawKind::Float => rough(f64::from_bits(bits)),
            _ => {
                let whole = self.whole(bits);
                let exact = Decimal::new(whole, 0).times(self.factor);
                let exact = exact.and_then(|product| product.plus(self.offset));
                match exact.and_then(Decimal::nearest) {
                    Some(value) => Value::Real(value),
                    None => rough(whole as f64),
                }
            }
        }
    }

    /// The whole number in data; `None` where the data are too short.
    #[inline]
    pub fn number(&self, data: &[u8]) -> Option<i128> {
        Some(self.whole(self.bits(data)?))
    }

    /// The bits of the value nearest to a number; `None` where it does not fit.
    pub fn code(&self, number: f64) -> Option<u64> {
        let (factor, offset) = (f64::from_bits(self.rough.0), f64::from_bits(self.rough.1));
        let raw = (number - offset) / factor;
        match self.raw {
            RawKind::Float if self.size == 32 => Some(u64::from((raw as f32).to_bits())),
            RawKind::Float => Some(raw.to_bits()),
            _ => {
                let whole = libm::round(raw);
                if !whole.is_finite() || libm::fabs(whole) > 2e19 {
                    return None;
                }
                self.whole_code(whole as i128)
            }
        }
    }

    /// The bits of a whole number, without factor and offset; `None` where it does not fit.
    pub fn whole_code(&self, whole: i128) -> Option<u64> {
        let (least, most) = match self.raw {
            RawKind::Signed => (-(1_i128 << (self.size - 1)), (1_i128 << (self.size - 1)) - 1),
            _ => (0, (1_i128 << self.size) - 1),
        };
        let mask = u64::MAX >> (MAX_BITS - self.size);
        (least..=most).contains(&whole).then_some(whole as u64 & mask)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn coding(start: u64, size: u64, order: ByteOrder, raw: RawKind, factor: f64, offset: f64) -> Coding {
        Coding::new((start, size), order, raw, factor, offset).unwrap()
    }

    #[test]
    fn bits_stand_where_dbc_says() {
        let data = [0x12, 0x34, 0x56, 0x78];
        let bits = |start, size, order| coding(start, size, order, RawKind::Unsigned, 1.0, 0.0).bits(&data);
        assert_eq!(bits(0, 8, ByteOrder::Little), Some(0x12));
        assert_eq!(bits(0, 16, ByteOrder::Little), Some(0x3412));
        assert_eq!(bits(4, 8, ByteOrder::Little), Some(0x41));
        assert_eq!(bits(7, 8, ByteOrder::Big), Some(0x12));
        assert_eq!(bits(7, 16, ByteOrder::Big), Some(0x1234));
        assert_eq!(bits(3, 12, ByteOrder::Big), Some(0x234));
        assert_eq!(bits(24, 16, ByteOrder::Little), None);
    }

    #[test]
    fn values_are_the_nearest_to_the_exact_ones() {
        let value = |raw, factor, offset, data: &[u8]| {
            coding(0, 16, ByteOrder::Little, raw, factor, offset).value(data)
        };
        // 3 times 0.1 is 0.3, and not 0.30000000000000004.
        assert_eq!(value(RawKind::Unsigned, 0.1, 0.0, &[3, 0]), Value::Real(0.3));
        assert_eq!(value(RawKind::Signed, 0.01, -40.0, &[0xFF, 0xFF]), Value::Real(-40.01));
        assert_eq!(value(RawKind::Unsigned, 2.0, 1.0, &[0xFF, 0xFF]), Value::Real(131_071.0));
        assert_eq!(value(RawKind::Unsigned, 1.0, 0.0, &[1]), Value::Unknown);
    }

    #[test]
    fn floats_are_read_by_their_bits() {
        let real = coding(0, 32, ByteOrder::Little, RawKind::Float, 1.0, 0.0);
        assert_eq!(real.value(&1.5f32.to_le_bytes()), Value::Real(1.5));
        assert_eq!(real.value(&f32::NAN.to_le_bytes()), Value::Unknown);
        assert_eq!(real.code(1.5), Some(u64::from(1.5f32.to_bits())));
        assert!(Coding::new((0, 16), ByteOrder::Little, RawKind::Float, 1.0, 0.0).is_none());
    }

    #[test]
    fn what_does_not_fit_is_no_code() {
        let byte = coding(0, 8, ByteOrder::Little, RawKind::Signed, 0.5, 0.0);
        assert_eq!((byte.code(63.5), byte.code(64.0), byte.code(-64.0)), (Some(127), None, Some(0x80)));
        assert_eq!(byte.code(f64::INFINITY), None);
        assert!(Coding::new((505, 8), ByteOrder::Little, RawKind::Signed, 1.0, 0.0).is_none());
        assert!(Coding::new((0, 65), ByteOrder::Little, RawKind::Signed, 1.0, 0.0).is_none());
        assert!(Coding::new((0, 8), ByteOrder::Little, RawKind::Signed, f64::NAN, 0.0).is_none());
    }

    proptest! {
        #[test]
        fn what_is_put_is_there_and_nothing_else(
            start in 0u64..512,
            size in 1u64..=64,
            big: bool,
            signed: bool,
            bits: u64,
            fill: u8,
        ) {
            let order = if big { ByteOrder::Big } else { ByteOrder::Little };
            let raw = if signed { RawKind::Signed } else { RawKind::Unsigned };
            if let Some(coding) = Coding::new((start, size), order, raw, 1.0, 0.0) {
                let bits = bits & (u64::MAX >> (64 - size));
                let mut data = [fill; 64];
                coding.put(bits, &mut data);
                prop_assert_eq!(coding.bits(&data), Some(bits));
                let number = coding.number(&data).unwrap();
                prop_assert_eq!(coding.whole_code(number), Some(bits));
                // Undone, the rest is as it was.
                coding.put(coding.bits(&[fill; 64]).unwrap(), &mut data);
                prop_assert_eq!(data, [fill; 64]);
            }
        }

        #[test]
        fn no_data_panics(
            start: u64,
            size: u64,
            big: bool,
            factor: f64,
            offset: f64,
            data in proptest::collection::vec(any::<u8>(), 0..70),
        ) {
            let order = if big { ByteOrder::Big } else { ByteOrder::Little };
            for raw in [RawKind::Unsigned, RawKind::Signed, RawKind::Float] {
                for (start, size) in [(start, size), (start % 512, size % 65)] {
                    if let Some(coding) = Coding::new((start, size), order, raw, factor, offset) {
                        coding.value(&data);
                        coding.code(factor);
                    }
                }
            }
        }
    }
}
