//! Numbers that look random and follow from a seed alone.

use signal::Span;

/// SplitMix64: every stream is named by a seed and a lane, so that one more wire does not shift the others' draws.
#[derive(Clone, Debug)]
pub(crate) struct Random(u64);

impl Random {
    /// The stream of this lane.
    pub(crate) fn new(seed: u64, lane: u64) -> Self {
        let mut lanes = Random(seed ^ 0x5363_616E_7269_6721);
        let base = lanes.next();
        Random(base ^ lane.wrapping_mul(0xD6E8_FEB8_6659_FD93))
    }

    /// The next 64 bits.
    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// A number in `0..bound`; 0 where the bound is 0.
    pub(crate) fn below(&mut self, bound: u64) -> u64 {
        ((u128::from(self.next()) * u128::from(bound)) >> 64) as u64
    }

    /// A duration in `1 ns ..= longest`; 0 where the longest is not above 0.
    pub(crate) fn span(&mut self, longest: Span) -> Span {
        match u64::try_from(longest.as_nanos()) {
            Ok(bound) if bound > 0 => Span::from_nanos(self.below(bound) as i64 + 1),
            _ => Span::ZERO,
        }
    }

    /// True `ppm` times in a million.
    pub(crate) fn chance(&mut self, ppm: u32) -> bool {
        self.below(1_000_000) < u64::from(ppm)
    }
}
