//! Devices that fail, hang or go away while a case runs: what is reported to a user, what becomes of the outputs, and of the next
//! case.

mod every;
mod far;
mod world;

use crate::rig::{Rig, guards};
use devices::{Call, Lab, MAIN, PATIENCE, SimChip, wait_for};
use rustix::process::Signal;
use std::time::Duration;

/// A chip that stays and one that can go away, each with a lamp.
fn board(rest: &str) -> String {
    format!(
        r#"format = 1
title = "A lamp on each of two chips"
[board]
kind = "real"
{rest}
[chips]
main = {{ label = "rig-gpio" }}
far = {{ label = "rig-gpio-far" }}
[channels]
Q0 = {{ kind = "digital", chip = "main", line = 8, safe = false }}
Q1 = {{ kind = "digital", chip = "far", line = 0, safe = false }}
I1 = {{ kind = "digital", chip = "far", line = 1 }}
[guard]
limit = "2 s"
[realtime]
late = "10 s"
"#
    )
}

const PROGRAM: &str = "\
PROGRAM MAIN
VAR
    near AT %QX0.0 : BOOL;
    far AT %QX0.1 : BOOL;
END_VAR
near := TRUE;
far := TRUE;
END_PROGRAM
";

/// Cases in this order, each as long as it says; each ends with a mark of its teardown.
fn plan(cases: &[(&str, &str)]) -> String {
    let rows = cases.iter().map(|(name, lasts)| format!("{name} = {{ lasts = \"{lasts}\" }}\n"));
    format!(
        r#"format = 1
title = "Both lamps are on"
program = "main.st"
signals = {{ far = "%QX0.1" }}
ends = "start + $lasts"
teardown = [{{ id = "rest", at = "teardown + 10 ms", mark = {{}} }}]
expect = [{{ stays = {{ signal = "far", is = true, from = "start + 300 ms", until = "start + 600 ms" }} }}]
[rows]
{}"#,
        rows.collect::<String>()
    )
}

fn far() -> SimChip {
    SimChip::add("rig-gpio-far", &["", "", "", ""])
}

fn files(board: String, plan: String) -> [(&'static str, String); 3] {
    [("board.toml", board), ("plan.toml", plan), ("main.st", PROGRAM.to_owned())]
}

const TEST: [&str; 6] = ["test", "--board", "board.toml", "--report", "report", "plan.toml"];
const RUN: [&str; 5] = ["run", "--board", "board.toml", "--program", "main.st"];

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_chip_that_vanishes_or_hangs_ends_its_case_and_the_next_is_sound() {
    let lab = Lab::enter();
    let chip = far();
    let plan = plan(&[("first", "60 s"), ("second", "60 s"), ("third", "1 s")]);
    let mut rig = Rig::start("vanish", &files(board("reconnect = true"), plan), &TEST);
    rig.until("both lamps are on", || MAIN.line(8).value() && chip.value(0));
    chip.vanish();
    rig.until("the other output is safe", || !MAIN.line(8).value());
    drop(chip);
    let chip = far();
    rig.until("the lamps are on again", || MAIN.line(8).value() && chip.value(0));
    lab.stall(MAIN, Call::Get, Duration::from_secs(1), 1);
    rig.until("the other output is safe", || !chip.value(0));
    assert_eq!(rig.exit_code(), Some(4), "{}", rig.said());
    assert!(!MAIN.line(8).value() && !chip.value(0) && guards() == 0, "{}", rig.said());
    let [first, second, third] = &rig.cases()[..] else { panic!("{}", rig.said()) };
    assert_eq!([&first[0], &first[2]], ["error", "a device was lost"]);
    let words = ["channel I1 was lost at", "its device, /dev/gpiochip", "(rig-gpio-far), is gone"];
    for said in [&first[1], &rig.said(), &rig.file("report/junit.xml")] {
        assert!(words.iter().all(|words| said.contains(words)), "{said}");
    }
    assert_eq!([&second[0], &second[2]], ["error", "a device was lost"]);
    assert!(second[1].contains("its device, /dev/gpiochip0 (rig-gpio), does not answer"), "{second:?}");
    // On a machine that stands still now and then it need not be sure of it.
    assert!(["pass", "inconclusive"].contains(&third[0].as_str()), "{}", rig.said());
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_chip_that_is_not_to_be_taken_back_stays_lost_and_the_next_case_says_since_when() {
    let _lab = Lab::enter();
    let chip = far();
    let plan = plan(&[("first", "60 s"), ("second", "60 s")]);
    let mut rig = Rig::start("stays", &files(board(""), plan), &TEST);
    rig.until("both lamps are on", || MAIN.line(8).value() && chip.value(0));
    chip.vanish();
    drop(chip);
    let _chip = far();
    assert_eq!(rig.exit_code(), Some(4), "{}", rig.said());
    assert!(!MAIN.line(8).value(), "{}", rig.said());
    let [first, second] = &rig.cases()[..] else { panic!("{}", rig.said()) };
    assert!(first[1].contains("was lost at"), "{first:?}");
    assert_eq!(second[0], "error");
    let words = ["channel I1 is lost for", "(rig-gpio-far), is gone; `reconnect = true`"];
    assert!(words.iter().all(|words| second[1].contains(words)), "{second:?}");
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_loss_ends_a_run_that_is_to_fail_fast() {
    let _lab = Lab::enter();
    let chip = far();
    let plan = plan(&[("first", "60 s"), ("second", "60 s")]);
    let words = [&TEST[..], &["--fail-fast"]].concat();
    let mut rig = Rig::start("fast", &files(board("reconnect = true"), plan), &words);
    rig.until("both lamps are on", || MAIN.line(8).value() && chip.value(0));
    chip.vanish();
    assert_eq!(rig.exit_code(), Some(4), "{}", rig.said());
    assert!(!MAIN.line(8).value(), "{}", rig.said());
    // Nobody could drive what is gone: the guard holds the others for a while.
    wait_for("the lines are let go", PATIENCE, || guards() == 0);
    let found = rig.cases();
    assert_eq!([&found[0][0], &found[0][2]], ["error", "a device was lost"], "{found:?}");
    assert!(rig.said().contains("1 error, 1 skipped; 1 of 2 planned cases ran"), "{}", rig.said());
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_controller_that_is_kept_running_drives_a_chip_that_is_back() {
    let _lab = Lab::enter();
    let chip = far();
    let rest = "reconnect = true\non-loss = \"go-on\"";
    let rig = Rig::start("run", &files(board(rest), plan(&[("only", "1 s")])), &RUN);
    rig.until("both lamps are on", || MAIN.line(8).value() && chip.value(0));
    chip.vanish();
    rig.until("it says so", || rig.said().contains("channel I1 was lost at"));
    drop(chip);
    let chip = far();
    rig.until("the lamp is on again", || chip.value(0));
    rig.until("it says so", || rig.said().contains("is back at"));
    assert!(MAIN.line(8).value(), "{}", rig.said());
    // The guard keeps it from now on.
    rig.signal(Signal::KILL);
    wait_for("all outputs are safe", PATIENCE, || !MAIN.line(8).value() && !chip.value(0));
    wait_for("the guard says so", PATIENCE, || rig.said().contains("error[R0193]"));
    assert!(rig.said().contains("rig-gpio-far"), "{}", rig.said());
    guard::take_over("/dev/gpiochip0 (rig-gpio)");
    wait_for("the lines are let go", PATIENCE, || guards() == 0);
}
