//! What ends a cycle, with the line where it happened: indices, pointers and references, divisions by 0, the stack;
//! and what the limits of FOR, CASE and the jumps do not do.

use crate::support::oracle::{WHOLE, limits, literal, verdicts, wrap};
use crate::support::{Rig, codes, once};
use scanrig_program::{ProgramFaultKind, StopReason};

/// The fault of one cycle and its line.
fn fault(text: &str) -> Option<(ProgramFaultKind, u32)> {
    let mut rig = Rig::new(text);
    match rig.run().stop {
        StopReason::Fault(fault) => Some((fault.kind, fault.line)),
        StopReason::Done => None,
        other => panic!("{other:?}\n{text}"),
    }
}

/// The fault of the last line of statements; line 3 where it is in the first.
fn of(declarations: &str, statements: &str) -> Option<(ProgramFaultKind, u32)> {
    fault(&format!("PROGRAM MAIN\nVAR {declarations} END_VAR\n{statements}\nEND_PROGRAM"))
}

use ProgramFaultKind::{BadReference, Bounds, DivisionByZero, RealDivisionByZero, ReservedWrite, StackDepth};

#[test]
fn an_index_of_every_type_is_held_to_its_bounds() {
    for ty in WHOLE {
        let (least, most) = limits(ty);
        for (low, high) in [(0, 3), (-2, 2), (-128, -126), (100, 127), (5, 5), (250, 260), (40_000, 40_001)] {
            for index in [low - 1, low, low + 1, high, high + 1, least, most, 0, -1] {
                if index < least || index > most {
                    continue;
                }
                let inside = low <= index && index <= high;
                let declarations = format!("a : ARRAY[{low}..{high}] OF DINT; i : {};", ty.name());
                let set = format!("i := {};\n", literal(ty, index));
                let expected = (!inside).then_some((Bounds, 4));
                assert_eq!(of(&declarations, &format!("{set}a[i] := 1;")), expected, "{declarations} {set}");
                let read = of(&declarations, &format!("{set}IF a[i] = 0 THEN ; END_IF;"));
                assert_eq!(read, expected, "{declarations} {set}");
                // A constant index is found by the compiler.
                let text = format!("PROGRAM MAIN VAR {declarations} END_VAR a[{index}] := 1; END_PROGRAM");
                assert_eq!(codes(&text).is_empty(), inside, "{text} {:?}", codes(&text));
            }
        }
    }
}

#[test]
fn every_dimension_is_checked() {
    let declarations = "m : ARRAY[1..2, -1..1, 0..3] OF INT; i, j, k : INT;";
    for (indices, inside) in [
        ((1, -1, 0), true),
        ((2, 1, 3), true),
        ((0, -1, 0), false),
        ((3, 1, 3), false),
        // What would land inside of the array's memory is outside all the same.
        ((1, 2, 0), false),
        ((1, -1, 4), false),
        ((2, -1, -1), false),
        ((2, -2, 3), false),
    ] {
        let (i, j, k) = indices;
        let found = of(declarations, &format!("i := {i}; j := {j}; k := {k};\n\nm[i, j, k] := 7;"));
        assert_eq!(found, (!inside).then_some((Bounds, 5)), "{indices:?}");
    }
    // Arrays of arrays, arrays in structures, and what stands in a called block.
    let text = "TYPE line : STRUCT v : ARRAY[1..3] OF INT; END_STRUCT; END_TYPE
        FUNCTION_BLOCK fb VAR_INPUT n : INT; END_VAR VAR a : ARRAY[1..3] OF INT; END_VAR
          a[n] := 1;
        END_FUNCTION_BLOCK
        PROGRAM MAIN VAR t : ARRAY[0..1] OF line; b : fb; i : INT := 4; END_VAR
          t[1].v[3] := 1; t[i - 4].v[i - 1] := 2;
          STATEMENT
        END_PROGRAM";
    assert_eq!(fault(&text.replace("STATEMENT", "")), None);
    assert_eq!(fault(&text.replace("STATEMENT", "t[1].v[i] := 1;")), Some((Bounds, 7)));
    assert_eq!(fault(&text.replace("STATEMENT", "t[i].v[1] := 1;")), Some((Bounds, 7)));
    assert_eq!(fault(&text.replace("STATEMENT", "b(n := i);")), Some((Bounds, 3)));
}

