//! `rig requirements`: what each requirement is proven by.

use std::collections::BTreeSet;

use crate::project_folder::{TestProject, root};

#[test]
fn the_register_as_json() {
    let bench = TestProject::new();
    bench.expect(0, &["test", "--shipped", "--only", "watchdog", "--report", "out"]);
    let out = bench.expect(0, &["requirements", "--format", "json", "--report", "out"]).out;
    let rows: serde_json::Value = serde_json::from_str(&out).unwrap();
    let rows = rows.as_array().unwrap();
    assert!(rows.len() > 100, "{}", rows.len());
    let mut ids = BTreeSet::new();
    let mut proven = 0;
    for row in rows {
        let id = row["id"].as_str().unwrap();
        assert!(ids.insert(id), "{id} is there twice");
        let status = row["status"].as_str().unwrap();
        let words = ["proven", "proven by decision", "stand-in", "in part", "not reproducible", "not proven"];
        assert!(words.contains(&status), "{id} is {status}");
        assert!(!row["asks"].as_str().unwrap().is_empty());
        // Every profile counts, and what one of them lacks is said.
        let profiles = row["profiles"].as_array().unwrap();
        let all = profiles.iter().all(|profile| profile["status"] == status);
        let none = profiles.iter().all(|profile| profile["cases"].as_array().unwrap().is_empty());
        assert!(status != "proven" || all, "{id}");
        assert_eq!(row["cases"].as_array().unwrap().is_empty(), none, "{id}");
        assert!(status != "in part" || !row["lacks"].as_array().unwrap().is_empty(), "{id}");
        assert!(status != "not reproducible" || !row["reason"].as_str().unwrap().is_empty(), "{id}");
        proven += usize::from(status == "proven");
    }
    assert!(proven > 10, "{proven}");
    let fallback = rows.iter().find(|row| row["id"] == "controller:WD-10").unwrap();
    assert!(fallback["cases"].as_array().unwrap().iter().any(|name| name == "watchdog/fallback[over]"));
}

#[test]
fn the_register_as_a_table() {
    let bench = TestProject::new();
    bench.expect(0, &["test", "--shipped", "--only", "watchdog/fallback", "--report", "out"]);
    let out = bench.expect(0, &["requirements", "--report", "out"]).out;
    let last = out.lines().last().unwrap();
    assert!(
        last.contains(" requirements: ") && last.contains(" in part") && last.contains(" not proven"),
        "{last}"
    );
    assert!(out.lines().any(|line| line.starts_with("controller:WD-04 ")
        && line.contains(" ++-  in part ")
        && line.contains("[lacks m251-2024]")));
    // Counts by area and status.
    assert!(out.lines().any(|line| line.starts_with("serial-can ")));
}

#[test]
fn a_failed_case_proves_nothing() {
    let bench = TestProject::new();
    let library = root().join("plans/library/watchdog/fallback.toml");
    let text = std::fs::read_to_string(&library).unwrap().replace("100 ms .. 100.3 ms", "1 ms .. 2 ms");
    bench.write("fallback.toml", &text);
    bench.write("lamp.st", &std::fs::read_to_string(library.with_file_name("lamp.st")).unwrap());
    bench.expect(1, &["test", "fallback.toml", "--report", "out"]);
    let out = bench.expect(0, &["requirements", "--format", "json", "--report", "out"]).out;
    let rows: serde_json::Value = serde_json::from_str(&out).unwrap();
    let row = rows.as_array().unwrap().iter().find(|row| row["id"] == "controller:WD-04").unwrap().clone();
    assert_eq!(row["status"], "failing");
    // Three rows, each for the two profiles of the plan.
    assert_eq!(row["cases"].as_array().unwrap().len(), 6);
}

#[test]
fn records_that_cannot_be_trusted_are_refused() {
    let bench = TestProject::new();
    bench
        .refused(&["requirements", "--report", "out"], &["error[R0160]", "`out/record.json` cannot be read"]);
    bench.expect(0, &["test", "lamp.toml", "--report", "out"]);
    let record = bench.read("out/record.json");
    bench.write("out/record.json", &record.replacen("\"passed\":1", "\"passed\":2", 1));
    bench.refused(&["requirements", "--report", "out"], &["totals"]);
    bench.write("out/record.json", "{}");
    bench.refused(&["requirements", "--report", "out"], &["out/record.json"]);
    // A requirement that nobody has asked for.
    bench.write_lamp("lamp.toml", "controller:TASK-10", "controller:TASK-999");
    bench.rig(&["test", "lamp.toml", "--report", "out"]);
    bench.refused(&["requirements", "--report", "out"], &["controller:TASK-999"]);
}
