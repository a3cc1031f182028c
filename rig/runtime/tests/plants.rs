//! Steps that set parameters of plants, as they are checked before anything moves.

use crate::texts::Texts;

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
    let (Ok(found) | Err(found)) = Texts(&[("plan.toml", &plan), ("board.toml", board)]).checked();
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
