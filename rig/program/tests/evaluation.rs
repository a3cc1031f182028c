//! Every part of a statement is computed once, from left to right, wherever it stands; what is left out is left out
//! (IEC 61131-3, 7.3.2: operands from left to right; 6.6.1.4: functions with effects through VAR_IN_OUT and globals).

use crate::support::Rig;

/// Runs statements in which `f(n)` writes the digit `n` into a log and gives it.
fn log(declarations: &str, statements: &str) -> (i128, Rig) {
    let mut rig = Rig::new(&format!(
        "TYPE pair : STRUCT x, y : INT; END_STRUCT; END_TYPE
         VAR_GLOBAL n : LINT; g : INT := 5; END_VAR
         FUNCTION f : INT VAR_INPUT d : INT; END_VAR n := n * 10 + d; f := d; END_FUNCTION
         FUNCTION t : BOOL VAR_INPUT d : INT; END_VAR n := n * 10 + d; t := TRUE; END_FUNCTION
         FUNCTION r : REAL VAR_INPUT d : INT; END_VAR n := n * 10 + d; r := INT_TO_REAL(d); END_FUNCTION
         FUNCTION s : STRING VAR_INPUT d : INT; END_VAR n := n * 10 + d; s := INT_TO_STRING(d); END_FUNCTION
         FUNCTION p : POINTER TO INT VAR_INPUT d : INT; END_VAR n := n * 10 + d; p := ADR(g); END_FUNCTION
         FUNCTION three : INT VAR_INPUT a, b, c : INT; END_VAR three := a * 100 + b * 10 + c; END_FUNCTION
         FUNCTION both : INT VAR_INPUT a : INT; END_VAR VAR_IN_OUT v : INT; END_VAR VAR_OUTPUT o : INT; END_VAR v := v + a; o := a + 1; both := 1; END_FUNCTION
         FUNCTION_BLOCK fb VAR_INPUT a, b : INT; END_VAR VAR_OUTPUT o : INT; END_VAR VAR v : INT; END_VAR
           METHOD m : INT VAR_INPUT x : INT; END_VAR m := x + v; END_METHOD
           PROPERTY q : INT GET q := v; END_GET SET v := q; END_SET END_PROPERTY
           o := a + b;
         END_FUNCTION_BLOCK
         PROGRAM MAIN VAR i, j : INT; x : REAL; b : BOOL; u : STRING; a : ARRAY[0..9] OF INT; m : ARRAY[0..9, 0..9] OF INT; w : ARRAY[0..9] OF WORD; l : ARRAY[0..9] OF fb; k : ARRAY[0..9] OF pair; e : ARRAY[0..9] OF TON; z : ARRAY[0..9] OF STRING; {declarations} END_VAR\n{statements}\nEND_PROGRAM"
    ));
    rig.cycle();
    (rig.int("n"), rig)
}

