//! Modelled time: what operations cost, and that slicing changes nothing (controller:PERF-01).

use crate::support::{Memory, Rig, build, sources};
use proptest::prelude::*;
use scanrig_program::{Costs, Machine, Options, StopReason, compile};
use signal::{Span, Time, Value};
use std::sync::Arc;

fn nanos(declarations: &str, statements: &str) -> i64 {
    let mut rig = Rig::new(&format!("PROGRAM MAIN {declarations} {statements} END_PROGRAM"));
    rig.cycle().as_nanos()
}

#[test]
fn operations_cost_what_the_documents_say() {
    let variables = "VAR i, j : INT; d, e : DINT; b, c : BOOL; l : LINT; END_VAR";
    for (statement, expected) in [
        // controller:PERF-01 - a load and a store of INT take 64 ns, of DINT 49 ns, one addition 42 and 41 ns.
        ("i := j;", 64),
        ("i := j + 1;", 64 + 42),
        ("i := j + i;", 64 + 32 + 42),
        ("d := e;", 49),
        ("d := e - 1;", 49 + 41),
        ("b := c;", 75),
        ("b := NOT c;", 75 + 75),
        ("b := b AND c;", 75 + 75 + 37),
        ("b := TRUE;", 38),
        // Constant expressions take no time.
        ("i := 2 + 3 * 4;", 32),
        ("b := i > 5;", 32 + 42 + 38),
        ("IF b THEN i := 1; END_IF;", 37 + 20),
        ("i := d_1;", 32),
    ] {
        let declarations = format!("{variables} VAR CONSTANT d_1 : INT := 3; END_VAR");
        assert_eq!(nanos(&declarations, statement), expected, "{statement}");
    }
}

#[test]
fn retained_variables_cost_more() {
    // controller:REM-05
    assert_eq!(nanos("VAR RETAIN i : INT; END_VAR", "i := i + 1;"), 64 + 42 + 40);
}

#[test]
fn an_endless_loop_takes_time_even_where_branches_are_free() {
    let costs = Costs { branch: 0, ..Costs::default() };
    let text = "PROGRAM MAIN WHILE TRUE DO ; END_WHILE; END_PROGRAM";
    let program = compile(&sources(text), &Options { costs, ..Options::default() }).unwrap();
    let mut machine = Machine::new(Arc::new(program), &[vec![0]]).unwrap();
    machine.begin(0);
    let slice = machine.resume(0, Time::ZERO, Span::from_micros(50), &mut Memory::default());
    assert_eq!(
        (slice.used, slice.stop),
        (Span::from_micros(50), StopReason::Budget { next: Span::from_nanos(1) })
    );
}

#[test]
fn an_operation_that_does_not_fit_waits() {
    let mut rig = Rig::new("PROGRAM MAIN VAR i, j : INT := 5; END_VAR i := j + 1; END_PROGRAM");
    rig.machine.begin(0);
    let mut slice =
        |budget: i64| rig.machine.resume(0, Time::ZERO, Span::from_nanos(budget), &mut rig.memory);
    // The load, the addition and the store are one operation of 32 + 42 + 32 ns.
    let first = slice(105);
    assert_eq!((first.used.as_nanos(), first.stop), (0, StopReason::Budget { next: Span::from_nanos(106) }));
    assert_eq!(slice(41).used, Span::ZERO);
    let last = slice(106);
    assert_eq!(last.used.as_nanos(), 106);
    assert_eq!(slice(0).stop, StopReason::Done);
}

