//! Between the value at the terminal of an analogue channel and its word of %I or %Q.
//!
//! Values are whole billionths of the unit here, and all divisions round to the nearest: a resolution of b bits divides the mode
//! into 2^b - 1 steps, of which a value is rounded to one, and the step is rounded to a word. Steps and words are counted from the
//! low end, and a half goes away from it; temperatures and ohms are counted from 0, and a half goes away from that.

use profile::{
    AnalogueInputSettings, AnalogueMode, AnalogueOutputSettings, ChannelStatus, CountRange, TemperatureScope,
};
use signal::Decimal;

/// Parts of a unit.
const PARTS: i64 = 1_000_000_000;

/// Of a mode without limits values are cut here: far beyond every word, and small enough to be computed with.
const FAR: i64 = 1_000_000 * PARTS;

/// The nearest whole billionths; those that are too many are held at the ends of the range.
#[inline]
pub(super) fn parts(real: f64) -> i64 {
    let parts = real * PARTS as f64;
    let whole = parts as i64;
    // What is left is exact, and 0 where whole numbers are too many: each input is here once for each conversion.
    let rest = parts - whole as f64;
    if rest >= 0.5 {
        whole.saturating_add(1)
    } else if rest <= -0.5 {
        whole.saturating_sub(1)
    } else {
        whole
    }
}

/// A figure of the catalogue in billionths.
fn figure(number: Decimal) -> i64 {
    let whole = number.shifted(9).floor();
    i64::try_from(whole).unwrap_or(FAR).clamp(-FAR, FAR)
}

/// The nearest whole quotient; `under` is above 0.
fn quotient(over: i64, under: i64) -> i64 {
    let half = under / 2;
    if over < 0 { -((half - over) / under) } else { (half + over) / under }
}

/// The nearest word.
fn word(number: i64) -> i16 {
    number.clamp(i64::from(i16::MIN), i64::from(i16::MAX)) as i16
}

/// The steps into which a resolution divides a mode; without one they are those of its words.
fn steps(bits: Option<u8>, counts: CountRange) -> i64 {
    match bits {
        Some(bits) => (1 << bits.clamp(1, 16)) - 1,
        None => width(counts),
    }
}

/// From one end of the words to the other.
fn width(counts: CountRange) -> i64 {
    i64::from(counts.maximum()) - i64::from(counts.minimum())
}

/// The ends of a mode in billionths, the first below the second; none where no document has them.
fn ends(mode: &AnalogueMode) -> Option<(i64, i64)> {
    let ends = (figure(mode.low?), figure(mode.high?));
    (ends.0 < ends.1).then_some(ends)
}

/// What an input makes of a value.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Converted {
    /// Its word of %I.
    pub(super) word: i16,
    /// Its status byte.
    pub(super) status: ChannelStatus,
}

/// How words follow from values.
#[derive(Clone, Copy, Debug)]
enum Law {
    /// From the ends of the mode to those of the words.
    Ends { low: i64, high: i64, steps: i64, counts: CountRange },
    /// A word is a number of such parts of a unit.
    Parts(i64),
    /// The same of tenths of a degree Fahrenheit, of a value in degrees Celsius.
    Fahrenheit,
}

/// The conversion of an input.
#[derive(Clone, Debug)]
pub(super) struct InputScale {
    law: Law,
    /// Values are cut to these.
    least: i64,
    most: i64,
    /// From here down the input is under range.
    under: i64,
    /// From here up it is over range.
    over: i64,
    /// The ends of an extended mode.
    extended: Option<(i64, i64)>,
}

impl InputScale {
    /// The conversion of an input of a module with such a resolution.
    pub(super) fn new(settings: &AnalogueInputSettings<'_>, bits: Option<u8>) -> InputScale {
        let (mode, counts) = (settings.mode, settings.counts);
        let ends = ends(mode);
        let law = match (mode.step.map(figure), ends) {
            (None, Some((low, high))) => Law::Ends { low, high, steps: steps(bits, counts), counts },
            _ if settings.scope == TemperatureScope::Fahrenheit => Law::Fahrenheit,
            // Of the temperatures of TM2 modules and cartridges no document has a step either.
            (step, _) => Law::Parts(step.filter(|step| *step > 0).unwrap_or(PARTS / 10)),
        };
        // A limit is the first value that is out of range; the end of a mode without limits is the last one that is not.
        let limit = |limit: Option<Decimal>, end: Option<i64>, beyond: i64, far: i64| match (
            limit.map(figure),
            end,
        ) {
            (Some(limit), _) => (limit, limit),
            (None, Some(end)) => (end, end + beyond),
            (None, None) => (far, far + beyond),
        };
        let (least, under) = limit(mode.under_range, ends.map(|(low, _)| low), -1, -FAR);
        let (most, over) = limit(mode.over_range, ends.map(|(_, high)| high), 1, FAR);
        InputScale { law, least, most, under, over, extended: ends.filter(|_| mode.extended) }
    }

