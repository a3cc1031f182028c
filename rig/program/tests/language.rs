//! What statements and expressions mean, against values worked out by hand from IEC 61131-3.

use crate::support::{Rig, codes, once};
use scanrig_program::{ProgramFaultKind, StopReason};
use signal::Value;

/// The value of an expression assigned to `r` of a type, with some variables at hand.
fn value(ty: &str, expression: &str) -> i128 {
    let declarations = format!(
        "VAR r : {ty}; i : INT := 7; j : INT := -3; u : UINT := 60000; d : DINT := 100000; w : WORD := 16#F00F;
         b : BOOL := TRUE; c : BOOL; s : SINT := -128; bt : BYTE := 16#81; ul : ULINT := 16#FFFF_FFFF_FFFF_FFFE;
         l : LINT := -5; t : TIME := T#1500ms; us : USINT := 200; dw : DWORD := 16#8000_0001; END_VAR"
    );
    once(&declarations, &format!("r := {expression};")).int("r")
}

#[test]
fn precedence_is_that_of_the_standard() {
    for (ty, expression, expected) in [
        ("INT", "1 + 2 * 3", 7),
        ("INT", "(1 + 2) * 3", 9),
        ("INT", "20 - 5 - 3", 12),
        ("INT", "100 / 5 / 2", 10),
        ("INT", "i - 2 * -j", 1),
        ("INT", "17 MOD 5 * 2", 4),
        ("BOOL", "TRUE OR TRUE AND FALSE", 1),
        ("BOOL", "(TRUE OR TRUE) AND FALSE", 0),
        ("BOOL", "TRUE XOR TRUE OR TRUE", 1),
        ("BOOL", "b OR b XOR b", 1),
        ("BOOL", "NOT b OR b", 1),
        ("BOOL", "NOT (b OR c)", 0),
        ("BOOL", "i > 6 AND i < 8", 1),
        ("BOOL", "i < 6 = c", 1),
        ("BOOL", "i + 1 = 8", 1),
        ("BOOL", "b & NOT c", 1),
        ("INT", "-i + 1", -6),
        ("INT", "+i", 7),
    ] {
        assert_eq!(value(ty, expression), expected, "{expression}");
    }
}

#[test]
fn results_wrap_at_the_width_of_their_type() {
    for (ty, expression, expected) in [
        ("SINT", "s - 1", 127),
        ("SINT", "-s", -128),
        ("SINT", "ABS(s)", -128),
        ("INT", "i * 10000", 70_000 - 65_536),
        ("UINT", "u + 6000", 66_000 - 65_536),
        ("USINT", "us + us", 144),
        ("DINT", "d * d", 1_410_065_408),
        ("ULINT", "ul + 3", 1),
        ("LINT", "l * l", 25),
        ("TIME", "t - T#2s", (1i128 << 32) * 1_000_000 - 500_000_000),
        ("TIME", "t * 3", 4_500_000_000),
        ("TIME", "t / 4", 375_000_000),
        // INT and UINT meet in DINT.
        ("DINT", "i + u", 60_007),
        ("DINT", "i + 40000", 40_007),
        ("BOOL", "ul > 5", 1),
        ("BOOL", "l < 5", 1),
    ] {
        assert_eq!(value(ty, expression), expected, "{expression}");
    }
}

#[test]
fn division_goes_towards_zero() {
    for (expression, expected) in [("j / 2", -1), ("i / j", -2), ("j MOD 2", -1), ("i MOD j", 1)] {
        assert_eq!(value("INT", expression), expected, "{expression}");
    }
    assert_eq!(value("ULINT", "ul / 2"), 0x7FFF_FFFF_FFFF_FFFF);
    assert_eq!(value("ULINT", "ul MOD 10"), 4);
}

