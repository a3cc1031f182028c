//! Functions of real numbers. All are computed in LREAL by the `libm` crate, which is the same on every machine, and
//! rounded once to REAL where the call is of REAL. Outside of its domain a function gives NaN, at a pole an infinity.

use super::Accepts::{AnyReal, Exact};
use super::convert::{real, real_cell};
use super::{Accepts, Function, Gives, argument, scalar};
use crate::types::Elementary::{self, Lreal};

/// The parameter of a function of one number.
const NUMBER: &[(&str, Accepts)] = &[("IN", AnyReal)];

const fn of_number(name: &'static str, body: fn(Elementary, &[i64]) -> i64) -> Function {
    scalar(name, NUMBER, Gives::Same, body)
}

/// SQRT, LN, LOG, EXP, the functions of angles in radians, and EXPT.
pub(super) const FUNCTIONS: &[Function] = &[
    of_number("SQRT", |ty, cells| apply(ty, cells, f64::sqrt)),
    of_number("LN", |ty, cells| apply(ty, cells, libm::log)),
    of_number("LOG", |ty, cells| apply(ty, cells, libm::log10)),
    of_number("EXP", |ty, cells| apply(ty, cells, libm::exp)),
    of_number("SIN", |ty, cells| apply(ty, cells, libm::sin)),
    of_number("COS", |ty, cells| apply(ty, cells, libm::cos)),
    of_number("TAN", |ty, cells| apply(ty, cells, libm::tan)),
    of_number("ASIN", |ty, cells| apply(ty, cells, libm::asin)),
    of_number("ACOS", |ty, cells| apply(ty, cells, libm::acos)),
    of_number("ATAN", |ty, cells| apply(ty, cells, libm::atan)),
    scalar("ATAN2", &[("Y", AnyReal), ("X", AnyReal)], Gives::Same, |ty, cells| {
        real_cell(ty, libm::atan2(real(ty, argument(cells, 0)), real(ty, argument(cells, 1))))
    }),
    // The exponent is of its own type, so that EXPT(x, 2) of a REAL is a REAL.
    scalar("EXPT", &[("IN1", AnyReal), ("IN2", Exact(Lreal))], Gives::Same, |ty, cells| {
        power(ty, argument(cells, 0), argument(cells, 1))
    }),
];

fn apply(ty: Elementary, cells: &[i64], function: fn(f64) -> f64) -> i64 {
    real_cell(ty, function(real(ty, argument(cells, 0))))
}

/// A number of REAL or LREAL to the power of an exponent, which is a cell of LREAL: EXPT and the operator `**`.
pub(crate) fn power(ty: Elementary, base: i64, exponent: i64) -> i64 {
    real_cell(ty, libm::pow(real(ty, base), real(Lreal, exponent)))
}
