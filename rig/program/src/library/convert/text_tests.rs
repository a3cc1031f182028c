//! Values as texts and back. Expected texts are literals of IEC 61131-3; what the documents and recordings of the
//! vendor's tool show (T#12ms, T#1s500ms, LTIME#106752d, fractions of LTOD) is among them.

use super::*;
use crate::library::{Text, TextOut};
use proptest::prelude::*;

/// A value as a text.
fn shown(ty: Elementary, cell: i64) -> String {
    let mut bytes = [0xAA; 64];
    let mut out = TextOut::new(false, &mut bytes);
    to_text(ty, cell, &mut out);
    let length = out.length;
    assert_eq!(bytes[length], 0);
    String::from_utf8(bytes[..length].to_vec()).unwrap()
}

fn read(text: &str, ty: Elementary) -> i64 {
    from_text(Text { wide: false, bytes: text.as_bytes() }, ty)
}

#[test]
fn values_as_texts() {
    let real = |n: f32| i64::from(n.to_bits());
    let lreal = |n: f64| n.to_bits() as i64;
    for (ty, cell, text) in [
        (Bool, 0, "FALSE"),
        (Bool, 1, "TRUE"),
        (Sint, -128, "-128"),
        (Byte, 255, "255"),
        (Ulint, -1, "18446744073709551615"),
        (Lint, i64::MIN, "-9223372036854775808"),
        (Real, real(0.0), "0.0"),
        (Real, real(-0.0), "-0.0"),
        (Real, real(1.0), "1.0"),
        (Real, real(87.4), "87.4"),
        (Real, real(0.1), "0.1"),
        (Real, real(100_000.0), "100000.0"),
        (Real, real(0.000_1), "0.0001"),
        (Real, real(0.000_09), "9E-5"),
        (Real, real(99_999_990.0), "99999990.0"),
        (Real, real(1e8), "1E8"),
        (Real, real(1.234_567_9e8), "1.2345679E8"),
        (Real, real(-1e20), "-1E20"),
        (Lreal, lreal(std::f64::consts::PI), "3.141592653589793"),
        (Lreal, lreal(123_456_789.0), "123456789.0"),
        (Lreal, lreal(999_999_999_999_999.0), "999999999999999.0"),
        (Lreal, lreal(1e15), "1E15"),
        (Lreal, lreal(5e-324), "5E-324"),
        (Lreal, lreal(f64::NAN), "#NaN"),
        (Lreal, lreal(f64::INFINITY), "#Inf"),
        (Real, real(f32::NEG_INFINITY), "-#Inf"),
        (Time, 0, "T#0ms"),
        (Time, 12, "T#12ms"),
        (Time, 1_500, "T#1s500ms"),
        (Time, 93_784_005, "T#1d2h3m4s5ms"),
        (Time, 3_600_000, "T#1h"),
        (Time, 4_294_967_295, "T#49d17h2m47s295ms"),
        (Ltime, 0, "LTIME#0ns"),
        (Ltime, 9_223_372_800_000_000_000_u64 as i64, "LTIME#106752d"),
        (Ltime, 1_000_002_000_003, "LTIME#16m40s2ms3ns"),
        (Date, 0, "D#1970-01-01"),
        (Date, 1_582_934_400, "D#2020-02-29"),
        (Date, 4_294_967_295, "D#2106-02-07"),
        (Tod, 45_296_789, "TOD#12:34:56.789"),
        (Tod, 45_296_000, "TOD#12:34:56"),
        (Tod, 5, "TOD#00:00:00.005"),
        (Dt, 1_580_428_800 + 45_296, "DT#2020-01-31-12:34:56"),
        (Dt, 4_294_967_295, "DT#2106-02-07-06:28:15"),
        (Ldate, 1_582_934_400_000_000_000, "LD#2020-02-29"),
        (Ltod, 3_723_000_001_000, "LTOD#01:02:03.000001000"),
        (Ldt, 1_709_211_909_500_000_000, "LDT#2024-02-29-13:05:09.500000000"),
        (Ldt, -1, "LDT#2554-07-21-23:34:33.709551615"),
        (Char, 65, "A"),
        (Char, 0, ""),
        (Wchar, 0x20AC, "?"),
    ] {
        assert_eq!(shown(ty, cell), text, "{}", ty.name());
    }
}