#[test]
fn divisions_by_zero() {
    for ty in WHOLE {
        let name = ty.name();
        for op in ["/", "MOD"] {
            let declarations = format!("x, z : {name}; b : BOOL;");
            let expected = Some((DivisionByZero, 4));
            assert_eq!(of(&declarations, &format!("x := 1;\nx := x {op} z;")), expected, "{name} {op}");
            assert_eq!(of(&declarations, &format!("x := 1;\nb := 5 {op} z = 1;")), expected, "{name} {op}");
            // Where it is not reached it does no harm.
            assert_eq!(
                of(&declarations, &format!("b := z <> 0 AND_THEN x {op} z = 1;")),
                None,
                "{name} {op}"
            );
            assert_eq!(of(&declarations, &format!("IF z <> 0 THEN x := x {op} z; END_IF;")), None);
            // AND computes both sides.
            let both = of(&declarations, &format!("b := TRUE;\nb := z <> 0 AND x {op} z = 1;"));
            assert_eq!(both, expected, "{name} {op}");
            let constant = format!("PROGRAM MAIN VAR {declarations} END_VAR x := x {op} 0; END_PROGRAM");
            assert_eq!(codes(&constant), ["S0305"]);
        }
    }
    // Durations too, by the operator and by the functions.
    for by in ["t / n", "DIVTIME(t, n)", "DIV_TIME(t, n)", "T#1s / n"] {
        assert_eq!(
            of("t : TIME := T#1s; n : INT;", &format!("\nt := {by};")),
            Some((DivisionByZero, 4)),
            "{by}"
        );
    }
    // The lowest number by -1 is no fault: it wraps.
    assert_eq!(once("VAR i : INT := -32768; m : INT := -1; END_VAR", "i := i / m;").int("i"), -32768);
    assert_eq!(
        once("VAR i : LINT := -9223372036854775808; m : LINT := -1; END_VAR", "i := i MOD m;").int("i"),
        0
    );
}

/// controller:SYS-03: a code of its own; whatever is divided, by a zero of either sign.
#[test]
fn real_divisions_by_zero() {
    for name in ["REAL", "LREAL"] {
        let declarations = format!("x : {name} := 1.0; z, inf : {name}; t : TIME; n : INT; b : BOOL;");
        for by in [
            "x := x / z",
            "x := z / z",
            "x := x / (-z)",
            "x := inf / z",
            "b := x / z > 1.0",
            "t := T#1s / z",
            "t := DIV_TIME(T#1s, z)",
            "x := n / z",
            "x := DIV(x, z)",
        ] {
            let found = of(&declarations, &format!("\n{by};"));
            assert_eq!(found, Some((RealDivisionByZero, 4)), "{name} {by}");
            assert_eq!(of(&declarations, &format!("IF z <> 0.0 THEN {by}; END_IF;")), None, "{name} {by}");
        }
        for by in
            ["x / 0.0", "x / (-0.0)", "x / 0", "1.0 / 0.0", "x / none", "T#1s / 0.0", "DIV_TIME(T#1s, 0)"]
        {
            let text = format!(
                "PROGRAM MAIN VAR CONSTANT none : {name} := 0.0; END_VAR VAR x : {name}; t : TIME; END_VAR
                 {} := {by}; END_PROGRAM",
                if by.contains("T#") { "t" } else { "x" }
            );
            assert_eq!(codes(&text), ["S0305"], "{name} {by}");
        }
        // Functions at their poles, and results that are too large, are what IEEE 754 says: no code names them.
        let rest = format!(
            "LN(z); x := SQRT(-x); x := EXPT(z, -1.0); x := {name}#1.0E30; x := x * x * x * x * x * x * x * x * x * x * x"
        );
        assert_eq!(of(&declarations, &format!("x := {rest};")), None);
    }
}

