//! No text makes the compiler panic, hang or grow without bound, and no accepted program hangs the machine.

use crate::support::{Memory, codes, sources};
use proptest::prelude::*;
use scanrig_program::{Machine, Options, ProgramLimits, compile};
use signal::{Span, Time};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Pieces from which texts are put together.
const PIECES: &[&str] = &[
    "PROGRAM",
    "END_PROGRAM",
    "FUNCTION",
    "END_FUNCTION",
    "FUNCTION_BLOCK",
    "END_FUNCTION_BLOCK",
    "VAR",
    "VAR_INPUT",
    "VAR_OUTPUT",
    "VAR_GLOBAL",
    "END_VAR",
    "CONSTANT",
    "RETAIN",
    "PERSISTENT",
    "a",
    "b",
    "x",
    "F",
    "MAIN",
    "t",
    ":",
    ":=",
    ";",
    ",",
    "(",
    ")",
    "[",
    "]",
    ".",
    "..",
    "=>",
    "+",
    "-",
    "*",
    "/",
    "MOD",
    "AND",
    "OR",
    "XOR",
    "NOT",
    "=",
    "<>",
    "<",
    ">",
    "IF",
    "THEN",
    "ELSIF",
    "ELSE",
    "END_IF",
    "CASE",
    "OF",
    "END_CASE",
    "FOR",
    "TO",
    "BY",
    "DO",
    "END_FOR",
    "WHILE",
    "END_WHILE",
    "REPEAT",
    "UNTIL",
    "END_REPEAT",
    "EXIT",
    "CONTINUE",
    "RETURN",
    "INT",
    "BOOL",
    "TIME",
    "TON",
    "ARRAY",
    "AT",
    "%QX0.0",
    "%MW5",
    "%IX0.1",
    "%S3",
    "1",
    "0",
    "16#FF",
    "T#5s",
    "INT#3",
    "TRUE",
    "SEL",
    "MIN",
    "INT_TO_BOOL",
    "SHL",
    "(*",
    "*)",
    "//",
    "{",
    "}",
    "'s'",
    "\n",
    "REAL",
    "STRUCT",
    "TYPE",
    "1.5",
    "?",
    "\u{e9}",
];

const VALID: &str = include_str!("valid.st");

