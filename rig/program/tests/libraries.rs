//! Third-party libraries compile and run (rig/program: "third-party ST libraries that nobody here wrote are the
//! yardstick"): what instances are made of before the first cycle, inputs of any type and with edges, functions on
//! memory, and files as libraries are distributed. Each form was met in such a library, written here in words of our
//! own.

use crate::support::{Rig, codes, once, sources};
use document::{Severity, SourceFile};
use scanrig_program::{Options, compile, source};
use signal::Value;

/// The codes of the warnings of a program that compiles.
fn warnings(text: &str) -> Vec<&'static str> {
    let program = compile(&sources(text), &Options::default()).unwrap();
    program.warnings.iter().map(|finding| finding.code).collect()
}

const TANK: &str = "
    FUNCTION_BLOCK VESSEL
    VAR size, made : INT; END_VAR
    METHOD FB_Init : BOOL
    VAR_INPUT bInitRetains, bInCopyCode : BOOL; litres : INT; END_VAR
    size := litres; made := made + 1;
    IF bInitRetains AND NOT bInCopyCode THEN made := made + 10; END_IF
    END_METHOD
    END_FUNCTION_BLOCK
    FUNCTION_BLOCK TANK EXTENDS VESSEL
    VAR level : INT; END_VAR
    METHOD FB_Init : BOOL
    VAR_INPUT bInitRetains, bInCopyCode : BOOL; litres : INT; start : INT := 7; END_VAR
    level := start + made * 100;
    END_METHOD
    END_FUNCTION_BLOCK ";

#[test]
fn fb_init_runs_once_before_the_first_cycle() {
    let text = format!(
        "{TANK}
        FUNCTION_BLOCK HALL
        VAR one : TANK(litres := 5); all : ARRAY[1..2] OF TANK[(litres := 1), (litres := 2, start := 9)];
            same : ARRAY[1..2] OF VESSEL(3); END_VAR
        END_FUNCTION_BLOCK
        VAR_GLOBAL outside : VESSEL(litres := 40); END_VAR
        PROGRAM MAIN
        VAR halls : ARRAY[0..1] OF HALL; END_VAR
        VAR RETAIN kept : VESSEL(litres := 8); END_VAR
        VAR_TEMP now : VESSEL(litres := 6); END_VAR
        VAR seen : INT; END_VAR
        seen := now.size;
        END_PROGRAM"
    );
    let mut rig = Rig::new(&text);
    // Before any cycle: they are initial values.
    assert_eq!((rig.int("outside.size"), rig.int("MAIN.kept.size")), (40, 8));
    for hall in ["MAIN.halls[0]", "MAIN.halls[1]"] {
        let int = |path: &str| rig.int(&format!("{hall}.{path}"));
        // The constructor of the block that is extended comes first.
        assert_eq!((int("one.size"), int("one.made"), int("one.level")), (5, 11, 1107));
        assert_eq!((int("all[1].size"), int("all[1].level")), (1, 1107));
        assert_eq!((int("all[2].size"), int("all[2].level")), (2, 1109));
        assert_eq!((int("same[1].size"), int("same[2].size")), (3, 3));
    }
    rig.cycle();
    rig.cycle();
    assert_eq!((rig.int("outside.made"), rig.int("MAIN.seen")), (11, 6));
}

#[test]
fn fb_init_gets_what_it_takes() {
    let main = |declaration: &str| format!("{TANK} PROGRAM MAIN VAR {declaration} END_VAR END_PROGRAM");
    assert_eq!(codes(&main("t : TANK(litres := 1, start := 2);")), [""; 0]);
    assert_eq!(codes(&main("t : TANK;")), ["S0407"]);
    assert_eq!(codes(&main("t : TANK(start := 2);")), ["S0407"]);
    assert_eq!(codes(&main("t : TANK(litres := 1, colour := 2);")), ["S0406"]);
    assert_eq!(codes(&main("t : TON(PT := T#1s);")), ["S0406"]);
    assert_eq!(codes(&main("t : TON();")), [""; 0]);
    // Where nothing is made nothing can be given.
    let text = main("t : TANK(1);").replace("VAR t", "VAR_INPUT t");
    assert_eq!(codes(&text), ["S0206"]);
}

