//! Online change, breakpoints, single steps, forced variables and coverage of compiled programs.

use crate::support::{Memory, Rig, build};
use scanrig_program::{ChangeReport, Machine, StopReason};
use signal::{Span, Time, Value};
use std::sync::Arc;

fn change(rig: &mut Rig, text: &str) -> ChangeReport {
    rig.machine.change(Arc::new(build(text)), &[vec![0]]).unwrap()
}

#[test]
fn values_stay_where_name_and_type_stay() {
    let mut rig = Rig::new(
        "TYPE p : STRUCT x, y : INT; END_STRUCT; END_TYPE
         VAR_GLOBAL g : DINT := 1; gone : INT; END_VAR
         FUNCTION_BLOCK fb VAR n : INT; old : INT; t : TON; END_VAR n := n + 1; t(IN := TRUE, PT := T#10s); END_FUNCTION_BLOCK
         PROGRAM MAIN VAR i : INT := 5; r : REAL; s : STRING[10] := 'abc'; a : ARRAY[1..3] OF INT; q : p; b : fb; t : INT; END_VAR
           i := i + 1; g := g + i; r := 1.5; s := 'text'; a[1] := 10; a[3] := 30; q.x := 7; q.y := 8; b(); t := 3;
         END_PROGRAM",
    );
    rig.now = Time::from_nanos(1_000_000);
    rig.cycle();
    let report = change(
        &mut rig,
        "TYPE p : STRUCT z : INT := 99; y, x : INT; END_STRUCT; END_TYPE
         VAR_GLOBAL new : INT := 4; g : DINT := 1; END_VAR
         FUNCTION_BLOCK fb VAR t : TON; extra : INT := 6; n : INT; END_VAR n := n + 100; t(IN := TRUE, PT := T#10s); END_FUNCTION_BLOCK
         PROGRAM MAIN VAR b : fb; i : INT := 50; r : LREAL; s : STRING[10] := 'new'; a : ARRAY[2..5] OF INT; q : p; t : UINT := 9; END_VAR
           b();
         END_PROGRAM",
    );
    for (path, value) in [
        // Kept though declared in another order.
        ("g", 7),
        ("i", 6),
        ("q.x", 7),
        ("q.y", 8),
        ("b.n", 1),
        // Elements with the same index.
        ("a[2]", 0),
        ("a[3]", 30),
        ("a[5]", 0),
        // New ones and those of another type are at their initial values.
        ("q.z", 99),
        ("b.extra", 6),
        ("new", 4),
        ("t", 9),
    ] {
        assert_eq!(rig.int(path), value, "{path}");
    }
    assert_eq!(rig.read("r"), Value::Real(0.0));
    assert_eq!(rig.machine.show("s", &mut Memory::default()).unwrap().to_string(), "'text'");
    // The timer goes on; it was started within the first cycle, somewhat after 1 ms.
    rig.now = Time::from_nanos(3_001_500_000);
    rig.cycle();
    assert_eq!((rig.int("b.n"), rig.int("b.t.ET")), (101, 3_000_000_000));
    // g, i, s, a, q.x, q.y, b.n and the four pins of the timer; q.z, b.extra, new, r, t; gone, b.old, r, t.
    assert_eq!((report.kept, report.new, report.lost), (11, 5, 4), "{report:?}");
}

#[test]
fn addresses_are_not_kept() {
    let text = "FUNCTION_BLOCK fb VAR_INPUT r : REFERENCE TO INT; END_VAR END_FUNCTION_BLOCK
        PROGRAM MAIN VAR n : INT; p : POINTER TO INT; first : BOOL := TRUE; valid : BOOL; END_VAR
          IF first THEN p := ADR(n); first := FALSE; END_IF; valid := p <> NULL; END_PROGRAM";
    let mut rig = Rig::new(text);
    rig.cycle();
    assert!(rig.on("valid"));
    change(&mut rig, &text.replace("VAR n", "VAR before, n"));
    rig.cycle();
    assert!(!rig.on("valid") && !rig.on("first"));
}

#[test]
fn a_change_waits_for_the_end_of_the_cycle_and_keeps_what_is_forced() {
    let text = "PROGRAM MAIN VAR a, b : INT; END_VAR a := a + 1; b := b + a; END_PROGRAM";
    let mut rig = Rig::new(text);
    rig.machine.begin(0);
    rig.machine.resume(0, Time::ZERO, Span::from_nanos(110), &mut rig.memory);
    let program = Arc::new(build(text));
    assert!(rig.machine.change(Arc::clone(&program), &[vec![0]]).is_err());
    rig.machine.resume(0, Time::ZERO, Span::from_secs(1), &mut rig.memory);
    let a = rig.machine.find("a").unwrap();
    assert!(rig.machine.force(a, Value::Int(40)));
    assert!(rig.machine.change(program, &[vec![0]]).is_ok());
    assert_eq!(rig.machine.forced().count(), 1);
    rig.cycle();
    assert_eq!((rig.int("a"), rig.int("b")), (40, 42));
}

#[test]
fn forced_variables_hold() {
    // controller:FRC-05 - at the begin and the end of the cycles of the task.
    let mut rig = Rig::new(
        "PROGRAM MAIN VAR n, seen : INT; t : TIME; w : ARRAY[0..1] OF WORD; b : BOOL; x : TON; END_VAR
         seen := n; n := n + 1; w[1] := 5; b := FALSE; x(IN := TRUE, PT := t); END_PROGRAM",
    );
    for (path, value) in [
        ("n", Value::Int(-7)),
        ("w[1]", Value::Word(0x1234)),
        ("b", Value::Bool(true)),
        ("t", Value::Int(5_000_000)),
        ("x.Q", Value::Bool(true)),
    ] {
        let variable = rig.machine.find(path).unwrap();
        assert!(rig.machine.force(variable, value), "{path}");
        assert!(crate::support::oracle::same(rig.read(path), value), "{path}");
    }
    for _ in 0..3 {
        rig.cycle();
        assert_eq!(
            (rig.int("seen"), rig.int("n"), rig.int("w[1]"), rig.int("x.PT")),
            (-7, -7, 0x1234, 5_000_000)
        );
        assert!(rig.on("b") && rig.on("x.Q"));
    }
    let n = rig.machine.find("n").unwrap();
    assert!(rig.machine.release(n) && !rig.machine.release(n));
    rig.cycle();
    assert_eq!((rig.int("seen"), rig.int("n")), (-7, -6));
    rig.machine.release_all();
    rig.cycle();
    assert_eq!((rig.int("n"), rig.int("w[1]")), (-5, 5));
    assert!(!rig.on("b"));
}

/// Lines at which a cycle stops, with the values of a variable there.
fn stops(machine: &mut Machine, step: bool, variable: &str) -> Vec<i128> {
    let mut memory = Memory::default();
    let variable = machine.find(variable).unwrap();
    let mut values = Vec::new();
    machine.begin(0);
    for _ in 0..100 {
        if step {
            machine.step(0);
        }
        match machine.resume(0, Time::ZERO, Span::from_secs(1), &mut memory).stop {
            StopReason::Break => values.push(machine.read(variable).as_int().unwrap()),
            StopReason::Done => return values,
            other => panic!("{other:?}"),
        }
    }
    panic!("no end");
}

const STEPS: &str = "FUNCTION f : INT VAR_INPUT x : INT; END_VAR
  f := x * 2;
END_FUNCTION
PROGRAM MAIN VAR n, i : INT; END_VAR
  n := 1;
  FOR i := 1 TO 2 DO
    n := n + f(n);
  END_FOR;
  IF n > 100 THEN

    n := 0;
  ELSE
    n := n + 1;
  END_IF;
END_PROGRAM";

#[test]
fn breakpoints_stop_before_the_statement() {
    let mut machine = Rig::new(STEPS).machine;
    assert_eq!(machine.set_breakpoint(0, 7), Some(7));
    // Before each turn.
    assert_eq!(stops(&mut machine, false, "n"), [1, 3]);
    machine.clear_breakpoints();
    assert_eq!(stops(&mut machine, false, "n"), Vec::<i128>::new());
    // In the function; from the line of a declaration to the first statement after it.
    for line in [1, 2] {
        assert_eq!(machine.set_breakpoint(0, line), Some(2));
        assert_eq!(stops(&mut machine, false, "n"), [1, 3]);
        machine.clear_breakpoints();
    }
    // The branch that is not taken never stops; the other does.
    assert_eq!(machine.set_breakpoint(0, 10), Some(11));
    assert_eq!(stops(&mut machine, false, "n"), Vec::<i128>::new());
    assert_eq!(machine.set_breakpoint(0, 12), Some(13));
    assert_eq!(stops(&mut machine, false, "n"), [9]);
    assert_eq!((machine.set_breakpoint(0, 15), machine.set_breakpoint(1, 1)), (None, None));
}

#[test]
fn breakpoints_take_no_time_and_change_nothing() {
    let plain = Rig::new(STEPS).cycle();
    let mut rig = Rig::new(STEPS);
    for line in 1..14 {
        rig.machine.set_breakpoint(0, line);
    }
    rig.machine.begin(0);
    let (mut used, mut breaks) = (Span::ZERO, 0);
    loop {
        let slice = rig.machine.resume(0, Time::ZERO, Span::from_secs(1), &mut rig.memory);
        used = used + slice.used;
        match slice.stop {
            StopReason::Break => breaks += 1,
            StopReason::Done => break,
            other => panic!("{other:?}"),
        }
    }
    assert_eq!(used, plain);
    // n := 1, FOR, twice the sum and the function, IF, its branch.
    assert_eq!((breaks, rig.int("n")), (8, 10));
}

#[test]
fn single_steps_follow_calls() {
    let mut machine = Rig::new(STEPS).machine;
    // Values before n := 1, FOR, sum, f, sum, f, IF, n + 1.
    assert_eq!(stops(&mut machine, true, "n"), [0, 1, 1, 1, 3, 3, 9, 9]);
}

/// Lines executed, lines not executed, and of each branch its line with whether it was taken and not taken.
type Covered = (Vec<u32>, Vec<u32>, Vec<(u32, bool, bool)>);

/// Which statements ran, and which branches went which way.
fn covered(text: &str) -> Covered {
    let mut rig = Rig::new(text);
    rig.machine.set_coverage(true);
    rig.cycle();
    let coverage = rig.machine.coverage();
    let lines = |ran: bool| {
        let mut lines: Vec<u32> =
            coverage.statements.iter().filter(|s| s.executed == ran).map(|s| s.line).collect();
        lines.sort_unstable();
        lines
    };
    let branches = coverage.branches.iter().map(|b| (b.line, b.taken, b.passed)).collect();
    (lines(true), lines(false), branches)
}

/// Of a line: how many of the ways of its branches were gone, of how many.
fn ways(branches: &[(u32, bool, bool)], line: u32) -> (usize, usize) {
    let here = branches.iter().filter(|(at, ..)| *at == line);
    let gone = here.clone().map(|(_, taken, passed)| usize::from(*taken) + usize::from(*passed)).sum();
    (gone, 2 * here.count())
}

#[test]
fn coverage_of_selections() {
    let text = "PROGRAM MAIN VAR i, n : INT; END_VAR
  i := 5;
  IF i = 1 THEN
    n := 1;
  ELSIF i = 5 THEN
    n := 2;
  ELSIF i = 6 THEN
    n := 3;
  ELSE
    n := 4;
  END_IF;
  CASE i OF
    1: n := 5;
    2..9: n := 6;
  ELSE
    n := 7;
  END_CASE;
END_PROGRAM";
    let (ran, rest, branches) = covered(text);
    assert_eq!(ran, [2, 3, 6, 12, 14]);
    assert_eq!(rest, [4, 8, 10, 13, 16]);
    assert_eq!((ways(&branches, 3), ways(&branches, 5), ways(&branches, 7)), ((1, 2), (1, 2), (0, 2)));
}

#[test]
fn coverage_of_loops() {
    let text = "PROGRAM MAIN VAR i, n : INT; END_VAR
  FOR i := 1 TO 3 DO
    IF i = 2 THEN
      CONTINUE;
    END_IF;
    n := n + 1;
  END_FOR;
  WHILE n < 2 DO
    n := n + 1;
  END_WHILE;
  REPEAT
    n := n + 1;
  UNTIL n > 3 END_REPEAT;
  FOR i := 5 TO 1 DO
    n := 0;
  END_FOR;
END_PROGRAM";
    let (ran, rest, branches) = covered(text);
    assert_eq!(ran, [2, 3, 4, 6, 8, 11, 12, 14]);
    assert_eq!(rest, [9, 15]);
    // Both ways of the IF, one of the WHILE that never turned.
    assert_eq!(ways(&branches, 3), (2, 2));
    assert_eq!(ways(&branches, 13), (2, 2));
    // Switched on again it starts from nothing.
    let mut rig = Rig::new(text);
    rig.machine.set_coverage(true);
    rig.cycle();
    rig.machine.set_coverage(true);
    assert!(rig.machine.coverage().statements.iter().all(|statement| !statement.executed));
}

#[test]
fn coverage_of_units_and_files() {
    let file = |name: &str, text: &str| document::SourceFile { name: name.into(), text: text.into() };
    let sources = [
        file(
            "a.st",
            "FUNCTION used : INT\n used := 1;\nEND_FUNCTION\nFUNCTION unused : INT\n unused := 1;\nEND_FUNCTION",
        ),
        file(
            "b.st",
            "FUNCTION_BLOCK fb VAR n : INT; END_VAR\n METHOD m : INT\n  m := 1;\n END_METHOD\n n := used();\nEND_FUNCTION_BLOCK",
        ),
        file("c.st", "PROGRAM MAIN VAR b : fb; END_VAR\n\n b();\nEND_PROGRAM"),
    ];
    let program = scanrig_program::compile(&sources, &scanrig_program::Options::default()).unwrap();
    let mut machine = Machine::new(Arc::new(program), &[vec![0]]).unwrap();
    machine.set_coverage(true);
    machine.begin(0);
    machine.resume(0, Time::ZERO, Span::from_secs(1), &mut Memory::default());
    let mut found: Vec<(u16, u32, bool)> =
        machine.coverage().statements.iter().map(|s| (s.file, s.line, s.executed)).collect();
    found.sort_unstable();
    let expected = [(0, 2, true), (0, 5, false), (1, 3, false), (1, 5, true), (2, 3, true)];
    assert_eq!(found, expected);
}
