//! The far end goes away while a case runs: the controller that another process plays, the only other node of a bus.

use super::TEST;
use super::world::{fresh_buses, ip};
use crate::rig::Rig;
use devices::{Lab, MAIN};
use rustix::process::Signal;

/// The rig whose plan is judged: the controller's lamp comes in on line 13, its alarm line on line 15.
const NEAR: &str = r#"format = 1
title = "A controller that somebody plays"
[board]
kind = "real"
unresponsive-after = "5 s"
[chips]
main = { label = "rig-gpio" }
[subject]
kind = "external"
alarm = "running"
boot = "500 ms"
jitter = "80 ms"
[channels]
I0 = { kind = "digital", line = 0 }
Q0 = { kind = "digital", line = 13 }
running = { kind = "digital", line = 15 }
[guard]
limit = "5 s"
[realtime]
late = "10 s"
"#;

const FAR: &str = r#"format = 1
title = "The controller"
[board]
kind = "real"
unresponsive-after = "5 s"
[chips]
main = { label = "rig-gpio" }
[subject]
alarm = "running"
[channels]
I0 = { kind = "digital", line = 1 }
Q0 = { kind = "digital", line = 12, safe = false }
running = { kind = "digital", line = 14, safe = false }
[guard]
limit = "5 s"
[realtime]
late = "10 s"
"#;

const LAMP: &str = "PROGRAM MAIN VAR lamp AT %QX0.0 : BOOL; END_VAR lamp := TRUE; END_PROGRAM\n";

const STAYS: &str = r#"format = 1
title = "The lamp stays on"
program = "main.st"
signals = { lamp = "%QX0.0", go = "%IX0.0" }
steps = [{ id = "go", at = "start + 500 ms", set = { signal = "go", value = true } }]
ends = "start + 3 s"
expect = [{ stays = { signal = "lamp", is = true, from = "start + 200 ms", until = "end" } }]
[rows]
killed = {}
behind = {}
"#;

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_controller_that_is_killed_fails_its_case_and_the_next_does_not_begin() {
    let lab = Lab::enter();
    lab.wire(MAIN.line(0), MAIN.line(1));
    lab.wire(MAIN.line(12), MAIN.line(13));
    lab.wire(MAIN.line(14), MAIN.line(15));
    let files = [("far.toml", FAR.to_owned()), ("main.st", LAMP.to_owned())];
    let words = ["run", "--board", "far.toml", "--program", "main.st", "--booted"];
    let mut far = Rig::start("far", &files, &words);
    far.until("the controller runs", || MAIN.line(12).value() && MAIN.line(14).value());
    let files = [("board.toml", NEAR), ("plan.toml", STAYS), ("main.st", LAMP)];
    let mut near = Rig::start("near", &files.map(|(name, text)| (name, text.to_owned())), &TEST);
    near.until("the case is under way", || MAIN.line(0).value());
    far.signal(Signal::KILL);
    far.exit_code();
    near.until("the far rig's guard has made it safe", || !MAIN.line(12).value() && !MAIN.line(14).value());
    assert_eq!(near.exit_code(), Some(4), "{}", near.said());
    let [killed, behind] = &near.cases()[..] else { panic!("{}", near.said()) };
    assert_eq!(killed[0], "fail", "{killed:?}");
    let words = ["the controller did not reach the state in which the case begins", "it stayed BOOTING"];
    assert!(behind[0] == "error" && words.iter().all(|words| behind[1].contains(words)), "{behind:?}");
    assert!(words.iter().all(|words| near.said().contains(words)), "{}", near.said());
}

const BUS: &str = r#"format = 1
title = "A bus"
[board]
kind = "real"
unresponsive-after = "500 ms"
[buses]
machine = { kind = "can", interface = "rcan0", bitrate = 500_000 }
[guard]
limit = "5 s"
[realtime]
late = "10 s"
"#;

/// It claims nothing of the frames that it sends.
const BEATS: &str = r#"format = 1
title = "A heartbeat that nobody asks for"
program = "main.st"
steps = [{ id = "beats", at = "start + 100 ms", send = { bus = "machine", id = 0x701, data = "05", period = "50 ms", count = 40 } }]
ends = "start + 2500 ms"
expect = [{ state = { stays = "RUNNING", from = "start + 200 ms", until = "start + 2 s" } }]
[rows]
alone = {}
still = {}
sound = {}
"#;

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_bus_whose_other_node_is_gone_is_reported_and_its_case_is_an_error() {
    let _lab = Lab::enter();
    fresh_buses();
    let files = [("board.toml", BUS), ("plan.toml", BEATS), ("main.st", "PROGRAM MAIN\nEND_PROGRAM\n")];
    let mut rig = Rig::start("bus", &files.map(|(name, text)| (name, text.to_owned())), &TEST);
    let received = || {
        let count = std::fs::read_to_string("/sys/class/net/rcan1/statistics/rx_packets").unwrap();
        count.trim().parse::<u64>().unwrap()
    };
    let before = received();
    rig.until("frames on the bus", || received() > before + 2);
    ip("link set rcan1 down");
    // A case that begins while frames of the one before it wait could not tell them from its own.
    rig.until("two cases are over", || rig.said().contains("plan[still]"));
    ip("link set rcan1 up");
    assert_eq!(rig.exit_code(), Some(4), "{}", rig.said());
    let found = rig.cases();
    let words = [
        "a frame that was sent on bus machine was not on it by",
        "rcan0, counts errors of sending: nobody acknowledges",
    ];
    for [verdict, reason, _] in &found[..2] {
        assert!(verdict == "error" && words.iter().all(|words| reason.contains(words)), "{reason}");
    }
    assert!(["pass", "inconclusive"].contains(&found[2][0].as_str()), "{found:?}");
    assert!(
        rig.said().contains(words[0]) && rig.file("report/junit.xml").contains(words[0]),
        "{}",
        rig.said()
    );
    assert!(rig.file("report/record.json").contains("rcan0 is error-passive"), "{}", rig.said());
}
