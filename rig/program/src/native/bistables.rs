//! Edges and bistables.

use super::Pins;
use super::{Native, hidden, input, output, rose};
use crate::types::Elementary::Bool;

/// R_TRIG, F_TRIG, SR and RS.
pub(super) const BLOCKS: &[Native] = &[
    Native { name: "R_TRIG", pins: &[input("CLK", Bool), output("Q", Bool), hidden("LAST")], run: r_trig },
    Native { name: "F_TRIG", pins: &[input("CLK", Bool), output("Q", Bool), hidden("LAST")], run: f_trig },
    Native { name: "SR", pins: &[input("SET1", Bool), input("RESET", Bool), output("Q1", Bool)], run: sr },
    Native { name: "RS", pins: &[input("SET", Bool), input("RESET1", Bool), output("Q1", Bool)], run: rs },
];

/// Rising edge. An input that is TRUE in the very first call counts as one.
fn r_trig(pins: &mut Pins<'_>) {
    let rose = rose(pins, 0, 2);
    pins.set(1, i64::from(rose));
}

/// Falling edge. An input that is FALSE in the very first call is none.
fn f_trig(pins: &mut Pins<'_>) {
    let fell = !pins.on(0) && pins.on(2);
    pins.set(2, i64::from(pins.on(0)));
    pins.set(1, i64::from(fell));
}

/// Bistable with dominant set.
fn sr(pins: &mut Pins<'_>) {
    let q = pins.on(0) || (pins.on(2) && !pins.on(1));
    pins.set(2, i64::from(q));
}

/// Bistable with dominant reset.
fn rs(pins: &mut Pins<'_>) {
    let q = !pins.on(1) && (pins.on(2) || pins.on(0));
    pins.set(2, i64::from(q));
}
