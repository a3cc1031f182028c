//! The standard blocks against timing diagrams worked out by hand from IEC 61131-3 (controller:LIB-01).

use crate::support::Rig;
use signal::{Span, Time, Value};

/// Calls a timer every millisecond; for each the input, and after it Q and ET in milliseconds are compared.
fn timer(kind: &str, preset: i64, steps: &[(i64, bool, bool, i64)]) {
    let mut rig = Rig::new(&format!(
        "PROGRAM MAIN VAR t1 : {kind}; x : BOOL; END_VAR t1(IN := x, PT := T#{preset}ms); END_PROGRAM"
    ));
    for (at, input, q, et) in steps {
        rig.now = Time::ZERO + Span::from_millis(*at);
        rig.write("x", Value::Bool(*input));
        rig.cycle();
        assert_eq!(
            (rig.on("t1.Q"), rig.int("t1.ET") / 1_000_000),
            (*q, i128::from(*et)),
            "{kind} at {at} ms"
        );
    }
}

#[test]
fn on_delay() {
    timer(
        "TON",
        50,
        &[
            (0, false, false, 0),
            (10, true, false, 0),
            (30, true, false, 20),
            (59, true, false, 49),
            (60, true, true, 50),
            (200, true, true, 50),
            (210, false, false, 0),
            (220, true, false, 0),
            (240, false, false, 0),
            (250, true, false, 0),
            (299, true, false, 49),
            (301, true, true, 50),
        ],
    );
    timer("TON", 0, &[(5, true, true, 0), (6, false, false, 0)]);
}

#[test]
fn off_delay() {
    timer(
        "TOF",
        50,
        &[
            (0, false, false, 0),
            (10, true, true, 0),
            (20, false, true, 0),
            (40, false, true, 20),
            (50, true, true, 0),
            (60, false, true, 0),
            (109, false, true, 49),
            (110, false, false, 50),
            (150, false, false, 50),
            (160, true, true, 0),
        ],
    );
}

#[test]
fn pulse() {
    timer(
        "TP",
        50,
        &[
            (0, false, false, 0),
            (10, true, true, 0),
            (20, false, true, 10),
            // Not started again while it runs.
            (30, true, true, 20),
            (59, true, true, 49),
            (60, true, false, 50),
            (100, true, false, 50),
            (110, false, false, 0),
            (120, true, true, 0),
            (140, false, true, 20),
            (170, false, false, 0),
        ],
    );
}

#[test]
fn a_timer_is_never_early() {
    // Started half a millisecond into a tick: elapsed time counts from there, not from the tick.
    let mut rig = Rig::new("PROGRAM MAIN VAR t1 : TON; END_VAR t1(IN := TRUE, PT := T#1ms); END_PROGRAM");
    rig.now = Time::from_nanos(500_000);
    rig.cycle();
    rig.now = Time::from_nanos(1_499_999);
    rig.cycle();
    assert!(!rig.on("t1.Q"));
    rig.now = Time::from_nanos(1_500_000);
    rig.cycle();
    assert!(rig.on("t1.Q"));
}

#[test]
fn counters() {
    let mut rig = Rig::new(
        "PROGRAM MAIN VAR up : CTU; down : CTD; both : CTUD; a, b, r, l : BOOL; END_VAR
         up(CU := a, RESET := r, PV := 2); down(CD := a, LOAD := l, PV := 2);
         both(CU := a, CD := b, RESET := r, LOAD := l, PV := 2); END_PROGRAM",
    );
    // a, b, r, l -> counts and Qs of all three.
    for (inputs, counts, qs) in [
        ([0, 0, 0, 0], [0, 0, 0], [0, 1, 0, 1]),
        ([0, 0, 0, 1], [0, 2, 2], [0, 0, 1, 0]),
        ([1, 0, 0, 0], [1, 1, 3], [0, 0, 1, 0]),
        ([1, 0, 0, 0], [1, 1, 3], [0, 0, 1, 0]),
        ([0, 1, 0, 0], [1, 1, 2], [0, 0, 1, 0]),
        ([1, 0, 0, 0], [2, 0, 3], [1, 1, 1, 0]),
        ([0, 0, 0, 0], [2, 0, 3], [1, 1, 1, 0]),
        ([1, 1, 0, 0], [3, 0, 3], [1, 1, 1, 0]),
        // Reset and load go before counting, reset before load.
        ([0, 0, 0, 0], [3, 0, 3], [1, 1, 1, 0]),
        ([1, 0, 1, 1], [0, 2, 0], [0, 0, 0, 1]),
    ] {
        for (name, value) in ["a", "b", "r", "l"].into_iter().zip(inputs) {
            rig.write(name, Value::Bool(value == 1));
        }
        rig.cycle();
        assert_eq!([rig.int("up.CV"), rig.int("down.CV"), rig.int("both.CV")], counts, "{inputs:?}");
        let found = [rig.int("up.Q"), rig.int("down.Q"), rig.int("both.QU"), rig.int("both.QD")];
        assert_eq!(found, qs, "{inputs:?}");
    }
}

#[test]
fn counters_stop_at_their_limits() {
    let mut rig = Rig::new(
        "PROGRAM MAIN VAR up : CTU; a : BOOL; END_VAR a := NOT a; up(CU := a, PV := 2); END_PROGRAM",
    );
    for _ in 0..2 * 65_540 {
        rig.cycle();
    }
    assert_eq!(rig.int("up.CV"), 65_535);
}

#[test]
fn edges_and_bistables() {
    let mut rig = Rig::new(
        "PROGRAM MAIN VAR r : R_TRIG; f : F_TRIG; s1 : SR; s2 : RS; x, y : BOOL; END_VAR
         r(CLK := x); f(CLK := x); s1(SET1 := x, RESET := y); s2(SET := x, RESET1 := y); END_PROGRAM",
    );
    for (x, y, expected) in [
        // A signal that is FALSE from the start has not fallen.
        (0, 0, [0, 0, 0, 0]),
        (1, 0, [1, 0, 1, 1]),
        (1, 0, [0, 0, 1, 1]),
        (0, 0, [0, 1, 1, 1]),
        (0, 0, [0, 0, 1, 1]),
        (0, 1, [0, 0, 0, 0]),
        (1, 1, [1, 0, 1, 0]),
    ] {
        rig.write("x", Value::Bool(x == 1));
        rig.write("y", Value::Bool(y == 1));
        rig.cycle();
        assert_eq!(
            [rig.int("r.Q"), rig.int("f.Q"), rig.int("s1.Q1"), rig.int("s2.Q1")],
            expected,
            "x {x} y {y}"
        );
    }
}
