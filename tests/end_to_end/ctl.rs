//! `rig ctl` as a script meets it.

use crate::project_folder::{TestProject, drain, run};
use crate::stepped_rig::{SOCKET, SteppedRig};
use crate::terminal::{talk, terminal};
use std::io::{BufRead, BufReader, Write};
use std::process::Stdio;
use std::time::{Duration, Instant};

const PATIENCE: Duration = Duration::from_secs(60);

const BOARD: &str = "format = 1\n[board]\nkind = \"simulated\"\n[channels]\nlevel = { kind = \"analog\", unit = \"V\" }\n\
[buses]\nmachine = { kind = \"can\", bitrate = 250_000 }\n\
line = { kind = \"serial\", baud = 38_400, parity = \"none\" }\n[ports]\nSL1 = \"line\"\n";

const PROGRAM: &str = "PROGRAM MAIN
VAR
    button AT %IX0.0 : BOOL;
    lamp AT %QX0.0 : BOOL;
    count : INT;
    part : REAL := 0.5;
    level : INT;
END_VAR
lamp := button;
count := count + 1;
END_PROGRAM
";

fn rig() -> (TestProject, SteppedRig) {
    let bench = TestProject::new();
    // What a client that is lost leaves ends here, so that what stays was meant to.
    bench.write("bench.toml", &format!("{BOARD}[control]\non-disconnect = \"release\"\n"));
    bench.write("count.st", PROGRAM);
    let stepped = SteppedRig::start(&bench, "bench.toml", "count.st");
    stepped.expect(0, &["await", "state=RUNNING", "--advance", "60s"]);
    (bench, stepped)
}

#[test]
fn forces_outlast_the_command_that_set_them() {
    let (_bench, stepped) = rig();
    stepped.expect(0, &["force", "%IX0.0=1", "Q3=TRUE"]);
    stepped.expect(0, &["await", "%IX0.0=1", "%QX0.0=1", "%QX0.3=1", "--advance", "1s"]);
    stepped.expect(0, &["release", "%IX0.0"]);
    stepped.expect(0, &["await", "%QX0.0=0", "--advance", "1s"]);
    let status = stepped.expect(0, &["status"]).out;
    assert!(status.contains("%QX0.3 = TRUE") && !status.contains("%IX0.0 ="), "{status}");
    stepped.expect(0, &["release", "--all"]);
    assert!(!stepped.expect(0, &["status"]).out.contains("forced"));
}

/// `level` is a variable of the program as well, which is named `MAIN.level` then.
#[test]
fn a_line_has_its_unit_and_can_be_let_go() {
    let (_bench, stepped) = rig();
    let read = || stepped.expect(0, &["read", "level"]).out;
    stepped.expect(0, &["write", "level=2 V"]);
    assert_eq!(read(), "level  2 V\n");
    stepped.expect(0, &["write", "level=Z"]);
    // Nothing else drives it.
    assert_eq!(read(), "level  0 V\n");
}

#[test]
fn a_force_for_a_while_ends_with_the_command_however_that_ends() {
    let (_bench, stepped) = rig();
    stepped.expect(0, &["force", "Q3=1", "--for", "10ms"]);
    assert!(!stepped.expect(0, &["status"]).out.contains("forced"));
    let mut child = stepped.command(&["force", "Q3=1", "--for", "1h"]).spawn().unwrap();
    let began = Instant::now();
    while !stepped.expect(0, &["status"]).out.contains("forced") {
        assert!(began.elapsed() < PATIENCE, "nothing is forced");
    }
    nix::sys::signal::kill(nix::unistd::Pid::from_raw(child.id() as i32), nix::sys::signal::Signal::SIGINT)
        .unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert!(!stepped.expect(0, &["status"]).out.contains("forced"));
}

