//! The block that sets a clock.

use super::{BlockBody, Native, Pins, hidden, input, output, rose};
use crate::types::Elementary::{Bool, Dt};

/// RTC.
pub(super) const BLOCKS: &[Native] = &[Native {
    name: "RTC",
    pins: &[
        input("IN", Bool),
        input("PDT", Dt),
        output("Q", Bool),
        output("CDT", Dt),
        hidden("LAST"),
        hidden("START"),
        hidden("SET"),
    ],
    body: BlockBody::Own(rtc),
}];

const IN: usize = 0;
const PDT: usize = 1;
const Q: usize = 2;
const CDT: usize = 3;
const LAST: usize = 4;
const START: usize = 5;
const SET: usize = 6;

/// Real-time clock: a rising edge of IN sets it to PDT, and it goes on in modelled time as long as IN is TRUE. While
/// IN is FALSE, Q is FALSE and CDT is 1970-01-01-00:00:00.
fn rtc(pins: &mut Pins<'_>) {
    if rose(pins, IN, LAST) {
        pins.set(START, pins.now().as_nanos());
        pins.set(SET, pins.get(PDT));
    }
    let on = pins.on(IN);
    let seconds = pins.now().as_nanos().saturating_sub(pins.get(START)) / 1_000_000_000;
    pins.set(Q, i64::from(on));
    pins.set(CDT, if on { pins.get(SET).wrapping_add(seconds) } else { 0 });
}
