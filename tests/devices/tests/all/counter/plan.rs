//! One plan on modelled lines and over the lab's counter: claims about a count, and the model's fast counter fed with it.

use devices::{Counter, Lab, MAIN, rig};
use std::path::Path;
use std::process::{Command, Output};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

const MODELLED: &str = r#"format = 1
title = "A shaft that is modelled"
[board]
kind = "simulated"
[channels]
shaft = { kind = "count", of = ["I5", "I6"], function = "quadrature-x4" }
[bind]
"%IX0.0" = "shaft"
"#;

const REAL: &str = r#"format = 1
title = "A shaft on a counter of the kernel"
[board]
kind = "real"
unresponsive-after = "10 s"
[chips]
main = { label = "rig-gpio" }
[counters]
wheel = { name = "rig-counter", function = "quadrature-x4", period = "5 ms" }
[channels]
shaft = { kind = "count" }
Q1 = { kind = "digital", line = 8, safe = false }
[bind]
"%IX0.0" = "shaft"
[guard]
limit = "10 s"
hold = "1 h"
[realtime]
late = "10 s"
"#;

/// Its lamp says when the shaft is to be turned.
const PROGRAM: &str = "\
PROGRAM MAIN
VAR
    hsc : HSCMain_M241;
    wait : TON;
    turn AT %QX0.1 : BOOL;
END_VAR
hsc(HSC_REF_IN := HSC0, F_Enable := TRUE);
wait(IN := TRUE, PT := T#1s);
turn := wait.Q;
END_PROGRAM
";

/// What holds of the shaft, whoever turns it.
const CLAIMS: &str = r#"
format = 1
title = "A thousand quarters of a turn"
program = "main.st"
signals = { shaft = "shaft", value = "HSC0.value", lamp = "%QX0.1" }
ends = "start + 5 s"
settings = { expert = { HSC0 = { kind = "main-single", a = "%IX0.0", mode = "modulo-loop", modulo = 10000 } } }
expect = [
  { value = { of = "shaft", is = 1000, when = "end" } },
  { value = { of = "value", is = 1000, when = "end" } },
  { rises = { signal = "lamp", from = "start", within = "4 s" } },
  { becomes = { signal = "shaft", min = 500, from = "start", within = "5 s" } },
  { speed = { signal = "shaft", is = "200 Hz ± 1 %", from = "start", until = "end" } },
]
measure = [
  { name = "speed", speed-of = "shaft", from = "start", until = "end", nominal = "200 Hz", tolerance = "1 %" },
]
"#;

/// Runs the plan on a board file: exit code and all that was said.
fn test(board: &str, steps: &str) -> (Option<i32>, String) {
    let folder = Path::new("/tmp/shaft");
    std::fs::create_dir_all(folder).unwrap();
    std::fs::write(folder.join("board.toml"), board).unwrap();
    std::fs::write(folder.join("main.st"), PROGRAM).unwrap();
    std::fs::write(folder.join("plan.toml"), format!("{CLAIMS}{steps}")).unwrap();
    says(folder, &["test", "--board", "board.toml", "--report", "out", "plan.toml"])
}

fn says(folder: &Path, words: &[&str]) -> (Option<i32>, String) {
    let ran =
        Command::new(rig()).args(words).current_dir(folder).env("XDG_STATE_HOME", folder).output().unwrap();
    let Output { status, stdout, stderr } = ran;
    (status.code(), format!("{}{}", String::from_utf8_lossy(&stdout), String::from_utf8_lossy(&stderr)))
}

/// Does this once the lamp is on, while something runs.
fn when_on<T>(act: impl FnOnce() + Send, run: impl FnOnce() -> T) -> T {
    let over = Arc::new(AtomicBool::new(false));
    thread::scope(|scope| {
        let ended = over.clone();
        scope.spawn(move || {
            while !MAIN.line(8).value() {
                if ended.load(Ordering::Acquire) {
                    return;
                }
                thread::sleep(Duration::from_millis(5));
            }
            act();
        });
        let result = run();
        over.store(true, Ordering::Release);
        result
    })
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_plan_about_a_count_passes_on_modelled_lines_and_over_a_counter() {
    let _lab = Lab::enter();
    let counter = Counter::enter();
    let encoder = r#"
[[steps]]
id = "turn"
at = "start + 2 s"
encoder = { a = "I5", b = "I6", moves = { by = 1000, speed = "1 kHz" } }
"#;
    let (code, said) = test(MODELLED, encoder);
    assert_eq!(code, Some(0), "{said}");
    let (code, said) = when_on(|| counter.count(0).steps_at(1_000, 1_000), || test(REAL, ""));
    assert_eq!(code, Some(0), "{said}");
    // Judged again from the trace alone it is the same.
    let (code, said) = says(Path::new("/tmp/shaft"), &["judge", "plan.toml", "out/traces/plan.trace"]);
    assert_eq!(code, Some(0), "{said}");
    // One quarter more is one too many.
    let (code, said) = when_on(|| counter.count(0).steps_at(1_001, 1_000), || test(REAL, ""));
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains("1001"), "{said}");
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_counter_that_is_lost_makes_the_case_an_error() {
    let _lab = Lab::enter();
    let counter = Counter::enter();
    let (code, said) = when_on(|| counter.unbind(), || test(REAL, ""));
    counter.bind();
    assert_eq!(code, Some(4), "{said}");
    assert!(said.contains("channel shaft was lost") && said.contains("is gone"), "{said}");
}