    /// What becomes of a value in billionths.
    pub(super) fn convert(&self, value: i64) -> Converted {
        let status = match self.extended {
            _ if value >= self.over => ChannelStatus::OverRange,
            _ if value <= self.under => ChannelStatus::UnderRange,
            Some((_, high)) if value > high => ChannelStatus::AboveEnd,
            Some((low, _)) if value < low => ChannelStatus::BelowEnd,
            _ => ChannelStatus::Normal,
        };
        Converted { word: self.word(value.max(self.least).min(self.most)), status }
    }

    /// What becomes of a sensor that is not connected: its current finds no way, as at the highest resistance.
    pub(super) fn open(&self) -> Converted {
        Converted { word: self.word(self.most), status: ChannelStatus::OverRange }
    }

    fn word(&self, value: i64) -> i16 {
        word(match self.law {
            Law::Ends { low, high, steps, counts } => {
                let step = quotient((value - low) * steps, high - low);
                i64::from(counts.minimum()) + quotient(step * width(counts), steps)
            }
            Law::Parts(parts) => quotient(value, parts),
            // The value of 0.1 °F is 5/9 of that of 0.1 °C.
            Law::Fahrenheit => quotient(value * 9 + 160 * PARTS, PARTS / 2),
        })
    }
}

/// The conversion of an output.
#[derive(Clone, Debug)]
pub(super) struct OutputScale {
    low: i64,
    high: i64,
    steps: i64,
    counts: CountRange,
}

impl OutputScale {
    /// The conversion of an output of a module with such a resolution; none where the mode has no ends.
    pub(super) fn new(settings: &AnalogueOutputSettings<'_>, bits: Option<u8>) -> Option<OutputScale> {
        let (low, high) = ends(settings.mode)?;
        Some(OutputScale { low, high, steps: steps(bits, settings.counts), counts: settings.counts })
    }

