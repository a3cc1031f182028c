//! What a written value means for a signal.

use crate::expect::condition;
use crate::lang::Literal;
use signal::{Kind, SignalInfo, Value};

/// A written value as a value of this signal: labels are those of its state, quantities are in its unit.
///
/// # Errors
/// Why it has no meaning for the signal.
pub fn value_of(literal: &Literal, info: &SignalInfo) -> Result<Value, String> {
    if condition::is_high_z(literal) && info.kind != Kind::State {
        return Ok(Value::HighZ);
    }
    Ok(match condition::number(literal, info)? {
        crate::judge::Number::Real(real) => Value::Real(real),
        crate::judge::Number::Int(number) => match i64::try_from(number) {
            Ok(number) => Value::Int(number),
            Err(_) => {
                Value::Word(u64::try_from(number).map_err(|_| String::from("the number has over 64 bits"))?)
            }
        },
    })
}

/// A written value in words.
pub fn show_literal(literal: &Literal) -> String {
    condition::show(literal)
}
