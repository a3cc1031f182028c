//! Operators on pairs of types: which go together, what the result is, and what is refused (S0304). From the rules of
//! IEC 61131-3, 6.6.1.6 (both operands go into one type that holds them) and the tables of its operators, with what
//! the controllers' tool takes beyond: arithmetic on bit strings and bit operators on whole numbers.

use crate::support::oracle::{Case, WHOLE, check, limits, literal, seen, verdicts, wrap};
use scanrig_program::Elementary::{self, *};
use signal::Value;

/// The type in which two types meet.
fn meet(a: Elementary, b: Elementary) -> Option<Elementary> {
    let holds = |ty: Elementary, other: Elementary| {
        let ((low, high), (least, most)) = (limits(ty), limits(other));
        low <= least && most <= high
    };
    let whole = |ty: Elementary| WHOLE.contains(&ty);
    let real = |ty: Elementary| matches!(ty, Real | Lreal);
    let bits = |ty: Elementary| matches!(ty, Byte | Word | Dword | Lword);
    let long = |ty: Elementary| match ty {
        Time => Ltime,
        Date => Ldate,
        Tod => Ltod,
        Dt => Ldt,
        ty => ty,
    };
    match (a, b) {
        _ if a == b => Some(a),
        _ if real(a) && real(b) => Some(Lreal),
        _ if real(a) && whole(b) => Some(a),
        _ if whole(a) && real(b) => Some(b),
        _ if whole(a) && whole(b) => {
            [a, b, Int, Dint, Lint].into_iter().find(|ty| holds(*ty, a) && holds(*ty, b))
        }
        _ if long(a) == long(b) => Some(long(a)),
        (Bool, _) if bits(b) => Some(b),
        (_, Bool) if bits(a) => Some(a),
        _ => None,
    }
}

fn number(ty: Elementary) -> bool {
    WHOLE.contains(&ty) || ty.is_real()
}

/// Dates with what can be added to them, and what their difference is.
const DATES: [(Elementary, Option<Elementary>, Elementary); 6] = [
    (Tod, Some(Time), Time),
    (Dt, Some(Time), Time),
    (Date, None, Time),
    (Ltod, Some(Ltime), Ltime),
    (Ldt, Some(Ltime), Ltime),
    (Ldate, None, Ltime),
];

/// Whether short and long types make one pair of a table: a short one goes into the long one by itself.
fn goes(from: Elementary, to: Elementary) -> bool {
    from == to || matches!((from, to), (Time, Ltime) | (Date, Ldate) | (Tod, Ltod) | (Dt, Ldt))
}

fn added(a: Elementary, b: Elementary) -> bool {
    DATES.into_iter().any(|(date, time, _)| goes(a, date) && time.is_some_and(|time| goes(b, time)))
}

fn subtracted(a: Elementary, b: Elementary) -> bool {
    added(a, b) || DATES.into_iter().any(|(date, ..)| goes(a, date) && goes(b, date))
}

/// Whether an operator takes two types.
fn takes(op: &str, a: Elementary, b: Elementary) -> bool {
    let met = meet(a, b);
    let whole = |ty: Elementary| WHOLE.contains(&ty);
    match op {
        "+" => met.is_some_and(|ty| number(ty) || ty.is_duration()) || added(a, b) || added(b, a),
        "-" => met.is_some_and(|ty| number(ty) || ty.is_duration()) || subtracted(a, b),
        "*" => met.is_some_and(number) || a.is_duration() && number(b) || number(a) && b.is_duration(),
        "/" => met.is_some_and(number) || a.is_duration() && number(b),
        "MOD" => met.is_some_and(whole),
        "**" => number(a) && number(b),
        "AND" | "OR" | "XOR" | "&" => met.is_some_and(|ty| ty == Bool || whole(ty)),
        "AND_THEN" | "OR_ELSE" => a == Bool && b == Bool,
        "=" | "<>" | "<" | "<=" | ">" | ">=" => met.is_some(),
        _ => unreachable!(),
    }
}