#[test]
fn pointers_and_references_that_lead_nowhere() {
    let units = "TYPE s : STRUCT a, b : INT; END_STRUCT; END_TYPE
        INTERFACE shape METHOD area : INT END_METHOD END_INTERFACE
        FUNCTION_BLOCK square IMPLEMENTS shape VAR x : INT; END_VAR VAR_INPUT in : INT; END_VAR METHOD area : INT area := 4; END_METHOD x := 1; END_FUNCTION_BLOCK
        FUNCTION set : INT VAR_IN_OUT it : INT; END_VAR it := 1; END_FUNCTION
        PROGRAM MAIN VAR l : POINTER TO ARRAY[0..5] OF INT; t : POINTER TO STRING(9); END_VAR
          VAR p : POINTER TO INT; q : POINTER TO s; r : REFERENCE TO INT; f : POINTER TO square; i : shape; n : INT; st : s; sq : square; END_VAR
          ";
    for (statement, kind) in [
        ("p^ := 1;", Some(ReservedWrite)),
        ("n := p^;", Some(BadReference)),
        ("q^.a := 1;", Some(ReservedWrite)),
        ("n := q^.b;", Some(BadReference)),
        ("r := 1;", Some(ReservedWrite)),
        // Members and elements, bits, texts, structures, results of functions, parameters by reference.
        ("q^.b := 1;", Some(ReservedWrite)),
        ("p[3] := 1;", Some(ReservedWrite)),
        ("n := p[3];", Some(BadReference)),
        ("l^[n + 2] := 1;", Some(ReservedWrite)),
        ("n := l^[n + 2];", Some(BadReference)),
        ("n := 9; l^[n] := 1;", Some(Bounds)),
        ("p^.3 := TRUE;", Some(ReservedWrite)),
        ("IF p^.3 THEN n := 1; END_IF;", Some(BadReference)),
        ("t^ := 'a';", Some(ReservedWrite)),
        ("t^ := CONCAT('a', 'b');", Some(ReservedWrite)),
        ("n := LEN(t^);", Some(BadReference)),
        ("q^ := st;", Some(ReservedWrite)),
        ("st := q^;", Some(BadReference)),
        ("q^ := q^;", Some(BadReference)),
        ("p^ := REAL_TO_INT(2.0 * n);", Some(ReservedWrite)),
        ("set(p^);", Some(ReservedWrite)),
        ("f^(in := 1);", Some(ReservedWrite)),
        ("MEMSET(p, 0, 4);", Some(ReservedWrite)),
        ("MEMCPY(ADR(n), p, 2);", Some(BadReference)),
        ("n := r;", Some(BadReference)),
        ("f^();", Some(BadReference)),
        ("n := f^.area();", Some(BadReference)),
        ("n := i.area();", Some(BadReference)),
        ("p := ADR(n); p^ := 1;", None),
        ("q := ADR(st); q^.b := 3; n := q^.a;", None),
        ("r REF= n; r := 1;", None),
        ("f := ADR(sq); f^(); n := f^.area();", None),
        ("i := sq; n := i.area();", None),
        ("p := ADR(n); p := NULL; p^ := 1;", Some(ReservedWrite)),
        ("i := sq; i := NULL; n := i.area();", Some(BadReference)),
        // Numbers and wild sums.
        ("p := 4; n := p^;", Some(BadReference)),
        ("p := 16#FFFFFFFF; p^ := 1;", Some(ReservedWrite)),
        ("p := 16#7FFFFFFF; n := p^;", Some(BadReference)),
        ("p := ADR(n); p := p - 100000000; n := p^;", Some(BadReference)),
        ("p := ADR(n); p := p + 100000000; p^ := 1;", Some(ReservedWrite)),
        ("IF __ISVALIDREF(r) THEN r := 1; END_IF; IF p <> NULL THEN p^ := 1; END_IF;", None),
    ] {
        let found = fault(&format!("{units}{statement}\nEND_PROGRAM"));
        assert_eq!(found.map(|(kind, _)| kind), kind, "{statement}");
        // In the function that was given what leads nowhere, or in that of the library.
        if !["set", "MEM"].iter().any(|name| statement.starts_with(name)) {
            assert_eq!(found.map(|(_, line)| line), kind.map(|_| 7), "{statement}");
        }
    }
    // Within one variable pointers go anywhere; a pointer to an array of bytes sees a DINT.
    let rig = once(
        "VAR d : DINT := 16#0403_0201; p : POINTER TO BYTE; a : ARRAY[0..3] OF INT := [1, 2, 3, 4]; w : POINTER TO INT; n, m : INT; END_VAR",
        "p := ADR(d); p := p + 2; n := p^; w := ADR(a); w := w + 2 * SIZEOF(INT); m := w^; w[1] := 9;",
    );
    assert_eq!((rig.int("n"), rig.int("m"), rig.int("a[3]")), (3, 3, 9));
}