    /// What the terminal shows of a word, in the unit of the mode. Words beyond the ends count as the ends.
    pub(super) fn value(&self, word: i16) -> f64 {
        let word = i64::from(self.counts.nearest(word)) - i64::from(self.counts.minimum());
        let step = quotient(word * self.steps, width(self.counts));
        let value = self.low + quotient(step * (self.high - self.low), self.steps);
        value as f64 / PARTS as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use signal::Unit;

    fn mode(ends: Option<(&str, &str)>, limits: Option<(&str, &str)>, step: Option<&str>) -> AnalogueMode {
        let number = |text: &str| Decimal::split(text).unwrap().0;
        AnalogueMode {
            name: String::from("test"),
            unit: Unit::new("V"),
            low: ends.map(|(low, _)| number(low)),
            high: ends.map(|(_, high)| number(high)),
            under_range: limits.map(|(under, _)| number(under)),
            over_range: limits.map(|(_, over)| number(over)),
            step: step.map(number),
            extended: false,
            sources: Vec::new(),
        }
    }

    fn input(mode: &AnalogueMode, counts: (i16, i16), bits: Option<u8>) -> InputScale {
        let counts = CountRange::new(counts.0, counts.1).unwrap();
        InputScale::new(&AnalogueInputSettings { counts, ..AnalogueInputSettings::new(mode) }, bits)
    }

    fn converted(scale: &InputScale, value: f64) -> (i16, u8) {
        let Converted { word, status } = scale.convert(parts(value));
        (word, status.code())
    }

    #[test]
    fn parts_are_rounded_halves_away_from_zero() {
        let mut random = signal::Random::new(1);
        for _ in 0..100_000 {
            let real = f64::from_bits(random.below(u64::MAX));
            assert_eq!(parts(real), libm::round(real * PARTS as f64) as i64, "{real}");
            let near = (random.below(u64::MAX) as i64 >> 20) as f64 / (2.0 * PARTS as f64);
            assert_eq!(parts(near), libm::round(near * PARTS as f64) as i64, "{near}");
        }
        for real in
            [0.0, -0.0, 0.5e-9, -0.5e-9, 4.999_999_999_999_999e-10, 1e300, -1e300, f64::INFINITY, f64::NAN]
        {
            assert_eq!(parts(real), libm::round(real * PARTS as f64) as i64, "{real}");
        }
    }

    // io: 10.3: 12 bit of 10 V are steps of 2.44 mV.
    #[test]
    fn a_value_is_rounded_to_a_step_and_that_to_a_word() {
        let mode = mode(Some(("0", "10")), Some(("-0.20", "10.20")), None);
        let scale = input(&mode, (0, 10_000), Some(12));
        assert_eq!([0.0, 5.0, 10.0].map(|volts| converted(&scale, volts)), [(0, 0), (5_001, 0), (10_000, 0)]);
        // The first step begins at the half of it: 1.2210 mV.
        assert_eq!([0.001_221, 0.001_222].map(|volts| converted(&scale, volts).0), [0, 2]);
        let fine = input(&mode, (0, 10_000), Some(16));
        assert_eq!(converted(&fine, 5.0), (5_000, 0));
        let all = input(&mode, (i16::MIN, i16::MAX), None);
        assert_eq!([0.0, 10.0].map(|volts| converted(&all, volts)), [(i16::MIN, 0), (i16::MAX, 0)]);
    }

    #[test]
    fn halves_go_away_from_the_low_end() {
        let mode = mode(Some(("4", "20")), Some(("3.68", "20.32")), None);
        let scale = input(&mode, (-100, 100), None);
        let at = |value| converted(&scale, value).0;
        assert_eq!([4.04, 5.08, 3.96].map(at), [-99, -86, -101]);
        let counts = CountRange::new(-3, 2).unwrap();
        let output = OutputScale::new(&AnalogueOutputSettings::new(&mode, counts), Some(1)).unwrap();
        assert_eq!([-3, -1, 0, 2].map(|word| output.value(word)), [4.0, 4.0, 20.0, 20.0]);
    }

    #[test]
    fn values_beyond_a_limit_are_cut_to_it_and_reported() {
        let mode = mode(Some(("4", "20")), Some(("3.68", "20.32")), None);
        let scale = input(&mode, (0, 10_000), None);
        let at = |value| converted(&scale, value);
        assert_eq!([4.0, 12.0, 20.0].map(at), [(0, 0), (5_000, 0), (10_000, 0)]);
        assert_eq!([3.69, 3.68, 0.0].map(at), [(-194, 0), (-200, 6), (-200, 6)]);
        assert_eq!([20.31, 20.32, 24.0].map(at), [(10_194, 0), (10_200, 5), (10_200, 5)]);
        assert_eq!([f64::NEG_INFINITY, f64::INFINITY].map(at), [(-200, 6), (10_200, 5)]);
    }

    #[test]
    fn an_extended_mode_reports_that_it_is_beyond_its_ends() {
        let mode = AnalogueMode { extended: true, ..mode(Some(("4", "20")), Some(("1.20", "23.17")), None) };
        let scale = input(&mode, (0, 10_000), None);
        let status = |value| converted(&scale, value).1;
        assert_eq!([4.0, 3.99, 1.21, 1.2, 20.0, 20.01, 23.16, 23.17].map(status), [0, 9, 9, 6, 0, 8, 8, 5]);
    }

    #[test]
    fn the_ends_of_a_mode_without_limits_are_in_range() {
        let mode = mode(Some(("0", "20")), None, None);
        let scale = input(&mode, (0, 20_000), None);
        let at = |value| converted(&scale, value);
        assert_eq!([-0.1, 0.0, 20.0, 20.1].map(at), [(0, 6), (0, 0), (20_000, 0), (20_000, 5)]);
    }

    #[test]
    fn temperatures_are_counted_in_tenths() {
        let mode = mode(Some(("-200", "850")), None, Some("0.1"));
        let settings = AnalogueInputSettings::new(&mode);
        let celsius = InputScale::new(&settings, Some(16));
        let at = |value| converted(&celsius, value);
        assert_eq!([-200.0, 20.04, 20.05, 850.0].map(at), [(-2_000, 0), (200, 0), (201, 0), (8_500, 0)]);
        assert_eq!([-201.0, 851.0].map(at), [(-2_000, 6), (8_500, 5)]);
        assert_eq!(celsius.open(), Converted { word: 8_500, status: ChannelStatus::OverRange });
        let scope = TemperatureScope::Fahrenheit;
        let fahrenheit = InputScale::new(&AnalogueInputSettings { scope, ..settings }, Some(16));
        let at = |value| converted(&fahrenheit, value).0;
        assert_eq!([-40.0, 0.0, 100.0, 37.77, 37.78].map(at), [-400, 320, 2_120, 1_000, 1_000]);
        assert_eq!([37.75, 37.74].map(at), [1_000, 999]);
    }

    #[test]
    fn without_a_range_the_word_is_the_limit() {
        let mode = mode(None, None, Some("0.1"));
        let scale = input(&mode, (0, 1), None);
        let at = |value| converted(&scale, value);
        assert_eq!([1e300, -1e300].map(at), [(i16::MAX, 5), (i16::MIN, 6)]);
        assert_eq!(at(4_000.0), (i16::MAX, 0));
    }

    #[test]
    fn an_output_shows_steps_and_nothing_beyond_its_ends() {
        let volts = mode(Some(("0", "10")), None, None);
        let counts = CountRange::new(0, 10_000).unwrap();
        let scale = OutputScale::new(&AnalogueOutputSettings::new(&volts, counts), Some(12)).unwrap();
        assert_eq!(
            [-1, 0, 5_000, 10_000, 10_001].map(|word| scale.value(word)),
            [0.0, 0.0, 5.001_221_001, 10.0, 10.0]
        );
        let unknown = mode(None, None, None);
        assert!(OutputScale::new(&AnalogueOutputSettings::new(&unknown, counts), None).is_none());
    }
}
