//! Nothing parses and is then ignored: each construct of the grammar, put into a program that is the same otherwise,
//! changes what the program does or is, or is refused. The parser's own tests (`src/parse/tests`) show that every
//! word of the grammar reaches the tree; this shows that the tree's parts reach the program.

use crate::support::sources;
use scanrig_program::{Options, compile};

/// What a source comes to: the digest of the program with what is warned of, or the codes.
fn result(text: &str) -> Result<([u8; 32], Vec<&'static str>), Vec<&'static str>> {
    let codes = |found: &[document::Diagnostic]| found.iter().map(|finding| finding.code).collect::<Vec<_>>();
    match compile(&sources(text), &Options::default()) {
        Ok(program) => Ok((program.digest(), codes(&program.warnings))),
        Err(found) => Err(codes(&found)),
    }
}

/// Blocks, methods and types for the pairs to use.
const AROUND: &str = "
TYPE point : STRUCT x, y : INT; END_STRUCT; light : (off, on); END_TYPE
INTERFACE named METHOD name : INT END_METHOD END_INTERFACE
FUNCTION twice : INT VAR_INPUT n : INT; END_VAR twice := n * 2; END_FUNCTION
FUNCTION two : INT VAR_INPUT a : INT := 1; b : INT := 2; END_VAR VAR_OUTPUT o : INT; END_VAR o := a; two := b; END_FUNCTION
FUNCTION change : INT VAR_IN_OUT v : INT; END_VAR v := v + 1; change := v; END_FUNCTION
FUNCTION kind : INT VAR_INPUT it : ANY; END_VAR kind := DINT_TO_INT(it.TypeClass); END_FUNCTION
FUNCTION_BLOCK rising VAR_INPUT e : BOOL R_EDGE; END_VAR VAR n : INT; END_VAR IF e THEN n := 1; END_IF; END_FUNCTION_BLOCK
FUNCTION_BLOCK falling VAR_INPUT e : BOOL F_EDGE; END_VAR VAR n : INT; END_VAR IF e THEN n := 1; END_IF; END_FUNCTION_BLOCK
FUNCTION_BLOCK level VAR_INPUT e : BOOL; END_VAR VAR n : INT; END_VAR IF e THEN n := 1; END_IF; END_FUNCTION_BLOCK
FUNCTION_BLOCK vessel VAR n : INT; END_VAR
METHOD FB_Init : BOOL VAR_INPUT size : INT; END_VAR n := size; END_METHOD END_FUNCTION_BLOCK
FUNCTION_BLOCK counter VAR_INPUT up : BOOL; END_VAR VAR_OUTPUT n : INT; END_VAR
METHOD more : INT VAR_INPUT k : INT; END_VAR n := n + k; more := n; END_METHOD
PROPERTY half : INT GET half := n / 2; END_GET SET n := half * 2; END_SET END_PROPERTY
ACTION clear: n := 0; END_ACTION
IF up THEN n := n + 1; END_IF; END_FUNCTION_BLOCK
";

/// The declarations and statements of two programs that differ by one construct.
const BODIES: &[(&str, &str)] = &[
    ("VAR n : INT; END_VAR", "VAR n : INT := 1; END_VAR"),
    ("VAR n : INT; END_VAR", "VAR n : DINT; END_VAR"),
    ("VAR n : INT; END_VAR", "VAR n : INT (0..9); END_VAR"),
    ("VAR n : INT; END_VAR", "VAR RETAIN n : INT; END_VAR"),
    ("VAR RETAIN n : INT; END_VAR", "VAR PERSISTENT n : INT; END_VAR"),
    ("VAR n : INT := 1; END_VAR", "VAR CONSTANT n : INT := 1; END_VAR n := 2;"),
    ("VAR n : INT; END_VAR n := 1;", "VAR_TEMP n : INT; END_VAR n := 1;"),
    ("VAR n : INT; END_VAR n := 1;", "VAR_STAT n : INT; END_VAR n := 1;"),
    ("VAR n : INT; END_VAR", "VAR_INPUT n : INT; END_VAR VAR_OUTPUT m : INT; END_VAR"),
    ("VAR n : INT; END_VAR n := 1;", "VAR n AT %MW5 : INT; END_VAR n := 1;"),
    ("VAR n AT %MW5 : INT; END_VAR n := 1;", "VAR n AT %MW6 : INT; END_VAR n := 1;"),
    ("VAR a : ARRAY[0..3] OF INT; END_VAR", "VAR a : ARRAY[1..4] OF INT; END_VAR"),
    ("VAR a : ARRAY[0..3] OF INT; END_VAR", "VAR a : ARRAY[0..1, 0..1] OF INT; END_VAR"),
    ("VAR a : ARRAY[0..3] OF INT; END_VAR", "VAR a : ARRAY[0..3] OF INT := [1, 2(3)]; END_VAR"),
    ("VAR p : point; END_VAR", "VAR p : point := (y := 2); END_VAR"),
    ("VAR p : point; END_VAR", "VAR p : ARRAY[0..1] OF point := [(x := 1)]; END_VAR"),
    ("VAR t : TON; END_VAR", "VAR t : TON := (PT := T#1s); END_VAR"),
    ("VAR s : STRING; END_VAR", "VAR s : STRING(20); END_VAR"),
    ("VAR s : STRING; END_VAR", "VAR s : WSTRING; END_VAR"),
    ("VAR s : STRING; END_VAR", "VAR s : STRING := 'a'; END_VAR"),
    ("VAR c : light; END_VAR", "VAR c : light := on; END_VAR"),
    ("VAR c : light; END_VAR", "VAR c : (red, green); END_VAR"),
    ("VAR p : POINTER TO INT; END_VAR", "VAR p : REFERENCE TO INT; END_VAR n := 1;"),
    ("VAR v : vessel(size := 1); END_VAR", "VAR v : vessel(size := 2); END_VAR"),
    ("VAR v : vessel(1); END_VAR", "VAR v : vessel(2); END_VAR"),
    (
        "VAR v : ARRAY[0..1] OF vessel[(size := 1), (size := 2)]; END_VAR",
        "VAR v : ARRAY[0..1] OF vessel[(size := 1), (size := 3)]; END_VAR",
    ),
    ("VAR n : INT; p : POINTER TO INT; END_VAR", "VAR n : INT; p : POINTER TO INT := ADR(n); END_VAR"),
    ("VAR b : rising; END_VAR b(e := TRUE);", "VAR b : falling; END_VAR b(e := TRUE);"),
    ("VAR b : rising; END_VAR b(e := TRUE);", "VAR b : level; END_VAR b(e := TRUE);"),
    ("VAR n : INT; END_VAR n := kind(n);", "VAR n : INT; d : DINT; END_VAR n := kind(d);"),
    ("VAR n : INT; END_VAR n := two(a := 3);", "VAR n : INT; END_VAR n := two(a := 3, b := 4);"),
    ("VAR n AT %I* : INT; END_VAR", "VAR n : INT; END_VAR"),
    ("VAR n, m : INT; END_VAR n := m;", "VAR n, m : INT; END_VAR n := NOT m;"),
    ("VAR n, m : INT; END_VAR n := m;", "VAR n, m : INT; END_VAR n := -m;"),
    ("VAR n, m : INT; END_VAR n := m + 1;", "VAR n, m : INT; END_VAR n := m - 1;"),
    ("VAR n, m : INT; END_VAR n := m + 1;", "VAR n, m : INT; END_VAR n := m + 2;"),
    ("VAR n, m : INT; END_VAR n := m * (m + 1);", "VAR n, m : INT; END_VAR n := m * m + 1;"),
    ("VAR n, m : INT; END_VAR n := m / 3;", "VAR n, m : INT; END_VAR n := m MOD 3;"),
    ("VAR b, c, d : BOOL; END_VAR b := c AND d;", "VAR b, c, d : BOOL; END_VAR b := c AND_THEN d;"),
    ("VAR b, c, d : BOOL; END_VAR b := c OR d;", "VAR b, c, d : BOOL; END_VAR b := c OR_ELSE d;"),
    ("VAR b, c, d : BOOL; END_VAR b := c OR d;", "VAR b, c, d : BOOL; END_VAR b := c XOR d;"),
    ("VAR b : BOOL; n : INT; END_VAR b := n < 1;", "VAR b : BOOL; n : INT; END_VAR b := n <= 1;"),
    ("VAR b : BOOL; n : INT; END_VAR b := n = 1;", "VAR b : BOOL; n : INT; END_VAR b := n <> 1;"),
    ("VAR r : REAL; END_VAR r := r * r;", "VAR r : REAL; END_VAR r := r ** 2;"),
    ("VAR w : WORD; b : BOOL; END_VAR b := w.1;", "VAR w : WORD; b : BOOL; END_VAR b := w.2;"),
    ("VAR w : WORD; c : BYTE; END_VAR c := w.%B0;", "VAR w : WORD; c : BYTE; END_VAR c := w.%B1;"),
    ("VAR b, c : BOOL; END_VAR b := c;", "VAR b, c : BOOL; END_VAR b S= c;"),
    ("VAR b, c : BOOL; END_VAR b S= c;", "VAR b, c : BOOL; END_VAR b R= c;"),
    ("VAR n, m : INT; END_VAR n := 1;", "VAR n, m : INT; END_VAR m := n := 1;"),
    ("VAR n : INT; END_VAR IF n = 1 THEN n := 2; END_IF;", "VAR n : INT; END_VAR n := 2;"),
    (
        "VAR n : INT; END_VAR IF n = 1 THEN n := 2; END_IF;",
        "VAR n : INT; END_VAR IF n = 1 THEN n := 2; ELSE n := 3; END_IF;",
    ),
    (
        "VAR n : INT; END_VAR IF n = 1 THEN n := 2; END_IF;",
        "VAR n : INT; END_VAR IF n = 1 THEN n := 2; ELSIF n = 2 THEN n := 3; END_IF;",
    ),
    (
        "VAR n : INT; END_VAR CASE n OF 1: n := 2; END_CASE;",
        "VAR n : INT; END_VAR CASE n OF 1, 2: n := 2; END_CASE;",
    ),
    (
        "VAR n : INT; END_VAR CASE n OF 1: n := 2; END_CASE;",
        "VAR n : INT; END_VAR CASE n OF 1..4: n := 2; END_CASE;",
    ),
    (
        "VAR n : INT; END_VAR CASE n OF 1: n := 2; END_CASE;",
        "VAR n : INT; END_VAR CASE n OF 1: n := 2; ELSE n := 3; END_CASE;",
    ),
    (
        "VAR n : INT; END_VAR FOR n := 1 TO 5 DO END_FOR;",
        "VAR n : INT; END_VAR FOR n := 1 TO 5 BY 2 DO END_FOR;",
    ),
    (
        "VAR n, k : INT; END_VAR FOR n := 1 TO 5 DO k := 1; END_FOR;",
        "VAR n, k : INT; END_VAR FOR n := 1 TO 5 DO k := 1; EXIT; END_FOR;",
    ),
    (
        "VAR n, k : INT; END_VAR FOR n := 1 TO 5 DO k := 1; END_FOR;",
        "VAR n, k : INT; END_VAR FOR n := 1 TO 5 DO CONTINUE; k := 1; END_FOR;",
    ),
    (
        "VAR n : INT; END_VAR WHILE n < 5 DO n := n + 1; END_WHILE;",
        "VAR n : INT; END_VAR REPEAT n := n + 1; UNTIL n < 5 END_REPEAT;",
    ),
    ("VAR n : INT; END_VAR n := 1; n := 2;", "VAR n : INT; END_VAR n := 1; RETURN; n := 2;"),
    ("VAR n : INT; END_VAR n := twice(1);", "VAR n : INT; END_VAR n := twice(2);"),
    ("VAR n : INT; END_VAR n := two(a := 5);", "VAR n : INT; END_VAR n := two(b := 5);"),
    ("VAR n : INT; END_VAR n := two(a := 1);", "VAR n : INT; END_VAR n := two(a := 1, o => n);"),
    ("VAR n : INT; END_VAR n := twice(n);", "VAR n : INT; END_VAR n := change(n);"),
    ("VAR c : counter; END_VAR c();", "VAR c : counter; END_VAR c(up := TRUE);"),
    ("VAR c : counter; n : INT; END_VAR c();", "VAR c : counter; n : INT; END_VAR c(n => n);"),
    (
        "VAR c : counter; n : BOOL; t : TON; END_VAR t(Q => n);",
        "VAR c : counter; n : BOOL; t : TON; END_VAR t(Q => NOT n);",
    ),
    ("VAR c : counter; END_VAR c();", "VAR c : counter; END_VAR c.clear();"),
    ("VAR c : counter; n : INT; END_VAR n := c.n;", "VAR c : counter; n : INT; END_VAR n := c.half;"),
    ("VAR c : counter; END_VAR", "VAR c : counter; END_VAR c.half := 3;"),
    ("VAR c : counter; n : INT; END_VAR n := c.n;", "VAR c : counter; n : INT; END_VAR n := c.more(1);"),
    ("VAR n : INT; END_VAR n := n;", "VAR n : INT; p : POINTER TO INT; END_VAR p := ADR(n); p^ := n;"),
];

/// Whole sources that differ by one construct outside of the program's body.
const UNITS: &[(&str, &str)] = &[
    (
        "TYPE t : INT; END_TYPE PROGRAM P VAR v : t; END_VAR END_PROGRAM",
        "TYPE t : INT := 3; END_TYPE PROGRAM P VAR v : t; END_VAR END_PROGRAM",
    ),
    (
        "TYPE t : STRUCT a : INT; END_STRUCT; END_TYPE PROGRAM P VAR v : t; END_VAR END_PROGRAM",
        "TYPE t : STRUCT a : INT := 1; END_STRUCT; END_TYPE PROGRAM P VAR v : t; END_VAR END_PROGRAM",
    ),
    (
        "TYPE t : STRUCT a : INT; b : INT; END_STRUCT; END_TYPE PROGRAM P VAR v : t; END_VAR END_PROGRAM",
        "TYPE t : UNION a : INT; b : INT; END_UNION; END_TYPE PROGRAM P VAR v : t; END_VAR END_PROGRAM",
    ),
    (
        "TYPE b : STRUCT x : INT; END_STRUCT; t : STRUCT a : INT; END_STRUCT; END_TYPE PROGRAM P VAR v : t; END_VAR END_PROGRAM",
        "TYPE b : STRUCT x : INT; END_STRUCT; t EXTENDS b : STRUCT a : INT; END_STRUCT; END_TYPE PROGRAM P VAR v : t; END_VAR END_PROGRAM",
    ),
    (
        "TYPE t : (a, b); END_TYPE PROGRAM P VAR v : t; END_VAR END_PROGRAM",
        "TYPE t : (a := 4, b); END_TYPE PROGRAM P VAR v : t; END_VAR END_PROGRAM",
    ),
    (
        "TYPE t : (a, b); END_TYPE PROGRAM P VAR v : t; END_VAR END_PROGRAM",
        "TYPE t : (a, b) DINT; END_TYPE PROGRAM P VAR v : t; END_VAR END_PROGRAM",
    ),
    (
        "TYPE t : (a, b); END_TYPE PROGRAM P VAR v : t; END_VAR END_PROGRAM",
        "TYPE t : (a, b) := b; END_TYPE PROGRAM P VAR v : t; END_VAR END_PROGRAM",
    ),
    (
        "VAR_GLOBAL g : INT; END_VAR PROGRAM P END_PROGRAM",
        "VAR_GLOBAL RETAIN g : INT; END_VAR PROGRAM P END_PROGRAM",
    ),
    (
        "VAR_GLOBAL g : INT; END_VAR PROGRAM P VAR_EXTERNAL g : INT; END_VAR END_PROGRAM",
        "VAR_GLOBAL g : INT; END_VAR PROGRAM P VAR_EXTERNAL g : DINT; END_VAR END_PROGRAM",
    ),
    ("PROGRAM P END_PROGRAM", "PROGRAM P END_PROGRAM PROGRAM Q END_PROGRAM"),
    (
        "PROGRAM P END_PROGRAM",
        "PROGRAM P END_PROGRAM CONFIGURATION c TASK t(INTERVAL := T#5ms); PROGRAM p1 WITH t : P; END_CONFIGURATION",
    ),
    (
        "PROGRAM P END_PROGRAM CONFIGURATION c TASK t(INTERVAL := T#5ms); PROGRAM p1 WITH t : P; END_CONFIGURATION",
        "PROGRAM P END_PROGRAM CONFIGURATION c TASK t(INTERVAL := T#6ms); PROGRAM p1 WITH t : P; END_CONFIGURATION",
    ),
    (
        "PROGRAM P END_PROGRAM CONFIGURATION c TASK t(INTERVAL := T#5ms); PROGRAM p1 WITH t : P; END_CONFIGURATION",
        "PROGRAM P END_PROGRAM CONFIGURATION c TASK t(INTERVAL := T#5ms, PRIORITY := 3); PROGRAM p1 WITH t : P; END_CONFIGURATION",
    ),
    (
        "PROGRAM P END_PROGRAM CONFIGURATION c VAR_GLOBAL a : INT; END_VAR END_CONFIGURATION",
        "PROGRAM P END_PROGRAM CONFIGURATION c VAR_GLOBAL a : INT := 1; END_VAR END_CONFIGURATION",
    ),
    // What only forbids is seen where it forbids.
    (
        "FUNCTION_BLOCK a END_FUNCTION_BLOCK FUNCTION_BLOCK b EXTENDS a END_FUNCTION_BLOCK PROGRAM P END_PROGRAM",
        "FUNCTION_BLOCK FINAL a END_FUNCTION_BLOCK FUNCTION_BLOCK b EXTENDS a END_FUNCTION_BLOCK PROGRAM P END_PROGRAM",
    ),
    (
        "FUNCTION_BLOCK a END_FUNCTION_BLOCK PROGRAM P VAR i : a; END_VAR i(); END_PROGRAM",
        "FUNCTION_BLOCK ABSTRACT a END_FUNCTION_BLOCK PROGRAM P VAR i : a; END_VAR i(); END_PROGRAM",
    ),
    (
        "FUNCTION_BLOCK a METHOD m END_METHOD END_FUNCTION_BLOCK PROGRAM P VAR i : a; END_VAR i.m(); END_PROGRAM",
        "FUNCTION_BLOCK a METHOD PRIVATE m END_METHOD END_FUNCTION_BLOCK PROGRAM P VAR i : a; END_VAR i.m(); END_PROGRAM",
    ),
    (
        "FUNCTION_BLOCK a METHOD m END_METHOD END_FUNCTION_BLOCK PROGRAM P VAR i : a; END_VAR i.m(); END_PROGRAM",
        "FUNCTION_BLOCK a METHOD PROTECTED m END_METHOD END_FUNCTION_BLOCK PROGRAM P VAR i : a; END_VAR i.m(); END_PROGRAM",
    ),
    (
        "FUNCTION_BLOCK a METHOD m END_METHOD END_FUNCTION_BLOCK FUNCTION_BLOCK b EXTENDS a METHOD m END_METHOD END_FUNCTION_BLOCK PROGRAM P END_PROGRAM",
        "FUNCTION_BLOCK a METHOD FINAL m END_METHOD END_FUNCTION_BLOCK FUNCTION_BLOCK b EXTENDS a METHOD m END_METHOD END_FUNCTION_BLOCK PROGRAM P END_PROGRAM",
    ),
    (
        "FUNCTION_BLOCK a METHOD m END_METHOD END_FUNCTION_BLOCK PROGRAM P END_PROGRAM",
        "FUNCTION_BLOCK a METHOD OVERRIDE m END_METHOD END_FUNCTION_BLOCK PROGRAM P END_PROGRAM",
    ),
    (
        "INTERFACE i METHOD m END_METHOD END_INTERFACE FUNCTION_BLOCK a END_FUNCTION_BLOCK PROGRAM P END_PROGRAM",
        "INTERFACE i METHOD m END_METHOD END_INTERFACE FUNCTION_BLOCK a IMPLEMENTS i END_FUNCTION_BLOCK PROGRAM P END_PROGRAM",
    ),
    (
        "INTERFACE h METHOD m END_METHOD END_INTERFACE INTERFACE i END_INTERFACE FUNCTION_BLOCK a IMPLEMENTS i END_FUNCTION_BLOCK PROGRAM P END_PROGRAM",
        "INTERFACE h METHOD m END_METHOD END_INTERFACE INTERFACE i EXTENDS h END_INTERFACE FUNCTION_BLOCK a IMPLEMENTS i END_FUNCTION_BLOCK PROGRAM P END_PROGRAM",
    ),
    (
        "FUNCTION_BLOCK a VAR_INPUT n : INT; END_VAR n := 1; END_FUNCTION_BLOCK PROGRAM P END_PROGRAM",
        "FUNCTION_BLOCK a VAR_INPUT CONSTANT n : INT; END_VAR n := 1; END_FUNCTION_BLOCK PROGRAM P END_PROGRAM",
    ),
    (
        "FUNCTION_BLOCK a METHOD m VAR n : INT; END_VAR n := n + 1; END_METHOD END_FUNCTION_BLOCK PROGRAM P VAR i : a; END_VAR i.m(); END_PROGRAM",
        "FUNCTION_BLOCK a METHOD m VAR_INST n : INT; END_VAR n := n + 1; END_METHOD END_FUNCTION_BLOCK PROGRAM P VAR i : a; END_VAR i.m(); END_PROGRAM",
    ),
];

#[test]
fn every_construct_shows_in_the_program() {
    let mut ignored = Vec::new();
    let body = |text: &str| format!("{AROUND} PROGRAM MAIN {text} END_PROGRAM");
    for (first, second) in BODIES {
        // The first of each pair is a sound program: a pair of two mistakes would show nothing.
        assert!(result(&body(first)).is_ok(), "{first}: {:?}", result(&body(first)));
        if result(&body(first)) == result(&body(second)) {
            ignored.push(*second);
        }
    }
    for (first, second) in UNITS {
        assert!(result(first).is_ok(), "{first}: {:?}", result(first));
        if result(first) == result(second) {
            ignored.push(*second);
        }
    }
    assert!(ignored.is_empty(), "no difference:\n{}", ignored.join("\n"));
}