#[test]
fn what_cannot_be_is_refused_before_anything_moves() {
    let (_bench, stepped) = rig();
    let refused = |args: &[&str], words: &[&str]| {
        let ran = stepped.expect(2, args);
        assert_eq!(ran.out, "");
        for word in words {
            assert!(ran.err.contains(word), "{args:?}: {word} is missing in {}", ran.err);
        }
    };
    refused(&["force", "Q0=1", "Q1"], &["R0649", "NAME=VALUE"]);
    refused(&["force", "Q0=1", "Q1=?"], &["R0649"]);
    refused(&["force", "Q0=1", "Q1=5 V"], &["R0649", "no unit"]);
    refused(&["force", "Q0=T#5s"], &["R0649", "no unit"]);
    refused(&["write", "level=2 bar"], &["R0649", "unit V"]);
    refused(&["write", "levle=2 V"], &["R0601", "level"]);
    refused(&["write", "state=RUNNNING"], &["R0649", "RUNNING"]);
    refused(&["write", "MAIN.cuont=3"], &["R0601", "MAIN.count"]);
    refused(&["write", "MAIN.count=40000"], &["R0603", "32767"]);
    refused(&["write", "%MW300=70000"], &["R0603", "from -32768 to 65535"]);
    refused(&["write", "%MW300=TRUE"], &["R0603", "from -32768 to 65535"]);
    refused(&["force", "Q0=2"], &["R0603", "TRUE or FALSE"]);
    refused(&["force", "MAIN.part=1"], &["R0605"]);
    refused(&["await", "state"], &["R0649", "state=RUNNING"]);
    refused(&["watch", "nothing"], &["R0601", "rig ctl list"]);
    refused(
        &["frames", "machin", "--for", "10ms"],
        &["R0601", "did you mean `machine`?", "its buses are machine, line"],
    );
    refused(&["release"], &["required"]);
    assert!(!stepped.expect(0, &["status"]).out.contains("forced"));
}

#[test]
fn a_serial_line_has_its_settings_its_port_and_no_state_of_can() {
    let (_bench, stepped) = rig();
    let described = stepped.expect(0, &["describe"]).out;
    assert!(described.contains("line: serial, 38400 Bd 8N1, at port SL1\n"), "{described}");
    let status = stepped.expect(0, &["status"]).out;
    assert!(status.contains("line: open,") && status.contains("machine: error-active,"), "{status}");
}

#[test]
fn the_list_says_what_a_point_takes() {
    let (_bench, stepped) = rig();
    let listed = |name: &str| stepped.expect(0, &["list", name]).out;
    assert!(listed("I0").contains("force, write"), "{}", listed("I0"));
    assert!(listed("level").contains("  write"), "{}", listed("level"));
    assert!(!listed("Q3").contains("write"), "{}", listed("Q3"));
    stepped.expect(0, &["write", "I0=1", "level=2 V"]);
    stepped.expect(2, &["write", "Q3=1"]);
}

#[test]
fn what_is_awaited_and_does_not_come_is_a_failure() {
    let (_bench, stepped) = rig();
    let late = stepped.expect(1, &["await", "state=HALT", "MAIN.part>0.1", "--advance", "100ms"]);
    assert_eq!((&*late.out, &*late.err), ("", "state=HALT was not reached: it is RUNNING\n"));
    stepped.expect(1, &["await", "state!=RUNNING", "--within", "10ms"]);
    stepped.expect(0, &["await", "state=running", "MAIN.part<=0.5"]);
}

#[test]
fn every_change_is_reported_in_stepped_time() {
    let (_bench, stepped) = rig();
    let before: i64 = stepped.expect(0, &["read", "--plain", "MAIN.count"]).out.trim().parse().unwrap();
    let reported = stepped.expect(0, &["watch", "MAIN.count", "--csv", "--all", "--advance", "10s"]);
    assert_eq!(reported.err, "");
    let counts: Vec<i64> =
        reported.out.lines().skip(1).map(|line| line.rsplit(',').next().unwrap().parse().unwrap()).collect();
    let all: Vec<i64> = (before..before + counts.len() as i64).collect();
    assert_eq!(counts, all);
    // The task runs each 20 ms; which of its cycles end within is up to the phase.
    assert!((500..=502).contains(&counts.len()), "{}", counts.len());
    let some = stepped.expect(0, &["watch", "MAIN.count", "--csv", "--advance", "10s", "--every", "1s"]);
    assert!((10..=22).contains(&some.out.lines().count()), "{}", some.out);
    let few =
        stepped.expect(0, &["watch", "MAIN.count", "--json", "--all", "--count", "3", "--advance", "10s"]);
    assert_eq!(few.out.lines().count(), 4);
}

