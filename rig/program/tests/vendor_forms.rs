//! Forms that libraries of other makers use: each was met in such a library, written here in words of our own.

use crate::support::{Memory, Rig, codes, once};
use document::SourceFile;
use scanrig_program::{Machine, Options, ProgramFaultKind, StopReason, compile};
use signal::{Span, Time, Value};
use std::sync::Arc;

/// Applications of several files, named as given.
fn files(sources: &[(&str, &str)]) -> Vec<SourceFile> {
    sources.iter().map(|(name, text)| SourceFile { name: (*name).into(), text: (*text).into() }).collect()
}

#[test]
fn the_system_time_is_the_modelled_time() {
    let text = "PROGRAM MAIN
        VAR t : TIME; l : LTIME; ms : DWORD; END_VAR
        t := TIME(); ms := TIME_TO_DWORD(TIME()); l := LTIME();
        END_PROGRAM";
    let mut rig = Rig::new(text);
    rig.now = Time::ZERO + Span::from_millis(90_500);
    rig.cycle();
    assert_eq!(rig.read("MAIN.t"), Value::Int(90_500_000_000));
    assert_eq!(rig.read("MAIN.ms"), Value::Word(90_500));
    // The clock goes on while operations take their time.
    assert!(rig.int("MAIN.l") > 90_500_000_000);
    // It counts 32 bits of milliseconds.
    rig.now = Time::ZERO + Span::from_millis((1 << 32) + 7);
    rig.cycle();
    assert_eq!(rig.read("MAIN.ms"), Value::Word(7));
    assert_eq!(codes("PROGRAM MAIN VAR t : TIME; END_VAR t := TIME(1); END_PROGRAM"), ["S0407"]);
    assert_eq!(codes("PROGRAM MAIN VAR CONSTANT t : TIME := TIME(); END_VAR END_PROGRAM"), ["S0203"]);
}

#[test]
fn a_list_of_globals_is_named_by_its_file() {
    let sources = files(&[
        ("lists/Limits.gvl.st", "VAR_GLOBAL CONSTANT other : INT := 1; END_VAR"),
        (
            "lists/Limits.st",
            "VAR_GLOBAL CONSTANT HIGHEST : INT := 4; NAMES : ARRAY[1..2] OF STRING(8) := ['low', 'high']; END_VAR",
        ),
        ("State.st", "VAR_GLOBAL count : INT; mask : BYTE; best : REFERENCE TO INT; END_VAR"),
        (
            "main.st",
            "PROGRAM MAIN
             VAR room : ARRAY[0..limits.HIGHEST] OF INT; s : STRING; n, size : INT; END_VAR
             State.count := State.count + Limits.HIGHEST;
             State.mask.3 := TRUE;
             State.best REF= n;
             State.best := 9;
             s := Limits.NAMES[2];
             size := SIZEOF(room) / SIZEOF(room[0]);
             END_PROGRAM",
        ),
    ]);
    let program = compile(&sources, &Options::default()).unwrap();
    let mut machine = Machine::new(Arc::new(program), &[vec![0]]).unwrap();
    machine.begin(0);
    let mut memory = Memory::default();
    machine.resume(0, Time::ZERO, Span::from_secs(1), &mut memory);
    let read = |path: &str| machine.read(machine.find(path).unwrap());
    assert_eq!(read("count"), Value::Int(4));
    assert_eq!(read("mask"), Value::Word(8));
    assert_eq!(read("MAIN.n"), Value::Int(9));
    assert_eq!(read("MAIN.size"), Value::Int(5));
    assert_eq!(machine.show("MAIN.s", &mut memory).unwrap().to_string(), "'high'");
}

#[test]
fn the_name_of_a_list_does_not_hide_and_does_not_invent() {
    let main = |body: &str| {
        let sources = files(&[
            ("Store.st", "VAR_GLOBAL level : INT; END_VAR"),
            ("main.st", &format!("PROGRAM MAIN VAR a : INT; END_VAR {body} END_PROGRAM")),
        ]);
        match compile(&sources, &Options::default()) {
            Ok(_) => Vec::new(),
            Err(findings) => findings.iter().map(|finding| finding.code).collect::<Vec<_>>(),
        }
    };
    assert_eq!(main("a := Store.level;"), [""; 0]);
    // In another file, in no file, a list that is none.
    assert_eq!(main("a := main.level;"), ["S0301"]);
    assert_eq!(main("a := Store.depth;"), ["S0301"]);
    assert_eq!(main("a := Shelf.level;"), ["S0301"]);
}

