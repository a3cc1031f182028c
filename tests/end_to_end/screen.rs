//! The dashboard takes a terminal and gives it back, however it ends, and ends the rig that it started.

use crate::project_folder::TestProject;
use crate::terminal::terminal;
use nix::pty::{Winsize, openpty};
use nix::sys::signal::{Signal, kill};
use nix::sys::termios::{LocalFlags, tcgetattr};
use nix::unistd::Pid;
use std::fs::File;
use std::io::{Read, Write};
use std::os::fd::OwnedFd;
use std::os::unix::process::CommandExt;
use std::process::{Child, Stdio};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// Far above what any of it takes, on a machine that does much else.
const PATIENCE: Duration = Duration::from_secs(120);

/// What a terminal receives when a program takes its screen, and when it gives it back.
const TAKEN: &str = "\x1b[?1049h";
const GIVEN_BACK: &str = "\x1b[?1049l";

/// A terminal with the dashboard of a demonstration on it.
struct DashboardTerminal {
    dash: Child,
    /// The side of the program, whose settings are looked at.
    settings: OwnedFd,
    keys: File,
    shown: Arc<Mutex<String>>,
    bench: TestProject,
}

impl DashboardTerminal {
    /// The dashboard of a demonstration, once its controller runs.
    fn start() -> DashboardTerminal {
        DashboardTerminal::with(TestProject::new(), &["dash", "--board", "sim"])
    }

    fn with(bench: TestProject, args: &[&str]) -> DashboardTerminal {
        let size = Winsize { ws_row: 24, ws_col: 80, ws_xpixel: 0, ws_ypixel: 0 };
        let pty = openpty(&size, None).unwrap();
        let side = || Stdio::from(pty.slave.try_clone().unwrap());
        let mut command = terminal(&bench, args);
        command.env("TMPDIR", bench.path("")).stdin(side()).stdout(side()).stderr(side());
        // A group of its own, as a shell gives to what it starts: only such a one can be stopped.
        let dash = command.process_group(0).spawn().unwrap();
        let mut terminal = File::from(pty.master);
        let keys = terminal.try_clone().unwrap();
        let shown = Arc::new(Mutex::new(String::new()));
        let all = shown.clone();
        std::thread::spawn(move || {
            let mut some = [0; 4096];
            while let Ok(n @ 1..) = terminal.read(&mut some) {
                all.lock().unwrap().push_str(&String::from_utf8_lossy(&some[..n]));
            }
        });
        let screen = DashboardTerminal { dash, settings: pty.slave, keys, shown, bench };
        screen.wait_for("a controller that runs", |screen| screen.shown().contains("RUNNING"));
        screen
    }

    fn shown(&self) -> String {
        self.shown.lock().unwrap().clone()
    }

    fn wait_for(&self, what: &str, mut is: impl FnMut(&DashboardTerminal) -> bool) {
        let until = Instant::now() + PATIENCE;
        while !is(self) {
            assert!(Instant::now() < until, "{what} does not come; the screen was sent {:?}", self.shown());
            std::thread::sleep(Duration::from_millis(10));
        }
    }

    fn press(&mut self, keys: &[u8]) {
        self.keys.write_all(keys).unwrap();
    }

    fn signal(&self, signal: Signal) {
        kill(Pid::from_raw(self.dash.id() as i32), signal).unwrap();
    }

    /// Whether the terminal hands over lines, and shows what is typed: as programs find it.
    fn is_given_back(&self) -> bool {
        let flags = tcgetattr(&self.settings).unwrap().local_flags;
        flags.contains(LocalFlags::ICANON | LocalFlags::ECHO) && self.count(TAKEN) == self.count(GIVEN_BACK)
    }

    fn count(&self, reported: &str) -> usize {
        self.shown().matches(reported).count()
    }

    fn is_stopped(&self) -> bool {
        let stat = std::fs::read_to_string(format!("/proc/{}/stat", self.dash.id())).unwrap();
        stat.rsplit(')').next().is_some_and(|rest| rest.trim_start().starts_with('T'))
    }

