//! How a counter is set up, and what is said where it cannot be.

use super::bench::{Bench, PATIENT, file, open};
use crate::rig::Rig;
use devices::{Counter, Lab, rig};
use document::Diagnostic;
use drivers::BoardExt;
use rustix::process::Signal;
use std::process::Command;

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_counter_is_set_up_and_set_back() {
    let lab = Lab::enter();
    let counter = Counter::enter();
    let count = counter.count(1);
    count.set("enable", "0");
    let says = || ["function", "ceiling", "enable", "signal3_action"].map(|file| count.says(file));
    let before = says();
    let of = "count = \"Count 1\", function = \"increase\", edge = \"both\", ceiling = 65535, counts-up-to = \"10 kHz\"";
    let bench = Bench::on(&file(PATIENT.replace("30 s", "1 s").as_str(), of), counter, lab);
    assert_eq!(says(), ["increase", "65535", "1", "both edges"]);
    assert_eq!(bench.board.device(drivers::ChannelId(0)), Some("/dev/counter0 (rig-counter)"));
    let Bench { board, counter, .. } = bench;
    drop(board);
    assert_eq!(says()[..3], before[..3]);
    counter.count(1).set("enable", "1");
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_counter_that_cannot_be_had_says_why() {
    let _lab = Lab::enter();
    let _counter = Counter::enter();
    let refusal = |of: &str| -> Diagnostic { open(&file(PATIENT, of)).unwrap_err().remove(0) };
    for (of, code, words) in [
        ("count = 7", "B0210", "has no count 7"),
        ("count = \"Count 7\"", "B0210", "its counts are 0 (\"Count 0\"), 1 (\"Count 1\")"),
        ("function = \"decrease\"", "B0211", "quadrature-x1, quadrature-x2, quadrature-x4"),
        ("ceiling = 999", "B0214", "wraps at 999"),
        ("ceiling = 999, counts-up-to = \"100 kHz\"", "B0214", "at 100000 counts a second"),
    ] {
        let found = refusal(of);
        assert_eq!(found.code, code, "{found:?}");
        let said = format!("{} {}", found.message, found.help);
        assert!(said.contains(words), "{said}");
    }
    // What was set on the way is set back.
    assert_eq!(_counter.count(0).says("ceiling"), "4294967295");
    // Nobody but the rig has a rule against a second reader of events; the kernel hands each to one.
    let missing = file(PATIENT, "period = \"5 ms\"");
    _counter.unbind();
    let found = open(&missing).unwrap_err().remove(0);
    assert_eq!(found.code, "B0208", "{found:?}");
    _counter.bind();
}

/// Runs the rig: exit code and all that was said.
fn rig_says(words: &[&str]) -> (Option<i32>, String) {
    let out =
        Command::new(rig()).args(words).current_dir("/tmp").env("XDG_STATE_HOME", "/tmp").output().unwrap();
    let said = [out.stdout, out.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
    (out.status.code(), said.concat())
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn the_board_commands_know_counters() {
    let _lab = Lab::enter();
    let counter = Counter::enter();
    let (code, said) = rig_says(&["board", "scan"]);
    assert_eq!(code, Some(0), "{said}");
    for line in [
        "rig-counter-1 = { name = \"rig-counter\", count = 1, function = \"quadrature-x4\", period = \"100 ms\" }",
        "rig-counter-0-count = { kind = \"count\", counter = \"rig-counter-0\" }",
    ] {
        assert!(said.contains(line), "{line}: {said}");
    }
    let board = format!(
        "format = 1\n[board]\nkind = \"real\"\n{PATIENT}\n[counters]\nwheel = {{ name = \"rig-counter\" }}\n\
         [channels]\nshaft = {{ kind = \"count\" }}\n"
    );
    std::fs::write("/tmp/counter.toml", &board).unwrap();
    let (code, said) = rig_says(&["board", "check", "counter.toml"]);
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("shaft  count 0 of /dev/counter0 (rig-counter), quadrature x4"), "{said}");
    counter.count(0).steps_at(100_000, 100);
    // It is watched until it has been seen to count, however long that takes: an emulated machine may stand still.
    let mut rig = Rig::start("watch", &[("counter.toml", board)], &["board", "watch", "counter.toml"]);
    let counts = || -> Vec<i64> {
        let said = rig.said();
        said.lines().filter_map(|line| line.split_once("  shaft  ")?.1.trim().parse().ok()).collect()
    };
    rig.until("the shaft has turned", || counts().len() > 3);
    let counts = counts();
    rig.signal(Signal::INT);
    assert_eq!(rig.exit_code(), Some(0), "{}", rig.said());
    assert!(counts.is_sorted() && counts[0] == 0, "{}", rig.said());
}
