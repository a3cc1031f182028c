//! The mean of values over the time, and the root of their mean square: exact where their sums have at most 38 digits, else
//! within an interval around the float.

use std::num::NonZeroU64;

use signal::Decimal;

use super::{Extent, Number};

/// How far a sum of floats may be off, as a part of it: what a window of a million values comes to.
const ROUNDED: f64 = 1e-10;

/// A sum of values, each times how long it lasts in nanoseconds.
#[derive(Clone, Copy, Debug)]
struct TimeSum {
    /// `None` once it had too many digits.
    exact: Option<Decimal>,
    near: f64,
    /// The sum of the magnitudes.
    size: f64,
}

impl TimeSum {
    const NONE: TimeSum = TimeSum { exact: Some(Decimal::ZERO), near: 0.0, size: 0.0 };

    fn add(&mut self, value: Number, nanos: i64) {
        let product = |value: Decimal| value.times(Decimal::from(i128::from(nanos)));
        self.exact = match (self.exact, value.as_decimal()) {
            (Some(sum), Some(value)) => product(value).and_then(|product| sum.plus(product)),
            _ => None,
        };
        let near = value.as_real() * nanos as f64;
        (self.near, self.size) = (self.near + near, self.size + near.abs());
    }

    /// The sum over so many nanoseconds, more than none.
    fn over(self, nanos: i64) -> Extent {
        let under = u64::try_from(nanos).ok().and_then(NonZeroU64::new).unwrap_or(NonZeroU64::MIN);
        if let Some(mean) = self.exact.and_then(|sum| sum.over(under)) {
            return (mean.into(), mean.into());
        }
        let (near, size) = (self.near / nanos as f64, self.size / nanos as f64);
        let off = match self.exact {
            Some(_) => size * f64::EPSILON * 4.0,
            None => size * ROUNDED,
        };
        (Number::Real(near - off), Number::Real(near + off))
    }
}

/// The values of a window, weighed with the time that they last.
#[derive(Clone, Debug)]
pub(super) struct Means {
    /// Certain time in nanoseconds, and with it the sums of the values and of their squares: the least and the greatest
    /// that they may be.
    time: i64,
    sum: [TimeSum; 2],
    squares: [TimeSum; 2],
}

impl Means {
    pub(super) const NONE: Means = Means { time: 0, sum: [TimeSum::NONE; 2], squares: [TimeSum::NONE; 2] };

    /// A number of this extent lasts for so many nanoseconds.
    pub(super) fn add(&mut self, extent: Extent, nanos: i64) {
        self.time = self.time.saturating_add(nanos);
        self.weigh(extent, nanos);
    }

    fn weigh(&mut self, (low, high): Extent, nanos: i64) {
        let [least, most] = &mut self.sum;
        least.add(low, nanos);
        most.add(high, nanos);
        let (near, far) = magnitudes((low, high));
        let [least, most] = &mut self.squares;
        least.add(near.times(near), nanos);
        most.add(far.times(far), nanos);
    }

    /// Mean and root of the mean square in a window that lasts for at most so many nanoseconds, when what is not certain of it
    /// may be any of these values.
    pub(super) fn finish(mut self, possible: Extent, longest: i64) -> (Extent, Extent) {
        let whole = longest.max(self.time);
        if whole <= 0 {
            return (possible, magnitudes(possible));
        }
        self.weigh(possible, whole.saturating_sub(self.time));
        let between = |[least, most]: [TimeSum; 2]| (least.over(whole).0, most.over(whole).1);
        let (low, high) = between(self.squares);
        (between(self.sum), (root(low).0, root(high).1))
    }
}

/// The least and the greatest magnitude of the numbers of an extent.
fn magnitudes((low, high): Extent) -> Extent {
    let (first, last) = (low.apart(Number::ZERO), high.apart(Number::ZERO));
    let both = !low.is_above(Number::ZERO) && !high.is_below(Number::ZERO);
    (if both { Number::ZERO } else { first.least(last) }, first.most(last))
}

/// The root, or the floats beside it.
fn root(square: Number) -> Extent {
    let near = libm::sqrt(square.as_real().max(0.0));
    let exact = [near, near.next_down(), near.next_up()].into_iter().map(Number::Real);
    let exact = exact.filter(|root| root.times(*root).compare(square).is_some_and(std::cmp::Ordering::is_eq));
    match exact.min_by(|a, b| a.as_real().total_cmp(&b.as_real())) {
        Some(root) => (root, root),
        None => (Number::Real(near.next_down().max(0.0)), Number::Real(near.next_up())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn over(values: &[(f64, i64)]) -> (Extent, Extent) {
        let mut means = Means::NONE;
        values
            .iter()
            .for_each(|(value, nanos)| means.add((Number::Real(*value), Number::Real(*value)), *nanos));
        means.finish((Number::ZERO, Number::ZERO), 0)
    }

    #[test]
    fn means_of_decimals_are_decimals() {
        let same = |number: Number| (number, number);
        let (mean, root) = over(&[(0.1, 10), (0.2, 10)]);
        assert_eq!(mean, same(Number::Real(0.15)));
        assert!(root.0.times(root.0).is_below(Number::Real(0.025)));
        assert!(root.1.times(root.1).is_above(Number::Real(0.025)));
        assert_eq!(over(&[(0.7, 3), (0.7, 4)]), (same(Number::Real(0.7)), same(Number::Real(0.7))));
        let third = over(&[(1.0, 1), (0.0, 2)]).0;
        assert!(third.0.as_real() < 1.0 / 3.0 && third.1.as_real() > 1.0 / 3.0);
        assert_eq!(over(&[]).0, same(Number::ZERO));
    }

    #[test]
    fn a_mean_of_large_whole_numbers_is_whole() {
        let mut means = Means::NONE;
        let large = Number::Int((1 << 62) + 1);
        means.add((large, large), 1 << 40);
        assert_eq!(means.finish((large, large), 1 << 40).0, (large, large));
    }
}
