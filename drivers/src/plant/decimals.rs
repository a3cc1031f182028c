//! The decimal numbers that computed values are but for rounding.

/// Decimal numbers of twelve or thirteen digits up to a size.
#[derive(Clone, Copy, Debug)]
pub(super) struct Decimals {
    /// Ten to the number of decimals.
    power: f64,
    /// By how much rounding can have moved a value.
    room: f64,
}

impl Decimals {
    /// Of values up to `size`, which are computed from numbers up to `most` where that is more.
    pub(super) fn new(size: f64, most: f64) -> Decimals {
        let (size, most) = (libm::fabs(size), libm::fabs(most));
        let decimals = 12.0 - libm::floor(libm::log10(size));
        // Up to the 22nd a power of ten is an exact float, and a quotient by it is rounded once.
        let count = if (0.0..=22.0).contains(&decimals) { decimals as u32 } else { 0 };
        let power = (0..count).fold(1.0, |power, _| power * 10.0);
        Decimals { power, room: 4.0 * f64::EPSILON * size.max(most) }
    }

    /// The decimal number that this value is but for rounding; the value where it is none.
    pub(super) fn nearest(&self, value: f64) -> f64 {
        let decimal = libm::round(value * self.power) / self.power;
        // A sum with 0 has no sign where it is 0.
        if libm::fabs(decimal - value) <= self.room { decimal + 0.0 } else { value }
    }

    /// The sum of two numbers that are decimal ones but for rounding.
    pub(super) fn sum(one: f64, other: f64) -> f64 {
        let size = libm::fabs(one).max(libm::fabs(other));
        Decimals::new(size, size).nearest(one + other)
    }
}

/// What is shown of a value whose law is linear: it lies within a range, and is the decimal number that it is but for rounding.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShownRange {
    low: f64,
    high: f64,
    decimals: Decimals,
}

impl ShownRange {
    /// A range in the unit of the output; `most` as of [`Decimals::new`].
    pub(super) fn new(low: f64, high: f64, most: f64) -> ShownRange {
        ShownRange { low, high, decimals: Decimals::new(libm::fabs(low).max(libm::fabs(high)), most) }
    }

    /// By how much rounding can have moved a value.
    pub(super) fn room(&self) -> f64 {
        self.decimals.room
    }

    /// What is shown of this value.
    pub(super) fn shown(&self, value: f64) -> f64 {
        self.decimals.nearest(value).clamp(self.low, self.high)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values that a person computes in decimals, from floats that a machine computes them from.
    #[test]
    fn what_is_computed_in_decimals_is_met() {
        let range = ShownRange::new(4.0, 20.0, 20.0);
        let mut rounded = 0;
        for step in 0..=2_000 {
            let (level, exact) = (f64::from(step) / 1_000.0, f64::from(4_000 + 8 * step) / 1_000.0);
            let computed = 4.0 + level * 8.0;
            rounded += u32::from(computed != exact);
            assert_eq!(range.shown(computed), exact, "{level}");
        }
        assert!(rounded > 100, "{rounded}");
        assert_eq!(Decimals::sum(0.1, 0.2), 0.3);
        assert_eq!(Decimals::sum(0.3, -0.3).to_bits(), 0);
    }

    #[test]
    fn what_is_no_decimal_number_stays_as_it_is() {
        let decimals = Decimals::new(20.0, 20.0);
        for value in [20.0 / 3.0, 4.0 + 1.0 / 7.0, 5.44 + 2e-14, f64::INFINITY, 1e-300] {
            assert!((decimals.nearest(value) - value).abs() <= 1e-299 || value == f64::INFINITY, "{value}");
        }
        assert_eq!(ShownRange::new(0.0, 100.0, 100.0).shown(-1.4e-14), 0.0);
        assert_eq!(ShownRange::new(0.0, 100.0, 100.0).shown(100.000_000_000_000_01), 100.0);
        assert_eq!(ShownRange::new(0.0, 100.0, 100.0).shown(100.1), 100.0);
        assert_eq!(Decimals::new(0.0, 0.0).nearest(0.0), 0.0);
    }
}
