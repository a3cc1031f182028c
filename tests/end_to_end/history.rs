//! `rig history`: past runs in one file.

use crate::project_folder::TestProject;
use record::RunRecord;
use serde_json::Value as Json;

/// A bench whose lamp may rise 400 ms to 600 ms after the button.
fn bench() -> TestProject {
    let bench = TestProject::new();
    bench.write_lamp("lamp.toml", "500 ms .. 550 ms", "400 ms .. 600 ms");
    bench
}

/// Runs of which the margin falls by 5 ms from one to the next; the last ones fail.
fn runs(bench: &TestProject, count: usize) -> Vec<String> {
    bench.expect(0, &["test", "lamp.toml", "--report", "run"]);
    let first = RunRecord::from_json(&bench.read("run/record.json")).unwrap();
    (0..count)
        .map(|number| {
            let mut run = first.clone();
            let claim = &mut run.cases[0].claims[0];
            let margin = claim.margin.as_mut().unwrap();
            margin.value -= 5e6 * number as f64;
            if margin.value < 0.0 {
                claim.verdict = record::Verdict::Fail;
                run.cases[0].verdict = record::Verdict::Fail;
                run.totals = record::Totals::of(&run.cases);
            }
            let folder = format!("past/{number:02}");
            bench.write(&format!("{folder}/record.json"), &run.to_json());
            folder
        })
        .collect()
}

fn add(bench: &TestProject, runs: &[String], more: &[&str]) -> String {
    let runs: Vec<&str> = runs.iter().map(String::as_str).collect();
    bench.expect(0, &[&["history", "add"], &runs[..], more].concat()).out
}

fn shown(bench: &TestProject) -> Json {
    serde_json::from_str(&bench.expect(0, &["history", "show", "--format", "json"]).out).unwrap()
}

#[test]
fn a_margin_that_shrinks_is_seen_before_it_is_gone() {
    let bench = bench();
    let said = add(&bench, &runs(&bench, 10), &[]);
    assert!(said.ends_with("past/09 added\nrig-history.sqlite: 10 runs\n"), "{said}");
    let out = bench.expect(0, &["history", "show"]).out;
    assert!(out.contains("Cases that did not always pass (0 of 1)"), "{out}");
    assert!(
        out.contains("Figures that drift (1 of 2)\n  lamp: `lamp` rises 400 ms .. 600 ms after press\n"),
        "{out}"
    );
    assert!(out.contains("drifts -5 ms a run, gone in 7 runs\n"), "{out}");
    let json = shown(&bench);
    assert_eq!((&json["format"], json["runs"].as_array().unwrap().len()), (&1.into(), 10));
    let figure = &json["figures"][0];
    assert_eq!((&figure["kind"], &figure["margin"]["count"]), (&"claim".into(), &10.into()));
    assert_eq!(figure["margin"]["last"], 34_965_000.0);
}

#[test]
fn a_verdict_that_changes_by_itself_is_flaky() {
    let bench = bench();
    let all = runs(&bench, 17);
    // 15 pass, the last fails; then one that passed is run again.
    add(&bench, &all, &[]);
    bench.write(
        "past/again/record.json",
        &bench.read("past/00/record.json").replace("\"started\":\"2", "\"started\":\"3"),
    );
    add(&bench, &["past/again".to_owned()], &[]);
    let out = bench.expect(0, &["history", "show"]).out;
    assert!(
        out.contains("  ................F.  17 of 18 passed, flaky: changed 2 times by itself\n      lamp\n"),
        "{out}"
    );
    assert_eq!(shown(&bench)["cases"][0]["flaky"], 2);
}

