//! Waves: which value a channel gets at which instant.

use super::band::{Band, quotient};
use plans::steps::ExactPeriod;
use signal::{Random, Span, Value};
use std::f64::consts::{FRAC_PI_4, TAU};

/// Draws for one value of a noise before it is cut off: with a range of at least one deviation each falls inside four
/// times in ten.
const MOST_DRAWS: u32 = 100;
/// As many different draws as a float has digits for.
const DRAWS: u64 = 1 << 53;

/// A wave with its values as numbers of its channel.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Its rule.
    pub shape: Waveform,
    /// How long it lasts; `None`: until something else drives the line.
    pub lasts: Option<Span>,
    /// From one value to the next.
    pub sample: Span,
}

/// The rule by which a value changes.
#[derive(Clone, Debug)]
pub enum Waveform {
    /// Evenly from one end of a band to the other.
    Ramp {
        /// The band; from where the line is, where the plan does not say.
        band: Band,
        /// The plan says where it begins.
        fixed: bool,
    },
    /// Up and down.
    Periodic {
        /// How.
        form: Form,
        /// From the least to the greatest value.
        band: Band,
        /// The period.
        cycle: ExactPeriod,
        /// Where in the period it begins, in parts of [`plans::steps::PeriodicWave::WHOLE`].
        phase: u32,
        /// Whether it ends with a whole period.
        whole: bool,
    },
    /// High and low; without a band a level.
    Square {
        /// From low to high.
        band: Option<Band>,
        /// The period.
        cycle: ExactPeriod,
        /// Where in the period it begins, as above.
        phase: u32,
        /// The high part of the period, as above.
        duty: u32,
    },
    /// Out of the seed.
    Noise {
        /// From the least to the greatest value.
        band: Band,
        /// Standard deviation around the middle; `None`: uniform.
        deviation: Option<f64>,
        /// What the seed is for this noise.
        seed: u64,
    },
}

/// How a periodic value goes up and down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Form {
    /// As a sine.
    Sine,
    /// Evenly up in so many millionths of the period, and evenly down in the others.
    Triangle(u32),
}

/// A period in the parts of a phase.
const WHOLE: u128 = plans::steps::PeriodicWave::WHOLE as u128;

impl Curve {
    /// How long after the beginning value `n` from 0 comes; `None` after the last.
    pub fn after(&self, n: u64) -> Option<Span> {
        if let Waveform::Square { cycle, phase, duty, .. } = &self.shape {
            let (parts, _) = edge(n, u128::from(*phase), u128::from(*duty));
            let after = cycle.after(parts, WHOLE);
            // What would come at the very end belongs to what is no more.
            let over = self.lasts.is_some_and(|lasts| after >= lasts) || after == Span::MAX;
            return (!over).then_some(after);
        }
        let after = i64::try_from(n).ok()?.checked_mul(self.sample.as_nanos()).map(Span::from_nanos)?;
        match self.lasts {
            Some(lasts) if after >= lasts => {
                // The last value is that of the end itself, however long the last sample is.
                (after - self.sample < lasts).then_some(lasts)
            }
            _ => Some(after),
        }
    }

    /// Value `n` from 0, which comes `after` the beginning.
    pub fn value(&self, n: u64, after: Span) -> Value {
        match &self.shape {
            Waveform::Ramp { band, .. } => {
                let nanos = |span: Span| u128::try_from(span.as_nanos()).unwrap_or(0);
                Value::Real(band.at(nanos(after), nanos(self.lasts.unwrap_or(after)).max(1)))
            }
            Waveform::Periodic { form, band, cycle, phase, whole } => {
                let ended = self.lasts == Some(after);
                let (part, period) = if *whole && ended { (0, 1) } else { cycle.position(after) };
                let (mut part, period) = (part * WHOLE + u128::from(*phase) * period, period * WHOLE);
                part %= period;
                // A sawtooth ends where it has come to, and not where the next one begins.
                if part == 0 && ended && matches!(form, Form::Triangle(0 | 1_000_000)) {
                    part = period;
                }
                Value::Real(match form {
                    Form::Sine => sine(part, period, band),
                    Form::Triangle(rise) => triangle(part, period, u128::from(*rise), band),
                })
            }
            Waveform::Square { band, phase, duty, .. } => {
                let (_, high) = edge(n, u128::from(*phase), u128::from(*duty));
                match band {
                    None => Value::Bool(high),
                    Some(band) => Value::Real(if high { band.to() } else { band.from() }),
                }
            }
            Waveform::Noise { band, deviation, seed } => {
                let mut random = Random::lane(*seed, n);
                Value::Real(match deviation {
                    None => band.at(u128::from(random.below(DRAWS + 1)), u128::from(DRAWS)),
                    Some(deviation) => normal(&mut random, band, *deviation),
                })
            }
        }
    }
}

