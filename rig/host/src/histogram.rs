//! How long something took, very many times: counts in bounded memory, and what share was at most so long.

/// Bits of a length that are kept beside its power of two: two lengths of one bucket differ by less than 1/256.
const KEPT: u32 = 8;

/// Buckets of one power of two.
const EACH: usize = 1 << KEPT;

/// Buckets in all: lengths up to 2^40 ns, some 18 minutes, and those beyond in the last.
const BUCKETS: usize = EACH * (40 - KEPT as usize + 1);

/// Counts of lengths in nanoseconds. Noting one takes some nanoseconds and never allocates.
#[derive(Clone, Debug)]
pub struct Histogram {
    counts: Box<[u64]>,
    count: u64,
    min: u64,
    max: u64,
    sum: u128,
}

impl Default for Histogram {
    fn default() -> Self {
        Histogram { counts: vec![0; BUCKETS].into_boxed_slice(), count: 0, min: u64::MAX, max: 0, sum: 0 }
    }
}

impl Histogram {
    /// An empty one.
    pub fn new() -> Histogram {
        Histogram::default()
    }

    /// Notes a length; a negative one counts as 0.
    #[inline]
    pub fn note(&mut self, length: i64) {
        let length = length.max(0) as u64;
        self.counts[bucket(length)] += 1;
        self.count += 1;
        self.min = self.min.min(length);
        self.max = self.max.max(length);
        self.sum += u128::from(length);
    }

    /// Adds what another one noted.
    pub fn add(&mut self, other: &Histogram) {
        for (mine, theirs) in self.counts.iter_mut().zip(&other.counts) {
            *mine += theirs;
        }
        self.count += other.count;
        self.min = self.min.min(other.min);
        self.max = self.max.max(other.max);
        self.sum += other.sum;
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        self.counts.fill(0);
        (self.count, self.min, self.max, self.sum) = (0, u64::MAX, 0, 0);
    }

    /// How many were noted.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// The shortest, exactly; 0 where none was noted.
    pub fn min(&self) -> u64 {
        if self.count > 0 { self.min } else { 0 }
    }

    /// The longest, exactly; 0 where none was noted.
    pub fn max(&self) -> u64 {
        self.max
    }

    /// The mean; 0 where none was noted.
    pub fn mean(&self) -> u64 {
        u64::try_from(self.sum / u128::from(self.count.max(1))).unwrap_or(u64::MAX)
    }

    /// A length that at least so many of a million were at most, rounded up within its bucket; 0 where none was noted.
    pub fn millionths(&self, share: u32) -> u64 {
        let wanted = (u128::from(self.count) * u128::from(share)).div_ceil(1_000_000).max(1);
        let mut seen = 0;
        for (place, count) in self.counts.iter().enumerate() {
            seen += u128::from(*count);
            if seen >= wanted {
                return upper(place).min(self.max);
            }
        }
        self.max
    }

    /// The greatest length of each bucket that is not empty, with its count, rising.
    pub fn buckets(&self) -> impl Iterator<Item = (u64, u64)> + '_ {
        let kept = self.counts.iter().enumerate().filter(|(_, count)| **count > 0);
        kept.map(|(place, count)| (upper(place).min(self.max), *count))
    }
}

/// The bucket of a length.
#[inline]
fn bucket(length: u64) -> usize {
    let power = (64 - length.leading_zeros()).saturating_sub(KEPT + 1);
    (power as usize * EACH + (length >> power) as usize).min(BUCKETS - 1)
}

/// The greatest length of a bucket.
fn upper(place: usize) -> u64 {
    if place < 2 * EACH {
        return place as u64;
    }
    let power = place / EACH - 1;
    ((((place % EACH) + EACH + 1) as u64) << power) - 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_length_lies_in_a_bucket_that_is_hardly_wider() {
        let powers = (0..38)
            .flat_map(|power| [1u64 << power, (1 << power) + 1, (1 << power) * 3 / 2, (2 << power) - 1]);
        for length in (0..5_000).chain(powers) {
            let top = upper(bucket(length));
            assert!(top >= length && top - length <= length / 256, "{length} lies in a bucket up to {top}");
            assert_ne!(bucket(top), bucket(top + 1), "{top}");
        }
    }

    #[test]
    fn shares_are_those_of_the_sorted_list() {
        let mut noted = Histogram::new();
        (1..=1000).for_each(|length| noted.note(length * 1_000));
        for (share, exact) in [(500_000, 500_000), (990_000, 990_000), (1_000_000, 1_000_000), (0, 1_000)] {
            let found = noted.millionths(share);
            assert!(found >= exact && found - exact <= exact / 256, "{share}: {found}");
        }
        assert_eq!((noted.max(), noted.count(), noted.mean()), (1_000_000, 1_000, 500_500));
        assert_eq!((noted.min(), Histogram::new().min()), (1_000, 0));
    }

    #[test]
    fn lengths_without_end_have_a_bucket_too() {
        let mut noted = Histogram::new();
        noted.note(i64::MAX);
        noted.note(-5);
        assert_eq!(noted.buckets().map(|(_, count)| count).sum::<u64>(), 2);
        assert_eq!(noted.max(), i64::MAX as u64);
        assert_eq!(Histogram::new().millionths(990_000), 0);
    }
}
