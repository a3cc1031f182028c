//! Expected values come from the standard, the documents of the controllers' Standard library and IEEE 754, or from
//! characters counted one by one.

use super::Accepts::Exact;
use super::*;
use crate::library::numeric::power;
use crate::types::Elementary::*;
use proptest::prelude::*;
use std::f64::consts::{E, FRAC_PI_2, FRAC_PI_4, LN_10, LOG10_2, SQRT_2};

/// A call of a function without texts.
fn call(name: &str, ty: Elementary, cells: &[i64]) -> i64 {
    match find(name).unwrap().body {
        Body::Scalar(body) => body(ty, cells),
        Body::Quotient(body) => body(ty, cells).unwrap(),
        Body::Text(_) | Body::Clock(_) | Body::Service(_) => panic!("{name}"),
    }
}

/// A call of a function of texts: the text that it gives, and the cell.
fn call_text(name: &str, texts: &[&str], cells: &[i64], room: usize) -> (String, i64) {
    let Body::Text(body) = find(name).unwrap().body else { panic!("{name}") };
    let texts: Vec<Text<'_>> = texts.iter().map(|t| Text { wide: false, bytes: t.as_bytes() }).collect();
    // What was there before must not show.
    let mut bytes = vec![0xAA; room + 1];
    let mut call = TextCall {
        texts: &texts,
        cells,
        out: TextOut { wide: false, bytes: &mut bytes, length: 0 },
        result: 0,
    };
    body(&mut call);
    let (length, result) = (call.out.length, call.result);
    let end = bytes.iter().position(|byte| *byte == 0).unwrap_or(0);
    if !matches!(find(name).unwrap().gives, Gives::Exact(_)) {
        assert_eq!(length, end, "{name}");
    }
    (bytes[..length].iter().map(|byte| char::from(*byte)).collect(), result)
}

fn text(name: &str, texts: &[&str], cells: &[i64]) -> String {
    call_text(name, texts, cells, 255).0
}

fn lreal(number: f64) -> i64 {
    number.to_bits() as i64
}

fn real(number: f32) -> i64 {
    i64::from(number.to_bits())
}

#[test]
fn names_are_unique_and_found() {
    let all: Vec<_> = names().collect();
    for (place, name) in all.iter().enumerate() {
        assert!(!all[..place].contains(name), "{name}");
        assert_eq!(find(name).unwrap().name, *name);
        assert_eq!(*name, name.to_uppercase());
        let parameters = find(name).unwrap().parameters;
        for (place, (parameter, _)) in parameters.iter().enumerate() {
            assert_eq!(find(name).unwrap().parameter(parameter), Some(place), "{name}.{parameter}");
        }
    }
    assert!(find("CEIL").is_none() && find("").is_none());
}

#[test]
fn parameters_have_two_names() {
    // IEC 61131-3 ed. 3, table 34, and the controllers' Standard library.
    let place = |function, parameter| find(function).unwrap().parameter(parameter);
    assert_eq!(place("LEFT", "SIZE"), Some(1));
    assert_eq!(place("LEFT", "L"), Some(1));
    assert_eq!(place("MID", "P"), Some(2));
    assert_eq!(place("MID", "POS"), Some(2));
    assert_eq!(place("REPLACE", "IN2"), Some(1));
    assert_eq!(place("REPLACE", "L"), Some(2));
    assert_eq!(place("CONCAT", "IN1"), Some(0));
    assert_eq!(place("CONCAT", "STR12"), Some(11));
    assert_eq!(place("CONCAT", "IN0"), None);
    assert_eq!(place("CONCAT", "IN"), None);
    assert_eq!(place("FIND", "L"), None);
    assert_eq!(place("SQRT", "X"), None);
}

