//! Files of any kind: none holds the command up, none is passed over, and what cannot be written is reported.

use crate::project_folder::{LAMP, LAMP_ST, TestProject};
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::Stdio;

const SUITE: &str = "format = 1\ninvariants = [{ never = { signal = \"%QX0.4\", is = true } }]\n";

fn pipe(path: &Path) {
    let (kind, mode) = (rustix::fs::FileType::Fifo, rustix::fs::Mode::RWXU);
    rustix::fs::mknodat(rustix::fs::CWD, path, kind, mode, 0).unwrap();
}

#[test]
fn a_suite_file_under_another_name_is_refused() {
    for name in ["Suite.toml", "SUITE.TOML", "suit.toml", "suites.toml"] {
        let bench = TestProject::new();
        bench.write(name, SUITE);
        for command in ["test", "check"] {
            let words = ["R0205", name, "a suite file is called `suite.toml`", "rename it"];
            bench.refused(&[command, "lamp.toml"], &words);
        }
    }
    let bench = TestProject::new();
    // A plan may have any name, and so may a file that it includes.
    bench.write("suit.toml", LAMP);
    bench.write("suites.toml", SUITE);
    bench.write_lamp("with.toml", "format = 1", "format = 1\ninclude = [\"suites.toml\"]");
    bench.expect(1, &["test", "with.toml"]);
}

#[test]
fn a_suite_that_cannot_be_read_is_refused() {
    let bench = TestProject::new();
    let suite = bench.path("suite.toml");
    let refused = |what: &str| bench.refused(&["test", "lamp.toml"], &["R0201", "suite.toml", what]);
    symlink(bench.path("nowhere.toml"), &suite).unwrap();
    refused("No such file");
    std::fs::remove_file(&suite).unwrap();
    std::fs::create_dir(&suite).unwrap();
    refused("it is a folder and no regular file");
    std::fs::remove_dir(&suite).unwrap();
    pipe(&suite);
    refused("it is a pipe and no regular file");
}

#[test]
fn an_included_file_is_read_or_refused() {
    let bench = TestProject::new();
    let invariant = SUITE.strip_prefix("format = 1\n").unwrap();
    for (text, code) in [
        (invariant, "P0102"),
        ("", "P0102"),
        ("fromat = 1\n", "P0102"),
        ("format = 1\ninvariants = [{", "P0001"),
    ] {
        bench.write("common.toml", text);
        bench.write_lamp("with.toml", "format = 1", "format = 1\ninclude = [\"common.toml\"]");
        bench.refused(&["test", "with.toml"], &[code, "common.toml"]);
    }
    bench.write("common.toml", SUITE);
    bench.expect(1, &["test", "with.toml"]);
}

#[test]
fn no_pipe_and_no_device_holds_the_command_up() {
    let bench = TestProject::new();
    pipe(&bench.path("pipe.toml"));
    pipe(&bench.path("pipe.st"));
    bench.expect(0, &["test", "lamp.toml", "--report", "run"]);
    bench.write_lamp("of-pipe.toml", "lamp.st", "pipe.st");
    bench.write_lamp("of-device.toml", "lamp.st", "/dev/zero");
    bench.write_lamp("on-pipe.toml", "program =", "board = \"pipe.toml\"\nprogram =");
    bench.write_lamp("with-pipe.toml", "format = 1", "format = 1\ninclude = [\"pipe.toml\"]");
    for args in [
        &["test", "pipe.toml"][..],
        &["check", "pipe.toml"],
        &["check", "pipe.st"],
        &["test", "of-pipe.toml"],
        &["test", "of-device.toml"],
        &["test", "on-pipe.toml"],
        &["test", "with-pipe.toml"],
        &["test", "lamp.toml", "--board", "pipe.toml"],
        &["test", "/dev/zero"],
        &["judge", "lamp.toml", "pipe.toml"],
        &["judge", "lamp.toml", "/dev/zero"],
        &["judge", "lamp.toml", "."],
        &["diff", "run", "pipe.toml"],
        &["report", "pipe.toml"],
        &["history", "add", "run", "--file", "pipe.toml"],
        &["history", "show", "--file", "pipe.toml"],
    ] {
        let ran = bench.expect(2, args);
        assert!(ran.err.contains("error["), "rig {args:?} names no code: {}", ran.err);
    }
    // A pipe that the shell makes is read once, and a plan more often.
    let ran = bench.rig(&["check", "/dev/stdin"]);
    assert_eq!(ran.code, Some(2), "{}", ran.err);
    // In a folder what looks like a plan and cannot be read is refused.
    bench.refused(&["test", "."], &["R0201", "pipe.toml"]);
}

