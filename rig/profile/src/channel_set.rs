//! Sets of channels, as the scan keeps them: one word, nothing allocated.

use std::fmt;
use std::ops::{BitAnd, BitAndAssign, BitOr, BitOrAssign, BitXor, BitXorAssign, Sub, SubAssign};

/// A set of embedded channels of one kind, by their numbers: inputs, n for In, or outputs, n for Qn.
///
/// The operators are those of sets: `|` the union, `&` the intersection, `-` the difference, `^` what is in one of two.
/// There is room for the numbers below [`ChannelSet::CAPACITY`], more than any reference has; those above are in no set.
#[derive(Clone, Copy, Default, PartialEq, Eq, Hash)]
pub struct ChannelSet(u32);

impl ChannelSet {
    /// Numbers that a set has room for. No reference has more than 24 embedded channels of a kind (tested).
    pub const CAPACITY: usize = u32::BITS as usize;

    /// No channel.
    pub const EMPTY: ChannelSet = ChannelSet(0);

    /// Every number that a set has room for.
    pub const ALL: ChannelSet = ChannelSet(u32::MAX);

    /// One channel.
    #[inline]
    pub const fn of(channel: usize) -> ChannelSet {
        if channel < ChannelSet::CAPACITY { ChannelSet(1 << channel) } else { ChannelSet::EMPTY }
    }

    /// The first `count` channels.
    pub const fn first(count: usize) -> ChannelSet {
        if count < ChannelSet::CAPACITY { ChannelSet((1 << count) - 1) } else { ChannelSet::ALL }
    }

    /// The channels whose bits are set in the first word of an image: embedded channel n has bit n of %I or %Q (io:ADR-01,
    /// io:ADR-02).
    #[inline]
    pub const fn from_image(word: [u8; 4]) -> ChannelSet {
        ChannelSet(u32::from_le_bytes(word))
    }

    /// The first word of an image with their bits set.
    #[inline]
    pub const fn to_image(self) -> [u8; 4] {
        self.0.to_le_bytes()
    }

    /// Whether a channel is in it.
    #[inline]
    pub const fn contains(self, channel: usize) -> bool {
        self.intersects(ChannelSet::of(channel))
    }

    /// Whether any channel is in both.
    #[inline]
    pub const fn intersects(self, other: ChannelSet) -> bool {
        self.0 & other.0 != 0
    }

    /// Whether there is no channel in it.
    #[inline]
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Puts a channel in.
    #[inline]
    pub const fn insert(&mut self, channel: usize) {
        self.0 |= ChannelSet::of(channel).0;
    }

    /// Takes a channel out.
    #[inline]
    pub const fn remove(&mut self, channel: usize) {
        self.0 &= !ChannelSet::of(channel).0;
    }

    /// Puts a channel in, or takes it out.
    #[inline]
    pub const fn set(&mut self, channel: usize, is_in: bool) {
        if is_in {
            self.insert(channel);
        } else {
            self.remove(channel);
        }
    }

    /// The same, but with the channels of `which` that are in `from`, and without those of `which` that are not.
    #[inline]
    #[must_use]
    pub const fn updated(self, which: ChannelSet, from: ChannelSet) -> ChannelSet {
        ChannelSet(self.0 & !which.0 | from.0 & which.0)
    }

    /// Its channels by number.
    #[inline]
    pub const fn iter(self) -> ChannelNumbers {
        ChannelNumbers(self.0)
    }
}

/// The channels of a set by number.
#[derive(Clone, Debug)]
pub struct ChannelNumbers(u32);

impl Iterator for ChannelNumbers {
    type Item = usize;

    #[inline]
    fn next(&mut self) -> Option<usize> {
        let first = self.0.trailing_zeros() as usize;
        // Takes out the lowest; of 0 nothing is left either way.
        self.0 &= self.0.wrapping_sub(1);
        (first < ChannelSet::CAPACITY).then_some(first)
    }
}

impl IntoIterator for ChannelSet {
    type Item = usize;
    type IntoIter = ChannelNumbers;

    #[inline]
    fn into_iter(self) -> ChannelNumbers {
        self.iter()
    }
}

