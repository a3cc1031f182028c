//! The levels of a voltage that was sampled: when it passes a threshold with a hysteresis, as far as its readings are
//! known.

use crate::{Capture, CapturedChange, CapturedChannel, ChannelType};
use signal::{Policy, SignalRecording, Value, When};

/// How far the truth may lie from a reading, either way.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ReadingError {
    /// A part of the reading: 0.01 for 1 %; at least 0.
    pub of_value: f64,
    /// The same everywhere, in the unit of the channel; at least 0.
    pub plus: f64,
}

/// From where on a voltage is a level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevelRule {
    /// The middle between both levels, in the unit of the channel.
    pub threshold: f64,
    /// The level is TRUE above the threshold and half of this, FALSE at or below the threshold less half of it, and between
    /// them what it was before; at least 0.
    pub hysteresis: f64,
    /// How far the readings may be off.
    pub error: ReadingError,
}

impl ReadingError {
    /// How far the truth may lie from this reading, rounded up.
    pub fn of(&self, reading: f64) -> f64 {
        let off = self.of_value * reading.abs() + self.plus;
        if off > 0.0 { off.next_up() } else { 0.0 }
    }
}

/// What of both levels a reading can be.
struct Possible {
    may_be_high: bool,
    may_be_low: bool,
}

impl LevelRule {
    /// `None` for what is no number.
    fn possible(&self, value: Value) -> Option<Possible> {
        let reading = value.as_real().filter(|reading| reading.is_finite())?;
        let off = self.off(reading, value);
        let half = self.hysteresis / 2.0;
        // TRUE above, FALSE at or below; what lies between is neither.
        Some(Possible {
            may_be_high: reading + off > self.threshold + half,
            may_be_low: reading - off <= self.threshold - half,
        })
    }

    /// How far the truth may lie from a reading, by what is stated of it and by what it carries itself.
    fn off(&self, reading: f64, value: Value) -> f64 {
        match value.uncertainty() {
            0.0 => self.error.of(reading),
            own => (self.error.of(reading) + own).next_up(),
        }
    }

    /// Whether the reading is one of this level for certain.
    fn must_be(&self, value: Value, high: bool) -> bool {
        let Some(reading) = value.as_real() else { return false };
        let off = self.off(reading, value);
        let half = self.hysteresis / 2.0;
        match high {
            true => reading - off > self.threshold + half,
            false => reading + off <= self.threshold - half,
        }
    }
}

/// Follows a channel.
struct LevelDetector {
    rule: LevelRule,
    /// The level, where it is known.
    level: Option<bool>,
    /// From when on it may have passed to the other level, where that is not certain yet.
    passing: Option<When>,
}

impl LevelDetector {
    /// The next reading; hands on what the level is from when on.
    fn see(&mut self, at: When, value: Value, put: &mut dyn FnMut(When, Value)) {
        let Some(possible) = self.rule.possible(value) else {
            self.finish(put);
            self.level = None;
            put(at, if value == Value::HighZ { value } else { Value::Unknown });
            return;
        };
        if let Some(level) = self.level {
            let (other, back) = match level {
                true => (possible.may_be_low, possible.may_be_high),
                false => (possible.may_be_high, possible.may_be_low),
            };
            let since = self.passing;
            if self.rule.must_be(value, !level) {
                // It passed once, between where it first may have and where it had.
                let from = since.map_or(at.earliest, |since| since.earliest);
                put(When::within(from, at.latest), Value::Bool(!level));
                (self.level, self.passing) = (Some(!level), None);
            } else if since.is_some() && back {
                // It may have passed and come back.
                self.finish(put);
            } else if other && since.is_none() {
                self.passing = Some(at);
                // A reading that may be of either level may have been both before the next.
                if back {
                    self.finish(put);
                }
            }
        }
        if self.level.is_none() {
            for level in [true, false].into_iter().filter(|level| self.rule.must_be(value, *level)) {
                put(at, Value::Bool(level));
                self.level = Some(level);
            }
        }
    }

    /// Nothing comes any more: whether it passed stays open.
    fn finish(&mut self, put: &mut dyn FnMut(When, Value)) {
        if let Some(since) = self.passing.take() {
            put(since, Value::Unknown);
            self.level = None;
        }
    }
}

