//! What a step waits for, and whether a change is that.

use signal::Value;

/// What an awaited step waits for.
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
    Above(f64),
    /// It moves from at or above to below this.
    Below(f64),
}

impl AwaitedChange {
    /// Whether a change of the signal is what is waited for.
    pub fn met(self, before: Option<Value>, value: Value) -> bool {
        let real = |value: Option<Value>| value.and_then(Value::as_real);
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
                real(Some(value)).is_some_and(|now| now > limit)
                    && real(before).is_none_or(|then| then <= limit)
            }
            AwaitedChange::Below(limit) => {
                real(Some(value)).is_some_and(|now| now < limit)
                    && real(before).is_none_or(|then| then >= limit)
            }
        }
    }
}
