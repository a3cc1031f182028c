//! What a user sees, word for word: the README's example and a failing plan.
//!
//! `SCANRIG_BLESS=1 cargo test -p scanrig-cli --test end_to_end` writes the goldens again.

use crate::project_folder::{CommandOutput, TestProject, root};

/// Compares with `tests/end_to_end/goldens/NAME`.
pub fn golden(name: &str, command: &str, ran: &CommandOutput) {
    let path = root().join("tests/end_to_end/goldens").join(name);
    let text = format!("$ {command}\n{}{}exit {}\n", ran.out, ran.err, ran.code.unwrap());
    if std::env::var_os("SCANRIG_BLESS").is_some() {
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, &text).unwrap();
    }
    let golden = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(text == golden, "{name} reads now:\n{text}\nand should read:\n{golden}");
}

fn run(bench: &TestProject, name: &str, args: &[&str]) {
    golden(name, &format!("rig {}", args.join(" ")), &bench.rig(args));
}

/// The README's blocks of code in a language.
fn blocks(language: &str) -> Vec<String> {
    let readme = std::fs::read_to_string(root().join("README.md")).unwrap();
    let fence = format!("```{language}\n");
    readme.split(&fence).skip(1).map(|part| part.split("```").next().unwrap().to_owned()).collect()
}

#[test]
fn the_example_of_the_readme() {
    let bench = TestProject::new();
    let (programs, plans) = (blocks("iecst"), blocks("toml"));
    assert_eq!((programs.len(), plans.len()), (1, 1));
    bench.write("lamp.st", &programs[0]);
    bench.write("lamp.toml", &plans[0]);
    run(&bench, "readme-check.txt", &["check", "lamp.toml"]);
    run(&bench, "readme-test.txt", &["test", "lamp.toml", "--report", "out"]);
    run(&bench, "readme-judge.txt", &["judge", "lamp.toml", "out/traces/lamp.trace"]);
    for file in ["index.html", "junit.xml", "record.json", "traces/lamp.trace", "traces/lamp.vcd"] {
        assert!(bench.path("out").join(file).is_file(), "{file}");
    }
}

#[test]
fn a_failing_plan() {
    let bench = TestProject::new();
    bench.write_lamp("slow.toml", "500 ms .. 550 ms", "490 ms .. 510 ms");
    run(&bench, "failing.txt", &["test", "slow.toml", "lamp.toml"]);
}

#[test]
fn an_inconclusive_and_an_inapplicable_plan() {
    let bench = TestProject::new();
    bench.write(
        "late.toml",
        "format = 1\n[board]\nkind = \"simulated\"\n[faults]\nlate = { chance = 1.0, by = \"40 ms\" }\n",
    );
    bench.write_lamp("m251.toml", "program =", "profiles = [\"m251-2024\"]\nprogram =");
    run(&bench, "inconclusive.txt", &["test", "lamp.toml", "m251.toml", "--board", "late.toml"]);
}

#[test]
fn trouble_of_the_rig() {
    let bench = TestProject::new();
    bench.write(
        "bad.toml",
        "format = 1\n[board]\nkind = \"simulated\"\n[faults]\nlost = { chance = 1.0, duration = \"10 ms\" }\n",
    );
    run(&bench, "trouble.txt", &["test", "lamp.toml", "--board", "bad.toml"]);
}

#[test]
fn broken_files() {
    let bench = TestProject::new();
    bench.write_lamp("lamp.toml", "within = \"500 ms .. 550 ms\"", "withn = \"500 ms .. 550 ms\"");
    run(&bench, "broken-plan.txt", &["check", "lamp.toml"]);
    bench.write(
        "lamp.st",
        "PROGRAM MAIN\nVAR\n    lamp AT %QX0.4 : BOOL\nEND_VAR\nlapm := TRUE;\nEND_PROGRAM\n",
    );
    run(&bench, "broken-program.txt", &["program", "check", "lamp.st"]);
}

#[test]
fn a_program_alone() {
    let bench = TestProject::new();
    run(
        &bench,
        "program-run.txt",
        &["program", "run", "lamp.st", "--set", "MAIN.button=TRUE", "--for", "1 s"],
    );
}

#[test]
fn a_list() {
    let bench = TestProject::new();
    run(&bench, "list.txt", &["test", ".", "--list"]);
}
