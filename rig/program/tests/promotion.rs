//! Whole numbers of fewer than 32 bits are computed in 32 (decision 64): what the tool's help shows, and every operator
//! in every place where the high bits of its result are seen, against an evaluator of its own.

use crate::support::oracle::{Case, check, limits, literal, register, seen, verdicts, width, wrap};
use crate::support::{Rig, codes, once};
use scanrig_program::Elementary::{self, *};
use signal::Value;
use std::fmt::Write;

/// The types that are promoted.
const SMALL: [Elementary; 6] = [Sint, Usint, Byte, Int, Uint, Word];

#[test]
fn the_examples_of_the_tools_help() {
    // "Operators", overflow and underflow in the data type, examples 1 to 4; rule SA0066 of the static analysis.
    let rig = once(
        "VAR w1 : WORD := 65535; w2, w3 : WORD; d : DWORD; b1, b2, b3, b4, b5, e : BOOL; u : USINT;
            a : ARRAY[0..3] OF BOOL; END_VAR",
        "d := w1 + 1;
        b1 := (w1 + 1) = w2;
        b2 := (w2 - 1) = w1;
        w3 := w1 + 1;
        b3 := w3 = w2;
        b4 := TO_WORD(w1 + 1) = w2;
        b5 := TO_WORD(w2 - 1) = w1;
        e := u - 1 <> 255;",
    );
    assert_eq!(rig.int("MAIN.d"), 65536);
    let truths = ["b1", "b2", "b3", "b4", "b5", "e"].map(|name| rig.on(&format!("MAIN.{name}")));
    assert_eq!(truths, [false, false, true, true, true, true]);
}

fn edges(ty: Elementary) -> Vec<i128> {
    let (low, high) = limits(ty);
    if low < 0 { vec![low, -7, -1, 0, 2, high] } else { vec![0, 1, 2, 7, high - 1, high] }
}