#[test]
fn bits_and_conversions() {
    for (ty, expression, expected) in [
        ("WORD", "NOT w", 0x0FF0),
        ("WORD", "w AND 16#00FF", 0x0F),
        ("WORD", "w XOR w", 0),
        ("BYTE", "SHL(bt, 1)", 2),
        ("BYTE", "ROL(bt, 1)", 3),
        ("BYTE", "ROR(bt, 1)", 0xC0),
        ("BYTE", "SHR(bt, 8)", 0),
        ("DWORD", "ROL(dw, 33)", 3),
        ("INT", "WORD_TO_INT(w)", -4081),
        ("INT", "DINT_TO_INT(d)", 100_000 - 131_072),
        ("BYTE", "WORD_TO_BYTE(w)", 0x0F),
        ("BOOL", "INT_TO_BOOL(i)", 1),
        ("INT", "BOOL_TO_INT(b)", 1),
        ("UDINT", "TIME_TO_UDINT(t)", 1500),
        ("TIME", "UINT_TO_TIME(u)", 60_000_000_000),
        ("DINT", "TO_DINT(s)", -128),
        ("INT", "SEL(b, 1, 2)", 2),
        ("INT", "SEL(G := c, IN0 := 1, IN1 := 2)", 1),
        ("INT", "MAX(i, j, 3)", 7),
        ("INT", "MIN(i, j)", -3),
        ("INT", "MIN(-1, 200, us)", -1),
        ("USINT", "MIN(100, 200, us)", 100),
        ("INT", "LIMIT(0, j, 5)", 0),
        ("INT", "LIMIT(0, i, 5)", 5),
        ("INT", "LIMIT(MX := 9, MN := 8, IN := i)", 8),
        ("INT", "INT#16#7F", 127),
        ("WORD", "2#1010_1010", 0xAA),
    ] {
        assert_eq!(value(ty, expression), expected, "{expression}");
    }
}

#[test]
fn names_do_not_depend_on_capitals() {
    // controller:DT-03
    let rig = once("var Count : int; End_Var", "COUNT := count + 1;");
    assert_eq!(rig.int("main.COUNT"), 1);
}

#[test]
fn comments_nest_and_pragmas_are_skipped() {
    let rig =
        once("VAR n : INT; END_VAR {attribute 'x'}", "(* a (* b *) c *) n := 1; // n := 2;\n/* n := 3; */");
    assert_eq!(rig.int("n"), 1);
}

#[test]
fn conditions_and_selection() {
    let statements = "
        FOR i := -2 TO 12 DO
          CASE i OF
            1: a := a + 1;
            2, 3: a := a + 10;
            5..7, limit: a := a + 100;
          ELSE
            b := b + 1;
          END_CASE;
          IF i < 0 THEN c := c + 1; ELSIF i = 0 THEN c := c + 10; ELSIF i = 1 THEN c := c + 100; ELSE c := c + 1000; END_IF;
        END_FOR;";
    let rig = once("VAR CONSTANT limit : INT := 10; END_VAR VAR i, a, b, c : INT; END_VAR", statements);
    assert_eq!((rig.int("a"), rig.int("b"), rig.int("c")), (421, 8, 11_112));
}

#[test]
fn loops_leave_and_go_on() {
    let rig = once(
        "VAR i, n, m, k : INT; END_VAR",
        "FOR i := 1 TO 10 DO IF i = 3 THEN CONTINUE; END_IF; IF i = 6 THEN EXIT; END_IF; n := n + i; END_FOR;
         WHILE m < 10 DO m := m + 1; IF m = 4 THEN EXIT; END_IF; END_WHILE;
         REPEAT k := k + 1; IF k < 3 THEN CONTINUE; END_IF; UNTIL k >= 3 END_REPEAT;",
    );
    assert_eq!((rig.int("n"), rig.int("i"), rig.int("m"), rig.int("k")), (12, 6, 4, 3));
}

#[test]
fn counted_loops_end_beside_the_limits_of_their_type() {
    let rig = once(
        "VAR u : USINT; s : SINT; d : USINT; a, b, c, e, n : INT; END_VAR",
        "FOR u := 250 TO 254 DO a := a + 1; END_FOR;
         FOR s := 127 TO -28 BY -100 DO b := b + 1; END_FOR;
         FOR d := 3 TO 1 BY -1 DO c := c + 1; END_FOR;
         FOR n := 5 TO 1 DO e := e + 1; END_FOR;
         FOR n := 1 TO 10 BY a DO e := e + 1; END_FOR;",
    );
    assert_eq!((rig.int("a"), rig.int("b"), rig.int("c"), rig.int("e")), (5, 2, 3, 2));
    assert_eq!((rig.int("u"), rig.int("s"), rig.int("d"), rig.int("n")), (255, -73, 0, 11));
}

