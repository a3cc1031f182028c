//! What the machine does at once - elements, pairs of operations, calls, native blocks - gives the same results in the
//! same modelled time as one operation after the other (controller:PERF-01; results and times do not depend on slices).

use crate::support::{Memory, sources};
use scanrig_program::{Machine, Options, StopReason, compile};
use signal::{Span, Time, Value};
use std::sync::Arc;

/// Runs cycles: in one slice each, or with budgets that never hold more than the next operation. Every value of the
/// program in the end, and the time that was used.
fn run(text: &str, names: &[&str], whole: bool) -> (Vec<Value>, Span, StopReason) {
    let program = compile(&sources(text), &Options::default()).unwrap();
    let mut machine = Machine::new(Arc::new(program), &[vec![0]]).unwrap();
    let mut memory = Memory::default();
    let (mut used, mut stop) = (Span::ZERO, StopReason::Done);
    for cycle in 0..3 {
        machine.begin(0);
        let start = Time::from_nanos(cycle * 40_000_000);
        let mut in_cycle = Span::ZERO;
        let mut budget = if whole { Span::from_secs(1) } else { Span::ZERO };
        loop {
            let slice = machine.resume(0, start + in_cycle, budget, &mut memory);
            in_cycle = in_cycle + slice.used;
            stop = slice.stop;
            match stop {
                StopReason::Budget { next } => budget = next,
                _ => break,
            }
        }
        used = used + in_cycle;
    }
    let values = names.iter().map(|name| machine.read(machine.find(name).unwrap())).collect();
    (values, used, stop)
}

fn same(text: &str, names: &[&str]) -> Vec<Value> {
    let (values, used, stop) = run(text, names, true);
    assert_eq!(run(text, names, false), (values.clone(), used, stop), "{text}");
    values
}

#[test]
fn elements() {
    for (ty, index) in [
        ("SINT", "DINT"),
        ("BYTE", "INT"),
        ("INT", "DINT"),
        ("WORD", "INT"),
        ("DINT", "DINT"),
        ("DINT", "INT"),
        ("REAL", "DINT"),
        ("LINT", "INT"),
    ] {
        let zero = if matches!(ty, "BYTE" | "WORD") { format!("{ty}#0") } else { "0".into() };
        let sums = if matches!(ty, "BYTE" | "WORD") { "" } else { "s := s + a[i]; t := a[i + 1] + t;" };
        let text = format!(
            "PROGRAM MAIN
            VAR a : ARRAY[-3..8] OF {ty}; i : {index}; k, s, t, last : {ty}; g, ge, l, le, e, ne : DINT; END_VAR
            FOR i := -3 TO 8 DO a[i] := TO_{ty}(i * 7 MOD 5 + 6); END_FOR;
            a[2] := {zero};
            k := a[1];
            FOR i := -3 TO 7 DO
                a[i] := a[i + 1];
                {sums}
                IF a[i] > k THEN g := g + 1; END_IF;
                IF a[i] >= k THEN ge := ge + 1; END_IF;
                IF k > a[i] THEN l := l + 1; END_IF;
                IF k >= a[i] THEN le := le + 1; END_IF;
                IF a[i] = k THEN e := e + 1; END_IF;
                IF k <> a[i] THEN ne := ne + 1; END_IF;
            END_FOR;
            i := 4;
            a[i - 2] := k;
            last := a[i - 2];
            END_PROGRAM"
        );
        let names = ["g", "le", "ge", "l", "e", "ne", "last", "k", "s", "t", "a[-3]", "a[1]", "a[8]"];
        let values = same(&text, &names);
        for (one, other) in [(0, 1), (2, 3), (4, 5)] {
            // Of a comparison and its opposite, one holds in each of the 11 turns of 3 cycles.
            match (values[one], values[other]) {
                (Value::Int(n), Value::Int(m)) => assert_eq!(n + m, 33, "{ty} {index} {}", names[one]),
                others => panic!("{others:?}"),
            }
        }
        assert_eq!(values[6], values[7]);
    }
}

