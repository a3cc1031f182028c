//! Conversions: every name against a table of its own, and which types go into which by themselves. Values: IEC
//! 61131-3, 6.6.2.5.2 (reals to the nearest, ties to even; bit strings and whole numbers by their bits, the high ones
//! cut off), and that the controllers' times and dates count milliseconds and seconds as numbers.

use crate::support::oracle::{Case, WHOLE, check, decimal, limits, literal, seen, verdicts, width, wrap};
use crate::support::{Memory, once};
use scanrig_program::Elementary::{self, *};
use signal::Value;

/// What is converted: the number that it counts as, and its literal.
#[derive(Clone, Debug)]
struct Sample(Number, String);

#[derive(Clone, Copy, Debug)]
enum Number {
    Whole(i128),
    Float(f64),
}

use Number::{Float, Whole};

fn samples(ty: Elementary) -> Vec<Sample> {
    let given = |all: &[(i128, &str)]| {
        all.iter().map(|(n, text)| Sample(Whole(*n), (*text).to_string())).collect::<Vec<_>>()
    };
    let day = 86_400_i128;
    match ty {
        Bool => given(&[(0, "FALSE"), (1, "TRUE")]),
        Char => given(&[(65, "CHAR#'A'"), (255, "CHAR#'$FF'")]),
        Wchar => given(&[(65, "WCHAR#\"A\""), (0x20AC, "WCHAR#\"$20AC\"")]),
        Time => given(&[(0, "T#0s"), (1_500, "T#1.5s"), (4_294_967_295, "T#49d17h2m47s295ms")]),
        Ltime => given(&[
            (0, "LTIME#0s"),
            (1_999_999, "LTIME#1999999ns"),
            ((1 << 62) + 1, "LTIME#4611686018427387905ns"),
        ]),
        Date => given(&[(0, "D#1970-01-01"), (19_782 * day, "D#2024-02-29"), (49_709 * day, "D#2106-02-06")]),
        Dt => given(&[(1, "DT#1970-01-01-00:00:01"), (19_782 * day + 45_296, "DT#2024-02-29-12:34:56")]),
        Tod => {
            given(&[(0, "TOD#00:00:00"), (45_296_789, "TOD#12:34:56.789"), (86_399_999, "TOD#23:59:59.999")])
        }
        Ldate => given(&[(19_782 * day * 1_000_000_000, "LDATE#2024-02-29")]),
        Ldt => given(&[((19_782 * day + 45_296) * 1_000_000_000 + 7, "LDT#2024-02-29-12:34:56.000000007")]),
        Ltod => given(&[(45_296_000_000_007, "LTOD#12:34:56.000000007")]),
        Real | Lreal => [0.0, 0.5, 1.5, 2.5, -0.5, -1.5, 126.5, 100.0, 0.1, -100.49]
            .into_iter()
            .map(|n| Sample(Float(if ty == Real { f64::from(n as f32) } else { n }), decimal(ty, n)))
            .collect(),
        _ => {
            let (low, high) = limits(ty);
            let all = [low, 0, 1, 100, high / 2 + 1, high];
            all.into_iter().map(|n| Sample(Whole(n), literal(ty, n))).collect()
        }
    }
}

/// Nanoseconds that one unit of a type counts.
fn unit(ty: Elementary) -> Option<i128> {
    match ty {
        Time | Tod => Some(1_000_000),
        Date | Dt => Some(1_000_000_000),
        Ltime | Ldate | Ltod | Ldt => Some(1),
        _ => None,
    }
}

