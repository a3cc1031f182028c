//! `rig test` on a terminal, in a log, and for a program that reads its events.

use crate::project_folder::{LAMP_ST, TestProject, drain, run};
use nix::pty::{Winsize, openpty};
use serde_json::Value as Json;
use std::fs::File;
use std::io::Write;
use std::process::{Command, Stdio};

/// Three cases: one passes, one fails, one does not apply.
fn three() -> TestProject {
    let bench = TestProject::new();
    bench.write_lamp("slow.toml", "500 ms .. 550 ms", "490 ms .. 510 ms");
    bench.write_lamp("m251.toml", "program =", "profiles = [\"m251-2024\"]\nprogram =");
    bench.write(
        "board.toml",
        "format = 1\n[subject]\nprofile = \"m241-2019\"\n[board]\nkind = \"simulated\"\n",
    );
    bench
}

const ALL: [&str; 6] = ["test", "lamp.toml", "slow.toml", "m251.toml", "--board", "board.toml"];

fn with<'a>(more: &[&'a str]) -> Vec<&'a str> {
    ALL.iter().copied().chain(more.iter().copied()).collect()
}

/// Runs a command on a terminal of its own and returns all that it wrote there.
fn on_terminal(command: Command) -> (Option<i32>, String) {
    talk(command, &[])
}

/// The same with somebody there who types the next of the lines whenever the command waits after `> `.
pub fn talk(mut command: Command, typed: &[&str]) -> (Option<i32>, String) {
    let size = Winsize { ws_row: 24, ws_col: 80, ws_xpixel: 0, ws_ypixel: 0 };
    let pty = openpty(&size, None).unwrap();
    let side = || Stdio::from(pty.slave.try_clone().unwrap());
    let mut child = command.stdin(side()).stdout(side()).stderr(side()).spawn().unwrap();
    // The terminal ends for the reader when nobody holds its other side any more.
    drop(command);
    drop(pty.slave);
    let mut terminal = File::from(pty.master);
    let (mut all, mut some, mut typed) = (Vec::new(), [0; 4096], typed.iter());
    while let Ok(n @ 1..) = std::io::Read::read(&mut terminal, &mut some) {
        all.extend_from_slice(&some[..n]);
        if all.ends_with(b"> ")
            && let Some(line) = typed.next()
        {
            terminal.write_all(format!("{line}\n").as_bytes()).unwrap();
        }
    }
    (child.wait().unwrap().code(), String::from_utf8_lossy(&all).into_owned())
}

/// The command as somebody at a terminal starts it.
pub fn terminal(bench: &TestProject, args: &[&str]) -> Command {
    let mut command = bench.command(args);
    command.env("TERM", "xterm-256color").env_remove("CI").env_remove("CLICOLOR");
    command
}

#[test]
fn each_level_has_its_lines() {
    let bench = three();
    for (level, lines) in [
        ("none", &[][..]),
        ("fail", &["FAIL"]),
        ("slow", &["FAIL"]),
        ("pass", &["PASS", "FAIL"]),
        ("all", &["PASS", "FAIL", "N/A"]),
    ] {
        let out = bench.expect(1, &with(&["--status-level", level])).out;
        for word in ["PASS", "FAIL", "N/A"] {
            assert_eq!(out.contains(&format!("{word} [")), lines.contains(&word), "{level}: {out}");
        }
        assert!(out.contains("Summary: 1 passed, 1 failed, 0 inconclusive, 1 not applicable"), "{out}");
    }
}

#[test]
fn lines_are_numbered_and_failures_come_again_at_the_end() {
    let out = three().expect(1, &with(&[])).out;
    assert!(out.contains("PASS [   3.500 s] (1/3) lamp\n"), "{out}");
    let summary = out.find("Summary:").unwrap();
    let again = out[summary..].lines().nth(1).unwrap();
    assert!(again.contains("FAIL [   3.500 s] (2/3) slow: ") && again.contains("too late"), "{again}");
}

