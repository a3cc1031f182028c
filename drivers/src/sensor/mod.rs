//! The curves of temperature sensors: from a resistance or a voltage to degrees Celsius.
//!
//! Platinum: IEC 60751. Nickel: DIN 43760. Thermocouples: the reference functions of IEC 60584-1 on the scale of 1990, with the
//! reference junction at 0 °C. Beyond its ends a curve goes on as a straight line, so that what is out of range reads so.

mod thermocouple;

use thermocouple::{COUPLES, Piece};

/// A sensor with a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SensorCurve(Curve);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Curve {
    /// Platinum with so many ohms at 0 °C.
    Platinum(u16),
    /// Nickel with so many ohms at 0 °C.
    Nickel(u16),
    /// A pair of metals, by its place among them.
    Thermocouple(usize),
}

/// Halvings of the range that leave nothing of a float.
const HALVINGS: usize = 64;

impl SensorCurve {
    /// The curve of a mode of an analogue input; none of a mode that is no such sensor, or of which there is no curve.
    pub fn of_mode(mode: &str) -> Option<SensorCurve> {
        let curve = match mode {
            "PT100" => Curve::Platinum(100),
            "PT1000" => Curve::Platinum(1_000),
            "NI100" => Curve::Nickel(100),
            "NI1000" => Curve::Nickel(1_000),
            _ => {
                let letter = mode.strip_prefix("thermocouple ")?;
                Curve::Thermocouple(COUPLES.iter().position(|(known, _)| *known == letter)?)
            }
        };
        Some(SensorCurve(curve))
    }

    /// The unit of what the sensor shows.
    pub const fn unit(self) -> &'static str {
        match self.0 {
            Curve::Platinum(_) | Curve::Nickel(_) => "Ohm",
            Curve::Thermocouple(_) => "mV",
        }
    }

    /// The temperatures between which the curve rises.
    fn range(self) -> (f64, f64) {
        match self.0 {
            Curve::Platinum(_) => (-200.0, 850.0),
            Curve::Nickel(_) => (-60.0, 180.0),
            Curve::Thermocouple(place) => {
                let pieces = pieces(place);
                (pieces.first().map_or(0.0, |piece| piece.from), pieces.last().map_or(0.0, |piece| piece.to))
            }
        }
    }

    /// What the sensor shows at a temperature of the range.
    fn signal(self, celsius: f64) -> f64 {
        let t = celsius;
        match self.0 {
            Curve::Platinum(ohms) => {
                let below = if t < 0.0 { -4.183e-12 * (t - 100.0) * t * t * t } else { 0.0 };
                f64::from(ohms) * (1.0 + 3.9083e-3 * t - 5.775e-7 * t * t + below)
            }
            Curve::Nickel(ohms) => {
                let (t2, t4) = (t * t, t * t * t * t);
                f64::from(ohms) * (1.0 + 5.485e-3 * t + 6.65e-6 * t2 + 2.805e-11 * t4 - 2e-17 * t4 * t2)
            }
            Curve::Thermocouple(place) => {
                let pieces = pieces(place);
                let piece = pieces.iter().find(|piece| t <= piece.to).or(pieces.last());
                piece.map_or(0.0, |piece| piece.millivolts(t))
            }
        }
    }

    /// The temperature at which the sensor shows this, in degrees Celsius.
    pub fn temperature(self, shown: f64) -> f64 {
        let (mut low, mut high) = self.range();
        let (first, last) = (self.signal(low), self.signal(high));
        // The last degree within the range has the slope beyond it.
        if shown <= first {
            return low + (shown - first) / (self.signal(low + 1.0) - first);
        }
        if shown >= last {
            return high + (shown - last) / (last - self.signal(high - 1.0));
        }
        for _ in 0..HALVINGS {
            let middle = low + (high - low) / 2.0;
            if self.signal(middle) < shown { low = middle } else { high = middle }
        }
        high
    }
}

