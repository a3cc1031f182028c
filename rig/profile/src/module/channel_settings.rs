//! How the analogue channels of a module are configured (io: 10.3; manufacturer's product help, TM3 analogue modules).

use super::AnalogueMode;
use signal::{Decimal, Span, Unit};

/// The parameters *Minimum* and *Maximum* of a channel: what its word of %I or %Q is at the two ends of its mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CountRange {
    minimum: i16,
    maximum: i16,
}

impl CountRange {
    /// What a channel has that nothing is said of.
    pub const FULL: CountRange = CountRange { minimum: i16::MIN, maximum: i16::MAX };

    /// The range of these ends; none where the first is not below the second.
    pub const fn new(minimum: i16, maximum: i16) -> Option<CountRange> {
        if minimum < maximum { Some(CountRange { minimum, maximum }) } else { None }
    }

    /// The word at the low end.
    pub const fn minimum(self) -> i16 {
        self.minimum
    }

    /// The word at the high end.
    pub const fn maximum(self) -> i16 {
        self.maximum
    }

    /// Both.
    fn ends(self) -> [f64; 2] {
        [self.minimum, self.maximum].map(f64::from)
    }

    /// Whether the word is one of the range.
    pub const fn contains(self, word: i16) -> bool {
        self.minimum <= word && word <= self.maximum
    }

    /// The word of the range that is next to this one.
    pub fn nearest(self, word: i16) -> i16 {
        word.clamp(self.minimum, self.maximum)
    }
}

/// The parameter *Scope* of an input of temperatures: in what its word counts them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TemperatureScope {
    /// In steps of 0.1 °C.
    #[default]
    Celsius,
    /// In steps of 0.1 °F.
    Fahrenheit,
}

/// Two words of an analogue channel and the values that they stand for; between them words and values are proportional.
#[derive(Clone, Debug, PartialEq)]
pub struct AnalogueEnds {
    /// The words at the low and at the high end.
    pub words: [f64; 2],
    /// The values there, in `unit`.
    pub values: [f64; 2],
    /// The unit of the values.
    pub unit: Unit,
}

/// An analogue input that is used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AnalogueInputSettings<'a> {
    /// Its mode, one of those of the module.
    pub mode: &'a AnalogueMode,
    /// The words at the ends of the mode; without effect on one whose counts are fixed.
    pub counts: CountRange,
    /// In what a temperature is counted; without effect on anything else.
    pub scope: TemperatureScope,
    /// The time constant of its filter, a lag of the first order; zero for none.
    pub filter: Span,
}

impl<'a> AnalogueInputSettings<'a> {
    /// The longest filter; it is a multiple of [`AnalogueInputSettings::FILTER_STEP`].
    pub const LONGEST_FILTER: Span = Span::from_secs(10);

    /// What a filter is a multiple of.
    pub const FILTER_STEP: Span = Span::from_millis(10);

    /// The input with the defaults of its other parameters.
    pub const fn new(mode: &'a AnalogueMode) -> AnalogueInputSettings<'a> {
        let (counts, scope) = (CountRange::FULL, TemperatureScope::Celsius);
        AnalogueInputSettings { mode, counts, scope, filter: Span::ZERO }
    }

    /// What its words stand for; none for a mode whose ends no document has.
    pub fn ends(&self) -> Option<AnalogueEnds> {
        let values = [self.mode.low?.as_f64(), self.mode.high?.as_f64()];
        let unit = self.mode.unit.clone();
        Some(match (self.mode.step.map(Decimal::as_f64), self.scope) {
            (None, _) => AnalogueEnds { words: self.counts.ends(), values, unit },
            (Some(step), TemperatureScope::Celsius) => {
                AnalogueEnds { words: values.map(|value| (value / step).round()), values, unit }
            }
            (Some(_), TemperatureScope::Fahrenheit) => {
                let values = values.map(|celsius| celsius * 1.8 + 32.0);
                AnalogueEnds {
                    words: values.map(|value| (value * 10.0).round()),
                    values,
                    unit: Unit::new("degF"),
                }
            }
        })
    }
}

/// An analogue output that is used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AnalogueOutputSettings<'a> {
    /// Its mode, one of those of the module.
    pub mode: &'a AnalogueMode,
    /// The words at the ends of the mode.
    pub counts: CountRange,
    /// Its word of %Q where outputs are set to their default values (controller:STOP-03); one of the range.
    pub fallback: i16,
}

impl<'a> AnalogueOutputSettings<'a> {
    /// The output with these ends and the default of its fallback value: 0, or the end that is next to it.
    pub fn new(mode: &'a AnalogueMode, counts: CountRange) -> AnalogueOutputSettings<'a> {
        AnalogueOutputSettings { mode, counts, fallback: counts.nearest(0) }
    }

    /// What its words stand for; none for a mode whose ends no document has.
    pub fn ends(&self) -> Option<AnalogueEnds> {
        let values = [self.mode.low?.as_f64(), self.mode.high?.as_f64()];
        Some(AnalogueEnds { words: self.counts.ends(), values, unit: self.mode.unit.clone() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_has_two_ends_in_order() {
        assert_eq!(CountRange::new(5, 5), None);
        let range = CountRange::new(-10, 10).unwrap();
        assert_eq!([-11, -10, 10, 11].map(|word| range.contains(word)), [false, true, true, false]);
        assert_eq!([-11, 3, 11].map(|word| range.nearest(word)), [-10, 3, 10]);
    }
}