#[test]
fn a_run_that_ends_early_says_how_much_of_it_ran() {
    let out = three().expect(1, &with(&["--fail-fast", "--jobs", "1"])).out;
    assert!(out.contains("1 skipped; 2 of 3 planned cases ran"), "{out}");
}

#[test]
fn colour_is_the_users() {
    let bench = three();
    let coloured = |command: Command| run(command).out.contains('\u{1b}');
    let set = |name: &str, value: &str, args: &[&str]| {
        let mut command = bench.command(&with(args));
        command.env(name, value);
        command
    };
    assert!(!coloured(bench.command(&with(&[]))));
    assert!(coloured(bench.command(&with(&["--color", "always"]))));
    assert!(coloured(set("CLICOLOR_FORCE", "1", &[])));
    assert!(!coloured(set("CLICOLOR_FORCE", "1", &["--color", "never"])));
    assert!(coloured(set("NO_COLOR", "1", &["--color", "always"])));
}

#[test]
fn a_terminal_has_a_bar_and_colour_and_no_line_for_what_passes() {
    let bench = three();
    let (code, screen) = on_terminal(terminal(&bench, &with(&[])));
    assert_eq!(code, Some(1), "{screen}");
    assert!(screen.contains("/3") && screen.contains("[---"), "{screen:?}");
    assert!(screen.contains("FAIL") && screen.contains("\u{1b}[31;1m"), "{screen:?}");
    assert!(!screen.contains("PASS [") && !screen.contains("N/A"), "{screen:?}");
    // The bar is gone at the end: the last thing is text.
    let last = screen.trim_end().lines().last().unwrap();
    assert!(last.contains("too late"), "{last:?}");
}

#[test]
fn ci_and_the_user_do_without_the_bar() {
    let bench = three();
    let mut ci = terminal(&bench, &with(&[]));
    ci.env("CI", "true");
    let none = terminal(&bench, &with(&["--progress", "none"]));
    for command in [ci, none] {
        let (code, screen) = on_terminal(command);
        assert_eq!(code, Some(1), "{screen}");
        assert!(!screen.contains("[---") && screen.contains("PASS"), "{screen:?}");
    }
    let mut plain = terminal(&bench, &with(&["--progress", "none"]));
    plain.env("NO_COLOR", "1");
    assert!(!on_terminal(plain).1.contains('\u{1b}'));
}

#[test]
fn a_case_that_takes_long_is_said_to_be_slow() {
    let bench = TestProject::new();
    bench.write("fast.st", &LAMP_ST.replace("delay(", "FOR i := 0 TO 20 DO n := n + 1; END_FOR delay("));
    bench.write("fast.st", &bench.read("fast.st").replace("END_VAR", "i, n : INT; END_VAR"));
    bench.write_lamp("long.toml", "program = \"lamp.st\"", "program = \"fast.st\"\nends = \"start + 5 min\"");
    let ran = bench.expect(0, &["test", "long.toml", "--slow", "1 us"]);
    // What depends on the host is not on standard output.
    assert!(
        !ran.out.contains("SLOW") && ran.err.contains("SLOW [") && ran.err.contains("] long"),
        "{}",
        ran.err
    );
    bench.refused(&["test", "long.toml", "--slow", "0 s"], &["--slow"]);
}

fn events(out: &str) -> Vec<Json> {
    out.lines().map(|line| serde_json::from_str(line).unwrap_or_else(|_| panic!("{line}"))).collect()
}

/// Whether an event has all that the record has, which leaves out what says nothing.
fn covers(reported: &Json, kept: &Json) -> bool {
    match (reported, kept) {
        (_, Json::Null) => true,
        (Json::Object(reported), Json::Object(kept)) => {
            kept.iter().all(|(key, value)| reported.get(key).is_some_and(|reported| covers(reported, value)))
        }
        (Json::Array(reported), Json::Array(kept)) => {
            reported.len() == kept.len()
                && reported.iter().zip(kept).all(|(reported, kept)| covers(reported, kept))
        }
        (reported, kept) => reported == kept,
    }
}

