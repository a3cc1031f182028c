//! Literals in every written form, as initial values, operands and arguments (IEC 61131-3, tables 5 to 9), with the
//! ranges of controller:DT-01.

use crate::support::oracle::verdicts;
use crate::support::{codes, once, sources};
use scanrig_program::{Options, ProgramLimits, compile};
use signal::Value;

/// The value of a literal as an initial value and in a statement; both must agree.
fn value(ty: &str, literal: &str) -> Value {
    let rig = once(&format!("VAR a : {ty} := {literal}; b : {ty}; END_VAR"), &format!("b := {literal};"));
    let (a, b) = (rig.read("a"), rig.read("b"));
    assert!(crate::support::oracle::same(a, b), "{ty} {literal}: {a:?} {b:?}");
    a
}

fn refused(ty: &str, literal: &str) -> Vec<&'static str> {
    codes(&format!("PROGRAM MAIN VAR b : {ty}; END_VAR b := {literal}; END_PROGRAM"))
}

#[test]
fn whole_numbers() {
    for (ty, literal, expected) in [
        ("INT", "0", 0i128),
        ("INT", "+5", 5),
        ("INT", "-32768", -32768),
        ("INT", "1_000", 1000),
        ("INT", "2#1010_1010", 170),
        ("INT", "8#17", 15),
        ("INT", "16#7fFF", 0x7FFF),
        ("INT", "-16#8000", -32768),
        ("INT", "INT#5", 5),
        ("INT", "int#-5", -5),
        ("INT", "INT#16#7F", 127),
        ("INT", "SINT#-1", -1),
        ("SINT", "-128", -128),
        ("USINT", "255", 255),
        ("UINT", "UINT#2#1111", 15),
        ("UDINT", "16#FFFF_FFFF", 0xFFFF_FFFF),
        ("DINT", "-2147483648", -2_147_483_648),
        ("LINT", "-9223372036854775808", i64::MIN.into()),
        ("ULINT", "18446744073709551615", u64::MAX.into()),
        ("ULINT", "ULINT#16#FFFF_FFFF_FFFF_FFFF", u64::MAX.into()),
        ("BYTE", "16#FF", 255),
        ("BYTE", "BYTE#2#1000_0001", 129),
        ("WORD", "WORD#16#ABCD", 0xABCD),
        ("DWORD", "8#37777777777", 0xFFFF_FFFF),
        ("LWORD", "LWORD#16#8000_0000_0000_0000", 1 << 63),
        ("BOOL", "TRUE", 1),
        ("BOOL", "false", 0),
        ("BOOL", "1", 1),
        ("BOOL", "BOOL#0", 0),
        ("BOOL", "BOOL#TRUE", 1),
        ("CHAR", "'A'", 65),
        ("CHAR", "CHAR#'$$'", 36),
        ("WCHAR", "\"$20AC\"", 0x20AC),
        ("DINT", "INT#-32768", -32768),
    ] {
        assert_eq!(value(ty, literal).as_int(), Some(expected), "{ty} {literal}");
    }
    for (ty, literal, code) in [
        ("INT", "32768", "S0303"),
        ("INT", "-32769", "S0303"),
        ("INT", "16#FFFF", "S0303"),
        ("INT", "INT#40000", "S0303"),
        ("USINT", "-1", "S0303"),
        ("UINT", "65536", "S0303"),
        ("DINT", "4294967296", "S0303"),
        ("BYTE", "256", "S0303"),
        ("ULINT", "18446744073709551616", "S0105"),
        ("INT", "2#102", "S0105"),
        ("INT", "8#8", "S0105"),
        ("INT", "3#1", "S0105"),
        ("INT", "1__0", "S0105"),
        ("INT", "16#", "S0105"),
        ("BOOL", "2", "S0302"),
        ("INT", "TRUE", "S0302"),
        ("INT", "1.0", "S0302"),
        ("INT", "'1'", "S0302"),
        ("CHAR", "'AB'", "S0302"),
        ("WCHAR", "'A'", "S0302"),
    ] {
        assert_eq!(refused(ty, literal), [code], "{ty} {literal}");
    }
}