    /// Waits for the end; nothing of the dashboard may be left.
    fn ends(mut self, code: i32) {
        let until = Instant::now() + PATIENCE;
        let status = loop {
            if let Some(status) = self.dash.try_wait().unwrap() {
                break status;
            }
            assert!(Instant::now() < until, "it does not end: {:?}", self.shown());
            std::thread::sleep(Duration::from_millis(10));
        };
        assert_eq!(status.code(), Some(code), "{:?}", self.shown());
        self.wait_for("the terminal", DashboardTerminal::is_given_back);
        let left: Vec<String> =
            self.bench.list("").into_iter().filter(|name| name.contains("demonstration")).collect();
        assert!(left.is_empty(), "{left:?}");
    }
}

impl Drop for DashboardTerminal {
    fn drop(&mut self) {
        // After a test that failed; one that has ended cannot be killed.
        let _ = self.dash.kill();
        let _ = self.dash.wait();
    }
}

#[test]
fn a_dashboard_that_is_left_leaves_nothing() {
    let mut screen = DashboardTerminal::start();
    assert!(!screen.is_given_back());
    screen.press(b"q");
    screen.wait_for("a question", |screen| screen.shown().contains("Leave and end the rig"));
    screen.press(b"l");
    screen.ends(0);
}

#[test]
fn the_rig_of_a_demonstration_ends_with_a_dashboard_that_is_killed() {
    let screen = DashboardTerminal::start();
    let folder = screen.bench.list("").into_iter().find(|name| name.contains("demonstration")).unwrap();
    let socket = screen.bench.path(&folder).join("sim.sock");
    assert!(socket.exists());
    screen.signal(Signal::SIGKILL);
    screen.wait_for("the end of the rig", |_| !socket.exists());
}

#[test]
fn a_dashboard_that_is_ended_leaves_nothing() {
    for signal in [Signal::SIGTERM, Signal::SIGHUP, Signal::SIGINT] {
        let screen = DashboardTerminal::start();
        screen.signal(signal);
        screen.ends(130);
    }
}

#[test]
fn a_dashboard_that_is_stopped_lends_the_terminal() {
    let mut screen = DashboardTerminal::start();
    screen.press(b"\x1a");
    screen.wait_for("a stop", DashboardTerminal::is_stopped);
    screen.wait_for("the terminal", DashboardTerminal::is_given_back);
    screen.signal(Signal::SIGCONT);
    // All of it is drawn again, and nothing is asked of the terminal, whose answer would be taken for keys.
    screen.wait_for("the screen", |screen| {
        screen.shown().rsplit(TAKEN).next().is_some_and(|since| since.contains("RUNNING"))
    });
    assert_eq!(screen.count("\x1b[6n"), 0);
    screen.press(b"ql");
    screen.ends(0);
}

/// A rig of the lamp at `rig.sock` in this folder.
fn rig(bench: &TestProject) -> Child {
    let args =
        ["run", "--board", "lamp-board.toml", "--program", "lamp.st", "--booted", "--control", "rig.sock"];
    bench.command(&args).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
}

#[test]
fn a_rig_that_ends_is_missed_and_its_next_one_is_found() {
    let bench = TestProject::new();
    bench.write("lamp-board.toml", "format = 1\n[board]\nkind = \"simulated\"\n");
    let mut first = rig(&bench);
    let mut screen = DashboardTerminal::with(bench, &["dash", "--socket", "rig.sock", "--wait", "60s"]);
    kill(Pid::from_raw(first.id() as i32), Signal::SIGTERM).unwrap();
    first.wait().unwrap();
    screen.wait_for("a warning", |screen| screen.shown().contains("!! No connection"));
    let mut second = rig(&screen.bench);
    screen.wait_for("the next rig", |screen| screen.shown().contains("connected again to lamp-board.toml"));
    screen.press(b"q");
    screen.ends(0);
    kill(Pid::from_raw(second.id() as i32), Signal::SIGTERM).unwrap();
    second.wait().unwrap();
}
