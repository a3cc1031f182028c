//! Whether an alarm's condition holds, value by value.

use signal::Value;

use crate::monitor::{Number, Truth, ValueTest, distance};

/// Whether the condition holds at the moment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ConditionState {
    /// It does not.
    Off,
    /// It does.
    On,
    /// The value, or how exactly it is known, leaves it open.
    #[default]
    Unknown,
}

/// A condition with its hysteresis, in the terms of one signal.
#[derive(Clone, Debug, PartialEq)]
pub struct AlarmRule {
    kind: RuleKind,
    /// How far the true value may be from the recorded one.
    slack: f64,
}

#[derive(Clone, Debug, PartialEq)]
enum RuleKind {
    /// Beyond `on` it holds, and then until the value is back at `off`.
    Limit { above: bool, on: Number, off: Number },
    /// The value meets a test.
    Is(ValueTest),
}

impl AlarmRule {
    pub(super) fn limit(above: bool, on: Number, off: Number, slack: f64) -> AlarmRule {
        AlarmRule { kind: RuleKind::Limit { above, on, off }, slack }
    }

    pub(super) fn is(test: ValueTest, slack: f64) -> AlarmRule {
        AlarmRule { kind: RuleKind::Is(test), slack }
    }

    /// Whether it holds with this value, where it was as `before` until now.
    #[inline]
    pub fn next(&self, before: ConditionState, value: Value) -> ConditionState {
        if matches!(value, Value::Unknown) {
            return ConditionState::Unknown;
        }
        let (above, on, off) = match &self.kind {
            RuleKind::Is(test) => {
                return match test.holds(value, self.slack) {
                    Truth::True => ConditionState::On,
                    Truth::False => ConditionState::Off,
                    Truth::Unknown => ConditionState::Unknown,
                };
            }
            RuleKind::Limit { above, on, off } => (*above, *on, *off),
        };
        // A line that nobody drives is on neither side of a limit.
        if Number::of(value).is_none() {
            return ConditionState::Off;
        }
        // The limit itself is not beyond, and the far end of the hysteresis is back.
        let within = |limit: Number, at_most: bool| {
            let (min, max) = if at_most { (None, Some(limit)) } else { (Some(limit), None) };
            ValueTest::Range { min, max }.holds(value, self.slack)
        };
        let beyond = within(on, above).not();
        let back = within(off, above);
        match (beyond, back, before) {
            (Truth::True, ..) => ConditionState::On,
            (_, Truth::True, _) => ConditionState::Off,
            (_, Truth::False, ConditionState::On) => ConditionState::On,
            (Truth::False, _, ConditionState::Off) => ConditionState::Off,
            _ => ConditionState::Unknown,
        }
    }

    /// How far off its limit a value keeps, negative beyond it; `None` where there is no limit.
    pub(super) fn margin(&self, value: Value) -> Option<f64> {
        let RuleKind::Limit { above, on, .. } = &self.kind else { return None };
        let number = Number::of(value)?;
        let away = if *above { distance(number, *on) } else { distance(*on, number) };
        Some(away - self.slack - value.uncertainty())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn phases(rule: &AlarmRule, values: &[f64]) -> Vec<ConditionState> {
        let mut phase = ConditionState::Off;
        values
            .iter()
            .map(|value| {
                phase = rule.next(phase, Value::Real(*value));
                phase
            })
            .collect()
    }

    #[test]
    fn it_is_over_only_behind_the_hysteresis() {
        use ConditionState::{Off, On};
        let above = AlarmRule::limit(true, Number::Int(6), Number::Int(5), 0.0);
        assert_eq!(phases(&above, &[6.0, 6.1, 5.5, 5.0, 5.5, 6.1]), [Off, On, On, Off, Off, On]);
        let below = AlarmRule::limit(false, Number::Int(1), Number::Int(2), 0.0);
        assert_eq!(phases(&below, &[1.0, 0.9, 1.9, 2.0, 1.5]), [Off, On, On, Off, Off]);
    }

    #[test]
    fn what_is_not_known_stays_open_until_it_is_clear() {
        let rule = AlarmRule::limit(true, Number::Int(6), Number::Int(5), 0.0);
        assert_eq!(rule.next(ConditionState::On, Value::Unknown), ConditionState::Unknown);
        assert_eq!(rule.next(ConditionState::Unknown, Value::Real(5.5)), ConditionState::Unknown);
        assert_eq!(rule.next(ConditionState::Unknown, Value::Real(5.0)), ConditionState::Off);
        assert_eq!(rule.next(ConditionState::Unknown, Value::Real(6.5)), ConditionState::On);
        let coarse = AlarmRule::limit(true, Number::Int(6), Number::Int(6), 0.5);
        assert_eq!(coarse.next(ConditionState::Off, Value::Real(6.2)), ConditionState::Unknown);
        assert_eq!(coarse.next(ConditionState::Off, Value::Real(6.6)), ConditionState::On);
        assert_eq!(coarse.next(ConditionState::On, Value::Real(5.5)), ConditionState::Off);
    }
}