#[test]
fn texts_as_values() {
    let real = |n: f32| i64::from(n.to_bits());
    let lreal = |n: f64| n.to_bits() as i64;
    for (ty, text, cell) in [
        (Bool, "TRUE", 1),
        (Bool, " true", 1),
        (Bool, "1", 1),
        (Bool, "0", 0),
        (Bool, "FALSE", 0),
        (Bool, "", 0),
        (Bool, "yes", 0),
        (Int, "123", 123),
        (Int, "  -12abc", -12),
        (Int, "+7", 7),
        (Int, "1_000", 1000),
        (Int, "_1", 0),
        (Int, "1.9", 1),
        (Int, "abc", 0),
        (Int, "", 0),
        (Int, "-", 0),
        (Int, "40000", -25_536),
        (Int, "16#7F", 127),
        (Int, "-16#10", -16),
        (Byte, "2#1010_1010", 0xAA),
        (Int, "8#17", 15),
        (Int, "3#11", 3),
        (Int, "16#", 0),
        (Ulint, "18446744073709551615", -1),
        (Ulint, "18446744073709551616", 0),
        (Lint, "-9223372036854775808", i64::MIN),
        (Real, "1.5", real(1.5)),
        (Real, "-1.5e3xyz", real(-1500.0)),
        (Real, "3", real(3.0)),
        (Real, ".5", real(0.5)),
        (Real, "5.", real(5.0)),
        (Real, "1e", real(1.0)),
        (Real, "1E+2", real(100.0)),
        (Real, "1_000.25", real(1000.25)),
        (Real, "1e99", real(f32::INFINITY)),
        (Real, "", 0),
        (Real, ".", 0),
        (Real, "-", 0),
        (Real, "#Inf", real(f32::INFINITY)),
        (Real, "-#INF", real(f32::NEG_INFINITY)),
        (Real, "#NaN", 0x7FC0_0000),
        // Just above the tie between 1 and the next REAL, but on it as LREAL.
        (Real, "1.000000059604644775390625000000001", 0x3F80_0001),
        (Lreal, "0.1", lreal(0.1)),
        (Lreal, "1E-400", 0),
        (Lreal, "1E99999999999999999999", lreal(f64::INFINITY)),
        (Time, "T#1d2h3m4s5ms", 93_784_005),
        (Time, "t#1D_2H", 93_600_000),
        (Time, "TIME#1.5s", 1_500),
        (Time, "5m", 300_000),
        (Time, "5ms", 5),
        (Time, "1000", 1_000),
        (Time, "1s5", 1_000),
        (Time, "T#", 0),
        (Time, "-5s", 0),
        (Time, "50d", 50 * 86_400_000 - 4_294_967_296),
        (Ltime, "LTIME#1us2ns", 1_002),
        (Ltime, "7", 7),
        (Date, "D#2020-02-29", 1_582_934_400),
        (Date, "2020-2-29", 1_582_934_400),
        (Date, "DATE#2021-02-29", 0),
        (Date, "2020-02", 0),
        (Date, "2106-02-08", 4_295_030_400 - 4_294_967_296),
        (Tod, "TOD#12:34:56.789", 45_296_789),
        (Tod, "TIME_OF_DAY#12:34", 45_240_000),
        (Tod, "12:60", 0),
        (Tod, "12", 0),
        (Ltod, "00:00:00.0000000019", 1),
        (Dt, "DT#2020-01-31-12:34:56", 1_580_474_096),
        (Dt, "2020-01-31 12:34:56", 1_580_474_096),
        (Dt, "2020-01-31T12:34:56.9", 1_580_474_096),
        (Dt, "2020-01-31", 1_580_428_800),
        (Dt, "2020-01-31-25:61:00", 0),
        (Ldt, "LDT#2024-02-29-13:05:09.5", 1_709_211_909_500_000_000),
        (Char, "AB", 65),
        (Char, " ", 32),
        (Char, "", 0),
    ] {
        assert_eq!(read(text, ty), cell, "{text:?} as {}", ty.name());
    }
}

/// A wide text of units.
fn wide(units: &[u16]) -> Vec<u8> {
    units.iter().flat_map(|unit| unit.to_le_bytes()).collect()
}

#[test]
fn wide_and_narrow() {
    assert_eq!(from_text(Text { wide: true, bytes: &wide(&[b'4'.into(), b'2'.into()]) }, Int), 42);
    assert_eq!(from_text(Text { wide: true, bytes: &wide(&[0x20AC]) }, Wchar), 0x20AC);
    assert_eq!(from_text(Text { wide: true, bytes: &wide(&[0x20AC]) }, Char), i64::from(b'?'));
    let mut bytes = [0; 4];
    to_text(Wchar, 0x20AC, &mut TextOut::new(true, &mut bytes));
    assert_eq!(bytes, [0xAC, 0x20, 0, 0]);
    // Storage without room, or with half a unit.
    for size in 0..4 {
        let mut bytes = vec![0xAA; size];
        to_text(Time, 93_784_005, &mut TextOut::new(true, &mut bytes));
        to_text(Time, 93_784_005, &mut TextOut::new(false, &mut bytes));
    }
}

#[test]
fn long_numbers() {
    let zeros = format!("{}1", "0".repeat(5_000));
    assert_eq!(read(&zeros, Int), 1);
    assert_eq!(read(&"9".repeat(5_000), Lreal), f64::INFINITY.to_bits() as i64);
    read(&format!("{}d", "9".repeat(400)).repeat(100), Ltime);
}

fn any_type() -> impl Strategy<Value = Elementary> {
    (0..Elementary::ALL.len()).prop_map(|place| Elementary::ALL[place])
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4096))]

    #[test]
    fn texts_read_back(ty in any_type(), cell: i64) {
        let cell = match ty {
            Date => ty.wrap(cell) / 86_400 * 86_400,
            Ldate => (cell as u64 / 86_400_000_000_000 * 86_400_000_000_000) as i64,
            // One NaN is enough, and a character fits a STRING.
            Real if f32::from_bits(cell as u32).is_nan() => 0x7FC0_0000,
            Lreal if f64::from_bits(cell as u64).is_nan() => 0x7FF8_0000_0000_0000,
            Wchar => cell & 0xFF,
            _ => ty.wrap(cell),
        };
        let mut bytes = [0; 64];
        let mut out = TextOut::new(false, &mut bytes);
        to_text(ty, cell, &mut out);
        prop_assert_eq!(from_text(Text { wide: false, bytes: &bytes }, ty), cell, "{}", ty.name());
    }

    #[test]
    fn any_bytes_are_read(ty in any_type(), wide: bool, bytes in proptest::collection::vec(any::<u8>(), 0..40)) {
        let cell = from_text(Text { wide, bytes: &bytes }, ty);
        prop_assert_eq!(cell, ty.wrap(cell));
    }

    #[test]
    fn likely_texts_are_read(ty in any_type(), text in "[ tdT#]{0,3}[-+0-9_:.#dhmsunEeINF]{0,40}") {
        let cell = from_text(Text { wide: false, bytes: text.as_bytes() }, ty);
        prop_assert_eq!(cell, ty.wrap(cell));
    }
}