impl Capture {
    /// Adds a channel of levels for each rule, after the channels that there are and with the name of the channel that it
    /// follows. In the order of the rules.
    pub fn add_levels(&mut self, rules: &[(usize, LevelRule)]) -> Vec<usize> {
        let first = self.channels.len();
        let mut detectors: Vec<(usize, LevelDetector)> = Vec::new();
        for &(channel, rule) in rules {
            let of = &self.channels[channel];
            self.channels.push(CapturedChannel {
                name: of.name.clone(),
                shares_name: of.shares_name,
                unit: String::new(),
                shape: ChannelType::Bit,
                // The rule has what a deadband leaves open; a level has none.
                recording: of
                    .recording
                    .map(|recording| SignalRecording { policy: Policy::Changes, ..recording }),
            });
            detectors.push((channel, LevelDetector { rule, level: None, passing: None }));
        }
        if rules.is_empty() {
            return Vec::new();
        }
        let mut changes = Vec::with_capacity(self.changes.len());
        for change in std::mem::take(&mut self.changes) {
            changes.push(change);
            for (place, (channel, detector)) in detectors.iter_mut().enumerate() {
                if change.channel as usize != *channel {
                    continue;
                }
                let own = (first + place) as u32;
                detector.see(change.at, change.value, &mut |at, value| {
                    changes.push(CapturedChange { channel: own, at, value });
                });
            }
        }
        for (place, (_, detector)) in detectors.iter_mut().enumerate() {
            let own = (first + place) as u32;
            detector.finish(&mut |at, value| changes.push(CapturedChange { channel: own, at, value }));
        }
        self.changes = changes;
        self.sort();
        (first..self.channels.len()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use signal::Time;

    fn rule(threshold: f64, hysteresis: f64, plus: f64) -> LevelRule {
        LevelRule { threshold, hysteresis, error: ReadingError { of_value: 0.0, plus } }
    }

    /// The levels of readings, one each millisecond: from and until when each began, in milliseconds.
    fn levels(rule: LevelRule, readings: &[f64]) -> Vec<(i64, i64, Value)> {
        let mut out = Vec::new();
        let mut detector = LevelDetector { rule, level: None, passing: None };
        let ms = |at: Time| at.as_nanos() / 1_000_000;
        let mut put = |at: When, value| out.push((ms(at.earliest), ms(at.latest), value));
        for (place, reading) in (0i64..).zip(readings) {
            let instant = |ms: i64| Time::from_nanos(ms.max(0) * 1_000_000);
            let at = When::within(instant(place - 1), instant(place));
            detector.see(at, Value::Real(*reading), &mut put);
        }
        detector.finish(&mut put);
        out
    }

    const ON: Value = Value::Bool(true);
    const OFF: Value = Value::Bool(false);
    const OPEN: Value = Value::Unknown;

    #[test]
    fn without_hysteresis_it_is_true_above_the_threshold() {
        let seen = levels(rule(2.5, 0.0, 0.0), &[0.0, 2.5, 2.6, 2.5]);
        assert_eq!(seen, [(0, 0, OFF), (1, 2, ON), (2, 3, OFF)]);
    }

    #[test]
    fn within_the_hysteresis_it_is_what_it_was() {
        let seen = levels(rule(2.5, 1.0, 0.0), &[0.0, 2.9, 3.1, 2.1, 3.0, 2.0]);
        assert_eq!(seen, [(0, 0, OFF), (1, 2, ON), (4, 5, OFF)]);
        // Where it begins within it, nothing is known before it leaves.
        assert_eq!(levels(rule(2.5, 1.0, 0.0), &[2.5, 2.6, 3.1]), [(1, 2, ON)]);
    }

    #[test]
    fn a_reading_that_may_be_off_widens_the_instant() {
        // Above 3.0 it is TRUE: 2.95 may be, 3.2 is. From then on it may have been between 0 and 2 ms.
        let seen = levels(rule(2.5, 1.0, 0.1), &[0.0, 2.95, 3.2, 1.0]);
        assert_eq!(seen, [(0, 0, OFF), (0, 2, ON), (2, 3, OFF)]);
        // It may have come and gone.
        let seen = levels(rule(2.5, 1.0, 0.1), &[0.0, 2.95, 1.0]);
        assert_eq!(seen, [(0, 0, OFF), (0, 1, OPEN), (1, 2, OFF)]);
        // It may have come, and nothing decides it before the end.
        assert_eq!(levels(rule(2.5, 1.0, 0.1), &[0.0, 2.95, 2.8]), [(0, 0, OFF), (0, 1, OPEN)]);
        // An error above the hysteresis: 2.5 may be any level.
        let seen = levels(rule(2.5, 0.0, 0.1), &[0.0, 2.5, 5.0]);
        assert_eq!(seen, [(0, 0, OFF), (0, 1, OPEN), (1, 2, ON)]);
    }

    #[test]
    fn a_part_of_the_reading_counts_by_its_size() {
        let part = LevelRule { error: ReadingError { of_value: 0.1, plus: 0.0 }, ..rule(10.0, 0.0, 0.0) };
        // 9 V may be 9.9 V, 9.5 V may be 10.45 V.
        assert_eq!(levels(part, &[0.0, 9.0]), [(0, 0, OFF)]);
        assert_eq!(levels(part, &[0.0, 9.5]), [(0, 0, OFF), (0, 1, OPEN)]);
    }

    proptest! {
        // Whatever the truth was at each reading, its level is among those that are known.
        #[test]
        fn no_truth_contradicts_the_levels(
            truth in proptest::collection::vec(0.0..5.0f64, 1..40),
            off in proptest::collection::vec(-1.0..=1.0f64, 40),
            hysteresis in 0.0..2.0f64,
            plus in 0.0..0.6f64,
        ) {
            let rule = rule(2.5, hysteresis, plus);
            let readings: Vec<f64> = truth.iter().zip(&off).map(|(truth, off)| truth + off * plus).collect();
            let known = levels(rule, &readings);
            let mut level = None;
            for (at, truth) in (0i64..).zip(&truth) {
                if *truth > 2.5 + hysteresis / 2.0 { level = Some(true) }
                if *truth <= 2.5 - hysteresis / 2.0 { level = Some(false) }
                // All that may hold at this instant: the last that must have begun, and those that may have.
                let last = known.iter().rposition(|(_, latest, _)| *latest <= at);
                let can = known.iter().enumerate().filter(|(place, (earliest, ..))| {
                    Some(*place) == last || (last.is_none_or(|last| *place > last) && *earliest < at.max(1))
                });
                let holds = can.into_iter().any(|(_, (_, _, value))| {
                    *value == Value::Unknown || level.is_none_or(|level| *value == Value::Bool(level))
                });
                prop_assert!(last.is_none() || holds, "{at}: {level:?} of {known:?}");
            }
        }
    }
}
