//! What single constructs are read as, where the walk over the grammar leaves a choice open.

use super::super::NameTable;
use super::super::ast::*;
use super::print::print;
use super::read;
use crate::program::Retention;
use crate::types::Elementary;

fn valid(text: &str) -> (SourceUnit, NameTable) {
    let (unit, names, findings) = read(text);
    assert!(findings.is_empty(), "{findings:#?}\n{text}");
    (unit, names)
}

/// The tree as text, grouped by brackets.
fn shown(text: &str) -> String {
    let (unit, names) = valid(text);
    print(&unit, &names).iter().map(|piece| piece.text.as_str()).collect::<Vec<_>>().join(" ")
}

/// A value as it is read.
fn value(text: &str) -> ExprKind {
    let (mut unit, _) = valid(&format!("PROGRAM p x := {text}; END_PROGRAM"));
    match unit.pous.remove(0).body.remove(0).kind {
        StmtKind::Assign { value, .. } => value.kind,
        other => panic!("{other:?}"),
    }
}

#[track_caller]
fn expression(text: &str, expected: &str) {
    assert_eq!(
        shown(&format!("PROGRAM P X := {text} ; END_PROGRAM")),
        format!("PROGRAM P X := {expected} ; END_PROGRAM")
    );
}

#[track_caller]
fn same(text: &str, canonical: &str) {
    assert_eq!(shown(text), shown(canonical));
}

#[test]
fn operators_have_the_precedence_of_the_standard() {
    // IEC 61131-3, table of the operators of the ST language, from the tightest: brackets, calls, ^, signs and NOT,
    // **, * / MOD, + -, < > <= >=, = <>, & AND, XOR, OR.
    expression("a OR b XOR c AND d", "A OR ( B XOR ( C AND D ) )");
    expression("a AND b XOR c OR d", "( ( A AND B ) XOR C ) OR D");
    expression("a OR_ELSE b AND_THEN c", "A OR_ELSE ( B AND_THEN C )");
    expression("a AND b = c", "A AND ( B = C )");
    expression("a = b < c", "A = ( B < C )");
    expression("a <> b >= c + d", "A <> ( B >= ( C + D ) )");
    expression("a + b * c ** d", "A + ( B * ( C ** D ) )");
    expression("a MOD b - c / d", "( A MOD B ) - ( C / D )");
    expression("-a ** b", "( - A ) ** B");
    expression("a ** -b ** c", "A ** ( - B ) ** C");
    expression("NOT a AND NOT b.c[1]^", "( NOT A ) AND ( NOT B . C [ 1 ] ^ )");
    expression("NOT a = b", "( NOT A ) = B");
    expression("- - +a", "- ( - ( + A ) )");
    expression("(a OR b) AND c", "( A OR B ) AND C");
    expression("a - (b - c)", "A - ( B - C )");
    expression("a & b", "A AND B");
    expression("a - b + c - d", "A - B + C - D");
    expression("((a))", "A");
}

#[test]
fn chains_are_flat() {
    let ExprKind::Chain(_, rest) = value("1 - 2 + 3 - 4") else { panic!() };
    let operators: Vec<BinaryOp> = rest.iter().map(|(op, _, _)| *op).collect();
    assert_eq!(operators, [BinaryOp::Subtract, BinaryOp::Add, BinaryOp::Subtract]);
    let ExprKind::Chain(_, rest) = value("2 ** 3 ** 2") else { panic!() };
    assert_eq!(rest.len(), 2);
}

