//! From what a converter measures to the quantity of a channel.

use super::{InRange, Reading};

/// A point of a calibration: what was shown, and what it really was, in the unit of the channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// What the channel showed.
    pub shown: f64,
    /// What a better instrument said.
    pub truly: f64,
}

/// How the quantity of a channel follows from that at its input.
#[derive(Clone, Debug, PartialEq)]
pub struct Scale {
    /// Of the channel, for each unit at the input; not 0.
    pub gain: f64,
    /// Of the channel where the input is at 0.
    pub offset: f64,
    /// Below this, at the input, the wire is open: a live zero that is missing.
    pub open_below: Option<f64>,
    /// Above this, at the input, the sensor says that it fails, or its wire is shorted.
    pub short_above: Option<f64>,
    /// Points of the calibration, in rising order of what was shown and of what it was. One point shifts, several are
    /// joined by lines, of which the outer ones go on.
    pub calibration: Vec<Point>,
    /// By how much more than this the quantity has to differ from what was told last.
    pub deadband: f64,
}

impl Default for Scale {
    /// The quantity at the input as it is.
    fn default() -> Scale {
        Scale {
            gain: 1.0,
            offset: 0.0,
            open_below: None,
            short_above: None,
            calibration: Vec::new(),
            deadband: 0.0,
        }
    }
}

impl Scale {
    /// The quantity behind a reading. `None` where it is not known: the input is at an end of its range, so that there
    /// may be more, or what it shows is that of a wire or sensor that failed.
    pub fn quantity(&self, reading: &Reading) -> Option<f64> {
        let beyond = reading.range != InRange::Yes
            || self.open_below.is_some_and(|least| reading.value < least)
            || self.short_above.is_some_and(|most| reading.value > most);
        let quantity = self.corrected(reading.value * self.gain + self.offset);
        (!beyond && quantity.is_finite()).then_some(quantity)
    }

    /// Whether a quantity has to be told of where the other one was told last.
    pub fn differs(&self, last: Option<f64>, now: Option<f64>) -> bool {
        match (last, now) {
            (Some(last), Some(now)) if self.deadband > 0.0 => (now - last).abs() > self.deadband,
            (last, now) => last != now,
        }
    }

    /// By the calibration.
    fn corrected(&self, shown: f64) -> f64 {
        match self.calibration[..] {
            [] => shown,
            [only] => shown + only.truly - only.shown,
            [.., last] => {
                // The part that the quantity lies in, or the outer one beside it.
                let behind = self.calibration.partition_point(|point| point.shown < shown);
                let behind = behind.clamp(1, self.calibration.len() - 1);
                let (from, to) =
                    (self.calibration[behind - 1], self.calibration.get(behind).unwrap_or(&last));
                let slope = (to.truly - from.truly) / (to.shown - from.shown);
                from.truly + (shown - from.shown) * slope
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn reading(value: f64) -> Reading {
        Reading { input: 0, before: 0, after: 0, value, range: InRange::Yes }
    }

    fn points(points: &[[f64; 2]]) -> Vec<Point> {
        points.iter().map(|[shown, truly]| Point { shown: *shown, truly: *truly }).collect()
    }

    #[test]
    fn a_current_loop_is_scaled_and_its_open_wire_is_no_pressure() {
        // 250 Ohm: 4 to 20 mA are 1 to 5 V and 0 to 16 bar.
        let loop_ = Scale {
            gain: 4.0,
            offset: -4.0,
            open_below: Some(0.9),
            short_above: Some(5.25),
            ..Scale::default()
        };
        assert_eq!(loop_.quantity(&reading(1.0)), Some(0.0));
        assert_eq!(loop_.quantity(&reading(5.0)), Some(16.0));
        assert_eq!(loop_.quantity(&reading(0.9)), Some(-0.3999999999999999));
        assert_eq!((loop_.quantity(&reading(0.899)), loop_.quantity(&reading(5.26))), (None, None));
    }

    #[test]
    fn the_end_of_a_range_is_no_value() {
        let at_end = |range| Scale::default().quantity(&Reading { range, ..reading(3.3) });
        assert_eq!(
            [at_end(InRange::Yes), at_end(InRange::Above), at_end(InRange::Below)],
            [Some(3.3), None, None]
        );
    }

    #[test]
    fn a_calibration_shifts_joins_its_points_and_goes_on_beyond_them() {
        let by =
            |at: &[[f64; 2]], shown| Scale { calibration: points(at), ..Scale::default() }.corrected(shown);
        assert_eq!(by(&[[1.0, 1.5]], 4.0), 4.5);
        assert_eq!([0.0, 1.0, 2.0, 3.0].map(|at| by(&[[1.0, 2.0], [2.0, 4.0]], at)), [0.0, 2.0, 4.0, 6.0]);
        let table = [[0.0, 0.0], [1.0, 2.0], [3.0, 3.0]];
        assert_eq!([-1.0, 0.5, 1.0, 2.0, 5.0].map(|at| by(&table, at)), [-2.0, 1.0, 2.0, 2.5, 4.0]);
    }

    #[test]
    fn a_deadband_is_what_a_change_has_to_be_more_than() {
        let every = Scale::default();
        let coarse = Scale { deadband: 0.5, ..Scale::default() };
        assert!(every.differs(Some(1.0), Some(1.1)) && !every.differs(Some(1.0), Some(1.0)));
        assert!(!coarse.differs(Some(1.0), Some(1.5)) && coarse.differs(Some(1.0), Some(1.6)));
        for scale in [every, coarse] {
            assert!(
                scale.differs(Some(1.0), None)
                    && scale.differs(None, Some(1.0))
                    && !scale.differs(None, None)
            );
        }
    }

    proptest! {
        #[test]
        fn a_rising_calibration_keeps_the_order(
            steps in prop::collection::vec((0.01..10.0f64, 0.01..10.0f64), 0..6), a in -50.0..50.0f64, b in -50.0..50.0f64,
        ) {
            let mut at = [0.0, 0.0];
            let rising: Vec<[f64; 2]> = steps.iter().map(|(x, y)| {
                at = [at[0] + x, at[1] + y];
                at
            }).collect();
            let scale = Scale { calibration: points(&rising), ..Scale::default() };
            let (low, high) = (a.min(b), a.max(b));
            prop_assert!(scale.corrected(low) <= scale.corrected(high) + 1e-9);
        }
    }
}
