//! Runs of the command on real lines, under its guard: whatever becomes of them, the outputs become safe.

use devices::{AUX, Call, Lab, MAIN, PATIENCE, rig, wait_for};
use rustix::process::{Pid, Signal, kill_process};
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

/// What a case may take from its trouble to safe outputs, the guard's limit included, on an emulated machine.
const SOON: Duration = Duration::from_millis(2_500);

const BOARD: &str = r#"format = 1
title = "A valve, a heater with an inverted relay, a lamp"
[board]
kind = "real"
[chips]
main = { label = "rig-gpio" }
aux = { label = "rig-gpio-aux" }
[channels]
I0 = { kind = "digital", chip = "main", line = 0 }
Q0 = { kind = "digital", chip = "main", line = 8, safe = false }
Q1 = { kind = "digital", chip = "main", line = 9, safe = true }
Q2 = { kind = "digital", chip = "aux", line = 0, safe = false }
[guard]
limit = "1 s"
hold = "1 h"
[realtime]
late = "10 s"
"#;

const PROGRAM: &str = "\
PROGRAM MAIN
VAR
    valve AT %QX0.0 : BOOL;
    heater AT %QX0.1 : BOOL;
    lamp AT %QX0.2 : BOOL;
END_VAR
valve := TRUE;
heater := FALSE;
lamp := TRUE;
END_PROGRAM
";

const PLAN: &str = r#"format = 1
title = "Everything is on for a while"
program = "main.st"
signals = { valve = "%QX0.0" }
ends = "start + LASTS"
expect = [{ stays = { signal = "valve", is = true, from = "start + 300 ms", until = "start + 600 ms" } }]
"#;

/// Nobody is at the outputs, or all are driven away from their safe levels, or all are safe.
fn safe() -> bool {
    !MAIN.line(8).value() && MAIN.line(9).value() && !AUX.line(0).value()
}

fn driven() -> bool {
    MAIN.line(8).value() && !MAIN.line(9).value() && AUX.line(0).value()
}

/// `rig test` or `rig run` at work.
struct Run {
    process: Child,
    said: PathBuf,
}

impl Run {
    /// Starts a case that lasts so long, and waits until its outputs are driven.
    fn driving(lasts: &str) -> Run {
        Run::start(lasts, &["test", "--board", "board.toml", "plan.toml"])
    }

    /// Starts a controller that is kept running, and waits until its outputs are driven.
    fn playing() -> Run {
        Run::start("1 s", &["run", "--board", "board.toml", "--program", "main.st"])
    }

    fn start(lasts: &str, args: &[&str]) -> Run {
        let run = Run::spawn(lasts, args);
        wait_for("the outputs are driven", PATIENCE * 2, || {
            assert!(!run.has_ended(), "{}", run.said());
            driven()
        });
        run
    }

    fn spawn(lasts: &str, args: &[&str]) -> Run {
        let folder = Path::new("/tmp/guarded");
        std::fs::create_dir_all(folder).unwrap();
        std::fs::write(folder.join("board.toml"), BOARD).unwrap();
        std::fs::write(folder.join("main.st"), PROGRAM).unwrap();
        std::fs::write(folder.join("plan.toml"), PLAN.replace("LASTS", lasts)).unwrap();
        let said = folder.join("said");
        let all = File::create(&said).unwrap();
        let process = Command::new(rig())
            .args(args)
            .current_dir(folder)
            .env("XDG_STATE_HOME", folder)
            .stdin(Stdio::null())
            .stdout(all.try_clone().unwrap())
            .stderr(all)
            .spawn()
            .unwrap();
        Run { process, said }
    }

    fn said(&self) -> String {
        std::fs::read_to_string(&self.said).unwrap()
    }

    fn has_ended(&self) -> bool {
        !is_there(Pid::from_child(&self.process))
    }

    fn signal(&self, signal: Signal) {
        kill_process(Pid::from_child(&self.process), signal).unwrap();
    }

