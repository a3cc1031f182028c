//! No text makes the parser panic, run on without end or build a tree that is too deep to walk.

use super::read;
use proptest::prelude::*;

/// Words and signs that the language has, and some that it has not.
const PIECES: &[&str] = &[
    "PROGRAM",
    "END_PROGRAM",
    "FUNCTION",
    "END_FUNCTION",
    "FUNCTION_BLOCK",
    "END_FUNCTION_BLOCK",
    "METHOD",
    "END_METHOD",
    "PROPERTY",
    "END_PROPERTY",
    "GET",
    "END_GET",
    "SET",
    "END_SET",
    "ACTION",
    "END_ACTION",
    "INTERFACE",
    "END_INTERFACE",
    "TYPE",
    "END_TYPE",
    "STRUCT",
    "END_STRUCT",
    "UNION",
    "END_UNION",
    "CONFIGURATION",
    "END_CONFIGURATION",
    "RESOURCE",
    "ON",
    "END_RESOURCE",
    "TASK",
    "WITH",
    "NAMESPACE",
    "END_NAMESPACE",
    "CLASS",
    "END_CLASS",
    "USING",
    "VAR",
    "VAR_INPUT",
    "VAR_IN_OUT",
    "VAR_GLOBAL",
    "VAR_CONFIG",
    "VAR_ACCESS",
    "VAR_TEMP",
    "END_VAR",
    "CONSTANT",
    "RETAIN",
    "PERSISTENT",
    "NON_RETAIN",
    "AT",
    "PUBLIC",
    "PRIVATE",
    "ABSTRACT",
    "FINAL",
    "EXTENDS",
    "IMPLEMENTS",
    "ARRAY",
    "OF",
    "POINTER",
    "TO",
    "REF_TO",
    "REFERENCE",
    "STRING",
    "WSTRING",
    "OVERLAP",
    "R_EDGE",
    "a",
    "b",
    "F",
    "MAIN",
    "S",
    "R",
    "REF",
    "LD",
    "STEP",
    "TRANSITION",
    "JMP",
    "__TRY",
    "__ENDTRY",
    "INT",
    "BOOL",
    "TON",
    "THIS",
    "SUPER",
    "NULL",
    "TRUE",
    "NOT",
    "AND",
    "OR",
    "XOR",
    "MOD",
    "AND_THEN",
    "IF",
    "THEN",
    "ELSIF",
    "ELSE",
    "END_IF",
    "CASE",
    "END_CASE",
    "FOR",
    "BY",
    "DO",
    "END_FOR",
    "WHILE",
    "END_WHILE",
    "REPEAT",
    "UNTIL",
    "END_REPEAT",
    "EXIT",
    "RETURN",
    ":",
    ":=",
    "?=",
    ";",
    ",",
    "(",
    ")",
    "[",
    "]",
    ".",
    "..",
    "=>",
    "=",
    "<>",
    "<",
    "+",
    "-",
    "*",
    "**",
    "/",
    "&",
    "^",
    "#",
    "%MW5",
    "%I*",
    "%X3",
    "%",
    "%B1.3.4",
    "1",
    "16#FF",
    "1.5",
    "1e5",
    "1e999",
    "99999999999999999999999",
    "INT#",
    "INT#-5",
    "BOOL#2",
    "colour#",
    "T#5s",
    "T#",
    "LTIME#1ns",
    "D#2024-02-30",
    "DT#1970-01-01-00:00:00",
    "TOD#25:0",
    "'s$41'",
    "'$",
    "\"w\"",
    "CHAR#",
    "(*",
    "*)",
    "/*",
    "*/",
    "//",
    "{",
    "}",
    "{IF x}",
    "\n",
    "?",
    "\u{e9}",
    "\u{0}",
    "\u{feff}",
];