#[test]
fn watched_variables_and_locations_stop_the_slice() {
    let mut rig = Rig::new(
        "PROGRAM MAIN VAR i, j : INT; t : R_TRIG; END_VAR j := 1; i := 2; i := 2; t(CLK := TRUE); %QX0.1 := TRUE; j := 3; END_PROGRAM",
    );
    let (i, q) = (rig.machine.find("i").unwrap(), rig.machine.find("t.Q").unwrap());
    rig.machine.watch(i);
    rig.machine.watch(q);
    rig.memory.watched = Some(signal::Address::parse("%QB0").unwrap());
    rig.machine.begin(0);
    let mut used = 0;
    let mut stops = Vec::new();
    loop {
        let slice =
            rig.machine.resume(0, Time::ZERO + Span::from_nanos(used), Span::from_secs(1), &mut rig.memory);
        used += slice.used.as_nanos();
        stops.push((used, matches!(slice.stop, StopReason::Touched { .. })));
        if slice.stop == StopReason::Done {
            break;
        }
    }
    // The second store of the same value is no change.
    assert_eq!(stops, [(64, true), (534, true), (572, true), (604, false)]);
}

/// A program with everything that could depend on where it is cut.
const WORK: &str = "
    FUNCTION mix : DINT VAR_INPUT a, b : DINT; END_VAR VAR k : INT; END_VAR
      mix := a * 31 + b; FOR k := 1 TO 3 DO mix := mix XOR SHL(mix, k); END_FOR;
    END_FUNCTION
    FUNCTION_BLOCK stage VAR_INPUT x : DINT; END_VAR VAR_OUTPUT y : DINT; END_VAR VAR RETAIN sum : DINT; END_VAR
      sum := mix(sum, x); y := sum MOD 1000;
    END_FUNCTION_BLOCK
    PROGRAM ONE VAR n : INT; list : ARRAY[0..3] OF stage; t : TON; i, last : DINT; END_VAR
      n := n + 1;
      FOR i := 0 TO 3 DO list[i](x := n + i); last := last + list[DINT_TO_INT(i)].y; END_FOR;
      t(IN := n MOD 7 <> 0, PT := T#2ms);
      CASE n MOD 4 OF 0: %MW10 := %MW10 + 1; 1..2: %QX0.3 := t.Q; ELSE last := -last; END_CASE;
    END_PROGRAM
    PROGRAM TWO VAR m : LINT; END_VAR
      REPEAT m := m + ONE.n; UNTIL m MOD 5 = 0 OR m MOD 7 = 3 END_REPEAT;
    END_PROGRAM
    (* Every run of operations that is executed in one go. *)
    PROGRAM THREE VAR a, b, c : BOOL; x, y, z, i : DINT; h : ARRAY[0..3] OF DINT; END_VAR VAR RETAIN s : DINT; END_VAR
      x := x + 1; y := x; a := x > 3; b := a; c := TRUE;
      IF a AND b OR c THEN z := x + y; END_IF;
      IF a THEN z := z + y; ELSE z := 7; END_IF;
      IF x = 5 THEN z := 1; END_IF; IF x < 9 THEN z := z + 2; END_IF; IF x <= 4 THEN z := z + 3; END_IF;
      IF x > 2 THEN z := z + 4; END_IF; IF x >= 6 THEN z := z + 5; ELSE z := z - 1; END_IF;
      IF x = z THEN y := 1; END_IF; IF x < z THEN y := 2; END_IF; IF x <= z THEN y := 3; END_IF;
      IF x > y THEN y := 4; END_IF; IF x >= y THEN y := 5; END_IF;
      CASE x OF 1: z := z + 6; 2, 3: z := z + 7; ELSE z := z - 2; END_CASE;
      b := a AND NOT c; c := a OR b; a := b AND c; y := x / 3; c := x > 4; b := x < 4;
      h[x MOD 4] := z;
      FOR i := 0 TO 3 DO s := s + h[i]; IF s > 100 THEN s := s - 90; ELSE s := s + 1; END_IF; END_FOR;
    END_PROGRAM";

/// Runs cycles, one every millisecond, each in slices of these lengths by turns. Everything that can be seen of it.
fn run(budgets: &[i64], watch: bool) -> (Vec<i64>, Vec<Value>, Vec<u8>, Vec<u32>) {
    let program = Arc::new(build(WORK));
    let mut machine = Machine::new(Arc::clone(&program), &[vec![0, 1, 2]]).unwrap();
    let mut memory = Memory::default();
    if watch {
        for path in ["n", "list[2].y", "t.ET", "m", "s", "z", "b"] {
            let variable = machine.find(path).unwrap();
            machine.watch(variable);
        }
    }
    let mut turn = budgets.iter().cycle();
    let mut times = Vec::new();
    for cycle in 0..12 {
        let start = Time::ZERO + Span::from_millis(cycle);
        machine.begin(0);
        let mut used = Span::ZERO;
        let mut least = 0;
        loop {
            let budget = Span::from_nanos(*turn.next().unwrap_or(&1000).max(&least));
            let slice = machine.resume(0, start + used, budget, &mut memory);
            assert!(slice.used <= budget);
            used = used + slice.used;
            match slice.stop {
                StopReason::Done => break,
                // An operation longer than every slice has to be let through.
                StopReason::Budget { next } => least = next.as_nanos(),
                StopReason::Touched { .. } => least = 0,
                stop => panic!("{stop:?}"),
            }
        }
        times.push(used.as_nanos());
    }
    let cells =
        program.variables().iter().filter_map(|v| machine.find(&v.path)).map(|v| machine.read(v)).collect();
    (times, cells, memory.words.bytes()[..64].to_vec(), memory.lines)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]
    #[test]
    fn results_and_times_do_not_depend_on_slices(
        budgets in proptest::collection::vec(prop_oneof![0..50i64, 0..5_000i64], 1..20),
        watch in any::<bool>(),
    ) {
        prop_assert_eq!(run(&budgets, watch), run(&[1_000_000_000], false));
    }
}

