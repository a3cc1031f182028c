//! Counters. CTU, CTD and CTUD count in WORD as the controllers' Standard library does, where IEC 61131-3 has INT; the
//! standard's typed counters count in the type that they are named after. CV stops at the limits of its type.

use super::{Native, Pin, Pins, hidden, input, native, output, rose};
use crate::types::Elementary::{Bool, Dint, Int, Lint, Udint, Ulint, Word};

/// Pins of a counter upwards, by place.
macro_rules! up {
    ($ty:ident, $reset:literal) => {
        &[
            input("CU", Bool),
            input($reset, Bool),
            input("PV", $ty),
            output("Q", Bool),
            output("CV", $ty),
            hidden("LAST"),
        ]
    };
}

/// Pins of a counter downwards, by place.
macro_rules! down {
    ($ty:ident, $load:literal) => {
        &[
            input("CD", Bool),
            input($load, Bool),
            input("PV", $ty),
            output("Q", Bool),
            output("CV", $ty),
            hidden("LAST"),
        ]
    };
}

/// Pins of a counter in both directions, by place.
macro_rules! both {
    ($ty:ident, $reset:literal, $load:literal) => {
        &[
            input("CU", Bool),
            input("CD", Bool),
            input($reset, Bool),
            input($load, Bool),
            input("PV", $ty),
            output("QU", Bool),
            output("QD", Bool),
            output("CV", $ty),
            hidden("LASTU"),
            hidden("LASTD"),
        ]
    };
}

/// CTU, CTD and CTUD, and the typed ones of the standard with the standard's names of pins.
pub(super) const BLOCKS: &[Native] = &[
    native!("CTU", up!(Word, "RESET"), ctu),
    native!("CTU_INT", up!(Int, "R"), ctu),
    native!("CTU_DINT", up!(Dint, "R"), ctu),
    native!("CTU_LINT", up!(Lint, "R"), ctu),
    native!("CTU_UDINT", up!(Udint, "R"), ctu),
    native!("CTU_ULINT", up!(Ulint, "R"), ctu),
    native!("CTD", down!(Word, "LOAD"), ctd),
    native!("CTD_INT", down!(Int, "LD"), ctd),
    native!("CTD_DINT", down!(Dint, "LD"), ctd),
    native!("CTD_LINT", down!(Lint, "LD"), ctd),
    native!("CTD_UDINT", down!(Udint, "LD"), ctd),
    native!("CTD_ULINT", down!(Ulint, "LD"), ctd),
    native!("CTUD", both!(Word, "RESET", "LOAD"), ctud),
    native!("CTUD_INT", both!(Int, "R", "LD"), ctud),
    native!("CTUD_DINT", both!(Dint, "R", "LD"), ctud),
    native!("CTUD_LINT", both!(Lint, "R", "LD"), ctud),
    native!("CTUD_UDINT", both!(Udint, "R", "LD"), ctud),
    native!("CTUD_ULINT", both!(Ulint, "R", "LD"), ctud),
];

/// The number in a pin.
#[inline(always)]
fn number(pins: &Pins<'_>, pin: usize) -> i128 {
    pins.ty(pin).number(pins.get(pin))
}

/// The number in a pin, one more or less, within the limits of its type.
#[inline(always)]
fn step(pins: &Pins<'_>, pin: usize, by: i128) -> i64 {
    let (low, high) = pins.ty(pin).range();
    (number(pins, pin) + by).clamp(low, high) as i64
}

/// Up counter; RESET goes before counting.
#[inline(always)]
fn ctu(pins: &mut Pins<'_>) {
    let up = rose(pins, 0, 5);
    let count = if pins.on(1) { 0 } else { step(pins, 4, i128::from(up)) };
    pins.set(4, count);
    pins.set(3, i64::from(number(pins, 4) >= number(pins, 2)));
}

/// Down counter; LOAD goes before counting.
#[inline(always)]
fn ctd(pins: &mut Pins<'_>) {
    let down = rose(pins, 0, 5);
    let count = if pins.on(1) { pins.get(2) } else { step(pins, 4, -i128::from(down)) };
    pins.set(4, count);
    pins.set(3, i64::from(number(pins, 4) <= 0));
}

/// Up and down counter; RESET goes before LOAD, LOAD before counting. Two edges in one call cancel out.
#[inline(always)]
fn ctud(pins: &mut Pins<'_>) {
    let up = rose(pins, 0, 8);
    let down = rose(pins, 1, 9);
    let count = if pins.on(2) {
        0
    } else if pins.on(3) {
        pins.get(4)
    } else {
        step(pins, 7, i128::from(up) - i128::from(down))
    };
    pins.set(7, count);
    pins.set(5, i64::from(number(pins, 7) >= number(pins, 4)));
    pins.set(6, i64::from(number(pins, 7) <= 0));
}