#[test]
fn fb_init_that_fails_is_reported() {
    let text = "FUNCTION_BLOCK PART
        VAR n, zero : INT; END_VAR
        METHOD FB_Init : BOOL
        VAR_INPUT bInitRetains, bInCopyCode : BOOL; END_VAR
        n := 1 / zero;
        END_METHOD
        END_FUNCTION_BLOCK
        PROGRAM MAIN VAR p : PART; END_VAR END_PROGRAM";
    assert_eq!(codes(text), ["S0213"]);
    assert_eq!(codes(&text.replace("n := 1 / zero;", "WHILE TRUE DO n := 1; END_WHILE")), ["S0213"]);
    assert_eq!(codes(&text.replace("n := 1 / zero;", "%QW0 := 1;")), ["S0213"]);
    // The other two are never called, which is said.
    assert_eq!(warnings(&text.replace("FB_Init", "FB_Exit")), ["S0216"]);
    // The names of what the rig brings along are its own.
    let copies = "PROGRAM MAIN VAR a, b__c : INT; END_VAR MEMCPY(ADR(a), ADR(b__c), 2); END_PROGRAM";
    assert_eq!(warnings(copies), ["S0112"]);
    assert_eq!(warnings(&text.replace("FB_Init", "FB_Reinit")), ["S0216"]);
}

#[test]
fn addresses_are_initial_values() {
    let text = "INTERFACE COUNTED METHOD count : INT END_METHOD END_INTERFACE
        FUNCTION_BLOCK BOX IMPLEMENTS COUNTED
        VAR cells : ARRAY[0..2] OF INT := [3, 4, 5]; first : POINTER TO INT := ADR(cells);
            last : POINTER TO INT := ADR(cells[2]); place : UDINT := ADR(cells) + 2; END_VAR
        METHOD count : INT count := first^ + last^; END_METHOD
        END_FUNCTION_BLOCK
        FUNCTION_BLOCK ROOM
        VAR box : BOX; any : COUNTED := box; both : ARRAY[0..1] OF POINTER TO INT := [2(ADR(n))]; n : INT := 42; END_VAR
        END_FUNCTION_BLOCK
        VAR_GLOBAL there : POINTER TO INT := ADR(MAIN.k); END_VAR
        PROGRAM MAIN
        VAR rooms : ARRAY[1..2] OF ROOM; k : INT := 11; a, b, c, d : INT; p : POINTER TO INT; other : COUNTED := rooms[2].box; END_VAR
        a := rooms[2].any.count(); b := there^; c := rooms[1].both[1]^; p := rooms[1].box.place; d := p^ + other.count();
        END_PROGRAM";
    let mut rig = Rig::new(text);
    rig.cycle();
    let read = |name: &str| rig.int(&format!("MAIN.{name}"));
    assert_eq!((read("a"), read("b"), read("c"), read("d")), (8, 11, 42, 12));
    // A variable that is no address is no initial value.
    assert_eq!(codes("PROGRAM MAIN VAR a : INT; b : INT := a; END_VAR END_PROGRAM"), ["S0203"]);
}

#[test]
fn settings_are_constants_of_structures() {
    let text = "TYPE NUMBERS : STRUCT PI : REAL := 3.25; STEPS : ARRAY[0..3] OF DINT := 1, 1, 2, 6; END_STRUCT END_TYPE
        VAR_GLOBAL CONSTANT MATH : NUMBERS; END_VAR
        FUNCTION_BLOCK RING VAR r : REAL := MATH.PI * 2; n : DINT := MATH.STEPS[3]; END_VAR END_FUNCTION_BLOCK
        PROGRAM MAIN VAR ring : RING; x : REAL; END_VAR x := math.pi; END_PROGRAM";
    let mut rig = Rig::new(text);
    rig.cycle();
    assert_eq!((rig.read("MAIN.ring.r"), rig.int("MAIN.ring.n")), (Value::Real(6.5), 6));
    assert_eq!(rig.read("MAIN.x"), Value::Real(3.25));
    assert_eq!(codes("PROGRAM MAIN VAR CONSTANT n : INT; END_VAR END_PROGRAM"), ["S0210"]);
}

