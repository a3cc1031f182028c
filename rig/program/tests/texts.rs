//! Texts from end to end: lengths, cuts, widths, comparison, characters, and the functions at their edges. From IEC
//! 61131-3, tables 34 and 37 (functions, comparison by the codes of the characters from left to right), 6.4.2.2
//! (assignment cuts to the length), and the documents of the controllers' library where positions lie outside.

use crate::support::{Memory, Rig, codes, once};

fn show(rig: &Rig, path: &str) -> String {
    rig.machine.show(path, &mut Memory::default()).unwrap_or_else(|| panic!("no {path}")).to_string()
}

/// The value of a text expression.
fn text(expression: &str) -> String {
    let rig = once(
        "VAR s : STRING := 'hello world'; e : STRING; n, m : INT := -1; w : WSTRING := \"h$00E9llo\"; one : STRING[1] := 'x'; r : STRING(255); END_VAR",
        &format!("r := {expression};"),
    );
    show(&rig, "r")
}

fn wide(expression: &str) -> String {
    let rig = once(
        "VAR s : WSTRING := \"h$20ACllo\"; e : WSTRING; r : WSTRING(255); END_VAR",
        &format!("r := {expression};"),
    );
    show(&rig, "r")
}

fn number(expression: &str) -> i128 {
    let declarations =
        "VAR s : STRING := 'hello world'; e : STRING; w : WSTRING := \"a$20ACb\"; r : DINT; END_VAR";
    once(declarations, &format!("r := {expression};")).int("r")
}

#[test]
fn functions_at_their_edges() {
    for (expression, expected) in [
        ("LEFT(s, 5)", "hello"),
        ("LEFT(s, 0)", ""),
        ("LEFT(s, 11)", "hello world"),
        ("LEFT(s, 100)", "hello world"),
        ("LEFT(s, n)", ""),
        ("LEFT(e, 3)", ""),
        ("RIGHT(s, 5)", "world"),
        ("RIGHT(s, 0)", ""),
        ("RIGHT(s, 100)", "hello world"),
        ("RIGHT(s, n)", ""),
        ("MID(s, 3, 1)", "hel"),
        ("MID(s, 3, 9)", "rld"),
        ("MID(s, 30, 9)", "rld"),
        ("MID(s, 3, 12)", ""),
        ("MID(s, 0, 3)", ""),
        ("MID(s, n, 3)", ""),
        ("MID(STR := s, POS := 7, LEN := 2)", "wo"),
        ("MID(IN := s, L := 2, P := 7)", "wo"),
        ("CONCAT(s, '!')", "hello world!"),
        ("CONCAT(e, e)", ""),
        ("CONCAT('a', 'b', 'c', one, s)", "abcxhello world"),
        ("CONCAT(IN1 := 'a', IN2 := 'b')", "ab"),
        ("INSERT(s, 'XY', 0)", "XYhello world"),
        ("INSERT(s, 'XY', 5)", "helloXY world"),
        ("INSERT(s, 'XY', 11)", "hello worldXY"),
        ("INSERT(s, 'XY', 100)", "hello worldXY"),
        ("INSERT(s, '', 3)", "hello world"),
        ("INSERT(e, 'XY', 0)", "XY"),
        ("DELETE(s, 6, 6)", "hello"),
        ("DELETE(s, 1, 1)", "ello world"),
        ("DELETE(s, 100, 3)", "he"),
        ("DELETE(s, 0, 3)", "hello world"),
        ("DELETE(s, 3, 12)", "hello world"),
        ("DELETE(STR := s, LEN := 2, POS := 3)", "heo world"),
        ("REPLACE(s, 'J', 1, 1)", "Jello world"),
        ("REPLACE(s, 'there', 5, 7)", "hello there"),
        ("REPLACE(s, '', 6, 6)", "hello"),
        ("REPLACE(s, 'X', 0, 6)", "helloX world"),
        ("REPLACE(s, 'X', 100, 6)", "helloX"),
        ("LEFT(CONCAT(RIGHT(s, 5), ' ', s), LEN(s))", "world hello"),
        ("SEL(TRUE, 'no', s)", "hello world"),
        ("MUX(2, 'a', 'bb', 'ccc')", "ccc"),
        ("MAX('abc', 'abd')", "abd"),
        ("MIN('abc', 'ab', 'b')", "ab"),
        ("LIMIT('b', 'a', 'c')", "b"),
    ] {
        assert_eq!(text(expression), format!("'{expected}'"), "{expression}");
    }
    for (expression, expected) in [
        ("LEN(s)", 11),
        ("LEN(e)", 0),
        ("LEN('')", 0),
        ("LEN(w)", 3),
        ("FIND(s, 'o')", 5),
        ("FIND(s, 'world')", 7),
        ("FIND(s, 'World')", 0),
        ("FIND(s, 'hello world!')", 0),
        ("FIND('aaab', 'aab')", 2),
        ("FIND(s, s)", 1),
        ("FIND(w, \"b\")", 3),
        ("SIZEOF(s)", 81),
    ] {
        assert_eq!(number(expression), expected, "{expression}");
    }
    for (expression, expected) in [
        ("LEFT(s, 2)", "h\u{20AC}"),
        ("RIGHT(s, 4)", "\u{20AC}llo"),
        ("MID(s, 1, 2)", "\u{20AC}"),
        ("CONCAT(s, \"$20AC\", e)", "h\u{20AC}llo\u{20AC}"),
        ("INSERT(s, \"--\", 2)", "h\u{20AC}--llo"),
        ("DELETE(s, 1, 2)", "hllo"),
        ("REPLACE(s, \"e\", 1, 2)", "hello"),
    ] {
        assert_eq!(wide(expression), format!("'{expected}'"), "{expression}");
    }
}

