//! What a step waits for, and whether a change is that.

use std::cmp::Ordering;

use signal::{SignalInfo, Span, Value};

use crate::lang::{Anchor, Literal};
use crate::meaning::{number, value_of};
use crate::monitor::Number;

/// What an awaited step waits for, as a plan says it.
#[derive(Clone, Debug, PartialEq)]
pub enum StepCondition {
    /// The signal changes to this value.
    Becomes(Literal),
    /// It becomes TRUE (or non-zero).
    Rises,
    /// It becomes FALSE (or zero).
    Falls,
    /// Any change.
    Changes,
    /// It moves from at or below to above this.
    Above(Literal),
    /// It moves from at or above to below this.
    Below(Literal),
}

impl StepCondition {
    /// The same of this signal; `None` where it cannot have the value.
    pub fn bind(&self, info: &SignalInfo) -> Option<AwaitedChange> {
        let limit = |literal: &Literal| number(literal, info).ok();
        match self {
            StepCondition::Becomes(literal) => value_of(literal, info).ok().map(AwaitedChange::Becomes),
            StepCondition::Rises => Some(AwaitedChange::Rises),
            StepCondition::Falls => Some(AwaitedChange::Falls),
            StepCondition::Changes => Some(AwaitedChange::Changes),
            StepCondition::Above(literal) => limit(literal).map(AwaitedChange::Above),
            StepCondition::Below(literal) => limit(literal).map(AwaitedChange::Below),
        }
    }
}

/// How a step waits.
#[derive(Clone, Debug, PartialEq)]
pub struct StepWait {
    /// The signal that it looks at.
    pub signal: String,
    /// What the signal has to do.
    pub awaits: StepCondition,
    /// Where waiting begins, counted from the step that the plan names.
    pub from: Anchor,
    /// How long it waits.
    pub within: Span,
}

/// What an awaited step waits for, of one signal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AwaitedChange {
    /// The signal becomes this value.
    Becomes(Value),
    /// It becomes TRUE.
    Rises,
    /// It becomes FALSE.
    Falls,
    /// It changes.
    Changes,
    /// It moves from at or below to above this.
    Above(Number),
    /// It moves from at or above to below this.
    Below(Number),
}

impl AwaitedChange {
    /// Whether a change of the signal is what is waited for.
    pub fn met(self, before: Option<Value>, value: Value) -> bool {
        let number = |value: Option<Value>| value.and_then(Number::of);
        match self {
            AwaitedChange::Becomes(wanted) => value == wanted,
            AwaitedChange::Rises => {
                value.as_bool() == Some(true) && before.and_then(Value::as_bool) != Some(true)
            }
            AwaitedChange::Falls => {
                value.as_bool() == Some(false) && before.and_then(Value::as_bool) != Some(false)
            }
            AwaitedChange::Changes => true,
            AwaitedChange::Above(limit) => {
                number(Some(value)).is_some_and(|now| now.is_above(limit))
                    && number(before).is_none_or(|then| then.compare(limit).is_some_and(Ordering::is_le))
            }
            AwaitedChange::Below(limit) => {
                number(Some(value)).is_some_and(|now| now.is_below(limit))
                    && number(before).is_none_or(|then| then.compare(limit).is_some_and(Ordering::is_ge))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_limit_is_crossed_beyond_every_float() {
        let above = AwaitedChange::Above(Number::Int((1 << 62) + 1));
        let met = |before, now| above.met(Some(Value::Int(before)), Value::Int(now));
        assert!(met((1 << 62) + 1, (1 << 62) + 2));
        assert!(!met(1 << 62, (1 << 62) + 1) && !met((1 << 62) + 2, (1 << 62) + 3));
        let below = AwaitedChange::Below(Number::Real(0.3));
        assert!(below.met(Some(Value::Real(0.3)), Value::Real(0.2)));
        assert!(!below.met(Some(Value::Real(f64::NAN)), Value::Real(0.2)));
    }
}
