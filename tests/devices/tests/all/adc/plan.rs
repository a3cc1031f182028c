//! One plan in virtual time and over a converter.

use devices::{ADS8688, Lab, MAIN, bind_spi, rig};
use std::path::Path;
use std::process::{Command, Output};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

const MODELLED: &str = r#"format = 1
title = "An oven that is a plant"
[board]
kind = "simulated"
[channels]
temperature = { kind = "analog", unit = "degC" }
[[plants]]
kind = "lag"
name = "oven"
input = "Q4"
output = "temperature"
low = 20.0
high = 80.0
tau = "20 ms"
sample = "10 ms"
"#;

const REAL: &str = r#"format = 1
title = "An oven behind a converter"
[board]
kind = "real"
unresponsive-after = "10 s"
[chips]
main = { label = "rig-gpio" }
[converters]
adc = { kind = "spi", path = "/dev/spidev0.1", part = "ads8688", period = "250 ms" }
[channels]
Q4 = { kind = "digital", line = 8, safe = false }
[channels.temperature]
kind = "analog"
unit = "degC"
input = 0
range = "0 V .. 10.24 V"
scale = { from = ["0 V", "10 V"], to = ["0 degC", "100 degC"] }
calibration = { points = [[20, 20], [80, 80]], date = "2020-01-31", expires = "2021-01-31", by = "the laboratory" }
deadband = "0.1 degC"
[channels.narrow]
kind = "analog"
unit = "degC"
input = 1
range = "0 V .. 5.12 V"
scale = { from = ["0 V", "10 V"], to = ["0 degC", "100 degC"] }
[channels.vague]
kind = "analog"
unit = "degC"
input = 2
range = "0 V .. 10.24 V"
scale = { from = ["0 V", "10 V"], to = ["0 degC", "100 degC"] }
accuracy = { of-value = "0.5 %", of-range = "0.1 %", plus = "0.2 degC" }
[channels.loose]
kind = "analog"
unit = "bar"
input = 3
scale = { shunt = "250 Ohm", from = ["4 mA", "20 mA"], to = ["0 bar", "16 bar"] }
open-below = "3.6 mA"
[guard]
limit = "10 s"
hold = "1 h"
[realtime]
late = "10 s"
"#;

const PROGRAM: &str = "\
PROGRAM MAIN
VAR
    heater AT %QX0.4 : BOOL;
    wait : TON;
END_VAR
wait(IN := TRUE, PT := T#1s);
heater := wait.Q;
END_PROGRAM
";

const PLAN: &str = r#"format = 1
title = "The oven becomes warm by its heater"
program = "main.st"
signals = { heater = "%QX0.4", temperature = "temperature" }
ends = "start + 4 s"
expect = [
  { rises = { signal = "heater", from = "start", within = "900 ms .. 2 s" } },
  { value = { of = "temperature", near = "20 degC", tolerance = "0.5 degC", when = "start + 600 ms" } },
  { value = { of = "temperature", near = "80 degC", tolerance = "0.5 degC", when = "start + 3.9 s" } },
  { never = { signal = "temperature", min = "81 degC", from = "start", until = "end", pulses-longer-than = "600 ms" } },
]
"#;

/// What can be said of inputs that are too narrow for the oven, too coarse for the claim, or wired to nothing.
const BEYOND: &str = r#"format = 1
title = "Nothing can be said of this"
program = "main.st"
signals = { narrow = "narrow", vague = "vague", loose = "loose" }
ends = "start + 4 s"
expect = [
  { value = { of = "narrow", near = "80 degC", tolerance = "0.5 degC", when = "start + 3.9 s" } },
  { value = { of = "vague", near = "80 degC", tolerance = "0.5 degC", when = "start + 3.9 s" } },
  { value = { of = "vague", near = "80 degC", tolerance = "1 degC", when = "start + 3.9 s" } },
  { value = { of = "loose", max = "20 bar", when = "start + 2 s" } },
]
measure = [
  { name = "warmth", value-of = "vague", when = "start + 3.9 s", max = "85 degC" },
  { name = "pressure", value-of = "loose", when = "start + 3 s", max = "20 bar" },
]
"#;

/// What is said of a value that is not known well enough.
const NEARER: &str = "the value is nearer to the limit than the trace is exact";

/// Runs plans on a board file: exit code and all that was said.
fn test(board: &str, plans: &[&str]) -> (Option<i32>, String) {
    let mut words = vec!["test", "--board", "board.toml", "--report", "out"];
    words.extend(plans);
    let folder = Path::new("/tmp/oven");
    std::fs::create_dir_all(folder).unwrap();
    std::fs::write(folder.join("board.toml"), board).unwrap();
    std::fs::write(folder.join("main.st"), PROGRAM).unwrap();
    std::fs::write(folder.join("plan.toml"), PLAN).unwrap();
    std::fs::write(folder.join("beyond.toml"), BEYOND).unwrap();
    rig_says(folder, &words)
}

/// Runs the rig: exit code and all that was said.
fn rig_says(folder: &Path, words: &[&str]) -> (Option<i32>, String) {
    let ran =
        Command::new(rig()).args(words).current_dir(folder).env("XDG_STATE_HOME", folder).output().unwrap();
    let Output { status, stdout, stderr } = ran;
    (status.code(), format!("{}{}", String::from_utf8_lossy(&stdout), String::from_utf8_lossy(&stderr)))
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_plan_passes_in_virtual_time_and_over_a_converter_and_not_beyond_its_range() {
    let _lab = Lab::enter();
    bind_spi();
    let _ = ADS8688.reset();
    let (code, said) = test(MODELLED, &["plan.toml"]);
    assert_eq!(code, Some(0), "{said}");
    // The oven: it follows the heater's line.
    let over = Arc::new(AtomicBool::new(false));
    let oven = {
        let over = over.clone();
        thread::spawn(move || {
            while !over.load(Ordering::Acquire) {
                let volts = if MAIN.line(8).value() { 8.0 } else { 2.0 };
                (0..3).for_each(|input| ADS8688.volts(input, volts));
                thread::sleep(Duration::from_millis(5));
            }
        })
    };
    let (code, said) = test(REAL, &["plan.toml", "beyond.toml"]);
    over.store(true, Ordering::Release);
    oven.join().unwrap();
    assert_eq!(code, Some(3), "{said}");
    assert!(said.contains("1 passed, 0 failed, 1 inconclusive"), "{said}");
    assert!(said.contains("warning[B0125]"), "{said}");
    // 80 degC: 0.4 of the value, 0.1024 of the range, 0.2 beside them, and half a step.
    let judged = |said: &str| {
        for why in ["(`narrow` from ", ": at the upper end", NEARER, "(`loose` from ", ": its wire is open"] {
            assert!(said.contains(why), "{why}: {said}");
        }
        assert!(said.contains("80.00 ± 0.7"), "{said}");
    };
    judged(&said);
    let (code, said) = rig_says(Path::new("/tmp/oven"), &["judge", "beyond.toml", "out/traces/beyond.trace"]);
    assert_eq!(code, Some(3), "{said}");
    judged(&said);
}
