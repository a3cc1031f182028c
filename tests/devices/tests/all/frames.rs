//! Plans that speak of frames, over the lab's CAN controllers: the same claims as over a simulated bus.

use std::fs;
use std::path::PathBuf;
use std::process::Command;

use devices::rig;

/// Two controllers on one wire.
const BOARD: &str = r#"format = 1
[board]
kind = "real"
unresponsive-after = "5 s"
[buses]
machine = { kind = "can", interface = "can0", bitrate = 500_000 }
drive = { kind = "can", interface = "can1", bitrate = 500_000 }
[realtime]
late = "10 s"
[guard]
limit = "5 s"
"#;

const PROGRAM: &str = "PROGRAM MAIN\nEND_PROGRAM\n";

const DBC: &str = "VERSION \"\"\n\nBU_: PLC DRIVE\n\nBO_ 256 Engine: 8 DRIVE\n \
                   SG_ Speed : 0|16@1+ (0.25,0) [0|16383.75] \"rpm\" PLC\n";

/// A heartbeat with bounds for a machine that stands still now and then, a value there, an answer back.
const PLAN: &str = r#"format = 1
title = "A heartbeat, a value and an answer over real controllers"
program = "main.st"
steps = [
  { id = "beats", at = "start + 200 ms", send = { bus = "drive", id = 0x701, data = "05", period = "50 ms", count = 20 } },
  { id = "set", at = "start + 400 ms", send = { bus = "drive", dbc = "machine.dbc", message = "Engine", values = { Speed = "1500 rpm" } } },
  { id = "seen", when = { signal = "engine", edge = "changes", from = "start", within = "30 s" }, send = { bus = "machine", id = 0x181, data = "AA" } },
  { id = "answered", when = { signal = "answer", edge = "changes", from = "start", within = "30 s" } },
]
ends = "answered + 5 s"
expect = [
  { frames = { frame = "beat", count = "COUNT" } },
  { frames = { frame = "own", count = 20 } },
  { value = { of = "speed", is = "1500 rpm" } },
  { order = { edges = ["engine changes", "answer changes"], from = "start" } },
]
[frames]
beat = { bus = "machine", id = 0x701, data = "05", from = "others" }
own = { bus = "drive", id = 0x701, from = "own" }
engine = { bus = "machine", dbc = "machine.dbc", message = "Engine" }
speed = { bus = "machine", dbc = "machine.dbc", message = "Engine", signal = "Speed" }
answer = { bus = "drive", id = 0x181, data = "AA" }
"#;

/// The exit code of `rig test`, and what it says. The trace alone says the same.
fn test(name: &str, board: &str, count: &str) -> (Option<i32>, String) {
    let folder = PathBuf::from(format!("/tmp/frames-{name}"));
    fs::create_dir_all(&folder).unwrap();
    for (file, text) in [
        ("board.toml", board.to_owned()),
        ("main.st", PROGRAM.to_owned()),
        ("machine.dbc", DBC.to_owned()),
        ("plan.toml", PLAN.replace("COUNT", count)),
    ] {
        fs::write(folder.join(file), text).unwrap();
    }
    let run = |words: &[&str]| {
        let mut command = Command::new(rig());
        let done = command.args(words).current_dir(&folder).env("XDG_STATE_HOME", &folder).output().unwrap();
        let said =
            [done.stdout, done.stderr].map(|text| String::from_utf8_lossy(&text).into_owned()).concat();
        (done.status.code(), said)
    };
    let tested = run(&["test", "--board", "board.toml", "--report", "report", "plan.toml"]);
    let judged = run(&["judge", "plan.toml", "report/traces/plan.trace"]);
    assert!(
        tested.0 == judged.0 || !folder.join("report/traces/plan.trace").exists(),
        "{tested:?}\n{judged:?}"
    );
    tested
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_plan_passes_over_real_controllers() {
    let (code, said) = test("passes", BOARD, "20");
    assert_eq!(code, Some(0), "{said}");
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_wrong_claim_fails_over_real_controllers() {
    let (code, said) = test("fails", BOARD, "21");
    assert!(code == Some(1) && said.contains("there were 20 frames"), "{code:?} {said}");
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_board_without_the_bus_says_so() {
    let other = BOARD.replace("machine =", "other =");
    let (_, said) = test("lacks", &other, "20");
    assert!(said.contains("the board has no bus `machine`"), "{said}");
}