/// Compiles, and runs what compiles for a millisecond.
fn survive(text: &str) {
    if let Ok(program) = compile(&sources(text), &Options::default()) {
        let all = (0..program.programs().len()).collect();
        let mut machine = Machine::new(Arc::new(program), &[all]).unwrap();
        machine.begin(0);
        let mut memory = Memory::default();
        machine.resume(0, Time::ZERO, Span::from_millis(1), &mut memory);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn any_text(text in "\\PC*") {
        survive(&text);
    }

    #[test]
    fn any_tokens(pieces in proptest::collection::vec(prop::sample::select(PIECES.to_vec()), 0..80)) {
        survive(&pieces.join(" "));
        survive(&format!("PROGRAM MAIN VAR a, b : INT; x : BOOL; t : TON; END_VAR {}", pieces.join(" ")));
    }

    #[test]
    fn mutations_of_a_valid_program(
        cuts in proptest::collection::vec((0..VALID.len(), 0..12usize, prop::sample::select(PIECES.to_vec())), 1..6),
    ) {
        let mut bytes = VALID.as_bytes().to_vec();
        for (at, length, piece) in cuts {
            let at = at.min(bytes.len());
            let end = (at + length).min(bytes.len());
            bytes.splice(at..end, piece.bytes());
        }
        survive(&String::from_utf8_lossy(&bytes));
    }
}

#[test]
fn the_valid_program_is_valid() {
    assert_eq!(codes(VALID), Vec::<&str>::new());
}

#[test]
fn nesting_is_bounded() {
    let deep = |open: &str, core: &str, close: &str| {
        let body = format!("{}{core}{}", open.repeat(100_000), close.repeat(100_000));
        codes(&format!("PROGRAM MAIN VAR a : INT; x : BOOL; END_VAR {body} END_PROGRAM"))
    };
    for found in [
        deep("a := (", "1", ");"),
        deep("a := -", "1", ";"),
        deep("IF x THEN ", ";", "END_IF;"),
        deep("a := MIN(1,", "1", ")"),
        deep("FOR a := 1 TO 2 DO ", ";", " END_FOR;"),
    ] {
        assert!(!found.is_empty() && found.len() <= 51, "{} errors", found.len());
    }
    let brackets = format!("a := {}1{};", "(".repeat(100_000), ")".repeat(100_000));
    assert_eq!(codes(&format!("PROGRAM MAIN VAR a : INT; END_VAR {brackets} END_PROGRAM")), ["S0107"]);
    // Comments may nest as deeply as they like.
    let comment = format!("{}{}", "(*".repeat(100_000), "*)".repeat(100_000));
    assert_eq!(codes(&format!("PROGRAM MAIN {comment} END_PROGRAM")), Vec::<&str>::new());
}

#[test]
fn long_chains_are_no_nesting() {
    let chain = "1 + ".repeat(50_000);
    let text = format!(
        "PROGRAM MAIN VAR a : DINT; END_VAR a := {chain} a; a := a{}; END_PROGRAM",
        " - 1".repeat(50_000)
    );
    assert_eq!(codes(&text), Vec::<&str>::new());
    let arms = "ELSIF a = 1 THEN a := 2; ".repeat(20_000);
    assert_eq!(
        codes(&format!("PROGRAM MAIN VAR a : INT; END_VAR IF a = 0 THEN ; {arms} END_IF; END_PROGRAM")),
        Vec::<&str>::new()
    );
}

#[test]
fn blocks_inside_blocks_are_bounded() {
    let mut text = String::from("FUNCTION_BLOCK b0 END_FUNCTION_BLOCK\n");
    for n in 1..60 {
        text += &format!("FUNCTION_BLOCK b{n} VAR x, y : b{}; END_VAR END_FUNCTION_BLOCK\n", n - 1);
    }
    // 2^59 instances do not fit, and that is found out without trying.
    let program = format!("{text} PROGRAM MAIN VAR x : b59; END_VAR x(); END_PROGRAM");
    assert!(codes(&program).contains(&"S0502"));
    // Chains are bounded whichever way round they are declared.
    for reverse in [false, true] {
        let mut blocks: Vec<String> = (1..200)
            .map(|n| format!("FUNCTION_BLOCK b{n} VAR x : b{}; END_VAR END_FUNCTION_BLOCK\n", n - 1))
            .collect();
        blocks.push("FUNCTION_BLOCK b0 VAR n : INT; END_VAR END_FUNCTION_BLOCK\n".into());
        if reverse {
            blocks.reverse();
        }
        assert!(
            codes(&(blocks.concat() + "PROGRAM MAIN VAR x : b199; END_VAR END_PROGRAM")).contains(&"S0504")
        );
    }
}

#[test]
fn errors_are_bounded() {
    let found = codes(&format!("PROGRAM MAIN {} END_PROGRAM", "unknown := 1;".repeat(10_000)));
    assert_eq!((found.len(), found.last()), (51, Some(&"S0506")));
    assert!(codes(&"?".repeat(100_000)).len() <= 51);
    let text = "(".repeat(ProgramLimits::default().source + 1);
    assert_eq!(codes(&text), ["S0501"]);
}

#[test]
fn long_programs_and_names_are_reported() {
    let text = format!("PROGRAM MAIN VAR a : INT; END_VAR {} END_PROGRAM", "a := a + 1;".repeat(1000));
    let options =
        |code| Options { limits: ProgramLimits { code, ..ProgramLimits::default() }, ..Options::default() };
    // An addition each, and the return.
    assert!(compile(&sources(&text), &options(1001)).is_ok());
    let findings = compile(&sources(&text), &options(1000)).unwrap_err();
    assert_eq!(findings.iter().map(|f| f.code).collect::<Vec<_>>(), ["S0505"]);
    // controller:DT-03
    let name = "i_udiETHIP_IOMessagingTransmitted";
    let program = crate::support::build(&format!("PROGRAM MAIN VAR {name} : UDINT; END_VAR END_PROGRAM"));
    assert_eq!(program.warnings.iter().map(|f| f.code).collect::<Vec<_>>(), ["S0109"]);
}

#[test]
fn large_arrays_are_refused_at_once() {
    for array in [
        "ARRAY[0..100000000] OF INT",
        "ARRAY[0..2147483647, 0..2147483647, 0..2147483647] OF BOOL",
        "ARRAY[-9223372036854775808..9223372036854775807] OF BYTE",
    ] {
        let text = format!("PROGRAM MAIN VAR a : {array}; END_VAR END_PROGRAM");
        assert_eq!(codes(&text), ["S0502"], "{array}");
    }
}

#[test]
fn large_types_are_counted_together() {
    let mut text = String::new();
    for n in 0..60 {
        text += &format!(
            "TYPE t{n} : STRUCT a : ARRAY[1..30000000] OF BYTE; b : BYTE := 1; END_STRUCT END_TYPE\n"
        );
    }
    assert!(codes(&(text + "PROGRAM MAIN VAR n : INT; END_VAR END_PROGRAM")).contains(&"S0502"));
    let mut text = String::new();
    for n in 0..200 {
        text += &format!("FUNCTION f{n} : INT VAR a : ARRAY[1..1000000] OF BYTE; END_VAR END_FUNCTION\n");
    }
    assert!(codes(&(text + "PROGRAM MAIN VAR n : INT; END_VAR END_PROGRAM")).contains(&"S0502"));
}

#[test]
fn blocks_that_extend_many_are_refused_at_once() {
    for reverse in [false, true] {
        let mut blocks: Vec<String> = (1..4_000)
            .map(|n| format!("FUNCTION_BLOCK b{n} EXTENDS b{} END_FUNCTION_BLOCK\n", n - 1))
            .collect();
        blocks.insert(0, String::from("FUNCTION_BLOCK b0 METHOD m : INT END_METHOD END_FUNCTION_BLOCK\n"));
        if reverse {
            blocks.reverse();
        }
        let began = Instant::now();
        assert!(
            codes(&(blocks.concat() + "PROGRAM MAIN VAR x : b9; END_VAR END_PROGRAM")).contains(&"S0504")
        );
        assert!(began.elapsed() < Duration::from_secs(60), "{:?}", began.elapsed());
    }
}

#[test]
fn interfaces_that_meet_in_one_are_looked_at_once() {
    let mut text =
        String::from("INTERFACE a0 METHOD m : INT END_METHOD END_INTERFACE\nINTERFACE b0 END_INTERFACE\n");
    for n in 1..60 {
        for name in ["a", "b"] {
            text += &format!("INTERFACE {name}{n} EXTENDS a{0}, b{0} END_INTERFACE\n", n - 1);
        }
    }
    text += "FUNCTION_BLOCK f IMPLEMENTS a59 METHOD m : INT m := 1; END_METHOD END_FUNCTION_BLOCK\n";
    text += "PROGRAM MAIN VAR x : f; i : b59; j : b0; END_VAR j := i; i := x; END_PROGRAM";
    let began = Instant::now();
    let found = codes(&text);
    assert!(began.elapsed() < Duration::from_secs(60), "{:?}", began.elapsed());
    // The block implements `a59` and not `b59`.
    assert!(!found.is_empty() && found.len() < 5, "{found:?}");
}

#[test]
fn methods_in_one_line_of_xml_are_read_at_once() {
    let method = |n: usize| {
        format!(
            "<Method Name=\"m{n}\"><Declaration><![CDATA[METHOD m{n} : INT]]></Declaration><Implementation><ST><![CDATA[m{n} := 1;]]></ST></Implementation></Method>"
        )
    };
    let methods: String = (0..20_000).map(method).collect();
    let text = format!(
        "<TcPlcObject><POU Name=\"f\"><Declaration><![CDATA[FUNCTION_BLOCK f]]></Declaration>{methods}</POU></TcPlcObject>"
    );
    let began = Instant::now();
    let source = scanrig_program::source("f.TcPOU", text.as_bytes()).unwrap();
    assert!(source.text.contains("METHOD m19999 : INT") && source.text.lines().count() == 1);
    let many = format!("<POU><Declaration>{}</Declaration></POU>", "&".repeat(4_000_000));
    let _ = scanrig_program::source("f.TcPOU", many.as_bytes());
    assert!(began.elapsed() < Duration::from_secs(60), "{:?}", began.elapsed());
}
