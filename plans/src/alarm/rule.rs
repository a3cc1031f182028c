//! Whether an alarm's condition holds, value by value.

use signal::Value;

use crate::monitor::{Number, Test, Truth};

/// Whether the condition holds at the moment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Phase {
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
pub struct Rule {
    kind: Kind,
    /// How far the true value may be from the recorded one.
    slack: f64,
}

#[derive(Clone, Debug, PartialEq)]
enum Kind {
    /// Beyond `on` it holds, and then until the value is back at `off`.
    Limit { above: bool, on: Number, off: Number },
    /// The value meets a test.
    Is(Test),
}

impl Rule {
    pub(super) fn limit(above: bool, on: Number, off: Number, slack: f64) -> Rule {
        Rule { kind: Kind::Limit { above, on, off }, slack }
    }

    pub(super) fn is(test: Test, slack: f64) -> Rule {
        Rule { kind: Kind::Is(test), slack }
    }

    /// Whether it holds with this value, where it was as `before` until now.
    #[inline]
    pub fn next(&self, before: Phase, value: Value) -> Phase {
        if matches!(value, Value::Unknown) {
            return Phase::Unknown;
        }
        let (above, on, off) = match &self.kind {
            Kind::Is(test) => {
                return match test.holds(value, self.slack) {
                    Truth::True => Phase::On,
                    Truth::False => Phase::Off,
                    Truth::Unknown => Phase::Unknown,
                };
            }
            Kind::Limit { above, on, off } => (*above, *on, *off),
        };
        // A line that nobody drives is on neither side of a limit.
        if Number::of(value).is_none() {
            return Phase::Off;
        }
        // The limit itself is not beyond, and the far end of the hysteresis is back.
        let within = |limit: Number, at_most: bool| {
            let (min, max) = if at_most { (None, Some(limit)) } else { (Some(limit), None) };
            Test::Range { min, max }.holds(value, self.slack)
        };
        let beyond = within(on, above).not();
        let back = within(off, above);
        match (beyond, back, before) {
            (Truth::True, ..) => Phase::On,
            (_, Truth::True, _) => Phase::Off,
            (_, Truth::False, Phase::On) => Phase::On,
            (Truth::False, _, Phase::Off) => Phase::Off,
            _ => Phase::Unknown,
        }
    }

    /// How far off its limit a value keeps, negative beyond it; `None` where there is no limit.
    pub(super) fn margin(&self, value: Value) -> Option<f64> {
        let Kind::Limit { above, on, .. } = &self.kind else { return None };
        let (number, on) = (Number::of(value)?.as_real(), on.as_real());
        Some(if *above { on - number } else { number - on } - self.slack - value.uncertainty())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn phases(rule: &Rule, values: &[f64]) -> Vec<Phase> {
        let mut phase = Phase::Off;
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
        use Phase::{Off, On};
        let above = Rule::limit(true, Number::Int(6), Number::Int(5), 0.0);
        assert_eq!(phases(&above, &[6.0, 6.1, 5.5, 5.0, 5.5, 6.1]), [Off, On, On, Off, Off, On]);
        let below = Rule::limit(false, Number::Int(1), Number::Int(2), 0.0);
        assert_eq!(phases(&below, &[1.0, 0.9, 1.9, 2.0, 1.5]), [Off, On, On, Off, Off]);
    }

    #[test]
    fn what_is_not_known_stays_open_until_it_is_clear() {
        let rule = Rule::limit(true, Number::Int(6), Number::Int(5), 0.0);
        assert_eq!(rule.next(Phase::On, Value::Unknown), Phase::Unknown);
        assert_eq!(rule.next(Phase::Unknown, Value::Real(5.5)), Phase::Unknown);
        assert_eq!(rule.next(Phase::Unknown, Value::Real(5.0)), Phase::Off);
        assert_eq!(rule.next(Phase::Unknown, Value::Real(6.5)), Phase::On);
        let coarse = Rule::limit(true, Number::Int(6), Number::Int(6), 0.5);
        assert_eq!(coarse.next(Phase::Off, Value::Real(6.2)), Phase::Unknown);
        assert_eq!(coarse.next(Phase::Off, Value::Real(6.6)), Phase::On);
        assert_eq!(coarse.next(Phase::On, Value::Real(5.5)), Phase::Off);
    }
}