#[test]
fn literals_in_every_written_form() {
    let number = |text: &str| match value(text) {
        ExprKind::Number(n, ty) => (n, ty),
        other => panic!("{text}: {other:?}"),
    };
    assert_eq!(number("1_000"), (1000, None));
    assert_eq!(number("16#FF_ff"), (0xFFFF, None));
    assert_eq!(number("2#1010_0101"), (0xA5, None));
    assert_eq!(number("8#777"), (0o777, None));
    assert_eq!(number("INT#5"), (5, Some(Elementary::Int)));
    assert_eq!(number("int#-5"), (-5, Some(Elementary::Int)));
    assert_eq!(number("SINT#+5"), (5, Some(Elementary::Sint)));
    assert_eq!(number("INT#16#7F"), (0x7F, Some(Elementary::Int)));
    assert_eq!(number("LWORD#16#FFFF_FFFF_FFFF_FFFF"), (u64::MAX.into(), Some(Elementary::Lword)));
    assert_eq!(number("WORD#2#1"), (1, Some(Elementary::Word)));
    for (text, expected) in
        [("TRUE", true), ("false", false), ("BOOL#1", true), ("BOOL#0", false), ("bool#True", true)]
    {
        assert!(matches!(value(text), ExprKind::Bool(value) if value == expected), "{text}");
    }
    let real = |text: &str| match value(text) {
        ExprKind::Real(double, _, ty) => (double, ty),
        other => panic!("{text}: {other:?}"),
    };
    assert_eq!(real("1.0E-3"), (0.001, None));
    assert_eq!(real("1e10"), (1e10, None));
    assert_eq!(real("1_0.2_5"), (10.25, None));
    assert_eq!(real("REAL#-1.5"), (-1.5, Some(Elementary::Real)));
    assert_eq!(real("REAL#3"), (3.0, Some(Elementary::Real)));
    assert_eq!(real("LREAL#1E3"), (1000.0, Some(Elementary::Lreal)));
    let moment = |text: &str| match value(text) {
        ExprKind::Moment(cell, ty) => (cell, ty),
        other => panic!("{text}: {other:?}"),
    };
    assert_eq!(moment("t#1h_1.5m"), (3_690_000, Elementary::Time));
    assert_eq!(moment("LTIME#1ms2us3ns"), (1_002_003, Elementary::Ltime));
    assert_eq!(moment("DATE#1970-01-02"), (86_400, Elementary::Date));
    assert_eq!(moment("time_of_day#00:00:01.5"), (1_500, Elementary::Tod));
    assert_eq!(moment("DATE_AND_TIME#1970-01-01-00:00:59"), (59, Elementary::Dt));
    let text = |text: &str| match value(text) {
        ExprKind::Text { wide, units, typed } => (wide, units, typed),
        other => panic!("{text}: {other:?}"),
    };
    assert_eq!(text("'a$'b'"), (false, vec![97, 39, 98], None));
    assert_eq!(text("\"\u{20ac}\""), (true, vec![0x20AC], None));
    assert_eq!(text("STRING#'a'"), (false, vec![97], None));
    assert_eq!(text("WSTRING#\"a\""), (true, vec![97], None));
    assert_eq!(text("CHAR#'$0A'"), (false, vec![10], Some(Elementary::Char)));
    assert_eq!(text("WCHAR#\"$263A\""), (true, vec![0x263A], Some(Elementary::Wchar)));
}

#[test]
fn bits_and_parts() {
    expression("w.3 + a[1].%X3", "W . %X3 + A [ 1 ] . %X3");
    expression("w.%B1.3", "W . %B1 . %X3");
    expression("%MW10.3", "%MW10.3");
    expression("%MD1.%W1", "%MD1 . %W1");
    expression("lib.colour#red", "COLOUR# RED");
}

#[test]
fn vendor_forms_of_statements() {
    same(
        "PROGRAM p IF a THEN b := 1; END_IF IF a THEN ; ELSE IF b THEN c := 1; END_IF END_IF;; END_PROGRAM",
        "PROGRAM p IF a THEN b := 1; END_IF; IF a THEN ELSE IF b THEN c := 1; END_IF; END_IF; END_PROGRAM",
    );
    same(
        "PROGRAM p REPEAT a := 1; UNTIL b; END_REPEAT END_PROGRAM",
        "PROGRAM p REPEAT a := 1; UNTIL b END_REPEAT; END_PROGRAM",
    );
    same("PROGRAM p f(NOT q => x); END_PROGRAM", "PROGRAM p f(q => NOT x); END_PROGRAM");
    same("PROGRAM p VAR ; a : INT;; END_VAR; END_PROGRAM", "PROGRAM p VAR a : INT; END_VAR END_PROGRAM");
    same("\u{feff}PROGRAM p a S= b; END_PROGRAM;", "program P A s = B ; end_program");
}

#[test]
fn comparisons_with_s_and_r_are_not_assignments() {
    expression("S = R", "S = R");
    same(
        "PROGRAM p IF S=1 THEN R := REF; END_IF END_PROGRAM",
        "PROGRAM p IF S = 1 THEN R := REF; END_IF; END_PROGRAM",
    );
}

#[test]
fn names_of_one_declaration_are_variables_each() {
    same(
        "PROGRAM p VAR a AT %MW1, b, c AT %MW2 : INT := 5; END_VAR END_PROGRAM",
        "PROGRAM p VAR a AT %MW1 : INT := 5; b : INT := 5; c AT %MW2 : INT := 5; END_VAR END_PROGRAM",
    );
}

#[test]
fn section_words_in_any_order() {
    let section = |text: &str| {
        let (mut unit, _) = valid(&format!("VAR_GLOBAL {text} a : INT; END_VAR"));
        let section = unit.globals.remove(0);
        (section.constant, section.retention)
    };
    assert_eq!(section(""), (false, Retention::None));
    assert_eq!(section("RETAIN CONSTANT"), (true, Retention::Retain));
    assert_eq!(section("PERSISTENT PUBLIC RETAIN"), (false, Retention::Persistent));
    assert_eq!(section("RETAIN PERSISTENT"), (false, Retention::Persistent));
    assert_eq!(section("NON_RETAIN CONSTANT"), (true, Retention::None));
}

