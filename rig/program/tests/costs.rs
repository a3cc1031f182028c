//! Modelled time of whole programs. The figures of controller:PERF-01, duration of 1000 instructions: addition,
//! subtraction and multiplication of INT 42 us, DINT 41 us, REAL 336 us; division of REAL 678 us; an operation of
//! BOOL 75 us; load and store of INT 64 us, DINT 49 us, REAL 50 us. What the documents do not give is what
//! `Costs::default` says.

use crate::support::{Memory, Rig, sources};
use scanrig_program::{Costs, Machine, Options, StopReason, compile};
use signal::{Span, Time};
use std::sync::Arc;

/// Nanoseconds of one cycle.
fn time(text: &str) -> i64 {
    Rig::new(text).cycle().as_nanos()
}

/// Nanoseconds of a statement that stands in the source a thousand times.
fn thousand(declarations: &str, statement: &str) -> i64 {
    let body = format!("{statement}\n").repeat(1000);
    time(&format!("PROGRAM MAIN VAR {declarations} END_VAR\n{body}END_PROGRAM"))
}

const VARIABLES: &str = "b, c : BOOL; y : BYTE; i, j : INT; d, e : DINT; r, q : REAL;";

#[test]
fn a_thousand_documented_instructions_take_the_documented_time() {
    let micros = |statement: &str| thousand(VARIABLES, statement) as f64 / 1000.0;
    // Load and store.
    assert_eq!(micros("i := j;"), 64.0);
    assert_eq!(micros("d := e;"), 49.0);
    assert_eq!(micros("r := q;"), 50.0);
    // An instruction with a literal beside it, without its load and store.
    for (with, without, documented) in [
        ("i := j + 3;", "i := j;", 42.0),
        ("i := j - 3;", "i := j;", 42.0),
        ("i := j * 3;", "i := j;", 42.0),
        ("d := e + 3;", "d := e;", 41.0),
        ("d := e - 3;", "d := e;", 41.0),
        ("d := e * 3;", "d := e;", 41.0),
        ("r := q + 1.5;", "r := q;", 336.0),
        ("r := q - 1.5;", "r := q;", 336.0),
        ("r := q * 1.5;", "r := q;", 336.0),
        ("r := q / 1.5;", "r := q;", 678.0),
        ("b := NOT c;", "b := c;", 75.0),
        ("b := c AND TRUE;", "b := c;", 75.0),
        ("b := c OR FALSE;", "b := c;", 75.0),
        ("b := c XOR TRUE;", "b := c;", 75.0),
        ("b := c = TRUE;", "b := c;", 75.0),
        // What changes nothing takes its time all the same: the controller does not know.
        ("i := j + 0;", "i := j;", 42.0),
        ("d := e * 1;", "d := e;", 41.0),
        ("d := e * 8;", "d := e;", 41.0),
        ("r := q * 1.0;", "r := q;", 336.0),
        ("r := q / 2.0;", "r := q;", 678.0),
        ("b := c AND FALSE;", "b := c;", 75.0),
    ] {
        assert_eq!(micros(with) - micros(without), documented, "{with}");
    }
    // In long expressions too.
    let sum = |ty: &str| {
        time(&format!("PROGRAM MAIN VAR x, y : {ty}; END_VAR x := y{}; END_PROGRAM", " + y".repeat(150)))
    };
    assert_eq!(sum("INT"), 64 + 150 * (32 + 42));
    assert_eq!(sum("DINT"), 49 + 150 * (24 + 41));
    assert_eq!(sum("REAL"), 50 + 150 * (25 + 336));
}

/// Types with what they cost: load, store, operation, division.
const CLASSES: [(&str, [i64; 4]); 23] = [
    ("SINT", [32, 32, 42, 84]),
    ("USINT", [32, 32, 42, 84]),
    ("INT", [32, 32, 42, 84]),
    ("UINT", [32, 32, 42, 84]),
    ("BYTE", [32, 32, 42, 84]),
    ("WORD", [32, 32, 42, 84]),
    ("DINT", [24, 25, 41, 82]),
    ("UDINT", [24, 25, 41, 82]),
    ("DWORD", [24, 25, 41, 82]),
    ("LINT", [48, 50, 82, 164]),
    ("ULINT", [48, 50, 82, 164]),
    ("LWORD", [48, 50, 82, 164]),
    ("REAL", [25, 25, 336, 678]),
    ("LREAL", [50, 50, 672, 1356]),
    ("TIME", [24, 25, 41, 82]),
    ("LTIME", [48, 50, 82, 164]),
    ("DATE", [24, 25, 41, 82]),
    ("TOD", [24, 25, 41, 82]),
    ("DT", [24, 25, 41, 82]),
    ("LDT", [48, 50, 82, 164]),
    ("BOOL", [37, 38, 75, 75]),
    ("CHAR", [32, 32, 42, 84]),
    ("WCHAR", [32, 32, 42, 84]),
];

