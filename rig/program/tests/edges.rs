//! What happens at the edges of types and blocks where a program goes on without a word: the table "At the edges" of
//! docs/structured-text.md. Each row has its source there.

use crate::support::{Rig, once};
use signal::{Span, Time, Value};

#[test]
fn times_and_dates_go_on_at_the_other_end() {
    let declarations = "VAR t, less, most, tenfold, late : TIME := T#49d17h2m47s295ms; d : DT := DT#2106-02-07-06:28:15;
        before : DT; day : TOD := TOD#23:59:59.999; next : TOD; none : TIME; seconds : DINT; b : BOOL; END_VAR";
    let rig = once(
        declarations,
        "t := t + T#1ms; less := T#2ms - T#3ms; tenfold := T#10d * 5; late := most + most;
         before := DT#1970-01-01-00:00:00 - T#1s; d := d + T#1s; next := day + T#2ms;
         none := D#1970-01-01 - D#1970-01-02; b := most + T#1ms < most; seconds := TIME_TO_DINT(late) / 1000;",
    );
    let millis = |path: &str| rig.int(path) / 1_000_000;
    // 32 bits of milliseconds: 4294967296 of them are 0.
    assert_eq!(millis("t"), 0);
    assert_eq!(millis("less"), 4_294_967_295);
    assert_eq!(millis("tenfold"), 50 * 86_400_000 - 4_294_967_296);
    assert_eq!(millis("late"), 4_294_967_294);
    assert_eq!(millis("none"), 4_294_967_296 - 86_400_000);
    assert!(rig.on("b"), "a sum is cut before it is compared");
    // A clock beyond midnight is not minded.
    assert_eq!(rig.read("before"), value_of("DT#2106-02-07-06:28:15"));
    assert_eq!(rig.read("d"), value_of("DT#1970-01-01-00:00:00"));
    assert_ne!(rig.read("next"), value_of("TOD#00:00:00.001"));
}

fn value_of(literal: &str) -> Value {
    let ty = literal.split('#').next().unwrap();
    once(&format!("VAR x : {ty} := {literal}; END_VAR"), "").read("x")
}

#[test]
fn one_variable_under_two_names() {
    let text = "
        FUNCTION swap : BOOL VAR_IN_OUT a, b : INT; END_VAR VAR c : INT; END_VAR c := a; a := b; b := c; END_FUNCTION
        FUNCTION twice : INT VAR_IN_OUT io : INT; END_VAR VAR_INPUT x : INT; END_VAR io := io + 1; twice := x * 10 + io; END_FUNCTION
        FUNCTION_BLOCK sum VAR_IN_OUT a, b : INT; END_VAR a := a + 1; b := b + 10; a := a + b; END_FUNCTION_BLOCK
        VAR_GLOBAL g : INT := 5; END_VAR
        FUNCTION outside : INT VAR_IN_OUT a : INT; END_VAR a := 7; outside := g; END_FUNCTION
        PROGRAM MAIN VAR one : INT := 3; list : ARRAY[0..1] OF INT := [1, 2]; r, s, i : INT; s1 : sum; END_VAR
        swap(one, one);
        swap(list[0], list[1]);
        r := twice(io := one, x := one);
        s1(a := i, b := i);
        s := outside(g);
        END_PROGRAM";
    let mut rig = Rig::new(text);
    rig.cycle();
    // An input is a copy of the call; an in-out is the variable itself, at every store.
    assert_eq!((rig.int("one"), rig.int("r")), (4, 34));
    assert_eq!((rig.int("list[0]"), rig.int("list[1]")), (2, 1));
    assert_eq!(rig.int("i"), 22);
    assert_eq!(rig.int("s"), 7);
}

