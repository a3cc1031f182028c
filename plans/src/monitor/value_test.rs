//! Conditions on a value, answered with true, false or unknown.

use std::cmp::Ordering;

use signal::{Policy, SignalInfo, Value, ValueKind};

use super::number::differs_at_most;
use super::{Number, NumberLimits};

/// The answer to a condition on a value that may not be known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Truth {
    /// It holds.
    True,
    /// It does not hold.
    False,
    /// The value, or how exactly it is known, leaves it open.
    Unknown,
}

impl Truth {
    /// The answer of something that is known.
    pub const fn of(holds: bool) -> Truth {
        if holds { Truth::True } else { Truth::False }
    }

    /// The opposite; unknown stays unknown.
    #[must_use]
    pub const fn not(self) -> Truth {
        match self {
            Truth::True => Truth::False,
            Truth::False => Truth::True,
            Truth::Unknown => Truth::Unknown,
        }
    }

    /// Whether it may hold.
    pub const fn possible(self) -> bool {
        !matches!(self, Truth::False)
    }
}

/// A condition on a value, in the terms of one signal.
#[derive(Clone, Debug, PartialEq)]
pub enum ValueTest {
    /// It is one of these numbers; `TRUE` is 1.
    OneOf(Vec<Number>),
    /// It is a number within these limits, both included.
    Range {
        /// The least that is allowed.
        min: Option<Number>,
        /// The greatest that is allowed.
        max: Option<Number>,
    },
    /// Nobody drives the line.
    HighZ,
    /// The condition does not hold.
    Not(Box<ValueTest>),
}

impl ValueTest {
    /// It is TRUE, or a number other than 0 is required by `Not` of `FALSE`.
    pub fn bool(on: bool) -> ValueTest {
        ValueTest::OneOf(vec![Number::Int(i128::from(on))])
    }

    /// Whether a value meets the condition. `slack` is how far a number may be from what is recorded, beside what it is
    /// uncertain by itself.
    #[inline]
    pub fn holds(&self, value: Value, slack: f64) -> Truth {
        // The common case of a line first.
        if let (Value::Bool(on), ValueTest::OneOf(wanted)) = (value, self)
            && let [Number::Int(wanted)] = wanted[..]
        {
            return Truth::of(wanted == i128::from(on));
        }
        if matches!(value, Value::Unknown) {
            return Truth::Unknown;
        }
        let own = slack;
        let slack = slack + value.uncertainty();
        match self {
            ValueTest::Not(inner) => inner.holds(value, own).not(),
            ValueTest::HighZ => Truth::of(matches!(value, Value::HighZ)),
            ValueTest::OneOf(wanted) => match Number::of(value) {
                None => Truth::False,
                Some(number) if slack > 0.0 => {
                    let near = |want: &Number| {
                        let limit = Number::Real(slack);
                        differs_at_most(number, *want, 0.0, limit)
                            && differs_at_most(*want, number, 0.0, limit)
                    };
                    if wanted.iter().any(near) { Truth::Unknown } else { Truth::False }
                }
                Some(number) => {
                    Truth::of(wanted.iter().any(|want| number.compare(*want) == Some(Ordering::Equal)))
                }
            },
            ValueTest::Range { min, max } => match Number::of(value) {
                None => Truth::False,
                Some(number) if slack > 0.0 => {
                    let within = |off: f64| {
                        let none = Number::Int(0);
                        min.is_none_or(|min| differs_at_most(number, min, off, none))
                            && max.is_none_or(|max| differs_at_most(max, number, off, none))
                    };
                    match (within(slack), within(-slack)) {
                        (true, _) => Truth::True,
                        (false, true) => Truth::Unknown,
                        (false, false) => Truth::False,
                    }
                }
                Some(number) => NumberLimits { min: *min, max: *max }.allow(number),
            },
        }
    }

    /// The limits of the condition; `None` where it has none.
    pub fn bounds(&self) -> Option<record::Bounds> {
        let ValueTest::Range { min, max } = self else { return None };
        Some(record::Bounds { min: min.map(Number::as_real), max: max.map(Number::as_real) })
    }

    /// How far inside its limits a value is at least, negative outside; `None` where the condition has no limits.
    pub fn margin(&self, value: Value) -> Option<f64> {
        let ValueTest::Range { min, max } = self else { return None };
        let number = Number::of(value)?;
        let margin = NumberLimits { min: *min, max: *max }.margin((number, number));
        margin.map(|margin| margin - value.uncertainty())
    }
}