#[test]
fn the_stack_ends() {
    let text = "FUNCTION down : DINT VAR_INPUT n : DINT; END_VAR
          IF n > 0 THEN
            down := down(n - 1) + 1;
          END_IF;
        END_FUNCTION
        PROGRAM MAIN VAR d : DINT := DEEP; r : DINT; END_VAR r := down(d); END_PROGRAM";
    let found = fault(&text.replace("DEEP", "1000000"));
    // Found where the call is, in the function that calls itself.
    assert_eq!(found, Some((StackDepth, 3)));
    let mut rig = Rig::new(&text.replace("DEEP", "50"));
    rig.cycle();
    assert_eq!(rig.int("r"), 50);
    // The next cycle starts with an empty stack.
    let mut rig = Rig::new(&text.replace("DEEP", "1000000"));
    assert!(matches!(rig.run().stop, StopReason::Fault(_)));
    rig.write("d", signal::Value::Int(50));
    rig.cycle();
    assert_eq!(rig.int("r"), 50);
    // Two that call each other.
    let text =
        "FUNCTION odd : BOOL VAR_INPUT n : INT; END_VAR odd := n <> 0 AND_THEN even(n - 1); END_FUNCTION
        FUNCTION even : BOOL VAR_INPUT n : INT; END_VAR even := n = 0 OR_ELSE odd(n - 1); END_FUNCTION
        PROGRAM MAIN VAR b, c : BOOL; END_VAR b := even(20); c := odd(20); END_PROGRAM";
    let mut rig = Rig::new(text);
    rig.cycle();
    assert!(rig.on("b") && !rig.on("c"));
}

#[test]
fn what_ran_before_a_fault_stays() {
    let mut rig = Rig::new(
        "FUNCTION f : INT VAR_INPUT x : INT; END_VAR
           f := 10 / x;
         END_FUNCTION
         PROGRAM MAIN VAR a, b, c : INT; z : INT; END_VAR a := a + 1;
           b := f(1) + f(z); c := c + 1; END_PROGRAM",
    );
    for turn in 1..3 {
        let StopReason::Fault(fault) = rig.run().stop else { panic!() };
        assert_eq!((fault.kind, fault.line), (DivisionByZero, 2));
        assert_eq!((rig.int("a"), rig.int("b"), rig.int("c")), (turn, 0, 0));
    }
}

#[test]
fn counted_loops_at_the_limits() {
    // The tool's help, FOR: an end at the limit of the control variable's type makes a loop without an end. IEC 61131-3,
    // 7.3.3.4.2: tested before each turn. The turns are counted by a naive loop here, up to 21.
    for ty in WHOLE {
        let (low, high) = limits(ty);
        let name = ty.name();
        let declarations = format!("VAR i, s : {name}; n, c : DINT; END_VAR");
        for (from, to, by) in [
            (high - 2, high, 1),
            (high, high, 1),
            (high - 2, high - 1, 1),
            (high - 5, high, 2),
            (high - 5, high - 2, 2),
            (high - 5, high, 100),
            (low + 2, low, -1),
            (low + 2, low + 1, -1),
            (low, low, -1),
            (low + 5, low, -2),
            (low + 5, low + 3, -2),
            (low + 5, low, -100),
            (low + 1, low, 1),
            (high - 1, high, -1),
            (1, 3, 1),
            (3, 1, -1),
            (5, 5, 7),
        ] {
            let (mut i, mut turns) = (from, 0);
            while turns < 21 && if by > 0 { i <= to } else { i >= to } {
                turns += 1;
                i = wrap(i + by, ty);
            }
            for counted in [
                format!("FOR i := {from} TO {to} BY {by} DO"),
                // Step and end as variables, of the control variable's type where it has the number.
                format!("c := {by}; FOR i := {from} TO {to} BY c DO"),
                format!("s := {to}; FOR i := {from} TO s BY {by} DO"),
                format!("c := {by}; s := {to}; FOR i := {from} TO s BY c DO"),
            ] {
                let rig = once(
                    &declarations,
                    &format!("{counted} n := n + 1; IF n > 20 THEN EXIT; END_IF; END_FOR;"),
                );
                assert_eq!(rig.int("n"), turns, "{name} {counted}");
            }
        }
    }
}

