//! Expected values come from integer arithmetic in 128 bits, IEEE 754 and the ranges of IEC 61131-3, or are written out.

use super::*;
use proptest::prelude::*;

/// Cells at and around the limits of a type.
fn edges(ty: Elementary) -> Vec<i64> {
    const REALS: [f64; 40] = [
        0.0,
        -0.0,
        0.3,
        0.5,
        1.5,
        2.5,
        3.5,
        -0.5,
        -1.5,
        -2.5,
        -3.5,
        1.0,
        -1.0,
        126.5,
        127.5,
        128.0,
        -128.5,
        -129.0,
        255.5,
        256.0,
        32_767.5,
        32_768.0,
        65_535.5,
        65_536.0,
        2_147_483_647.5,
        2_147_483_648.0,
        4_294_967_295.5,
        4_294_967_296.0,
        4_503_599_627_370_497.5,
        9.223_372_036_854_775e18,
        9.223_372_036_854_776e18,
        -9.223_372_036_854_776e18,
        1.844_674_407_370_955e19,
        1.844_674_407_370_955_2e19,
        1e30,
        -1e30,
        5e-324,
        f64::INFINITY,
        f64::NEG_INFINITY,
        f64::NAN,
    ];
    match ty {
        Real => REALS.iter().map(|n| i64::from((*n as f32).to_bits())).collect(),
        Lreal => REALS.iter().map(|n| n.to_bits() as i64).collect(),
        _ => {
            let (low, high) = ty.range();
            let mut cells = vec![0, 1, 2, low, low + 1, high, high - 1, high / 2, high / 2 + 1];
            cells.extend([24, 31, 53, 62].into_iter().flat_map(|bit| {
                [(1i128 << bit) - 1, 1 << bit, (1 << bit) + 1, (1 << bit) + (1 << (bit - 24)), 3 << (bit - 1)]
            }));
            cells.extend([86_399, 86_400, 86_399_999, 86_400_000, 1_580_428_800, 86_400_000_000_000 - 1]);
            cells.extend(cells.clone().into_iter().map(|n| -n));
            cells.into_iter().filter(|n| *n >= low && *n <= high).map(|n| ty.wrap(n as i64)).collect()
        }
    }
}

/// A number cut to the width of a type, by the range alone.
fn cut(ty: Elementary, number: i128) -> i64 {
    let (low, _) = ty.range();
    ((number - low).rem_euclid(1 << ty.bits()) + low) as i64
}

/// A whole number with at most `digits` binary digits: the nearest, ties to even. By integer arithmetic.
fn nearest(number: i128, digits: u32) -> f64 {
    let size = number.unsigned_abs();
    let excess = (128 - size.leading_zeros()).saturating_sub(digits);
    let (kept, rest) = (size >> excess, size & ((1 << excess) - 1));
    let half = if excess == 0 { 1 } else { 1 << (excess - 1) };
    let kept = kept + u128::from(rest > half || (rest == half && kept % 2 == 1 && excess > 0));
    // Exact: few digits, and a power of two.
    let size = kept as f64 * (1u128 << excess) as f64;
    if number < 0 { -size } else { size }
}

/// The nearest whole number, ties to even, within 64 bits.
fn nearest_whole(number: f64, to: Elementary) -> i128 {
    if number.is_nan() {
        return 0;
    }
    let top = if to.bits() == 64 && !to.signed() { i128::from(u64::MAX) } else { i128::from(i64::MAX) };
    let below = number.floor();
    let clamped = (below.clamp(-1e20, 1e20)) as i128;
    let up = match number - below {
        rest if rest > 0.5 => 1,
        0.5 => clamped & 1,
        _ => 0,
    };
    (clamped + up).clamp(i128::from(i64::MIN), top)
}

fn nanos(ty: Elementary) -> Option<i128> {
    match ty {
        Time | Tod => Some(1_000_000),
        Date | Dt => Some(1_000_000_000),
        Ltime | Ltod | Ldt | Ldate => Some(1),
        _ => None,
    }
}

