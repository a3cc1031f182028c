//! `rig run`: the controller kept running on a board.

use crate::project_folder::TestProject;
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use std::io::{BufRead, BufReader};
use std::process::Stdio;

const BOARD: &str = "\
format = 1
[board]
kind = \"simulated\"
[subject]
alarm = \"running\"
power = \"supply\"
[channels]
running = { kind = \"digital\" }
supply = { kind = \"digital\", pull = \"up\" }
[[wires]]
from = \"running\"
to = \"I0\"
";

fn bench() -> TestProject {
    let bench = TestProject::new();
    bench.write("bench.toml", BOARD);
    bench
}

/// The lines without their instants, which follow the host's clock.
fn reported(out: &str) -> Vec<&str> {
    out.lines().map(|line| line.split_once(" s  ").unwrap().1.trim()).collect()
}

const BOOT: [&str; 4] = ["ready", "BOOTING", "boot decision by row 15", "RUNNING"];

#[test]
fn a_program_runs_until_its_time_is_over() {
    let bench = bench();
    let ran = bench.expect(0, &["run", "--board", "bench.toml", "--program", "lamp.st", "--for", "2 s"]);
    assert_eq!(reported(&ran.out), BOOT);
    assert!(ran.err.contains("outputs safe"), "{}", ran.err);
    // 1.5 s of boot; MAST runs every 20 ms.
    assert!(ran.err.contains("MAST: 25 cycles"), "{}", ran.err);
}

#[test]
fn a_first_boot_that_takes_no_time_leads_where_a_boot_leads() {
    let bench = bench();
    let args = ["run", "--board", "bench.toml", "--program", "lamp.st", "--booted", "--for", "500 ms"];
    let ran = bench.expect(0, &args);
    assert_eq!(reported(&ran.out), BOOT);
    let last = ran.out.lines().last().unwrap();
    assert!(last.trim_start().starts_with("0.00"), "{last}");
    assert!(ran.err.contains("MAST: 25 cycles"), "{}", ran.err);
}

#[test]
fn a_case_lends_its_program_and_settings() {
    let bench = bench();
    let on_disk = bench.expect(0, &["run", "--board", "bench.toml", "--case", "lamp", "--for", "1.6 s"]);
    assert_eq!(reported(&on_disk.out), BOOT);
    let args = ["run", "--board", "bench.toml", "--case", "wires/run-stop[keep]", "--for", "1.6 s"];
    assert!(reported(&bench.expect(0, &args).out).contains(&"RUNNING"));
}

#[test]
fn an_interrupt_ends_it_well() {
    let bench = bench();
    let mut child = bench
        .command(&["run", "--board", "bench.toml", "--program", "lamp.st"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
    assert!(lines.any(|line| line.unwrap().ends_with("RUNNING")));
    kill(Pid::from_raw(child.id() as i32), Signal::SIGTERM).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(0));
}

#[test]
fn what_cannot_be_played_is_said() {
    let bench = bench();
    bench.write(
        "real.toml",
        "format = 1\nboard = { kind = \"simulated\" }\nsubject = { kind = \"external\" }\n",
    );
    let refused = |args: &[&str], words: &[&str]| bench.refused(args, words);
    refused(&["run", "--board", "real.toml", "--program", "lamp.st"], &["R0221", "is a real controller"]);
    refused(&["run", "--board", "bench.toml", "--program", "lamp.st", "--for", "0"], &["R0222"]);
    let wrong = ["run", "--board", "bench.toml", "--case", "lamp[slow]"];
    refused(&wrong, &["R0223", "has no case `lamp[slow]`", "its cases are lamp"]);
    refused(&["run", "--board", "bench.toml", "--program", "none.st"], &["R0201", "none.st"]);
}

#[test]
fn a_controller_that_nothing_loads_is_taken_at_its_word_once() {
    let bench = bench();
    let board =
        "format = 1\nboard = { kind = \"simulated\" }\n[subject]\nkind = \"external\"\nboot = \"1 s\"\n";
    bench.write("real.toml", board);
    // Nobody lights the lamp: what the run says before does not depend on that.
    let ran = bench.rig(&["test", "lamp.toml", "--board", "real.toml", "--repeat", "3"]);
    assert_eq!(ran.code, Some(1), "{}", ran.err);
    assert_eq!(ran.err.matches("R0224").count(), 1, "{}", ran.err);
}
