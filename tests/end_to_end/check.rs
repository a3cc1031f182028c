//! `rig check`: what is wrong with files that are not broken enough to be in the folders of broken ones, and what is
//! right.

use crate::project_folder::{LAMP, TestProject, root};

#[test]
fn sound_files_have_no_errors() {
    let bench = TestProject::new();
    bench.write("board.toml", "format = 1\n[board]\nkind = \"simulated\"\n");
    let ran = bench.expect(0, &["check", "lamp.toml", "lamp.st", "board.toml"]);
    assert_eq!(ran.out, "lamp.toml: no errors\nlamp.st: no errors\nboard.toml: no errors\n");
    assert_eq!(ran.err, "");
    let library = root().join("plans/library");
    let ran = bench.expect(0, &["check", library.to_str().unwrap()]);
    // Programs that the compiler warns of are there for it, and say so.
    let meant = ["types/lreal.toml", "types/promotion.st", "memory/relocation.st", "watchdog/fault.st"];
    let mut lines = ran.err.lines();
    while let Some(line) = lines.next() {
        if line.starts_with("warning[S") || line.starts_with("warning[R0117]") {
            let place = lines.next().unwrap_or_default();
            assert!(meant.iter().any(|file| place.contains(file)), "{line}\n{place}");
        }
    }
}

#[test]
fn an_instrument_file_is_checked_as_what_it_is() {
    let bench = TestProject::new();
    let file =
        "format = 1\n[timebase]\nerror = \"25 ppm\"\n[channels.CH1]\nunit = \"V\"\nthreshold = \"2.5 V\"\n";
    bench.write("scope.toml", file);
    let ran = bench.expect(0, &["check", "scope.toml"]);
    assert_eq!((ran.out.as_str(), ran.err.as_str()), ("scope.toml: no errors\n", ""));
    bench.write("wrong.toml", &file.replace("threshold", "treshold"));
    bench.refused(&["check", "wrong.toml"], &["R0211", "wrong.toml:6", "did you mean `threshold`?"]);
    // The search of a folder takes it for no plan.
    let ran = bench.expect(0, &["check", "."]);
    assert_eq!(ran.out, "lamp.toml: no errors\n");
}

#[test]
fn a_board_is_checked_with_the_programs_of_its_plants() {
    let bench = TestProject::new();
    let board = "format = 1\n[board]\nkind = \"simulated\"\n[[plants]]\nkind = \"program\"\nname = \"vessel\"
program = \"../vessel.st\"\nperiod = \"10 ms\"\ninputs = { fill = \"Q0\" }\n";
    bench.write("boards/board.toml", board);
    let program = |line: &str| {
        format!(
            "PROGRAM Vessel\nVAR_INPUT fill : BOOL; END_VAR\nVAR n : INT; u : UINT; END_VAR\n{line}\nEND_PROGRAM\n"
        )
    };
    bench.write("vessel.st", &program("n := 1;"));
    let ran = bench.expect(0, &["check", "boards/board.toml"]);
    assert_eq!((ran.out.as_str(), ran.err.as_str()), ("boards/board.toml: no errors\n", ""));
    bench.write("vessel.st", &program("m := 1;"));
    bench.refused(&["check", "boards/board.toml"], &["S0301", "boards/../vessel.st:4:1", "m := 1;"]);
    let ran = bench.expect(2, &["check", "--board", "boards/board.toml", "lamp.toml"]);
    assert!(ran.err.contains("S0301") && ran.err.contains("boards/../vessel.st:4:1"), "{}", ran.err);
    // A warning is shown, and the board can be used.
    bench.write("vessel.st", &program("n := u;"));
    let ran = bench.expect(0, &["check", "boards/board.toml"]);
    assert_eq!(ran.out, "boards/board.toml: no errors\n");
    assert!(ran.err.contains("warning[S0306]"), "{}", ran.err);
    bench.write("boards/board.toml", &board.replace("../vessel.st", "vesel.st"));
    bench.refused(&["check", "boards/board.toml"], &["board.toml:7:11", "relative to the board file"]);
}

#[test]
fn one_broken_file_does_not_hide_the_others() {
    let bench = TestProject::new();
    bench.write_lamp("a.toml", "rises", "risse");
    bench.write("b.st", "PROGRAM MAIN\nlamp := TRUE;\nEND_PROGRAM\n");
    let ran = bench.expect(2, &["check", "a.toml", "lamp.toml", "b.st"]);
    assert_eq!(ran.out, "lamp.toml: no errors\n");
    assert!(ran.err.contains("a.toml:10:5") && ran.err.contains("b.st:2:1"), "{}", ran.err);
}

#[test]
fn a_plan_is_checked_with_its_program_and_on_its_board() {
    let bench = TestProject::new();
    bench.write_lamp("name.toml", "lamp = \"%QX0.4\"", "lamp = \"%QX0.4\", et = \"MAIN.delay.TE\"");
    let ran = bench.expect(2, &["check", "name.toml"]);
    assert!(
        ran.err.contains("R0104") && ran.err.contains("name.toml:5:") && ran.err.contains("MAIN.delay.ET"),
        "{}",
        ran.err
    );
    bench.write_lamp("program.toml", "lamp.st", "broken.st");
    bench.write("broken.st", "PROGRAM MAIN\nVAR x : INT; END_VAR\nx := y;\nEND_PROGRAM\n");
    let ran = bench.expect(2, &["check", "program.toml"]);
    assert!(ran.err.contains("S0301") && ran.err.contains("broken.st:3:6"), "{}", ran.err);
}

#[test]
fn a_board_can_be_given_as_for_a_test() {
    let bench = TestProject::new();
    bench.write("board.toml", "format = 1\n[board]\nkind = \"simulated\"\n[channels]\nheat = { kind = \"analog\", unit = \"degC\" }\n");
    bench.write("heat.toml", &LAMP.replace("lamp = \"%QX0.4\"", "lamp = \"%QX0.4\", heat = \"heat\""));
    bench.expect(2, &["check", "heat.toml"]);
    let ran = bench.expect(0, &["check", "heat.toml", "--board", "board.toml"]);
    assert_eq!(ran.out, "board.toml: no errors\nheat.toml: no errors\n");
    bench.expect(0, &["check", "--board", "board.toml"]);
    bench.refused(&["check", "--board", "lamp.toml"], &["B0004", "program"]);
}

#[test]
fn what_the_compiler_warns_of_in_a_plans_program_is_shown_once() {
    let bench = TestProject::new();
    bench.write(
        "warned.st",
        "PROGRAM MAIN\nVAR a, b : UINT; c : BOOL; d : LREAL; END_VAR\nc := a - b > 5;\nEND_PROGRAM\n",
    );
    bench.write(
        "warned.toml",
        "format = 1\ntitle = \"A program with warnings\"\nprofiles = [\"m241-2014\", \"m241-2019\", \"m251-2024\"]\n\
         program = \"warned.st\"\nexpect = [{ state = { is = \"RUNNING\", when = \"end\" } }]\n\
         [rows]\none = {}\ntwo = {}\n",
    );
    for command in ["check", "test"] {
        let ran = bench.expect(0, &[command, "warned.toml"]);
        assert_eq!(ran.err.matches("[S0309]").count(), 1, "{}", ran.err);
        // It names the profile, of which two lack the type.
        assert_eq!(ran.err.matches("[R0117]").count(), 2, "{}", ran.err);
        assert!(ran.err.contains("warned.st:3:6"), "{}", ran.err);
    }
}