/// controller:DT-01: 0 and the normal magnitudes, whatever makes the number.
#[test]
fn reals_outside_of_their_ranges() {
    for (ty, literal, code) in [
        ("REAL", "3.5E38", "S0303"),
        ("REAL", "-3.5E38", "S0303"),
        ("REAL", "1.0E39", "S0303"),
        ("REAL", "1.0E-39", "S0303"),
        ("REAL", "-1.0E-39", "S0303"),
        ("REAL", "1.0E-60", "S0303"),
        ("REAL", "REAL#1.0E39", "S0303"),
        ("REAL", "REAL#1.0E-39", "S0303"),
        ("REAL", "1.0E30 * 1.0E30", "S0303"),
        ("LREAL", "REAL#1.0E39", "S0303"),
        ("LREAL", "1.0E308 * 10.0", "S0303"),
        ("LREAL", "1.0E-308", "S0105"),
        ("LREAL", "LREAL#4.9E-324", "S0105"),
        ("LREAL", "1.0E309", "S0105"),
        ("REAL", "1.0E-400", "S0105"),
    ] {
        assert_eq!(refused(ty, literal), [code], "{ty} {literal}");
    }
    // Initial values that constants come to; the same product of a statement is what IEEE 754 says.
    for value in ["big", "REAL#1.0E30 * REAL#1.0E30", "LREAL_TO_REAL(big)"] {
        let constant = "VAR CONSTANT big : LREAL := 1.0E300; END_VAR";
        let text = format!("PROGRAM MAIN {constant} VAR r : REAL := {value}; END_VAR END_PROGRAM");
        assert_eq!(codes(&text), ["S0303"], "{value}");
    }
    assert!(refused("REAL", "REAL#1.0E30 * REAL#1.0E30").is_empty());
}

/// controller:DT-01: how long a text may be is the controller's.
#[test]
fn texts_have_the_length_that_the_controller_allows() {
    for (limit, length, fits) in
        [(255, 255, true), (255, 256, false), (65_535, 65_535, true), (65_535, 65_536, false)]
    {
        for ty in [format!("STRING({length})"), format!("WSTRING[{length}]")] {
            let text = format!("PROGRAM MAIN VAR t : {ty}; END_VAR END_PROGRAM");
            let limits = ProgramLimits { text: limit, ..ProgramLimits::default() };
            let found = compile(&sources(&text), &Options { limits, ..Options::default() });
            let codes =
                found.err().unwrap_or_default().into_iter().map(|found| found.code).collect::<Vec<_>>();
            let expected: &[&str] = if fits { &[] } else { &["S0204"] };
            assert_eq!(codes, expected, "{ty} with at most {limit}");
        }
    }
}

#[test]
fn reals() {
    for (literal, expected) in [
        ("1.5", 1.5),
        ("-1.5", -1.5),
        ("+0.25", 0.25),
        ("1E3", 1000.0),
        ("1.0e-3", 0.001),
        ("1_000.5", 1000.5),
        ("6.02214_07", 6.022_140_7),
        ("1.34E-12", 1.34E-12),
        ("1.0E+6", 1_000_000.0),
        ("-0.0", -0.0),
        ("5", 5.0),
        ("16777217", 16_777_217.0),
        ("0.1", 0.1),
        ("3.4028234663852886E38", f64::from(f32::MAX)),
        ("1.175494351E-38", 1.175494351E-38),
    ] {
        let double: f64 = expected;
        let single = literal.replace('_', "").trim_start_matches('+').parse::<f32>().unwrap();
        assert_eq!(value("LREAL", literal).as_real().map(f64::to_bits), Some(double.to_bits()), "{literal}");
        assert_eq!(
            value("REAL", literal).as_real().map(f64::to_bits),
            Some(signal::of_single(single).to_bits()),
            "{literal}"
        );
        // With the type in front.
        assert_eq!(value("REAL", &format!("REAL#{literal}")).as_real(), Some(signal::of_single(single)));
        assert_eq!(value("LREAL", &format!("LREAL#{literal}")).as_real(), Some(double));
    }
    assert_eq!(value("LREAL", "1.7976931348623157E308").as_real(), Some(f64::MAX));
    assert_eq!(refused("LREAL", "1.0E309"), ["S0105"]);
    assert_eq!(refused("REAL", "1_.0"), ["S0105"]);
}