#[test]
fn numbers() {
    // Constants of mathematics; the error is at most one unit in the last place of 17.
    for (name, number, result) in [
        ("SQRT", 2.0, SQRT_2),
        ("LN", 10.0, LN_10),
        ("LN", 1.0, 0.0),
        ("LOG", 1000.0, 3.0),
        ("LOG", 2.0, LOG10_2),
        ("EXP", 1.0, E),
        ("EXP", 0.0, 1.0),
        ("SIN", 1.0, 0.841_470_984_807_896_5),
        ("COS", 1.0, 0.540_302_305_868_139_8),
        ("TAN", 1.0, 1.557_407_724_654_902_3),
        ("ASIN", 1.0, FRAC_PI_2),
        ("ACOS", 0.0, FRAC_PI_2),
        ("ATAN", 1.0, FRAC_PI_4),
    ] {
        let found = f64::from_bits(call(name, Lreal, &[lreal(number)]) as u64);
        assert!((found - result).abs() <= result.abs() * f64::EPSILON, "{name}({number}) = {found}");
        let found = f32::from_bits(call(name, Real, &[real(number as f32)]) as u32);
        assert_eq!(found, result as f32, "{name}({number}) as REAL");
    }
    // IEEE 754, 9.2.1: domains and poles.
    const NAN: i64 = 0x7FF8_0000_0000_0000;
    for (name, number, result) in [
        ("SQRT", -1.0, NAN),
        ("SQRT", -0.0, lreal(-0.0)),
        ("SQRT", f64::INFINITY, lreal(f64::INFINITY)),
        ("LN", 0.0, lreal(f64::NEG_INFINITY)),
        ("LN", -1.0, NAN),
        ("LOG", 0.0, lreal(f64::NEG_INFINITY)),
        ("EXP", 1000.0, lreal(f64::INFINITY)),
        ("EXP", -1000.0, 0),
        ("SIN", f64::INFINITY, NAN),
        ("COS", f64::NEG_INFINITY, NAN),
        ("ASIN", 1.5, NAN),
        ("ACOS", -1.5, NAN),
        ("SIN", -f64::NAN, NAN),
    ] {
        assert_eq!(call(name, Lreal, &[lreal(number)]), result, "{name}({number})");
    }
    assert_eq!(call("SQRT", Real, &[real(-1.0)]), 0x7FC0_0000);
    assert_eq!(call("EXP", Real, &[real(89.0)]), real(f32::INFINITY), "too large for REAL only");
    let angle = call("ATAN2", Lreal, &[lreal(1.0), lreal(-1.0)]);
    assert_eq!(f64::from_bits(angle as u64), 3.0 * FRAC_PI_4, "3/4 pi: Y comes first");
}

#[test]
fn powers() {
    let expt = |base: f64, exponent: f64| {
        f64::from_bits(call("EXPT", Lreal, &[lreal(base), lreal(exponent)]) as u64)
    };
    // Powers that a double holds are exact: against products of whole numbers.
    for base in -30i128..=30 {
        let mut product: i128 = 1;
        for exponent in 0..40 {
            if product.abs() > 1 << 53 {
                break;
            }
            assert_eq!(expt(base as f64, f64::from(exponent)), product as f64, "{base}^{exponent}");
            product *= base;
        }
    }
    for exponent in -1074i32..=1023 {
        let bits = if exponent >= -1022 { ((exponent + 1023) as u64) << 52 } else { 1 << (exponent + 1074) };
        assert_eq!(expt(2.0, f64::from(exponent)).to_bits(), bits, "2^{exponent}");
    }
    assert_eq!(expt(10.0, 22.0), 1e22);
    // IEEE 754, 9.2.1.
    assert_eq!(expt(0.0, 0.0), 1.0);
    assert_eq!(expt(f64::NAN, 0.0), 1.0);
    assert_eq!(expt(0.0, -1.0), f64::INFINITY);
    assert!(expt(-8.0, 1.0 / 3.0).is_nan());
    assert_eq!(expt(4.0, 0.5), 2.0);
    assert_eq!(expt(2.0, 1024.0), f64::INFINITY);
    assert_eq!(call("EXPT", Real, &[real(1.5), lreal(2.0)]), real(2.25));
    assert_eq!(power(Lreal, lreal(-2.0), lreal(3.0)), lreal(-8.0));
}

