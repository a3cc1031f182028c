//! A rig whose tasks have something to do, with two ends of a CAN bus and plans.

use super::setup::DashboardSetup;
use crate::project_folder::TestProject;
use dash::glyphs::TerminalFeatures;

const BOARD: &str = r#"format = 1
title = "A shop floor"
[board]
kind = "simulated"
[channels]
button = { kind = "digital" }
lamp = { kind = "digital" }
[bind]
"%IX0.0" = "button"
"%QX0.4" = "lamp"
[buses]
machine = { kind = "can", bitrate = 500_000 }
drive = { kind = "can", joins = "machine" }
"#;

const PROGRAM: &str = "(* Three tasks of different weight; the lamp follows the button. *)
PROGRAM MAIN
VAR
    button AT %IX0.0 : BOOL;
    lamp AT %QX0.4 : BOOL;
    delay : TON;
    n, sum : DINT;
END_VAR
delay(IN := button, PT := T#500ms);
lamp := delay.Q;
FOR n := 1 TO 6000 DO
    sum := sum + n MOD 7;
END_FOR
END_PROGRAM

PROGRAM EDGES
VAR
    n, sum, turn : DINT;
END_VAR
turn := turn + 1;
FOR n := 1 TO 200 + 20 * (turn MOD 20) DO
    sum := sum + n;
END_FOR
END_PROGRAM

PROGRAM REPORT
VAR
    pages : UDINT;
END_VAR
pages := pages + 1;
END_PROGRAM
";

const CASE: &str = r#"format = 1
title = "The floor"
program = "floor.st"
expect = [{ state = { stays = "RUNNING" } }]

[settings.tasks]
MAST = { interval = "20 ms", priority = 15, programs = ["MAIN"], watchdog = "100 ms" }
FAST = { interval = "5 ms", priority = 1, programs = ["EDGES"], watchdog = "5 ms" }
FREE = { type = "freewheeling", priority = 31, programs = ["REPORT"] }
"#;

/// One that does not hold, one that waits for long.
pub const PLAN: &str = r#"format = 1
title = "The lamp of the floor"
program = "lamp.st"
signals = { button = "%IX0.0", lamp = "%QX0.4" }
ends = "$end"
steps = [
  { id = "press", at = "start + 1 s", set = { signal = "button", value = true } },
  { id = "let-go", at = "press + 1 s", set = { signal = "button", value = false } },
]
expect = [
  { name = "on", rises = { signal = "lamp", from = "press", within = "0 ms .. $most" } },
  { name = "off", falls = { signal = "lamp", from = "let-go", within = "50 ms" } },
]
measure = [
  { name = "delay", from = "press", to = { signal = "lamp", edge = "rises" }, min = "450 ms", max = "$most" },
]
[rows]
strict = { most = "500 ms", end = "start + 3 s" }
mild = { most = "520 ms", end = "start + 3 s" }
"#;

/// Frames of a drive, own ones and others.
pub const FRAMES: &str = r#"format = 1
title = "The drive says how fast it is"
program = "lamp.st"
ends = "more.done + 200 ms"
steps = [
  { id = "slow", at = "start + 100 ms", send = { frame = "slow", period = "200 ms", count = 3 } },
  { id = "order", at = "start + 150 ms", send = { frame = "order", period = "300 ms", count = 2 } },
  { id = "text", at = "start + 800 ms", send = { frame = "text" } },
  { id = "more", at = "text.done + 100 ms", send = { frame = "ask" } },
]
expect = [{ frames = { frame = "seen", count = 3 } }]
[frames]
slow = { bus = "drive", id = 0x18F, data = "0CFF00A5" }
seen = { bus = "machine", id = 0x18F, data = "0CFF00A5" }
order = { bus = "machine", id = 0x18FF50E5, extended = true, data = "0011223344556677" }
text = { bus = "drive", id = 0x7E8, data = "48656C6C6F" }
ask = { bus = "drive", id = 0x7DF, remote = true }
"#;

/// The floor.
pub fn floor(features: TerminalFeatures) -> DashboardSetup {
    let folder = TestProject::new();
    for (name, text) in [
        ("floor.board.toml", BOARD),
        ("floor.st", PROGRAM),
        ("floor.toml", CASE),
        ("plans/lamp.toml", PLAN),
        ("plans/lamp.st", crate::project_folder::LAMP_ST),
        ("plans/frames.toml", FRAMES),
    ] {
        folder.write(name, text);
    }
    DashboardSetup::of(folder, &["--board", "floor.board.toml", "--case", "floor", "--booted"], features)
}