/// From the beginning of a square wave to its edge `n`, in parts of a period, and the level that it brings; 0 is the
/// level in which it begins.
fn edge(n: u64, phase: u128, duty: u128) -> (u128, bool) {
    let begins_high = phase < duty;
    let Some(edges) = n.checked_sub(1) else { return (0, begins_high) };
    let (periods, second) = (u128::from(edges / 2), edges % 2 == 1);
    let (first, other) = if begins_high { (duty, WHOLE) } else { (WHOLE, WHOLE + duty) };
    let place = periods * WHOLE + if second { other } else { first };
    (place - phase, begins_high == second)
}

/// A sine at a part of its period. At its quarters it is exactly the middle or an end of the band.
fn sine(part: u128, period: u128, band: &Band) -> f64 {
    let (low, high) = (band.from(), band.to());
    // One eighth of the period after another: what is given to the series is small, and symmetric.
    let (eighth, rest) = (part * 8 / period, part * 8 % period);
    let up = quotient(rest, period) * FRAC_PI_4;
    let down = quotient(period - rest, period) * FRAC_PI_4;
    let height = match eighth {
        0 => libm::sin(up),
        1 => libm::cos(down),
        2 => libm::cos(up),
        3 => libm::sin(down),
        4 => -libm::sin(up),
        5 => -libm::cos(down),
        6 => -libm::cos(up),
        _ => -libm::sin(down),
    };
    if height >= 1.0 {
        high
    } else if height <= -1.0 {
        low
    } else {
        (band.at(1, 2) + (high - low) / 2.0 * height).clamp(low, high)
    }
}

/// A triangle at a part of its period.
fn triangle(part: u128, period: u128, rise: u128, band: &Band) -> f64 {
    const ALL: u128 = 1_000_000;
    let (place, top) = (part * ALL, period * rise);
    if place < top || (rise == ALL && place == top) {
        return band.at(place, top);
    }
    band.at(period * ALL - place, period * (ALL - rise))
}

/// A value of a normal distribution around the middle of the band that lies within the band.
fn normal(random: &mut Random, band: &Band, deviation: f64) -> f64 {
    let middle = band.at(1, 2);
    let mut value = middle;
    for _ in 0..MOST_DRAWS {
        // Box and Muller: a radius and an angle, the first never 0.
        let radius =
            libm::sqrt(-2.0 * libm::log(quotient(u128::from(random.below(DRAWS) + 1), u128::from(DRAWS))));
        let angle = TAU * quotient(u128::from(random.below(DRAWS)), u128::from(DRAWS));
        value = middle + deviation * radius * libm::cos(angle);
        if (band.from()..=band.to()).contains(&value) {
            return value;
        }
    }
    value.clamp(band.from(), band.to())
}

#[cfg(test)]
mod tests {
    use super::*;
    use signal::Decimal;

    fn band(low: i128, high: i128) -> Band {
        Band::new(Decimal::from(low), Decimal::from(high))
    }

    fn periodic(form: Form, phase: u32, lasts: Option<Span>, whole: bool) -> Curve {
        // 2 Hz in values every 25 ms: 20 of them in a period.
        let shape = Waveform::Periodic {
            form,
            band: band(-1, 3),
            cycle: ExactPeriod::of_millihertz(2_000),
            phase,
            whole,
        };
        Curve { shape, lasts, sample: Span::from_millis(25) }
    }

    /// Every value of a curve of known length, with its instant in microseconds.
    fn values(curve: &Curve) -> Vec<(i64, Value)> {
        let instants = (0..).map_while(|n| Some((n, curve.after(n)?)));
        instants.map(|(n, after)| (after.as_nanos() / 1_000, curve.value(n, after))).collect()
    }

    fn reals(curve: &Curve) -> Vec<f64> {
        values(curve).into_iter().filter_map(|(_, value)| value.as_real()).collect()
    }

