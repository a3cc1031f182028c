//! `rig report RUN`: the reports of a run drawn again from its record.

use crate::project_folder::TestProject;
use crate::report::OUTPUTS;

/// A run with a case that passes and one that fails, in `out`.
fn ran() -> TestProject {
    let bench = TestProject::new();
    bench.write_lamp("slow.toml", "500 ms .. 550 ms", "490 ms .. 510 ms");
    bench.expect(1, &["test", "lamp.toml", "slow.toml", "--report", "out"]);
    bench
}

#[test]
fn what_was_drawn_is_drawn_again() {
    let bench = ran();
    let all = [
        "claims.csv",
        "ctrf.json",
        "index.html",
        "junit.xml",
        "measurements.csv",
        "summary.md",
        "traces/lamp.vcd",
        "traces/slow.vcd",
    ];
    let before: Vec<String> = all.iter().map(|name| bench.read(&format!("out/{name}"))).collect();
    for name in all {
        bench.write(&format!("out/{name}"), "lost");
    }
    let ran = bench.expect(0, &["report", "out"]);
    assert_eq!(ran.out, "Report: out/index.html\n");
    let after: Vec<String> = all.iter().map(|name| bench.read(&format!("out/{name}"))).collect();
    for ((name, before), after) in all.iter().zip(&before).zip(&after) {
        assert!(before == after, "{name} is not what it was");
    }
}

#[test]
fn another_folder_is_whole() {
    let bench = ran();
    bench.expect(0, &["report", "out/record.json", "--out", "again"]);
    assert_eq!(bench.list("again"), OUTPUTS);
    assert_eq!(bench.list("again/traces"), bench.list("out/traces"));
    assert_eq!(bench.read("again/record.json"), bench.read("out/record.json"));
    // Attachments are where they are now.
    assert!(bench.read("again/junit.xml").contains("[[ATTACHMENT|again/traces/slow.vcd]]"));
    bench.expect(0, &["report", "again/", "--out", "third", "--format", "md,csv"]);
    assert_eq!(bench.list("third"), ["claims.csv", "measurements.csv", "summary.md"]);
}

#[test]
fn traces_that_are_lost_are_said() {
    let bench = ran();
    std::fs::remove_file(bench.path("out/traces/lamp.trace")).unwrap();
    let ran = bench.expect(0, &["report", "out"]);
    assert!(ran.err.contains("lamp: out/traces/lamp.trace"), "{}", ran.err);
    bench.refused(&["report", "out", "--format", "vcd"], &["error[R0166]", "lamp"]);
    // The trace of another case under its name.
    std::fs::copy(bench.path("out/traces/slow.trace"), bench.path("out/traces/lamp.trace")).unwrap();
    let record = bench.read("out/record.json");
    let digest = bench.json("out/record.json")["cases"][0]["trace_sha256"].as_str().unwrap().to_owned();
    bench.write("out/record.json", &record.replace(&digest, &"0".repeat(64)));
    bench.refused(&["report", "out", "--format", "vcd"], &["error[R0166]", "another trace"]);
    // Nothing outside the folder is read, whatever a record says.
    bench.write("secret.trace", "x");
    bench.write("out/record.json", &record.replace("traces/lamp.trace", "../secret.trace"));
    bench.refused(
        &["report", "out", "--format", "vcd"],
        &["error[R0166]", "not a path within the run's folder"],
    );
}

#[test]
fn what_is_no_run_is_refused() {
    let bench = ran();
    bench.refused(&["report", "nowhere"], &["error[R0160]", "nowhere"]);
    bench.refused(&["report", "."], &["error[R0160]", "record.json"]);
    bench.refused(&["report", "lamp.toml"], &["error[R0402]"]);
    bench.refused(&["report", "out", "out"], &["error[R0165]", "--merge"]);
    bench.write("file", "");
    bench.refused(&["report", "out", "--out", "file/out"], &["error[R0167]", "file/out"]);
    bench.refused(&["report", "out", "--format", "pdf"], &["pdf"]);
    bench.refused(&["report", "--merge", "out"], &["--out"]);
}

#[test]
fn a_summary_goes_where_it_is_wanted() {
    let bench = ran();
    bench.write("step.md", "");
    bench.expect(1, &["test", "lamp.toml", "slow.toml", "--summary", "step.md"]);
    let summary = bench.read("step.md");
    assert!(summary.starts_with("## ✗ rig: failed\n\n**1** passed, **1** failed of 2 cases"), "{summary}");
    assert!(summary.contains("`slow.toml:10`"), "{summary}");
    let ran = bench.expect(4, &["test", "lamp.toml", "--summary", "nowhere/step.md"]);
    assert!(ran.err.contains("nowhere/step.md"), "{}", ran.err);
}
