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

    /// A value, as a decimal number where it is known as one, and as a float.
    fn add(&mut self, (value, near): (Option<Decimal>, f64), nanos: i64) {
        let product = value.and_then(|value| value.times(Decimal::from(i128::from(nanos))));
        self.exact = self.exact.zip(product).and_then(|(sum, product)| sum.plus(product));
        let near = near * nanos as f64;
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

/// The values of a window, or their squares, weighed with the time that they last.
#[derive(Clone, Debug)]
pub(super) struct Means {
    squares: bool,
    /// Certain time in nanoseconds, and with it the sums: the least and the greatest that they may be.
    time: i64,
    sums: [TimeSum; 2],
}

impl Means {
    /// For the mean, or with `squares` for the root of the mean square.
    pub(super) const fn new(squares: bool) -> Means {
        Means { squares, time: 0, sums: [TimeSum::NONE; 2] }
    }

    /// A number of this extent lasts for so many nanoseconds.
    pub(super) fn add(&mut self, extent: Extent, nanos: i64) {
        self.time = self.time.saturating_add(nanos);
        self.weigh(extent, nanos);
    }

    fn weigh(&mut self, extent: Extent, nanos: i64) {
        let (low, high) = if self.squares { magnitudes(extent) } else { extent };
        let weighed = |number: Number, sum: &TimeSum| {
            // Once there was no room there is no need to look.
            let exact = sum.exact.and_then(|_| number.as_decimal());
            match (self.squares, number.as_real()) {
                (true, near) => (exact.and_then(|exact| exact.times(exact)), near * near),
                (false, near) => (exact, near),
            }
        };
        let least = weighed(low, &self.sums[0]);
        let most = if low == high { least } else { weighed(high, &self.sums[1]) };
        self.sums[0].add(least, nanos);
        self.sums[1].add(most, nanos);
    }

    /// The mean, or the root, in a window that lasts for at most so many nanoseconds, when what is not certain of it may be any of
    /// these values.
    pub(super) fn finish(mut self, possible: Extent, longest: i64) -> Extent {
        let whole = longest.max(self.time);
        if whole <= 0 {
            return if self.squares { magnitudes(possible) } else { possible };
        }
        self.weigh(possible, whole.saturating_sub(self.time));
        let (low, high) = (self.sums[0].over(whole).0, self.sums[1].over(whole).1);
        if self.squares { (root(low).0, root(high).1) } else { (low, high) }
    }
}

/// The least and the greatest magnitude of the numbers of an extent.
fn magnitudes((low, high): Extent) -> Extent {
    let (first, last) = (low.abs(), high.abs());
    let both = !low.is_above(Number::ZERO) && !high.is_below(Number::ZERO);
    (if both { Number::ZERO } else { first.least(last) }, first.most(last))
}

/// The root, or the floats beside it.
pub(super) fn root(square: Number) -> Extent {
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

    fn over(squares: bool, values: &[(f64, i64)]) -> Extent {
        let mut means = Means::new(squares);
        values
            .iter()
            .for_each(|(value, nanos)| means.add((Number::Real(*value), Number::Real(*value)), *nanos));
        means.finish((Number::ZERO, Number::ZERO), 0)
    }

    #[test]
    fn means_of_decimals_are_decimals() {
        let same = |number: Number| (number, number);
        assert_eq!(over(false, &[(0.1, 10), (0.2, 10)]), same(Number::Real(0.15)));
        let root = over(true, &[(0.1, 10), (0.2, 10)]);
        assert!(root.0.times(root.0).is_below(Number::Real(0.025)));
        assert!(root.1.times(root.1).is_above(Number::Real(0.025)));
        for squares in [false, true] {
            assert_eq!(over(squares, &[(0.7, 3), (0.7, 4)]), same(Number::Real(0.7)));
            assert_eq!(over(squares, &[]), same(Number::ZERO));
        }
        assert_eq!(over(true, &[(-0.7, 3), (0.7, 4)]), same(Number::Real(0.7)));
        let third = over(false, &[(1.0, 1), (0.0, 2)]);
        assert!(third.0.as_real() < 1.0 / 3.0 && third.1.as_real() > 1.0 / 3.0);
    }

    #[test]
    fn a_sum_without_room_is_an_interval() {
        let third = (1.0 / 3.0, 1 << 40);
        let found = over(true, &[third, (1e-9 / 7.0, 1 << 40)]);
        assert!(found.0.as_real() < found.1.as_real());
        assert!((found.0.as_real() - found.1.as_real()).abs() < 1e-9);
    }

    #[test]
    fn a_mean_of_large_whole_numbers_is_whole() {
        let mut means = Means::new(false);
        let large = Number::Int((1 << 62) + 1);
        means.add((large, large), 1 << 40);
        assert_eq!(means.finish((large, large), 1 << 40), (large, large));
    }
}