#[test]
fn links_in_circles_give_each_plan_once() {
    let bench = TestProject::new();
    bench.write("plans/lamp.st", LAMP_ST);
    bench.write("plans/lamp.toml", LAMP);
    std::fs::create_dir(bench.path("plans/a")).unwrap();
    std::fs::create_dir(bench.path("plans/b")).unwrap();
    symlink("..", bench.path("plans/a/up")).unwrap();
    symlink("../a", bench.path("plans/b/a")).unwrap();
    symlink("../b", bench.path("plans/a/b")).unwrap();
    let out = bench.expect(0, &["test", "--list", "plans"]).out;
    assert_eq!(out.lines().count(), 1, "{out}");
    symlink("nowhere.toml", bench.path("plans/gone.toml")).unwrap();
    bench.refused(&["test", "plans"], &["R0201", "plans/gone.toml"]);
}

#[test]
fn names_do_not_reach_the_terminal_as_commands() {
    let bench = TestProject::new();
    let name = "la\u{1b}]0;owned\u{7}\u{1b}[2Jmp.toml";
    bench.write(name, &LAMP.replace("half a second", "\\u001B[8m half a second"));
    for args in [&["test", name, "--status-level", "all"][..], &["test", name, "--list"], &["check", name]] {
        let ran = bench.expect(0, args);
        assert!(!ran.out.contains(['\u{1b}', '\u{7}']), "rig {args:?}: {:?}", ran.out);
    }
    let listed = bench.expect(0, &["test", name, "--list"]).out;
    assert!(listed.contains("la\\u001b]0;owned\\u0007"), "{listed:?}");
    bench.write(name, "format = 1\n");
    let ran = bench.expect(2, &["test", name]);
    assert!(!ran.err.contains(['\u{1b}', '\u{7}']), "{:?}", ran.err);
    // A colour of the rig's own stays.
    assert!(bench.expect(0, &["test", "lamp.toml", "--color", "always"]).out.contains("\u{1b}["));
    let json = bench.rig(&["test", "lamp.toml", "--format", "json"]).out;
    json.lines().for_each(|line| drop(serde_json::from_str::<serde_json::Value>(line).unwrap()));
}

/// Runs the command with its standard output on a full disk.
fn on_a_full_disk(bench: &TestProject, args: &[&str]) -> (Option<i32>, String) {
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let ran = bench.command(args).stdout(Stdio::from(full)).output().unwrap();
    (ran.status.code(), String::from_utf8(ran.stderr).unwrap())
}

#[test]
fn what_cannot_be_written_is_reported() {
    let bench = TestProject::new();
    for args in [
        &["test", "lamp.toml", "--format", "json"][..],
        &["test", "lamp.toml"],
        &["explain"],
        &["schema", "plan"],
    ] {
        let (code, err) = on_a_full_disk(&bench, args);
        assert!(code == Some(4) && err.contains("R0232"), "rig {args:?}: {code:?} {err}");
    }
    bench.refused(&["test", "lamp.toml", "--report", "/dev/full"], &["R0167", "/dev/full"]);
    for place in ["/dev/full", "pipe"] {
        if place == "pipe" {
            pipe(&bench.path(place));
        }
        let ran = bench.expect(4, &["test", "lamp.toml", "--summary", place]);
        assert!(ran.err.contains("R0167"), "{}", ran.err);
    }
    assert!(bench.rig(&["test", "lamp.toml", "--summary", "pipe"]).err.contains("nobody reads it"));
    bench.expect(0, &["test", "lamp.toml", "--summary", "/dev/null"]);
}

#[test]
fn a_report_leaves_no_unfinished_file() {
    let bench = TestProject::new();
    // As a command leaves it that was killed.
    bench.write("out/traces/.rig-unfinished", "half");
    bench.expect(0, &["test", "lamp.toml", "--report", "out"]);
    let names = bench.list("out/traces");
    assert!(names.iter().all(|name| !name.starts_with('.')), "{names:?}");
}

#[test]
fn a_history_with_code_in_it_is_refused() {
    let bench = TestProject::new();
    bench.expect(0, &["test", "lamp.toml", "--history", "h.sqlite", "--report", "run"]);
    let history = rusqlite::Connection::open(bench.path("h.sqlite")).unwrap();
    history.execute_batch("CREATE TRIGGER t AFTER INSERT ON run BEGIN DELETE FROM run; END;").unwrap();
    drop(history);
    bench.refused(&["history", "show", "--file", "h.sqlite"], &["R0168", "a trigger `t`"]);
    bench.refused(&["history", "add", "run", "--file", "h.sqlite"], &["R0168", "a trigger `t`"]);
}