#[test]
fn strings() {
    // The examples of the controllers' documents.
    assert_eq!(call_text("LEN", &["SUSI"], &[], 0).1, 4);
    assert_eq!(text("LEFT", &["SUSI"], &[3]), "SUS");
    assert_eq!(text("RIGHT", &["SUSI"], &[3]), "USI");
    assert_eq!(text("MID", &["SUSI"], &[2, 2]), "US");
    assert_eq!(text("CONCAT", &["SUSI", "WILLI"], &[]), "SUSIWILLI");
    assert_eq!(text("INSERT", &["SUSI", "XY"], &[2]), "SUXYSI");
    assert_eq!(text("DELETE", &["SUXYSI"], &[2, 3]), "SUSI");
    assert_eq!(text("REPLACE", &["SUXYSI", "K"], &[2, 2]), "SKYSI");
    assert_eq!(call_text("FIND", &["abcdef", "de"], &[], 0).1, 4);
    // What the documents say of positions in front of the text.
    assert_eq!(text("DELETE", &["SUXYSI"], &[2, 0]), "UXYSI");
    assert_eq!(text("DELETE", &["SUXYSI"], &[2, 1]), "XYSI");
    assert_eq!(text("REPLACE", &["SUXYSI", "K"], &[2, 0]), "KUXYSI");
    assert_eq!(text("INSERT", &["SUSI", "XY"], &[0]), "XYSUSI");
    assert_eq!(text("INSERT", &["SUSI", "XY"], &[-1]), "SUSI");
    // Ours.
    for (name, texts, cells, result) in [
        ("LEFT", &["abc"][..], &[0][..], ""),
        ("LEFT", &["abc"], &[-1], ""),
        ("LEFT", &["abc"], &[99], "abc"),
        ("LEFT", &["abc"], &[i64::MIN], ""),
        ("RIGHT", &["abc"], &[0], ""),
        ("RIGHT", &["abc"], &[-5], ""),
        ("RIGHT", &["abc"], &[i64::MAX], "abc"),
        ("MID", &["abc"], &[2, 0], "a"),
        ("MID", &["abc"], &[2, -1], ""),
        ("MID", &["abc"], &[0, 1], ""),
        ("MID", &["abc"], &[-1, 1], ""),
        ("MID", &["abc"], &[9, 3], "c"),
        ("MID", &["abc"], &[9, 4], ""),
        ("MID", &["abc"], &[i64::MAX, i64::MAX], ""),
        ("CONCAT", &[], &[], ""),
        ("CONCAT", &["a", "", "b", "c"], &[], "abc"),
        ("INSERT", &["abc", "XY"], &[3], "abcXY"),
        ("INSERT", &["abc", "XY"], &[4], "abcXY"),
        ("INSERT", &["abc", ""], &[1], "abc"),
        ("DELETE", &["abc"], &[0, 1], "abc"),
        ("DELETE", &["abc"], &[-1, 1], "abc"),
        ("DELETE", &["abc"], &[9, -2], "abc"),
        ("DELETE", &["abc"], &[9, 2], "a"),
        ("DELETE", &["abc"], &[1, 4], "abc"),
        ("REPLACE", &["abc", "XY"], &[0, 2], "aXYbc"),
        ("REPLACE", &["abc", "XY"], &[-1, 2], "aXYbc"),
        ("REPLACE", &["abc", "XY"], &[9, 9], "abcXY"),
        ("REPLACE", &["abc", "XY"], &[1, -1], "abc"),
        ("REPLACE", &["abc", ""], &[1, 1], "bc"),
    ] {
        assert_eq!(text(name, texts, cells), result, "{name} {texts:?} {cells:?}");
    }
    for (first, second, place) in [
        ("abcabc", "bc", 2),
        ("abc", "x", 0),
        ("abc", "", 0),
        ("", "a", 0),
        ("aab", "ab", 2),
        ("ab", "abc", 0),
    ] {
        assert_eq!(call_text("FIND", &[first, second], &[], 0).1, place, "{first} {second}");
    }
    assert_eq!(call_text("LEN", &["ab\0cd"], &[], 0).1, 2, "a 0 ends the text");
    assert_eq!(call_text("LEN", &[&"x".repeat(40_000)], &[], 0).1, 32_767);
    // What does not fit is cut off.
    assert_eq!(call_text("CONCAT", &["abc", "def"], &[], 4).0, "abcd");
    assert_eq!(call_text("INSERT", &["abc", "def"], &[1], 2).0, "ad");
    assert_eq!(call_text("LEFT", &["abc"], &[3], 0).0, "");
}

#[test]
fn wide_strings() {
    let units = |text: &str| -> Vec<u8> { text.encode_utf16().flat_map(u16::to_le_bytes).collect() };
    let (first, second) = (units("10 € = x"), units("€"));
    let texts = [Text { wide: true, bytes: &first }, Text { wide: true, bytes: &second }];
    let mut bytes = [0xAA; 12];
    let Body::Text(body) = find("FIND").unwrap().body else { panic!() };
    let mut call = TextCall { texts: &texts, cells: &[], out: TextOut::new(true, &mut bytes), result: 0 };
    body(&mut call);
    assert_eq!(call.result, 4);
    // Bytes that look the same between two characters are no match.
    let (first, second) = ([0x01, 0x41, 0x42, 0x41], [0x41, 0x42]);
    let shifted = [Text { wide: true, bytes: &first }, Text { wide: true, bytes: &second }];
    let mut call = TextCall { texts: &shifted, cells: &[], out: TextOut::new(true, &mut []), result: 0 };
    body(&mut call);
    assert_eq!(call.result, 0);
    let Body::Text(body) = find("CONCAT").unwrap().body else { panic!() };
    let mut call = TextCall { texts: &texts, cells: &[], out: TextOut::new(true, &mut bytes), result: 0 };
    body(&mut call);
    assert_eq!(bytes[..], units("10 € \0")[..], "5 characters and the closing 0");
}

