//! What goes wrong with chips and lines, and what is said of it.

use std::os::unix::process::CommandExt;
use std::process::Command;
use std::time::{Duration, Instant};

use super::bench::{BOTH, Bench};
use devices::{AUX, Call, Lab, MAIN, SimChip};
use drivers::{BoardError, BoardEvent, LossReason};
use signal::{Span, Time};

/// Codes and words of what is refused.
fn refused(text: &str) -> Vec<(String, String, String)> {
    let Err(found) = Bench::try_open(text) else { panic!("nothing is refused") };
    found.into_iter().map(|one| (one.code.to_owned(), one.message, one.help)).collect()
}

/// A board file with one chip and one channel.
fn file(chip: &str, line: &str) -> String {
    format!(
        "format = 1\n[board]\nkind = \"real\"\n[chips]\nmain = {{ {chip} }}\n[channels]\n\
         a = {{ kind = \"digital\", {line} }}\n"
    )
}

/// The one thing that is refused: its code, and words that message and help contain.
fn one(text: &str, code: &str, message: &str, help: &str) {
    let found = refused(text);
    let [(was, words, said)] = &found[..] else { panic!("{found:#?}") };
    assert_eq!(was, code, "{words}");
    assert!(words.contains(message) && said.contains(help), "{words}\n{said}");
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn chips_and_lines_that_are_not_there_are_named_with_what_was_meant() {
    let _lab = Lab::enter();
    let main = "label = \"rig-gpio\"";
    one(&file("label = \"rig-gpoi\"", "line = 0"), "B0170", "rig-gpoi", "did you mean \"rig-gpio\"");
    one(&file("name = \"gpiochip17\"", "line = 0"), "B0170", "gpiochip17", "gpiochip1");
    one(&file("path = \"/dev/null\"", "line = 0"), "B0170", "opening /dev/null failed", "rig board scan");
    one(&file("path = \"/dev/nowhere\"", "line = 0"), "B0170", "No such file", "");
    one(&file(main, "line = 32"), "B0172", "has no line 32", "0 to 31");
    one(&file(main, "line = \"DOR\""), "B0172", "no line named DOR", "did you mean DOOR");
    let twice = format!("{}b = {{ kind = \"digital\", line = \"DOOR\" }}\n", file(main, "line = 24"));
    one(&twice, "B0164", "number 24", "");
    let v1 = file(main, "line = 0, debounce = \"1 ms\"").replace("\"real\"", "\"real\"\nbackend = \"v1\"");
    one(&v1, "B0176", "cannot debounce", "v2");
    // A link leads to the chip, and a line may be named on the one chip as on the other.
    let linked = file("path = \"/dev/rig/gpio1\"", "line = \"VALVE\", drives = true");
    let bench = Bench::open(&linked);
    assert_eq!(bench.board.output_claims().unwrap().len(), 1);
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_busy_line_names_its_holder() {
    let _lab = Lab::enter();
    one(&file("label = \"rig-gpio-aux\"", "line = 7"), "B0174", "line 7 (HOGGED)", "");
    one(
        &file("label = \"rig-gpio-aux\"", "line = \"HOGGED\""),
        "B0174",
        "held by lab-hog",
        "end that program",
    );
    for backend in BOTH {
        let text = file("label = \"rig-gpio\"", "line = 3, drives = true");
        let text =
            text.replace("\"real\"\n", &format!("\"real\"\nconsumer = \"first\"\nbackend = \"{backend}\"\n"));
        let first = Bench::open(&text);
        one(&text, "B0174", "line 3 of /dev/gpiochip0 (rig-gpio) is held by first", "");
        drop(first);
        Bench::open(&text);
    }
}

/// What `a_chip_that_may_not_be_opened_says_so` runs as somebody else.
#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn as_nobody() {
    if std::env::var_os("AS_NOBODY").is_some() {
        one(&file("label = \"rig-gpio\"", "line = 0"), "B0175", "Permission denied", "usermod");
        one(&file("path = \"/dev/rig/gpio0\"", "line = 0"), "B0175", "Permission denied", "ls -l");
        let listed = drivers::gpio::list().unwrap();
        assert!(listed.iter().all(Result::is_err) && !listed.is_empty());
    }
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_chip_that_may_not_be_opened_says_so() {
    let _lab = Lab::enter();
    let ran = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "gpio::trouble::as_nobody", "--include-ignored", "--nocapture"])
        .env("AS_NOBODY", "1")
        .uid(65_534)
        .gid(65_534)
        .output()
        .unwrap();
    assert!(
        ran.status.success(),
        "{}{}",
        String::from_utf8_lossy(&ran.stdout),
        String::from_utf8_lossy(&ran.stderr)
    );
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_chip_that_vanishes_is_lost_and_can_come_back() {
    let _lab = Lab::enter();
    for backend in BOTH {
        let chip = SimChip::add("rig-gpio-gone", &["", "", "", ""]);
        let text = format!(
            "format = 1\n[board]\nkind = \"real\"\nreconnect = true\nbackend = \"{backend}\"\n[chips]\ngone = {{ label = \"rig-gpio-gone\" }}\n\
             main = {{ label = \"rig-gpio\" }}\n[channels]\n\
             out = {{ kind = \"digital\", chip = \"gone\", line = 0, drives = true }}\n\
             in = {{ kind = \"digital\", chip = \"gone\", line = 1 }}\n\
             b = {{ kind = \"digital\", chip = \"gone\", line = 2 }}\n\
             stays = {{ kind = \"digital\", chip = \"main\", line = 0 }}\n"
        );
        let mut bench = Bench::open(&text);
        bench.start();
        bench.write(&[("out", true)]);
        chip.pull(1, true);
        bench.until_level("in", true);
        chip.vanish();
        bench.until("all its channels are lost", |bench| bench.board.health().lost == 3);
        for name in ["out", "in", "b"] {
            let id = bench.channel(name);
            let lost = |event: &&BoardEvent| matches!(event, BoardEvent::Lost { channel, reason: LossReason::Gone, .. } if *channel == id);
            assert_eq!(bench.events.iter().filter(lost).count(), 1, "{backend}: {name}");
        }
        assert!(!bench.board.health().is_sound());
        // The other chip goes on.
        MAIN.line(0).pull(true);
        bench.until_level("stays", true);
        let now = bench.now();
        assert!(matches!(bench.board.safe(now), Err(BoardError::Os { code: 19, .. })), "{backend}");
        let started = bench.board.start(now);
        assert!(matches!(started, Err(BoardError::Lost { reason: LossReason::Gone, .. })), "{started:?}");
        drop(chip);
        let chip = SimChip::add("rig-gpio-gone", &["", "", "", ""]);
        chip.pull(1, true);
        bench.events.clear();
        bench.start();
        assert_eq!((bench.level("in"), bench.board.health().is_sound()), (Some(true), true), "{backend}");
        chip.pull(1, false);
        bench.until_level("in", false);
        MAIN.line(0).pull(false);
    }
}

const TWO_CHIPS: &str = "format = 1\n[board]\nkind = \"real\"\n[chips]\nmain = { label = \"rig-gpio\" }\n\
     aux = { label = \"rig-gpio-aux\" }\n[channels]\n\
     out = { kind = \"digital\", chip = \"main\", line = 1, drives = true }\n\
     in = { kind = \"digital\", chip = \"main\", line = 2 }\n\
     more = { kind = \"digital\", chip = \"main\", line = 3 }\n\
     far = { kind = \"digital\", chip = \"aux\", line = 1, drives = true }\n";

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_call_that_hangs_holds_up_nobody_and_its_chip_is_lost_until_it_ends() {
    let lab = Lab::enter();
    for call in [Call::Set, Call::Get] {
        let mut bench = Bench::open(TWO_CHIPS);
        bench.start();
        lab.stall(MAIN, call, Duration::from_secs(2), 1);
        let begin = Instant::now();
        bench.write(&[("out", true)]);
        bench.poll();
        assert!(begin.elapsed() < Duration::from_millis(500), "the board waited for the device");
        bench.until("it is lost", |bench| bench.board.health().lost == 3);
        let (id, asked) = (bench.channel("out"), Time::ZERO);
        let lost = bench.events.iter().find_map(|event| match event {
            BoardEvent::Lost { channel, at, reason: LossReason::Unresponsive } if *channel == id => Some(*at),
            _ => None,
        });
        assert!(lost.unwrap() >= asked + Span::from_millis(100));
        // The other chip, and edges of this one, come all the same.
        bench.write(&[("far", true)]);
        bench.until_level("far", true);
        MAIN.line(2).pull(true);
        bench.until_level("in", true);
        assert!(AUX.line(1).value() && begin.elapsed() < Duration::from_millis(1_900));
        // What cannot be made safe is said, in time; it is made safe as soon as it can be.
        let begin = Instant::now();
        let now = bench.now();
        let safe = bench.board.safe(now);
        assert!(matches!(safe, Err(BoardError::Os { code: 110, .. })), "{call:?}: {safe:?}");
        assert!(begin.elapsed() < Duration::from_millis(600) && !AUX.line(1).value());
        bench.until("it answers again", |bench| bench.board.health().lost == 0);
        bench.until("it is safe", |_| !MAIN.line(1).value());
        let back = bench
            .events
            .iter()
            .any(|event| matches!(event, BoardEvent::Returned { channel, .. } if *channel == id));
        assert!(back, "{call:?}");
        MAIN.line(2).pull(false);
    }
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_change_that_a_slow_call_swallows_is_reported() {
    let lab = Lab::enter();
    let text = TWO_CHIPS.replace("\"real\"\n", "\"real\"\nunresponsive-after = \"10 s\"\n");
    let mut bench = Bench::open(&text);
    bench.start();
    lab.stall(MAIN, Call::Set, Duration::from_millis(500), 1);
    bench.write(&[("out", true)]);
    bench.until("the call hangs", |_| lab.inside(MAIN, Call::Set) == 1);
    for high in [false, true, false, true] {
        bench.write(&[("out", high)]);
    }
    bench.write(&[("out", true), ("far", true)]);
    bench.until("it is told", |bench| bench.seen("out").dropped > 0);
    bench.until_level("far", true);
    assert_eq!(bench.level("out"), Some(true), "the newest image is what is driven");
    assert!(MAIN.line(1).value() && !bench.board.health().is_sound());
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_board_that_is_dropped_leaves_its_outputs_safe() {
    let lab = Lab::enter();
    lab.wire(MAIN.line(1), MAIN.line(9));
    for backend in BOTH {
        let mut bench = Bench::of_main(backend, "out = { kind = \"digital\", line = 1, drives = true }");
        bench.start();
        bench.write(&[("out", true)]);
        bench.until("it is driven", |_| MAIN.line(9).value());
        let held = bench.board.output_claims().unwrap();
        drop(bench);
        assert!(!MAIN.line(9).value(), "{backend}");
        drop(held);
    }
}