    /// Its guard: its one child.
    fn guard(&self) -> Pid {
        let parent = format!("PPid:\t{}", self.process.id());
        let status = |name: &str| std::fs::read_to_string(format!("/proc/{name}/status")).unwrap_or_default();
        let names = std::fs::read_dir("/proc").unwrap().flatten();
        let mut names = names.filter_map(|entry| entry.file_name().into_string().ok());
        let child = names.find(|name| status(name).lines().any(|line| line == parent));
        Pid::from_raw(child.expect("it has a guard").parse().unwrap()).unwrap()
    }

    /// Whether the case comes to a verdict. On a machine that stands still now and then it need not be sure of it.
    fn ends_judged(&mut self) -> bool {
        matches!(self.exit_code(), Some(0 | 3))
    }

    fn exit_code(&mut self) -> Option<i32> {
        wait_for("the run ends", PATIENCE * 2, || self.has_ended());
        self.process.wait().unwrap().code()
    }
}

impl Drop for Run {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
        if !thread::panicking() {
            let lets_go =
                || ["/dev/gpiochip0 (rig-gpio)", "/dev/gpiochip1 (rig-gpio-aux)"].map(guard::take_over);
            wait_for("the lines are let go", PATIENCE, || {
                lets_go();
                guards() == 0
            });
        }
    }
}

fn is_there(process: Pid) -> bool {
    let stat = std::fs::read_to_string(format!("/proc/{}/stat", process.as_raw_nonzero()));
    stat.is_ok_and(|stat| !stat.contains(") Z "))
}

/// How many guards there are.
fn guards() -> usize {
    let names = std::fs::read_dir("/proc").unwrap().flatten().map(|entry| entry.path().join("cmdline"));
    names.filter(|path| std::fs::read(path).is_ok_and(|words| words.ends_with(b"\0guard\0"))).count()
}

/// The outputs become safe within a time, counted from `since`.
fn becomes_safe(what: &str, since: Instant, within: Duration) {
    let mut took = since.elapsed();
    while !safe() {
        assert!(took < PATIENCE, "{what}: the outputs never became safe");
        took = since.elapsed();
    }
    println!("\nfigure: rig {what}: all outputs safe after {took:?}");
    assert!(took < within, "{what}: safe after {took:?}");
}

/// The same of a rig that is lost: its guard holds the outputs from then on.
fn is_made_safe(what: &str, since: Instant, within: Duration) {
    becomes_safe(what, since, within);
    let until = Instant::now() + Duration::from_millis(50);
    while Instant::now() < until {
        assert!(safe(), "{what}: an output changed after the latch");
    }
}

