//! Pulses that the rig makes on GPIO lines, edge by edge: trains, square waves and the encoder simulator, counted by the
//! model's own fast counters, and by a counter of the kernel on the far side of a wire.

use devices::{Call, Lab, MAIN, PATIENCE, rig, wait_for};
use rustix::process::{Pid, Signal, kill_process};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

/// Output lines 8 and 9 are the model's inputs, and wired to lines 0 and 1, which a counter of the kernel follows.
const BOARD: &str = r#"
format = 1
[board]
kind = "real"
unresponsive-after = "5 s"
[chips]
main = { label = "rig-gpio" }
[channels]
I0 = { kind = "digital", line = 8, drives = true, pulses-up-to = "1 kHz" }
I1 = { kind = "digital", line = 9, drives = true, pulses-up-to = "1 kHz" }
[guard]
limit = "5 s"
[realtime]
late = "5 s"
"#;

const PLAN: &str = r#"
format = 1
title = "Pulses on real lines"
board = "board.toml"
program-text = """
PROGRAM MAIN
VAR
  simple : HSCSimple_M241;
  main : HSCMain_M241;
END_VAR
BLOCK
END_PROGRAM
"""
settings = { filter = "0 ms", expert = { EXPERT } }
signals = { A = "%IX0.0", value = "HSC0.value" ALSO }
steps = [
  { id = "enable", at = "start + 1 ms", write = { of = "ENABLE", value = true } },
  STEPS
]
ends = "pulses.done + 300 ms"
expect = [
  CLAIMS
]
"#;

/// A counter of pulses, or of an encoder's counts.
const SIMPLE: [&str; 3] = [
    "HSC0 = { kind = \"simple\", a = \"%IX0.0\", mode = \"modulo-loop\", modulo = 30000 }",
    "simple(HSC_REF_IN := HSC0);",
    "MAIN.simple.Enable",
];
const DUAL: [&str; 3] = [
    "HSC0 = { kind = \"main-dual\", a = \"%IX0.0\", b = \"%IX0.1\", inputs = \"quadrature-x4\", mode = \"free-large\", preset = 0 }",
    "main(HSC_REF_IN := HSC0);",
    "MAIN.main.F_Enable",
];

/// Runs a plan on a board in a folder of its own: the exit code, and what was said.
fn test(name: &str, board: &str, counter: [&str; 3], steps: &str, claims: &str) -> (i32, String) {
    let also = if counter == DUAL { ", B = \"%IX0.1\", error = \"HSC0.error\"" } else { "" };
    end(start(name, board, counter, also, steps, claims))
}

/// The same under way, with further signals.
fn start(name: &str, board: &str, counter: [&str; 3], also: &str, steps: &str, claims: &str) -> Child {
    let folder = PathBuf::from(format!("/tmp/pulses-{name}"));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    let plan = PLAN
        .replace("EXPERT", counter[0])
        .replace("BLOCK", counter[1])
        .replace("ENABLE", counter[2])
        .replace("ALSO", also)
        .replace("STEPS", steps)
        .replace("CLAIMS", claims);
    std::fs::write(folder.join("board.toml"), board).unwrap();
    std::fs::write(folder.join("plan.toml"), plan).unwrap();
    Command::new(rig())
        .args(["test", "plan.toml", "--report", "out"])
        .current_dir(&folder)
        .env("XDG_STATE_HOME", &folder)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

fn end(ran: Child) -> (i32, String) {
    let ran = ran.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&ran.stdout).into_owned() + &String::from_utf8_lossy(&ran.stderr);
    (ran.status.code().unwrap(), said)
}

/// The lab's counter on lines 0 and 1, which are wired to the outputs.
struct Wired {
    lab: Lab,
}

const COUNT: &str = "/sys/bus/counter/devices/counter0/count0";
const FOLLOWS: &str = "/run/lab/counter/count0/lines";

