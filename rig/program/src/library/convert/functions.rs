//! Conversions that are not plain, as functions: to whole numbers towards 0, and binary coded decimals.

use super::{real, whole};
use crate::library::Accepts::{AnyInt, AnyReal};
use crate::library::{Accepts, Function, Gives, argument, scalar};
use crate::types::Elementary::{self, *};

const REAL: &[(&str, Accepts)] = &[("IN", AnyReal)];
const WHOLE: &[(&str, Accepts)] = &[("IN", AnyInt)];

/// A function to a type.
macro_rules! to {
    ($name:literal, $accepts:ident, $to:ident, $body:ident) => {
        scalar($name, $accepts, Gives::Exact($to), |from, cells| $body(from, $to, argument(cells, 0)))
    };
}

/// TRUNC_..., BCD_TO_... and TO_BCD_...
pub(in crate::library) const FUNCTIONS: &[Function] = &[
    to!("TRUNC_SINT", REAL, Sint, truncate),
    to!("TRUNC_USINT", REAL, Usint, truncate),
    to!("TRUNC_INT", REAL, Int, truncate),
    to!("TRUNC_UINT", REAL, Uint, truncate),
    to!("TRUNC_DINT", REAL, Dint, truncate),
    to!("TRUNC_UDINT", REAL, Udint, truncate),
    to!("TRUNC_LINT", REAL, Lint, truncate),
    to!("TRUNC_ULINT", REAL, Ulint, truncate),
    to!("TRUNC_BYTE", REAL, Byte, truncate),
    to!("TRUNC_WORD", REAL, Word, truncate),
    to!("TRUNC_DWORD", REAL, Dword, truncate),
    to!("TRUNC_LWORD", REAL, Lword, truncate),
    to!("BCD_TO_SINT", WHOLE, Sint, from_bcd),
    to!("BCD_TO_USINT", WHOLE, Usint, from_bcd),
    to!("BCD_TO_INT", WHOLE, Int, from_bcd),
    to!("BCD_TO_UINT", WHOLE, Uint, from_bcd),
    to!("BCD_TO_DINT", WHOLE, Dint, from_bcd),
    to!("BCD_TO_UDINT", WHOLE, Udint, from_bcd),
    to!("BCD_TO_LINT", WHOLE, Lint, from_bcd),
    to!("BCD_TO_ULINT", WHOLE, Ulint, from_bcd),
    to!("BCD_TO_BYTE", WHOLE, Byte, from_bcd),
    to!("BCD_TO_WORD", WHOLE, Word, from_bcd),
    to!("BCD_TO_DWORD", WHOLE, Dword, from_bcd),
    to!("BCD_TO_LWORD", WHOLE, Lword, from_bcd),
    to!("TO_BCD_BYTE", WHOLE, Byte, to_bcd),
    to!("TO_BCD_WORD", WHOLE, Word, to_bcd),
    to!("TO_BCD_DWORD", WHOLE, Dword, to_bcd),
    to!("TO_BCD_LWORD", WHOLE, Lword, to_bcd),
];

/// Towards 0; at the limits and for a NaN as [`super::convert`].
fn truncate(from: Elementary, to: Elementary, cell: i64) -> i64 {
    to.wrap(whole(to, real(from, cell).trunc()))
}

/// The number that decimal digits of four bits each spell. Where one is none, the result has all bits set: -1, or the
/// largest number.
fn from_bcd(from: Elementary, to: Elementary, cell: i64) -> i64 {
    to.wrap(decimal(bits(from, cell)).unwrap_or(-1))
}

/// Decimal digits of four bits each. Where the number is negative or has too many digits, all bits are set.
fn to_bcd(from: Elementary, to: Elementary, cell: i64) -> i64 {
    let number = from.number(from.wrap(cell));
    let (mut rest, mut digits) = (number, 0);
    for place in 0..to.bits() / 4 {
        digits |= ((rest % 10) as i64) << (4 * place);
        rest /= 10;
    }
    to.wrap(if rest != 0 || number < 0 { -1 } else { digits })
}

/// The bits of a value, without those that its sign fills.
pub(in crate::library) fn bits(ty: Elementary, cell: i64) -> u64 {
    cell as u64 & (u64::MAX >> (64 - ty.bits()))
}

/// The number of 16 decimal digits of four bits each; `None` where one is no digit.
pub(in crate::library) fn decimal(digits: u64) -> Option<i64> {
    let digit = |place| ((digits >> (4_u32 * place)) & 0xF_u64) as i64;
    (0..16).rev().map(digit).try_fold(0, |number, digit| (digit < 10).then_some(10 * number + digit))
}
