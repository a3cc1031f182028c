//! Why a text is no number, quantity, duration or range.

use std::fmt;

/// Why a text is no number, quantity, duration or range, and where.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct QuantityError {
    /// The byte of the text at which it went wrong, at most its length.
    pub at: usize,
    /// What is wrong there.
    pub fault: QuantityFault,
}

/// What can be wrong with a number, quantity, duration or range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum QuantityFault {
    /// The text ends where a number is expected.
    Empty,
    /// A number is expected.
    Number,
    /// The number has over 30 digits, or is beyond what a float holds.
    TooLarge,
    /// The number of a duration has no unit after it.
    MissingUnit,
    /// The word is no unit of time.
    NoTime,
    /// The quantity ends before this.
    Trailing,
    /// The duration is no whole number of nanoseconds.
    TooFine,
    /// The duration does not fit into ±292 years.
    TooLong,
    /// The duration, or the tolerance of a range, is below 0.
    Negative,
    /// The range has neither a beginning nor an end.
    NoEnds,
    /// The end of the range is below its beginning.
    Reversed,
    /// The quantity cannot be compared with the other one of its range.
    Units,
}

impl QuantityFault {
    /// The same fault with its place.
    pub(crate) const fn at(self, at: usize) -> QuantityError {
        QuantityError { at, fault: self }
    }
}

impl fmt::Display for QuantityFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Empty => "a number with its unit is missing",
            Self::Number => "a number is expected here",
            Self::TooLarge => "the number is too large",
            Self::MissingUnit => "a unit is missing: ns, us, ms, s, min, h or d",
            Self::NoTime => "no unit of time: use ns, us, ms, s, min, h or d",
            Self::Trailing => "the quantity should end here",
            Self::TooFine => "finer than one nanosecond",
            Self::TooLong => "longer than 292 years",
            Self::Negative => "a duration or tolerance cannot be below 0",
            Self::NoEnds => "a range needs a beginning or an end",
            Self::Reversed => "the end of the range lies before its beginning",
            Self::Units => "the units of the range do not go together",
        })
    }
}

impl fmt::Display for QuantityError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.fault.fmt(f)
    }
}

impl std::error::Error for QuantityError {}
