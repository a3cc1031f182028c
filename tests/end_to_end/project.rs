//! What the command writes for a project: a new one, the shipped plans, schemas, completions and pages of the manual.

use crate::project_folder::{TestProject, files, root};
use serde_json::Value as Json;

#[test]
fn the_first_run_of_a_new_project_passes() {
    let bench = TestProject::new();
    bench.expect(0, &["new", "site/press"]);
    let expected = [
        ".github/workflows/rig.yml",
        ".gitignore",
        ".gitlab-ci.yml",
        ".taplo.toml",
        "README.md",
        "boards/bench.toml",
        "plans/contactor.toml",
        "plans/start-stop.toml",
        "schemas/board.schema.json",
        "schemas/included.schema.json",
        "schemas/plan.schema.json",
        "schemas/suite.schema.json",
        "src/motor.st",
        "suite.toml",
    ];
    assert_eq!(files(&bench.path("site/press")), expected);
    assert!(bench.read("site/press/README.md").starts_with("# press\n"));
    let checked = bench.expect(0, &["check", "site/press"]);
    assert_eq!(checked.err, "");
    assert!(bench.expect(0, &["test", "site/press"]).out.contains("3 passed, 0 failed"));
    // As the jobs of the CI servers do it, from within; the report is not taken for a part of the project.
    let mut within = bench.command(&["test", ".", "--report", "report"]);
    within.current_dir(bench.path("site/press"));
    assert!(within.output().unwrap().status.success());
    assert!(bench.path("site/press/report/junit.xml").is_file());
    for kind in ["plan", "board", "suite", "included"] {
        assert_eq!(
            bench.read(&format!("site/press/schemas/{kind}.schema.json")),
            bench.expect(0, &["schema", kind]).out
        );
    }
}

#[test]
fn a_new_project_writes_over_nothing() {
    let bench = TestProject::new();
    bench.refused(&["new", "."], &["R0150", "is not empty", "it has `lamp.st`"]);
    bench.refused(&["plans", "export", "."], &["R0150"]);
    bench.refused(&["new", "lamp.st"], &["R0151", "lamp.st"]);
    bench.refused(&["new", "lamp.st/within"], &["R0151"]);
    assert_eq!(bench.list("."), ["lamp.st", "lamp.toml"]);
    std::fs::create_dir(bench.path("empty")).unwrap();
    bench.expect(0, &["new", "empty"]);
    bench.refused(&["new", "empty"], &["R0150"]);
}

#[test]
fn the_shipped_plans_are_those_of_the_source() {
    let bench = TestProject::new();
    bench.expect(0, &["plans", "export", "library"]);
    let library = root().join("plans/library");
    // A plan that was added after the last build would be missing here.
    assert_eq!(files(&bench.path("library")), files(&library));
    for name in files(&library) {
        let (here, there) =
            (std::fs::read(bench.path("library").join(&name)), std::fs::read(library.join(&name)));
        assert!(here.unwrap() == there.unwrap(), "{name}");
    }
    let listed: Json =
        serde_json::from_str(&bench.expect(0, &["plans", "list", "--format", "json"]).out).unwrap();
    let listed = listed.as_array().unwrap();
    let fallback = listed.iter().find(|plan| plan["path"] == "watchdog/fallback.toml").unwrap();
    assert!(
        fallback["proves"]
            .as_array()
            .unwrap()
            .iter()
            .any(|id| id.as_str().unwrap().starts_with("controller:WD"))
    );
    let cases: u64 = listed.iter().map(|plan| plan["cases"].as_u64().unwrap()).sum();
    let table = bench.expect(0, &["plans", "list"]).out;
    assert!(table.ends_with(&format!("{} plans of {cases} cases\n", listed.len())), "{table}");
    // What was written out runs as what is built in.
    let ran = bench.expect(0, &["test", "library/watchdog/fallback.toml", "--only", "under"]);
    assert!(ran.out.contains("library/watchdog/fallback[under]"), "{}", ran.out);
}

#[test]
fn schemas_say_what_the_tables_say() {
    let bench = TestProject::new();
    let schema: Json = serde_json::from_str(&bench.expect(0, &["schema", "plan"]).out).unwrap();
    for key in plans::plan::PLAN_KEYS {
        assert_eq!(schema["properties"][key.name]["description"], key.doc);
    }
    let board: Json = serde_json::from_str(&bench.expect(0, &["schema", "board"]).out).unwrap();
    assert_eq!(board["required"], serde_json::json!(["format"]));
    bench.refused(&["schema", "trace"], &["trace", "plan", "board"]);
}

#[test]
fn shells_and_man_know_the_command() {
    let bench = TestProject::new();
    let help = bench.expect(0, &["--help"]).out;
    let commands: Vec<&str> = help
        .lines()
        .skip_while(|line| !line.starts_with("Commands:"))
        .skip(1)
        .take_while(|line| !line.is_empty())
        .filter(|line| line.starts_with("  ") && !line.starts_with("   "))
        .filter_map(|line| line.split_whitespace().next())
        .collect();
    assert!(commands.contains(&"test") && commands.contains(&"explain"), "{commands:?}");
    for shell in ["bash", "zsh", "fish"] {
        let script = bench.expect(0, &["completions", shell]).out;
        assert!(commands.iter().all(|command| script.contains(command)), "{shell}");
    }
    bench.refused(&["completions", "cmd"], &["cmd", "bash"]);
    bench.expect(0, &["man", "man/man1"]);
    let pages = bench.list("man/man1");
    for command in commands {
        assert!(pages.contains(&format!("rig-{command}.1")), "{command}: {pages:?}");
    }
    assert!(bench.read("man/man1/rig-test.1").contains("fail\\-fast"));
    // A newer version takes the place of the pages.
    bench.expect(0, &["man", "man/man1"]);
    bench.refused(&["man", "lamp.st"], &["R0151"]);
}