/// The value in another type; `None` where the standard and the documents say nothing.
fn converted(from: Elementary, to: Elementary, number: Number) -> Option<Value> {
    let day = 86_400_000_000_000;
    match number {
        _ if to == Bool => Some(Value::Bool(match number {
            Whole(n) => n != 0,
            Float(n) => n != 0.0,
        })),
        Float(n) if to == Real => Some(Value::Real(f64::from(n as f32))),
        Float(n) if to == Lreal => Some(Value::Real(n)),
        Float(n) => {
            let down = n.floor();
            let rest = n - down;
            let up = rest > 0.5 || rest == 0.5 && down.rem_euclid(2.0) == 1.0;
            let rounded = down as i128 + i128::from(up);
            let (low, high) = limits(to);
            (low <= rounded && rounded <= high).then(|| seen(to, rounded))
        }
        Whole(n) if to == Real => Some(Value::Real(f64::from(n as f32))),
        Whole(n) if to == Lreal => Some(Value::Real(n as f64)),
        Whole(n) => match (unit(from), unit(to)) {
            (Some(a), Some(b)) => {
                let nanos = n * a;
                let nanos = match (from, to) {
                    (Time | Ltime, Time | Ltime) => nanos,
                    (Dt | Ldt, Dt | Ldt) => nanos,
                    (Date | Ldate, Date | Ldate | Dt | Ldt) => nanos,
                    (Tod | Ltod, Tod | Ltod | Time | Ltime) => nanos,
                    (Dt | Ldt, Date | Ldate) => nanos / day * day,
                    (Dt | Ldt, Tod | Ltod) => nanos % day,
                    _ => return None,
                };
                Some(seen(to, wrap(nanos / b, to)))
            }
            _ => Some(seen(to, wrap(n, to))),
        },
    }
}

#[test]
fn every_conversion_has_its_value() {
    let mut cases = Vec::new();
    let mut silent = 0;
    for from in Elementary::ALL {
        for to in Elementary::ALL {
            for Sample(number, text) in samples(from) {
                let operands = [(from, text)];
                let Some(expected) = converted(from, to, number) else {
                    silent += 1;
                    continue;
                };
                cases.push(Case::new(
                    &format!("{}_TO_{}($a)", from.name(), to.name()),
                    to,
                    expected,
                    &operands,
                ));
                cases.push(Case::new(&format!("TO_{}($a)", to.name()), to, expected, &operands));
            }
        }
    }
    assert!(cases.len() > 4_000 && silent < 700, "{} {silent}", cases.len());
    check(&cases, 0b1);
    check(&cases, 0b0);
}

#[test]
fn every_name_compiles() {
    let short = |ty: Elementary| match ty {
        Tod => "TOD",
        Dt => "DT",
        Ltod => "LTOD",
        Ldt => "LDT",
        ty => ty.name(),
    };
    let mut declarations = String::from("VAR_GLOBAL x_STRING : STRING; x_WSTRING : WSTRING; ");
    let mut names =
        vec![("STRING".to_string(), "STRING".to_string()), ("WSTRING".to_string(), "WSTRING".to_string())];
    for ty in Elementary::ALL {
        declarations += &format!("x_{0} : {0}; ", ty.name());
        names.push((ty.name().to_string(), short(ty).to_string()));
    }
    declarations += "END_VAR";
    let mut statements = Vec::new();
    for (from, from_short) in &names {
        for (to, to_short) in &names {
            let text = from.contains("STRING") && to.contains("STRING");
            // Characters and texts of the two widths: the standard names the text conversions only.
            if !text || from != to {
                statements.push(format!("x_{to} := {from}_TO_{to}(x_{from});"));
                statements.push(format!("x_{to} := {from_short}_TO_{to_short}(x_{from});"));
            }
            statements.push(format!("x_{to} := TO_{to_short}(x_{from});"));
            statements.push(format!("x_{to} := ANY_TO_{to}(IN := x_{from});"));
        }
    }
    for (line, codes) in statements.iter().zip(verdicts(&declarations, &statements)) {
        assert_eq!(codes, Vec::<&str>::new(), "{line}");
    }
}

#[test]
fn truncation_goes_towards_zero() {
    let mut cases = Vec::new();
    for from in [Real, Lreal] {
        for n in [0.0, 0.9, 1.5, 2.5, 99.99, -0.9, -1.5, -2.5] {
            let operands = [(from, decimal(from, n))];
            for to in WHOLE {
                if n < 0.0 && !width(to).1 {
                    continue;
                }
                let expected = seen(to, n as i128);
                cases.push(Case::new(
                    &format!("{}_TRUNC_{}($a)", from.name(), to.name()),
                    to,
                    expected,
                    &operands,
                ));
                cases.push(Case::new(&format!("TRUNC_{}($a)", to.name()), to, expected, &operands));
            }
            cases.push(Case::new("TRUNC($a)", Dint, seen(Dint, n as i128), &operands));
        }
    }
    check(&cases, 1);
    check(&cases, 0);
}

