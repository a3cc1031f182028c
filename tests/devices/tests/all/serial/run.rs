//! Serial lines under the command: what is reported to a user when one goes away while a case runs, and what becomes of the next.

use devices::{Lab, MAIN, SERIAL_A, SERIAL_B};

use crate::rig::Rig;

const BOARD: &str = r#"format = 1
title = "A lamp, and a line"
[board]
kind = "real"
reconnect = true
[chips]
main = { label = "rig-gpio" }
[channels]
Q0 = { kind = "digital", line = 8, safe = false }
[buses]
modbus = { kind = "serial", path = "/dev/rig/serial-a", rs485 = { delay-after = "1 ms" } }
[guard]
limit = "2 s"
[realtime]
late = "10 s"
"#;

const PLAN: &str = r#"format = 1
title = "The lamp is on"
program = "main.st"
signals = { lamp = "%QX0.0" }
ends = "start + $lasts"
expect = [{ stays = { signal = "lamp", is = true, from = "start + 300 ms", until = "start + 600 ms" } }]
[rows]
first = { lasts = "60 s" }
second = { lasts = "1 s" }
"#;

const PROGRAM: &str = "PROGRAM MAIN VAR lamp AT %QX0.0 : BOOL; END_VAR lamp := TRUE; END_PROGRAM\n";

const TEST: [&str; 6] = ["test", "--board", "board.toml", "--report", "report", "plan.toml"];

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_line_that_goes_away_ends_its_case_and_the_next_has_it_again() {
    let _lab = Lab::enter();
    let files = [("board.toml", BOARD), ("plan.toml", PLAN), ("main.st", PROGRAM)];
    let files = files.map(|(name, text)| (name, text.to_owned()));
    let mut rig = Rig::start("serial", &files, &TEST);
    rig.until("the lamp is on", || MAIN.line(8).value());
    let unplugged = SERIAL_A.unplug();
    rig.until("the output is safe", || !MAIN.line(8).value());
    drop(unplugged);
    assert_eq!(rig.exit_code(), Some(4), "{}", rig.said());
    let record: serde_json::Value = serde_json::from_str(&rig.file("report/record.json")).unwrap();
    let of = |case: usize, key: &str| record["cases"][case][key].as_str().unwrap_or_default().to_owned();
    assert_eq!((of(0, "verdict"), of(0, "ended")), ("error".into(), "a device was lost".into()));
    let words = ["bus modbus was lost at", "its device, /dev/rig/serial-a, is gone"];
    for said in [of(0, "reason"), rig.said(), rig.file("report/junit.xml")] {
        assert!(words.iter().all(|words| said.contains(words)), "{said}");
    }
    // On a machine that stands still now and then it need not be sure of it.
    assert!(["pass", "inconclusive"].contains(&of(1, "verdict").as_str()), "{}", rig.said());
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_port_that_is_held_is_reported_before_anything_is_driven() {
    let _lab = Lab::enter();
    let held = std::fs::File::open(SERIAL_B.path()).unwrap();
    let board = BOARD.replace("serial-a", "serial-b");
    let files = [("board.toml", &*board), ("plan.toml", PLAN), ("main.st", PROGRAM)];
    let files = files.map(|(name, text)| (name, text.to_owned()));
    let mut rig = Rig::start("held", &files, &TEST);
    assert_eq!(rig.exit_code(), Some(2), "{}", rig.said());
    let words = ["error[B0145]", "/dev/rig/serial-b is held by `all ", "modbus = "];
    assert!(words.iter().all(|words| rig.said().contains(words)), "{}", rig.said());
    drop(held);
}
