//! Every operator on every elementary type, at the edges, against a second evaluator. Whole numbers: IEC 61131-3,
//! tables 28 to 33, with results that are cut to the width of the type where they are stored; what they are before that
//! is in promotion.rs. Reals: IEEE 754.

use crate::support::oracle::{Case, WHOLE, check, decimal, limits, literal, seen, width, wrap};
use scanrig_program::Elementary::{self, *};
use signal::Value;

/// Values at and near the limits.
fn edges(ty: Elementary) -> Vec<i128> {
    let (low, high) = limits(ty);
    if low < 0 { vec![low, -7, -1, 0, 2, high] } else { vec![0, 1, 2, 7, high - 1, high] }
}

/// Operators on two whole numbers: whether the result is BOOL, and the result where there is one.
type Whole = (&'static str, bool, fn(i128, i128) -> Option<i128>);

const OPERATORS: [Whole; 17] = [
    ("$a + $b", false, |a, b| Some(a + b)),
    ("$a - $b", false, |a, b| Some(a - b)),
    // The low 64 bits are right whatever happens above 128.
    ("$a * $b", false, |a, b| Some(a.wrapping_mul(b))),
    ("$a / $b", false, |a, b| (b != 0).then(|| a / b)),
    // The sign of MOD is that of the dividend: a - (a / b) * b.
    ("$a MOD $b", false, |a, b| (b != 0).then(|| a - (a / b) * b)),
    ("$a AND $b", false, |a, b| Some(a & b)),
    ("$a & $b", false, |a, b| Some(a & b)),
    ("$a OR $b", false, |a, b| Some(a | b)),
    ("$a XOR $b", false, |a, b| Some(a ^ b)),
    ("$a = $b", true, |a, b| Some(i128::from(a == b))),
    ("$a <> $b", true, |a, b| Some(i128::from(a != b))),
    ("$a < $b", true, |a, b| Some(i128::from(a < b))),
    ("$a <= $b", true, |a, b| Some(i128::from(a <= b))),
    ("$a > $b", true, |a, b| Some(i128::from(a > b))),
    ("$a >= $b", true, |a, b| Some(i128::from(a >= b))),
    ("MIN($a, $b)", false, |a, b| Some(a.min(b))),
    ("MAX($a, $b)", false, |a, b| Some(a.max(b))),
];

fn whole_cases(ty: Elementary) -> Vec<Case> {
    let mut cases = Vec::new();
    for a in edges(ty) {
        let operand = (ty, literal(ty, a));
        let mut one = |text: &str, n: i128| {
            cases.push(Case::new(text, ty, seen(ty, wrap(n, ty)), std::slice::from_ref(&operand)));
        };
        one("NOT $a", !a);
        one("NOT($a)", !a);
        one("ABS($a)", a.abs());
        one("MOVE($a)", a);
        one("+ $a", a);
        if width(ty).1 {
            one("- $a", -a);
            one("- (- $a)", a);
        }
        for b in edges(ty) {
            for (text, truth, operator) in OPERATORS {
                if let Some(n) = operator(a, b) {
                    let result = if truth { Bool } else { ty };
                    let expected = seen(result, wrap(n, result));
                    cases.push(Case::new(text, result, expected, &[operand.clone(), (ty, literal(ty, b))]));
                }
            }
        }
    }
    cases
}

#[test]
fn whole_numbers_in_variables() {
    for ty in WHOLE {
        check(&whole_cases(ty), 0b11);
    }
}

#[test]
fn whole_numbers_computed_by_the_compiler() {
    for ty in WHOLE {
        check(&whole_cases(ty), 0b00);
    }
}

#[test]
fn whole_numbers_beside_literals() {
    for ty in WHOLE {
        let cases: Vec<Case> = whole_cases(ty).into_iter().filter(|case| case.operands.len() == 2).collect();
        check(&cases, 0b01);
        check(&cases, 0b10);
    }
}

#[test]
fn functions_have_the_operators_values() {
    // IEC 61131-3, tables 29 to 33: the same by name.
    let named = [
        ("ADD($a, $b)", 0),
        ("SUB($a, $b)", 1),
        ("MUL($a, $b)", 2),
        ("DIV($a, $b)", 3),
        ("MOD($a, $b)", 4),
        ("AND($a, $b)", 5),
        ("OR($a, $b)", 7),
        ("XOR($a, $b)", 8),
        ("EQ($a, $b)", 9),
        ("NE($a, $b)", 10),
        ("LT($a, $b)", 11),
        ("LE($a, $b)", 12),
        ("GT($a, $b)", 13),
        ("GE(IN1 := $a, IN2 := $b)", 14),
        ("ADD($a, $b, $b)", 17),
        ("MUL($a, $b, $a)", 18),
        ("MAX($a, $b, $a, $b)", 16),
    ];
    let more: [Whole; 2] =
        [("", false, |a, b| Some(a + b + b)), ("", false, |a, b| Some(a.wrapping_mul(b).wrapping_mul(a)))];
    let all: Vec<Whole> = OPERATORS.into_iter().chain(more).collect();
    for ty in [Sint, Uint, Dint, Ulint, Dword] {
        let mut cases = Vec::new();
        for a in edges(ty) {
            for b in edges(ty) {
                for (text, place) in named {
                    let (_, truth, operator) = all[place];
                    let result = if truth { Bool } else { ty };
                    let Some(n) = operator(a, b) else { continue };
                    let operands = [(ty, literal(ty, a)), (ty, literal(ty, b))];
                    cases.push(Case::new(text, result, seen(result, wrap(n, result)), &operands));
                }
            }
        }
        check(&cases, 0b11);
    }
}

#[test]
fn booleans() {
    let operators: [Whole; 9] = [
        ("$a AND $b", true, |a, b| Some(a & b)),
        ("$a OR $b", true, |a, b| Some(a | b)),
        ("$a XOR $b", true, |a, b| Some(a ^ b)),
        ("$a AND_THEN $b", true, |a, b| Some(a & b)),
        ("$a OR_ELSE $b", true, |a, b| Some(a | b)),
        ("$a = $b", true, |a, b| Some(i128::from(a == b))),
        ("$a <> $b", true, |a, b| Some(a ^ b)),
        ("$a > $b", true, |a, b| Some(i128::from(a > b))),
        ("NOT $a", true, |a, _| Some(1 - a)),
    ];
    let mut cases = Vec::new();
    for (a, b) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
        for (text, _, operator) in operators {
            let operands = [(Bool, literal(Bool, a)), (Bool, ["FALSE", "TRUE"][b as usize].into())];
            cases.push(Case::new(text, Bool, seen(Bool, operator(a, b).unwrap()), &operands));
        }
    }
    for variables in 0..4 {
        check(&cases, variables);
    }
}

