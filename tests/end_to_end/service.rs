//! `rig run` as a service manager starts it: what it sends, and when.

use crate::project_folder::TestProject;
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use std::os::linux::net::SocketAddrExt;
use std::os::unix::net::{SocketAddr, UnixDatagram};
use std::process::{Child, Stdio};
use std::time::Duration;

/// Longer than anything here lasts on a busy machine.
const PATIENCE: Duration = Duration::from_secs(60);

const BOARD: &str = "format = 1\nboard = { kind = \"simulated\" }\n";

/// The lines of the next message.
fn reported(manager: &UnixDatagram) -> Vec<String> {
    let mut room = [0; 4096];
    let length = manager.recv(&mut room).expect("the rig reports something");
    String::from_utf8_lossy(&room[..length]).lines().map(str::to_owned).collect()
}

/// Lines up to the first that is this one, and it.
fn reported_until(manager: &UnixDatagram, last: &str) -> Vec<String> {
    let mut lines = Vec::new();
    while !lines.iter().any(|line| line == last) {
        lines.extend(reported(manager));
    }
    lines
}

fn start(bench: &TestProject, socket: &str, watchdog: &str) -> Child {
    bench.write("bench.toml", BOARD);
    let mut command = bench.command(&["run", "--board", "bench.toml", "--program", "lamp.st"]);
    command.env("NOTIFY_SOCKET", socket).env("WATCHDOG_USEC", watchdog);
    command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
}

fn stop(mut rig: Child) -> Option<i32> {
    kill(Pid::from_raw(rig.id() as i32), Signal::SIGTERM).unwrap();
    rig.wait().unwrap().code()
}

#[test]
fn a_manager_is_notified_when_the_controller_is_ready_that_it_goes_on_and_that_it_stops() {
    let bench = TestProject::new();
    let path = bench.path("notify");
    let manager = UnixDatagram::bind(&path).unwrap();
    manager.set_read_timeout(Some(PATIENCE)).unwrap();
    let rig = start(&bench, path.to_str().unwrap(), "200000");
    assert_eq!(reported_until(&manager, "READY=1").last().map(String::as_str), Some("STATUS=ready"));
    let lines = reported_until(&manager, "STATUS=RUNNING");
    assert!(lines.contains(&String::from("STATUS=BOOTING")), "{lines:?}");
    // It goes on for as long as the scan does, without anything else to be sent.
    for _ in 0..5 {
        assert_eq!(reported(&manager), ["WATCHDOG=1"]);
    }
    assert_eq!(stop(rig), Some(0));
    let lines = reported_until(&manager, "STOPPING=1");
    assert!(!lines.contains(&String::from("READY=1")), "{lines:?}");
    manager.set_nonblocking(true).unwrap();
    let mut rest = [0; 4096];
    while let Ok(length) = manager.recv(&mut rest) {
        assert_eq!(&rest[..length], b"WATCHDOG=1", "after the end");
    }
}

#[test]
fn a_manager_may_listen_at_an_abstract_name_and_want_no_sign_of_life() {
    let bench = TestProject::new();
    let name = format!("scanrig-test-{}", std::process::id());
    let manager = UnixDatagram::bind_addr(&SocketAddr::from_abstract_name(&name).unwrap()).unwrap();
    manager.set_read_timeout(Some(PATIENCE)).unwrap();
    let rig = start(&bench, &format!("@{name}"), "0");
    let lines = reported_until(&manager, "STATUS=RUNNING");
    assert_eq!(stop(rig), Some(0));
    let lines: Vec<String> = lines.into_iter().chain(reported_until(&manager, "STOPPING=1")).collect();
    let said = |line: &str| lines.iter().filter(|said| *said == line).count();
    assert_eq!((said("READY=1"), said("STOPPING=1"), said("WATCHDOG=1")), (1, 1, 0), "{lines:?}");
}

#[test]
fn a_manager_that_is_not_there_is_said_before_anything_moves() {
    let bench = TestProject::new();
    bench.write("bench.toml", BOARD);
    let run = |name: &str, text: &str| {
        let mut command = bench.command(&["run", "--board", "bench.toml", "--program", "lamp.st"]);
        let ran = crate::project_folder::run({
            command.env("NOTIFY_SOCKET", bench.path("notify")).env(name, text);
            command
        });
        assert_eq!((ran.code, ran.out.as_str()), (Some(2), ""), "{}", ran.err);
        ran.err
    };
    assert!(run("WATCHDOG_USEC", "1000").contains("R0340"));
    assert!(run("WATCHDOG_USEC", "soon").contains("R0341"));
}

#[test]
fn a_manager_that_takes_nothing_does_not_hold_up_the_end() {
    let bench = TestProject::new();
    let path = bench.path("notify");
    let manager = UnixDatagram::bind(&path).unwrap();
    let fill = UnixDatagram::unbound().unwrap();
    fill.set_nonblocking(true).unwrap();
    // Nothing more fits into its queue.
    while fill.send_to(b"X", &path).is_ok() {}
    let rig = start(&bench, path.to_str().unwrap(), "200000");
    // As soon as the signal is caught it counts.
    crate::interrupt::wait_for_handler(&rig, Signal::SIGTERM);
    kill(Pid::from_raw(rig.id() as i32), Signal::SIGTERM).unwrap();
    assert_eq!(crate::interrupt::end(rig), Some(0));
    drop(manager);
}