#[test]
fn decimals_in_bits() {
    let case = |text: &str, ty, n, operand: (Elementary, &str)| {
        Case::new(text, ty, seen(ty, n), &[(operand.0, operand.1.to_string())])
    };
    let cases = [
        case("BCD_TO_INT($a)", Int, 42, (Byte, "BYTE#16#42")),
        case("WORD_BCD_TO_UINT($a)", Uint, 9_999, (Word, "WORD#16#9999")),
        case("BCD_TO_UDINT($a)", Udint, 12_345_678, (Dword, "DWORD#16#1234_5678")),
        case("UINT_TO_BCD_WORD($a)", Word, 0x9999, (Uint, "UINT#9999")),
        case("TO_BCD_BYTE($a)", Byte, 0x42, (Usint, "USINT#42")),
        case("UDINT_TO_BCD_DWORD($a)", Dword, 0x1234_5678, (Udint, "UDINT#12345678")),
    ];
    check(&cases, 1);
    check(&cases, 0);
}

#[test]
fn values_become_texts_and_texts_values() {
    let show = |declarations: &str, statement: &str| {
        let rig = once(declarations, statement);
        rig.machine.show("r", &mut Memory::default()).unwrap().to_string()
    };
    // The form of the language's literals, numbers in decimal.
    for (ty, literal, text) in [
        ("BOOL", "TRUE", "TRUE"),
        ("SINT", "-128", "-128"),
        ("ULINT", "18446744073709551615", "18446744073709551615"),
        ("LINT", "-9223372036854775808", "-9223372036854775808"),
        ("WORD", "16#FFFF", "65535"),
        ("REAL", "1.5", "1.5"),
        ("LREAL", "-0.25", "-0.25"),
        ("TIME", "T#1d2h3m4s5ms", "T#1d2h3m4s5ms"),
        ("DATE", "D#2024-02-29", "D#2024-02-29"),
        ("TOD", "TOD#12:34:56.789", "TOD#12:34:56.789"),
        ("DT", "DT#2024-02-29-12:34:56", "DT#2024-02-29-12:34:56"),
        ("CHAR", "'x'", "x"),
    ] {
        let declarations = format!("VAR v : {ty} := {literal}; r : STRING; END_VAR");
        assert_eq!(show(&declarations, &format!("r := {ty}_TO_STRING(v);")), format!("'{text}'"));
        let wide = declarations.replace("STRING", "WSTRING");
        assert_eq!(show(&wide, "r := TO_WSTRING(v);"), format!("'{text}'"));
        let back = format!("VAR s : STRING := '{text}'; v, r : {ty}; same : BOOL; END_VAR");
        let rig = once(&back, &format!("v := {literal}; r := STRING_TO_{ty}(s); same := v = r;"));
        assert!(rig.on("same"), "{text} as {ty}");
    }
    // What does not fit is cut off.
    assert_eq!(show("VAR v : DINT := -123456; r : STRING[4]; END_VAR", "r := DINT_TO_STRING(v);"), "'-123'");
    assert_eq!(show("VAR s : STRING := 'abc'; r : WSTRING; END_VAR", "r := STRING_TO_WSTRING(s);"), "'abc'");
    assert_eq!(
        show("VAR s : WSTRING := \"a$20ACc\"; r : STRING; END_VAR", "r := WSTRING_TO_STRING(s);"),
        "'a?c'"
    );
    assert_eq!(show("VAR s : STRING := '  42abc'; r : INT; END_VAR", "r := STRING_TO_INT(s);"), "42");
    assert_eq!(show("VAR s : STRING := '16#FF'; r : INT; END_VAR", "r := STRING_TO_INT(s);"), "255");
    assert_eq!(show("VAR s : STRING := '-1.5E3'; r : REAL; END_VAR", "r := STRING_TO_REAL(s);"), "-1500.0");
}

/// How a type goes into another by itself.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Implicit {
    Silent,
    /// S0306.
    Warned,
    /// S0302.
    Refused,
}

/// IEC 61131-3, figure 11. Beyond it, as in the controllers' tool: with a warning between signed and unsigned of one
/// width, from LREAL to REAL and from whole numbers of which digits may be lost; between bit strings and numbers.
fn implicit(from: Elementary, to: Elementary) -> Implicit {
    let whole = |ty: Elementary| WHOLE.contains(&ty);
    let lossless = |bits: u32| if bits > 32 { Implicit::Warned } else { Implicit::Silent };
    match (from, to) {
        _ if from == to => Implicit::Silent,
        _ if whole(from) && whole(to) => {
            let ((low, high), (least, most)) = (limits(to), limits(from));
            match (low <= least && most <= high, width(from).0 == width(to).0) {
                (true, _) => Implicit::Silent,
                (false, true) => Implicit::Warned,
                _ => Implicit::Refused,
            }
        }
        (_, Real) if whole(from) => lossless(2 * width(from).0),
        (_, Lreal) if whole(from) => lossless(width(from).0),
        (Lreal, Real) => Implicit::Warned,
        (Real, Lreal) | (Time, Ltime) | (Date, Ldate) | (Tod, Ltod) | (Dt, Ldt) => Implicit::Silent,
        (Bool, Byte | Word | Dword | Lword) => Implicit::Silent,
        _ => Implicit::Refused,
    }
}