/// Reads, and walks the tree by recursion. Every finding has a place in the text.
fn survive(text: &str) {
    let (unit, names, findings) = read(text);
    let printed = format!("{unit:?}");
    assert!(!printed.is_empty() && names.get("PROGRAM").is_some());
    for finding in &findings {
        for label in &finding.labels {
            assert!(text.get(label.span.clone()).is_some(), "{finding:?}");
        }
    }
    if findings.is_empty() {
        super::print::print(&unit, &names);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    #[test]
    fn any_text(text in "\\PC*") {
        survive(&text);
    }

    #[test]
    fn any_bytes(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
        survive(&String::from_utf8_lossy(&bytes));
    }

    #[test]
    fn any_tokens(pieces in proptest::collection::vec(prop::sample::select(PIECES.to_vec()), 0..80)) {
        survive(&pieces.join(" "));
        survive(&format!("FUNCTION_BLOCK f VAR {} END_VAR", pieces.join(" ")));
        survive(&format!("PROGRAM p {}", pieces.join(" ")));
        survive(&format!("TYPE {}", pieces.join(" ")));
        survive(&format!("CONFIGURATION c {}", pieces.join(" ")));
        survive(&format!("PROGRAM p CASE a OF {}", pieces.join(" ")));
    }
}

#[test]
fn depth_is_bounded() {
    let nests: &[(&str, &str, &str)] = &[
        ("PROGRAM p a := ", "(", "1"),
        ("PROGRAM p a := ", "NOT ", "b"),
        ("PROGRAM p a := ", "- ", "b"),
        ("PROGRAM p a := ", "a[", "1"),
        ("PROGRAM p a := ", "f(", "1"),
        ("PROGRAM p a := a", ".b", ""),
        ("PROGRAM p a := a", "^", ""),
        ("PROGRAM p a := a", "[1]", ""),
        ("PROGRAM p a := a", ".%X1", ""),
        ("PROGRAM p ", "IF a THEN ", ""),
        ("PROGRAM p ", "CASE a OF 1: ", ""),
        ("PROGRAM p ", "FOR a := 1 TO 2 DO ", ""),
        ("PROGRAM p ", "WHILE a DO ", ""),
        ("PROGRAM p ", "REPEAT ", ""),
        ("PROGRAM p VAR a : ", "ARRAY[1..2] OF ", "INT"),
        ("PROGRAM p VAR a : ", "POINTER TO ", "INT"),
        ("PROGRAM p VAR a : ", "STRUCT a : ", "INT"),
        ("PROGRAM p VAR a : INT := ", "[", "1"),
        ("PROGRAM p VAR a : INT := ", "(a := ", "1"),
        ("PROGRAM p VAR a : INT := ", "2(", "1"),
        ("PROGRAM p VAR a : INT := [", "2(", "1"),
    ];
    for (start, nest, end) in nests {
        for count in [50_000, 70, 64, 63, 60] {
            let text = format!("{start}{}{end}", nest.repeat(count));
            survive(&text);
            let (_, _, findings) = read(&text);
            let deep = findings.iter().any(|finding| finding.code == "S0107");
            assert!(deep || count < 50_000 || *nest == "2(", "{start}{nest}");
        }
    }
    // Wide is not deep.
    survive(&format!("PROGRAM p a := 1{};", " + 1".repeat(50_000)));
    // Depth that comes from several kinds of nesting.
    let after = format!("]{}", ".b".repeat(60));
    let (_, _, findings) = read(&format!("PROGRAM p a := {}1{}", "a[".repeat(40), after.repeat(40)));
    assert!(findings.iter().any(|finding| finding.code == "S0107"));
}

#[test]
fn long_broken_texts_end_soon() {
    for piece in [
        "; ",
        "a : ",
        "TYPE a ; ",
        "STRUCT ; ",
        "( ",
        ", ",
        "CASE a OF a. ",
        "INT(",
        "a : T(",
        "a.b.c.d.",
        "END_IF ",
        "'",
        "a ",
    ] {
        for start in ["", "TYPE x ", "PROGRAM p ", "PROGRAM p VAR ", "PROGRAM p CASE a OF "] {
            survive(&format!("{start}{}", piece.repeat(200_000 / piece.len())));
        }
    }
    // Names before a type are not copied without end.
    let text = format!(
        "PROGRAM p VAR {}a : ARRAY[0..9] OF INT := [{}1]; END_VAR END_PROGRAM",
        "a, ".repeat(50_000),
        "1, ".repeat(50_000)
    );
    let (_, _, findings) = read(&text);
    assert_eq!(findings.len(), 1);
}
