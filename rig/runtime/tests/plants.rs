//! Steps that set parameters of plants: as they are checked before anything moves, and with a controller that is not the rig's own.

use std::sync::atomic::AtomicBool;

use crate::texts::{Texts, expect};
use record::Verdict;
use scanrig_runtime::case::check_case;
use scanrig_runtime::{ClockKind, RunOptions};

const BOARD: &str = "format = 1
title = \"A bench\"
[board]
kind = \"simulated\"
[channels]
level = { kind = \"analog\", unit = \"m\" }
signal = { kind = \"analog\", unit = \"mA\" }
copy = { kind = \"analog\", unit = \"mA\" }
[[plants]]
kind = \"tank\"
name = \"tank\"
area = \"1 m2\"
height = \"2 m\"
inflows = [{ channel = \"Q0\", flow = \"6 l/min\" }]
output = \"level\"
sample = \"1 s\"
[[plants]]
kind = \"transmitter\"
name = \"level\"
input = \"level\"
output = \"signal\"
range = \"0 .. 2 m\"
signal = \"4 .. 20 mA\"
sample = \"1 s\"
[[plants]]
kind = \"dead-time\"
name = \"pipe\"
input = \"signal\"
output = \"copy\"
delay = \"1 s\"
";

/// What the check says of a plan that sets a parameter, with its help.
fn found(board: &str, plant: &str, parameter: &str, value: &str) -> Vec<String> {
    let plan = format!(
        "format = 1\ntitle = \"A plan\"\nprogram-text = \"PROGRAM MAIN END_PROGRAM\"\nboard = \"board.toml\"\n\
         steps = [{{ id = \"set\", at = \"start + 1 s\", set-plant = {{ plant = \"{plant}\", parameter = \"{parameter}\", value = {value} }} }}]\n\
         expect = [{{ state = {{ stays = \"RUNNING\" }} }}]\n"
    );
    let (loaded, jobs) = Texts(&[("plan.toml", &plan), ("board.toml", board)]).load(1);
    let case = loaded.plan.case(0).unwrap();
    let files = loaded.files(&case, &jobs[0]).unwrap();
    let (Ok(found) | Err(found)) = check_case(&case, &files);
    found.iter().map(|one| format!("{} {}: {}", one.code, one.message, one.help)).collect()
}

#[test]
fn parameters_of_plants_are_checked() {
    let none: [&str; 0] = [];
    assert_eq!(found(BOARD, "tank", "inflow", "\"1 m3/h\""), none);
    assert_eq!(found(BOARD, "level", "broken", "true"), none);
    assert_eq!(found(BOARD, "level", "broken", "1"), none);
    assert_eq!(found(BOARD, "level", "drift", "\"-1 mm/h\""), none);
    let wrong = [
        ("tan", "inflow", "0", "R0331 the board has no plant `tan`: did you mean `tank`?"),
        ("tank", "inflw", "0", "R0332 the plant `tank` has no parameter `inflw`: did you mean `inflow`?"),
        ("tank", "stuck", "0", "R0332 the plant `tank` has no parameter `stuck`: there are inflow, leak"),
        ("pipe", "delay", "0", "R0332 the plant `pipe` has no parameter `delay`: none of it can be set"),
        (
            "tank",
            "leak",
            "2",
            "R0333 `leak` of the plant `tank` cannot be 2: write a flow such as \"2 l/min\" or \"7.2 m3/h\"",
        ),
        (
            "tank",
            "leak",
            "\"-2 l/min\"",
            "R0333 `leak` of the plant `tank` cannot be -2 l/min: write 0 to 1000000 m3/s",
        ),
        (
            "level",
            "gain",
            "\"2 V\"",
            "R0333 `gain` of the plant `level` cannot be 2 V: write a number without a unit, such as 1.5",
        ),
        ("level", "broken", "2", "R0333 `broken` of the plant `level` cannot be 2: write true or false"),
        (
            "level",
            "broken",
            "\"2 s\"",
            "R0333 `broken` of the plant `level` cannot be 2 s: write true or false",
        ),
    ];
    for (plant, parameter, value, report) in wrong {
        assert_eq!(found(BOARD, plant, parameter, value), [report]);
    }
    let twice = BOARD.replace("name = \"level\"", "name = \"tank\"");
    assert!(
        found(&twice, "tank", "leak", "0")[0]
            .starts_with("R0331 several plants of the board are called `tank`")
    );
    let empty = &BOARD[..BOARD.find("[[plants]]").unwrap()];
    assert!(
        found(empty, "tank", "leak", "0")[0]
            .starts_with("R0331 the board has no plant `tank`: give the plan")
    );
}

/// A controller whose program lets Q4 follow I0 within 20 ms, and an oven at Q4 that is the bench's.
const EXTERNAL: &str = "format = 1
[board]
kind = \"simulated\"
[subject]
kind = \"external\"
power = \"supply\"
alarm = \"running\"
off = \"2 s\"
[channels]
supply = { kind = \"digital\", safe = false }
running = { kind = \"digital\" }
warmth = { kind = \"analog\", unit = \"degC\" }
[[wires]]
from = \"supply\"
to = \"running\"
delay = \"1500 ms\"
[[wires]]
from = \"I0\"
to = \"Q4\"
delay = \"20 ms\"
[[plants]]
kind = \"lag\"
name = \"oven\"
input = \"Q4\"
output = \"warmth\"
low = 20
high = 100
tau = \"1 ms\"
sample = \"1 ms\"
";

#[test]
fn a_plant_at_a_real_controller_is_set_as_any_other() {
    let plan = "format = 1
title = \"A plan\"
program-text = \"PROGRAM MAIN lamp := button; END_PROGRAM\"
board = \"board.toml\"
signals = { button = \"%IX0.0\", warmth = \"warmth\" }
steps = [
  { id = \"heat\", at = \"start + 1 s\", set = { signal = \"button\", value = true } },
  { id = \"weak\", at = \"heat + 1 s\", set-plant = { plant = \"oven\", parameter = \"high\", value = \"60 degC\", duration = \"1 s\" } },
]
ends = \"weak.done + 1 s\"
expect = [
  { stays = { signal = \"warmth\", is = \"100 degC\", from = \"heat + 100 ms\", until = \"weak\" } },
  { stays = { signal = \"warmth\", is = \"60 degC\", from = \"weak + 100 ms\", until = \"weak.done\" } },
  { stays = { signal = \"warmth\", is = \"100 degC\", from = \"weak.done + 100 ms\" } },
]
";
    let interrupt = AtomicBool::new(false);
    let options = RunOptions::new(ClockKind::Virtual, &interrupt);
    let result = Texts(&[("plan.toml", plan), ("board.toml", EXTERNAL)]).run(1, &options);
    expect(&result, Verdict::Pass);
}
