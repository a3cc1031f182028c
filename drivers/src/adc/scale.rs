//! From what a converter measures to the quantity of a channel.

use signal::{SignalGap, Value};

use super::{Accuracy, AdcReading, InRange, Noise, Resolution};

/// What a channel shows: a quantity with how far the truth may lie from it, or why there is none.
pub type Shown = Result<Value, SignalGap>;

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
    /// By how much more than this the quantity has to differ from what was reported last.
    pub deadband: f64,
    /// What is known of its errors, its steps and its noise aside.
    pub accuracy: Accuracy,
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
            accuracy: Accuracy::default(),
        }
    }
}

impl Scale {
    /// The quantity behind a reading. None is known where the input is at an end of its range, so that there may be more,
    /// or where it shows what a wire or sensor shows that failed.
    ///
    /// # Errors
    /// Why it is not known.
    pub fn quantity(&self, reading: &AdcReading, resolution: Resolution, noise: Option<Noise>) -> Shown {
        if self.open_below.is_some_and(|least| reading.value < least) {
            return Err(SignalGap::OpenWire);
        }
        if self.short_above.is_some_and(|most| reading.value > most) {
            return Err(SignalGap::Failed);
        }
        let quantity = self.shown(reading.value);
        match reading.range {
            InRange::Below => Err(SignalGap::Below),
            // A scale that leads beyond all numbers is one that shows more than can be reported.
            InRange::Yes if quantity.is_finite() => {
                Ok(Value::measured(quantity, self.uncertainty(reading.value, quantity, resolution, noise)))
            }
            InRange::Above | InRange::Yes => Err(SignalGap::Above),
        }
    }

    /// What the channel shows of this at the input.
    fn shown(&self, value: f64) -> f64 {
        self.corrected(value * self.gain + self.offset)
    }

    /// How far the truth may lie from `quantity`, which is what the channel shows of `value`: half a step and the noise
    /// at the input, and what the board file says of its errors.
    fn uncertainty(&self, value: f64, quantity: f64, resolution: Resolution, noise: Option<Noise>) -> f64 {
        let at_input = resolution.step / 2.0 + noise.map_or(0.0, Noise::of_mean);
        let of_range = self.accuracy.of_range * resolution.range.unwrap_or_default() * self.gain.abs();
        self.change(value, quantity, at_input)
            + self.accuracy.of_value * quantity.abs()
            + of_range
            + self.accuracy.plus
    }

    /// How far the channel moves at most when its input moves so far; `quantity` is what it shows of `value`.
    fn change(&self, value: f64, quantity: f64, by: f64) -> f64 {
        if by == 0.0 {
            return 0.0;
        }
        (self.shown(value + by) - quantity).abs().max((self.shown(value - by) - quantity).abs())
    }

    /// How noisy the channel is: the standard deviation of single samples, in its unit.
    pub fn noise(&self, value: f64, noise: Noise) -> f64 {
        self.change(value, self.shown(value), noise.deviation)
    }