impl Wired {
    fn new(function: &str) -> Wired {
        let lab = Lab::enter();
        lab.wire(MAIN.line(8), MAIN.line(0));
        lab.wire(MAIN.line(9), MAIN.line(1));
        let write =
            |path: &str, text: &str| std::fs::write(path, text).unwrap_or_else(|e| panic!("{path}: {e}"));
        write(FOLLOWS, "none");
        write(&format!("{COUNT}/function"), function);
        write(&format!("{COUNT}/enable"), "1");
        write(&format!("{COUNT}/count"), "0");
        write(FOLLOWS, "rig-gpio 0 1");
        Wired { lab }
    }

    fn count(&self) -> u64 {
        std::fs::read_to_string(format!("{COUNT}/count")).unwrap().trim().parse().unwrap()
    }
}

impl Drop for Wired {
    fn drop(&mut self) {
        let _ = std::fs::write(FOLLOWS, "none");
    }
}

const TRAIN: &str = r#"
  { id = "pulses", at = "start + 300 ms", train = { signal = "A", frequency = "40 Hz", count = 30 } },
"#;
const COUNTED: &str = r#"
  { edges = { signal = "A", rising = 30, falling = 30, from = "pulses - 50 ms", until = "pulses.done + 200 ms" } },
  { value = { of = "value", is = 30 } },