#[test]
fn an_index_out_of_bounds_stops_at_its_own_operation_however_it_is_cut() {
    let text = "PROGRAM MAIN VAR h : ARRAY[0..3] OF INT; i, x : INT; END_VAR i := 7; x := h[i]; END_PROGRAM";
    let program = Arc::new(build(text));
    let ends = |budget: Span| {
        let mut machine = Machine::new(Arc::clone(&program), &[vec![0]]).unwrap();
        machine.begin(0);
        let mut used = Span::ZERO;
        let mut least = Span::ZERO;
        loop {
            let slice = machine.resume(0, Time::ZERO + used, budget.max(least), &mut Memory::default());
            used = used + slice.used;
            match slice.stop {
                StopReason::Fault(fault) => return (used, fault),
                StopReason::Budget { next } => least = next,
                _ => panic!("the cycle ends with a fault"),
            }
        }
    };
    // A budget for one operation at a time, and one for all.
    assert_eq!(ends(Span::from_nanos(60)), ends(Span::from_secs(1)));
}

#[test]
fn tasks_keep_apart() {
    // Two tasks inside the same function at the same time have frames of their own.
    let text = "
        FUNCTION f : INT VAR_INPUT x : INT; END_VAR VAR k : INT; END_VAR k := x; f := k * 2; f := f + k; END_FUNCTION
        PROGRAM A VAR r : INT; END_VAR r := f(5); END_PROGRAM
        PROGRAM B VAR r : INT; END_VAR r := f(100); END_PROGRAM";
    let mut machine = Machine::new(Arc::new(build(text)), &[vec![0], vec![1]]).unwrap();
    let mut memory = Memory::default();
    machine.begin(0);
    machine.begin(1);
    let mut done = [false; 2];
    while done != [true; 2] {
        for (task, done) in done.iter_mut().enumerate() {
            // One operation of each in turn: the longest costs less than two slices of this.
            let slice = machine.resume(task, Time::ZERO, Span::from_nanos(250), &mut memory);
            *done = slice.stop == StopReason::Done;
        }
    }
    let read = |path: &str| machine.read(machine.find(path).unwrap());
    assert_eq!((read("A.r"), read("B.r")), (Value::Int(15), Value::Int(300)));
}