impl FromIterator<usize> for ChannelSet {
    fn from_iter<I: IntoIterator<Item = usize>>(channels: I) -> ChannelSet {
        let mut set = ChannelSet::EMPTY;
        channels.into_iter().for_each(|channel| set.insert(channel));
        set
    }
}

impl BitOr for ChannelSet {
    type Output = ChannelSet;

    #[inline]
    fn bitor(self, other: ChannelSet) -> ChannelSet {
        ChannelSet(self.0 | other.0)
    }
}

impl BitAnd for ChannelSet {
    type Output = ChannelSet;

    #[inline]
    fn bitand(self, other: ChannelSet) -> ChannelSet {
        ChannelSet(self.0 & other.0)
    }
}

impl BitXor for ChannelSet {
    type Output = ChannelSet;

    #[inline]
    fn bitxor(self, other: ChannelSet) -> ChannelSet {
        ChannelSet(self.0 ^ other.0)
    }
}

impl Sub for ChannelSet {
    type Output = ChannelSet;

    #[inline]
    fn sub(self, other: ChannelSet) -> ChannelSet {
        ChannelSet(self.0 & !other.0)
    }
}

impl BitOrAssign for ChannelSet {
    #[inline]
    fn bitor_assign(&mut self, other: ChannelSet) {
        *self = *self | other;
    }
}

impl BitAndAssign for ChannelSet {
    #[inline]
    fn bitand_assign(&mut self, other: ChannelSet) {
        *self = *self & other;
    }
}

impl BitXorAssign for ChannelSet {
    #[inline]
    fn bitxor_assign(&mut self, other: ChannelSet) {
        *self = *self ^ other;
    }
}

impl SubAssign for ChannelSet {
    #[inline]
    fn sub_assign(&mut self, other: ChannelSet) {
        *self = *self - other;
    }
}

impl fmt::Debug for ChannelSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_set().entries(self.iter()).finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::REFERENCES;
    use proptest::prelude::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_reference_has_room() {
        let most = REFERENCES.iter().map(|known| known.input_count().max(known.output_count())).max();
        assert!(most.is_some_and(|most| most <= ChannelSet::CAPACITY));
    }

    #[test]
    fn numbers_beyond_the_room_are_in_no_set() {
        let mut set = ChannelSet::from_iter([0, 31, 32, 64, usize::MAX]);
        assert_eq!(set.iter().collect::<Vec<_>>(), [0, 31]);
        set.remove(32);
        assert!(set.contains(0) && !set.contains(32) && !ChannelSet::ALL.contains(64));
        assert_eq!((ChannelSet::first(32), ChannelSet::first(0)), (ChannelSet::ALL, ChannelSet::EMPTY));
        assert_eq!(ChannelSet::first(31) ^ ChannelSet::ALL, ChannelSet::of(31));
    }

    // io:ADR-01
    #[test]
    fn channels_have_their_bits_in_the_order_of_an_image() {
        assert_eq!(ChannelSet::from_iter([0, 9, 31]).to_image(), [1, 2, 0, 0x80]);
        assert_eq!(ChannelSet::from_image([0, 0, 4, 0]), ChannelSet::of(18));
    }

    proptest! {
        #[test]
        fn it_is_a_set(a in prop::collection::btree_set(0..32_usize, 0..32), b in prop::collection::btree_set(0..32_usize, 0..32)) {
            let (x, y): (ChannelSet, ChannelSet) = (a.iter().copied().collect(), b.iter().copied().collect());
            let set = |it: ChannelSet| it.iter().collect::<BTreeSet<_>>();
            prop_assert_eq!(set(x | y), &a | &b);
            prop_assert_eq!(set(x & y), &a & &b);
            prop_assert_eq!(set(x - y), &a - &b);
            prop_assert_eq!(set(x ^ y), &a ^ &b);
            prop_assert_eq!(x.intersects(y), !a.is_disjoint(&b));
            prop_assert_eq!(x.is_empty(), a.is_empty());
            let low = ChannelSet::first(16);
            prop_assert_eq!(x.updated(low, y), (x - low) | (y & low));
            prop_assert!((0..40).all(|n| x.contains(n) == a.contains(&n)));
        }
    }
}