#[test]
fn the_end_of_a_loop_is_computed_before_each_turn_and_its_step_once() {
    let rig =
        once("VAR i, n, m : INT := 3; END_VAR", "m := 0; FOR i := 1 TO n DO n := 100; m := m + 1; END_FOR;");
    assert_eq!(rig.int("m"), 100);
    let rig = once(
        "VAR i, n, m : INT := 3; END_VAR",
        "m := 0; FOR i := 1 TO 7 BY n DO n := 100; m := m + 1; END_FOR;",
    );
    assert_eq!(rig.int("m"), 3);
}

#[test]
fn functions_and_blocks() {
    let text = "
        FUNCTION twice : INT VAR_INPUT x : INT; none : INT := 0; END_VAR VAR k : INT := 2; END_VAR
          twice := x * k; k := 50; IF x > 100 THEN RETURN; END_IF; twice := twice + none;
        END_FUNCTION
        FUNCTION_BLOCK counter VAR_INPUT step : INT := 1; END_VAR VAR_OUTPUT total : INT; END_VAR VAR inner : R_TRIG; END_VAR
          inner(CLK := step > 0); IF inner.Q THEN total := total + 1000; END_IF; total := total + step;
        END_FUNCTION_BLOCK
        PROGRAM MAIN VAR a, b, n, out : INT; c1, c2 : counter; list : ARRAY[1..3] OF counter; END_VAR
          a := twice(twice(3)) + twice(x := 1, none := 0);
          c1(); c1(step := 5, total => out); c2(2);
          FOR n := 1 TO 3 DO list[n](step := n * 10); END_FOR;
          b := list[2].total;
        END_PROGRAM";
    let mut rig = Rig::new(text);
    rig.cycle();
    assert_eq!((rig.int("a"), rig.int("out"), rig.int("MAIN.c2.total")), (14, 1006, 1002));
    assert_eq!((rig.int("b"), rig.int("MAIN.list[3].total")), (1020, 1030));
    rig.cycle();
    assert_eq!((rig.int("a"), rig.int("out")), (14, 1016));
}

#[test]
fn programs_and_globals_share() {
    let text = "
        VAR_GLOBAL CONSTANT size : INT := 4; END_VAR
        VAR_GLOBAL shared : INT := size * 2; END_VAR
        PROGRAM A VAR_INPUT x : INT; END_VAR VAR n : INT; END_VAR n := n + x; shared := shared + 1; END_PROGRAM
        PROGRAM B VAR n, m : INT; END_VAR A(x := 3); m := A.n; n := shared; END_PROGRAM";
    let mut rig = Rig::new(text);
    rig.cycle();
    assert_eq!((rig.int("A.n"), rig.int("B.m"), rig.int("B.n"), rig.int("shared")), (3, 3, 10, 10));
    // A short path means nothing where two programs have it.
    assert!(rig.machine.find("n").is_none());
    assert!(rig.machine.find("m").is_some());
}

#[test]
fn arrays() {
    let rig = once(
        "VAR a : ARRAY[-1..2] OF INT := [5, 2(7)]; m : ARRAY[0..1, 1..3] OF DINT; i, j : INT; n : INT; END_VAR",
        "FOR i := 0 TO 1 DO FOR j := 1 TO 3 DO m[i, j] := i * 10 + j; END_FOR; END_FOR;
         i := -1; n := a[i] * 1000 + a[0] * 100 + a[i + 2] * 10 + a[2]; a[a[2] + 1] := 9;",
    );
    assert_eq!(rig.int("n"), 5770);
    assert_eq!((rig.int("m[1,2]"), rig.int("MAIN.m[0, 3]"), rig.int("a[1]")), (12, 3, 9));
    assert!(rig.machine.find("a[3]").is_none() && rig.machine.find("m[1]").is_none());
}

#[test]
fn faults_name_their_line() {
    let mut rig =
        Rig::new("PROGRAM MAIN VAR n, z : INT; END_VAR\nn := 1;\nn := n / z;\nn := 3;\nEND_PROGRAM");
    let StopReason::Fault(fault) = rig.run().stop else { panic!() };
    assert_eq!((fault.kind, fault.file, fault.line), (ProgramFaultKind::DivisionByZero, 0, 3));
    assert_eq!(rig.int("n"), 1);
    // The abandoned cycle does not go on.
    let after = rig.machine.resume(0, rig.now, signal::Span::from_secs(1), &mut rig.memory);
    assert_eq!(after.stop, StopReason::Done);

    let mut rig =
        Rig::new("PROGRAM MAIN VAR a : ARRAY[1..3] OF INT; i : INT := 4; END_VAR\na[i] := 1;\nEND_PROGRAM");
    assert!(
        matches!(rig.run().stop, StopReason::Fault(fault) if fault.kind == ProgramFaultKind::Bounds && fault.line == 2)
    );
}

