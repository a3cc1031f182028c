//! Suite files and alarms by the command.

use crate::project_folder::{LAMP, LAMP_ST, TestProject};

const SUITE: &str = "format = 1
signals = { lamp = \"%QX0.4\", button = \"%IX0.0\" }
invariants = [
  { name = \"no lamp without a button\", stays = { signal = \"lamp\", is = false, until = \"start + 1 s\" } },
]
alarms = [
  { name = \"lit for long\", when = { signal = \"lamp\", is = true }, delay = \"300 ms\" },
]
";

/// A project with a suite above two folders of plans.
fn project() -> TestProject {
    let bench = TestProject::new();
    bench.write("plans/suite.toml", &SUITE.replace(", button = \"%IX0.0\"", ""));
    bench.write("plans/inner/lamp.toml", LAMP);
    bench.write("plans/inner/lamp.st", LAMP_ST);
    bench
}

#[test]
fn an_alarm_of_a_suite_ends_the_case_and_says_so() {
    let bench = project();
    let ran = bench.rig(&["test", "plans/inner/lamp.toml", "--report", "out"]);
    assert_eq!(ran.code, Some(1));
    for text in [
        "why  lit for long: the alarm was raised 1.8",
        "expected      `lamp` is not TRUE for 300 ms",
        "until the end",
        "in            plans/suite.toml:7",
    ] {
        assert!(ran.out.contains(text), "{text}: {}", ran.out);
    }
    assert!(!ran.out.contains("no lamp without a button"), "it holds: {}", ran.out);
    // Again from the trace, without the suite.
    std::fs::remove_file(bench.path("plans/suite.toml")).unwrap();
    let again = bench.rig(&["judge", "plans/inner/lamp.toml", "out/traces/plans_inner_lamp.trace"]);
    assert_eq!(again.code, Some(1));
    assert!(again.out.contains("lit for long: the alarm was raised 1.8"), "{}", again.out);
}

#[test]
fn the_suites_of_a_plan_do_not_depend_on_how_it_is_named() {
    let bench = project();
    for paths in [["plans"], ["plans/inner"], ["plans/inner/lamp.toml"]] {
        let ran = bench.rig(&["test", paths[0]]);
        assert!(ran.out.contains("lit for long"), "{paths:?}: {}", ran.out);
        assert!(ran.out.contains("1 failed"), "the suite is no plan: {}", ran.out);
    }
}

#[test]
fn what_is_wrong_with_a_suite_is_said_once() {
    let bench = project();
    bench.write("plans/inner/second.toml", LAMP);
    bench.write("plans/suite.toml", &SUITE.replace("stays", "stay"));
    for command in ["check", "test"] {
        let ran = bench.rig(&[command, "plans"]);
        assert_eq!(ran.code, Some(2), "{}", ran.err);
        assert_eq!(ran.err.matches("P0502").count(), 1, "{}", ran.err);
    }
    // A name that the suite does not use is worth a warning, once.
    bench.write("plans/suite.toml", SUITE);
    assert_eq!(bench.rig(&["check", "plans"]).err.matches("P0623").count(), 1);
    let alone = bench.rig(&["check", "plans/suite.toml"]);
    assert!(alone.code == Some(0) && alone.err.contains("`button` is bound and never used"), "{}", alone.err);
}
