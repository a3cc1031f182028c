//! The lab itself: what the other tests build upon.

use devices::{AUX, Call, Lab, Line, MAIN, PATIENCE, SimChip, wait_for};
use std::fs;
use std::path::PathBuf;
use std::thread;
use std::time::{Duration, Instant};

/// An output line taken through the kernel's old interface, so that nothing of the rig is needed.
struct Output(PathBuf, u32);

impl Output {
    fn take(line: Line) -> Output {
        let label = line.to_string().split(':').next().unwrap().to_owned();
        let base = fs::read_dir("/sys/class/gpio").unwrap().flatten().find_map(|entry| {
            let found = fs::read_to_string(entry.path().join("label")).ok()?.trim() == label;
            found.then(|| {
                fs::read_to_string(entry.path().join("base")).unwrap().trim().parse::<u32>().unwrap()
            })
        });
        let number = base.unwrap() + line.number();
        fs::write("/sys/class/gpio/export", number.to_string()).unwrap();
        let output = Output(format!("/sys/class/gpio/gpio{number}").into(), number);
        fs::write(output.0.join("direction"), "low").unwrap();
        output
    }

    fn set(&self, level: bool) {
        fs::write(self.0.join("value"), if level { "1" } else { "0" }).unwrap();
    }

    fn get(&self) -> bool {
        fs::read_to_string(self.0.join("value")).unwrap().trim() == "1"
    }
}

impl Drop for Output {
    fn drop(&mut self) {
        let _ = fs::write("/sys/class/gpio/unexport", self.1.to_string());
    }
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_line_follows_its_pull() {
    let _lab = Lab::enter();
    for line in [MAIN.line(0), MAIN.line(31), AUX.line(6)] {
        for level in [true, false, true] {
            line.pull(level);
            assert_eq!(line.value(), level, "{line}");
        }
    }
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_test_finds_every_line_as_a_free_input() {
    let lab = Lab::enter();
    Output::take(MAIN.line(3)).set(true);
    MAIN.line(5).pull(true);
    lab.wire(MAIN.line(3), AUX.line(1));
    let directions =
        || fs::read_to_string("/sys/kernel/debug/gpio").unwrap().matches(" input,pull-down").count();
    assert!(directions() < 40);
    drop(lab);
    let _lab = Lab::enter();
    assert_eq!((directions(), fs::read_to_string("/run/lab/wires").unwrap().as_str()), (40, ""));
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_wired_line_has_moved_when_the_call_returns() {
    let lab = Lab::enter();
    lab.wire(MAIN.line(3), AUX.line(1));
    lab.wire_inverted(MAIN.line(3), MAIN.line(4));
    let output = Output::take(MAIN.line(3));
    for level in [true, false, true] {
        output.set(level);
        assert_eq!((MAIN.line(3).value(), AUX.line(1).value(), MAIN.line(4).value()), (level, level, !level));
    }
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_stalled_call_hangs_before_the_line_moves_and_only_that_call_does() {
    let lab = Lab::enter();
    let stalled = Duration::from_millis(500);
    let (output, other) = (Output::take(MAIN.line(3)), Output::take(AUX.line(3)));
    for call in [Call::Set, Call::Get] {
        output.set(false);
        lab.stall(MAIN, call, stalled, 1);
        let begin = Instant::now();
        thread::scope(|scope| {
            let hung = scope.spawn(|| match call {
                Call::Set => output.set(true),
                Call::Get => assert!(!output.get()),
            });
            wait_for("the call is inside", PATIENCE, || lab.inside(MAIN, call) == 1);
            // Another chip and other calls on this one go on meanwhile.
            other.set(true);
            assert!(AUX.line(3).value() && other.get());
            MAIN.line(5).pull(true);
            assert!(MAIN.line(5).value() && !MAIN.line(3).value());
            assert_eq!(lab.inside(MAIN, call), 1, "the call came back before the other ones were done");
            hung.join().unwrap();
        });
        // The kernel sleeps by its ticks, which an emulated machine that stood still has to catch up with.
        assert!(begin.elapsed() >= stalled - Duration::from_millis(50));
        assert_eq!(output.get(), call == Call::Set);
        assert_eq!(lab.inside(MAIN, call), 0);
    }
}

/// Whoever makes lines safe has to know this: a copy of a claim is of no use for driving while a call on the claim
/// hangs, but it is for reading, and other claims on the chip are for both.
#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_hung_set_call_holds_up_other_set_calls_of_its_claim_and_nothing_else() {
    use gpiocdev::line::Value::{Active, Inactive};
    let lab = Lab::enter();
    let claim = |line: u32| {
        let request =
            gpiocdev::Request::builder().on_chip(MAIN.path()).with_line(line).as_output(Inactive).request();
        request.unwrap()
    };
    let (hung, other) = (claim(3), claim(4));
    let begin = Instant::now();
    let stalled = Duration::from_millis(800);
    lab.stall(MAIN, Call::Set, stalled, 1);
    thread::scope(|scope| {
        let inside = scope.spawn(|| hung.set_value(3, Active).unwrap());
        wait_for("the call is inside", PATIENCE, || lab.inside(MAIN, Call::Set) == 1);
        assert_eq!(hung.value(3).unwrap(), Inactive);
        other.set_value(4, Active).unwrap();
        assert!(MAIN.line(4).value() && lab.inside(MAIN, Call::Set) == 1, "the other claim had to wait");
        hung.set_value(3, Inactive).unwrap();
        assert!(begin.elapsed() >= stalled, "the second call of the claim did not wait for the first");
        inside.join().unwrap();
    });
    assert!(!MAIN.line(3).value());
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_chip_of_the_tests_own_comes_and_goes() {
    let _lab = Lab::enter();
    let chip = SimChip::add("passing", &["FIRST", ""]);
    chip.pull(0, true);
    assert!(chip.value(0) && !chip.value(1) && chip.path().exists());
    chip.vanish();
    assert!(!chip.path().exists());
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn resets_run_again_in_the_next_boot() {
    let lab = Lab::enter();
    if lab.boot() == 1 {
        // At once, as a watchdog does it.
        fs::write("/proc/sysrq-trigger", "b").unwrap();
        wait_for("the machine is reset", PATIENCE, || false);
    }
    assert_eq!(lab.boot(), 2);
}
