//! The seeded source of chance. Fixed for ever: a change would change every trace that was drawn from it.

use crate::Span;

/// SplitMix64: a full period of 64 bits of state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Random(u64);

impl Random {
    /// The sequence of `seed`.
    pub const fn new(seed: u64) -> Self {
        Random(seed)
    }

    /// The sequence of a seed for one purpose of several, so that one more draw for one shifts no other's.
    pub fn lane(seed: u64, lane: u64) -> Self {
        let base = Random(seed ^ 0x5363_616E_7269_6721).next_u64();
        Random(base ^ lane.wrapping_mul(0xD6E8_FEB8_6659_FD93))
    }

    /// The next 64 bits.
    fn next_u64(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// A number in `0..bound`; 0 where the bound is 0.
    pub fn below(&mut self, bound: u64) -> u64 {
        ((u128::from(self.next_u64()) * u128::from(bound)) >> 64) as u64
    }

    /// A duration in `1 ns ..= longest`; 0 where the longest is not above 0.
    pub fn span(&mut self, longest: Span) -> Span {
        match u64::try_from(longest.as_nanos()) {
            Ok(bound) if bound > 0 => Span::from_nanos(self.below(bound) as i64 + 1),
            _ => Span::ZERO,
        }
    }

    /// True `ppm` times in a million.
    pub fn chance(&mut self, ppm: u32) -> bool {
        self.below(1_000_000) < u64::from(ppm)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_sequence() {
        // First outputs of SplitMix64 for seed 0, as published with the algorithm.
        let mut random = Random::new(0);
        assert_eq!(random.next_u64(), 0xE220_A839_7B1D_CDAF);
        assert_eq!(random.next_u64(), 0x6E78_9E6A_A1B9_65F4);
    }

    #[test]
    fn bounds_hold() {
        let mut random = Random::lane(3, 1);
        assert_eq!((random.below(0), random.span(Span::ZERO)), (0, Span::ZERO));
        assert!((0..1000).all(|_| random.below(7) < 7));
        assert!((0..1000).all(|_| (1..=5).contains(&random.span(Span::from_nanos(5)).as_nanos())));
        assert_ne!(Random::lane(3, 1), Random::lane(3, 2));
    }
}