type Operator = (&'static str, fn(i128, i128) -> Option<i128>);

const OPERATORS: [Operator; 12] = [
    ("($a + $b)", |a, b| Some(a + b)),
    ("($a - $b)", |a, b| Some(a - b)),
    ("($a * $b)", |a, b| Some(a * b)),
    ("($a / $b)", |a, b| (b != 0).then(|| a / b)),
    ("($a MOD $b)", |a, b| (b != 0).then(|| a % b)),
    ("(($a + $b) AND $b)", |a, b| Some((a + b) & b)),
    ("(($a + $b) OR $a)", |a, b| Some((a + b) | a)),
    ("($a * $b XOR $b)", |a, b| Some((a * b) ^ b)),
    ("ABS($a - $b)", |a, b| Some((a - b).abs())),
    ("MAX($a + $b, $a, $b)", |a, b| Some((a + b).max(a).max(b))),
    ("MIN($a * $b, $a)", |a, b| Some((a * b).min(a))),
    ("LIMIT($a, $a - $b, $b)", |a, b| Some((a - b).max(a).min(b))),
];

/// An operator and a place where the whole of its result is seen: what is written around it and what comes of the
/// register, with the type of the result.
type Seen = (&'static str, Elementary, fn(Elementary, i128) -> i128);

const PLACES: [Seen; 9] = [
    ("$x", Dint, |_, n| wrap(n, Dint)),
    ("TO_DINT($x)", Dint, |_, n| wrap(n, Dint)),
    ("TO_LINT($x)", Lint, |_, n| n),
    ("$x / 2", Dint, |ty, n| if width(ty).1 { wrap(n / 2, Dint) } else { n / 2 }),
    ("$x = $a", Bool, |_, n| n),
    ("$x > 5", Bool, |_, n| i128::from(n > 5)),
    ("SEL(TRUE, $a, $x) < 100", Bool, |_, n| i128::from(n < 100)),
    ("TO_BOOL($x)", Bool, |_, n| i128::from(n != 0)),
    ("$x MOD 100", Dint, |_, n| n % 100),
];

/// Unsigned operators on values below 0 in between, in the register: as the processor has them.
fn value(ty: Elementary, which: usize, a: i128, b: i128) -> Option<i128> {
    let (text, operator) = OPERATORS[which];
    if width(ty).1 {
        return operator(a, b).map(|n| register(n, ty));
    }
    // What is compared inside of an operator is a register too.
    let r = |n: i128| register(n, ty);
    Some(match text {
        "ABS($a - $b)" => r(a - b),
        "MAX($a + $b, $a, $b)" => r(a + b).max(a).max(b),
        "MIN($a * $b, $a)" => r(a * b).min(a),
        "LIMIT($a, $a - $b, $b)" => r(a - b).max(a).min(b),
        _ => r(operator(a, b)?),
    })
}

#[test]
fn every_operator_where_its_high_bits_are_seen() {
    for ty in SMALL {
        let mut cases = Vec::new();
        for a in edges(ty) {
            for b in edges(ty) {
                for (which, operator) in OPERATORS.iter().enumerate() {
                    let Some(n) = value(ty, which, a, b) else { continue };
                    for (place, result, of) in PLACES {
                        let text = place.replace("$x", operator.0);
                        let expected = match place {
                            "$x = $a" => i128::from(n == a),
                            _ => of(ty, n),
                        };
                        let operands = [(ty, literal(ty, a)), (ty, literal(ty, b))];
                        cases.push(Case::new(&text, result, seen(result, wrap(expected, result)), &operands));
                    }
                }
            }
        }
        check(&cases, 0b11);
        check(&cases, 0b00);
        check(&cases, 0b10);
    }
}

#[test]
fn negation_of_the_least_number_is_whole() {
    for (ty, low) in [("SINT", -128), ("INT", -32768)] {
        let rig = once(
            &format!("VAR x : {ty} := {low}; d, e : DINT; b : BOOL; r : REAL; END_VAR"),
            "d := -x; e := ABS(x); b := -x > 0; r := -x;",
        );
        assert_eq!(rig.int("MAIN.d"), -low);
        assert_eq!(rig.int("MAIN.e"), -low);
        assert!(rig.on("MAIN.b"));
        assert_eq!(rig.read("MAIN.r"), Value::Real(-low as f64));
    }
}

#[test]
fn a_store_a_parameter_and_a_conversion_cut() {
    let mut rig = Rig::new(
        "FUNCTION same : DINT VAR_INPUT x : USINT; END_VAR same := x; END_FUNCTION
        FUNCTION_BLOCK twice VAR_INPUT x : USINT; END_VAR VAR_OUTPUT y : DINT; END_VAR y := x; END_FUNCTION_BLOCK
        PROGRAM MAIN VAR u : USINT := 255; w : WORD; s : STRING; d, f, g, h, k : DINT; n : twice; END_VAR
        w := u + 1; d := TO_USINT(u + 1); f := same(u + 1); n(x := u + 1); g := n.y;
        s := USINT_TO_STRING(u + 1); h := SHR(u + 1, 1); k := NOT u; END_PROGRAM",
    );
    rig.cycle();
    assert_eq!(rig.int("MAIN.w"), 256);
    for name in ["d", "f", "g", "h", "k"] {
        assert_eq!(rig.int(&format!("MAIN.{name}")), 0, "{name}");
    }
}

#[test]
fn indices_and_selectors_are_whole() {
    let rig = once(
        "VAR u : USINT := 255; i : INT; a : ARRAY[0..300] OF INT; c, m : INT; t : TIME; END_VAR",
        "a[u + 1] := 7; i := a[256];
        CASE u + 1 OF 0: c := 1; ELSE c := 2; END_CASE;
        m := MUX(u + 1, 10, 20, 30);
        t := T#1ms * (u + 1);",
    );
    assert_eq!(rig.int("MAIN.a[256]"), 7);
    assert_eq!(rig.int("MAIN.c"), 2);
    assert_eq!(rig.int("MAIN.m"), 30);
    assert_eq!(rig.int("MAIN.t"), 256_000_000);
}

#[test]
fn mixed_types_and_long_chains_keep_their_bits() {
    // More operands than are kept in one row.
    let mut chain = String::from("u");
    for _ in 0..450 {
        write!(chain, " + u").unwrap();
    }
    let rig = once(
        "VAR u : USINT := 255; s : SINT := -128; w : WORD := 65535; i : INT := 32767; d, e, f, g : DINT; l : LINT;
            b : BOOL; END_VAR",
        &format!("d := {chain}; b := {chain} = 115005; e := w + (u + u); f := s * s; g := (u + u) * (u + u); l := i * i;"),
    );
    assert_eq!(rig.int("MAIN.d"), 451 * 255);
    assert!(rig.on("MAIN.b"));
    assert_eq!(rig.int("MAIN.e"), 65535 + 510);
    assert_eq!(rig.int("MAIN.f"), 16384);
    assert_eq!(rig.int("MAIN.g"), 510 * 510);
    assert_eq!(rig.int("MAIN.l"), 32767 * 32767);
}

#[test]
fn numbers_of_32_bits_and_more_wrap_at_their_own_width() {
    // Rule SA0130: an extension comes after the operation.
    let rig = once(
        "VAR d : DINT := 2147483647; u : UDINT := 4294967295; l, m : LINT; b : BOOL; END_VAR",
        "l := d + 1; m := u + 1; b := d + 1 < 0;",
    );
    assert_eq!(rig.int("MAIN.l"), -2147483648);
    assert_eq!(rig.int("MAIN.m"), 0);
    assert!(rig.on("MAIN.b"));
}

#[test]
fn a_difference_that_does_not_wrap_is_warned_of() {
    let declarations = "VAR_GLOBAL now, last : UINT; a, b : USINT; i, j : INT; d : DINT; l : LINT; r : REAL; x : BOOL; END_VAR";
    let cases = [
        ("x := now - last >= 1000;", true),
        ("IF (a - b) MOD 10 = 0 THEN x := TRUE; END_IF;", true),
        ("l := a - b;", true),
        ("r := a - b;", true),
        ("now := MAX(now - last, 5);", true),
        ("x := TO_UINT(now - last) >= 1000;", false),
        ("x := (now - last AND 16#FF) = 3;", false),
        ("d := a - b;", false),
        ("x := i - j > 5;", false),
        ("now := now - last;", false),
        ("x := a + b > 255;", false),
    ];
    let statements: Vec<String> = cases.iter().map(|(text, _)| text.to_string()).collect();
    for ((text, warned), found) in cases.iter().zip(verdicts(declarations, &statements)) {
        assert_eq!(found.contains(&"S0309"), *warned, "{text}: {found:?}");
    }
    assert!(codes("PROGRAM MAIN VAR x : BOOL; a : UINT; END_VAR x := a - 1 > 5; END_PROGRAM").is_empty());
}