#[test]
fn inputs_with_edges_are_true_for_one_call() {
    let text = "FUNCTION_BLOCK COUNT
        VAR_INPUT up : BOOL R_EDGE; down : BOOL F_EDGE; END_VAR
        VAR rises, falls : INT; END_VAR
        IF up THEN rises := rises + 1; END_IF
        IF down THEN falls := falls + 1; END_IF
        END_FUNCTION_BLOCK
        PROGRAM MAIN VAR c : COUNT; on : BOOL; END_VAR c(up := on, down := on); c(); END_PROGRAM";
    let mut rig = Rig::new(text);
    // IEC 61131-3: as R_TRIG and F_TRIG, which the second call of a cycle does not see again.
    for (on, rises, falls) in [(false, 0, 0), (true, 1, 0), (true, 1, 0), (false, 1, 1), (true, 2, 1)] {
        rig.write("MAIN.on", Value::Bool(on));
        rig.cycle();
        assert_eq!((rig.int("MAIN.c.rises"), rig.int("MAIN.c.falls")), (rises, falls));
    }
    assert_eq!(codes(&text.replace("VAR rises", "VAR x : BOOL R_EDGE; rises")), ["S0206"]);
    assert_eq!(codes(&text.replace("up : BOOL", "up : INT")), ["S0302", "S0402", "S0302"]);
    assert_eq!(codes(&text.replace("IF up THEN", "up := FALSE; IF up THEN")), ["S0401"]);
    let function = "FUNCTION f : BOOL VAR_INPUT e : BOOL R_EDGE; END_VAR f := e; END_FUNCTION";
    assert_eq!(codes(&format!("{function} PROGRAM MAIN END_PROGRAM")), ["S0206"]);
    let derived = "FUNCTION_BLOCK MORE EXTENDS COUNT END_FUNCTION_BLOCK PROGRAM MAIN";
    assert_eq!(codes(&text.replace("PROGRAM MAIN", derived)), ["S0901", "S0901"]);
}