#[test]
fn which_types_go_into_which_by_themselves() {
    // An assignment, an initial value, an input, a result and a member of an array follow one rule.
    let mut declarations = String::new();
    for ty in Elementary::ALL {
        let name = ty.name();
        declarations += &format!("FUNCTION f_{name} : BOOL VAR_INPUT v : {name}; END_VAR ; END_FUNCTION ");
        declarations += &format!("FUNCTION_BLOCK b_{name} VAR_INPUT v : {name}; END_VAR END_FUNCTION_BLOCK ");
    }
    declarations += "VAR_GLOBAL ";
    for ty in Elementary::ALL {
        declarations +=
            &format!("x_{0}, y_{0} : {0}; a_{0} : ARRAY[0..1] OF {0}; i_{0} : b_{0}; ", ty.name());
    }
    declarations += "s : STRING; w : WSTRING; ok : BOOL; END_VAR";
    let mut statements = Vec::new();
    let mut expected = Vec::new();
    for from in Elementary::ALL {
        for to in Elementary::ALL {
            let (a, b) = (from.name(), to.name());
            for statement in [
                format!("y_{b} := x_{a};"),
                format!("a_{b}[1] := x_{a};"),
                format!("ok := f_{b}(x_{a});"),
                format!("ok := f_{b}(v := x_{a});"),
                format!("i_{b}(v := x_{a});"),
                format!("i_{b}.v := x_{a};"),
            ] {
                statements.push(statement);
                expected.push(implicit(from, to));
            }
        }
        let text = |width: Elementary| if from == width { Implicit::Silent } else { Implicit::Refused };
        statements.push(format!("s := x_{};", from.name()));
        expected.push(text(Char));
        statements.push(format!("w := x_{};", from.name()));
        expected.push(text(Wchar));
        for other in ["s", "w"] {
            statements.push(format!("x_{} := {other};", from.name()));
            expected.push(Implicit::Refused);
        }
    }
    for text in ["s := w;", "w := s;"] {
        statements.push(text.into());
        expected.push(Implicit::Refused);
    }
    let mut wrong = Vec::new();
    for ((line, codes), expected) in statements.iter().zip(verdicts(&declarations, &statements)).zip(expected)
    {
        let codes_expected: &[&str] = match expected {
            Implicit::Silent => &[],
            Implicit::Warned => &["S0306"],
            Implicit::Refused => &["S0302"],
        };
        if codes != codes_expected {
            wrong.push(format!("{line} {codes:?}, expected {expected:?}"));
        }
    }
    assert!(wrong.is_empty(), "{}\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn implicit_conversions_keep_the_number() {
    let mut cases = Vec::new();
    for from in Elementary::ALL {
        for to in Elementary::ALL {
            if implicit(from, to) == Implicit::Refused {
                continue;
            }
            for Sample(number, text) in samples(from) {
                let expected = converted(from, to, number).unwrap();
                cases.push(Case::new("$a", to, expected, &[(from, text)]));
            }
        }
    }
    check(&cases, 1);
}

#[test]
fn powers_of_whole_numbers_have_the_digits_of_an_lreal() {
    // The tool's help: EXPT of whole numbers gives an LREAL. REAL holds 24 bits.
    let rig = once(
        "VAR i : INT := 3; j : INT := 16; u : USINT := 7; d, e, f : DINT; l : LREAL; END_VAR",
        "d := LREAL_TO_DINT(i ** j); e := TO_DINT(EXPT(u, 10)); l := EXPT(3, 33); f := TO_DINT(i ** 17);",
    );
    assert_eq!((rig.int("d"), rig.int("e"), rig.int("f")), (43_046_721, 282_475_249, 129_140_163));
    assert_eq!(rig.read("l"), Value::Real(5_559_060_566_555_523.0));
}