    /// Whether what a channel shows has to be reported where the other one was reported last.
    pub fn differs(&self, last: Shown, now: Shown) -> bool {
        match (last, now) {
            // What lies within the band around the last one needs no telling, with all that it may be.
            (Ok(last), Ok(now)) if self.deadband > 0.0 => {
                let apart = |last: f64, now: f64| (now - last).abs();
                let wider = (now.uncertainty() - last.uncertainty()).max(0.0);
                match (last.as_real(), now.as_real()) {
                    (Some(last), Some(now)) => apart(last, now) + wider > self.deadband,
                    _ => true,
                }
            }
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
    use host::HostInstant;
    use proptest::prelude::*;

    fn reading(value: f64) -> AdcReading {
        AdcReading {
            input: 0,
            before: HostInstant::BOOT,
            after: HostInstant::BOOT,
            value,
            range: InRange::Yes,
        }
    }

    /// What is shown by a converter that is exact.
    fn shown(scale: &Scale, reading: &AdcReading) -> Shown {
        scale.quantity(reading, Resolution::default(), None)
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
        let shown = |volts| shown(&loop_, &reading(volts));
        assert_eq!(shown(1.0), Ok(Value::Real(0.0)));
        assert_eq!(shown(5.0), Ok(Value::Real(16.0)));
        assert_eq!(shown(0.9), Ok(Value::Real(-0.3999999999999999)));
        assert_eq!((shown(0.899), shown(5.26)), (Err(SignalGap::OpenWire), Err(SignalGap::Failed)));
    }

    #[test]
    fn the_end_of_a_range_is_no_value() {
        let at_end = |range| shown(&Scale::default(), &AdcReading { range, ..reading(3.3) });
        assert_eq!(
            [at_end(InRange::Yes), at_end(InRange::Above), at_end(InRange::Below)],
            [Ok(Value::Real(3.3)), Err(SignalGap::Above), Err(SignalGap::Below)]
        );
    }

    #[test]
    fn steps_noise_and_the_errors_of_the_board_file_add_up() {
        let resolution = Resolution { step: 0.01, range: Some(10.0) };
        let scale = Scale { gain: -4.0, offset: 20.0, ..Scale::default() };
        let uncertainty = |scale: &Scale, noise| {
            let shown = scale.quantity(&reading(3.0), resolution, noise).unwrap();
            assert_eq!(shown.as_real(), Some(8.0));
            shown.uncertainty()
        };
        let near = |is: f64, wanted: f64| assert!(is >= wanted && is <= wanted * 1.04, "{is} for {wanted}");
        near(uncertainty(&scale, None), 0.02);
        let noise = Noise { deviation: 0.1, samples: 16 };
        near(uncertainty(&scale, Some(noise)), 0.02 + 4.0 * 2.131 * 0.1 / 4.0);
        assert!((scale.noise(3.0, noise) - 0.4).abs() < 1e-12);
        let accuracy = Accuracy { of_value: 0.01, of_range: 0.001, plus: 0.3, ..Accuracy::default() };
        let stated = Scale { accuracy, ..scale };
        near(uncertainty(&stated, None), 0.02 + 0.08 + 0.04 + 0.3);
    }

    #[test]
    fn a_step_is_as_wide_as_the_calibration_makes_it() {
        // Steep below 1, flat above it.
        let scale =
            Scale { calibration: points(&[[0.0, 0.0], [1.0, 10.0], [2.0, 11.0]]), ..Scale::default() };
        let uncertainty = |volts| {
            let resolution = Resolution { step: 0.2, range: None };
            scale.quantity(&reading(volts), resolution, None).unwrap().uncertainty()
        };
        let near =
            |is: f64, wanted: f64| assert!(is >= wanted - 1e-9 && is <= wanted * 1.04, "{is} for {wanted}");
        near(uncertainty(0.5), 1.0);
        near(uncertainty(1.5), 0.1);
        near(uncertainty(1.0), 1.0);
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
        let one = Ok(Value::Real(1.0));
        let now = |value, by| Ok(Value::measured(value, by));
        assert!(
            every.differs(one, now(1.1, 0.0))
                && !every.differs(one, one)
                && every.differs(one, now(1.0, 0.1))
        );
        assert!(!coarse.differs(one, now(1.5, 0.0)) && coarse.differs(one, now(1.6, 0.0)));
        assert!(!coarse.differs(one, now(1.25, 0.2)) && coarse.differs(one, now(1.25, 0.3)));
        assert!(!coarse.differs(now(1.25, 0.3), one), "what is known better need not be told");
        for scale in [every, coarse] {
            let (open, above) = (Err(SignalGap::OpenWire), Err(SignalGap::Above));
            assert!(scale.differs(one, open) && scale.differs(open, one) && scale.differs(open, above));
            assert!(!scale.differs(open, open));
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