#[test]
fn times() {
    for (name, cells, result) in [
        ("ADD_TIME", [1_000, 500], 1_500),
        ("ADD_TIME", [4_294_967_295, 2], 1),
        ("SUB_TIME", [1, 2], 4_294_967_295),
        ("ADD_LTIME", [-1, 1], 0),
        ("ADD_TOD_TIME", [86_399_000, 2_000], 86_401_000),
        ("SUB_TOD_TIME", [1_000, 400], 600),
        ("SUB_TOD_TOD", [45_296_000, 45_000_000], 296_000),
        ("ADD_DT_TIME", [1_580_428_800, 1_999], 1_580_428_801),
        ("ADD_DT_TIME", [4_294_967_295, 1_000], 0),
        ("SUB_DT_TIME", [1_580_428_800, 1_999], 1_580_428_799),
        ("SUB_DT_TIME", [0, 1_000], 4_294_967_295),
        ("SUB_DT_DT", [1_580_428_860, 1_580_428_800], 60_000),
        ("SUB_DT_DT", [4_294_968, 0], 4_294_968_000 - 4_294_967_296),
        ("SUB_DATE_DATE", [1_582_934_400, 1_580_428_800], 2_505_600_000),
        ("SUB_LDATE_LDATE", [86_400_000_000_000, 0], 86_400_000_000_000),
        ("ADD_LDT_LTIME", [1, 2], 3),
        ("SUB_LDT_LTIME", [1, 2], -1),
        ("SUB_LDT_LDT", [5, 2], 3),
        ("ADD_LTOD_LTIME", [5, 2], 7),
        ("SUB_LTOD_LTIME", [5, 2], 3),
        ("SUB_LTOD_LTOD", [5, 2], 3),
        ("CONCAT_DATE_TOD", [1_580_428_800, 45_296_789], 1_580_474_096),
        ("CONCAT_DATE_LTOD", [1_580_428_800, 45_296_000_000_001], 1_580_474_096_000_000_001),
        ("CONCAT_LDATE_LTOD", [1_580_428_800_000_000_000, 1], 1_580_428_800_000_000_001),
    ] {
        assert_eq!(call(name, Bool, &cells), result, "{name} {cells:?}");
    }
}

#[test]
fn times_by_numbers() {
    for (name, ty, number, result) in [
        ("MUL_TIME", Int, 3, 3_000),
        ("MULTIME", Lreal, lreal(1.5), 1_500),
        ("MULTIME", Lreal, lreal(0.000_5), 0),
        ("MULTIME", Real, real(0.25), 250),
        ("MULTIME", Lreal, lreal(0.0015), 2),
        ("MUL_TIME", Int, -1, 4_294_966_296),
        ("MUL_TIME", Dint, 2_000_000_001, (2_000_000_001i64 * 1_000) & 0xFFFF_FFFF),
        ("MUL_TIME", Lreal, lreal(f64::NAN), 0),
        ("DIV_TIME", Int, 3, 333),
        ("DIVTIME", Lreal, lreal(1.5), 667),
        ("DIV_TIME", Int, -3, 4_294_966_963),
        ("DIV_TIME", Ulint, -1, 0),
        ("DIV_TIME", Lreal, lreal(1.0E-300), 4_294_967_295),
        ("DIV_LTIME", Ulint, 2, 500),
        ("MUL_LTIME", Lint, 2, 2_000),
    ] {
        assert_eq!(call(name, ty, &[1_000, number]), result, "{name} {} {number}", ty.name());
    }
    assert_eq!(call("DIV_LTIME", Lint, &[-1, 2]), i64::MAX, "LTIME is unsigned");
    for name in ["DIV_TIME", "DIVTIME", "DIV_LTIME"] {
        let Body::Quotient(body) = find(name).unwrap().body else { panic!("{name}") };
        for (ty, zero) in
            [(Int, 0), (Ulint, 0), (Real, real(-0.0)), (Lreal, lreal(0.0)), (Lreal, lreal(-0.0))]
        {
            assert_eq!(body(ty, &[1_000, zero]), None, "{name} {}", ty.name());
        }
    }
}

