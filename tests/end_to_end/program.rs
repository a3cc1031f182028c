//! `rig program`: a program tried alone.

use crate::project_folder::TestProject;

#[test]
fn a_program_runs_alone() {
    let bench = TestProject::new();
    let pressed =
        ["program", "run", "lamp.st", "--set", "MAIN.button=TRUE", "--print", "MAIN.lamp,MAIN.delay.Q"];
    let run = |time: &str| bench.expect(0, &[&pressed[..], &["--for", time]].concat()).out;
    assert_eq!(run("500 ms"), "MAIN.lamp = FALSE\nMAIN.delay.Q = FALSE\n");
    assert_eq!(run("520 ms"), "MAIN.lamp = TRUE\nMAIN.delay.Q = TRUE\n");
    // Without `--print`, every variable.
    let all = bench.expect(0, &["program", "run", "lamp.st"]).out;
    for line in ["MAIN.button = FALSE\n", "MAIN.lamp = FALSE\n", "MAIN.delay.ET = T#0ms\n"] {
        assert!(all.contains(line), "{all}");
    }
}

#[test]
fn variables_as_json() {
    let bench = TestProject::new();
    let out =
        bench.expect(0, &["program", "run", "lamp.st", "--set", "MAIN.button=1", "--format", "json"]).out;
    let values: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert_eq!((&values["MAIN.lamp"], &values["MAIN.delay.ET"]), (&true.into(), &500_000_000.into()));
}

#[test]
fn a_fault_of_the_program_is_1_and_names_its_line() {
    let bench = TestProject::new();
    bench.write(
        "fault.st",
        "PROGRAM MAIN\nVAR a : INT := 3; b : INT; c : INT; END_VAR\na := 4;\nc := a / b;\nEND_PROGRAM\n",
    );
    let ran = bench.expect(1, &["program", "run", "fault.st"]);
    assert!(ran.err.contains("division by zero at fault.st:4"), "{}", ran.err);
    // The values at that moment are what one wants to see.
    assert!(ran.out.contains("MAIN.a = 4\n"), "{}", ran.out);
    bench.expect(0, &["program", "run", "fault.st", "--set", "MAIN.b=2"]);
}

#[test]
fn an_endless_loop_ends_with_the_run() {
    let bench = TestProject::new();
    bench.write(
        "loop.st",
        "PROGRAM MAIN\nVAR a : DINT; END_VAR\nWHILE TRUE DO\n  a := a + 1;\nEND_WHILE;\nEND_PROGRAM\n",
    );
    let ran = bench.expect(1, &["program", "run", "loop.st", "--for", "100 ms"]);
    assert!(ran.err.contains("MAST: the cycle that began after 0 s had not ended"), "{}", ran.err);
    // A loop without a body ends, too.
    bench.write("loop.st", "PROGRAM MAIN\nWHILE TRUE DO\nEND_WHILE;\nEND_PROGRAM\n");
    bench.expect(1, &["program", "run", "loop.st", "--for", "100 ms"]);
}

