//! Exit code 2: something is wrong with the user's files or arguments, and nothing has moved.

use crate::project_folder::TestProject;

#[test]
fn arguments_that_mean_nothing() {
    let bench = TestProject::new();
    bench.refused(&[], &["Usage: rig"]);
    bench.refused(&["tset"], &["unrecognized subcommand 'tset'", "'test'"]);
    bench.refused(&["test", "--bogus"], &["--bogus"]);
    bench.refused(&["test", "--jobs", "0"], &["'0'", "--jobs"]);
    bench.refused(&["test", "--repeat", "0"], &["--repeat"]);
    bench.refused(&["test", "--seed", "-1"], &["-1"]);
    bench.refused(&["test", "--clock", "sundial"], &["sundial", "virtual", "real"]);
    // The project in the current folder is checked.
    assert_eq!(bench.expect(0, &["check"]).out, "lamp.toml: no errors\n");
    bench.refused(&["run", "--board", "b.toml", "--program", "lamp.st", "--led"], &["R0225", "`--stepped`"]);
    bench.refused(&["judge", "lamp.toml"], &["TRACE"]);
}

#[test]
fn help_and_version_are_no_fault() {
    let bench = TestProject::new();
    let help = bench.expect(0, &["--help"]);
    for word in ["test", "check", "judge", "requirements", "program", "Exit codes", "130"] {
        assert!(help.out.contains(word), "{word}");
    }
    assert!(bench.expect(0, &["--version"]).out.starts_with("rig "));
    assert!(bench.expect(0, &["test", "--help"]).out.contains("--fail-fast"));
}

#[test]
fn files_that_are_not_there() {
    let bench = TestProject::new();
    bench.refused(&["test", "lmap.toml"], &["R0201", "lmap.toml"]);
    bench.refused(&["test", "lamp.toml", "--board", "bench.toml"], &["R0201", "bench.toml"]);
    bench.refused(&["check", "lmap.toml"], &["R0201", "lmap.toml"]);
    bench.refused(&["judge", "lmap.toml", "lamp.st"], &["R0204", "lamp.st"]);
    bench.refused(&["judge", "lamp.toml", "none.trace"], &["R0201", "none.trace", "help"]);
    bench.refused(&["program", "run", "lmap.st"], &["R0201", "lmap.st"]);
    bench.write_lamp("other.toml", "lamp.st", "missing.st");
    bench.refused(
        &["test", "other.toml"],
        &["R0201", "missing.st", "other.toml:4:11", "relative to the plan"],
    );
    bench.write_lamp("other.toml", "program =", "board = \"missing.toml\"\nprogram =");
    bench.refused(
        &["test", "other.toml"],
        &["R0201", "missing.toml", "other.toml:4:9", "relative to the plan"],
    );
    bench.write("board.toml", "format = 1\n[board]\nkind = \"simulated\"\n");
    let run = bench.expect(2, &["run", "--board", "board.toml", "--program", "missing.st"]);
    assert!(run.err.contains("R0201") && !run.err.contains("rig-run"), "{}", run.err);
    bench.write("empty/readme.txt", "");
    bench.refused(&["test", "empty"], &["R0230", "empty holds no plan"]);
    // Files of other kinds say what they are, in one finding.
    bench.write("suite.toml", "format = 1\n");
    for (file, what) in [
        ("board.toml", "a board file and no plan"),
        ("lamp.st", "a program and no plan"),
        ("suite.toml", "a suite file and no plan"),
    ] {
        let ran = bench.expect(2, &["test", file]);
        assert!(ran.err.contains("R0235") && ran.err.contains(what), "{}", ran.err);
        assert_eq!(ran.err.matches("error[").count(), 1, "{}", ran.err);
    }
    std::fs::remove_file(bench.path("suite.toml")).unwrap();
    // A folder in place of a file, and a file in place of a folder.
    bench.refused(&["test", "lamp.toml", "--board", "empty"], &["R0201", "empty"]);
    bench.refused(&["test", "lamp.toml", "--report", "lamp.st"], &["lamp.st"]);
}

#[test]
fn files_that_are_no_text() {
    let bench = TestProject::new();
    std::fs::write(bench.path("bytes.toml"), b"format = 1\ntitle = \"\xff\"\n").unwrap();
    bench.refused(&["test", "bytes.toml"], &["R0201", "bytes.toml", "no UTF-8 text (byte 20)"]);
    let file = std::fs::File::create(bench.path("large.toml")).unwrap();
    file.set_len(1 << 40).unwrap();
    bench.refused(&["check", "large.toml"], &["R0201", "large.toml", "1099511627776 bytes"]);
}

