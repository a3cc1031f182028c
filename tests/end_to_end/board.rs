//! `rig board` where there are no lines: clear words, and nothing moves. What it does with lines is tested in the lab.

use std::path::Path;

use crate::project_folder::TestProject;
use crate::terminal::{talk, terminal};

const LINES: &str = r#"format = 1
[board]
kind = "real"
[chips]
main = { label = "no-machine-has-this" }
[channels]
door = { kind = "digital", line = 3 }
valve = { kind = "digital", line = "VALVE", drives = true, safe = true }
pump = { kind = "digital", line = 5, drives = true }
"#;

fn bench() -> TestProject {
    let bench = TestProject::new();
    bench.write("lines.toml", LINES);
    bench.write("modelled.toml", "format = 1\n[board]\nkind = \"simulated\"\n");
    bench
}

/// Whether this machine has GPIO lines, so that what it says of having none cannot be seen.
fn has_lines() -> bool {
    let dev = std::fs::read_dir(Path::new("/dev")).unwrap();
    dev.flatten().any(|entry| entry.file_name().to_string_lossy().starts_with("gpiochip"))
}

#[test]
fn a_machine_without_lines_has_nothing_to_scan_but_says_what_it_has() {
    if has_lines() {
        return;
    }
    let bench = bench();
    bench.refused(
        &["board", "scan", "--root", "."],
        &["error[R0240]: this machine has no GPIO lines, nor another device", "rig doctor"],
    );
    bench.write("sys/class/net/can0/type", "280\n");
    bench.write("sys/class/watchdog/watchdog0/identity", "a dog\n");
    bench.refused(
        &["board", "scan", "--root", ".", "-o", "first.toml"],
        &["R0240", "only\n", "  can       can0", "  watchdog  /dev/watchdog0 a dog"],
    );
    assert!(!bench.path("first.toml").exists());
}

#[test]
fn lines_that_are_not_there_are_named_with_their_place() {
    if has_lines() {
        return;
    }
    let bench = bench();
    let ran = bench.expect(2, &["board", "check", "lines.toml"]);
    assert_eq!(ran.out, "door   not available\nvalve  not available\npump   not available\n");
    assert!(ran.err.contains("error[B0170]") && ran.err.contains("lines.toml:5:1"), "{}", ran.err);
    bench.refused(
        &["board", "watch", "lines.toml", "--for", "1 s"],
        &["error[B0170]", "valve, pump are outputs"],
    );
    bench.refused(&["board", "exercise", "lines.toml", "--yes", "valve"], &["error[B0170]"]);
}

#[test]
fn a_modelled_board_has_no_lines_to_look_for() {
    for command in ["check", "watch", "exercise"] {
        bench()
            .refused(&["board", command, "modelled.toml"], &["error[R0243]", "simulated", "rig board scan"]);
    }
}

#[test]
fn no_output_moves_without_consent() {
    let bench = bench();
    bench.refused(&["board", "exercise", "lines.toml"], &["error[R0245]", "--yes"]);
    bench.refused(
        &["board", "exercise", "lines.toml", "--yes", "pump,vale,door"],
        &["error[R0246]: `vale` is no output", "did you mean `valve`?", "`door` is no output"],
    );
    bench.refused(&["board", "watch", "lines.toml", "--for", "0 s"], &["above 0"]);
    // Somebody is there, and does not want it.
    let (ended, screen) = talk(terminal(&bench, &["board", "exercise", "lines.toml"]), &["no", "no"]);
    assert_eq!(ended, Some(0), "{screen}");
    assert!(screen.contains("valve: drive it from 1 to 0 for 500 ms, and back?"), "{screen}");
    assert!(screen.contains("pump: drive it from 0 to 1 for 500 ms, and back?"), "{screen}");
}