#[test]
fn bounds_may_name_constants_that_come_later() {
    let text = "FUNCTION_BLOCK RING
        VAR_INPUT push : INT; END_VAR
        VAR slots : ARRAY[0..last] OF INT; next : INT; END_VAR
        VAR CONSTANT last : INT := top - 1; top : INT := 3; END_VAR
        slots[next] := push; next := (next + 1) MOD top;
        END_FUNCTION_BLOCK
        FUNCTION SUMMED : INT
        VAR cells : ARRAY[1..n] OF INT := [4(2)]; i : INT; END_VAR
        VAR CONSTANT n : INT := 4; END_VAR
        FOR i := 1 TO n DO SUMMED := SUMMED + cells[i]; END_FOR
        END_FUNCTION
        PROGRAM MAIN
        VAR r : RING; s : INT; END_VAR
        r(push := 7); r(push := 8); r(push := 9); r(push := 10); s := SUMMED();
        END_PROGRAM";
    let mut rig = Rig::new(text);
    rig.cycle();
    assert_eq!(rig.int("MAIN.r.slots[0]"), 10);
    assert_eq!(rig.int("MAIN.r.slots[2]"), 9);
    assert_eq!(rig.int("MAIN.s"), 8);
}

#[test]
fn variables_of_a_method_that_stay_are_its_own() {
    let text = "FUNCTION_BLOCK COUNTERS
        VAR n : INT; END_VAR
        METHOD up : INT VAR_INST n : INT := 10; END_VAR n := n + 1; up := n; END_METHOD
        METHOD down : INT VAR_INST n : INT; END_VAR n := n - 1; down := n; END_METHOD
        METHOD own : INT n := n + 100; own := n; END_METHOD
        END_FUNCTION_BLOCK
        FUNCTION_BLOCK MORE EXTENDS COUNTERS END_FUNCTION_BLOCK
        PROGRAM MAIN
        VAR c : COUNTERS; m : MORE; a, b, d, e : INT; END_VAR
        a := c.up(); b := c.down(); d := c.own(); e := m.up();
        END_PROGRAM";
    let mut rig = Rig::new(text);
    rig.cycle();
    rig.cycle();
    assert_eq!((rig.int("MAIN.a"), rig.int("MAIN.b")), (12, -2));
    assert_eq!((rig.int("MAIN.d"), rig.int("MAIN.e")), (200, 12));
}

#[test]
fn a_size_goes_into_every_type_that_holds_it() {
    let rig = once(
        "VAR data : ARRAY[1..6] OF REAL; bytes, half : UINT; n : INT; b : BYTE; d : UDINT; p : POINTER TO REAL; END_VAR",
        "bytes := SIZEOF(data); half := SHR(bytes, 1); n := SIZEOF(data) / SIZEOF(data[1]);
         b := SIZEOF(n); d := SIZEOF(data) - SIZEOF(p); p := ADR(data) + SIZEOF(REAL);",
    );
    assert_eq!((rig.int("MAIN.bytes"), rig.int("MAIN.half"), rig.int("MAIN.n")), (24, 12, 6));
    assert_eq!((rig.read("MAIN.b"), rig.int("MAIN.d")), (Value::Word(2), 20));
    assert_eq!(
        codes(
            "PROGRAM MAIN VAR big : ARRAY[1..200] OF DINT; s : SINT; END_VAR s := SIZEOF(big); END_PROGRAM"
        ),
        ["S0303"]
    );
}