#[test]
fn located_variables_and_direct_addresses() {
    // controller:ADDR-01, controller:ADDR-07
    let text = "
        PROGRAM MAIN
        VAR lamp AT %QX0.4 : BOOL; level AT %IW2 : INT; big AT %MD10 : UDINT := 16#1234_5678; n : INT; END_VAR
          lamp := %IX0.1 AND NOT %MW4.15;
          %MW7 := n + 1; n := level; %QB1 := 16#5A;
        END_PROGRAM";
    let mut rig = Rig::new(text);
    rig.memory.set("%IX0.1", 1);
    rig.memory.set("%IW2", 0xFFFE);
    rig.cycle();
    assert_eq!(rig.memory.get("%QX0.4"), 1);
    assert_eq!((rig.int("n"), rig.memory.get("%MW7"), rig.memory.get("%QB1")), (-2, 1, 0x5A));
    rig.memory.set("%MX9.7", 1);
    rig.cycle();
    assert_eq!(rig.memory.get("%QX0.4"), 0);
    assert_eq!(rig.memory.get("%MW7"), 0xFFFF);
    assert_eq!(rig.memory.lines, [4, 5, 5, 4, 5, 5]);
    let program = rig.machine.program();
    let big = program.located().iter().find(|l| l.address.to_string() == "%MD10").unwrap();
    assert_eq!((big.initial, big.bits), (Some(0x1234_5678), 32));
    assert!(program.find("lamp").is_some() && rig.machine.find("lamp").is_none());
}

#[test]
fn outputs_are_known_by_program() {
    let program = crate::support::build(
        "VAR_GLOBAL lamp AT %QX0.4 : BOOL; END_VAR
         FUNCTION f : BOOL VAR_INPUT x : BOOL; END_VAR lamp := x; f := x; END_FUNCTION
         FUNCTION_BLOCK fb lamp := f(TRUE); %QW3 := %IW1; END_FUNCTION_BLOCK
         PROGRAM A VAR b : fb; x : BOOL; END_VAR b(); %MW5 := 1; x := lamp; END_PROGRAM
         PROGRAM B VAR x : BOOL; END_VAR x := f(x); x := %QX1.1; END_PROGRAM
         PROGRAM C A(); %QB0 := 1; END_PROGRAM",
    );
    let outputs = |place| program.outputs_of(place).iter().map(ToString::to_string).collect::<Vec<_>>();
    assert_eq!(outputs(0), ["%QX0.4", "%QB6", "%QB7"]);
    assert_eq!(outputs(1), ["%QX0.4"]);
    assert_eq!(outputs(2), ["%QB0", "%QX0.4", "%QB6", "%QB7"]);
    assert_eq!(outputs(3), Vec::<String>::new());
}

#[test]
fn times_are_read_and_written_in_nanoseconds() {
    let mut rig = once("VAR t : TIME := T#1.5s; END_VAR", "t := t + T#1ms;");
    assert_eq!(rig.read("t"), Value::Int(1_501_000_000));
    rig.write("t", Value::Int(2_000_999_999));
    assert_eq!(rig.read("t"), Value::Int(2_000_000_000));
}

#[test]
fn a_program_of_nothing_takes_no_time() {
    let mut rig = Rig::new("PROGRAM MAIN END_PROGRAM PROGRAM TWO ; END_PROGRAM");
    assert_eq!(rig.cycle(), signal::Span::ZERO);
}

#[test]
fn conversions_that_lose_values_need_to_be_written() {
    let with = |statement: &str| {
        codes(&format!(
            "PROGRAM P VAR i : INT; d : DINT; b : BOOL; t : TIME; u : UINT; END_VAR {statement} END_PROGRAM"
        ))
    };
    assert_eq!(with("i := d;"), ["S0302"]);
    assert_eq!(with("i := b;"), ["S0302"]);
    assert_eq!(with("t := 5;"), ["S0302"]);
    assert_eq!(with("i := 40000;"), ["S0303"]);
    assert_eq!(with("u := -1;"), ["S0303"]);
    assert_eq!(with("d := i;"), Vec::<&str>::new());
    let program = crate::support::build("PROGRAM P VAR i : INT; u : UINT; END_VAR i := u; END_PROGRAM");
    assert_eq!(program.warnings.iter().map(|w| w.code).collect::<Vec<_>>(), ["S0306"]);
}

