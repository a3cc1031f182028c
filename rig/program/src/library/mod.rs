//! The functions of the library that are not operators: a table with typed parameters and a Rust body each, and the
//! conversions between the elementary types.

mod calendar;
mod checks;
mod clock;
mod convert;
mod dates;
mod numeric;
mod services;
mod strings;
mod text;

pub(crate) use calendar::days_of;
pub(crate) use convert::{Conversion, ConversionSide, How, convert, from_text, parse_conversion, to_text};
pub use services::Service;

use crate::types::Elementary;

/// What a parameter takes. Parameters that take `Any..` of one call share one type, the generic type of the call,
/// into which all of them are converted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Accepts {
    Exact(Elementary),
    /// REAL or LREAL; whole numbers become REAL, or LREAL where REAL does not hold them.
    AnyReal,
    /// Whole numbers and bit strings.
    AnyInt,
    /// Whole numbers, bit strings, REAL and LREAL, each as it is.
    AnyNum,
    /// BOOL and bit strings.
    AnyBit,
    /// STRING or WSTRING; all texts of a call are of one width.
    AnyText,
}

/// What a function gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Gives {
    /// The generic type of the call.
    Same,
    Exact(Elementary),
    /// A text of the width of the arguments, STRING for a function without text parameters, of up to
    /// [`TEXT_LIMIT`] characters.
    Text,
}

/// The longest text that a function of the library gives, in characters.
pub(crate) const TEXT_LIMIT: u32 = 255;

/// One function.
#[derive(Debug)]
pub(crate) struct Function {
    /// In capitals.
    pub name: &'static str,
    /// Names in capitals and what they take, in order.
    pub parameters: &'static [(&'static str, Accepts)],
    /// The last parameter may be repeated, as in CONCAT(a, b, c).
    pub extensible: bool,
    pub gives: Gives,
    pub body: Body,
}

/// What a function does. Bodies do not allocate, do not panic and end in bounded time. Cells are those of
/// [`Elementary::wrap`]: signed types sign-extended, others zero-extended, BOOL 0 or 1, the bits of REAL and LREAL.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Body {
    /// The generic type of the call (BOOL where it has none) and the cells of the arguments; the cell of the result.
    Scalar(fn(Elementary, &[i64]) -> i64),
    /// The same for a division; `None` where the divisor is 0.
    Quotient(fn(Elementary, &[i64]) -> Option<i64>),
    /// Arguments or the result are texts.
    Text(fn(&mut TextCall<'_>)),
    /// From the modelled time since the start; the cell of the result.
    Clock(fn(signal::Time) -> i64),
    /// The caller of the machine answers; the first argument goes with the question.
    Service(Service),
}

/// A text as it is stored: units of one or two bytes (little-endian), ended by a unit 0 or by the storage.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Text<'a> {
    pub wide: bool,
    pub bytes: &'a [u8],
}

/// Where a text is written: the storage with room for the closing 0. What does not fit is cut off.
#[derive(Debug)]
pub(crate) struct TextOut<'a> {
    pub wide: bool,
    pub bytes: &'a mut [u8],
    /// Units written.
    pub length: usize,
}

/// A call of a function with texts.
#[derive(Debug)]
pub(crate) struct TextCall<'a> {
    /// Text arguments in order.
    pub texts: &'a [Text<'a>],
    /// The other arguments in order, as cells.
    pub cells: &'a [i64],
    /// The result where it is a text.
    pub out: TextOut<'a>,
    /// The result where it is a cell.
    pub result: i64,
}

/// Every function, by subject.
const TABLES: [&[Function]; 7] = [
    numeric::FUNCTIONS,
    strings::FUNCTIONS,
    dates::FUNCTIONS,
    checks::FUNCTIONS,
    clock::FUNCTIONS,
    services::FUNCTIONS,
    convert::FUNCTIONS,
];

/// The function with this name, in capitals.
pub(crate) fn find(key: &str) -> Option<&'static Function> {
    TABLES.into_iter().flatten().find(|function| function.name == key)
}

/// The names of all functions, for suggestions.
pub(crate) fn names() -> impl Iterator<Item = &'static str> {
    TABLES.into_iter().flatten().map(|function| function.name)
}

impl Function {
    /// The place of the parameter with this name, in capitals, for calls such as `LEFT(STR := s, SIZE := 3)`.
    ///
    /// The string functions have two sets of names, the controllers' (STR, SIZE) and the standard's (IN, L); both
    /// are taken. The parameters of an extensible function are numbered without end.
    pub(crate) fn parameter(&self, key: &str) -> Option<usize> {
        self.parameters.iter().position(|(name, _)| *name == key).or_else(|| strings::other_name(self, key))
    }
}

/// A function on cells.
const fn scalar(
    name: &'static str,
    parameters: &'static [(&'static str, Accepts)],
    gives: Gives,
    body: fn(Elementary, &[i64]) -> i64,
) -> Function {
    Function { name, parameters, extensible: false, gives, body: Body::Scalar(body) }
}

/// An argument; 0 where the call has too few, which the compiler does not let happen.
fn argument(cells: &[i64], place: usize) -> i64 {
    cells.get(place).copied().unwrap_or(0)
}

#[cfg(test)]
mod tests;