#[test]
fn durations() {
    let (milli, second) = (1_000_000i128, 1_000_000_000);
    for (literal, nanos) in [
        ("T#14ms", 14 * milli),
        ("T#14.7s", 14_700 * milli),
        ("T#14.7m", 882 * second),
        ("T#14.7h", 52_920 * second),
        ("t#14.7d", 1_270_080 * second),
        ("T#25h15m", 90_900 * second),
        ("T#5d14h12m18s35ms", 483_138_035 * milli),
        ("t#5d_14h_12m_18s_35ms", 483_138_035 * milli),
        ("TIME#1h", 3_600 * second),
        ("time#1H1M", 3_660 * second),
        ("T#90m", 5_400 * second),
        ("T#36h", 129_600 * second),
        ("T#0s", 0),
        ("T#+1s", second),
        ("T#4294967295ms", 4_294_967_295 * milli),
        ("T#49d17h2m47s295ms", 4_294_967_295 * milli),
        // What is finer than a millisecond is cut off.
        ("T#5.5ms", 5 * milli),
        ("T#1.2345s", 1_234 * milli),
    ] {
        assert_eq!(value("TIME", literal).as_int(), Some(nanos), "{literal}");
        // A short one goes into a long one.
        assert_eq!(value("LTIME", literal).as_int(), Some(nanos), "{literal}");
    }
    for (literal, nanos) in [
        ("LTIME#1ns", 1),
        ("LT#1us1ns", 1_001),
        ("LTIME#1d2h3m4s5ms6us7ns", 93_784_005_006_007),
        ("LTIME#0.5us", 500),
        ("LTIME#106751d23h47m16s854ms775us807ns", i64::MAX.into()),
    ] {
        assert_eq!(value("LTIME", literal).as_int(), Some(nanos), "{literal}");
    }
    for (ty, literal) in [
        ("TIME", "T#"),
        ("TIME", "T#5"),
        ("TIME", "T#5x"),
        ("TIME", "T#1s1h"),
        ("TIME", "T#-5s"),
        ("TIME", "T#4294967296ms"),
        ("TIME", "T#1us"),
        ("TIME", "T#1.5h30m"),
        ("LTIME", "LTIME#0.1ns"),
        ("LTIME", "LTIME#106752d"),
    ] {
        assert_eq!(refused(ty, literal), ["S0106"], "{literal}");
    }
    assert_eq!(refused("TIME", "LTIME#1s"), ["S0302"]);
    assert_eq!(refused("TIME", "5"), ["S0302"]);
}

#[test]
fn dates() {
    // Seconds as `date -u -d` gives them.
    let second = 1_000_000_000i128;
    for (ty, literal, nanos) in [
        ("DATE", "D#1970-01-01", 0),
        ("DATE", "DATE#2024-02-29", 1_709_164_800 * second),
        ("DATE", "d#2000-02-29", 951_782_400 * second),
        ("DATE", "D#2100-03-01", 4_107_542_400 * second),
        ("DATE", "D#2106-02-07", 4_294_944_000 * second),
        ("DATE", "D#1984-6-5", 455_241_600 * second),
        ("TOD", "TOD#00:00:00", 0),
        ("TOD", "TIME_OF_DAY#15:36:55.36", 56_215_360_000_000),
        ("TOD", "tod#23:59:59.999", 86_399_999_000_000),
        ("DT", "DT#1970-01-01-00:00:01", second),
        ("DT", "DATE_AND_TIME#2024-02-29-12:34:56", 1_709_210_096 * second),
        ("DT", "dt#2106-02-07-06:28:15", 4_294_967_295 * second),
        ("LDATE", "LDATE#2024-02-29", 1_709_164_800 * second),
        ("LDATE", "LD#2262-04-11", 9_223_372_800 * second - 86_400 * second),
        ("LTOD", "LTOD#15:36:55.360227400", 56_215_360_227_400),
        ("LDT", "LDT#1984-06-25-15:36:55.360227400", 457_025_815_360_227_400),
        ("LDT", "LDATE_AND_TIME#1970-01-01-00:00:00.000000001", 1),
    ] {
        assert_eq!(value(ty, literal).as_int(), Some(nanos), "{literal}");
    }
    for literal in [
        "D#2023-02-29",
        "D#1900-01-01",
        "D#2024-13-01",
        "D#2024-04-31",
        "D#2024-01-00",
        "D#2106-02-08",
        "D#2024-01",
        "TOD#24:00:00",
        "TOD#12:60:00",
        "TOD#12:00:60",
        "TOD#12:00:00.0001",
        "DT#2024-02-29",
        "DT#2024-02-29-25:00:00",
        "DT#2106-02-07-06:28:16",
        "DT#2024-01-01-00:00:00.5",
        "LDATE#2262-04-12",
    ] {
        let ty = literal.split('#').next().unwrap();
        assert_eq!(refused(ty, literal), ["S0111"], "{literal}");
    }
}