#[test]
fn a_reader_that_goes_away_ends_the_watch() {
    let (_bench, stepped) = rig();
    let mut child =
        stepped.command(&["watch", "MAIN.count", "--all"]).stdout(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
    lines.next().unwrap().unwrap();
    drop(lines);
    let began = Instant::now();
    while child.try_wait().unwrap().is_none() {
        assert!(began.elapsed() < PATIENCE, "it goes on");
        stepped.expect(0, &["advance", "100ms"]);
    }
    assert_eq!(child.wait().unwrap().code(), Some(0));
}

#[test]
fn a_rig_that_is_gone_is_an_error_of_the_rig() {
    let (_bench, stepped) = rig();
    let mut child = stepped
        .command(&["watch", "MAIN.count"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
    lines.next().unwrap().unwrap();
    let err = drain(child.stderr.take().unwrap());
    nix::sys::signal::kill(
        nix::unistd::Pid::from_raw(stepped.process() as i32),
        nix::sys::signal::Signal::SIGTERM,
    )
    .unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(4));
    let err = err.join().unwrap();
    assert!(err.contains("R0646") || err.contains("R0645"), "{err}");
}

#[test]
fn raw_lines_are_answered_one_by_one() {
    let (_bench, stepped) = rig();
    let mut child = stepped.command(&["raw"]).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    let mut stdin = child.stdin.take().unwrap();
    for id in 0..500 {
        writeln!(stdin, "{{\"id\":{id},\"do\":\"read\",\"names\":[\"MAIN.count\"]}}").unwrap();
    }
    // The last line needs no end.
    write!(stdin, "{{\"id\":500,\"do\":\"unlock\"}}").unwrap();
    drop(stdin);
    let out = drain(child.stdout.take().unwrap()).join().unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(0));
    let ids: Vec<&str> = out.lines().skip(1).map(|line| line.split([':', ',']).nth(1).unwrap()).collect();
    assert_eq!(ids, (0..=500).map(|id| id.to_string()).collect::<Vec<_>>());
}

#[test]
fn json_is_what_the_rig_reports() {
    let (_bench, stepped) = rig();
    let json =
        |args: &[&str]| serde_json::from_str::<serde_json::Value>(&stepped.expect(0, args).out).unwrap();
    assert_eq!(json(&["status", "--json"])["state"], "RUNNING");
    assert_eq!(json(&["describe", "--json"])["clock"], "stepped");
    assert_eq!(
        json(&["read", "--json", "MAIN.part", "%IX0.0"]),
        serde_json::json!({"MAIN.part": 0.5, "%IX0.0": false})
    );
    let listed = json(&["list", "--json", "lamp"]);
    assert_eq!(
        (&listed["points"][0]["name"], &listed["signals"][0]["name"]),
        (&"Q0".into(), &"MAIN.lamp".into())
    );
}

#[test]
fn who_sits_at_a_terminal_is_asked_before_outputs_move() {
    let (bench, stepped) = rig();
    let state = || {
        stepped.expect(0, &["advance", "100ms"]);
        stepped.expect(0, &["state"]).out
    };
    let stop = ["ctl", "--socket", SOCKET, "stop"];
    for answer in ["no", "", "what"] {
        let (code, screen) = talk(terminal(&bench, &stop), &[answer]);
        assert!(screen.contains("stop on bench.toml") && screen.contains("nothing was done"), "{screen}");
        assert_eq!((code, &*state()), (Some(130), "RUNNING\n"));
    }
    assert_eq!(talk(terminal(&bench, &stop), &["yes"]).0, Some(0));
    assert_eq!(state(), "STOPPED\n");
    stepped.expect(0, &["run"]);
    assert_eq!(state(), "RUNNING\n");
    let (code, screen) = talk(terminal(&bench, &[&stop[..], &["--yes"]].concat()), &[]);
    assert!(code == Some(0) && !screen.contains("yes or no"), "{screen}");
}

#[test]
fn a_rig_is_found_by_its_board() {
    let bench = TestProject::new();
    bench.write("count.st", PROGRAM);
    bench.write("left.toml", BOARD);
    let socket = bench.path("elsewhere.socket");
    bench.write("right.toml", &format!("{BOARD}[control]\nsocket = {:?}\n", socket.display().to_string()));
    let command = |args: &[&str]| {
        let mut command = bench.command(args);
        command.env("XDG_RUNTIME_DIR", bench.path("run"));
        command
    };
    let ctl = |args: &[&str]| {
        let ran = run(command(&[&["ctl"], args].concat()));
        (ran.code, ran.out + &ran.err)
    };
    std::fs::create_dir(bench.path("run")).unwrap();
    let mut rigs = Vec::new();
    for (board, name) in [("left.toml", "left"), ("right.toml", "right.toml")] {
        let args = ["run", "--board", board, "--program", "count.st", "--stepped"];
        rigs.push(KilledOnDrop(command(&args).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()));
        let (code, said) = ctl(&["describe", "--board", name, "--wait", "60s"]);
        assert!(code == Some(0) && said.contains(board), "{said}");
    }
    assert!(socket.exists());
    let listed = ctl(&["rigs"]).1;
    assert!(listed.contains("run/scanrig/left.sock  TM241CEC24T  left.toml"), "{listed}");
    let second = ["run", "--board", "left.toml", "--program", "count.st", "--stepped", "--control"];
    let mut second = command(&second);
    second.arg(bench.path("run/scanrig/second.sock")).stdout(Stdio::null()).stderr(Stdio::null());
    rigs.push(KilledOnDrop(second.spawn().unwrap()));
    assert_eq!(ctl(&["state", "--board", "second", "--wait", "60s"]).0, Some(0));
    let (code, said) = ctl(&["state"]);
    let named = ["R0641", "left.sock", "second.sock"].iter().all(|word| said.contains(word));
    assert!(code == Some(2) && named, "{said}");
    drop(rigs);
    let (code, said) = ctl(&["state", "--board", "left"]);
    assert!(code == Some(2) && said.contains("R0642") && said.contains("left.sock"), "{said}");
}

#[test]
fn a_plan_has_the_course_and_the_exit_of_a_test() {
    let (bench, stepped) = rig();
    bench.write_lamp("slow.toml", "500 ms .. 550 ms", "490 ms .. 499 ms");
    assert_eq!(stepped.expect(0, &["plans", "lamp.toml"]).out, "lamp\n");
    let reported = stepped.expect(0, &["plan", "lamp"]).out;
    assert_eq!(reported, "lamp (1 of 1)\n      1.000000 s  press  button := TRUE\npass: lamp\nall: pass\n");
    let reported = stepped.expect(1, &["plan", "slow"]).out;
    assert!(
        reported.contains("  fail: `lamp` rises 490 ms .. 499 ms after press")
            && reported.ends_with("all: fail\n"),
        "{reported}"
    );
    let json = stepped.expect(0, &["plan", "lamp", "--json"]).out;
    let events: Vec<serde_json::Value> =
        json.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let kinds: Vec<&str> = events.iter().map(|event| event["plan"].as_str().unwrap()).collect();
    assert_eq!(kinds, ["case", "step", "step", "verdict", "over"]);
    let missing = stepped.expect(2, &["plan", "lapm"]);
    assert!(missing.err.contains("R061"), "{}", missing.err);
    // The controller restarts after it.
    stepped.expect(0, &["await", "state=RUNNING", "--advance", "60s"]);
}

/// A process that is ended when this is dropped.
struct KilledOnDrop(std::process::Child);

impl Drop for KilledOnDrop {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}