#[test]
fn the_greatest_text_computes_each_once() {
    let letters: Vec<String> =
        (b'a'..=b'z').map(|letter| format!("CONCAT('{}', s)", char::from(letter))).collect();
    let mut rig = Rig::new(&format!(
        "FUNCTION next : STRING VAR_INPUT x : STRING; END_VAR n := n + 1; next := CONCAT(x, 'z'); END_FUNCTION
         VAR_GLOBAL n : INT; s, r, t, u : STRING := 'q'; END_VAR
         PROGRAM MAIN r := MAX(next('a'), s, next('zz'), 'c'); t := MAX({}); u := LIMIT(next('b'), s, next('c')); END_PROGRAM",
        letters.join(", ")
    ));
    rig.cycle();
    assert_eq!(rig.int("n"), 4);
    assert_eq!(["r", "t", "u"].map(|path| show(&rig, path)), ["'zzz'", "'zq'", "'cz'"]);
}

#[test]
fn a_text_may_be_its_own_source() {
    for (statement, expected) in [
        ("s := CONCAT(s, s);", "abcabc"),
        ("s := CONCAT('>', s);", ">abc"),
        ("s := RIGHT(s, 2);", "bc"),
        ("s := MID(s, 1, 2);", "b"),
        ("s := INSERT(s, s, 1);", "aabcbc"),
        ("s := DELETE(s, 1, 1);", "bc"),
        ("s := REPLACE(s, s, 1, 2);", "aabcc"),
        ("s := s;", "abc"),
        ("s := SEL(s = 'abc', s, CONCAT(s, 'd'));", "abcd"),
        ("s := CONCAT(LEFT(s, 1), RIGHT(s, 1));", "ac"),
    ] {
        let rig = once("VAR s : STRING := 'abc'; END_VAR", statement);
        assert_eq!(show(&rig, "s"), format!("'{expected}'"), "{statement}");
    }
}

#[test]
fn what_is_too_long_is_cut() {
    let rig = Rig::new(
        "TYPE rec : STRUCT name : STRING[4]; next : INT := 7; END_STRUCT; END_TYPE
         FUNCTION f : STRING[3] VAR_INPUT x : STRING[5]; END_VAR f := CONCAT('<', x); END_FUNCTION
         FUNCTION_BLOCK fb VAR_INPUT x : STRING[2]; END_VAR VAR_OUTPUT y : STRING[6]; END_VAR y := CONCAT(x, x, x, x); END_FUNCTION_BLOCK
         PROGRAM MAIN VAR
           long : STRING(255); short : STRING[3] := 'ab'; after : INT := 1; r : rec; a : ARRAY[0..1] OF STRING[2]; b : fb; out : STRING[3]; from_f : STRING; w : WSTRING[2]; default : STRING; i : INT;
         END_VAR
           short := 'abcdef'; r.name := 'abcdef'; a[0] := 'xyz'; i := 1; a[i] := short;
           from_f := f('1234567'); b(x := 'pqr', y => out); w := \"abc\";
           FOR i := 1 TO 40 DO long := CONCAT(long, '0123456789'); END_FOR;
           default := long;
         END_PROGRAM",
    );
    let mut rig = rig;
    rig.cycle();
    for (path, expected) in [
        ("short", "'abc'"),
        ("r.name", "'abcd'"),
        ("r.next", "7"),
        ("after", "1"),
        ("a[0]", "'xy'"),
        ("a[1]", "'ab'"),
        ("from_f", "'<12'"),
        ("b.x", "'pq'"),
        ("b.y", "'pqpqpq'"),
        ("out", "'pqp'"),
        ("w", "'ab'"),
    ] {
        assert_eq!(show(&rig, path), expected, "{path}");
    }
    assert_eq!(show(&rig, "long").len(), 257);
    // A STRING without a length has 80 characters.
    assert_eq!(show(&rig, "default").len(), 82);
    // The compiler says when a literal is cut.
    let program = crate::support::build("PROGRAM MAIN VAR s : STRING[2]; END_VAR s := 'abc'; END_PROGRAM");
    assert_eq!(program.warnings.iter().map(|w| w.code).collect::<Vec<_>>(), ["S0303"]);
}