#[test]
fn every_type_costs_what_its_class_does() {
    let (bool_op, bool_store) = (75, 38);
    for (ty, [load, store, op, div]) in CLASSES {
        let declarations = format!("x, y, z : {ty}; b : BOOL; n : INT;");
        let number =
            !matches!(ty, "BOOL" | "TIME" | "LTIME" | "DATE" | "TOD" | "DT" | "LDT" | "CHAR" | "WCHAR");
        let real = matches!(ty, "REAL" | "LREAL");
        let mut expected = vec![
            ("x := y;", load + store),
            ("b := x < y;", 2 * load + op + bool_store),
            ("b := x = y;", 2 * load + op + bool_store),
            ("b := NOT (x = y);", 2 * load + op + bool_op + bool_store),
            ("x := MAX(y, z);", 2 * load + op + store),
            ("x := LIMIT(y, x, z);", 3 * load + 2 * op + store),
        ];
        if number {
            expected.extend([
                ("x := y + z;", 2 * load + op + store),
                ("x := y * z - x;", 3 * load + 2 * op + store),
                ("x := ABS(y);", load + op + store),
                ("z := 1; x := y / z;", store + 2 * load + div + store),
            ]);
        }
        if number && !real {
            expected.extend([
                ("z := 1; x := y MOD z;", store + 2 * load + div + store),
                ("x := y AND z;", 2 * load + op + store),
                ("x := NOT y;", load + op + store),
                ("x := SHL(y, 3);", load + op + store),
                ("x := ROR(y, n);", load + 32 + op + store),
            ]);
        }
        for (statement, expected) in expected {
            let found = time(&format!("PROGRAM MAIN VAR {declarations} END_VAR {statement} END_PROGRAM"));
            assert_eq!(found, expected, "{ty}: {statement}");
        }
    }
}

#[test]
fn constants_and_constant_expressions_are_free() {
    for (statement, expected) in [
        ("i := 5;", 32),
        ("i := 2 + 3 * 4 - 20 / 7;", 32),
        ("i := seven * 2 + seven;", 32),
        ("d := INT_TO_DINT(seven) + 3;", 25),
        ("r := 1.0 / 3.0 * 2.0;", 25),
        ("b := 3 > 2;", 38),
        ("b := NOT TRUE;", 38),
        // Constants beside a variable: left to right, only what is constant by itself is computed before.
        ("i := j + 2 * 3;", 32 + 42 + 32),
        ("i := 2 + 3 + j;", 32 + 42 + 32),
        ("i := j + 2 + 3;", 32 + 2 * 42 + 32),
        // A conversion into the type that it has cuts a constant, as one into another type does.
        ("y := y * BYTE_TO_BYTE(BYTE#255 + BYTE#1);", 32 + 42 + 32),
        ("y := y * TO_BYTE(USINT#255 + USINT#1);", 32 + 42 + 32),
    ] {
        let text = format!(
            "PROGRAM MAIN VAR {VARIABLES} END_VAR VAR CONSTANT seven : INT := 7; END_VAR {statement} END_PROGRAM"
        );
        assert_eq!(time(&text), expected, "{statement}");
    }
}

#[test]
fn conversions_cost_an_operation_of_the_wider_type() {
    for (statement, expected) in [
        ("d := INT_TO_DINT(i);", 32 + 41 + 25),
        ("i := DINT_TO_INT(d);", 24 + 41 + 32),
        ("r := INT_TO_REAL(i);", 32 + 336 + 25),
        ("i := REAL_TO_INT(r);", 25 + 336 + 32),
        ("b := INT_TO_BOOL(i);", 32 + 42 + 38),
        // What goes by itself between whole numbers takes no time, to a real number it is an operation.
        ("d := i;", 32 + 25),
        ("d := d + i;", 24 + 32 + 41 + 25),
        ("r := i;", 32 + 336 + 25),
        ("r := r + i;", 25 + 32 + 336 + 336 + 25),
    ] {
        assert_eq!(
            time(&format!("PROGRAM MAIN VAR {VARIABLES} END_VAR {statement} END_PROGRAM")),
            expected,
            "{statement}"
        );
    }
}

