//! A controller that is kept running on real lines, and clients of its control socket.

use crate::rig::{Rig, guards};
use devices::{Lab, MAIN};
use rustix::process::Signal;
use std::process::{Command, Stdio};

const SOCKET: &str = "/tmp/trouble/live/rig.sock";

const BOARD: &str = r#"
format = 1
[board]
kind = "real"
unresponsive-after = "5 s"
[control]
socket = "/tmp/trouble/live/rig.sock"
on-disconnect = "release"
[chips]
main = { label = "rig-gpio" }
[channels]
Q0 = { kind = "digital", line = 8 }
[guard]
limit = "5 s"
[realtime]
late = "5 s"
"#;

const PROGRAM: &str = "
PROGRAM MAIN
VAR
  wanted : BOOL;
  lamp AT %QX0.0 : BOOL;
END_VAR
lamp := wanted;
END_PROGRAM
";

fn client(words: &[&str]) -> Command {
    let mut client = Command::new(devices::rig());
    client.args(["ctl", "--socket", SOCKET, "--wait", "60s"]).args(words);
    client.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    client
}

/// What a client that ends well prints.
fn said(words: &[&str]) -> String {
    let ended = client(words).output().unwrap();
    assert!(ended.status.success(), "{words:?}: {}", String::from_utf8_lossy(&ended.stderr));
    String::from_utf8(ended.stdout).unwrap()
}

/// What is written and forced comes to the wire; what a client that is killed forced ends with it, as the board file says.
#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn what_clients_write_and_force_comes_to_the_wire() {
    let _lab = Lab::enter();
    let files = [("board.toml", BOARD), ("main.st", PROGRAM)].map(|(name, text)| (name, text.to_owned()));
    let mut rig =
        Rig::start("live", &files, &["run", "--board", "board.toml", "--program", "main.st", "--booted"]);
    said(&["await", "state=RUNNING", "--within", "60s"]);
    let lit = |rig: &Rig, on: bool, why: &str| rig.until(why, || MAIN.line(8).value() == on);
    said(&["write", "MAIN.wanted=TRUE"]);
    lit(&rig, true, "the program drives its output");
    // This client says goodbye, and that its force stays.
    said(&["force", "%QX0.0=0"]);
    lit(&rig, false, "the force is on the wire");
    assert!(said(&["status"]).contains("forced      %QX0.0 = FALSE"), "{}", rig.said());
    said(&["release", "--all"]);
    lit(&rig, true, "the program has its output again");
    let mut forces = client(&["force", "%QX0.0=0", "--for", "1h"]).spawn().unwrap();
    lit(&rig, false, "the force of a client that stays is on the wire");
    forces.kill().unwrap();
    forces.wait().unwrap();
    lit(&rig, true, "it ended with its client");
    rig.signal(Signal::INT);
    assert_eq!(rig.exit_code(), Some(0), "{}", rig.said());
    assert!(!MAIN.line(8).value() && guards() == 0, "{}", rig.said());
}