#[test]
fn comparison_goes_by_the_codes_of_characters() {
    // In ascending order.
    let ordered =
        ["''", "'A'", "'AB'", "'B'", "'a'", "'ab'", "'abc'", "'ac'", "'b'", "'z'", "'$E9'", "'$FF'"];
    for (nth, a) in ordered.iter().enumerate() {
        for (other, b) in ordered.iter().enumerate() {
            for width in ["STRING", "WSTRING"] {
                let wide = |text: &str| {
                    if width == "STRING" {
                        text.to_string()
                    } else {
                        text.replace('\'', "\"").replace("$E", "$00E").replace("$F", "$00F")
                    }
                };
                let (a, b) = (wide(a), wide(b));
                let rig = once(
                    &format!("VAR x : {width} := {a}; y : {width}[100] := {b}; r : ARRAY[0..5] OF BOOL; t : INT; END_VAR"),
                    "r[0] := x = y; r[1] := x <> y; r[2] := x < y; r[3] := x <= y; r[4] := x > y; r[5] := x >= y;
                     IF x < y THEN t := t + 1; END_IF; IF NOT (x = y) THEN t := t + 10; END_IF; IF LT(x, y) AND NE(x, y) THEN t := t + 100; END_IF;",
                );
                let expected =
                    [nth == other, nth != other, nth < other, nth <= other, nth > other, nth >= other];
                for (place, expected) in expected.into_iter().enumerate() {
                    assert_eq!(rig.on(&format!("r[{place}]")), expected, "{a} {b} {place}");
                }
                let turns = i128::from(nth < other) * 101 + i128::from(nth != other) * 10;
                assert_eq!(rig.int("t"), turns, "{a} {b}");
            }
        }
    }
    // Texts of other lengths are not cut for it.
    let rig = once(
        "VAR s : STRING[3] := 'abc'; t : STRING[5] := 'abcde'; r : ARRAY[0..5] OF BOOL; END_VAR",
        "r[0] := s = 'abcd'; r[1] := 'abcd' = s; r[2] := s < 'abcd'; r[3] := s = t; r[4] := MAX(s, 'abcd') = 'abcd'; r[5] := SEL(TRUE, s, 'abcdef') = 'abcdef';",
    );
    let found = [0, 1, 2, 3, 4, 5].map(|nth| rig.on(&format!("r[{nth}]")));
    assert_eq!(found, [false, false, true, false, true, true]);
    assert_eq!(
        codes("PROGRAM MAIN VAR s : STRING; w : WSTRING; b : BOOL; END_VAR b := s = w; END_PROGRAM"),
        ["S0304"]
    );
}

#[test]
fn characters_of_texts() {
    // The controllers' tool counts them from 0, as BYTE and WORD.
    let rig = once(
        "VAR s : STRING[5] := 'abc'; w : WSTRING[3] := \"x$20ACz\"; b : BYTE; c : CHAR; v : WORD; i, n : INT; t : STRING; END_VAR",
        "b := s[0]; s[1] := 16#58; i := 2; s[i] := s[0]; v := w[1];
         c := 'q'; t := c; IF c = 'q' THEN n := 1; END_IF; IF c < 'r' THEN n := n + 10; END_IF; t := CONCAT(t, c);",
    );
    assert_eq!((rig.int("b"), rig.int("v"), rig.int("n")), (97, 0x20AC, 11));
    assert_eq!((show(&rig, "s").as_str(), show(&rig, "t").as_str()), ("'aXa'", "'qq'"));
    // The place after the last character is the closing 0; further ones are outside.
    let with = |index: &str| {
        let mut rig = Rig::new(&format!(
            "PROGRAM MAIN VAR s : STRING[5] := 'abc'; b : BYTE; i : INT := {index}; END_VAR b := s[i]; END_PROGRAM"
        ));
        rig.run().stop == scanrig_program::StopReason::Done
    };
    assert!(with("0") && with("4") && with("5") && !with("6") && !with("-1"));
}