#[test]
fn shifts_and_rotations() {
    // IEC 61131-3, table 30. Counts at and above the width shift everything out; rotations go on. What the standard
    // leaves open, as the controllers do it: signed numbers keep their sign when they are shifted to the right.
    for ty in WHOLE {
        let (bits, signed) = width(ty);
        let mut cases = Vec::new();
        for value in edges(ty) {
            let plain = value.rem_euclid(1 << bits);
            for count in [0, 1, 3, bits - 1, bits, bits + 1, 2 * bits - 1, 127] {
                let full: i128 = (1 << bits) - 1;
                let turn = count % bits;
                let left = if count < bits { plain << count & full } else { 0 };
                let right = if signed { value >> count } else { plain >> count };
                let rotated = (plain << turn | plain >> (bits - turn)) & full;
                let back = (plain >> turn | plain << (bits - turn)) & full;
                let operands = [(ty, literal(ty, value)), (Usint, literal(Usint, i128::from(count)))];
                let mut add = |text: &str, n: i128| {
                    cases.push(Case::new(text, ty, seen(ty, wrap(n, ty)), &operands));
                };
                add("SHL($a, $b)", left);
                add("ROL($a, $b)", rotated);
                add("ROR(IN := $a, N := $b)", back);
                add("SHR($a, $b)", right);
            }
        }
        for variables in [0b11, 0b00, 0b01] {
            check(&cases, variables);
        }
    }
}

/// Numbers at which rounding, signs and limits show.
fn reals(ty: Elementary) -> Vec<(f64, String)> {
    let single = ty == Real;
    let (max, least) = if single {
        (f64::from(f32::MAX), f64::from(f32::MIN_POSITIVE))
    } else {
        (f64::MAX, f64::MIN_POSITIVE)
    };
    let round = |n: f64| if single { f64::from(n as f32) } else { n };
    let mut all: Vec<(f64, String)> = [0.0, 1.0, -1.5, 0.1, 3.0, 16_777_217.0, max, -max, least]
        .map(|n| (round(n), decimal(ty, n)))
        .to_vec();
    let name = ty.name();
    all.push((-0.0, format!("{name}#-0.0")));
    all.push((f64::INFINITY, format!("inf_{name}")));
    all.push((f64::NEG_INFINITY, format!("-inf_{name}")));
    all.push((f64::NAN, format!("nan_{name}")));
    all
}

