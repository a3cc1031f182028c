//! Timers. Elapsed time counts in the unit of PT from the call that started the timer, so a timer is never early; PT
//! counts as it is at each call.

use super::{Native, Pin, Pins, hidden, input, native, output};
use crate::types::Elementary::{Bool, Ltime, Time};

/// Pins of a timer, by place.
macro_rules! pins {
    ($time:ident) => {
        &[
            input("IN", Bool),
            input("PT", $time),
            output("Q", Bool),
            output("ET", $time),
            hidden("START"),
            hidden("PHASE"),
        ]
    };
}

const SHORT: &[Pin] = pins!(Time);
const LONG: &[Pin] = pins!(Ltime);

/// TON, TOF and TP with TIME, and with LTIME under the names of the controllers' tool and of the standard.
pub(super) const BLOCKS: &[Native] = &[
    native!("TON", SHORT, ton),
    native!("TOF", SHORT, tof),
    native!("TP", SHORT, tp),
    native!("LTON", LONG, ton),
    native!("LTOF", LONG, tof),
    native!("LTP", LONG, tp),
    native!("TON_TIME", SHORT, ton),
    native!("TOF_TIME", SHORT, tof),
    native!("TP_TIME", SHORT, tp),
    native!("TON_LTIME", LONG, ton),
    native!("TOF_LTIME", LONG, tof),
    native!("TP_LTIME", LONG, tp),
];

const IN: usize = 0;
const PT: usize = 1;
const Q: usize = 2;
const ET: usize = 3;
const START: usize = 4;
const PHASE: usize = 5;

/// Phases of the timers.
const IDLE: i64 = 0;
const TIMING: i64 = 1;
const EXPIRED: i64 = 2;

#[inline(always)]
fn start(pins: &mut Pins<'_>) {
    pins.set(START, pins.now().as_nanos());
    pins.set(PHASE, TIMING);
}

/// Advances a timing timer; whether it has expired.
#[inline(always)]
fn expires(pins: &mut Pins<'_>) -> bool {
    let elapsed = pins.now().as_nanos().saturating_sub(pins.get(START)).max(0) as u64;
    let elapsed = if pins.ty(PT) == Time { elapsed / 1_000_000 } else { elapsed };
    // An LTIME is unsigned.
    let preset = pins.get(PT) as u64;
    pins.set(ET, elapsed.min(preset) as i64);
    if elapsed >= preset {
        pins.set(PHASE, EXPIRED);
    }
    elapsed >= preset
}

/// On-delay: Q becomes TRUE when IN has been TRUE for PT.
#[inline(always)]
fn ton(pins: &mut Pins<'_>) {
    if !pins.on(IN) {
        pins.set(PHASE, IDLE);
        pins.set(Q, 0);
        pins.set(ET, 0);
        return;
    }
    if pins.get(PHASE) == IDLE {
        start(pins);
    }
    if pins.get(PHASE) == TIMING {
        let expired = expires(pins);
        pins.set(Q, i64::from(expired));
    }
}

/// Off-delay: Q stays TRUE until IN has been FALSE for PT.
#[inline(always)]
fn tof(pins: &mut Pins<'_>) {
    if pins.on(IN) {
        pins.set(PHASE, IDLE);
        pins.set(Q, 1);
        pins.set(ET, 0);
        return;
    }
    if pins.get(PHASE) == IDLE && pins.on(Q) {
        start(pins);
    }
    if pins.get(PHASE) == TIMING {
        let expired = expires(pins);
        pins.set(Q, i64::from(!expired));
    }
}

/// Pulse: a rising edge of IN makes Q TRUE for PT, whatever IN does meanwhile. ET is held until IN is FALSE.
#[inline(always)]
fn tp(pins: &mut Pins<'_>) {
    if pins.get(PHASE) == IDLE && pins.on(IN) {
        start(pins);
    }
    if pins.get(PHASE) == TIMING {
        let expired = expires(pins);
        pins.set(Q, i64::from(!expired));
    }
    if pins.get(PHASE) == EXPIRED && !pins.on(IN) {
        pins.set(PHASE, IDLE);
        pins.set(ET, 0);
    }
}