#[test]
fn a_loop_without_an_end_is_warned_of_and_takes_the_whole_cycle() {
    let declarations = "VAR_GLOBAL i : SINT; u : USINT; d : DINT; n, k : USINT; END_VAR";
    let cases = [
        ("FOR i := 120 TO 127 DO ; END_FOR;", true),
        ("FOR i := n TO 127 DO ; END_FOR;", true),
        ("FOR i := 0 TO 126 BY 5 DO ; END_FOR;", true),
        ("FOR i := 0 TO -128 BY -1 DO ; END_FOR;", true),
        ("FOR u := 10 TO 0 BY -1 DO ; END_FOR;", true),
        ("FOR u := 10 TO 1 BY -1 DO ; END_FOR;", false),
        ("FOR u := 0 TO 254 DO ; END_FOR;", false),
        ("FOR u := 0 TO 250 BY 5 DO ; END_FOR;", false),
        ("FOR u := 255 TO 3 DO ; END_FOR;", false),
        ("FOR u := 0 TO 255 DO EXIT; END_FOR;", true),
        ("FOR d := 0 TO 2147483647 DO ; END_FOR;", true),
        ("FOR d := 0 TO n DO ; END_FOR;", false),
    ];
    let statements: Vec<String> =
        cases.iter().map(|(text, _)| text.replace("i := n", "i := USINT_TO_SINT(n)")).collect();
    for ((text, warned), found) in cases.iter().zip(verdicts(declarations, &statements)) {
        assert_eq!(found.contains(&"S0411"), *warned, "{text}: {found:?}");
    }
    // Nothing but the watchdog ends it.
    for end in ["127", "m", "i"] {
        let text = format!(
            "PROGRAM MAIN VAR i, m : SINT := 127; END_VAR FOR i := 120 TO {end} DO ; END_FOR; END_PROGRAM"
        );
        let mut rig = Rig::new(&text);
        assert!(matches!(rig.run().stop, StopReason::Budget { .. }), "{end}");
    }
    // A count of none less 1 is no end of an unsigned loop, and is warned of.
    let found = verdicts(declarations, &["FOR u := 0 TO k - 1 DO ; END_FOR;".to_string()]);
    assert_eq!(found, [["S0309"]]);
    let mut rig =
        Rig::new("PROGRAM MAIN VAR i, k : USINT; END_VAR FOR i := 0 TO k - 1 DO ; END_FOR; END_PROGRAM");
    assert!(matches!(rig.run().stop, StopReason::Budget { .. }));
    let rig =
        once("VAR u : USINT := 255; i, n : INT; END_VAR", "FOR i := 0 TO u + 2 DO n := n + 1; END_FOR;");
    assert_eq!(rig.int("n"), 258);
}

#[test]
fn bodies_that_change_their_loops() {
    let rig = once(
        "VAR i, n, m, k, e, s, z : INT; l : LINT; END_VAR",
        // The control variable counts from where the body leaves it; the step is computed once, the end before each turn.
        "FOR i := 1 TO 10 DO i := i + 1; n := n + 1; END_FOR;
         e := 3; FOR i := 1 TO e DO e := 6; m := m + 1; END_FOR;
         s := 1; FOR i := 1 TO 6 BY s DO s := 3; k := k + 1; END_FOR;
         e := 9; FOR i := 1 TO e + 1 BY 2 DO e := e - 1; z := z + 1; END_FOR;
         FOR l := 9223372036854775805 TO 9223372036854775806 DO ; END_FOR;",
    );
    assert_eq!((rig.int("n"), rig.int("m"), rig.int("k"), rig.int("z")), (5, 6, 6, 4));
    // A step of 0 goes on for ever: the cycle never ends, and time passes.
    let mut rig =
        Rig::new("PROGRAM MAIN VAR i, s : INT; END_VAR FOR i := 1 TO 2 BY s DO ; END_FOR; END_PROGRAM");
    assert!(matches!(rig.run().stop, StopReason::Budget { .. }));
    // Loops on members and constant elements; what could move in the loop is refused.
    let rig = once(
        "VAR a : ARRAY[0..2] OF INT; t : CTU_INT; p : POINTER TO INT; x, n : INT; END_VAR",
        "p := ADR(x); FOR p^ := 1 TO 2 DO n := n + x * 1000; END_FOR; FOR a[1] := 1 TO 4 DO n := n + a[1]; END_FOR; FOR t.PV := 1 TO 3 DO n := n + 100; END_FOR;",
    );
    assert_eq!((rig.int("n"), rig.int("a[1]"), rig.int("t.PV")), (3310, 5, 4));
    for control in ["a[j]", "x.3", "r"] {
        let text = format!(
            "PROGRAM MAIN VAR a : ARRAY[0..2] OF INT; p : POINTER TO INT; x, j : INT; r : REAL; END_VAR
             FOR {control} := 1 TO 4 DO ; END_FOR; END_PROGRAM"
        );
        assert_eq!(codes(&text), ["S0404"], "{control}");
    }
}

