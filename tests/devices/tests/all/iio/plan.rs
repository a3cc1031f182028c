//! Plans over a converter of the kernel: what is claimed of a quantity, and what becomes of it.

use crate::rig::Rig;
use devices::{Adc, Lab, MAIN};

const BOARD: &str = r#"format = 1
title = "A tank behind a converter of the kernel"
[board]
kind = "real"
unresponsive-after = "10 s"
[chips]
main = { label = "rig-gpio" }
[converters]
adc = { kind = "iio", name = "rig-adc", period = "250 ms" }
[channels]
Q4 = { kind = "digital", line = 8, safe = false }
[channels.level]
kind = "analog"
unit = "m"
input = 2
scale = { from = ["0 V", "10 V"], to = ["0 m", "4 m"] }
deadband = "5 mm"
[guard]
limit = "5 s"
[realtime]
late = "10 s"
"#;

const PROGRAM: &str = "\
PROGRAM MAIN
VAR
    pump AT %QX0.4 : BOOL;
    wait : TON;
END_VAR
wait(IN := TRUE, PT := T#1s);
pump := wait.Q;
END_PROGRAM
";

/// The tank: 1 m, 3 m behind the pump. Each row claims something else of it.
const PLAN: &str = r#"format = 1
title = "The tank is filled"
program = "main.st"
signals = { pump = "%QX0.4", level = "level" }
ends = "start + 4 s"
expect = [
  { rises = { signal = "pump", from = "start", within = "900 ms .. 2 s" } },
  { value = { of = "level", near = "1 m", tolerance = "20 mm", when = "start + 600 ms" } },
  { value = { of = "level", near = "$full", tolerance = "20 mm", when = "start + 3.9 s" } },
  { never = { signal = "level", min = "$limit", from = "start", until = "end", pulses-longer-than = "600 ms" } },
]
[rows]
holds = { full = "3 m", limit = "3.1 m" }
other = { full = "2.9 m", limit = "3.1 m" }
above = { full = "3 m", limit = "2.9 m" }
"#;

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn limits_of_a_quantity_are_judged_over_a_converter_of_the_kernel() {
    let (_lab, adc) = (Lab::enter(), Adc::enter());
    let files = [("board.toml", BOARD), ("plan.toml", PLAN), ("main.st", PROGRAM)];
    let words = ["test", "--board", "board.toml", "--report", "report", "plan.toml"];
    adc.set(2, 2.5);
    let mut rig = Rig::start("tank", &files.map(|(name, text)| (name, text.to_owned())), &words);
    // The tank follows its pump.
    let mut full = false;
    while !rig.has_ended() {
        let pump = MAIN.line(8).value();
        if pump != full {
            adc.set(2, if pump { 7.5 } else { 2.5 });
            full = pump;
        }
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    assert_eq!(rig.exit_code(), Some(1), "{}", rig.said());
    let found = rig.cases();
    let verdicts: Vec<&str> = found.iter().map(|[verdict, ..]| verdict.as_str()).collect();
    assert_eq!(verdicts, ["pass", "fail", "fail"], "{}", rig.said());
    assert!(rig.said().contains("3 m"), "{}", rig.said());
}
