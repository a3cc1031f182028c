//! Plants in Structured Text, from the files to the trace and the record.

use crate::texts::Texts;
use document::{Diagnostic, SourceFile};
use record::Verdict;
use scanrig_runtime::suite;
use scanrig_runtime::{CaseResult, ClockKind, RunOptions};
use signal::{Time, Value};
use std::sync::atomic::AtomicBool;

const CONTROLLER: &str = "PROGRAM MAIN END_PROGRAM";

fn plan(rest: &str) -> String {
    format!(
        "format = 1\ntitle = \"A plant\"\nprogram-text = \"{CONTROLLER}\"\nboard = \"board.toml\"\n
         signals = {{ x = {{ channel = \"x\", record = true }}, y = {{ channel = \"y\", record = true }}, on = \"on\" }}\n{rest}\n"
    )
}

fn board(period: &str, pins: &str) -> String {
    format!(
        "format = 1\n[board]\nkind = \"simulated\"\n[channels]\nx = {{ kind = \"analog\" }}\ny = {{ kind = \"analog\" }}
         on = {{ kind = \"digital\" }}\n[[plants]]\nkind = \"program\"\nname = \"plant\"\nprogram = \"plant.st\"
         period = \"{period}\"\n{pins}\n"
    )
}

fn run(plan: &str, board: &str, plant: &str) -> Box<CaseResult> {
    let interrupt = AtomicBool::new(false);
    let options = RunOptions::new(ClockKind::Virtual, &interrupt);
    Texts(&[("plan.toml", plan), ("board.toml", board), ("plant.st", plant)]).run(5, &options)
}

/// What a signal changes to, with the instants in nanoseconds.
fn changes(result: &CaseResult, name: &str) -> Vec<(i64, Value)> {
    let trace = result.trace.as_ref().unwrap();
    let signal = trace.find(name).unwrap();
    let events = trace.events().map(Result::unwrap).filter(|event| event.signal == signal);
    events.map(|event| (event.at.latest.as_nanos(), event.value)).collect()
}

const ENDS: &str = "ends = \"start + 10 s\"\nexpect = [{ state = { stays = \"RUNNING\" } }]";

// Two tanks exchange a part k of their difference in each cycle: the difference is (1 - 2 k)^n of what it was, the sum stays.
#[test]
fn a_recurrence_is_followed_cycle_by_cycle() {
    let plant = "PROGRAM Tanks VAR_INPUT k : LREAL := 0.5; END_VAR VAR_OUTPUT left : LREAL := 3.0; right : LREAL := 1.0; END_VAR
        VAR flow : LREAL; END_VAR
        flow := k * (left - right); left := left - flow; right := right + flow; END_PROGRAM";
    let board = board("7 ms", "outputs = { left = \"x\", right = \"y\" }\nparameters = { k = 0.001 }");
    let result = run(&plan(ENDS), &board, plant);
    crate::texts::expect(&result, Verdict::Pass);
    for (name, sign) in [("x", 1.0), ("y", -1.0)] {
        let changes = changes(&result, name);
        // 10 s and what the controller takes to start.
        assert!(changes.len() > 10_000 / 7, "{}", changes.len());
        for (n, (at, value)) in changes.iter().enumerate() {
            assert_eq!(*at, n as i64 * 7_000_000);
            let expected = 2.0 + sign * 0.998f64.powi(n as i32);
            assert!((value.as_real().unwrap() - expected).abs() < 1e-9, "{name} {n}: {value:?}");
        }
    }
}

#[test]
fn timers_of_a_plant_take_the_time_of_the_bench() {
    let plant = "PROGRAM Timer VAR d : TON; n : INT; END_VAR VAR_OUTPUT done : BOOL; since : LREAL; END_VAR
        FOR n := 0 TO 100 DO ; END_FOR
        d(IN := TRUE, PT := T#1s); IF d.Q AND NOT done THEN since := LINT_TO_LREAL(LTIME_TO_LINT(LTIME())); END_IF
        done := d.Q; END_PROGRAM";
    let result = run(&plan(ENDS), &board("100 ms", "outputs = { done = \"on\", since = \"x\" }"), plant);
    crate::texts::expect(&result, Verdict::Pass);
    // It begins in the first cycle, at 0.1 s.
    let ticked = changes(&result, "x");
    assert_eq!(ticked.last(), Some(&(1_100_000_000, Value::Real(1.1e9))));
    assert_eq!(changes(&result, "on").last(), Some(&(1_100_000_000, Value::Bool(true))));
}

#[test]
fn a_plant_that_fails_is_an_error_of_the_bench_with_its_line() {
    let loops = "PROGRAM P VAR n : DINT; END_VAR VAR_OUTPUT x : DINT; END_VAR\nx := x + 1;\nIF x = 200 THEN\nWHILE TRUE DO\nn := n + 1;\nEND_WHILE\nEND_IF\nEND_PROGRAM";
    for (plant, why) in [
        (
            "PROGRAM P VAR_OUTPUT x : DINT; END_VAR\nx := x + 1;\nIF x = 200 THEN\nx := x / (x - 200);\nEND_IF\nEND_PROGRAM",
            ["plant.st:4: division by zero", "plant.st:4: division by zero"],
        ),
        (
            "PROGRAM P VAR a : ARRAY [0..199] OF INT; END_VAR VAR_OUTPUT x : DINT; END_VAR\nx := x + 1;\na[x] := 1;\nEND_PROGRAM",
            ["plant.st:3: index outside", "plant.st:3: index outside"],
        ),
        (loops, ["plant.st:4: a cycle that does not end", "plant.st:5: a cycle that does not end"]),
    ] {
        let result = run(&plan(ENDS), &board("10 ms", "outputs = { x = \"x\" }"), plant);
        crate::texts::expect(&result, Verdict::Error);
        let reason = &result.record.reason;
        let begins = "the plant `plant` failed at 2.000000000 s: ";
        assert!(reason.starts_with(begins) && reason.ends_with("(R0334)"), "{reason}");
        assert!(why.iter().any(|why| reason.contains(why)), "{reason}");
        // What it drove stays, and nothing comes after it.
        assert_eq!(changes(&result, "x").last(), Some(&(1_990_000_000, Value::Real(199.0))));
    }
}

#[test]
fn numbers_are_brought_to_the_types_of_variables() {
    let plant =
        "PROGRAM P VAR_INPUT i : INT; r : REAL; u : ULINT; END_VAR VAR_OUTPUT x : LREAL; y : LREAL; END_VAR
        x := INT_TO_LREAL(i) + REAL_TO_LREAL(r); y := ULINT_TO_LREAL(u); END_PROGRAM";
    let board = board("1 ms", "inputs = { i = \"a\", u = \"a\" }\noutputs = { x = \"x\", y = \"y\" }")
        .replace("on = {", "a = { kind = \"analog\" }\non = {");
    for (written, x, y) in [
        ("2.5", 2.0, 2.0),
        ("3.5", 4.0, 4.0),
        ("-40000", -32768.0, 0.0),
        ("1e30", 32767.0, 1.8446744073709552e19),
    ] {
        let rest = format!(
            "ends = \"start + 1 s\"\nsteps = [{{ id = \"w\", at = \"start\", set = {{ signal = \"a\", value = {written} }} }}]\nexpect = [{{ state = {{ stays = \"RUNNING\" }} }}]"
        );
        let plan = plan(&rest).replace("on = \"on\"", "on = \"on\", a = \"a\"");
        let result = run(&plan, &board, plant);
        crate::texts::expect(&result, Verdict::Pass);
        for (name, expected) in [("x", x), ("y", y)] {
            assert_eq!(
                changes(&result, name).last().map(|(_, value)| *value),
                Some(Value::Real(expected)),
                "{written}"
            );
        }
    }
}

/// What reading a board with this program finds.
fn found(program: &str, keys: &str) -> Vec<Diagnostic> {
    let board = board("1 ms", keys);
    let files = [("board.toml", board.as_str()), ("plant.st", program)];
    suite::load_board(&Texts(&files), "board.toml", &mut Vec::new()).err().unwrap_or_default()
}

#[test]
fn what_no_plant_can_run_is_refused_with_the_reason() {
    for (program, says) in [
        ("PROGRAM A END_PROGRAM PROGRAM B END_PROGRAM", "`A` and `B`"),
        ("PROGRAM A VAR i AT %IX0.1 : BOOL; END_VAR END_PROGRAM", "%IX0.1"),
        ("PROGRAM A %QX0.1 := TRUE; END_PROGRAM", "%QX0.1"),
        ("PROGRAM A VAR n : DINT; END_VAR\nn := GetRtc(); END_PROGRAM", "plant.st:2 asks"),
        (
            "PROGRAM A END_PROGRAM CONFIGURATION c RESOURCE r ON cpu TASK t(INTERVAL := T#10ms, PRIORITY := 1);
             PROGRAM p WITH t : A; END_RESOURCE END_CONFIGURATION",
            "`t`",
        ),
    ] {
        let found = found(program, "");
        assert!(found.len() == 1 && found[0].code == "B0512", "{found:#?}");
        assert!(found[0].message.contains(says) && found[0].labels[0].file == "board.toml", "{found:#?}");
    }
    // What the compiler finds stands in the program itself.
    for (program, code) in [
        ("PROGRAM A x := 1; END_PROGRAM", "S0301"),
        ("PROGRAM A VAR w AT %MW0 : INT; END_VAR END_PROGRAM", "S0207"),
    ] {
        let found = found(program, "");
        assert!(found[0].code == code && found[0].labels[0].file == "plant.st", "{found:#?}");
    }
    let missing = [("board.toml", board("1 ms", "")), ("other.st", String::new())];
    let missing: Vec<(&str, &str)> = missing.iter().map(|(name, text)| (*name, text.as_str())).collect();
    let found = suite::load_board(&Texts(&missing), "board.toml", &mut Vec::new()).unwrap_err();
    assert!(
        found[0].labels[0].file == "board.toml" && found[0].help.contains("relative to the board file"),
        "{found:#?}"
    );
}

#[test]
fn findings_in_a_program_come_with_its_text() {
    let board = board("1 ms", "");
    let mut sources: Vec<SourceFile> = Vec::new();
    let files = [("board.toml", board.as_str()), ("plant.st", "PROGRAM A x := 1; END_PROGRAM")];
    assert!(suite::load_board(&Texts(&files), "board.toml", &mut sources).is_err());
    let names: Vec<&str> = sources.iter().map(|source| source.name.as_str()).collect();
    assert_eq!(names, ["board.toml", "plant.st"]);
}

#[test]
fn the_program_of_a_plant_is_a_part_of_the_board() {
    let board = board("10 ms", "outputs = { x = \"x\" }");
    let hashes = |step: &str| {
        let plant = format!("PROGRAM P VAR_OUTPUT x : DINT; END_VAR x := x + {step}; END_PROGRAM");
        let plan = plan(ENDS);
        let files =
            [("plan.toml", plan.as_str()), ("board.toml", board.as_str()), ("plant.st", plant.as_str())];
        let (loaded, _) = Texts(&files).load(1);
        let record = run(&plan, &board, &plant).record.clone();
        (loaded.sha256(), record.hashes.board, record.hashes.program)
    };
    let (one, other) = (hashes("1"), hashes("2"));
    assert!(one.0 != other.0 && one.1 != other.1 && one.2 == other.2);
    assert_eq!(one, hashes("1"));
}

// Each plant has the variables for itself, though they share the code.
#[test]
fn the_variables_of_all_plants_have_a_limit_together() {
    let plant = "PROGRAM P VAR_OUTPUT n : DINT; END_VAR VAR all : ARRAY [0..1000000] OF BYTE; END_VAR n := 1; END_PROGRAM";
    let check = |count: usize| {
        let one = |n: usize| {
            format!(
                "[[plants]]\nkind = \"program\"\nname = \"p{n}\"\nprogram = \"plant.st\"\nperiod = \"1 s\"\n"
            )
        };
        let more: String = (1..count).map(one).collect();
        let (plan, board) = (plan(ENDS), board("1 s", &format!("outputs = {{ n = \"x\" }}\n{more}")));
        let files = [("plan.toml", plan.as_str()), ("board.toml", board.as_str()), ("plant.st", plant)];
        let loaded = suite::load_plan(&Texts(&files), "plan.toml", None, &[], 1, &mut Vec::new());
        loaded.err().unwrap_or_default()
    };
    assert!(check(60).is_empty());
    let found = check(70);
    assert!(found[0].code == "B0512" && found[0].message.contains("64 MiB"), "{found:#?}");
}

// Plants of one file share its code, and nothing else.
#[test]
fn one_program_is_several_plants() {
    let plant = "PROGRAM P VAR_INPUT step : INT := 1; END_VAR VAR_OUTPUT n : DINT; END_VAR n := n + step; END_PROGRAM";
    let other =
        "[[plants]]\nkind = \"program\"\nname = \"other\"\nprogram = [\"plant.st\"]\nperiod = \"500 ms\"
        outputs = { n = \"y\" }\nparameters = { STEP = -2 }\n";
    let board = board("1 s", &format!("outputs = {{ n = \"x\" }}\n{other}"));
    let result = run(&plan(ENDS), &board, plant);
    crate::texts::expect(&result, Verdict::Pass);
    let second = |n: i64| Time::from_nanos(n * 1_000_000_000).as_nanos();
    let value = |name: &str, at: i64| {
        let mut until = changes(&result, name).into_iter().filter(|(when, _)| *when <= second(at));
        until.next_back().map(|(_, value)| value)
    };
    assert_eq!((value("x", 10), value("y", 10)), (Some(Value::Real(10.0)), Some(Value::Real(-40.0))));
}