/// Lines that a run has let go are at their pulls, and none of them is driven any more.
fn is_let_go() -> bool {
    !MAIN.line(8).value() && !AUX.line(0).value()
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn runs_that_are_killed_or_stopped() {
    let _lab = Lab::enter();
    for (what, signal) in
        [("test killed", Signal::KILL), ("test stopped", Signal::STOP), ("test aborted", Signal::ABORT)]
    {
        let mut run = Run::driving("60 s");
        let since = Instant::now();
        run.signal(signal);
        is_made_safe(what, since, SOON);
        assert_eq!(run.exit_code(), None, "{}", run.said());
        wait_for("the guard says so", PATIENCE, || run.said().contains("error[R0193]"));
    }
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_run_that_ends_by_itself_or_is_interrupted_leaves_no_guard() {
    let _lab = Lab::enter();
    let mut run = Run::driving("1 s");
    assert!(run.ends_judged(), "{}", run.said());
    assert_eq!(guards(), 0);
    assert!(!run.said().contains("R019"), "{}", run.said());
    let mut run = Run::driving("60 s");
    run.signal(Signal::INT);
    becomes_safe("test interrupted", Instant::now(), PATIENCE);
    assert_eq!(run.exit_code(), Some(130), "{}", run.said());
    assert_eq!(guards(), 0);
    assert!(is_let_go());
    assert!(!run.said().contains("R019"), "{}", run.said());
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_controller_that_is_kept_running_is_guarded_as_well() {
    let _lab = Lab::enter();
    for (what, signal) in [("run killed", Signal::KILL), ("run stopped", Signal::STOP)] {
        let mut run = Run::playing();
        let since = Instant::now();
        run.signal(signal);
        is_made_safe(what, since, SOON);
        assert_eq!(run.exit_code(), None, "{}", run.said());
        wait_for("the guard says so", PATIENCE, || run.said().contains("error[R0193]"));
    }
    let mut run = Run::playing();
    run.signal(Signal::INT);
    becomes_safe("run interrupted", Instant::now(), PATIENCE);
    assert!(run.exit_code().is_some());
    assert_eq!(guards(), 0);
    assert!(is_let_go());
    assert!(!run.said().contains("R019"), "{}", run.said());
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_key_that_stops_programs_does_not_stop_a_run() {
    let _lab = Lab::enter();
    let mut run = Run::driving("2 s");
    run.signal(Signal::TSTP);
    assert!(run.ends_judged(), "{}", run.said());
}

/// The device's calls hang, and not the scan: the rig lives on, and knows that its case is worth nothing.
#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_chip_that_hangs_while_it_is_read_makes_the_case_an_error() {
    let lab = Lab::enter();
    let mut run = Run::driving("4 s");
    lab.stall(MAIN, Call::Get, Duration::from_secs(2), 1);
    wait_for("the call hangs", PATIENCE, || lab.inside(MAIN, Call::Get) == 1);
    assert_eq!(run.exit_code(), Some(4), "{}", run.said());
    assert!(run.said().contains("its device, /dev/gpiochip0 (rig-gpio), does not answer"), "{}", run.said());
    assert_eq!(guards(), 0);
    assert!(!AUX.line(0).value(), "the other chip is safe");
}

/// The last write of a run, which makes its outputs safe, hangs on one of two chips.
#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_chip_that_hangs_while_it_is_made_safe_holds_up_no_other() {
    let lab = Lab::enter();
    let mut run = Run::driving("60 s");
    lab.stall(MAIN, Call::Set, Duration::from_secs(2), 1);
    run.signal(Signal::INT);
    wait_for("the call hangs", PATIENCE, || lab.inside(MAIN, Call::Set) == 1);
    wait_for("the other chip is safe", PATIENCE, || !AUX.line(0).value());
    assert!(MAIN.line(8).value() && lab.inside(MAIN, Call::Set) == 1, "the call came back too early");
    let since = Instant::now();
    wait_for("the chip is safe", PATIENCE, || !MAIN.line(8).value());
    println!(
        "\nfigure: rig test with a write that hangs for 2 s: its chip safe {:?} after the other",
        since.elapsed()
    );
    let code = run.exit_code();
    assert!(matches!(code, Some(4 | 130)), "{code:?} {}", run.said());
    println!("{}", run.said());
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_run_whose_guard_dies_ends_safe_and_as_an_error() {
    let _lab = Lab::enter();
    let mut run = Run::driving("60 s");
    kill_process(run.guard(), Signal::KILL).unwrap();
    becomes_safe("test whose guard died", Instant::now(), SOON);
    assert_eq!(run.exit_code(), Some(4), "{}", run.said());
    assert!(run.said().contains("the guard is gone or does not answer"), "{}", run.said());
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn the_next_run_takes_the_lines_over() {
    let _lab = Lab::enter();
    let mut first = Run::driving("60 s");
    first.signal(Signal::KILL);
    is_made_safe("test killed", Instant::now(), SOON);
    first.exit_code();
    wait_for("the guard is alone", PATIENCE, || first.said().contains("error[R0193]"));
    let mut second = Run::driving("1 s");
    assert!(second.ends_judged(), "{}", second.said());
}
