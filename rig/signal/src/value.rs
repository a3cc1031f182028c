//! What a signal can be.

use std::fmt;

/// The state of a wire or terminal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Level {
    /// Driven to 0 V, or contact open on an output that loads pull down.
    Low,
    /// Driven to the supply.
    High,
    /// Not driven (high impedance).
    HighZ,
}

impl Level {
    /// The level that a Boolean drives.
    pub const fn from_bool(on: bool) -> Self {
        if on { Level::High } else { Level::Low }
    }

    /// What an input sees: only a driven 1 is TRUE.
    pub const fn is_high(self) -> bool {
        matches!(self, Level::High)
    }
}

/// A value of a signal at an instant.
#[derive(Clone, Copy, Debug)]
pub enum Value {
    /// A Boolean or a driven line.
    Bool(bool),
    /// A signed number, a small unsigned number, a state's number, or TIME in nanoseconds.
    Int(i64),
    /// A bit string or an unsigned number of up to 64 bits.
    Word(u64),
    /// A measured or computed real number, in the signal's unit.
    Real(f64),
    /// A line that nobody drives.
    HighZ,
    /// Not known: not yet read, or its device is lost.
    Unknown,
}

impl Value {
    /// The exact integer behind a Boolean, number or bit string.
    pub fn as_int(self) -> Option<i128> {
        match self {
            Value::Bool(b) => Some(i128::from(b)),
            Value::Int(n) => Some(i128::from(n)),
            Value::Word(n) => Some(i128::from(n)),
            Value::Real(_) | Value::HighZ | Value::Unknown => None,
        }
    }

    /// The value as a real number, where it has one. Integers above 2^53 lose digits.
    pub fn as_real(self) -> Option<f64> {
        match self {
            Value::Real(r) => Some(r),
            other => other.as_int().map(|n| n as f64),
        }
    }

    /// The value as a truth, where it has one: numbers are true when they are not 0.
    pub fn as_bool(self) -> Option<bool> {
        match self {
            Value::Bool(b) => Some(b),
            other => other.as_int().map(|n| n != 0),
        }
    }
}

impl PartialEq for Value {
    /// Equal as values: `Int(1)`, `Word(1)` and `Bool(true)` are equal; reals are equal by bits, so that a
    /// NaN that stays the same NaN is no change.
    #[inline]
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            // The common case first: the trace compares every pushed value with the last one.
            (Value::Bool(a), Value::Bool(b)) => a == b,
            (Value::Real(a), Value::Real(b)) => a.to_bits() == b.to_bits(),
            (Value::Real(a), b) | (b, Value::Real(a)) => b.as_int().is_some_and(|n| *a == n as f64),
            (Value::HighZ, Value::HighZ) | (Value::Unknown, Value::Unknown) => true,
            (a, b) => a.as_int().is_some() && a.as_int() == b.as_int(),
        }
    }
}

impl Eq for Value {}

impl From<Level> for Value {
    fn from(level: Level) -> Self {
        match level {
            Level::Low => Value::Bool(false),
            Level::High => Value::Bool(true),
            Level::HighZ => Value::HighZ,
        }
    }
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Value::Bool(true) => f.write_str("TRUE"),
            Value::Bool(false) => f.write_str("FALSE"),
            Value::Int(n) => write!(f, "{n}"),
            Value::Word(n) => write!(f, "16#{n:X}"),
            Value::Real(r) => write!(f, "{r}"),
            Value::HighZ => f.write_str("high impedance"),
            Value::Unknown => f.write_str("unknown"),
        }
    }
}