#[test]
fn an_element_outside_of_its_array_is_a_fault() {
    for body in [
        "a[i] := 1;",
        "n := a[i];",
        "n := n + a[i];",
        "a[i - 1] := a[i];",
        "IF a[i] > n THEN n := 1; END_IF;",
    ] {
        let text = format!(
            "PROGRAM MAIN VAR a : ARRAY[2..6] OF DINT; i, n : DINT; END_VAR
            FOR i := 3 TO 9 DO {body} END_FOR; END_PROGRAM"
        );
        let (values, _, stop) = run(&text, &["i"], true);
        assert!(matches!(stop, StopReason::Fault(_)), "{body}: {stop:?}");
        assert_eq!(values, [Value::Int(7)], "{body}");
        same(&text, &["i", "n", "a[2]", "a[6]"]);
    }
}

#[test]
fn pairs_of_operations() {
    let text = "PROGRAM MAIN
        VAR d, n, m, x, count, low, high : DINT; y, z : REAL; END_VAR
        d := 2; n := 90;
        WHILE d * d <= n DO
            IF n MOD d = 0 THEN count := count + 1; END_IF;
            IF n MOD d <> 1 THEN count := count + 100; END_IF;
            d := d + 1;
        END_WHILE;
        WHILE d * 3 > m DO m := m + 4; END_WHILE;
        x := x * 1103515245 + 12345; x := 7 + x * x;
        low := 20; high := 2147483640;
        WHILE low >= -5 DO low := low - 3; z := z + 1.0; END_WHILE;
        WHILE low < 12 DO low := low + 5; z := z * 2.0 + 1.0; END_WHILE;
        WHILE high > 0 DO high := high + 3; y := y + 0.1 * z; END_WHILE;
        END_PROGRAM";
    let values = same(text, &["d", "count", "m", "low", "high", "x", "y", "z"]);
    // Of 2 to 9, five divide 90, and none leaves 1.
    assert_eq!(values[..2], [Value::Int(10), Value::Int(3 * (5 + 800))]);
    assert_eq!(values[3..5], [Value::Int(13), Value::Int(i64::from(2_147_483_640i32.wrapping_add(9)))]);
}

#[test]
fn a_remainder_by_zero_is_a_fault() {
    let text = "PROGRAM MAIN VAR n, d, k : DINT; END_VAR
        d := 3;
        WHILE TRUE DO k := k + 1; IF n MOD d = 0 THEN n := n + 1; END_IF; d := d - 1; END_WHILE;
        END_PROGRAM";
    let (values, _, stop) = run(text, &["d"], true);
    assert!(matches!(stop, StopReason::Fault(_)) && values == [Value::Int(0)], "{stop:?} {values:?}");
    same(text, &["n", "d", "k"]);
}

#[test]
fn calls_and_native_blocks() {
    let text =
        "FUNCTION TWICE : DINT VAR_INPUT n : DINT; m : INT := 5; END_VAR TWICE := n * 2 + m; END_FUNCTION
        FUNCTION_BLOCK STAGE
        VAR_INPUT run : BOOL; place : DINT; END_VAR VAR_OUTPUT count : DINT; late : BOOL; END_VAR
        VAR timer : TON; edge : R_TRIG; up : CTU; END_VAR
        timer(IN := run, PT := T#50ms);
        edge(CLK := timer.Q); up(CU := edge.Q, PV := WORD#2);
        IF edge.Q THEN count := count + 1; END_IF;
        late := timer.Q;
        place := TWICE(place + TWICE(count), 1);
        END_FUNCTION_BLOCK
        PROGRAM MAIN
        VAR s : ARRAY[1..3] OF STAGE; one : STAGE; timers : ARRAY[0..2] OF TOF; i, all : DINT; END_VAR
        one(run := TRUE, place := 3);
        FOR i := 1 TO 3 DO
            s[i](run := i < 3, place := i);
            timers[i - 1](IN := s[i].late, PT := T#1ms);
            IF s[i].late THEN all := all + s[i].place; END_IF;
            IF timers[i - 1].Q THEN all := all + 1000; END_IF;
        END_FOR;
        END_PROGRAM";
    let values = same(text, &["one.count", "s[1].count", "s[3].count", "one.place", "all", "s[2].timer.ET"]);
    assert_eq!(values[..3], [Value::Int(1), Value::Int(1), Value::Int(0)]);
    // 3 + (1 * 2 + 5), doubled, and one more.
    assert_eq!(values[3], Value::Int(21));
    // The timers of two instances have run out in the third cycle: (1 + 7) * 2 + 1, (2 + 7) * 2 + 1.
    assert_eq!(values[4], Value::Int(17 + 19 + 2000));
    assert_eq!(values[5], Value::Int(50_000_000));
}