#[test]
fn events_report_the_whole_run() {
    let bench = three();
    let ran = bench.expect(1, &with(&["--format", "json", "--report", "out", "--jobs", "2"]));
    assert_eq!(ran.err, "");
    let events = events(&ran.out);
    let names: Vec<&str> = events.iter().map(|event| event["event"].as_str().unwrap()).collect();
    assert_eq!((names[0], names[names.len() - 1]), ("run-started", "run-finished"));
    assert_eq!((events[0]["format"].as_u64(), events[0]["planned"].as_u64()), (Some(1), Some(3)));
    // Finished in the order of the cases, each after its beginning.
    let at = |name: &str, place: u64| {
        events.iter().position(|event| event["event"] == name && event["place"] == place).unwrap()
    };
    for place in 1..=3 {
        assert!(at("case-started", place) < at("case-finished", place));
    }
    assert!(
        at("case-finished", 1) < at("case-finished", 2) && at("case-finished", 2) < at("case-finished", 3)
    );
    // The same facts as in the record.
    let record = bench.json("out/record.json");
    for place in 0..3 {
        let (reported, kept) = (&events[at("case-finished", place + 1)], &record["cases"][place as usize]);
        for member in ["verdict", "reason", "claims", "measurements", "trace_sha256", "trace_file", "host_ms"]
        {
            assert!(covers(&reported[member], &kept[member]), "{member}: {reported} {kept}");
        }
    }
    let last = &events[events.len() - 1];
    assert_eq!((last["verdict"].as_str(), last["totals"]["failed"].as_u64()), (Some("fail"), Some(1)));
    assert!(bench.path(last["page"].as_str().unwrap()).is_file());
}

#[test]
fn the_last_event_has_the_statistics_of_what_was_repeated() {
    let bench = TestProject::new();
    let ran = bench.expect(0, &["test", "lamp.toml", "--repeat", "3", "--format", "json"]);
    let events = events(&ran.out);
    let repeated = &events[events.len() - 1]["repeated"][0];
    assert_eq!((repeated["case"].as_str(), repeated["turns"].as_u64()), (Some("lamp"), Some(3)));
    // In virtual time each turn is the same.
    let margin = &repeated["figures"][0]["statistics"];
    assert_eq!((margin["count"].as_u64(), margin["spread"].as_f64()), (Some(3), Some(0.0)), "{margin}");
}

#[test]
fn a_list_of_events() {
    let listed = events(&three().expect(0, &with(&["--list", "--format", "json"])).out);
    assert_eq!(listed.len(), 3);
    assert!(listed.iter().all(|event| event["event"] == "case-listed" && event["format"] == 1));
    assert_eq!(listed[1]["case"], "slow");
}

#[test]
fn a_report_keeps_the_traces_that_are_asked_for() {
    let bench = three();
    for (which, traces) in
        [("all", &["lamp.trace", "slow.trace"][..]), ("fail", &["slow.trace"]), ("none", &[])]
    {
        let folder = format!("out-{which}");
        bench.expect(1, &with(&["--report", &folder, "--trace-on", which]));
        let mut kept = bench.list(&format!("{folder}/traces"));
        kept.retain(|name| name.ends_with(".trace"));
        assert_eq!(kept, traces);
        let record = bench.json(&format!("{folder}/record.json"));
        let named = record["cases"].as_array().unwrap().iter().filter(|case| case["trace_file"].is_string());
        assert_eq!(named.count(), traces.len());
    }
    bench.refused(&["test", "lamp.toml", "--trace-on", "fail"], &["--report"]);
}

#[test]
fn a_closed_pipe_ends_nothing_badly() {
    let bench = three();
    let mut child = bench.command(&with(&["--format", "json"])).stdout(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    // Whether all cases had ended by then is a matter of moments.
    assert!(matches!(child.wait().unwrap().code(), Some(1 | 141)));
    let quiet = bench.command(&with(&[])).stdout(Stdio::null()).stderr(Stdio::piped()).spawn();
    let mut quiet = quiet.unwrap();
    let err = drain(quiet.stderr.take().unwrap());
    assert_eq!(quiet.wait().unwrap().code(), Some(1));
    assert_eq!(err.join().unwrap(), "");
}