#[test]
fn dates() {
    let date = |cells: &[i64]| call("CONCAT_DATE", Int, cells);
    assert_eq!(date(&[2020, 2, 29]), 1_582_934_400);
    assert_eq!(date(&[1970, 1, 1]), 0);
    assert_eq!(date(&[2106, 2, 7]), 4_294_944_000);
    assert_eq!(date(&[2106, 2, 8]), 4_295_030_400 - 4_294_967_296, "a DATE ends in 2106");
    for none in [[2021, 2, 29], [2100, 2, 29], [1969, 12, 31], [2020, 0, 1], [2020, 13, 1], [2020, 1, 32]] {
        assert_eq!(date(&none), 0);
    }
    assert_eq!(call("CONCAT_LDATE", Uint, &[2400, 2, 29]), 13_574_563_200_000_000_000u64 as i64);
    assert_eq!(call("CONCAT_TOD", Int, &[12, 34, 56, 789]), 45_296_789);
    assert_eq!(call("CONCAT_TOD", Int, &[24, 0, 0, 0]), 0);
    assert_eq!(call("CONCAT_TOD", Int, &[0, 0, 0, 1_000]), 0);
    assert_eq!(call("CONCAT_LTOD", Int, &[0, 0, 1, 1]), 1_001_000_000);
    assert_eq!(call("CONCAT_DT", Int, &[2020, 1, 31, 12, 34, 56, 999]), 1_580_474_096);
    assert_eq!(call("CONCAT_DT", Int, &[2106, 2, 7, 6, 28, 15, 0]), 4_294_967_295);
    assert_eq!(call("CONCAT_LDT", Int, &[2020, 1, 31, 12, 34, 56, 1]), 1_580_474_096_001_000_000);
    assert_eq!(call("CONCAT_DATE", Ulint, &[-1, 1, 1]), 0);
    // Known days: Thursday, Friday, Sunday.
    assert_eq!(call("DAY_OF_WEEK", Bool, &[0]), 4);
    assert_eq!(call("DAY_OF_WEEK", Bool, &[1_580_428_800]), 5);
    assert_eq!(call("DAY_OF_WEEK", Bool, &[4_294_944_000]), 0);
}

#[test]
fn checks() {
    for (number, valid) in [(0.0, 1), (f64::MAX, 1), (f64::NAN, 0), (f64::INFINITY, 0), (5e-324, 1)] {
        assert_eq!(call("IS_VALID", Lreal, &[lreal(number)]), valid, "{number}");
    }
    assert_eq!(call("IS_VALID", Real, &[0x7F80_0000]), 0);
    for (ty, digits, valid) in
        [(Byte, 0x99, 1), (Byte, 0x9A, 0), (Word, 0xA000, 0), (Lword, -1, 0), (Bool, 1, 1)]
    {
        assert_eq!(call("IS_VALID_BCD", ty, &[digits]), valid, "{digits:x}");
    }
    assert_eq!(call("TO_BIG_ENDIAN", Word, &[0x1234]), 0x3412);
    assert_eq!(call("FROM_BIG_ENDIAN", Int, &[0x0080]), -32_768);
    assert_eq!(call("TO_BIG_ENDIAN", Dword, &[0x1234_5678]), 0x7856_3412);
    assert_eq!(call("TO_BIG_ENDIAN", Lint, &[1]), 1 << 56);
    assert_eq!(call("TO_BIG_ENDIAN", Sint, &[-5]), -5);
    assert_eq!(call("TO_LITTLE_ENDIAN", Word, &[0x1234]), 0x1234);
}

