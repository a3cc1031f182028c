//! The projects that `rig new --template` makes: their files, their first run, and programs with a defect, which their plans
//! must notice.

use crate::project_folder::{TestProject, files};

/// A defect in the program of a template, and the case that has to fail by it.
struct Defect {
    /// What is taken out of the program, and what stands there then.
    part: &'static str,
    by: &'static str,
    fails: &'static str,
}

/// A template: its files beside those that every project has, how many cases it has, and defects of its program.
struct Template {
    name: &'static str,
    program: &'static str,
    files: &'static [&'static str],
    cases: usize,
    defects: &'static [Defect],
}

/// What every project has.
const COMMON: &[&str] = &[
    ".github/workflows/rig.yml",
    ".gitignore",
    ".gitlab-ci.yml",
    ".taplo.toml",
    "README.md",
    "schemas/board.schema.json",
    "schemas/included.schema.json",
    "schemas/plan.schema.json",
    "schemas/suite.schema.json",
    "suite.toml",
];

const MOTOR: Template = Template {
    name: "motor",
    program: "src/motor.st",
    files: &["boards/bench.toml", "plans/contactor.toml", "plans/start-stop.toml", "src/motor.st"],
    cases: 3,
    defects: &[Defect { part: "IF answer.Q THEN", by: "IF FALSE THEN", fails: "plans/contactor[held]" }],
};

const TANK: Template = Template {
    name: "tank",
    program: "src/level.st",
    files: &[
        "boards/tank.toml",
        "controller/tank.toml",
        "plans/broken-wire.toml",
        "plans/consumer.toml",
        "plans/fill.toml",
        "plans/high-level.toml",
        "plans/set-point.toml",
        "src/level.st",
    ],
    cases: 7,
    defects: &[
        Defect { part: "KP : REAL := 0.4;", by: "KP : REAL := -0.4;", fails: "plans/fill" },
        // Without its integral the controller leaves an error.
        Defect { part: "LIMIT(0.0, share + integral", by: "LIMIT(0.0, share", fails: "plans/consumer" },
        Defect { part: "level_status <> 0 OR ", by: "", fails: "plans/broken-wire[filling]" },
        Defect { part: " OR NOT below_high", by: "", fails: "plans/high-level" },
        Defect { part: "ELSIF reset THEN", by: "ELSE", fails: "plans/broken-wire[filling]" },
    ],
};

const CONVEYOR: Template = Template {
    name: "conveyor",
    program: "src/conveyor.st",
    files: &[
        "boards/conveyor.toml",
        "plans/count.toml",
        "plans/jam.toml",
        "plans/stop.toml",
        "src/conveyor.st",
    ],
    cases: 7,
    defects: &[
        Defect { part: " OR at_exit.Q", by: "", fails: "plans/jam[exit]" },
        Defect { part: "at_entry.Q OR ", by: "", fails: "plans/jam[entry]" },
        Defect { part: "IN := belt AND exit_eye", by: "IN := exit_eye", fails: "plans/stop[pressed]" },
        Defect { part: "IF leaves.Q THEN", by: "IF exit_eye THEN", fails: "plans/count[apart]" },
        Defect { part: "alarm OR NOT not_stopped", by: "alarm", fails: "plans/stop[broken]" },
    ],
};

const PRESS: Template = Template {
    name: "press",
    program: "src/press.st",
    files: &[
        "boards/press.toml",
        "plans/cycle.toml",
        "plans/failed.toml",
        "plans/light-curtain.toml",
        "plans/two-hands.toml",
        "src/press.st",
    ],
    cases: 12,
    defects: &[
        Defect {
            part: "NOT right_hand OR NOT clear",
            by: "NOT right_hand",
            fails: "plans/light-curtain[closing]",
        },
        Defect { part: "presses.Q OR NOT clear", by: "presses.Q", fails: "plans/light-curtain[closed]" },
        Defect { part: "IF one_hand.Q THEN", by: "IF FALSE THEN", fails: "plans/two-hands[late]" },
        Defect { part: "ELSIF closes.Q THEN", by: "ELSIF FALSE THEN", fails: "plans/failed[bottom-switch]" },
        Defect { part: "ELSIF opens.Q THEN", by: "ELSIF FALSE THEN", fails: "plans/failed[no-way-back]" },
        Defect { part: "armed := FALSE;\n        END_IF", by: "END_IF", fails: "plans/cycle[together]" },
    ],
};

/// Makes the project, compares its files, runs it, and runs the plans of each defect against the program that has it.
fn try_out(template: &Template) {
    let bench = TestProject::new();
    bench.expect(0, &["new", "site", "--template", template.name]);
    let mut expected: Vec<&str> = COMMON.iter().chain(template.files).copied().collect();
    expected.sort_unstable();
    assert_eq!(files(&bench.path("site")), expected);
    let readme = bench.read("site/README.md");
    assert!(readme.starts_with("# site\n") && !readme.contains("{{"), "{readme}");
    let checked = bench.expect(0, &["check", "site"]);
    assert_eq!(checked.err, "");
    let ran = bench.expect(0, &["test", "site"]).out;
    assert!(ran.contains(&format!("{} passed, 0 failed", template.cases)), "{ran}");
    let program = format!("site/{}", template.program);
    let right = bench.read(&program);
    for defect in template.defects {
        assert!(right.contains(defect.part), "{}: {}", template.name, defect.part);
        bench.write(&program, &right.replace(defect.part, defect.by));
        let only = format!("site/{}", defect.fails);
        let ran = bench.rig(&["test", "site", "--only", &only]);
        assert_eq!(ran.code, Some(1), "{} without {}\n{}{}", template.name, defect.part, ran.out, ran.err);
        assert!(ran.out.contains(&format!("✗ {only}")), "{}", ran.out);
    }
}

#[test]
fn the_motor_stops_without_an_answer() {
    try_out(&MOTOR);
}

#[test]
fn the_tank_keeps_its_level() {
    try_out(&TANK);
}

#[test]
fn the_conveyor_counts_and_notices_a_jam() {
    try_out(&CONVEYOR);
}

#[test]
fn the_press_closes_with_both_hands_alone() {
    try_out(&PRESS);
}

#[test]
fn a_template_that_does_not_exist_is_refused_with_those_that_do() {
    let bench = TestProject::new();
    bench
        .refused(&["new", "site", "--template", "boiler"], &["boiler", "motor", "tank", "conveyor", "press"]);
    assert!(!bench.path("site").exists());
}