#[test]
fn what_cannot_be_set_or_printed_is_refused() {
    let bench = TestProject::new();
    bench.write(
        "kinds.st",
        "TYPE color : (red, green); END_TYPE\nPROGRAM MAIN\nVAR i : INT; w : WORD; b : BOOL; t : TIME; \
         m AT %MW5 : INT; r : REAL; s : STRING[5]; d : DATE; c : color; a : ARRAY[0..1, 1..2] OF INT; END_VAR\n\
         END_PROGRAM\n",
    );
    let run =
        |set: &str, print: &str| bench.rig(&["program", "run", "kinds.st", "--set", set, "--print", print]);
    for (set, print, shown) in [
        ("MAIN.i=-32768", "MAIN.i", "-32768"),
        ("MAIN.w=16#FFFF", "MAIN.w", "16#FFFF"),
        ("MAIN.b=TRUE", "MAIN.b", "TRUE"),
        ("MAIN.w=WORD#16#FF", "MAIN.w", "16#FF"),
        ("MAIN.t=T#5s", "MAIN.t", "T#5s"),
        ("MAIN.m=-5", "MAIN.m", "-5"),
        ("MAIN.r=-1.5e3", "MAIN.r", "-1500.0"),
        ("MAIN.s='it$'s'", "MAIN.s", "'it$'s'"),
        ("MAIN.s=plain", "MAIN.s", "'plain'"),
        ("MAIN.d=D#2024-02-29", "MAIN.d", "D#2024-02-29"),
        ("MAIN.c=green", "MAIN.c", "green"),
        ("MAIN.c=color#red", "MAIN.c", "red"),
        ("MAIN.a[1,2]=7", "MAIN.a", "[0, 0, 0, 7]"),
        ("MAIN.a[0,1] := 7", "MAIN.a[0,1]", "7"),
    ] {
        let ran = run(set, print);
        assert_eq!(
            (ran.code, ran.out.as_str()),
            (Some(0), format!("{print} = {shown}\n").as_str()),
            "{}",
            ran.err
        );
    }
    for set in [
        "MAIN.i=32768",
        "MAIN.i=soon",
        "MAIN.i=1.5",
        "MAIN.w=-1",
        "MAIN.w=65536",
        "MAIN.b=2",
        "MAIN.m=65536",
        "MAIN.m=-32769",
        "MAIN.t=5",
        "MAIN.s='too long'",
        "MAIN.d=D#2023-02-29",
        "MAIN.c=blue",
        "MAIN.a=1",
    ] {
        let ran = run(set, "MAIN.i");
        assert!(ran.code == Some(2) && ran.err.contains("error[R0502]"), "{set}: {}", ran.err);
    }
    let refused = |more: &[&str], words: &[&str]| {
        bench.refused(&[&["program", "run", "kinds.st"], more].concat(), words);
    };
    refused(&["--set", "MAIN.i"], &["R0503", "VARIABLE=VALUE"]);
    refused(&["--set", "MAIN.i=32768"], &["from -32768 to 32767"]);
    refused(&["--set", "MAIN.ii=1"], &["R0501", "no variable `MAIN.ii`", "did you mean `MAIN.i`?"]);
    refused(&["--print", "MAIN.x"], &["R0501", "no variable `MAIN.x`"]);
    refused(&["--for", "0 s"], &["R0504", "above 0"]);
    refused(&["--for", "1"], &["R0504", "--for 1"]);
    refused(&["--interval", "fast"], &["R0504", "--interval fast"]);
}

#[test]
fn programs_are_checked() {
    let bench = TestProject::new();
    assert_eq!(
        bench.expect(0, &["program", "check", "lamp.st"]).out,
        "no errors: programs MAIN, 6 variables\n"
    );
    bench.write(
        "two.st",
        "FUNCTION_BLOCK Blink VAR_OUTPUT q : BOOL; END_VAR q := NOT q; END_FUNCTION_BLOCK\n",
    );
    bench.write("main.st", "PROGRAM MAIN VAR b : Blink; END_VAR b(); END_PROGRAM\n");
    bench.expect(0, &["program", "check", "main.st", "two.st"]);
    bench.refused(&["program", "check", "main.st"], &["main.st:1:", "Blink"]);
    // The controller's own variables are known, and those that it alone writes are only read.
    bench.write("state.st", "PROGRAM MAIN VAR w : WORD; END_VAR w := PLC_R.i_wStatus; END_PROGRAM\n");
    bench.expect(0, &["program", "check", "state.st"]);
    bench.write("state.st", "PROGRAM MAIN PLC_R.i_wStatus := 2; END_PROGRAM\n");
    bench.refused(&["program", "check", "state.st"], &["S0401", "state.st:1:"]);
    bench.refused(&["program", "check", "lamp.st", "main.st"], &["S0201", "main.st:1:9", "lamp.st:1:9"]);
}