#[test]
fn statements_cost_their_tests_and_turns() {
    let (branch, int) = (20, 32);
    let condition = int + 42; // Load of i, comparison.
    for (statement, expected) in [
        ("IF i > 5 THEN j := 1; END_IF;", condition + branch),
        ("IF i = 0 THEN j := 1; END_IF;", condition + branch + int),
        ("IF i = 0 THEN j := 1; ELSE d := 1; END_IF;", condition + branch + int),
        ("IF i > 5 THEN j := 1; ELSE d := 1; END_IF;", condition + branch + 25),
        ("IF i > 5 THEN j := 1; ELSIF i < 1 THEN d := 1; END_IF;", 2 * (condition + branch) + 25),
        ("IF b THEN j := 1; END_IF;", 37 + branch),
        // Both sides of AND are computed as far as time goes; AND_THEN leaves the right one out.
        ("IF b AND i > 5 THEN j := 1; END_IF;", 37 + condition + 75 + branch),
        ("IF b OR i > 5 THEN j := 1; END_IF;", 37 + condition + 75 + branch),
        // The selector is read once; each label that is passed or met is a comparison and a branch.
        ("CASE i OF 0: j := 1; END_CASE;", int + 42 + branch + int),
        ("CASE i OF 3: j := 1; 0: j := 2; END_CASE;", int + 2 * (42 + branch) + int),
        ("CASE i OF 3, 4: j := 1; ELSE j := 2; END_CASE;", int + 2 * (42 + branch) + int),
    ] {
        assert_eq!(
            time(&format!("PROGRAM MAIN VAR {VARIABLES} END_VAR {statement} END_PROGRAM")),
            expected,
            "{statement}"
        );
    }
    // FOR: the start is stored, each turn is tested (load, comparison, branch) and counted (load, addition, store, branch).
    let (test, count) = (int + 42 + branch, int + 42 + int + branch);
    for turns in [0, 1, 2, 10] {
        let text = format!(
            "PROGRAM MAIN VAR i, j : INT; END_VAR FOR i := 1 TO {turns} DO j := 1; END_FOR; END_PROGRAM"
        );
        assert_eq!(time(&text), int + test + turns * (int + count + test), "{turns}");
        let text = format!(
            "PROGRAM MAIN VAR i, j : INT; END_VAR FOR i := {turns} TO 1 BY -1 DO j := 1; END_FOR; END_PROGRAM"
        );
        assert_eq!(time(&text), int + test + turns * (int + count + test), "{turns}");
        // WHILE: the condition and a branch before each turn, a branch back.
        let text = format!(
            "PROGRAM MAIN VAR i : INT; END_VAR WHILE i < {turns} DO i := i + 1; END_WHILE; END_PROGRAM"
        );
        assert_eq!(
            time(&text),
            condition + branch + turns * (2 * int + 42 + branch + condition + branch),
            "{turns}"
        );
        if turns > 0 {
            let text = format!(
                "PROGRAM MAIN VAR i : INT; END_VAR REPEAT i := i + 1; UNTIL i >= {turns} END_REPEAT; END_PROGRAM"
            );
            assert_eq!(time(&text), turns * (2 * int + 42 + condition + branch), "{turns}");
        }
    }
}

#[test]
fn calls_cost_their_parameters_and_bodies() {
    let units = "FUNCTION f : INT VAR_INPUT x, y : INT; END_VAR f := x + y; END_FUNCTION
        FUNCTION_BLOCK fb VAR_INPUT x : INT; END_VAR VAR_OUTPUT y : INT; END_VAR y := x; END_FUNCTION_BLOCK\n";
    let (call, int, body) = (200, 32, 32 + 32 + 42 + 32);
    for (statement, expected) in [
        // Values given to a function are part of the call, those given to a block are stored.
        ("i := f(1, 2);", call + body + int),
        ("i := f(i, y := 2);", int + call + body + int),
        ("block(x := 1);", int + call + 64),
        ("block();", call + 64),
        ("block(x := i, y => i);", 2 * int + call + 64 + 2 * int),
        ("i := block.y;", 64),
        // A standard block is one operation.
        ("t1(IN := TRUE, PT := T#1s);", 38 + 25 + 400),
        ("r1(CLK := b);", 37 + 38 + 400),
        // An index is checked.
        ("a[3] := 1;", int),
        ("a[i] := 1;", int + 42 + int),
        ("m[i, i] := 1;", 2 * (int + 42) + int),
        // A function of the library that is no operation.
        ("r := SQRT(r);", 25 + 1000 + 25),
        // A text is one unit of time; structures cost 8 bytes at a time.
        ("s := 'abc';", 1000),
        ("s := CONCAT(s, s);", 1000),
        ("big := other;", 5 * 49),
    ] {
        let text = format!(
            "{units}PROGRAM MAIN VAR i : INT := 1; b : BOOL; r : REAL; block : fb; t1 : TON; r1 : R_TRIG; a : ARRAY[0..9] OF INT;
             m : ARRAY[0..2, 0..2] OF INT; s : STRING; big, other : ARRAY[1..10] OF DINT; END_VAR {statement} END_PROGRAM"
        );
        assert_eq!(time(&text), expected, "{statement}");
    }
}

#[test]
fn other_costs_may_be_given() {
    // Twice the figure of one operation, of one operation only.
    let text = "PROGRAM MAIN VAR i : INT; r : REAL; END_VAR i := i + 1; r := r * 2.0; END_PROGRAM";
    let with = |costs: Costs| {
        let program = compile(&sources(text), &Options { costs, ..Options::default() }).unwrap();
        let mut machine = Machine::new(Arc::new(program), &[vec![0]]).unwrap();
        machine.begin(0);
        let slice = machine.resume(0, Time::ZERO, Span::from_secs(1), &mut Memory::default());
        assert_eq!(slice.stop, StopReason::Done);
        slice.used.as_nanos()
    };
    let all = 64 + 42 + 50 + 336;
    assert_eq!(with(Costs::default()), all);
    assert_eq!(with(Costs { int_op: 84, ..Costs::default() }), all + 42);
    assert_eq!(with(Costs { real_op: 672, ..Costs::default() }), all + 336);
    assert_eq!(with(Costs { real_store: 0, ..Costs::default() }), all - 25);
}