/// What a string function gives, each character looked at by its position.
fn naive(name: &str, texts: &[&str], a: i64, b: i64) -> String {
    let at = |text: &str, keep: &dyn Fn(i64) -> bool| -> String {
        text.chars().zip(1..).filter(|(_, position)| keep(*position)).map(|(c, _)| c).collect()
    };
    let (text, length) = (texts[0], texts[0].len() as i64);
    let inside = |p: i64| b >= 0 && p >= b && p < b + a.max(0);
    match name {
        "LEFT" => at(text, &|p| p <= a),
        "RIGHT" => at(text, &|p| p > length - a.max(0)),
        "MID" => at(text, &inside),
        "CONCAT" => texts.concat(),
        "INSERT" if a < 0 => text.into(),
        "INSERT" => at(text, &|p| p <= a) + texts[1] + &at(text, &|p| p > a),
        "DELETE" => at(text, &|p| !inside(p)),
        "REPLACE" if b < 0 => text.into(),
        _ => at(text, &|p| p < b) + texts[1] + &at(text, &|p| p >= b && !inside(p)),
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2048))]

    #[test]
    fn strings_by_position(
        place in 0..7usize, first in "[a-c]{0,12}", second in "[X-Z]{0,5}", a in -3..16i64, b in -3..16i64, room in 0..20usize,
    ) {
        let name = ["LEFT", "RIGHT", "MID", "CONCAT", "INSERT", "DELETE", "REPLACE"][place];
        let mut expected = naive(name, &[&first, &second], a, b);
        expected.truncate(room);
        prop_assert_eq!(call_text(name, &[&first, &second], &[a, b], room).0, expected, "{}", name);
    }

    #[test]
    fn found_as_rust_finds(first in "[ab]{0,12}", second in "[ab]{1,4}") {
        let expected = first.find(&second).map_or(0, |place| place as i64 + 1);
        prop_assert_eq!(call_text("FIND", &[&first, &second], &[], 0).1, expected);
    }

    #[test]
    fn any_arguments(
        ty in 0..25usize, cells in proptest::collection::vec(any::<i64>(), 0..9), wide: bool,
        bytes in proptest::collection::vec(any::<u8>(), 0..9), room in 0..9usize,
    ) {
        let ty = Elementary::ALL[ty];
        let texts = [Text { wide, bytes: &bytes }; 3];
        for name in names() {
            let function = find(name).unwrap();
            match function.body {
                Body::Scalar(body) => {
                    let result = body(ty, &cells);
                    if let Gives::Exact(exact) = function.gives {
                        prop_assert_eq!(result, exact.wrap(result), "{}", name);
                    }
                }
                Body::Text(body) => {
                    let mut bytes = [0xAA; 9];
                    let out = TextOut { wide, bytes: &mut bytes[..room], length: 0 };
                    let mut call = TextCall { texts: &texts, cells: &cells, out, result: 0 };
                    body(&mut call);
                    prop_assert!(call.out.length <= call.out.capacity());
                    prop_assert_eq!(call.result, Int.wrap(call.result));
                }
                Body::Quotient(body) => {
                    if let (Some(result), Gives::Exact(exact)) = (body(ty, &cells), function.gives) {
                        prop_assert_eq!(result, exact.wrap(result), "{}", name);
                    }
                }
                Body::Clock(_) | Body::Service(_) => {}
            }
        }
    }

    #[test]
    fn sums_of_times(name in 0..12usize, a: i64, b: i64) {
        // Against 128 bits, cut to the width.
        let (name, left, right, result, sign) = [
            ("ADD_TIME", Time, Time, Time, 1),
            ("SUB_TIME", Time, Time, Time, -1),
            ("ADD_LTIME", Ltime, Ltime, Ltime, 1),
            ("SUB_LTIME", Ltime, Ltime, Ltime, -1),
            ("ADD_TOD_TIME", Tod, Time, Tod, 1),
            ("SUB_TOD_TOD", Tod, Tod, Time, -1),
            ("ADD_LDT_LTIME", Ldt, Ltime, Ldt, 1),
            ("SUB_LDT_LTIME", Ldt, Ltime, Ldt, -1),
            ("SUB_LDT_LDT", Ldt, Ldt, Ltime, -1),
            ("ADD_LTOD_LTIME", Ltod, Ltime, Ltod, 1),
            ("SUB_LTOD_LTIME", Ltod, Ltime, Ltod, -1),
            ("SUB_TOD_TIME", Tod, Time, Tod, -1),
        ][name];
        let parameters = find(name).unwrap().parameters;
        prop_assert_eq!([parameters[0].1, parameters[1].1], [Exact(left), Exact(right)]);
        prop_assert_eq!(find(name).unwrap().gives, Gives::Exact(result));
        let number = left.number(left.wrap(a)) + sign * right.number(right.wrap(b));
        let (_, high) = result.range();
        prop_assert_eq!(result.number(call(name, Bool, &[a, b])), number.rem_euclid(high + 1));
    }
}
