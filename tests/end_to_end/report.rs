//! `--report DIR`: everything that a run leaves on disk.

use crate::project_folder::{LAMP, TestProject};

/// What a report folder holds.
pub const OUTPUTS: [&str; 8] = [
    "claims.csv",
    "ctrf.json",
    "index.html",
    "junit.xml",
    "measurements.csv",
    "record.json",
    "summary.md",
    "traces",
];

#[test]
fn a_run_leaves_record_reports_and_traces() {
    let bench = TestProject::new();
    bench.write_lamp("slow.toml", "500 ms .. 550 ms", "490 ms .. 510 ms");
    let ran = bench.expect(1, &["test", "lamp.toml", "slow.toml", "--report", "out"]);
    assert!(ran.out.ends_with("Report: out/index.html\n"), "{}", ran.out);
    assert_eq!(bench.list("out"), OUTPUTS);
    assert_eq!(bench.list("out/traces"), ["lamp.trace", "lamp.vcd", "slow.trace", "slow.vcd"]);

    let record = bench.json("out/record.json");
    assert_eq!((&record["totals"]["passed"], &record["totals"]["failed"]), (&1.into(), &1.into()));
    let case = &record["cases"][0];
    assert_eq!(case["trace_file"], "traces/lamp.trace");
    assert_eq!(case["proves"][0], "controller:TASK-10");
    assert_eq!((&case["profile"], &case["reference"]), (&"m241-2019".into(), &"TM241CEC24T".into()));
    // Where it came from: the command line, the hashes of what it was made of.
    assert_eq!(record["provenance"]["arguments"][1], "lamp.toml");
    assert_eq!(record["provenance"]["clock"], "virtual");
    assert_eq!(record["provenance"]["environment"][0][0], "Real-time kernel");
    assert_eq!(case["board"], "default board");
    // What the register says of the requirements that the plans name, so that a report needs no register.
    assert_eq!(record["requirements"].as_array().unwrap().len(), 1);
    assert_eq!(record["requirements"][0]["id"], "controller:TASK-10");
    assert!(!record["requirements"][0]["asks"].as_str().unwrap().is_empty());
    for hash in [
        &record["provenance"]["binary_sha256"],
        &case["hashes"]["plan"],
        &case["hashes"]["program"],
        &case["trace_sha256"],
    ] {
        assert_eq!(hash.as_str().unwrap().len(), 64);
    }

    let junit = bench.read("out/junit.xml");
    assert!(junit.contains("tests=\"2\"") && junit.contains("failures=\"1\""), "{junit}");
    let page = bench.read("out/index.html");
    assert!(page.contains("<svg") && page.contains("slow"));
    // It stands alone: nothing is fetched.
    for fetched in ["src=\"http", "href=\"http", "url(http", "@import"] {
        assert!(!page.contains(fetched), "{fetched}");
    }
    let waves = bench.read("out/traces/lamp.vcd");
    assert!(waves.contains("$timescale 1 ns $end") && waves.contains(" lamp $end"));
}

#[test]
fn tags_choose_and_are_in_the_record() {
    let bench = TestProject::new();
    bench.write(
        "slow.toml",
        &LAMP.replacen("\nprogram", "\ntags = [\"slow\", \"lamp\", \"slow\"]\nprogram", 1),
    );
    let ran = bench.expect(0, &["test", "lamp.toml", "slow.toml", "--only", "tag:slow", "--report", "out"]);
    assert!(ran.out.contains("1 passed"), "{}", ran.out);
    let record = bench.json("out/record.json");
    assert_eq!(record["cases"][0]["name"], "slow");
    assert_eq!(record["cases"][0]["tags"], serde_json::json!(["slow", "lamp"]));
}

#[test]
fn a_second_run_replaces_the_first() {
    let bench = TestProject::new();
    bench.expect(0, &["test", "lamp.toml", "--report", "deep/er/out"]);
    let first = bench.json("deep/er/out/record.json");
    bench.expect(0, &["test", "lamp.toml", "--report", "deep/er/out"]);
    let second = bench.json("deep/er/out/record.json");
    assert_eq!(first["cases"][0]["trace_sha256"], second["cases"][0]["trace_sha256"]);
    assert_eq!(bench.list("deep/er/out/traces"), ["lamp.trace", "lamp.vcd"]);
}