    #[test]
    fn a_sine_is_exact_at_its_quarters_and_symmetric_between_them() {
        let sine = reals(&periodic(Form::Sine, 0, Some(Span::from_millis(500)), true));
        assert_eq!(sine.len(), 21);
        assert_eq!((sine[0], sine[5], sine[10], sine[15], sine[20]), (1.0, 3.0, 1.0, -1.0, 1.0));
        for n in 0..=10 {
            assert_eq!(sine[n], sine[10 - n], "{n}");
            assert!((sine[n] + sine[20 - n] - 2.0).abs() < 1e-15, "{n}");
        }
        // sin 54 deg.
        assert!((sine[3] - (1.0 + 2.0 * 0.809_016_994_374_947_5)).abs() < 1e-15);
        let quarter = periodic(Form::Sine, 90_000_000, None, false);
        assert_eq!(quarter.value(0, Span::ZERO), Value::Real(3.0));
        // Ten years later it is where it was: nothing adds up.
        let late = Span::from_secs(10 * 366 * 86_400);
        assert_eq!(quarter.value(0, late), Value::Real(3.0));
    }

    #[test]
    fn a_triangle_goes_from_its_least_to_its_greatest_value() {
        let even = reals(&periodic(Form::Triangle(500_000), 0, Some(Span::from_millis(500)), true));
        assert_eq!((even[0], even[5], even[10], even[15], even[20]), (-1.0, 1.0, 3.0, 1.0, -1.0));
        assert_eq!(even[1], -0.6);
        let saw = reals(&periodic(Form::Triangle(1_000_000), 0, Some(Span::from_millis(500)), true));
        assert_eq!((saw[0], saw[1], saw[19], saw[20]), (-1.0, -0.8, 2.8, 3.0));
        let down = reals(&periodic(Form::Triangle(0), 0, Some(Span::from_millis(500)), false));
        assert_eq!((down[0], down[1], down[20]), (3.0, 2.8, -1.0));
    }

    #[test]
    fn the_last_value_comes_at_the_very_end() {
        let ramp = Curve {
            shape: Waveform::Ramp { band: band(0, 10), fixed: true },
            lasts: Some(Span::from_micros(2_500)),
            sample: Span::from_millis(1),
        };
        let real = |micros: i64, value: f64| (micros, Value::Real(value));
        assert_eq!(values(&ramp), [real(0, 0.0), real(1_000, 4.0), real(2_000, 8.0), real(2_500, 10.0)]);
        let even = Curve { lasts: Some(Span::from_millis(2)), ..ramp };
        assert_eq!(values(&even), [real(0, 0.0), real(1_000, 5.0), real(2_000, 10.0)]);
        let short = Curve { lasts: Some(Span::from_micros(10)), ..even };
        assert_eq!(values(&short), [real(0, 0.0), real(10, 10.0)]);
    }

    #[test]
    fn a_square_wave_has_its_edges_where_its_phase_puts_them() {
        let square = |phase: u32, duty: u32| {
            let shape =
                Waveform::Square { band: None, cycle: ExactPeriod::of_millihertz(100_000), phase, duty };
            let curve = Curve { shape, lasts: Some(Span::from_millis(20)), sample: Span::from_millis(10) };
            values(&curve).into_iter().map(|(at, value)| (at, value == Value::Bool(true))).collect::<Vec<_>>()
        };
        // Nothing comes at the very end: the last period is whole.
        assert_eq!(square(0, 90_000_000), [(0, true), (2_500, false), (10_000, true), (12_500, false)]);
        assert_eq!(
            square(180_000_000, 90_000_000),
            [(0, false), (5_000, true), (7_500, false), (15_000, true), (17_500, false)]
        );
        assert_eq!(
            square(36_000_000, 90_000_000),
            [(0, true), (1_500, false), (9_000, true), (11_500, false), (19_000, true)]
        );
    }

    #[test]
    fn noise_keeps_its_range_and_its_seed() {
        let noise = |deviation, seed| {
            let shape = Waveform::Noise { band: band(-1, 1), deviation, seed };
            reals(&Curve { shape, lasts: Some(Span::from_secs(20)), sample: Span::from_millis(1) })
        };
        let spread = |values: &[f64]| {
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            (mean, values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / values.len() as f64)
        };
        let (uniform, normal) = (noise(None, 7), noise(Some(0.2), 7));
        for values in [&uniform, &normal] {
            assert!(values.iter().all(|value| (-1.0..=1.0).contains(value)));
        }
        // A uniform distribution over 2 has a variance of 1/3; 20 001 draws come within a few per cent.
        let (mean, variance) = spread(&uniform);
        assert!(mean.abs() < 0.02 && (variance - 1.0 / 3.0).abs() < 0.01, "{mean} {variance}");
        let (mean, variance) = spread(&normal);
        assert!(mean.abs() < 0.01 && (variance - 0.04).abs() < 0.002, "{mean} {variance}");
        assert_eq!(uniform, noise(None, 7));
        assert_ne!(uniform, noise(None, 8));
    }
}