#[test]
fn escapes() {
    for (literal, units) in [
        ("'$$'", vec![0x24]),
        ("'$''", vec![0x27]),
        ("'$L$l$N$n'", vec![10; 4]),
        ("'$P$p$R$r$T$t'", vec![12, 12, 13, 13, 9, 9]),
        ("'$41$fe'", vec![0x41, 0xFE]),
        ("'\"'", vec![0x22]),
        ("'\u{E9}'", vec![0xE9]),
        ("\"'\"", vec![0x27]),
        ("\"$\"$$\"", vec![0x22, 0x24]),
        ("\"$20AC$0041\"", vec![0x20AC, 0x41]),
        ("\"\u{20AC}\"", vec![0x20AC]),
        ("''", vec![]),
        ("STRING#'ab'", vec![97, 98]),
        ("WSTRING#\"ab\"", vec![97, 98]),
    ] {
        let ty = if literal.contains('\'') && !literal.starts_with('"') && !literal.starts_with('W') {
            "STRING"
        } else {
            "WSTRING"
        };
        let read: String = (0..units.len()).map(|nth| format!("r[{nth}] := s[{nth}]; ")).collect();
        let declarations = format!(
            "VAR s : {ty} := {literal}; t : {ty}; r : ARRAY[0..9] OF WORD; same : BOOL; n : INT; END_VAR"
        );
        let rig = once(
            &declarations,
            &format!("{read} t := {literal}; same := s = t AND s = {literal}; n := LEN(s);"),
        );
        assert!(rig.on("same"), "{literal}");
        assert_eq!(rig.int("n"), units.len() as i128, "{literal}");
        for (nth, unit) in units.iter().enumerate() {
            assert_eq!(rig.int(&format!("r[{nth}]")), *unit, "{literal} {nth}");
        }
    }
    for literal in ["'$4'", "'$x'", "'$", "\"$41\"", "'\u{20AC}'"] {
        let text = format!("PROGRAM MAIN VAR s : STRING; END_VAR s := {literal}; END_PROGRAM");
        assert!(
            codes(&text).iter().any(|code| ["S0110", "S0104"].contains(code)),
            "{literal} {:?}",
            codes(&text)
        );
    }
}

#[test]
fn texts_in_functions_and_blocks() {
    let mut rig = Rig::new(
        "FUNCTION twice : STRING VAR_INPUT x : STRING; n : INT := 2; END_VAR VAR i : INT; END_VAR
           FOR i := 1 TO n DO twice := CONCAT(twice, x); END_FOR;
         END_FUNCTION
         FUNCTION fill : INT VAR_IN_OUT t : STRING; END_VAR t := CONCAT(t, '+'); fill := LEN(t); END_FUNCTION
         FUNCTION_BLOCK log VAR_INPUT line : STRING[10] := 'none'; END_VAR VAR lines : ARRAY[0..2] OF STRING[10]; n : INT; END_VAR
           METHOD last : STRING last := lines[(n + 2) MOD 3]; END_METHOD
           lines[n] := line; n := (n + 1) MOD 3;
         END_FUNCTION_BLOCK
         VAR_GLOBAL CONSTANT greeting : STRING := 'hi'; END_VAR
         PROGRAM MAIN VAR a, b, c : STRING; l : log; n : INT; END_VAR
           a := twice(twice('ab'), 3); l(); l(line := greeting); b := l.last(); l(line := CONCAT(greeting, '!')); c := CONCAT(l.last(), l.lines[0]);
           n := fill(b);
         END_PROGRAM",
    );
    rig.cycle();
    let shown = ["a", "b", "c", "l.lines[0]", "l.lines[2]"].map(|path| show(&rig, path));
    assert_eq!(shown, ["'abababababab'", "'hi+'", "'hi!none'", "'none'", "'hi!'"]);
    assert_eq!(rig.int("n"), 3);
    // The result of a function starts empty at each call.
    rig.cycle();
    assert_eq!(show(&rig, "a"), "'abababababab'");
}
