//! `rig bench` and `rig doctor` on real lines: figures of a loop and of scans, and what stands in their way.

use devices::{Call, Lab, MAIN, PATIENCE, rig, wait_for};
use serde_json::Value as Json;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

/// Line 3 is wired to line 7; line 5 is a lamp that nobody named for a measurement.
const BOARD: &str = r#"
format = 1
[board]
kind = "real"
unresponsive-after = "3 s"
check = { out = "there", in = "back" }
[chips]
main = { label = "rig-gpio" }
[channels]
there = { kind = "digital", line = 3, drives = true }
back = { kind = "digital", line = 7 }
lamp = { kind = "digital", line = 5, drives = true }
[guard]
limit = "5 s"
"#;

/// A folder of its own, with the board file and the state of a user.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Folder {
        let folder = std::env::temp_dir().join(format!("bench-{name}"));
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(folder.join("board.toml"), BOARD).unwrap();
        Folder(folder)
    }

    fn path(&self) -> &Path {
        &self.0
    }

    /// Runs the command: its exit code, and what it printed on both ways out.
    fn run(&self, args: &[&str]) -> (i32, String, String) {
        let ran = Command::new(rig())
            .args(args)
            .current_dir(self.path())
            .env("XDG_STATE_HOME", self.path())
            .output()
            .unwrap();
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        (ran.status.code().unwrap(), text(&ran.stdout), text(&ran.stderr))
    }

    fn json(&self, args: &[&str]) -> Json {
        let (code, out, err) = self.run(&[args, &["--format", "json"]].concat());
        assert_eq!(code, 0, "rig {args:?}\n{out}{err}");
        serde_json::from_str(&out).unwrap()
    }
}

