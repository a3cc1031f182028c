//! Checks of values, and the order of their bytes.

use super::Accepts::{AnyBit, AnyInt, AnyReal};
use super::convert::{bits, decimal, real};
use super::{Accepts, Function, Gives, argument, scalar};
use crate::types::Elementary::{self, Bool};

const NUMBER: &[(&str, Accepts)] = &[("IN", AnyInt)];

/// IS_VALID, IS_VALID_BCD, and the four functions of byte order.
pub(super) const FUNCTIONS: &[Function] = &[
    scalar("IS_VALID", &[("IN", AnyReal)], Gives::Exact(Bool), |ty, cells| {
        i64::from(real(ty, argument(cells, 0)).is_finite())
    }),
    scalar("IS_VALID_BCD", &[("IN", AnyBit)], Gives::Exact(Bool), |ty, cells| {
        i64::from(decimal(bits(ty, argument(cells, 0))).is_some())
    }),
    scalar("TO_BIG_ENDIAN", NUMBER, Gives::Same, swapped),
    scalar("FROM_BIG_ENDIAN", NUMBER, Gives::Same, swapped),
    // The controllers' own order.
    scalar("TO_LITTLE_ENDIAN", NUMBER, Gives::Same, |ty, cells| ty.wrap(argument(cells, 0))),
    scalar("FROM_LITTLE_ENDIAN", NUMBER, Gives::Same, |ty, cells| ty.wrap(argument(cells, 0))),
];

/// The bytes of a value in the other order.
fn swapped(ty: Elementary, cells: &[i64]) -> i64 {
    let bytes = argument(cells, 0).swap_bytes() as u64;
    ty.wrap((bytes >> (64 - 8 * ty.bytes() as u32)) as i64)
}
