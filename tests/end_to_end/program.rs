//! `rig program`: a program tried alone.

use crate::bench::Bench;

#[test]
fn a_program_runs_alone() {
    let bench = Bench::new();
    let pressed =
        ["program", "run", "lamp.st", "--set", "MAIN.button=TRUE", "--print", "MAIN.lamp,MAIN.delay.Q"];
    let run = |time: &str| bench.expect(0, &[&pressed[..], &["--for", time]].concat()).out;
    assert_eq!(run("500 ms"), "MAIN.lamp = FALSE\nMAIN.delay.Q = FALSE\n");
    assert_eq!(run("520 ms"), "MAIN.lamp = TRUE\nMAIN.delay.Q = TRUE\n");
    // Without `--print`, every variable.
    let all = bench.expect(0, &["program", "run", "lamp.st"]).out;
    assert!(
        all.starts_with("MAIN.button = FALSE\nMAIN.lamp = FALSE\n") && all.contains("MAIN.delay.ET = 0 s\n"),
        "{all}"
    );
}

#[test]
fn variables_as_json() {
    let bench = Bench::new();
    let out =
        bench.expect(0, &["program", "run", "lamp.st", "--set", "MAIN.button=1", "--format", "json"]).out;
    let values: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert_eq!((&values["MAIN.lamp"], &values["MAIN.delay.ET"]), (&true.into(), &500_000_000.into()));
}

#[test]
fn a_fault_of_the_program_is_1_and_names_its_line() {
    let bench = Bench::new();
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
    let bench = Bench::new();
    bench.write(
        "loop.st",
        "PROGRAM MAIN\nVAR a : DINT; END_VAR\nWHILE TRUE DO\n  a := a + 1;\nEND_WHILE;\nEND_PROGRAM\n",
    );
    let ran = bench.expect(1, &["program", "run", "loop.st", "--for", "100 ms"]);
    assert!(ran.err.contains("the cycle that began after 0 s had not ended"), "{}", ran.err);
    // A loop without a body ends, too.
    bench.write("loop.st", "PROGRAM MAIN\nWHILE TRUE DO\nEND_WHILE;\nEND_PROGRAM\n");
    bench.expect(1, &["program", "run", "loop.st", "--for", "100 ms"]);
}

#[test]
fn what_cannot_be_set_or_printed_is_refused() {
    let bench = Bench::new();
    bench.write(
        "kinds.st",
        "PROGRAM MAIN\nVAR i : INT; w : WORD; b : BOOL; t : TIME; m AT %MW5 : INT; END_VAR\nEND_PROGRAM\n",
    );
    let run =
        |set: &str, print: &str| bench.rig(&["program", "run", "kinds.st", "--set", set, "--print", print]);
    for (set, print, shown) in [
        ("MAIN.i=-32768", "MAIN.i", "-32768"),
        ("MAIN.w=16#FFFF", "MAIN.w", "16#FFFF"),
        ("MAIN.b=TRUE", "MAIN.b", "TRUE"),
        ("MAIN.t=T#5s", "MAIN.t", "5 s"),
        ("MAIN.m=-5", "MAIN.m", "16#FFFB"),
    ] {
        let ran = run(set, print);
        assert_eq!(
            (ran.code, ran.out.as_str()),
            (Some(0), format!("{print} = {shown}\n").as_str()),
            "{}",
            ran.err
        );
    }
    for set in ["MAIN.i=32768", "MAIN.w=-1", "MAIN.w=65536", "MAIN.b=2", "MAIN.m=65536", "MAIN.m=-32769"] {
        let ran = run(set, "MAIN.i");
        assert!(ran.code == Some(2) && ran.err.contains("cannot have this value"), "{set}: {}", ran.err);
    }
    bench.refused(&["program", "run", "kinds.st", "--set", "MAIN.i"], &["VARIABLE=VALUE"]);
    bench.refused(&["program", "run", "kinds.st", "--set", "MAIN.i=soon"], &["`soon` is no value"]);
    bench.refused(
        &["program", "run", "kinds.st", "--set", "MAIN.ii=1"],
        &["no variable `MAIN.ii`", "did you mean `MAIN.i`?"],
    );
    bench.refused(&["program", "run", "kinds.st", "--print", "MAIN.x"], &["no variable `MAIN.x`"]);
    bench.refused(&["program", "run", "kinds.st", "--for", "0 s"], &["above 0"]);
    bench.refused(&["program", "run", "kinds.st", "--for", "1"], &["--for 1"]);
    bench.refused(&["program", "run", "kinds.st", "--interval", "fast"], &["--interval fast"]);
}

#[test]
fn programs_are_checked() {
    let bench = Bench::new();
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
    bench.refused(&["program", "check", "lamp.st", "main.st"], &["S0201", "main.st:1:9", "lamp.st:1:9"]);
}
