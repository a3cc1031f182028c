//! Conversions between the elementary types, and between them and texts.
//!
//! Every pair of types has a meaning, so a conversion never fails:
//! - Whole numbers, bit strings and characters: the high bits are cut off, and what is left is read in the new type.
//! - To BOOL: TRUE for everything but 0. A NaN is not 0.
//! - REAL and LREAL to whole numbers: to the nearest, ties to even; at the limits of 64 bits it stays, then the high
//!   bits are cut off; a NaN gives 0.
//! - Whole numbers to REAL and LREAL, and LREAL to REAL: the nearest, ties to even (IEEE 754).
//! - Times and dates and numbers: the number counts the unit of the type (milliseconds, seconds, nanoseconds).
//! - Times and dates to each other: scaled, cut down to the unit of the new type. Of a point in time, DATE takes the
//!   day, TOD the time of the day.

mod functions;
mod names;
mod read;
mod write;

pub(super) use functions::{FUNCTIONS, bits, decimal};
pub(crate) use names::{Conversion, ConversionSide, How, parse_conversion};
pub(crate) use read::from_text;
pub(crate) use write::to_text;

use super::calendar::DAY;
use crate::types::Elementary::{self, *};

/// The cell of `to` for a cell of `from`.
pub(crate) fn convert(from: Elementary, to: Elementary, cell: i64) -> i64 {
    let cell = from.wrap(cell);
    if from == to {
        return cell;
    }
    if to == Bool {
        return i64::from(if from.is_real() { real(from, cell) != 0.0 } else { cell != 0 });
    }
    if from.is_real() {
        return if to.is_real() { real_cell(to, real(from, cell)) } else { rounded(to, real(from, cell)) };
    }
    match to {
        // One rounding each: by way of LREAL there would be two.
        Real if from.wide_unsigned() => i64::from((cell as u64 as f32).to_bits()),
        Real => i64::from((cell as f32).to_bits()),
        Lreal if from.wide_unsigned() => (cell as u64 as f64).to_bits() as i64,
        Lreal => (cell as f64).to_bits() as i64,
        _ => match (from.nanos(), to.nanos()) {
            (Some(from_unit), Some(to_unit)) => {
                // Never more than 2^64: the units of a millisecond and a second have 32 bits.
                let nanos = (cell as u64).wrapping_mul(from_unit);
                let nanos = match to {
                    Date | Ldate => nanos - nanos % DAY,
                    Tod | Ltod => nanos % DAY,
                    _ => nanos,
                };
                to.wrap((nanos / to_unit) as i64)
            }
            _ => to.wrap(cell),
        },
    }
}

/// The number in a cell of REAL or LREAL.
pub(in crate::library) fn real(ty: Elementary, cell: i64) -> f64 {
    if ty == Real { f64::from(f32::from_bits(cell as u32)) } else { f64::from_bits(cell as u64) }
}

/// A number as a cell of REAL or LREAL; there is one NaN.
pub(in crate::library) fn real_cell(ty: Elementary, number: f64) -> i64 {
    match (ty, number.is_nan()) {
        (Real, true) => 0x7FC0_0000,
        (Real, false) => i64::from((number as f32).to_bits()),
        (_, true) => 0x7FF8_0000_0000_0000,
        (_, false) => number.to_bits() as i64,
    }
}

/// The nearest whole number as a cell, ties to even.
pub(in crate::library) fn rounded(ty: Elementary, number: f64) -> i64 {
    ty.wrap(whole(ty, number.round_ties_even()))
}

/// A whole number in 64 bits: unsigned where the type is and the number not negative. `as` stays at the limits and
/// makes 0 of a NaN.
fn whole(ty: Elementary, number: f64) -> i64 {
    if ty.wide_unsigned() && number > 0.0 { number as u64 as i64 } else { number as i64 }
}

#[cfg(test)]
mod tests;
#[cfg(test)]
mod text_tests;