#[test]
fn a_reference_is_bound_to_what_a_call_refers_to() {
    let text = "FUNCTION_BLOCK CELL VAR_INPUT v : INT; END_VAR END_FUNCTION_BLOCK
        FUNCTION_BLOCK SHELF
        VAR cells : ARRAY[1..3] OF CELL; END_VAR
        METHOD nth : REFERENCE TO CELL VAR_INPUT i : INT; END_VAR nth REF= cells[i]; END_METHOD
        END_FUNCTION_BLOCK
        PROGRAM MAIN
        VAR s : SHELF; r : REFERENCE TO CELL; END_VAR
        r REF= s.nth(2); r.v := 6; r REF= s.nth(3); r.v := 7;
        END_PROGRAM";
    let mut rig = Rig::new(text);
    rig.cycle();
    assert_eq!((rig.int("MAIN.s.cells[2].v"), rig.int("MAIN.s.cells[3].v")), (6, 7));
    let wrong = text.replace("r : REFERENCE TO CELL;", "r : REFERENCE TO INT;").replace("r.v :=", "r :=");
    assert_eq!(codes(&wrong), ["S0302", "S0302"]);
}

#[test]
fn a_list_without_names_may_give_the_outputs_too() {
    let text = "FUNCTION DIVIDE : BOOL
        VAR_INPUT a, b : INT; END_VAR
        VAR_IN_OUT calls : INT; END_VAR
        VAR_OUTPUT whole, rest : INT; END_VAR
        calls := calls + 1; whole := a / b; rest := a MOD b; DIVIDE := rest = 0;
        END_FUNCTION
        PROGRAM MAIN
        VAR n, w, r : INT; even : BOOL; END_VAR
        even := DIVIDE(17, 5, n, w, r); even := DIVIDE(16, 4, n);
        END_PROGRAM";
    let mut rig = Rig::new(text);
    rig.cycle();
    assert_eq!((rig.int("MAIN.n"), rig.int("MAIN.w"), rig.int("MAIN.r")), (2, 3, 2));
    assert!(rig.on("MAIN.even"));
    assert_eq!(codes(&text.replace("n, w, r);", "n, w);")), ["S0407"]);
    assert_eq!(codes(&text.replace("n, w, r);", "n, w, 5);")), ["S0401"]);
}

#[test]
fn signed_numbers_keep_their_sign_when_shifted_to_the_right() {
    let rig = once(
        "VAR i : INT := -1; d : DINT := -1024; u : UINT := 65535; w : WORD := 16#8000; a, b, c, e : INT; f : DINT;
             g : UINT; h : WORD; END_VAR",
        "a := SHR(i, 1); b := SHR(i - 5, 1); c := SHR(i, 20); e := SHR(INT#-8, 2); f := SHR(d, 4); g := SHR(u, 4);
         h := SHR(w, 3);",
    );
    let read = |name: &str| rig.int(&format!("MAIN.{name}"));
    assert_eq!((read("a"), read("b"), read("c"), read("e"), read("f")), (-1, -3, -1, -2, -64));
    assert_eq!((read("g"), rig.read("MAIN.h")), (4095, Value::Word(0x1000)));
}

