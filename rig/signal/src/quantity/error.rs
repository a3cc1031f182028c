//! Why a text is no quantity or range.

use std::fmt;

use super::Dimension;

/// Why a text is no quantity or range, with the byte at which it went wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParseQuantityError {
    /// A quantity was expected at this byte, where the text ends.
    Empty(usize),
    /// A number was expected at this byte.
    Number(usize),
    /// The number at this byte continues a duration and has no unit behind it.
    MissingUnit(usize),
    /// The word at this byte is no unit.
    UnknownUnit(usize),
    /// The word at this byte is a unit but for its capitals.
    Spelling {
        /// Byte of the text.
        at: usize,
        /// How the unit is written.
        unit: &'static str,
    },
    /// The quantity ends before this byte.
    Trailing(usize),
    /// The number at this byte is finer than a billionth of the base unit.
    TooFine(usize),
    /// The number at this byte is too large.
    TooLarge(usize),
    /// The text is a single quantity where a range is expected.
    NotARange,
    /// The range has neither a beginning nor an end.
    OpenAtBothEnds,
    /// The end of the range, at this byte, is below its beginning.
    Reversed(usize),
    /// The tolerance at this byte is negative.
    NegativeTolerance(usize),
    /// The quantity at this byte is of another kind than it has to be.
    Dimension {
        /// Byte of the text.
        at: usize,
        /// What it has to be.
        expected: Dimension,
        /// What it is.
        found: Dimension,
    },
}

impl ParseQuantityError {
    /// The byte of the text at which reading stopped.
    pub fn offset(&self) -> usize {
        match *self {
            Self::NotARange | Self::OpenAtBothEnds => 0,
            Self::Empty(at)
            | Self::Number(at)
            | Self::MissingUnit(at)
            | Self::UnknownUnit(at)
            | Self::Spelling { at, .. }
            | Self::Trailing(at)
            | Self::TooFine(at)
            | Self::TooLarge(at)
            | Self::Reversed(at)
            | Self::NegativeTolerance(at)
            | Self::Dimension { at, .. } => at,
        }
    }

    /// The same fault in a text that has `by` more bytes in front.
    pub(super) fn moved(mut self, by: usize) -> Self {
        match &mut self {
            Self::NotARange | Self::OpenAtBothEnds => {}
            Self::Empty(at)
            | Self::Number(at)
            | Self::MissingUnit(at)
            | Self::UnknownUnit(at)
            | Self::Spelling { at, .. }
            | Self::Trailing(at)
            | Self::TooFine(at)
            | Self::TooLarge(at)
            | Self::Reversed(at)
            | Self::NegativeTolerance(at)
            | Self::Dimension { at, .. } => *at += by,
        }
        self
    }
}

impl fmt::Display for ParseQuantityError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty(_) => f.write_str("a quantity is missing, as in 24 V"),
            Self::Number(_) => f.write_str("a number is expected here"),
            Self::MissingUnit(_) => f.write_str("a unit is missing: ns, us, ms, s, min, h or d"),
            Self::UnknownUnit(_) => f.write_str(
                "no such unit: use s, Hz, V, A, Ohm, W, degC, %, rpm, m or Pa, with n, u, m, k or M in front where usual",
            ),
            Self::Spelling { unit, .. } => write!(f, "no such unit: write {unit}"),
            Self::Trailing(_) => f.write_str("the quantity should end here"),
            Self::TooFine(_) => f.write_str("finer than a billionth of the base unit"),
            Self::TooLarge(_) => f.write_str("the number is too large"),
            Self::NotARange => f.write_str("a range is expected: 4 mA .. 20 mA, .. 20 mA, 4 mA .. or 12 mA ± 1 mA"),
            Self::OpenAtBothEnds => f.write_str("the range needs a beginning or an end"),
            Self::Reversed(_) => f.write_str("the end of the range is below its beginning"),
            Self::NegativeTolerance(_) => f.write_str("a tolerance is not negative"),
            Self::Dimension { expected, found, .. } => {
                write!(f, "{} is expected here, not {}", expected.name(), found.name())
            }
        }
    }
}

impl std::error::Error for ParseQuantityError {}