/// How far a signal's true value may be from the recorded one.
pub fn slack(info: &SignalInfo) -> f64 {
    match (info.policy, info.kind) {
        (Policy::Deadband(width), ValueKind::Int | ValueKind::Word) => width.floor(),
        (Policy::Deadband(width), _) => width,
        _ => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_at_the_limit_is_inside() {
        let test = ValueTest::Range { min: Some(Number::Int(10)), max: Some(Number::Real(20.5)) };
        assert_eq!(test.holds(Value::Int(10), 0.0), Truth::True);
        assert_eq!(test.holds(Value::Int(9), 0.0), Truth::False);
        assert_eq!(test.holds(Value::Real(20.5), 0.0), Truth::True);
        assert_eq!(test.holds(Value::Real(f64::NAN), 0.0), Truth::False);
        assert_eq!(test.margin(Value::Int(12)), Some(2.0));
        assert_eq!(test.margin(Value::Real(21.0)), Some(-0.5));
    }

    #[test]
    fn a_deadband_leaves_values_near_a_limit_open() {
        let test = ValueTest::Range { min: None, max: Some(Number::Real(10.0)) };
        assert_eq!(test.holds(Value::Real(9.7), 0.5), Truth::Unknown);
        assert_eq!(test.holds(Value::Real(9.4), 0.5), Truth::True);
        assert_eq!(test.holds(Value::Real(10.6), 0.5), Truth::False);
        assert_eq!(test.holds(Value::Int(9), 1.0), Truth::True);
        assert_eq!(test.holds(Value::Int(10), 1.0), Truth::Unknown);
        assert_eq!(test.holds(Value::Int(12), 1.0), Truth::False);
        let test = ValueTest::OneOf(vec![Number::Int(5)]);
        assert_eq!(test.holds(Value::Int(5), 1.0), Truth::Unknown);
        assert_eq!(test.holds(Value::Int(7), 1.0), Truth::False);
    }

    #[test]
    fn what_was_measured_is_inside_only_with_all_that_it_may_be() {
        let test = ValueTest::Range { min: Some(Number::Int(4)), max: Some(Number::Real(10.0)) };
        let holds = |value, by, slack| test.holds(Value::measured(value, by), slack);
        assert_eq!(holds(9.0, 0.5, 0.0), Truth::True);
        assert_eq!(holds(9.7, 0.5, 0.0), Truth::Unknown);
        assert_eq!(holds(9.0, 0.5, 0.75), Truth::Unknown, "a deadband comes on top");
        assert_eq!(holds(11.0, 0.5, 0.0), Truth::False);
        assert_eq!(
            ValueTest::Not(Box::new(test.clone())).holds(Value::measured(9.7, 0.5), 0.0),
            Truth::Unknown
        );
        assert_eq!(test.margin(Value::measured(9.0, 0.5)), Some(0.5));
        assert_eq!(
            ValueTest::OneOf(vec![Number::Int(5)]).holds(Value::measured(5.0, 0.5), 0.0),
            Truth::Unknown
        );
    }

    #[test]
    fn whole_numbers_move_by_whole_steps() {
        let mut info = SignalInfo::exact("n", ValueKind::Int);
        info.policy = Policy::Deadband(1.5);
        assert_eq!(slack(&info), 1.0);
        info.policy = Policy::Deadband(0.5);
        assert_eq!(slack(&info), 0.0);
        info.kind = ValueKind::Real;
        assert_eq!(slack(&info), 0.5);
    }

    #[test]
    fn a_line_that_nobody_drives_is_neither_true_nor_false() {
        assert_eq!(ValueTest::bool(false).holds(Value::HighZ, 0.0), Truth::False);
        assert_eq!(ValueTest::bool(true).holds(Value::HighZ, 0.0), Truth::False);
        assert_eq!(ValueTest::HighZ.holds(Value::HighZ, 0.0), Truth::True);
        assert_eq!(ValueTest::bool(true).holds(Value::Unknown, 0.0), Truth::Unknown);
    }

    #[test]
    fn large_numbers_stay_exact() {
        let test = ValueTest::OneOf(vec![Number::Int(i128::from(u64::MAX))]);
        assert_eq!(test.holds(Value::Word(u64::MAX), 0.0), Truth::True);
        assert_eq!(test.holds(Value::Word(u64::MAX - 1), 0.0), Truth::False);
    }

    #[test]
    fn a_deadband_is_added_as_a_decimal() {
        let test = ValueTest::Range { min: None, max: Some(Number::Real(0.3)) };
        assert_eq!(test.holds(Value::Real(0.1), 0.2), Truth::True);
    }
}