#[test]
fn each_part_once_and_in_order() {
    for (statements, expected) in [
        ("i := f(1) + f(2) * f(3) - f(4);", 1234),
        ("i := (f(1) + f(2)) * (f(3) + f(4));", 1234),
        ("i := f(1) - (f(2) - (f(3) - f(4)));", 1234),
        ("b := f(1) < f(2) AND f(3) = f(4) OR f(5) > f(6);", 123_456),
        ("IF f(1) > f(2) OR f(3) > f(4) THEN i := 1; END_IF;", 1234),
        ("IF t(1) AND NOT t(2) XOR t(3) THEN i := 1; END_IF;", 123),
        ("i := three(f(1), f(2), f(3));", 123),
        ("i := three(f(1), three(f(2), f(3), f(4)), f(5));", 12_345),
        ("i := MAX(f(1), f(3), f(2));", 132),
        ("i := MIN(f(1), f(3), f(2));", 132),
        ("i := LIMIT(f(1), f(5), f(3));", 153),
        ("i := ABS(f(3));", 3),
        // Only the value that is taken.
        ("i := SEL(t(1), f(2), f(3));", 13),
        ("i := SEL(NOT t(1), f(2), f(3));", 12),
        ("i := MUX(f(1), f(2), f(3), f(4));", 13),
        ("i := MUX(f(7), f(2), f(3), f(4));", 74),
        ("x := SQRT(r(4)) + EXPT(r(2), r(3));", 423),
        ("x := MAX(r(1), r(2)) / r(3);", 123),
        ("x := r(1) ** f(2);", 12),
        ("i := WORD_TO_INT(SHL(INT_TO_WORD(f(1)), f(2)));", 12),
        ("u := CONCAT(s(1), s(2), s(3));", 123),
        ("b := s(1) < s(2);", 12),
        ("u := REPLACE(s(1), s(2), f(3), f(4));", 1234),
        ("u := SEL(t(1), s(2), s(3));", 13),
        ("u := MAX(s(1), s(3), s(2));", 132),
        // Places.
        ("a[f(1)] := f(2);", 12),
        ("m[f(1), f(2)] := f(3);", 123),
        ("i := m[f(1), f(2)] + a[f(3)];", 123),
        ("a[a[f(1)] + f(2)] := a[f(3)];", 123),
        ("k[f(1)] := k[f(2)];", 12),
        ("k[f(1)].y := k[f(2)].x;", 12),
        ("w[f(1)].3 := t(2);", 12),
        ("b := w[f(1)].3;", 1),
        ("w[f(1)].%B1 := 7;", 1),
        ("z[f(1)] := z[f(2)];", 12),
        ("z[f(1)][f(0)] := 65;", 10),
        ("p(1)^ := f(2);", 12),
        ("i := p(1)^ + f(2);", 12),
        // Calls of what stands at a computed place.
        ("l[f(1)](a := f(2), b := f(3));", 123),
        ("l[f(1)](f(2), f(3), o => i);", 123),
        ("i := l[f(1)].m(f(2)) + f(3);", 123),
        ("l[f(1)].q := f(2);", 12),
        ("i := l[f(1)].q + f(2);", 12),
        ("l[f(1)].a := f(2);", 12),
        ("e[f(1)](IN := t(2), PT := T#1s);", 12),
        ("b := e[f(1)].Q;", 1),
        ("i := both(a := f(1), v := a[f(2)], o => a[f(3)]);", 123),
        // Statements.
        // The end before each turn.
        ("FOR i := f(1) TO f(3) BY f(2) DO j := j + 1; END_FOR;", 12_333),
        ("FOR i := f(1) TO f(2) DO j := j + 1; END_FOR;", 1222),
        ("CASE f(3) OF 1, 2: i := 1; 3..5: i := 2; 7: i := 3; END_CASE;", 3),
        (
            "IF f(1) = 2 THEN i := f(2); ELSIF f(3) = 3 THEN i := f(4); ELSIF f(5) = 5 THEN i := f(6); END_IF;",
            134,
        ),
        ("WHILE f(1) > j DO j := j + 1; END_WHILE;", 11),
        ("REPEAT j := j + 1; UNTIL j > f(2) END_REPEAT;", 222),
        // What is left out.
        ("b := t(1) OR_ELSE t(2);", 1),
        ("b := NOT t(1) AND_THEN t(2) OR_ELSE t(3);", 13),
        ("IF NOT t(1) AND_THEN t(2) THEN i := f(3); ELSE i := f(4); END_IF;", 14),
        // Computed for its effect alone.
        ("f(1); f(2);", 12),
        ("i := SIZEOF(a);", 0),
    ] {
        assert_eq!(log("", statements).0, expected, "{statements}");
    }
}

#[test]
fn what_was_read_before_an_effect_stays() {
    // g is read, then changed by the function to its right.
    for (statement, expected) in [
        ("i := g + set(7);", 5 + 7),
        ("i := set(7) + g;", 7 + 7),
        ("i := g * 100 + set(7) * 10 + g;", 577),
        ("i := three(g, set(7), g);", 577),
        ("i := SEL(FALSE, g, set(7));", 5),
        ("i := MUX(0, g, set(7));", 5),
        ("i := MAX(g, set(2));", 5),
        ("i := a[g] + set(1) + a[g];", 50 + 1 + 10),
        ("IF g < set(5) THEN i := 1; ELSE i := 2; END_IF;", 2),
        ("IF g = set(7) OR g = 7 THEN i := 1; ELSE i := 2; END_IF;", 1),
        ("i := WORD_TO_INT(SHL(INT_TO_WORD(g), set(1)));", 10),
        ("i := -g + set(7);", 2),
        ("i := INT_TO_DINT(g) + set(7);", 12),
        ("CASE g OF 5: i := set(7); 7: i := 100; END_CASE; i := i + g;", 14),
        ("a[g] := set(7); i := a[5] * 10 + a[7];", 70 + 70),
        ("i := LIMIT(g, set(7), g);", 7),
    ] {
        let mut rig = Rig::new(&format!(
            "VAR_GLOBAL g : INT := 5; END_VAR
             FUNCTION set : INT VAR_INPUT x : INT; END_VAR g := x; set := x; END_FUNCTION
             FUNCTION three : INT VAR_INPUT a, b, c : INT; END_VAR three := a * 100 + b * 10 + c; END_FUNCTION
             PROGRAM MAIN VAR i : DINT; a : ARRAY[0..9] OF INT := [0, 10, 20, 30, 40, 50, 60, 70]; END_VAR {statement} END_PROGRAM"
        ));
        rig.cycle();
        assert_eq!(rig.int("i"), expected, "{statement}");
    }
}

#[test]
fn methods_and_programs_in_order() {
    let (order, rig) =
        log("o : fb;", "o.q := f(3); i := o.m(f(4)) + o.q * f(5); o(a := o.q, b := i); j := o.o;");
    assert_eq!((order, rig.int("i"), rig.int("j")), (345, 7 + 15, 25));
}