/// What a conversion gives, by the rules of the module's heading.
fn expected(from: Elementary, to: Elementary, cell: i64) -> i64 {
    const DAY: i128 = 24 * 60 * 60 * 1_000_000_000;
    let real =
        if from == Real { f64::from(f32::from_bits(cell as u32)) } else { f64::from_bits(cell as u64) };
    let number = if from.wide_unsigned() { i128::from(cell as u64) } else { i128::from(cell) };
    match (from, to) {
        _ if from == to => cell,
        (Real | Lreal, Bool) => i64::from(!(real == 0.0)),
        (_, Bool) => i64::from(number != 0),
        (Real | Lreal, Real | Lreal) if real.is_nan() => {
            if to == Real {
                0x7FC0_0000
            } else {
                0x7FF8_0000_0000_0000
            }
        }
        (Real, Lreal) => real.to_bits() as i64,
        (Lreal, Real) => i64::from((real as f32).to_bits()),
        (Real | Lreal, _) => cut(to, nearest_whole(real, to)),
        (_, Real) => i64::from((nearest(number, 24) as f32).to_bits()),
        (_, Lreal) => nearest(number, 53).to_bits() as i64,
        _ => match (nanos(from), nanos(to)) {
            (Some(of), Some(into)) => {
                let time = number * of;
                let time = match to {
                    Date | Ldate => time / DAY * DAY,
                    Tod | Ltod => time % DAY,
                    _ => time,
                };
                cut(to, time / into)
            }
            _ => cut(to, number),
        },
    }
}

#[test]
fn every_type_to_every_type_at_the_limits() {
    for from in Elementary::ALL {
        for to in Elementary::ALL {
            for cell in edges(from) {
                let found = convert(from, to, cell);
                assert_eq!(found, expected(from, to, cell), "{}_TO_{} of {cell}", from.name(), to.name());
                assert_eq!(found, to.wrap(found), "{}_TO_{} of {cell}", from.name(), to.name());
            }
        }
    }
}

#[test]
fn written_out() {
    let lreal = |n: f64| n.to_bits() as i64;
    let real = |n: f32| i64::from(n.to_bits());
    // IEC 61131-3, 6.6.2.5.3: rounding of REAL to whole numbers is to the nearest, ties to even.
    for (number, whole) in [(1.5, 2), (2.5, 2), (-1.5, -2), (-2.5, -2), (1.4, 1), (-1.6, -2), (0.5, 0)] {
        assert_eq!(convert(Lreal, Int, lreal(number)), whole, "{number}");
        assert_eq!(convert(Real, Dint, real(number as f32)), whole, "{number}");
    }
    // Two's complement.
    assert_eq!(convert(Int, Usint, -1), 255);
    assert_eq!(convert(Uint, Int, 40_000), -25_536);
    assert_eq!(convert(Dword, Sint, 0x1234_5680), -128);
    assert_eq!(convert(Lint, Ulint, -1) as u64, u64::MAX);
    // IEEE 754: ties to even at 24 digits, and what is too large for REAL.
    assert_eq!(convert(Dint, Real, 16_777_217), real(16_777_216.0));
    assert_eq!(convert(Dint, Real, 16_777_219), real(16_777_220.0));
    assert_eq!(convert(Lreal, Real, lreal(1e39)), 0x7F80_0000);
    assert_eq!(convert(Lreal, Real, lreal(0.1)), 0x3DCC_CCCD);
    assert_eq!(convert(Real, Lreal, real(0.1)), lreal(0.100_000_001_490_116_12));
    assert_eq!(convert(Ulint, Lreal, -1), lreal(18_446_744_073_709_551_616.0));
    // Ties and limits of REAL: 1 + 2^-24, 1 + 3 * 2^-24, the largest number and half a unit more, 2^-150.
    assert_eq!(convert(Lreal, Real, 0x3FF0_0000_1000_0000), 0x3F80_0000);
    assert_eq!(convert(Lreal, Real, 0x3FF0_0000_3000_0000), 0x3F80_0002);
    assert_eq!(convert(Lreal, Real, 0x47EF_FFFF_EFFF_FFFF), 0x7F7F_FFFF);
    assert_eq!(convert(Lreal, Real, 0x47EF_FFFF_F000_0000), 0x7F80_0000);
    assert_eq!(convert(Lreal, Real, 0x3690_0000_0000_0000), 0);
    assert_eq!(convert(Lreal, Real, 0x3690_0000_0000_0001), 1);
    // A NaN is one NaN, and not 0.
    assert_eq!(convert(Lreal, Real, -1), 0x7FC0_0000);
    assert_eq!(convert(Real, Lreal, 0xFFFF_FFFF), 0x7FF8_0000_0000_0000);
    assert_eq!(convert(Real, Bool, 0x7FC0_0000), 1);
    assert_eq!(convert(Real, Bool, 0x8000_0000), 0, "-0.0");
    // A number on the tie of REAL, but only by way of LREAL: 2^60 + 2^36 + 1.
    assert_eq!(convert(Lint, Real, (1 << 60) + (1 << 36) + 1), 0x5D80_0001);
    // Times and dates, by POSIX time: 1580428800 is 2020-01-31 00:00, 1582934400 2020-02-29.
    assert_eq!(convert(Time, Ltime, 1), 1_000_000);
    assert_eq!(convert(Ltime, Time, 1_999_999), 1);
    assert_eq!(convert(Dt, Date, 1_580_428_800 + 45_296), 1_580_428_800);
    assert_eq!(convert(Dt, Tod, 1_580_428_800 + 45_296), 45_296_000);
    assert_eq!(convert(Dt, Ldt, 1_582_934_400), 1_582_934_400_000_000_000);
    assert_eq!(convert(Ldt, Dt, 1_582_934_400_999_999_999), 1_582_934_400);
    assert_eq!(convert(Ldt, Dt, 4_294_967_296_000_000_000), 0, "a DT ends in 2106");
    assert_eq!(convert(Date, Udint, 86_400), 86_400);
    assert_eq!(convert(Time, Dint, 300_000), 300_000);
    assert_eq!(convert(Tod, Sint, 12), 12);
    assert_eq!(convert(Real, Time, real(1.5)), 2);
    assert_eq!(convert(Char, Int, 65), 65);
}

