//! The standard blocks of IEC 61131-3: timers, counters, edges and bistables (controller:LIB-01, library Standard).

use super::{Native, Pin, PinKind, Pins};
use crate::types::Elementary::{self, Bool, Lint, Time, Word};

const fn input(name: &'static str, ty: Elementary) -> Pin {
    Pin { name, kind: PinKind::Input, ty }
}

const fn output(name: &'static str, ty: Elementary) -> Pin {
    Pin { name, kind: PinKind::Output, ty }
}

const fn hidden(name: &'static str) -> Pin {
    Pin { name, kind: PinKind::Hidden, ty: Lint }
}

/// Pins of a timer, by place.
const TIMER: &[Pin] = &[
    input("IN", Bool),
    input("PT", Time),
    output("Q", Bool),
    output("ET", Time),
    hidden("START"),
    hidden("PHASE"),
];

/// TON, TOF, TP, CTU, CTD, CTUD, R_TRIG, F_TRIG, SR and RS.
///
/// Counters count in WORD as the controllers' Standard library does, where IEC 61131-3 has INT. Elapsed time is
/// whole milliseconds since the call that started the timer, so a timer is never early; PT counts as it is
/// at each call.
pub const STANDARD: &[Native] = &[
    Native { name: "TON", pins: TIMER, run: ton },
    Native { name: "TOF", pins: TIMER, run: tof },
    Native { name: "TP", pins: TIMER, run: tp },
    Native {
        name: "CTU",
        pins: &[
            input("CU", Bool),
            input("RESET", Bool),
            input("PV", Word),
            output("Q", Bool),
            output("CV", Word),
            hidden("LAST"),
        ],
        run: ctu,
    },
    Native {
        name: "CTD",
        pins: &[
            input("CD", Bool),
            input("LOAD", Bool),
            input("PV", Word),
            output("Q", Bool),
            output("CV", Word),
            hidden("LAST"),
        ],
        run: ctd,
    },
    Native {
        name: "CTUD",
        pins: &[
            input("CU", Bool),
            input("CD", Bool),
            input("RESET", Bool),
            input("LOAD", Bool),
            input("PV", Word),
            output("QU", Bool),
            output("QD", Bool),
            output("CV", Word),
            hidden("LASTU"),
            hidden("LASTD"),
        ],
        run: ctud,
    },
    Native { name: "R_TRIG", pins: &[input("CLK", Bool), output("Q", Bool), hidden("LAST")], run: r_trig },
    Native { name: "F_TRIG", pins: &[input("CLK", Bool), output("Q", Bool), hidden("LAST")], run: f_trig },
    Native { name: "SR", pins: &[input("SET1", Bool), input("RESET", Bool), output("Q1", Bool)], run: sr },
    Native { name: "RS", pins: &[input("SET", Bool), input("RESET1", Bool), output("Q1", Bool)], run: rs },
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

fn start(pins: &mut Pins<'_>) {
    pins.set(START, pins.now().as_nanos());
    pins.set(PHASE, TIMING);
}

/// Advances a timing timer; whether it has expired.
fn expires(pins: &mut Pins<'_>) -> bool {
    let elapsed = pins.now().as_nanos().saturating_sub(pins.get(START)) / 1_000_000;
    let preset = pins.get(PT);
    pins.set(ET, elapsed.clamp(0, preset));
    if elapsed >= preset {
        pins.set(PHASE, EXPIRED);
    }
    elapsed >= preset
}

/// On-delay: Q becomes TRUE when IN has been TRUE for PT.
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

/// Whether the input pin rose since the last call, remembered in the pin `last`.
fn rose(pins: &mut Pins<'_>, input: usize, last: usize) -> bool {
    let rose = pins.on(input) && !pins.on(last);
    pins.set(last, i64::from(pins.on(input)));
    rose
}

const COUNT_MAX: i64 = 65_535;

/// Up counter; RESET goes before counting.
fn ctu(pins: &mut Pins<'_>) {
    let up = rose(pins, 0, 5);
    let count = pins.get(4);
    let count = if pins.on(1) { 0 } else { (count + i64::from(up)).min(COUNT_MAX) };
    pins.set(4, count);
    pins.set(3, i64::from(count >= pins.get(2)));
}

/// Down counter; LOAD goes before counting.
fn ctd(pins: &mut Pins<'_>) {
    let down = rose(pins, 0, 5);
    let count = pins.get(4);
    let count = if pins.on(1) { pins.get(2) } else { (count - i64::from(down)).max(0) };
    pins.set(4, count);
    pins.set(3, i64::from(count <= 0));
}

/// Up and down counter; RESET goes before LOAD, LOAD before counting. Two edges in one call cancel out.
fn ctud(pins: &mut Pins<'_>) {
    let up = rose(pins, 0, 8);
    let down = rose(pins, 1, 9);
    let mut count = pins.get(7);
    if pins.on(2) {
        count = 0;
    } else if pins.on(3) {
        count = pins.get(4);
    } else if up != down {
        count = if up { (count + 1).min(COUNT_MAX) } else { (count - 1).max(0) };
    }
    pins.set(7, count);
    pins.set(5, i64::from(count >= pins.get(4)));
    pins.set(6, i64::from(count <= 0));
}

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