fn number(of: &Json, name: &str) -> f64 {
    of[name].as_f64().unwrap_or_else(|| panic!("{name} in {of}"))
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_loop_has_figures_that_agree_with_each_other() {
    let lab = Lab::enter();
    lab.wire(MAIN.line(3), MAIN.line(7));
    let folder = Folder::new("loop");
    let found = folder.json(&["bench", "loopback", "--board", "board.toml", "--count", "300"]);
    assert_eq!((&found["turns"], &found["loop"]), (&300.into(), &serde_json::json!(["there", "back"])));
    let [call, seen, asked] =
        ["call_to_stamp", "stamp_to_seen", "asked_to_call"].map(|name| found[name].clone());
    assert!([&call, &seen, &asked].iter().all(|figure| figure["count"] == 300), "{found}");
    // The edge is stamped before the rig can know of it, and the parts are no more than the turn, which no stamp
    // went into.
    let parts = number(&asked, "mean_us") + number(&call, "mean_us") + number(&seen, "mean_us");
    let turn = number(&found, "turn_us");
    assert!(parts > 0.0 && parts <= turn * 1.01, "{parts} us of {turn} us");
    println!(
        "\nfigure: a turn takes {turn:.1} us, of which call to stamp {:.1} us",
        number(&call, "mean_us")
    );
    println!("figure: call to stamp p99 {} us, max {} us", call["p99_us"], call["max_us"]);
    // Too few to be kept; nothing else moved.
    assert_eq!(found["kept"], Json::Null);
    assert!(!MAIN.line(5).value() && !MAIN.line(3).value());
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_wire_that_inverts_is_a_loop_and_a_cut_one_is_named() {
    let lab = Lab::enter();
    lab.wire_inverted(MAIN.line(3), MAIN.line(7));
    let folder = Folder::new("cut");
    let (code, out, err) = folder.run(&["bench", "loopback", "--board", "board.toml", "--count", "50"]);
    assert_eq!(code, 0, "{out}{err}");
    assert!(out.contains("50 edges from `there` to `back`") && out.contains("by counting alone, 1/(2f): "));
    assert!(err.contains("not kept: less than 10000"), "{err}");
    lab.cut();
    let (code, out, err) = folder.run(&["bench", "loopback", "--board", "board.toml", "--count", "10"]);
    assert_eq!((code, out.as_str()), (4, ""), "{err}");
    assert!(err.contains("error[R0255]: `back` did not follow edge 1 of `there`, to 1"), "{err}");
    assert!(err.contains("see that the wire is there"), "{err}");
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn scans_have_phases_and_a_slow_device_is_none_of_theirs() {
    let lab = Lab::enter();
    lab.wire(MAIN.line(3), MAIN.line(7));
    let folder = Folder::new("scan");
    let program =
        "PROGRAM MAIN\nVAR n, i : DINT; END_VAR\nFOR i := 1 TO 100 DO n := n + i; END_FOR;\nEND_PROGRAM\n";
    std::fs::write(folder.path().join("loop.st"), program).unwrap();
    let args = ["bench", "scan", "--board", "board.toml", "--program", "loop.st", "--interval", "5 ms"];
    let found = folder.json(&[&args[..], &["--count", "200"]].concat());
    assert_eq!(&found["scans"], &200, "{found}");
    for phase in ["late_by", "inputs", "program", "outputs", "whole", "device"] {
        assert!(number(&found[phase], "count") > 0.0, "{phase} in {found}");
    }
    assert!(number(&found["program"], "p50_us") > number(&found["inputs"], "min_us"), "{found}");
    println!();
    for phase in ["late_by", "inputs", "program", "outputs", "device"] {
        println!("figure: {phase}: p50 {} us, p99 {} us", found[phase]["p50_us"], found[phase]["p99_us"]);
    }
    // Every call that drives takes 20 ms: it is the device that is slow, and no phase of the scan.
    lab.stall(MAIN, Call::Set, Duration::from_millis(20), 20);
    let slow = folder.json(&[&args[..], &["--count", "100"]].concat());
    assert!(number(&slow["device"], "max_us") >= 20_000.0, "{slow}");
    assert!(number(&slow["outputs"], "p50_us") < 5_000.0, "{slow}");
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn what_cannot_be_measured_on_a_board_is_refused() {
    let lab = Lab::enter();
    lab.wire(MAIN.line(3), MAIN.line(7));
    let folder = Folder::new("refused");
    let refused = |args: &[&str], words: &str| {
        let (code, out, err) = folder.run(&[&["bench"], args, &["--board", "board.toml"]].concat());
        assert!(code == 2 && out.is_empty() && err.contains(words), "{args:?}: {code} {out}{err}");
    };
    refused(&["scan", "--drive", "back"], "error[R0254]: --drive back: the board has no such output");
    refused(&["loopback", "--out", "there", "--in", "bck"], "error[R0254]: --in bck");
    refused(&["loopback", "--count", "0"], "error[R0250]");
    std::fs::write(folder.path().join("board.toml"), BOARD.replace("check =", "# check =")).unwrap();
    refused(&["loopback"], "error[R0254]: `board.toml` names no loop");
    std::fs::write(folder.path().join("board.toml"), BOARD.replace("rig-gpio", "nowhere")).unwrap();
    refused(&["loopback"], "error[B0170]");
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn the_doctor_finds_the_devices_of_this_machine() {
    let _lab = Lab::enter();
    let folder = Folder::new("doctor");
    let (code, out, err) = folder.run(&["doctor"]);
    // A virtual machine: fit, with drawbacks.
    assert_eq!((code, err.as_str()), (3, ""), "{out}");
    for line in [
        "  good  kind              PREEMPT_RT, ",
        "  good  timer resolution  1 ns\n",
        "  good  priority          SCHED_FIFO up to 99\n",
        "  good  GPIO              gpiochip0, gpiochip1\n",
        "  good  SPI               spidev0.0, ",
        "  good  counter           counter0\n",
        "  good  PWM               pwmchip0\n",
        "  good  ADC               iio:device0\n",
        "  good  watchdog          i6300ESB timer",
        "  good  guard             it starts, with all that it asks for\n",
        "CAN               can0, 500000 bit/s, up; can1, ",
        "wake-up latency   not measured\n        $ rig bench latency",
    ] {
        assert!(out.contains(line), "`{line}` is missing in\n{out}");
    }
    let (_, out, _) = folder.run(&["bench", "latency", "--count", "10000", "--interval", "100 us"]);
    println!("\nfigure: {}", out.lines().nth(1).unwrap_or_default());
    assert!(folder.run(&["doctor"]).1.contains("  good  wake-up latency   p99 "));
}

/// A plan on the board, of the lamp: what the lab is late by lies far from its limits.
const PLAN: &str = r#"
format = 1
title = "The lamp lights"
board = "board.toml"
program-text = "PROGRAM MAIN VAR lamp AT %QX0.4 : BOOL; t : TON; END_VAR t(IN := TRUE, PT := T#800ms); lamp := t.Q; END_PROGRAM"
signals = { lamp = "%QX0.4" }
expect = [{ rises = { signal = "lamp", from = "start", within = "0 s .. 2 s" } }]
ends = "start + 2 s"
"#;

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_run_checks_its_instrument_first_and_records_what_is_known_of_it() {
    let lab = Lab::enter();
    lab.wire(MAIN.line(3), MAIN.line(7));
    let folder = Folder::new("checked");
    let board = BOARD.replace("lamp =", "Q4 =").replace("line = 5, drives = true", "line = 5");
    std::fs::write(folder.path().join("board.toml"), board + "[realtime]\nlate = \"2 s\"\n").unwrap();
    std::fs::write(folder.path().join("lamp.toml"), PLAN).unwrap();
    let (code, out, err) = folder.run(&["test", "lamp.toml", "--report", "out"]);
    assert_eq!(code, 0, "{out}{err}");
    let text = std::fs::read_to_string(folder.path().join("out/record.json")).unwrap();
    let record: Json = serde_json::from_str(&text).unwrap();
    let facts = record["provenance"]["environment"].as_array().unwrap().clone();
    let fact = |name: &str| {
        let found = facts.iter().find(|fact| fact[0] == name).unwrap_or_else(|| panic!("{name}: {facts:?}"));
        found[1].as_str().unwrap().to_owned()
    };
    assert!(fact("Instrument checked").starts_with("40 edges came back, stamped within "), "{facts:?}");
    assert_eq!(fact("Edges stamped within"), "not measured");
    // Without the wire nothing is judged.
    lab.cut();
    let (code, out, err) = folder.run(&["test", "lamp.toml"]);
    assert_eq!((code, out.as_str()), (4, ""), "{err}");
    assert!(err.contains("error[R0255]: `back` did not follow edge 1 of `there`"), "{err}");
    assert!(!MAIN.line(3).value() && !MAIN.line(5).value());
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn what_was_measured_widens_what_is_known_and_is_left_out_on_another_kernel() {
    let lab = Lab::enter();
    lab.wire(MAIN.line(3), MAIN.line(7));
    let folder = Folder::new("widened");
    let looped = folder.json(&["bench", "loopback", "--board", "board.toml", "--count", "20"]);
    let board = "format = 1\nboard = { kind = \"real\", unresponsive-after = \"3 s\" }\n\
                 chips = { main = { label = \"rig-gpio\" } }\n\
                 channels = { Q4 = { kind = \"digital\", line = 3, readback = 7 } }\n\
                 realtime = { late = \"2 s\" }\nguard = { limit = \"5 s\" }\n";
    std::fs::write(folder.path().join("board.toml"), board).unwrap();
    std::fs::write(folder.path().join("lamp.toml"), PLAN).unwrap();
    // As if edges were stamped up to 30 s late on this machine, which no lab can wait for.
    let doctor: Json = serde_json::from_str(&folder.run(&["doctor", "--format", "json"]).1).unwrap();
    let machine: Vec<(&String, &Json)> = doctor["machine"].as_object().unwrap().iter().collect();
    let late = 30_000_000_000_u64;
    let kept = serde_json::json!({
        "format": 1,
        "kind": "loopback",
        "measured": "2026-11-22T09:00:00Z",
        "machine": machine,
        "board_sha256": looped["devices"],
        "settings": [],
        "figures": [{
            "name": "call to stamp", "count": 10_000, "min_ns": 1, "mean_ns": 1, "p50_ns": 1, "p99_ns": 1,
            "p99_99_ns": late, "max_ns": late,
        }],
    });
    let devices = looped["devices"].as_str().unwrap();
    let file = folder.path().join(format!("rig/loopback-{}.json", &devices[..16]));
    std::fs::create_dir_all(file.parent().unwrap()).unwrap();
    std::fs::write(&file, kept.to_string()).unwrap();
    let (code, out, err) = folder.run(&["test", "lamp.toml"]);
    assert_eq!(code, 3, "{out}{err}");
    // Of another kernel they are not used, and that is said.
    std::fs::write(&file, kept.to_string().replace("Linux ", "Minix ")).unwrap();
    let (code, out, err) = folder.run(&["test", "lamp.toml"]);
    assert_eq!(code, 0, "{out}{err}");
    let words = "warning[R0252]: the figures of `rig bench loopback` are not used: the kernel was `Minix ";
    assert!(err.contains(words), "{err}");
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_measurement_that_is_killed_leaves_its_output_safe() {
    let lab = Lab::enter();
    lab.wire(MAIN.line(3), MAIN.line(7));
    let folder = Folder::new("killed");
    let board = BOARD.replace("line = 3, drives = true", "line = 3, drives = true, safe = true");
    std::fs::write(folder.path().join("board.toml"), board.replace("limit = \"5 s\"", "limit = \"1 s\""))
        .unwrap();
    // The loop is stopped at any level: one in two would be the safe one by chance.
    for _ in 0..2 {
        let mut child = Command::new(rig())
            .args(["bench", "loopback", "--board", "board.toml", "--count", "10000000"])
            .current_dir(folder.path())
            .stdout(std::process::Stdio::null())
            .stderr(std::process::Stdio::null())
            .spawn()
            .unwrap();
        wait_for("the output begins safe", PATIENCE, || MAIN.line(3).value());
        wait_for("the loop drives itself", PATIENCE, || !MAIN.line(3).value());
        child.kill().unwrap();
        child.wait().unwrap();
        wait_for("the output is safe", PATIENCE, || MAIN.line(3).value());
        // Whoever holds it safe lets go in the end.
        drop(Lab::enter());
        lab.wire(MAIN.line(3), MAIN.line(7));
    }
}

/// Faster and faster, until an edge is missing or none can be made faster; what was measured is held against what the
/// board file promises.
#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn pulses_are_counted_up_to_a_frequency_that_is_measured() {
    let lab = Lab::enter();
    lab.wire(MAIN.line(3), MAIN.line(7));
    let folder = Folder::new("counts");
    let line = "there = { kind = \"digital\", line = 3, drives = true";
    let board = BOARD
        .replace(line, &format!("{line}, pulses-up-to = \"10 kHz\""))
        .replace("line = 7", "line = 7, counts-up-to = \"10 MHz\"");
    std::fs::write(folder.path().join("board.toml"), board).unwrap();
    let (code, out, err) =
        folder.run(&["bench", "counts", "board.toml", "--repeats", "1", "--format", "json"]);
    // Nothing here counts ten million pulses a second.
    assert!(code == 3 && err.contains("R0316") && err.contains("10000000 Hz"), "{code} {out}{err}");
    let found: Json = serde_json::from_str(&out).unwrap();
    let trains = found["trains"].as_array().unwrap();
    let is_counted = |train: &Json| train["seen"] == train["made"] && train["lost"] == 0;
    let (last, before) = trains.split_last().unwrap();
    assert!(before.iter().all(is_counted), "{found}");
    let is_limit = !is_counted(last);
    assert_eq!(found["is_limit"], is_limit, "{found}");
    let fastest = if is_limit { before.last() } else { Some(last) };
    assert_eq!(found["counted_hz"] == 0, fastest.is_none(), "{found}");
    let (_, out, err) = folder.run(&["doctor", "board.toml"]);
    assert!(out.contains("counting") && out.contains("promises 10000000 Hz of `back`"), "{out}{err}");
    assert!(!MAIN.line(3).value());
    println!("figure: counted up to {} Hz, made up to {} Hz", found["counted_hz"], found["made_hz"]);
}
