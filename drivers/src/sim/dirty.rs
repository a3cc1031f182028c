//! Lines whose drivers changed, to be looked at in the order of their ranks.

/// A set of lines that gives the one of the lowest rank first; of several of one rank, that of the lowest place.
#[derive(Clone, Debug)]
pub(super) struct DirtyLines {
    /// The places of all lines in their order.
    order: Vec<u16>,
    /// By line: where it is in the order.
    positions: Vec<u16>,
    /// By position: whether it is in the set.
    bits: Vec<u64>,
    /// No line is in a word before this one.
    first: usize,
}

impl DirtyLines {
    /// None of the lines with these ranks, which are at most as many as a [`u16`] counts.
    pub(super) fn new(ranks: &[u16]) -> DirtyLines {
        let mut order: Vec<u16> = (0..ranks.len() as u16).collect();
        order.sort_by_key(|place| (ranks[usize::from(*place)], *place));
        let mut positions = vec![0; ranks.len()];
        for (position, place) in order.iter().enumerate() {
            positions[usize::from(*place)] = position as u16;
        }
        let words = ranks.len().div_ceil(64);
        DirtyLines { order, positions, bits: vec![0; words], first: words }
    }

    /// The lines of all places, by their ranks.
    pub(super) fn order(&self) -> &[u16] {
        &self.order
    }

    /// A line is in the set from now on.
    pub(super) fn insert(&mut self, place: usize) {
        let position = usize::from(self.positions[place]);
        self.bits[position / 64] |= 1 << (position % 64);
        self.first = self.first.min(position / 64);
    }

    /// Takes the first line.
    pub(super) fn pop(&mut self) -> Option<usize> {
        while let Some(word) = self.bits.get_mut(self.first) {
            if *word == 0 {
                self.first += 1;
                continue;
            }
            let position = self.first * 64 + word.trailing_zeros() as usize;
            *word &= *word - 1;
            return Some(usize::from(self.order[position]));
        }
        None
    }

    /// No line is in the set.
    pub(super) fn clear(&mut self) {
        self.bits.fill(0);
        self.first = self.bits.len();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::collections::BTreeSet;

    proptest! {
        /// Against a set of ranks and places, with lines that come while others are taken.
        #[test]
        fn the_lowest_rank_comes_first(
            ranks in proptest::collection::vec(0u16..200, 1..200),
            acts in proptest::collection::vec(proptest::option::of(0usize..200), 1..200),
        ) {
            let (mut dirty, mut known) = (DirtyLines::new(&ranks), BTreeSet::new());
            for act in acts {
                match act {
                    Some(place) => {
                        let place = place % ranks.len();
                        dirty.insert(place);
                        known.insert((ranks[place], place));
                    }
                    None => prop_assert_eq!(dirty.pop(), known.pop_first().map(|(_, place)| place)),
                }
            }
            dirty.clear();
            prop_assert_eq!(dirty.pop(), None);
        }
    }
}