#[test]
fn broken_files() {
    let bench = TestProject::new();
    bench.write_lamp("plan.toml", "rises", "rsies");
    bench.refused(&["test", "plan.toml"], &["P0502", "plan.toml:10:", "rises"]);
    bench.write("lamp.st", "PROGRAM MAIN\nlamp := TRUE;\nEND_PROGRAM\n");
    // The program is read with the case, so that the case has a line, too.
    let ran = bench.expect(2, &["test", "lamp.toml"]);
    assert!(ran.err.contains("S0301") && ran.err.contains("lamp.st:2:1"), "{}", ran.err);
    bench.write("board.toml", "format = 1\n[board]\nkind = \"simulated\"\n[bind]\n\"%IX0.0\" = \"Q77\"\n");
    bench.refused(&["test", "lamp.toml", "--board", "board.toml"], &["B0304", "board.toml:5:12"]);
    // Every broken file is reported in one run.
    bench.write_lamp("more.toml", "rises", "risse");
    bench.refused(&["test", "plan.toml", "more.toml"], &["plan.toml:10:", "more.toml:10:"]);
}

#[test]
fn signals_that_the_bench_does_not_have() {
    let bench = TestProject::new();
    bench.write_lamp("lamp.toml", "%QX0.4", "%QX7.0");
    let ran = bench.expect(2, &["test", "lamp.toml"]);
    assert!(ran.err.contains("error[R01") && ran.err.contains("lamp.toml:5:"), "{}", ran.err);
    // Nothing ran, and the counts do not say that anything passed.
    assert!(!ran.out.contains("PASS"), "{}", ran.out);
}

#[test]
fn selections_of_nothing() {
    let bench = TestProject::new();
    bench.refused(&["test", "lamp.toml", "--only", "nothing"], &["R0228", "no case is selected", "--list"]);
    bench.refused(
        &["test", "lamp.toml", "--only", "nothing", "--list"],
        &["R0228", "no case is selected", "--list"],
    );
    bench.refused(&["test", "lamp.toml", "--only", "(lamp"], &["R0227", "never closed", "character 1"]);
    bench.refused(&["test", "lamp.toml", "--only", "lamp and"], &["character 9"]);
    bench.refused(&["test", "lamp.toml", "--only", "colour:red"], &["unknown kind"]);
    bench.refused(&["test", "lamp.toml", "--only", ""], &["--only"]);
}

#[test]
fn a_plan_given_twice() {
    let bench = TestProject::new();
    bench.refused(&["test", "lamp.toml", "lamp.toml"], &["lamp", "given twice"]);
    bench.refused(&["test", "lamp.toml", "./lamp.toml"], &["given twice"]);
    bench.refused(&["test", ".", "lamp.toml"], &["given twice"]);
}

#[test]
fn parameters_that_no_plan_has() {
    let bench = TestProject::new();
    bench.write(
        "limit.toml",
        &(crate::project_folder::LAMP.replace("\"500 ms .. 550 ms\"", "\"$limit\"")
            + "[parameters]\nlimit = \"500 ms .. 550 ms\"\n"),
    );
    bench.refused(&["test", "limit.toml", "--param", "limit"], &["R0229", "NAME=VALUE"]);
    bench.refused(&["test", "limit.toml", "--param", "lmit=1 s"], &["`lmit`", "did you mean `limit`?"]);
    bench.refused(
        &["test", "limit.toml", "--param", "limit=1 s", "--param", "limit=2 s"],
        &["a value already"],
    );
    bench.refused(
        &["test", "lamp.toml", "--param", "limit=1 s"],
        &["R0229", "no plan has a parameter `limit`"],
    );
    bench.refused(&["test", "--shipped", "--param", "limit=1 s"], &["no plan has a parameter `limit`"]);
    // A value that does not fit is shown where it is used.
    bench.refused(
        &["test", "limit.toml", "--param", "limit=soon"],
        &["P0104", "limit.toml:10:", "here it reads \"soon\""],
    );
    bench.refused(&["check", "limit.toml", "--param", "limit=soon"], &["P0104"]);
}