/// What a conversion with this name gives.
fn named(key: &str, cell: i64) -> i64 {
    let conversion = parse_conversion(key).unwrap();
    let Some(ConversionSide::Scalar(from)) = conversion.from else { panic!("{key}") };
    let crate::library::Body::Scalar(body) = conversion.function().unwrap().body else { panic!("{key}") };
    body(from, &[cell])
}

#[test]
fn towards_zero() {
    for (number, whole) in
        [(1.9, 1), (-1.9, -1), (0.999, 0), (2.5, 2), (-1e30, 0), (f64::NAN, 0), (32_768.9, -32_768)]
    {
        assert_eq!(named("LREAL_TRUNC_INT", number.to_bits() as i64), whole, "{number}");
    }
    assert_eq!(named("LREAL_TRUNC_ULINT", 1.8e19_f64.to_bits() as i64) as u64, 18_000_000_000_000_000_000);
    assert_eq!(named("REAL_TRUNC_DINT", i64::from((-7.99f32).to_bits())), -7);
}

#[test]
fn decimals_in_four_bits() {
    // The first ones are the examples and the ranges in the documents of the controllers' Util library.
    assert_eq!(named("BYTE_BCD_TO_INT", 73), 49);
    assert_eq!(named("BYTE_BCD_TO_INT", 151), 97);
    assert_eq!(named("BYTE_BCD_TO_INT", 15), -1);
    assert_eq!(named("INT_TO_BCD", 49), 73);
    assert_eq!(named("INT_TO_BCD", 97), 151);
    assert_eq!(named("INT_TO_BCD", 100), 255);
    assert_eq!(named("INT_TO_BCD", -1), 255);
    assert_eq!(named("WORD_BCD_TO_UINT", 0x9999), 9999);
    assert_eq!(named("WORD_BCD_TO_USINT", 0x0300), 300 - 256);
    assert_eq!(named("LWORD_BCD_TO_ULINT", 0x9999_9999_9999_9999u64 as i64), 9_999_999_999_999_999);
    assert_eq!(named("LWORD_BCD_TO_ULINT", 0xA000_0000_0000_0000u64 as i64), -1);
    assert_eq!(named("UINT_TO_BCD_WORD", 1234), 0x1234);
    assert_eq!(named("UINT_TO_BCD_WORD", 10_000), 0xFFFF);
    assert_eq!(named("ULINT_TO_BCD_LWORD", -1), -1);
    assert_eq!(named("ULINT_TO_BCD_LWORD", 9_999_999_999_999_999) as u64, 0x9999_9999_9999_9999);
}