#[test]
fn a_run_is_added_once_and_old_ones_are_forgotten() {
    let bench = bench();
    let all = runs(&bench, 8);
    add(&bench, &all[..3], &[]);
    let said = add(&bench, &all[2..4], &[]);
    assert_eq!(said, "past/02 is there already\npast/03 added\nrig-history.sqlite: 4 runs\n");
    add(&bench, &all[4..], &["--keep", "5"]);
    let json = shown(&bench);
    let names: Vec<&str> =
        json["runs"].as_array().unwrap().iter().map(|run| run["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["past/03", "past/04", "past/05", "past/06", "past/07"]);
    assert_eq!(json["figures"][0]["margin"]["count"], 5);
    // A case that no run has any more leaves nothing.
    bench.write_lamp("other.toml", "half a second", "soon");
    bench.expect(0, &["test", "other.toml", "--history", "rig-history.sqlite"]);
    add(&bench, &all[..1], &["--keep", "1"]);
    let json = shown(&bench);
    assert_eq!((json["cases"].as_array().unwrap().len(), &json["cases"][0]["name"]), (1, &"lamp".into()));
}

#[test]
fn a_run_adds_itself() {
    let bench = bench();
    for _ in 0..2 {
        bench.expect(0, &["test", "lamp.toml", "--history", "h.db"]);
    }
    let out = bench.expect(0, &["history", "show", "--file", "h.db", "--only", "lamp"]).out;
    assert!(
        out.contains("Runs (2)") && out.contains("Cases (1 of 1)") && out.contains("Figures (2 of 2)"),
        "{out}"
    );
    assert!(
        bench
            .expect(0, &["history", "show", "--file", "h.db", "--only", "none"])
            .out
            .contains("Cases (0 of 0)")
    );
}

#[test]
fn files_of_others_are_left_alone() {
    let bench = bench();
    let run = runs(&bench, 1).remove(0);
    bench.write("notes.txt", &"Not a database, but long enough to have a header of one.\n".repeat(20));
    let text = bench.read("notes.txt");
    bench.refused(&["history", "add", &run, "--file", "notes.txt"], &["error[R0168]", "no database"]);
    assert_eq!(bench.read("notes.txt"), text);
    bench.refused(&["history", "show", "--file", "nowhere"], &["error[R0168]", "no history `nowhere`"]);
    bench.refused(&["history", "add", &run, "--file", "no/where"], &["error[R0169]", "no/where"]);
    bench.refused(&["history", "add", "nowhere", "--file", "new"], &["error[R0160]"]);
    assert!(!bench.path("new").exists());
    // A database of another program, and a history of a newer rig: the marks stand in the header.
    for (at, code) in [(68, "error[R0168]"), (60, "error[R0169]")] {
        add(&bench, std::slice::from_ref(&run), &["--file", "h.db"]);
        let mut bytes = std::fs::read(bench.path("h.db")).unwrap();
        bytes[at + 3] ^= 0x55;
        std::fs::write(bench.path("h.db"), &bytes).unwrap();
        bench.refused(&["history", "add", &run, "--file", "h.db"], &[code]);
        bench.refused(&["history", "show", "--file", "h.db"], &[code]);
        assert!(std::fs::read(bench.path("h.db")).unwrap() == bytes);
        std::fs::remove_file(bench.path("h.db")).unwrap();
    }
    // Cut in the middle.
    add(&bench, std::slice::from_ref(&run), &["--file", "h.db"]);
    let bytes = std::fs::read(bench.path("h.db")).unwrap();
    std::fs::write(bench.path("h.db"), &bytes[..bytes.len() / 2]).unwrap();
    bench.refused(&["history", "show", "--file", "h.db"], &["error[R0169]", "damaged"]);
}

#[test]
fn two_commands_at_once_lose_nothing() {
    let bench = bench();
    let all = runs(&bench, 6);
    let start = |run: &String| {
        let mut command = bench.command(&["history", "add", run]);
        command.stdout(std::process::Stdio::null()).spawn().unwrap()
    };
    let children: Vec<_> = all.iter().map(start).collect();
    for mut child in children {
        assert!(child.wait().unwrap().success());
    }
    assert_eq!(shown(&bench)["runs"].as_array().unwrap().len(), 6);
    assert!(!bench.list(".").iter().any(|name| name.contains("journal")), "{:?}", bench.list("."));
}