#[test]
fn bytes_of_texts_and_numbers_through_pointers() {
    let text = "FUNCTION HEX : STRING(4)
        VAR_INPUT value : WORD; END_VAR
        VAR p : POINTER TO BYTE; digit : BYTE; i : INT; END_VAR
        p := ADR(HEX) + 4;
        p^ := 0;
        FOR i := 1 TO 4 DO;
            p := p - 1;
            digit := WORD_TO_BYTE(value AND 16#000F);
            IF digit <= 9 THEN digit := digit + 48; ELSE digit := digit + 55; END_IF
            p^ := digit;
            value := SHR(value, 4);
        END_FOR
        END_FUNCTION
        FUNCTION TALLY : INT
        VAR_INPUT data : POINTER TO ARRAY[0..32000] OF BYTE; size : UINT; wanted : BYTE; END_VAR
        VAR i, stop : UINT; END_VAR
        stop := size - 1;
        FOR i := 0 TO stop DO IF data^[i] = wanted THEN TALLY := TALLY + 1; END_IF; END_FOR;
        END_FUNCTION
        PROGRAM MAIN
        VAR s : STRING(20) := 'banana'; h : STRING(4); n : INT; r : REAL := -2.0; sign : BOOL; bits : POINTER TO DWORD; END_VAR
        h := HEX(16#BEEF); n := TALLY(ADR(s), SIZEOF(s), 97);
        bits := ADR(r); sign := bits^.31;
        END_PROGRAM";
    let mut rig = Rig::new(text);
    rig.cycle();
    let shown = |path: &str, rig: &mut Rig| rig.machine.show(path, &mut rig.memory).unwrap().to_string();
    assert_eq!(shown("MAIN.h", &mut rig), "'BEEF'");
    assert_eq!(rig.int("MAIN.n"), 3);
    assert!(rig.on("MAIN.sign"));
}

#[test]
fn names_of_functions_and_new_types_are_free_for_variables() {
    let text = "TYPE ZONE : STRUCT LDATE : DATE; LTOD : TOD; DAY, MONTH, OFFSET : INT; USE : SINT; END_STRUCT END_TYPE
        FUNCTION MINUTE : INT VAR_INPUT t : TOD; END_VAR MINUTE := DINT_TO_INT(TOD_TO_DINT(t) / 60000 MOD 60); END_FUNCTION
        PROGRAM MAIN
        VAR z : ZONE; minute : INT; end, read, code : INT; bits : ARRAY[0..3] OF BOOL; END_VAR
        z.LTOD := TOD#12:34:56; z.LDATE := D#2024-02-29;
        bits[1] := 1; minute := 0; minute.0 := bits[1]; minute.3 := bits[1] XOR bits[0];
        IF z.LTOD >= TOD#12:00 AND z.LDATE < D#2025-01-01 THEN end := 5; END_IF;
        END_PROGRAM";
    let mut rig = Rig::new(text);
    rig.cycle();
    assert_eq!((rig.int("MAIN.minute"), rig.int("MAIN.end")), (9, 5));
}

#[test]
fn a_constant_may_name_a_bit() {
    let text = "VAR_GLOBAL CONSTANT READY : INT := 3; END_VAR
        PROGRAM MAIN
        VAR status : WORD; lamp, other : BOOL; n : INT; END_VAR
        VAR CONSTANT FAULT : BYTE := 15; END_VAR
        status.READY := TRUE; status.FAULT := TRUE; lamp := status.READY AND NOT status.0; other := n.READY;
        END_PROGRAM";
    let mut rig = Rig::new(text);
    rig.cycle();
    assert_eq!(rig.read("MAIN.status"), Value::Word(0x8008));
    assert!(rig.on("MAIN.lamp"));
    assert_eq!(codes(&text.replace("BYTE := 15", "BYTE := 16")), ["S0308"]);
    assert_eq!(codes(&text.replace("n.READY", "n.lamp")), ["S0307"]);
}

#[test]
fn rows_of_an_array_may_have_brackets_of_their_own() {
    let rig = once(
        "VAR a : ARRAY[1..2, 0..2] OF INT := [[1, 2, 3], [4, 5, 6]]; b : ARRAY[1..3, 1..2] OF INT := [2([7, 8]), [9]];
             c : ARRAY[1..2, 1..2] OF INT := [1, 2, 3]; END_VAR",
        ";",
    );
    let all = ["a[1,2]", "a[2,0]", "b[1,1]", "b[2,2]", "b[3,1]", "b[3,2]", "c[2,1]", "c[2,2]"];
    assert_eq!(all.map(|path| rig.int(&format!("MAIN.{path}"))), [3, 4, 7, 8, 9, 0, 3, 0]);
}

#[test]
fn a_property_may_be_a_reference() {
    let text = "TYPE PAGE : STRUCT lines : INT; marks : ARRAY[1..2] OF INT; END_STRUCT END_TYPE
        FUNCTION_BLOCK BOOK
        VAR first : PAGE; END_VAR
        PROPERTY page : REFERENCE TO PAGE
        GET page REF= first; END_GET
        END_PROPERTY
        METHOD open : REFERENCE TO PAGE open REF= first; END_METHOD
        END_FUNCTION_BLOCK
        PROGRAM MAIN
        VAR b : BOOK; n : INT; END_VAR
        b.page.lines := 4; b.page.marks[2] := 9; n := b.page.lines + b.open().marks[2];
        END_PROGRAM";
    let mut rig = Rig::new(text);
    rig.cycle();
    assert_eq!(
        (rig.int("MAIN.b.first.lines"), rig.int("MAIN.b.first.marks[2]"), rig.int("MAIN.n")),
        (4, 9, 13)
    );
}

#[test]
fn a_pointer_to_a_text_literal_may_be_kept() {
    let text = "FUNCTION greeting : POINTER TO STRING VAR_INPUT again : BOOL; END_VAR
        IF again THEN greeting := ADR('good evening'); ELSE greeting := ADR('good morning'); END_IF
        END_FUNCTION
        FUNCTION other : INT VAR x : ARRAY[1..50] OF INT; i : INT; END_VAR
        FOR i := 1 TO 50 DO x[i] := 16#4141; END_FOR other := x[1];
        END_FUNCTION
        PROGRAM MAIN
        VAR p, q : POINTER TO STRING; same : BOOL; n : INT; END_VAR
        p := greeting(FALSE); q := greeting(TRUE); n := other();
        same := p^ = 'good morning' AND q^ = 'good evening';
        END_PROGRAM";
    let mut rig = Rig::new(text);
    rig.cycle();
    assert!(rig.on("MAIN.same"));
}

#[test]
fn an_in_out_may_take_arrays_of_any_length() {
    let text = "FUNCTION total : DINT VAR_IN_OUT a : ARRAY[*] OF INT; END_VAR VAR i : DINT; END_VAR
        FOR i := LOWER_BOUND(a, 1) TO UPPER_BOUND(a, 1) DO total := total + a[i]; END_FOR
        END_FUNCTION
        FUNCTION twice : DINT VAR_IN_OUT b : ARRAY[*] OF INT; END_VAR
        b[LOWER_BOUND(b, 1)] := 100; twice := 2 * total(a := b);
        END_FUNCTION
        FUNCTION corner : INT VAR_IN_OUT m : ARRAY[*, *] OF INT; END_VAR VAR_INPUT i, j : INT; END_VAR
        corner := m[i, j]; m[i, j] := -1;
        END_FUNCTION
        FUNCTION_BLOCK holder VAR_IN_OUT a : ARRAY[*] OF INT; END_VAR VAR_OUTPUT last : INT; END_VAR
        last := a[UPPER_BOUND(a, 1)];
        END_FUNCTION_BLOCK
        PROGRAM MAIN
        VAR x : ARRAY[1..3] OF INT := [1, 2, 3]; y : ARRAY[-2..-1] OF INT := [10, 20]; s1, s2, s3 : DINT;
            m : ARRAY[1..2, 0..2] OF INT := [1, 2, 3, 4, 5, 6]; c : INT; h : holder; wide : INT; bad : INT; go : BOOL; END_VAR
        s1 := total(x); s2 := total(a := y); s3 := twice(x);
        c := corner(m, 2, 1);
        h(a := y);
        wide := DINT_TO_INT(UPPER_BOUND(m, 2) - LOWER_BOUND(m, 2));
        IF go THEN bad := corner(m, 2, 3); END_IF
        END_PROGRAM";
    let mut rig = Rig::new(text);
    rig.cycle();
    let values = ["s1", "s2", "s3", "c", "m[2,1]", "x[1]", "h.last", "wide"];
    assert_eq!(values.map(|path| rig.int(&format!("MAIN.{path}"))), [6, 30, 210, 5, -1, 100, 20, 2]);
    rig.write("MAIN.go", signal::Value::Bool(true));
    let StopReason::Fault(fault) = rig.run().stop else {
        panic!("an index outside of its bounds is a fault")
    };
    assert_eq!(fault.kind, ProgramFaultKind::Bounds);
}

#[test]
fn a_loop_counts_where_it_began() {
    let rig = once(
        "VAR x : ARRAY[1..4] OF INT; p : POINTER TO INT; turns : INT; END_VAR",
        "p := ADR(x[1]); FOR p^ := 1 TO 3 DO turns := turns + 1; p := ADR(x[3]); END_FOR",
    );
    assert_eq!(["turns", "x[1]", "x[3]"].map(|path| rig.int(&format!("MAIN.{path}"))), [3, 4, 0]);
}