#[test]
fn names_of_conversions() {
    let plain = |from, to| Some(Conversion { from, to, how: How::Plain });
    let scalar = |ty| Some(ConversionSide::Scalar(ty));
    assert_eq!(parse_conversion("INT_TO_REAL"), plain(scalar(Int), ConversionSide::Scalar(Real)));
    assert_eq!(parse_conversion("DATE_AND_TIME_TO_TOD"), plain(scalar(Dt), ConversionSide::Scalar(Tod)));
    assert_eq!(parse_conversion("DT_TO_TIME_OF_DAY"), plain(scalar(Dt), ConversionSide::Scalar(Tod)));
    assert_eq!(parse_conversion("LTOD_TO_STRING"), plain(scalar(Ltod), ConversionSide::String));
    assert_eq!(
        parse_conversion("STRING_TO_WSTRING"),
        plain(Some(ConversionSide::String), ConversionSide::Wstring)
    );
    assert_eq!(parse_conversion("TO_LDT"), plain(None, ConversionSide::Scalar(Ldt)));
    assert_eq!(parse_conversion("ANY_TO_BYTE"), plain(None, ConversionSide::Scalar(Byte)));
    let trunc = |from, to| Some(Conversion { from, to: ConversionSide::Scalar(to), how: How::Truncate });
    assert_eq!(parse_conversion("TRUNC"), trunc(None, Dint));
    assert_eq!(parse_conversion("TRUNC_INT"), trunc(None, Int));
    assert_eq!(parse_conversion("LREAL_TRUNC_LINT"), trunc(scalar(Lreal), Lint));
    let bcd = |from, to, how| Some(Conversion { from, to: ConversionSide::Scalar(to), how });
    assert_eq!(parse_conversion("BYTE_BCD_TO_USINT"), bcd(scalar(Byte), Usint, How::FromBcd));
    assert_eq!(parse_conversion("BCD_TO_INT"), bcd(None, Int, How::FromBcd));
    assert_eq!(parse_conversion("TO_BCD_WORD"), bcd(None, Word, How::ToBcd));
    assert_eq!(parse_conversion("UINT_TO_BCD_WORD"), bcd(scalar(Uint), Word, How::ToBcd));
    assert_eq!(parse_conversion("DWORD_TO_BCD"), bcd(scalar(Dword), Dword, How::ToBcd));
    for key in [
        "",
        "TO_",
        "_TO_INT",
        "INT_TO_",
        "INT_TO",
        "TO_FOO",
        "FOO_TO_INT",
        "INT_TO_INT_TO_INT",
        "TRUNC_REAL",
        "INT_TRUNC_DINT",
        "TRUNC_STRING",
        "INT_BCD_TO_INT",
        "STRING_TO_BCD",
        "BCD_TO_STRING",
        "BCD",
        "TO_BCD",
        "INT_TO_BCD_INT",
        "GOTO_INT",
        "AUTO_BYTE",
        "_BCD_TO_INT",
        "TO_BCD_",
        "ÄTO_INT",
        "TO_TO_INT",
    ] {
        assert_eq!(parse_conversion(key), None, "{key}");
    }
    for from in Elementary::ALL {
        for to in Elementary::ALL {
            let key = format!("{}_TO_{}", from.name(), to.name());
            assert_eq!(parse_conversion(&key), plain(scalar(from), ConversionSide::Scalar(to)), "{key}");
        }
    }
}

/// Every conversion that is not plain has its function.
#[test]
fn functions_of_conversions() {
    for ty in Elementary::ALL.into_iter().filter(|ty| ty.is_integer()) {
        for key in
            [format!("TRUNC_{}", ty.name()), format!("BCD_TO_{}", ty.name()), format!("TO_BCD_{}", ty.name())]
        {
            if let Some(conversion) = parse_conversion(&key) {
                assert_eq!(conversion.function().unwrap().name, key);
            } else {
                assert!(key.starts_with("TO_BCD") && !ty.is_bit_string(), "{key}");
            }
        }
    }
    assert!(parse_conversion("INT_TO_REAL").unwrap().function().is_none());
}

fn any_type() -> impl Strategy<Value = Elementary> {
    (0..Elementary::ALL.len()).prop_map(|place| Elementary::ALL[place])
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4096))]

    #[test]
    fn every_cell_converts(from in any_type(), to in any_type(), cell: i64) {
        let found = convert(from, to, cell);
        prop_assert_eq!(found, to.wrap(found));
        prop_assert_eq!(found, expected(from, to, from.wrap(cell)));
    }

    #[test]
    fn any_name_is_looked_up(key in "[A-Z_]{0,6}(TO_|_BCD|TRUNC_){0,3}[A-Z_]{0,6}") {
        parse_conversion(&key);
    }
}