const OPERATORS: [&str; 18] = [
    "+", "-", "*", "/", "MOD", "**", "AND", "&", "OR", "XOR", "AND_THEN", "OR_ELSE", "=", "<>", "<", "<=",
    ">", ">=",
];

/// A declaration of a variable for every type, and of one for each text.
fn declarations() -> String {
    let mut text = String::from("VAR_GLOBAL s : STRING; w : WSTRING; p : POINTER TO INT; b : BOOL; ");
    for ty in Elementary::ALL {
        for letter in ["x", "y"] {
            text += &format!("{letter}_{0} : {0}; ", ty.name());
        }
    }
    text + "END_VAR"
}

#[test]
fn which_types_operators_take() {
    let mut statements = Vec::new();
    let mut expected = Vec::new();
    for op in OPERATORS {
        for a in Elementary::ALL {
            for b in Elementary::ALL {
                // SIZEOF takes every type of result.
                statements.push(format!("x_UDINT := SIZEOF(x_{} {op} y_{});", a.name(), b.name()));
                expected.push(takes(op, a, b));
            }
        }
    }
    let mut wrong = Vec::new();
    for ((codes, expected), line) in
        verdicts(&declarations(), &statements).iter().zip(expected).zip(statements)
    {
        // An exponent of 64 bits warns that it becomes LREAL.
        let others = codes.iter().any(|code| !["S0304", "S0306"].contains(code));
        if codes.contains(&"S0304") == expected || others {
            wrong.push(format!("{line} {codes:?}, expected {expected}"));
        }
    }
    assert!(wrong.is_empty(), "{}\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn texts_and_pointers_have_few_operators() {
    let mut statements = Vec::new();
    let mut expected = Vec::new();
    for op in OPERATORS {
        let compares = matches!(op, "=" | "<>" | "<" | "<=" | ">" | ">=");
        for (a, b, fine) in [
            ("s", "s", compares),
            ("w", "w", compares),
            ("s", "w", false),
            ("s", "x_INT", false),
            ("x_BOOL", "s", false),
            // A character is a text of one.
            ("s", "x_CHAR", compares),
            ("x_WCHAR", "w", compares),
            ("w", "x_CHAR", false),
            ("p", "p", compares || op == "-"),
            ("p", "x_INT", compares || matches!(op, "+" | "-")),
            ("p", "x_REAL", false),
            ("p", "s", false),
        ] {
            statements.push(format!("x_UDINT := SIZEOF({a} {op} {b});"));
            expected.push(fine);
        }
    }
    for ((codes, expected), line) in
        verdicts(&declarations(), &statements).iter().zip(expected).zip(statements)
    {
        assert_eq!(codes.is_empty(), expected, "{line} {codes:?}");
        assert!(codes.iter().all(|code| *code == "S0304"), "{line} {codes:?}");
    }
}

#[test]
fn pairs_of_whole_numbers_meet() {
    // The result is of the common type: it goes into such a variable by itself and wraps at its width.
    let mut cases = Vec::new();
    for a in WHOLE {
        for b in WHOLE {
            let Some(ty) = meet(a, b) else { continue };
            for left in [limits(a).0, 7.min(limits(a).1), limits(a).1] {
                for right in [limits(b).0, 3, limits(b).1] {
                    let operands = [(a, literal(a, left)), (b, literal(b, right))];
                    let mut add = |text: &str, result: Elementary, n: i128| {
                        cases.push(Case::new(text, result, seen(result, wrap(n, result)), &operands));
                    };
                    add("$a + $b", ty, left + right);
                    add("$a - $b", ty, left - right);
                    add("$a * $b", ty, left.wrapping_mul(right));
                    if right != 0 {
                        add("$a / $b", ty, left / right);
                        add("$a MOD $b", ty, left % right);
                    }
                    add("$a < $b", Bool, i128::from(left < right));
                    add("$a = $b", Bool, i128::from(left == right));
                    add("$a >= $b", Bool, i128::from(left >= right));
                    add("MAX($a, $b)", ty, left.max(right));
                    // Operators on bits: the narrower one is extended as the number that it is.
                    add("$a XOR $b", ty, left ^ right);
                }
            }
        }
    }
    check(&cases, 0b11);
    check(&cases, 0b00);
}

#[test]
fn literals_take_the_type_beside_them() {
    // A literal that fits takes the other's type; one that does not makes a wider sum.
    for (ty, other, fits, result) in [
        (Sint, "100", true, Sint),
        (Sint, "200", false, Int),
        (Usint, "200", true, Usint),
        (Usint, "-1", false, Int),
        (Int, "40000", false, Dint),
        (Uint, "40000", true, Uint),
        (Uint, "-5", false, Dint),
        (Dint, "3000000000", false, Lint),
        (Word, "16#FFFF", true, Word),
        (Byte, "16#100", false, Int),
        (Real, "1000000", true, Real),
        (Lreal, "7", true, Lreal),
    ] {
        let number: i128 = match other.strip_prefix("16#") {
            Some(digits) => i128::from_str_radix(digits, 16).unwrap(),
            None => other.parse().unwrap(),
        };
        assert_eq!(fits, result == ty);
        let case = |text: &str| {
            if result.is_real() {
                let operand = (ty, format!("{}#1.0", ty.name()));
                return Case::new(text, result, Value::Real(1.0 + number as f64), &[operand]);
            }
            let most = limits(ty).1;
            Case::new(text, result, seen(result, wrap(most + number, result)), &[(ty, literal(ty, most))])
        };
        check(&[case(&format!("$a + {other}")), case(&format!("{other} + $a"))], 1);
    }
}

#[test]
fn reals_meet_whole_numbers() {
    let mut cases = Vec::new();
    for whole in WHOLE {
        for n in [limits(whole).0, 5, limits(whole).1] {
            let operand = (whole, literal(whole, n));
            let single = f64::from(n as f32 + 1.5);
            cases.push(Case::new(
                "$a + $b",
                Real,
                Value::Real(single),
                &[operand.clone(), (Real, "REAL#1.5".into())],
            ));
            let double = 0.5 * n as f64;
            cases.push(Case::new(
                "$b * $a",
                Lreal,
                Value::Real(double),
                &[operand.clone(), (Lreal, "LREAL#0.5".into())],
            ));
            cases.push(Case::new(
                "$b < $a",
                Bool,
                Value::Bool(2.5 < n as f32),
                &[operand, (Real, "REAL#2.5".into())],
            ));
        }
    }
    let operands = [(Real, "REAL#0.1".into()), (Lreal, "LREAL#0.1".into())];
    cases.push(Case::new("$a - $b", Lreal, Value::Real(f64::from(0.1f32) - 0.1), &operands));
    cases.push(Case::new("$a = $b", Bool, Value::Bool(false), &operands));
    for variables in 0..4 {
        check(&cases, variables);
    }
}

/// Seconds since 1970-01-01 of dates worked out with a calendar (`date -u -d ... +%s`).
const LEAP: i128 = 1_709_164_800; // 2024-02-29
const LAST: i128 = 4_294_967_295; // 2106-02-07-06:28:15

#[test]
fn dates_and_durations() {
    let milli = 1_000_000;
    let case = |text: &str, result, n: i128, operands: &[(Elementary, &str)]| {
        let operands: Vec<_> = operands.iter().map(|(ty, text)| (*ty, (*text).to_string())).collect();
        Case::new(text, result, seen(result, n), &operands)
    };
    let day = 86_400;
    let cases = [
        case("$a + $b", Dt, LEAP + day, &[(Dt, "DT#2024-02-28-23:59:59"), (Time, "T#1d1s")]),
        // DT counts whole seconds.
        case("$a + $b", Dt, LEAP, &[(Dt, "DT#2024-02-29-00:00:00"), (Time, "T#999ms")]),
        case("$a + $b", Dt, 0, &[(Dt, "DT#2106-02-07-06:28:15"), (Time, "T#1s")]),
        case("$b + $a", Dt, LEAP, &[(Dt, "DT#2024-02-28-23:59:59"), (Time, "T#1s")]),
        case("$a - $b", Dt, LEAP - 1, &[(Dt, "DT#2024-03-01-00:00:00"), (Time, "T#1d1s")]),
        case("$a - $b", Dt, LAST, &[(Dt, "DT#1970-01-01-00:00:00"), (Time, "T#1s")]),
        case("$a - $b", Time, day * 1000, &[(Date, "D#2024-03-01"), (Date, "D#2024-02-29")]),
        case("$a - $b", Time, 2 * day * 1000, &[(Date, "D#2000-03-01"), (Date, "D#2000-02-28")]),
        case("$a - $b", Time, 1000, &[(Dt, "DT#2024-02-29-00:00:00"), (Dt, "DT#2024-02-28-23:59:59")]),
        case("$a - $b", Time, 10_801_001, &[(Tod, "TOD#03:00:01.001"), (Tod, "TOD#00:00:00")]),
        case("$a + $b", Tod, 3_600_500, &[(Tod, "TOD#00:59:59.5"), (Time, "T#1s")]),
        case("$a - $b", Tod, 0, &[(Tod, "TOD#23:59:59.999"), (Time, "T#23h59m59s999ms")]),
        case("$a < $b", Bool, 1, &[(Date, "D#2024-02-29"), (Date, "D#2024-03-01")]),
        case("$a = $b", Bool, 1, &[(Dt, "DT#2024-02-29-12:30:00"), (Dt, "DT#2024-02-29-12:30:0.0")]),
        case("$a >= $b", Bool, 0, &[(Tod, "TOD#11:59:59.999"), (Tod, "TOD#12:00:00")]),
        case("MAX($a, $b)", Date, LEAP, &[(Date, "D#2024-02-29"), (Date, "D#1970-01-01")]),
        case(
            "$a + $b",
            Ldt,
            LEAP * 1_000_000_000 + 1,
            &[(Ldt, "LDT#2024-02-29-00:00:00"), (Ltime, "LTIME#1ns")],
        ),
        case(
            "$a - $b",
            Ltime,
            1,
            &[(Ldt, "LDT#2024-02-29-00:00:00.000000001"), (Ldt, "LDT#2024-02-29-00:00:00")],
        ),
        case("$a - $b", Ltod, 43_200_000_000_000, &[(Ltod, "LTOD#12:00:00.5"), (Ltime, "LTIME#500ms")]),
        case(
            "$a - $b",
            Ltime,
            31 * day * 1_000_000_000,
            &[(Ldate, "LDATE#2024-02-01"), (Ldate, "LDATE#2024-01-01")],
        ),
        // Short ones go into long ones.
        case("$a + $b", Ltime, 1_500 * milli + 1, &[(Time, "T#1500ms"), (Ltime, "LTIME#1ns")]),
        case("$a < $b", Bool, 1, &[(Time, "T#1500ms"), (Ltime, "LTIME#1500000001ns")]),
        case("$a + $b", Ltod, 3_600_000_000_000, &[(Ltod, "LTOD#00:59:59"), (Time, "T#1s")]),
        case(
            "$a + $b",
            Ldt,
            (LEAP + 1) * 1_000_000_000,
            &[(Dt, "DT#2024-02-29-00:00:00"), (Ltime, "LTIME#1s")],
        ),
        case(
            "$a - $b",
            Ltime,
            1_000_000_000,
            &[(Ldt, "LDT#2024-02-29-00:00:01"), (Dt, "DT#2024-02-29-00:00:00")],
        ),
        // A duration by a real number goes to the nearest unit.
        case("$a * $b", Time, 1_650, &[(Time, "T#1500ms"), (Real, "REAL#1.1")]),
        case("$b * $a", Time, 2_250, &[(Time, "T#1500ms"), (Lreal, "LREAL#1.5")]),
        case("$a / $b", Time, 1_000, &[(Time, "T#1500ms"), (Real, "REAL#1.5")]),
        case("$a / $b", Ltime, 333, &[(Ltime, "LTIME#1us"), (Lreal, "LREAL#3.0")]),
    ];
    for variables in 0..4 {
        check(&cases, variables);
    }
}
