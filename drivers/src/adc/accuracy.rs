//! How far what a channel shows may lie from what it measures.

use signal::{Coverage, Decimal};

/// What a board file says of the errors of an input and of all that lies in front of it, in the channel's unit after its
/// calibration. They add up.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Accuracy {
    /// A part of the value.
    pub of_value: f64,
    /// A part of the input's range.
    pub of_range: f64,
    /// The same everywhere, in the channel's unit.
    pub plus: f64,
    /// What these figures cover.
    pub coverage: Coverage,
}

/// What a converter knows of an input by itself, in the unit of its readings.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Resolution {
    /// From one code to the next; 0 where that is not known.
    pub step: f64,
    /// From the lower end of the range to the upper one; `None` where that is not known.
    pub range: Option<f64>,
}

/// What the samples behind one reading say of its noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// How far single samples lie from their mean (standard deviation), in the unit of the reading.
    pub deviation: f64,
    /// How many samples there were, at least two.
    pub samples: u32,
}

/// Student's t for 95 % on both sides, by degrees of freedom from 1 on; more of them come to [`MANY`].
const STUDENT: [f64; 30] = [
    12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228, 2.201, 2.179, 2.160, 2.145, 2.131,
    2.120, 2.110, 2.101, 2.093, 2.086, 2.080, 2.074, 2.069, 2.064, 2.060, 2.056, 2.052, 2.048, 2.045, 2.042,
];
/// The same for more than thirty.
const MANY: f64 = 2.04;

impl Noise {
    /// What [`Noise::of_mean`] covers.
    pub fn coverage() -> Coverage {
        Coverage::Probability(Decimal::from(95))
    }

    /// How far the mean may lie from the quantity, in 95 of 100 readings: the expanded uncertainty of the Guide to the
    /// expression of uncertainty in measurement (GUM), with Student's factor for the few samples that there are.
    pub fn of_mean(self) -> f64 {
        let samples = self.samples.max(2);
        let factor = STUDENT.get(samples as usize - 2).copied().unwrap_or(MANY);
        factor * self.deviation / libm::sqrt(f64::from(samples))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_of_few_samples_is_worth_little() {
        let of = |samples| Noise { deviation: 1.0, samples }.of_mean();
        // GUM, table G.2: 12.71 for one degree of freedom, 2.13 for 15.
        assert!((of(2) - 12.706 / 2f64.sqrt()).abs() < 1e-12);
        assert!((of(16) - 2.131 / 4.0).abs() < 1e-12);
        assert!((of(10_000) - 0.0204).abs() < 1e-12);
        assert!((2..200).all(|samples| of(samples + 1) < of(samples)));
    }
}