#[test]
fn a_preset_that_changes_while_a_timer_runs() {
    let text =
        "PROGRAM MAIN VAR on, off, pulse : BOOL; pt : TIME := T#100ms; ton : TON; tof : TOF; tp : TP; END_VAR
        ton(IN := on, PT := pt); tof(IN := off, PT := pt); tp(IN := pulse, PT := pt); END_PROGRAM";
    // The preset at 60 ms, and when the timers are over: at the call at which ET has reached what PT is by then.
    for (preset, over) in [(50, 60), (100, 100), (150, 150), (0, 60)] {
        let mut rig = Rig::new(text);
        rig.write("off", Value::Bool(true));
        rig.cycle();
        for (path, value) in [("on", true), ("off", false), ("pulse", true)] {
            rig.write(path, Value::Bool(value));
        }
        for now in (0..=200).step_by(10) {
            rig.now = Time::ZERO + Span::from_millis(now);
            if now == 60 {
                rig.write("pt", Value::Int(Span::from_millis(preset).as_nanos()));
            }
            rig.cycle();
            let expired = now >= over;
            let found = ["ton.Q", "tof.Q", "tp.Q"].map(|path| rig.on(path));
            assert_eq!(found, [expired, !expired, !expired], "{preset} ms, at {now} ms");
        }
        // What has expired does not begin again with a longer preset.
        rig.write("pt", Value::Int(Span::from_secs(10).as_nanos()));
        rig.cycle();
        assert_eq!(["ton.Q", "tof.Q", "tp.Q"].map(|path| rig.on(path)), [true, false, false], "{preset} ms");
    }
}

#[test]
fn edges_in_the_first_cycle() {
    let text = "PROGRAM MAIN VAR high : BOOL := TRUE; low : BOOL; r1, r2 : R_TRIG; f1, f2 : F_TRIG; END_VAR
        r1(CLK := high); r2(CLK := low); f1(CLK := high); f2(CLK := low); END_PROGRAM";
    let mut rig = Rig::new(text);
    rig.cycle();
    assert_eq!(["r1.Q", "r2.Q", "f1.Q", "f2.Q"].map(|path| rig.on(path)), [true, false, false, false]);
    rig.cycle();
    assert_eq!(["r1.Q", "r2.Q", "f1.Q", "f2.Q"].map(|path| rig.on(path)), [false; 4]);
}

#[test]
fn shifts_rotations_and_conversions() {
    for (declared, expression, expected) in [
        ("USINT", "SHL(USINT#16#81, 8)", 0),
        ("USINT", "SHR(USINT#16#81, 200)", 0),
        ("BYTE", "SHL(BYTE#16#81, n)", 0),
        ("SINT", "SHR(SINT#-127, 8)", -1),
        ("SINT", "SHR(SINT#-127, n)", 0),
        ("BYTE", "ROL(BYTE#16#81, 1)", 3),
        ("BYTE", "ROL(BYTE#16#81, 9)", 3),
        ("BYTE", "ROR(BYTE#16#81, 9)", 0xC0),
        ("BYTE", "ROL(BYTE#16#81, n)", 0xC0),
        ("INT", "REAL_TO_INT(2.5)", 2),
        ("INT", "REAL_TO_INT(3.5)", 4),
        ("INT", "REAL_TO_INT(-1.5)", -2),
        ("INT", "REAL_TO_INT(-2.5)", -2),
        ("INT", "REAL_TO_INT(70000.0)", 4464),
        ("USINT", "REAL_TO_USINT(-1.0)", 255),
        ("DINT", "LREAL_TO_DINT(4294967297.0)", 1),
        ("INT", "BCD_TO_INT(BYTE#73)", 49),
        ("INT", "BCD_TO_INT(BYTE#151)", 97),
        ("INT", "BCD_TO_INT(BYTE#15)", -1),
        ("BYTE", "INT_TO_BCD(49)", 73),
        ("BYTE", "INT_TO_BCD(97)", 151),
        ("BYTE", "INT_TO_BCD(100)", 255),
        ("BYTE", "INT_TO_BCD(-1)", 255),
    ] {
        let declarations = format!("VAR x : {declared}; n : INT := -1; END_VAR");
        let rig = once(&declarations, &format!("x := {expression};"));
        assert_eq!(rig.int("x"), expected, "{expression}");
    }
}