#[test]
fn selections_at_the_limits() {
    for ty in WHOLE {
        let (low, high) = limits(ty);
        let text = format!(
            "VAR i : {}; r : ARRAY[0..6] OF INT; n : INT; END_VAR VAR CONSTANT seven : {0} := 7; END_VAR",
            ty.name()
        );
        let mut statements = String::new();
        for (nth, value) in [low, low + 1, 7, 8, 50, high - 1, high].into_iter().enumerate() {
            statements += &format!(
                "i := {value}; CASE i OF {low}: n := 1; {high}: n := 2; seven: n := 3; 8..20, 22: n := 4; {}..{}: n := 5; ELSE n := 6; END_CASE; r[{nth}] := n;\n",
                high - 9,
                high - 1
            );
        }
        let rig = once(&text, &statements);
        let found: Vec<i128> = (0..7).map(|nth| rig.int(&format!("r[{nth}]"))).collect();
        assert_eq!(found, [1, 6, 3, 4, 6, 5, 2], "{}", ty.name());
    }
    let with = |labels: &str| {
        codes(&format!("PROGRAM MAIN VAR i : INT; n : INT; END_VAR CASE i OF {labels} END_CASE; END_PROGRAM"))
    };
    assert_eq!(with("1: n := 1; 2: n := 2; 1: n := 3;"), ["S0403"]);
    assert_eq!(with("1..5: n := 1; 3: n := 2;"), ["S0403"]);
    assert_eq!(with("5..1: n := 1;"), ["S0403"]);
    assert_eq!(with("n: n := 1;"), ["S0203"]);
    assert_eq!(with("40000: n := 1;"), ["S0303"]);
}

#[test]
fn jumps_leave_what_they_stand_in() {
    let text = "FUNCTION f : INT VAR_INPUT x : INT; END_VAR VAR i, j : INT; END_VAR
          f := 1; IF x = 0 THEN RETURN; END_IF;
          FOR i := 1 TO 3 DO
            j := 0;
            WHILE TRUE DO
              j := j + 1;
              IF j = 2 THEN CONTINUE; END_IF;
              IF j > 4 THEN EXIT; END_IF;
              CASE x OF 1: f := f + 10; 2: f := f + 100; IF i = 2 THEN RETURN; END_IF; 3: EXIT; ELSE CONTINUE; END_CASE;
              REPEAT IF x = 1 THEN EXIT; END_IF; f := f + 1; CONTINUE; UNTIL TRUE END_REPEAT;
            END_WHILE;
            IF x = 3 THEN CONTINUE; END_IF;
            f := f + 1000;
          END_FOR;
          f := f + 10000;
        END_FUNCTION
        PROGRAM MAIN VAR r : ARRAY[0..4] OF INT; i : INT; END_VAR FOR i := 0 TO 4 DO r[i] := f(i); END_FOR; END_PROGRAM";
    let mut rig = Rig::new(text);
    rig.cycle();
    let found: Vec<i128> = (0..5).map(|nth| rig.int(&format!("r[{nth}]"))).collect();
    // 1: 3 turns of 3 counted j (1, 3, 4), 1000 each. 2: as 1 by 101, and returns in the second turn.
    assert_eq!(found, [1, 1 + 90 + 3000 + 10_000, 1 + 303 + 1000 + 100, 10_001, 13_001]);
    assert_eq!(codes("PROGRAM MAIN EXIT; END_PROGRAM"), ["S0405"]);
    assert_eq!(codes("PROGRAM MAIN IF TRUE THEN CONTINUE; END_IF; END_PROGRAM"), ["S0405"]);
}