#[test]
fn a_located_array_is_one_variable() {
    // controller:REM-03 - whatever its size: a list of its elements would be searched for each word of the memory.
    let program = crate::support::build(
        "TYPE pair : STRUCT a : INT; b : DINT; END_STRUCT; END_TYPE
         PROGRAM MAIN VAR all AT %MW10 : ARRAY[0..49999] OF INT; p AT %MW4 : pair; END_VAR all[3] := p.a; END_PROGRAM",
    );
    let covers = |word: &str| {
        let word = signal::Address::parse(word).unwrap();
        program.located().iter().filter(|located| located.overlaps(&word)).count()
    };
    assert_eq!(program.located().len(), 2);
    assert_eq!(
        ["%MW3", "%MW4", "%MW7", "%MW8", "%MW10", "%MW50009", "%MW50010", "%MX20.0", "%IW10"].map(covers),
        [0, 1, 1, 0, 1, 1, 0, 1, 0]
    );
}

#[test]
fn a_slip_in_a_name_is_seen() {
    let help = |statement: &str| {
        let text = format!("PROGRAM MAIN VAR delay : TON; Count : INT; END_VAR {statement} END_PROGRAM");
        let found =
            scanrig_program::compile(&crate::support::sources(&text), &Default::default()).unwrap_err();
        found[0].help.clone()
    };
    assert_eq!(help("dealy(IN := TRUE);"), "did you mean delay?");
    assert_eq!(help("Count := SQTR(2.0);"), "did you mean SQRT?");
    assert_eq!(help("Cuont := 1;"), "did you mean Count?");
    assert_eq!(help("delay(IM := TRUE);"), "`TON` has IN, PT");
}

#[test]
fn results_and_locals_start_at_the_initial_values_of_their_types() {
    // IEC 61131-3, 6.6.2.2: a result is a variable of the function, and has the initial value of its type.
    let mut rig = Rig::new(
        "TYPE level : INT := 5; high : level := 9; part : UINT (10..90) := 20; plain : UINT (10..90);
            mode : (idle := 3, run := 7) := run; name : STRING[8] := 'none'; row : ARRAY[0..1] OF INT := [4, 6];
            rec : STRUCT a : level; b : INT := 2; END_STRUCT; END_TYPE
        FUNCTION f : level VAR l : level; END_VAR f := f + l; END_FUNCTION
        FUNCTION g : high g := g + 1; END_FUNCTION
        FUNCTION h : part h := h + 1; END_FUNCTION
        FUNCTION p : plain p := p + 1; END_FUNCTION
        FUNCTION m : mode VAR x : INT; END_VAR x := 1; END_FUNCTION
        FUNCTION t : name VAR x : INT; END_VAR x := 1; END_FUNCTION
        FUNCTION a : row a[0] := a[0] + 1; END_FUNCTION
        FUNCTION r : rec r.a := r.a + 1; END_FUNCTION
        FUNCTION_BLOCK b METHOD v : level v := v + 1; END_METHOD
            PROPERTY q : level GET q := q + 2; END_GET END_PROPERTY END_FUNCTION_BLOCK
        PROGRAM MAIN VAR i : b; x : ARRAY[0..9] OF INT; s : STRING; named : BOOL; y : row; z : rec; e : mode; END_VAR
        VAR_TEMP w : level; END_VAR
        x[0] := f(); x[1] := f(); x[2] := g(); x[3] := UINT_TO_INT(h()); x[4] := UINT_TO_INT(p()); e := m(); s := t(); named := s = 'none';
        y := a(); z := r(); x[5] := i.v(); x[6] := i.q; x[7] := w; w := 8; END_PROGRAM",
    );
    // The same in every call.
    for _ in 0..2 {
        rig.cycle();
        let found: Vec<i128> = (0..8).map(|n| rig.int(&format!("MAIN.x[{n}]"))).collect();
        assert_eq!(found, [10, 10, 10, 21, 11, 6, 7, 5]);
        assert_eq!((rig.int("MAIN.e"), rig.int("MAIN.y[0]"), rig.int("MAIN.y[1]")), (7, 5, 6));
        assert_eq!((rig.int("MAIN.z.a"), rig.int("MAIN.z.b")), (6, 2));
        assert!(rig.on("MAIN.named"));
    }
}