/// Structures, arrays, texts and enumerations; two tasks of its own.
const PLANT: &str = "\
TYPE mode : (idle, busy := 5); END_TYPE
TYPE point : STRUCT x : REAL := 1.5; label : STRING[8] := 'p'; END_STRUCT END_TYPE
PROGRAM fast
VAR n : INT; END_VAR
n := n + 1;
END_PROGRAM
PROGRAM MAIN
VAR
    m : mode := busy;
    p : point;
    list : ARRAY[1..2] OF point;
    t : TIME := T#1m30s;
    big : LINT := -9000000000000000000;
    n : INT;
END_VAR
n := n + 1;
IF n > 100 THEN
    m := idle;
END_IF;
END_PROGRAM
CONFIGURATION plant
    TASK quick (INTERVAL := T#5ms, PRIORITY := 2);
    PROGRAM f WITH quick : fast;
END_CONFIGURATION
";

#[test]
fn every_type_is_printed_in_its_form() {
    let bench = TestProject::new();
    bench.write("plant.st", PLANT);
    let all = bench.expect(0, &["program", "run", "plant.st", "--for", "40 ms"]).out;
    for line in [
        // 0, 5, ... 35 ms; and 0 and 20 ms for what has no task of its own.
        "fast.n = 8",
        "MAIN.n = 2",
        "MAIN.m = busy",
        "MAIN.p.x = 1.5",
        "MAIN.p.label = 'p'",
        "MAIN.list[2].label = 'p'",
        "MAIN.t = T#1m30s",
    ] {
        assert!(all.lines().any(|known| known == line), "{line} in\n{all}");
    }
    let print =
        ["program", "run", "plant.st", "--format", "json", "--print", "MAIN.m,MAIN.list,MAIN.t,MAIN.big"];
    let values: serde_json::Value = serde_json::from_str(&bench.expect(0, &print).out).unwrap();
    let point = serde_json::json!({ "x": 1.5, "label": "p" });
    let wanted = serde_json::json!({
        "MAIN.m": "busy", "MAIN.list": [point, point], "MAIN.t": 90_000_000_000_i64,
        "MAIN.big": -9_000_000_000_000_000_000_i64,
    });
    assert_eq!(values, wanted);
}

#[test]
fn coverage_says_which_lines_did_not_run() {
    let bench = TestProject::new();
    bench.write("plant.st", PLANT);
    let ran = bench.expect(0, &["program", "run", "plant.st", "--print", "MAIN.n", "--coverage"]).out;
    let wanted = "MAIN.n = 50\n\nCoverage\n  plant.st\n      statements    3 of 4 (75.0 %)\n      \
                  branches      1 of 2 (50.0 %)\n      not run       18\n      one way only  17\n";
    assert_eq!(ran, wanted);
    let whole = ["program", "run", "plant.st", "--for", "10 s", "--coverage", "--format", "json"];
    let values: serde_json::Value = serde_json::from_str(&bench.expect(0, &whole).out).unwrap();
    assert_eq!(values["variables"]["MAIN.m"], "idle");
    assert_eq!(values["coverage"][0]["statements_run"], 4);
    assert_eq!(values["coverage"][0]["lines_missed"], serde_json::json!([]));
}

#[test]
fn the_code_is_listed_with_its_lines_and_costs() {
    let bench = TestProject::new();
    let out = bench.expect(0, &["program", "dump", "lamp.st"]).out;
    assert!(out.starts_with("MAIN (lamp.st)"), "{out}");
    for words in ["     8 | lamp := delay.Q;", "TON", "400 ns"] {
        assert!(out.contains(words), "{out}");
    }
}

#[test]
fn scans_are_measured() {
    let bench = TestProject::new();
    let out = bench.expect(0, &["program", "bench", "lamp.st", "--cycles", "500", "--format", "json"]).out;
    let figures: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert_eq!(figures["cycles"], 500);
    let of = |what: &str, figure: &str| figures[what][figure].as_f64().unwrap();
    assert!(of("scan_us", "mean") > 0.0 && of("scan_us", "p99") <= of("scan_us", "max"));
    // A load and a store of BOOL each for IN and lamp (75), a store of TIME (25), the block (400): in us.
    assert_eq!((of("modelled_us", "mean"), of("modelled_us", "max")), (0.575, 0.575));
    assert!(bench.expect(0, &["program", "bench", "lamp.st", "--cycles", "1"]).out.contains("host"));
    bench.refused(&["program", "bench", "lamp.st", "--cycles", "0"], &["R0505"]);
    bench.write("loop.st", "PROGRAM MAIN\nVAR n : INT; END_VAR\nn := n / n;\nEND_PROGRAM\n");
    let ran = bench.expect(1, &["program", "bench", "loop.st", "--cycles", "5"]);
    assert!(ran.err.contains("loop.st:3"), "{}", ran.err);
}

#[test]
fn tasks_that_the_controller_refuses_are_named_where_they_stand() {
    let bench = TestProject::new();
    for (task, line) in [
        ("TASK quick (PRIORITY := 2);", "has neither INTERVAL nor SINGLE"),
        ("TASK quick (INTERVAL := T#5ms, PRIORITY := 15);", "both have priority 15"),
        ("TASK quick (INTERVAL := T#5ms, PRIORITY := 40);", "priority 40"),
    ] {
        bench.write("plant.st", &PLANT.replace("TASK quick (INTERVAL := T#5ms, PRIORITY := 2);", task));
        bench.refused(&["program", "check", "plant.st"], &["plant.st:22:10", line]);
    }
}

#[test]
fn a_plan_takes_the_tasks_of_the_program_and_may_override_them() {
    let bench = TestProject::new();
    bench.write("plant.st", PLANT);
    let plan = |settings: &str, fast: u32| {
        let text = format!(
            "format = 1\nprogram = \"plant.st\"\nneeds = [\"memory-access\"]\n{settings}\nends = \"start + 99 ms\"\n\
             expect = [\n  {{ value = {{ of = \"fast.n\", is = {fast}, when = \"end\" }} }},\n  \
             {{ value = {{ of = \"MAIN.n\", is = 5, when = \"end\" }} }},\n]\n"
        );
        bench.write("plant.toml", &text);
        bench.expect(0, &["test", "plant.toml"]);
    };
    plan("", 20);
    plan("settings = { tasks = { quick = { interval = \"10 ms\" } } }", 10);
    plan(
        "settings = { tasks = { slow = { interval = \"50 ms\", priority = 20, programs = [\"fast\"] } } }",
        2,
    );
    plan("settings = { mast = { programs = [\"MAIN\", \"fast\"] } }", 5);
}

#[test]
fn an_empty_controller_needs_no_program() {
    let bench = TestProject::new();
    let empty = "format = 1\nsettings = { initial = \"empty\" }\nends = \"start + 1 s\"\n\
                 expect = [{ state = { stays = \"EMPTY\" } }]\n";
    bench.write("empty.toml", empty);
    bench.expect(0, &["test", "empty.toml"]);
    bench.expect(0, &["check", "empty.toml"]);
    bench.write(
        "empty.toml",
        &empty.replace("ends", "steps = [{ id = \"d\", at = \"start\", download = {} }]\nends"),
    );
    bench.refused(&["check", "empty.toml"], &["R0108"]);
}

#[test]
fn coverage_of_plans_is_in_the_record_and_in_the_page() {
    let bench = TestProject::new();
    bench.expect(0, &["test", "lamp.toml", "--report", "plain"]);
    assert!(bench.json("plain/record.json").get("coverage").is_none());
    let ran = bench.expect(0, &["test", "lamp.toml", "--coverage", "--report", "out"]);
    assert!(ran.out.contains("statements    2 of 2 (100.0 %)"), "{}", ran.out);
    let coverage = &bench.json("out/record.json")["coverage"];
    assert_eq!((&coverage[0]["file"], &coverage[0]["statements_run"]), (&"lamp.st".into(), &2.into()));
    assert!(bench.read("out/index.html").contains("<section id=\"coverage\">"));
    // What is looked at does not change what happens.
    let trace = |folder: &str| std::fs::read(bench.path(folder).join("traces/lamp.trace")).unwrap();
    assert!(trace("plain") == trace("out"));
}