"#;

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_train_is_emitted_and_counted_pulse_by_pulse() {
    let wired = Wired::new("increase");
    let (code, said) = test("train", BOARD, SIMPLE, TRAIN, COUNTED);
    assert_eq!((code, wired.count()), (0, 30), "{said}");
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_train_that_the_chip_is_late_with_loses_no_pulse() {
    let wired = Wired::new("increase");
    // In the middle of the train the chip hangs for as long as four pulses, three times.
    let (code, said) = std::thread::scope(|scope| {
        let ran = scope.spawn(|| test("late", BOARD, SIMPLE, TRAIN, COUNTED));
        wait_for("the train has begun", PATIENCE * 6, || wired.count() > 3 || ran.is_finished());
        wired.lab.stall(MAIN, Call::Set, Duration::from_millis(100), 3);
        ran.join().unwrap()
    });
    assert_eq!((code, wired.count()), (0, 30), "{said}");
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn an_encoder_turns_to_and_fro_and_a_counter_follows() {
    let wired = Wired::new("quadrature x4");
    let steps = r#"
  { id = "preset", at = "start + 100 ms", write = { of = "MAIN.main.F_Preset", value = true } },
  { id = "there", at = "start + 300 ms", encoder = { a = "A", b = "B", lines = 100, moves = [{ by = 60, speed = "100 Hz", ramp = "100 ms" }] } },
  { id = "pulses", at = "there.done + 300 ms", encoder = { a = "A", b = "B", lines = 100, from = 60, moves = [{ by = -20, speed = "100 Hz" }] } },
"#;
    let claims = r#"
  { value = { of = "value", is = 0, when = "there" } },
  { value = { of = "value", is = 60, when = "pulses" } },
  { value = { of = "value", is = 40 } },
  { stays = { signal = "error", is = 0, from = "there", until = "end" } },
"#;
    let (code, said) = test("encoder", BOARD, DUAL, steps, claims);
    assert_eq!((code, wired.count()), (0, 40), "{said}");
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_square_wave_has_its_periods() {
    let wired = Wired::new("increase");
    let steps = r#"
  { id = "pulses", at = "start + 300 ms", square = { signal = "A", frequency = "20 Hz", duty = "30 %", count = 20 } },
"#;
    let claims = r#"
  { edges = { signal = "A", rising = 20, from = "pulses - 50 ms", until = "end" } },
  { value = { of = "value", is = 20 } },
"#;
    let (code, said) = test("square", BOARD, SIMPLE, steps, claims);
    assert_eq!((code, wired.count()), (0, 20), "{said}");
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn pulses_beyond_the_promise_are_not_made() {
    let wired = Wired::new("increase");
    for (name, board, why) in [
        ("none", BOARD.replace(", pulses-up-to = \"1 kHz\"", ""), "the board promises no pulses"),
        (
            "slow",
            BOARD.replacen("pulses-up-to = \"1 kHz\"", "pulses-up-to = \"20 Hz\"", 1),
            "the step needs pulses of 40 Hz on `I0`, which makes them up to 20 Hz",
        ),
    ] {
        let (code, said) = test(name, &board, SIMPLE, TRAIN, COUNTED);
        assert!(code == 3 && said.contains("inconclusive") && said.contains(why), "{name}: {code} {said}");
    }
    assert_eq!(wired.count(), 0);
}

/// A count of faster pulses than the board promises to report is open, and stays so when the trace is judged again.
#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn what_is_counted_beyond_the_promise_is_open() {
    let lab = Lab::enter();
    lab.wire(MAIN.line(8), MAIN.line(2));
    let also = ", seen = \"seen\"";
    let steps = r#"
  { id = "pulses", at = "start + 300 ms", train = { signal = "A", frequency = "5 Hz", count = 4 } },
"#;
    let claims = r#"
  { edges = { signal = "seen", rising = 4, from = "pulses - 50 ms" } },
"#;
    for (promise, code) in [("2 Hz", 3), ("10 Hz", 0)] {
        let line =
            format!("seen = {{ kind = \"digital\", line = 2, counts-up-to = \"{promise}\" }}\n[guard]");
        let board = BOARD.replace("[guard]", &line);
        let ran = end(start("beyond", &board, SIMPLE, also, steps, claims));
        assert_eq!(ran.0, code, "{}", ran.1);
        assert_eq!(ran.1.contains("its board counts up to 2 Hz"), code == 3, "{}", ran.1);
        let trace =
            std::fs::read_dir("/tmp/pulses-beyond/out/traces").unwrap().next().unwrap().unwrap().path();
        let again = Command::new(rig())
            .args(["judge", "plan.toml"])
            .arg(&trace)
            .current_dir("/tmp/pulses-beyond")
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&again.stdout);
        assert_eq!(again.status.code(), Some(code), "{said}");
    }
}

/// Edges that the kernel's buffer loses while the rig stands still.
#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_gap_is_a_fault_of_the_counter_and_an_error_of_the_case() {
    let _lab = Lab::enter();
    let board = BOARD
        .replace("I0 = { kind = \"digital\", line = 8, drives = true", "I0 = { kind = \"digital\", line = 0")
        .replacen(", pulses-up-to = \"1 kHz\"", "", 1)
        .replace("\"5 s\"", "\"20 s\"")
        .replace("limit = \"20 s\"", "limit = \"10 s\"");
    let also = ", B = \"%IX0.1\", error = \"HSC0.error\", excess = \"HSC0.excess\"";
    let steps = r#"
  { id = "pulses", at = "start + 300 ms", pulse = { signal = "B", width = "3 s" } },
"#;
    let claims = r#"
  { value = { of = "error", is = 8 } },
  { value = { of = "excess", min = 1 } },
"#;
    let mut ran = start("gap", &board, SIMPLE, also, steps, claims);
    wait_for("the case is under way", PATIENCE * 6, || {
        MAIN.line(9).value() || ran.try_wait().unwrap().is_some()
    });
    let pid = Pid::from_child(&ran);
    kill_process(pid, Signal::STOP).unwrap();
    // More than the kernel keeps.
    for edge in 0..4_000 {
        MAIN.line(0).pull(edge % 2 == 0);
    }
    kill_process(pid, Signal::CONT).unwrap();
    let (code, said) = end(ran);
    assert!(code == 4 && said.contains("events of channel I0 were lost"), "{code} {said}");
    assert!(!said.contains('✗') && !said.contains("  ? "), "{said}");
}