/// The parts of the reference function at this place.
fn pieces(place: usize) -> &'static [Piece] {
    COUPLES.get(place).map_or(&[], |(_, pieces)| pieces)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A mode, how far off a rounded figure is at most, and temperatures with what the sensor shows.
    type PrintedTable<'a> = (&'a str, f64, &'a [(f64, f64)]);

    fn curve(mode: &str) -> SensorCurve {
        SensorCurve::of_mode(mode).unwrap()
    }

    // The tables of the standards, rounded to 0.01 Ohm and 0.001 mV.
    #[test]
    fn curves_agree_with_the_tables_of_the_standards() {
        let tables: [PrintedTable<'_>; 11] = [
            (
                "PT100",
                0.005,
                &[(-200.0, 18.52), (-100.0, 60.26), (0.0, 100.0), (100.0, 138.51), (850.0, 390.48)],
            ),
            ("PT1000", 0.05, &[(-200.0, 185.2), (0.0, 1_000.0), (100.0, 1_385.1), (400.0, 2_470.9)]),
            ("NI100", 0.05, &[(-60.0, 69.5), (0.0, 100.0), (100.0, 161.8), (180.0, 223.2)]),
            (
                "thermocouple K",
                0.000_5,
                &[(-200.0, -5.891), (0.0, 0.0), (100.0, 4.096), (500.0, 20.644), (1_300.0, 52.41)],
            ),
            (
                "thermocouple J",
                0.000_5,
                &[(-200.0, -7.89), (0.0, 0.0), (100.0, 5.269), (760.0, 42.919), (1_000.0, 57.953)],
            ),
            (
                "thermocouple T",
                0.000_5,
                &[(-200.0, -5.603), (0.0, 0.0), (100.0, 4.279), (200.0, 9.288), (400.0, 20.872)],
            ),
            (
                "thermocouple E",
                0.000_5,
                &[(-200.0, -8.825), (0.0, 0.0), (100.0, 6.319), (500.0, 37.005), (800.0, 61.017)],
            ),
            (
                "thermocouple N",
                0.000_5,
                &[(-200.0, -3.99), (0.0, 0.0), (100.0, 2.774), (500.0, 16.748), (1_300.0, 47.513)],
            ),
            (
                "thermocouple R",
                0.000_5,
                &[(0.0, 0.0), (100.0, 0.647), (500.0, 4.471), (1_000.0, 10.506), (1_700.0, 20.222)],
            ),
            (
                "thermocouple S",
                0.000_5,
                &[(0.0, 0.0), (100.0, 0.646), (500.0, 4.233), (1_000.0, 9.587), (1_700.0, 17.947)],
            ),
            (
                "thermocouple B",
                0.000_5,
                &[(100.0, 0.033), (500.0, 1.242), (1_000.0, 4.834), (1_500.0, 10.099), (1_820.0, 13.82)],
            ),
        ];
        for (mode, off, points) in tables {
            for (celsius, shown) in points {
                let found = curve(mode).signal(*celsius);
                assert!((found - shown).abs() <= off + 1e-9, "{mode} at {celsius} °C: {found}");
            }
        }
    }

    #[test]
    fn temperatures_are_found_again() {
        for mode in
            ["PT100", "NI1000", "thermocouple K", "thermocouple J", "thermocouple B", "thermocouple T"]
        {
            let (low, high) = curve(mode).range();
            for part in 0..=100 {
                let celsius = low + (high - low) * f64::from(part) / 100.0;
                let found = curve(mode).temperature(curve(mode).signal(celsius));
                assert!((found - celsius).abs() < 1e-6, "{mode} at {celsius} °C: {found}");
            }
        }
    }

    #[test]
    fn beyond_its_ends_a_curve_goes_on() {
        assert!(curve("PT100").temperature(390.6) > 850.1);
        assert!(curve("PT100").temperature(0.0) < -230.0);
        assert!(curve("thermocouple N").temperature(47.6) > 1_300.1);
        assert_eq!((curve("PT100").unit(), curve("thermocouple K").unit()), ("Ohm", "mV"));
        for unknown in ["thermocouple C", "NTC", "0..10 V", "thermocouple"] {
            assert_eq!(SensorCurve::of_mode(unknown), None, "{unknown}");
        }
    }
}
