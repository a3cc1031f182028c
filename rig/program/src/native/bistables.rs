//! Edges and bistables.

use super::{Native, Pin, Pins, hidden, input, native, output, rose};
use crate::types::Elementary::Bool;

/// R_TRIG, F_TRIG, SR and RS.
pub(super) const BLOCKS: &[Native] = &[
    native!("R_TRIG", &[input("CLK", Bool), output("Q", Bool), hidden("LAST")], r_trig),
    native!("F_TRIG", &[input("CLK", Bool), output("Q", Bool), hidden("LAST")], f_trig),
    native!("SR", &[input("SET1", Bool), input("RESET", Bool), output("Q1", Bool)], sr),
    native!("RS", &[input("SET", Bool), input("RESET1", Bool), output("Q1", Bool)], rs),
];

/// Rising edge. An input that is TRUE in the very first call counts as one.
#[inline(always)]
fn r_trig(pins: &mut Pins<'_>) {
    let rose = rose(pins, 0, 2);
    pins.set(1, i64::from(rose));
}

/// Falling edge. An input that is FALSE in the very first call is none.
#[inline(always)]
fn f_trig(pins: &mut Pins<'_>) {
    let fell = !pins.on(0) && pins.on(2);
    pins.set(2, i64::from(pins.on(0)));
    pins.set(1, i64::from(fell));
}

/// Bistable with dominant set.
#[inline(always)]
fn sr(pins: &mut Pins<'_>) {
    let q = pins.on(0) || (pins.on(2) && !pins.on(1));
    pins.set(2, i64::from(q));
}

/// Bistable with dominant reset.
#[inline(always)]
fn rs(pins: &mut Pins<'_>) {
    let q = !pins.on(1) && (pins.on(2) || pins.on(0));
    pins.set(2, i64::from(q));
}