#[test]
fn every_case_has_a_trace_of_its_own() {
    let bench = TestProject::new();
    let text = LAMP.replace("\"lamp.st\"", "\"../lamp.st\"");
    bench.write("a/b.toml", &text);
    bench.write("a_b.toml", LAMP);
    bench.write("a b.toml", &LAMP.replace("500 ms .. 550 ms", "$limit"));
    bench.write("a b.toml", &(bench.read("a b.toml") + "[rows]\n\"x\" = { limit = \"500 ms .. 550 ms\" }\n"));
    bench.expect(0, &["test", "a/b.toml", "a_b.toml", "a b.toml", "--report", "out"]);
    let record = bench.json("out/record.json");
    let mut files: Vec<&str> =
        record["cases"].as_array().unwrap().iter().map(|case| case["trace_file"].as_str().unwrap()).collect();
    assert!(files.iter().all(|file| bench.path("out").join(file).is_file()));
    files.sort();
    files.dedup();
    assert_eq!(files.len(), 3, "{files:?}");
}

#[test]
fn a_plan_of_a_long_path_can_be_reported() {
    let bench = TestProject::new();
    let folder = ["a-folder-with-quite-a-long-name"; 9].join("/");
    bench.write(&format!("{folder}/lamp.st"), crate::project_folder::LAMP_ST);
    bench.write(&format!("{folder}/lamp.toml"), LAMP);
    let path = bench.path(&folder).join("lamp.toml");
    bench.expect(0, &["test", path.to_str().unwrap(), "--report", "out"]);
    let file = bench.json("out/record.json")["cases"][0]["trace_file"].as_str().unwrap().to_owned();
    bench.expect(0, &["judge", path.to_str().unwrap(), &format!("out/{file}")]);
}

#[test]
fn a_folder_that_cannot_be_written_is_refused_before_anything_moves() {
    let bench = TestProject::new();
    bench.write("out/traces", "a file in the way");
    bench.refused(&["test", "lamp.toml", "--report", "out"], &["out/traces"]);
}

#[test]
fn can_frames_of_a_case_are_kept_as_candump_writes_them() {
    let bench = TestProject::new();
    let plan = crate::project_folder::root().join("plans/library/buses/remote.toml");
    bench.expect(0, &["test", plan.to_str().unwrap(), "lamp.toml", "--report", "out"]);
    let record = bench.json("out/record.json");
    let case = &record["cases"][0];
    let log = case["trace_file"].as_str().unwrap().replace(".trace", ".log");
    let text = bench.read(&format!("out/{log}"));
    // Five questions and five answers, each heard by both nodes.
    assert_eq!(case["frames"], serde_json::json!({ "kept": 20 }), "{text}");
    let lines: Vec<Vec<&str>> = text.lines().map(|line| line.split(' ').collect()).collect();
    let count = |bus: &str, frame: &str| lines.iter().filter(|line| line[1..] == [bus, frame]).count();
    for (bus, frame) in
        [("machine", "301#R2"), ("drive", "301#R2"), ("machine", "301#1234"), ("drive", "301#1234")]
    {
        assert_eq!(count(bus, frame), 5, "{bus} {frame} in\n{text}");
    }
    assert!(
        lines.iter().all(|line| line[0].len() == "(0000000001.000000)".len() && line.len() == 3),
        "{text}"
    );
    assert!(lines.is_sorted_by_key(|line| line[0]), "{text}");
    assert!(bench.read("out/ctrf.json").contains(&log));
    // Without frames there is no log; another folder gets a copy.
    assert_eq!(record["cases"][1]["frames"], serde_json::Value::Null);
    assert_eq!(bench.list("out/traces").iter().filter(|name| name.ends_with(".log")).count(), 1);
    bench.expect(0, &["report", "out", "--out", "again"]);
    assert_eq!(bench.read(&format!("again/{log}")), text);
    bench.expect(0, &["test", plan.to_str().unwrap(), "--shard", "1/1", "--report", "part"]);
    bench.expect(0, &["report", "--merge", "part", "--out", "merged"]);
    assert_eq!(bench.read(&format!("merged/{log}")), text);
}