#[test]
fn types_in_older_forms() {
    same(
        "TYPE a : STRING(80); b : UINT (x := 1, y) := x; END_TYPE",
        "TYPE a : STRING[80]; b : (x := 1, y) UINT := x; END_TYPE",
    );
    same("TYPE a : STRUCT b : INT; END_STRUCT END_TYPE", "TYPE a : STRUCT b : INT; END_STRUCT; END_TYPE");
    same(
        "TYPE a : lib.b; END_TYPE FUNCTION_BLOCK c EXTENDS lib.d END_FUNCTION_BLOCK",
        "TYPE a : b; END_TYPE FUNCTION_BLOCK c EXTENDS d END_FUNCTION_BLOCK",
    );
    same(
        "VAR_GLOBAL a : ARRAY[0..4] OF INT := 1, 2, 3(0); b : list := 2(5); END_VAR",
        "VAR_GLOBAL a : ARRAY[0..4] OF INT := [1, 2, 3(0)]; b : list := [2(5)]; END_VAR",
    );
    same(
        "VAR_GLOBAL a : list := [2(x := 1, y := 2)]; END_VAR",
        "VAR_GLOBAL a : list := [2((x := 1, y := 2))]; END_VAR",
    );
    let (unit, names) = valid("TYPE a : REFERENCE; END_TYPE");
    assert!(
        matches!(unit.types[0].ty.kind, TypeKind::Named(name) if names.key_text(name.key) == "REFERENCE")
    );
}

#[test]
fn parts_of_a_unit_in_any_order() {
    let canonical = "FUNCTION_BLOCK f VAR a : INT; END_VAR VAR b : INT; END_VAR METHOD m END_METHOD METHOD n END_METHOD \
        PROPERTY q : INT GET q := a; END_GET END_PROPERTY ACTION act: a := 2; END_ACTION a := 1; b := 2; END_FUNCTION_BLOCK";
    same(
        "FUNCTION_BLOCK f METHOD m END_METHOD VAR a : INT; END_VAR ACTION act a := 2; END_ACTION VAR b : INT; END_VAR; \
         a := 1; METHOD n END_METHOD b := 2; PROPERTY q : INT GET q := a; END_GET; END_PROPERTY END_FUNCTION_BLOCK",
        canonical,
    );
    same(
        "FUNCTION_BLOCK f VAR a : INT; END_VAR VAR b : INT; END_VAR a := 1; b := 2; END_FUNCTION_BLOCK METHOD m END_METHOD \
         METHOD n END_METHOD PROPERTY q : INT GET q := a; END_GET END_PROPERTY ACTION act: a := 2; END_ACTION",
        canonical,
    );
}

#[test]
fn words_of_one_place_are_names_elsewhere() {
    valid(
        "PROGRAM p VAR Step, Get, Set, Task, On, With, Interval, Priority, Resource, Class, Namespace : INT; Public : INT;
         Overlap : BOOL; Reference : BOOL; Transition, S, R, Ref, Ld, Cal, Using : INT; END_VAR
         Step := Get + Set; Ld := Cal; Task(On := With); Transition := 1; Reference := TRUE; Class.Using := Namespace; END_PROGRAM",
    );
}

#[test]
fn sources_share_one_unit() {
    let sources = ["PROGRAM a END_PROGRAM", "PROGRAM b END_PROGRAM"]
        .map(|text| document::SourceFile::new("x.st", text));
    let mut names = NameTable::new();
    let mut findings = crate::findings::CompileFindings::new(&sources, 50);
    let unit = super::super::parse(&sources, sources.len(), &mut names, &mut findings);
    let places: Vec<(u16, u32)> = unit.pous.iter().map(|pou| (pou.name.at.file, pou.name.at.start)).collect();
    assert_eq!(places, [(0, 8), (1, 8)]);
    assert!(!findings.failed());
}

#[test]
fn places_span_what_they_are_of() {
    let text = "PROGRAM p a.b[1] := (c + d) * 2; END_PROGRAM";
    let (unit, _) = valid(text);
    let at = |at: crate::findings::SourcePlace| &text[at.start as usize..at.end as usize];
    let statement = &unit.pous[0].body[0];
    assert_eq!(at(statement.at), "a.b[1] := (c + d) * 2;");
    let StmtKind::Assign { targets, value, .. } = &statement.kind else { panic!() };
    assert_eq!((at(targets[0].at), at(value.at)), ("a.b[1]", "(c + d) * 2"));
    assert_eq!(at(unit.pous[0].end), "END_PROGRAM");
}

#[test]
fn long_names_are_warned_of() {
    let (_, _, findings) = read("PROGRAM i_udiETHIP_IOMessagingTransmitted END_PROGRAM");
    assert_eq!((findings[0].code, findings[0].severity), ("S0109", document::Severity::Warning));
}

#[test]
fn underscores_side_by_side_are_warned_of() {
    let (_, _, findings) =
        read("PROGRAM p VAR a__b, __c, d__, ab_, _ab, a_b : INT; END_VAR a__b := 1; END_PROGRAM");
    let found: Vec<_> = findings.iter().map(|found| (found.code, found.severity)).collect();
    assert_eq!(found, [("S0112", document::Severity::Warning); 3]);
}