#[test]
fn names_with_a_type_in_front() {
    let rig = crate::support::once(
        "VAR a, b : INT; END_VAR",
        "a := INT#7 + INT#16#10; b := DINT_TO_INT(DINT#100000 MOD DINT#65536);",
    );
    assert_eq!((rig.int("a"), rig.int("b")), (23, 34_464 - 65_536));
    let mut rig = crate::support::Rig::new(
        "TYPE colour : (red, green := 5, blue); small : INT(-5..5); speed : UINT; END_TYPE
         PROGRAM MAIN VAR c : colour := colour#green; d : colour := blue; s : small := -5; v : speed := 16#FF; e : colour; n : INT; END_VAR
           e := colour#red; IF c = green THEN n := n + 1; END_IF; IF d > colour#green THEN n := n + 10; END_IF;
         END_PROGRAM",
    );
    rig.cycle();
    assert_eq!(["c", "d", "e", "s", "v", "n"].map(|path| rig.int(path)), [5, 6, 0, -5, 255, 11]);
    assert_eq!(
        codes("TYPE small : INT(-5..5); END_TYPE PROGRAM MAIN VAR s : small := 6; END_VAR END_PROGRAM"),
        ["S0303"]
    );
    assert_eq!(
        codes("TYPE c : (red); END_TYPE PROGRAM MAIN VAR s : c := c#blue; END_VAR END_PROGRAM"),
        ["S0301"]
    );
}

#[test]
fn initial_values_of_structures_and_arrays() {
    let rig = crate::support::Rig::new(
        "TYPE point : STRUCT x : INT := 3; y : REAL; name : STRING[5] := 'p'; END_STRUCT; line : STRUCT a, b : point := (x := 9); END_STRUCT; END_TYPE
         VAR_GLOBAL CONSTANT size : INT := 2; END_VAR
         PROGRAM MAIN VAR
           p : point; q : point := (y := 1.5, x := -1); l : line := (b := (name := 'end'));
           a : ARRAY[0..size] OF INT := [1, 2(7)]; m : ARRAY[1..2, 1..3] OF INT := [1, 2, 3, 4]; s : ARRAY[0..1] OF point := [(x := 4), (x := 5)];
           n : ARRAY[0..1] OF ARRAY[0..1] OF BYTE := [[1, 2], [3, 16#FF]]; few : ARRAY[0..4] OF DINT := [3(-1)]; z : ARRAY[-1..0] OF BOOL := [TRUE];
         END_VAR END_PROGRAM",
    );
    for (path, expected) in [
        ("p.x", 3),
        ("q.x", -1),
        ("l.a.x", 9),
        ("l.b.x", 9),
        ("a[0]", 1),
        ("a[2]", 7),
        ("m[1,1]", 1),
        ("m[1,3]", 3),
        ("m[2,1]", 4),
        ("m[2,2]", 0),
        ("s[1].x", 5),
        ("n[1][1]", 255),
        ("few[2]", -1),
        ("few[3]", 0),
        ("z[-1]", 1),
        ("z[0]", 0),
    ] {
        assert_eq!(rig.int(path), expected, "{path}");
    }
    assert_eq!(rig.read("q.y"), Value::Real(1.5));
    for (declaration, code) in [
        ("a : ARRAY[0..1] OF INT := [1, 2, 3];", "S0213"),
        ("a : ARRAY[0..1] OF INT := [1.5];", "S0302"),
        ("p : point := (z := 1);", "S0213"),
        ("p : point := (x := 1, x := 2);", "S0213"),
        ("i : INT := j; j : INT;", "S0203"),
    ] {
        let text = format!(
            "TYPE point : STRUCT x, y : INT; END_STRUCT; END_TYPE PROGRAM MAIN VAR {declaration} END_VAR END_PROGRAM"
        );
        assert_eq!(codes(&text), [code], "{declaration}");
    }
}

#[test]
fn a_real_compared_with_a_number_that_it_does_not_hold_is_warned_of() {
    let declarations = "VAR_GLOBAL r : REAL; l : LREAL; i : INT; x : BOOL; END_VAR";
    let cases = [
        ("x := r = 0.1;", true),
        ("x := 16777217.0 <> r;", true),
        ("x := EQ(r, -0.3);", true),
        ("x := r = REAL#0.1;", false),
        ("x := r = 0.5;", false),
        ("x := r = 0;", false),
        ("x := r < 0.1;", false),
        ("x := l = 0.1;", false),
        ("x := ABS(r - 0.1) < 0.001;", false),
    ];
    let statements: Vec<String> = cases.iter().map(|(text, _)| text.to_string()).collect();
    for ((text, warned), found) in cases.iter().zip(verdicts(declarations, &statements)) {
        assert_eq!(found.contains(&"S0310"), *warned, "{text}: {found:?}");
    }
    // The literal is of the type that it stands beside.
    let rig =
        once("VAR r : REAL := 0.1; l : LREAL; a, b : BOOL; END_VAR", "a := r = 0.1; l := r; b := l = 0.1;");
    assert!(rig.on("a") && !rig.on("b"));
}