type Float = (&'static str, fn(f32, f32) -> f32, fn(f64, f64) -> f64);
type Compared = (&'static str, fn(f64, f64) -> bool);

fn real_cases(ty: Elementary, special: bool) -> Vec<Case> {
    let operators: [Float; 6] = [
        ("$a + $b", |a, b| a + b, |a, b| a + b),
        ("$a - $b", |a, b| a - b, |a, b| a - b),
        ("$a * $b", |a, b| a * b, |a, b| a * b),
        ("$a / $b", |a, b| a / b, |a, b| a / b),
        ("-$a", |a, _| -a, |a, _| -a),
        ("ABS($a)", |a, _| a.abs(), |a, _| a.abs()),
    ];
    // IEEE 754: no relation holds for NaN but <>, and -0.0 equals 0.0.
    let comparisons: [Compared; 6] = [
        ("$a = $b", |a, b| a == b),
        ("$a <> $b", |a, b| a != b),
        ("$a < $b", |a, b| a < b),
        ("$a <= $b", |a, b| a <= b),
        ("$a > $b", |a, b| a > b),
        ("$a >= $b", |a, b| a >= b),
    ];
    let mut cases = Vec::new();
    let values = reals(ty);
    let values: Vec<_> = values.into_iter().filter(|(n, _)| special || n.is_finite()).collect();
    for (a, left) in &values {
        for (b, right) in &values {
            let operands = [(ty, left.clone()), (ty, right.clone())];
            for (text, single, double) in operators {
                // A division by 0 is a fault.
                if text == "$a / $b" && *b == 0.0 {
                    continue;
                }
                let expected =
                    if ty == Real { f64::from(single(*a as f32, *b as f32)) } else { double(*a, *b) };
                cases.push(Case::new(text, ty, Value::Real(expected), &operands));
            }
            for (text, holds) in comparisons {
                cases.push(Case::new(text, Bool, Value::Bool(holds(*a, *b)), &operands));
                let not = format!("NOT ({text})");
                cases.push(Case::new(&not, Bool, Value::Bool(!holds(*a, *b)), &operands));
            }
            if !a.is_nan() && !b.is_nan() && a != b {
                cases.push(Case::new("MIN($a, $b)", ty, Value::Real(a.min(*b)), &operands));
                cases.push(Case::new("MAX($a, $b)", ty, Value::Real(a.max(*b)), &operands));
            }
        }
    }
    cases
}

#[test]
fn reals_in_variables() {
    check(&real_cases(Real, true), 0b11);
    check(&real_cases(Lreal, true), 0b11);
}

#[test]
fn reals_beside_literals() {
    for ty in [Real, Lreal] {
        for variables in [0b00, 0b01, 0b10] {
            check(&real_cases(ty, false), variables);
        }
    }
}

#[test]
fn durations() {
    // The controllers' TIME counts milliseconds in 32 bits without a sign, LTIME nanoseconds in 64.
    let operators: [Whole; 10] = [
        ("$a + $b", false, |a, b| Some(a + b)),
        ("$a - $b", false, |a, b| Some(a - b)),
        ("$a = $b", true, |a, b| Some(i128::from(a == b))),
        ("$a <> $b", true, |a, b| Some(i128::from(a != b))),
        ("$a < $b", true, |a, b| Some(i128::from(a < b))),
        ("$a <= $b", true, |a, b| Some(i128::from(a <= b))),
        ("$a > $b", true, |a, b| Some(i128::from(a > b))),
        ("$a >= $b", true, |a, b| Some(i128::from(a >= b))),
        ("MIN($a, $b)", false, |a, b| Some(a.min(b))),
        ("MAX($a, $b)", false, |a, b| Some(a.max(b))),
    ];
    for (ty, high) in [(Time, limits(Time).1), (Ltime, (1 << 63) - 1)] {
        let mut cases = Vec::new();
        for a in [0, 1, 1500, high / 2, high] {
            for b in [0, 1, 7, high - 1, high] {
                let operands = [(ty, literal(ty, a)), (ty, literal(ty, b))];
                for (text, truth, operator) in operators {
                    let result = if truth { Bool } else { ty };
                    let expected = seen(result, wrap(operator(a, b).unwrap(), result));
                    cases.push(Case::new(text, result, expected, &operands));
                }
            }
            for (number, n) in [(Usint, 3), (Int, 7), (Dint, 100_000), (Ulint, 5)] {
                let operands = [(ty, literal(ty, a)), (number, literal(number, n))];
                let mut add = |text: &str, n: i128| {
                    cases.push(Case::new(text, ty, seen(ty, wrap(n, ty)), &operands));
                };
                add("$a * $b", a * n);
                add("$b * $a", a * n);
                add("$a / $b", a / n);
            }
        }
        for variables in 0..4 {
            check(&cases, variables);
        }
    }
}