#[test]
fn inputs_of_any_type_report_class_address_and_size() {
    let text = "FUNCTION LOOK : DINT
        VAR_INPUT it : ANY; END_VAR
        LOOK := it.diSize + 100 * it.TypeClass + 10000 * BYTE_TO_DINT(it.pValue[0]);
        IF it.TypeClass = __SYSTEM.TYPE_CLASS.TYPE_INT AND it.TypeClass = IBaseLibrary.TypeClass.TYPE_INT THEN LOOK := -LOOK; END_IF
        END_FUNCTION
        FUNCTION ON : DINT VAR_INPUT it : ANY_NUM; END_VAR ON := LOOK(it); END_FUNCTION
        FUNCTION_BLOCK ALIKE
        VAR_INPUT a, b : ANY; n : INT; END_VAR VAR_OUTPUT q : BOOL; END_VAR VAR i : DINT; END_VAR
        q := a.diSize = b.diSize AND a.TypeClass = b.TypeClass;
        FOR i := 0 TO a.diSize - 1 DO q := q AND a.pValue[i] = b.pValue[i]; END_FOR
        END_FUNCTION_BLOCK
        PROGRAM MAIN
        VAR w : WORD := 16#0105; s : STRING(5) := 'AB'; i, k : INT := 3; al : ALIKE; a, b, c, d, e : DINT; p, q : BOOL; END_VAR
        a := LOOK(w); b := LOOK(s); c := LOOK(it := i); d := ON(i); e := LOOK(INT#5);
        al(a := i, b := k, n := 3); p := al.q; al(b := w); q := al.q;
        END_PROGRAM";
    let mut rig = Rig::new(text);
    rig.cycle();
    let read = |name: &str| rig.int(&format!("MAIN.{name}"));
    // The classes' numbers: WORD 3, INT 7, STRING 16.
    assert_eq!((read("a"), read("b"), read("c")), (50_302, 651_606, -30_702));
    assert_eq!((read("d"), read("e")), (-30_702, -50_702));
    assert_eq!((rig.on("MAIN.p"), rig.on("MAIN.q")), (true, false));
    assert_eq!(codes(&text.replace("d := ON(i)", "d := ON(s)")), ["S0302"]);
    assert_eq!(codes(&text.replace("a := LOOK(w)", "a := LOOK(w.1)")), ["S0410"]);
    assert_eq!(codes(&text.replace("p, q : BOOL;", "p, q : BOOL; x : ANY;")), ["S0302"]);
}

#[test]
fn memory_is_copied_filled_and_compared() {
    let list: Vec<String> = (1..=21).map(|n| n.to_string()).collect();
    let rig = once(
        &format!(
            "VAR a, f : ARRAY[0..20] OF BYTE := [{0}]; b : ARRAY[0..20] OF BYTE; c, d, e : DINT; n : UDINT; END_VAR",
            list.join(", ")
        ),
        "n := MEMCPY(ADR(b), ADR(a), SIZEOF(a)); c := MEMCMP(ADR(a), ADR(b), SIZEOF(b));
         MEMMOVE(ADR(a[3]), ADR(a[0]), 18); SysMemMove(ADR(f[0]), ADR(f[3]), 18);
         d := MEMCMP(ADR(a), ADR(b), SIZEOF(b)); e := SysMemCmp(pBuffer1 := ADR(b), pBuffer2 := ADR(a), udiCount := 4);
         MEMSET(destAddr := ADR(b), fillByte := 16#AA, n := 13); SysMemSet(ADR(b[20]), 7, 1);",
    );
    let byte = |path: String| match rig.read(&path) {
        Value::Word(n) => n,
        other => panic!("{other:?}"),
    };
    // Areas that lie over each other are moved as a whole.
    for n in 0..18u64 {
        assert_eq!((byte(format!("MAIN.a[{}]", n + 3)), byte(format!("MAIN.f[{n}]"))), (n + 1, n + 4));
    }
    for n in 0..20u64 {
        assert_eq!(byte(format!("MAIN.b[{n}]")), if n < 13 { 0xAA } else { n + 1 });
    }
    assert_eq!((byte("MAIN.b[20]".into()), rig.int("MAIN.n")), (7, 21));
    assert_eq!((rig.int("MAIN.c"), rig.int("MAIN.d"), rig.int("MAIN.e")), (0, -1, 1));
    // A function of that name in the sources is the one that is meant.
    let own = "FUNCTION MEMSET : INT VAR_INPUT x : INT; END_VAR MEMSET := x + 1; END_FUNCTION
        PROGRAM MAIN VAR n : INT; END_VAR n := MEMSET(4); END_PROGRAM";
    let mut rig = Rig::new(own);
    rig.cycle();
    assert_eq!(rig.int("MAIN.n"), 5);
}

#[test]
fn numbers_go_back_to_where_they_came_from() {
    let text = "VAR i : INT := 7; d : DINT := -3; w : DWORD := 10; u : UINT := 9; r : REAL := 3.9; a, b, c : INT; e : DINT; END_VAR";
    let rig = once(text, "a := TRUNC(r); b := TRUNC(r * 2) + i; e := w + d; c := i + u;");
    let read = |name: &str| rig.int(&format!("MAIN.{name}"));
    assert_eq!((read("a"), read("b"), read("e"), read("c")), (3, 14, 7, 16));
    let main = |body: &str| format!("PROGRAM MAIN {text} {body} END_PROGRAM");
    assert_eq!(warnings(&main("a := TRUNC(r); e := w + d;")), ["S0306", "S0306"]);
    // What was wide is still not cut by itself.
    assert_eq!(codes(&main("a := d;")), ["S0302"]);
    assert_eq!(codes(&main("a := TRUNC(r) + d;")), ["S0302"]);
}

#[test]
fn named_calls_may_be_incomplete() {
    let text = "FUNCTION SUM : INT VAR_INPUT a, b : INT; c : INT := 3; END_VAR SUM := a + 10 * b + 100 * c; END_FUNCTION
        PROGRAM MAIN VAR n : INT; END_VAR n := SUM(a := 1); END_PROGRAM";
    let mut rig = Rig::new(text);
    rig.cycle();
    assert_eq!(rig.int("MAIN.n"), 301);
    // Without names it is a slip.
    assert_eq!(codes(&text.replace("SUM(a := 1)", "SUM(1)")), ["S0407"]);
}

#[test]
fn blocks_may_be_located() {
    let text = "FUNCTION_BLOCK METER VAR count AT %MW7 : INT; far AT %I* : BOOL; END_VAR count := count + 1; END_FUNCTION_BLOCK
        PROGRAM MAIN VAR a, b : METER; END_VAR a(); b(); END_PROGRAM";
    let mut rig = Rig::new(text);
    rig.cycle();
    // One address is one variable, whatever block names it.
    assert_eq!(rig.memory.get("%MW7"), 2);
    assert_eq!(warnings(text), ["S0215"]);
    assert_eq!(
        codes(&text.replace("VAR count AT %MW7 : INT;", "VAR_INPUT count AT %MW7 : INT; END_VAR VAR")),
        ["S0209"]
    );
}

#[test]
fn names_of_libraries_and_old_words_are_read() {
    let text = "FUNCTIONBLOCK STEPPER VAR_INPUT PROG : ARRAY[0..3]OF TIME; END_VAR
        VAR n : INT; t : Standard.TON; END_VAR
        IF PROG[1] > T#0.5s THEN; n := 1; ELSE; n := 2; END_IF;
        t(IN := TRUE, PT := T#1m0.5s);
        END_FUNCTIONBLOCK
        TYPE COLOURS : (red, green); END_TYPE
        PROGRAM MAIN
        VAR s : STEPPER; x : STRING; c : COLOURS; pt : TIME; END_VAR
        s(); x := Tc2_Standard.CONCAT(STR1 := 'a', STR2 := 'b'); c := Shades.COLOURS.green; pt := T#5.5ms;
        END_PROGRAM";
    let mut rig = Rig::new(text);
    rig.cycle();
    assert_eq!((rig.int("MAIN.s.n"), rig.int("MAIN.c")), (2, 1));
    assert_eq!(rig.read("MAIN.pt"), Value::Int(5_000_000));
}

#[test]
fn a_return_may_have_a_condition() {
    let text = "FUNCTION STEPS : INT VAR_INPUT n : INT; END_VAR
        STEPS := 1; RETURN(n < 3); STEPS := 2; END_FUNCTION
        PROGRAM MAIN VAR a, b : INT; END_VAR a := STEPS(2); b := STEPS(3); END_PROGRAM";
    let mut rig = Rig::new(text);
    rig.cycle();
    assert_eq!((rig.int("MAIN.a"), rig.int("MAIN.b")), (1, 2));
    assert_eq!(codes(&text.replace("n < 3", "n")), ["S0402"]);
}

#[test]
fn exports_of_older_tools_are_read() {
    let export = |nested: &str, remark: &str| {
        format!(
            "(* @NESTEDCOMMENTS := '{nested}' *)\r\n(* @PATH := '\\/Mathematical' *)\r\n(* @OBJECTFLAGS := '0, 8' *)\r\n\
             FUNCTION TWICE : REAL\r\nVAR_INPUT CONSTANT\r\n\tX : REAL;\r\nEND_VAR\r\n{remark}\r\n\
             (* @END_DECLARATION := '0' *)\r\nTWICE := X * 2;\r\nEND_FUNCTION\r\n\
             PROGRAM MAIN VAR r : REAL; END_VAR r := TWICE(1.5); END_PROGRAM"
        )
    };
    for (nested, remark) in [("Yes", "(* a (* b *) *)"), ("No", "(* a (* b *)")] {
        let mut rig = Rig::new(&export(nested, remark));
        rig.cycle();
        assert_eq!(rig.read("MAIN.r"), Value::Real(3.0));
    }
    assert_eq!(codes(&export("Yes", "(* a (* b *)")), ["S0104"]);
}

/// A program of several files as bytes.
fn files(files: &[(&str, &[u8])]) -> Vec<SourceFile> {
    files.iter().map(|(name, bytes)| source(name, bytes).unwrap()).collect()
}

#[test]
fn files_of_twincat_are_one_program() {
    let block = br#"<?xml version="1.0"?>
<TcPlcObject><POU Name="FB_Add"><Declaration><![CDATA[FUNCTION_BLOCK FB_Add IMPLEMENTS I_Sum
VAR n : INT; END_VAR]]></Declaration><Implementation><ST><![CDATA[n := n + GVL_Set.step;]]></ST></Implementation>
<Method Name="sum"><Declaration><![CDATA[METHOD sum : INT]]></Declaration>
<Implementation><ST><![CDATA[sum := n; // all of it]]></ST></Implementation></Method></POU></TcPlcObject>"#;
    let interface = br#"<TcPlcObject><Itf Name="I_Sum"><Declaration><![CDATA[INTERFACE I_Sum]]></Declaration>
<Method Name="sum"><Declaration><![CDATA[METHOD sum : INT]]></Declaration></Method></Itf></TcPlcObject>"#;
    let list = b"<TcPlcObject><GVL Name=\"GVL_Set\"><Declaration><![CDATA[{attribute 'qualified_only'}
VAR_GLOBAL CONSTANT step : INT := 5; END_VAR]]></Declaration></GVL></TcPlcObject>";
    let latin = b"PROGRAM MAIN (* f\xFCr Wien *) VAR a : FB_Add; s : STRING := '\xB0C'; n : INT; END_VAR a(); n := a.sum(); END_PROGRAM";
    let all = files(&[
        ("FB_Add.TcPOU", block),
        ("I_Sum.TcIO", interface),
        ("GVL_Set.TcGVL", list),
        ("main.st", latin),
    ]);
    let program = compile(&all, &Options::default()).unwrap_or_else(|found| panic!("{found:#?}"));
    assert_eq!(program.programs(), ["MAIN"]);
    // A finding stands in the line of the file.
    let broken = String::from_utf8_lossy(block).replace("sum := n;", "sum := nn;");
    let all =
        [source("FB_Add.TcPOU", broken.as_bytes()).unwrap(), all[1].clone(), all[2].clone(), all[3].clone()];
    let found = compile(&all, &Options::default()).unwrap_err();
    let error = found.iter().find(|finding| finding.severity == Severity::Error).unwrap();
    let label = &error.labels[0];
    let line = all[0].text[..label.span.start].matches('\n').count() + 1;
    assert_eq!((label.file.as_str(), error.code, line), ("FB_Add.TcPOU", "S0301", 5));
}

#[test]
fn a_library_needs_no_program() {
    let text = sources("FUNCTION f : INT f := 1; END_FUNCTION");
    assert_eq!(codes("FUNCTION f : INT f := 1; END_FUNCTION"), ["S0211"]);
    let program = compile(&text, &Options { library: true, ..Options::default() }).unwrap();
    assert!(program.programs().is_empty());
}

#[test]
fn a_library_may_have_a_file_for_each_unit() {
    let unit = |n: usize| (format!("F{n}.EXP"), format!("FUNCTION F{n} : INT F{n} := {n}; END_FUNCTION\n"));
    let mut all: Vec<SourceFile> = (0..600).map(unit).map(|(name, text)| SourceFile { name, text }).collect();
    let main = "PROGRAM MAIN VAR n : INT; END_VAR n := F599() + missing; END_PROGRAM";
    all.push(SourceFile { name: "main.st".into(), text: main.into() });
    let found = compile(&all, &Options::default()).unwrap_err();
    assert_eq!((found[0].labels[0].file.as_str(), found[0].code), ("main.st", "S0301"));
}
