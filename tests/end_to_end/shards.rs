//! `--shard K/N` and `rig report --merge`: a suite on several machines.

use crate::project_folder::{CommandOutput, TestProject};
use record::RunRecord;

/// A bench with seven cases: a sweep of five, one that passes, one that fails.
fn suite() -> TestProject {
    let bench = TestProject::new();
    bench.write_lamp("slow.toml", "500 ms .. 550 ms", "490 ms .. 510 ms");
    let sweep = "\nsweep = { late = { from = \"0 ms\", to = \"4 ms\", step = \"1 ms\" } }\n";
    let text = crate::project_folder::LAMP
        .replace("start + 1 s", "start + 1 s + $late")
        .replace("\nsteps", &format!("{sweep}steps"));
    bench.write("sweep.toml", &text);
    bench
}

const PLANS: [&str; 3] = ["lamp.toml", "slow.toml", "sweep.toml"];

fn test(bench: &TestProject, more: &[&str]) -> CommandOutput {
    bench.rig(&[&["test"], &PLANS[..], more].concat())
}

/// Runs all parts into `part1` and so on; gives their exit codes.
fn parts(bench: &TestProject, of: u32) -> Vec<Option<i32>> {
    let part = |k: u32| {
        let (shard, folder) = (format!("{k}/{of}"), format!("part{k}"));
        test(bench, &["--shard", &shard, "--report", &folder]).code
    };
    (1..=of).map(part).collect()
}

fn record(bench: &TestProject, folder: &str) -> RunRecord {
    RunRecord::from_json(&bench.read(&format!("{folder}/record.json"))).unwrap().without_host_facts()
}

#[test]
fn the_parts_together_are_the_whole() {
    let bench = suite();
    assert_eq!(test(&bench, &["--report", "whole"]).code, Some(1));
    assert_eq!(parts(&bench, 3).into_iter().flatten().max(), Some(1));
    // In any order.
    let ran =
        bench.expect(1, &["report", "--merge", "part3", "part1/record.json", "part2", "--report", "all"]);
    assert_eq!(
        ran.out,
        "Summary: 6 passed, 1 failed, 0 inconclusive, 0 not applicable\nReport: all/index.html\n"
    );
    assert_eq!(record(&bench, "all"), record(&bench, "whole"));
    assert_eq!(bench.list("all"), crate::report::OUTPUTS);
    assert_eq!(bench.list("all/traces"), bench.list("whole/traces"));
    for file in bench.list("whole/traces") {
        let read = |folder: &str| std::fs::read(bench.path(&format!("{folder}/traces/{file}"))).unwrap();
        assert!(read("all") == read("whole"), "{file}");
    }
    let arguments = &bench.json("all/record.json")["provenance"]["arguments"];
    assert!(!arguments.to_string().contains("shard"), "{arguments}");
}

#[test]
fn coverage_adds_up() {
    let bench = suite();
    // Only one case presses the button, so that the parts run different statements.
    bench.write("idle.toml", &crate::project_folder::LAMP.replace("value = true", "value = false"));
    let pressed = "IF button THEN\n    lamp := delay.Q;\nELSE\n    lamp := FALSE;\nEND_IF;";
    bench.write("lamp.st", &crate::project_folder::LAMP_ST.replace("lamp := delay.Q;", pressed));
    let test = |more: &[&str]| bench.rig(&[&["test", "idle.toml", "lamp.toml", "--coverage"], more].concat());
    test(&["--report", "whole"]);
    test(&["--shard", "1/2", "--report", "part1"]);
    test(&["--shard", "2/2", "--report", "part2"]);
    bench.rig(&["report", "--merge", "part1", "part2", "--out", "all"]);
    let [all, whole, part] = ["all", "whole", "part1"].map(|folder| record(&bench, folder).coverage);
    assert_eq!(all, whole);
    assert!(part[0].statements_run < whole[0].statements_run && whole[0].statements_at.is_empty());
}

#[test]
fn a_part_without_cases_is_a_part() {
    let bench = suite();
    let ran = test(&bench, &["--shard", "9/9", "--report", "part9"]);
    assert_eq!(ran.code, Some(0));
    assert!(ran.err.contains("this part has none"), "{}", ran.err);
    for k in 1..9 {
        test(&bench, &["--shard", &format!("{k}/9"), "--report", &format!("part{k}")]);
    }
    let folders: Vec<String> = (1..=9).map(|k| format!("part{k}")).collect();
    let folders: Vec<&str> = folders.iter().map(String::as_str).collect();
    bench.expect(1, &[&["report", "--merge", "--out", "all"], &folders[..]].concat());
    assert_eq!(record(&bench, "all").cases.len(), 7);
}

#[test]
fn parts_can_be_listed() {
    let bench = suite();
    let all = test(&bench, &["--list"]).out;
    let one = test(&bench, &["--list", "--shard", "2/3"]).out;
    let second: Vec<&str> = all.lines().skip(1).step_by(3).collect();
    assert_eq!(one.lines().collect::<Vec<_>>(), second);
}

#[test]
fn what_is_not_of_one_suite_is_refused() {
    let bench = suite();
    parts(&bench, 2);
    let refused = |runs: &[&str], words: &[&str]| {
        bench.refused(&[&["report", "--merge", "--out", "all"], runs].concat(), words);
    };
    refused(&["part1"], &["error[R0163]", "2/2"]);
    refused(&["part1", "part2", "part1"], &["error[R0164]", "part 1/2"]);
    refused(&["part1", "nowhere"], &["error[R0160]"]);
    test(&bench, &["--report", "whole"]);
    refused(&["part1", "whole"], &["error[R0165]", "`whole`"]);
    test(&bench, &["--shard", "2/2", "--seed", "7", "--report", "seed"]);
    refused(&["part1", "seed"], &["error[R0162]", "the seed is 7 and not 1", "the selection is"]);
    test(&bench, &["--shard", "2/3", "--report", "third"]);
    refused(&["part1", "third"], &["error[R0162]", "the number of parts is 3 and not 2"]);
    // A file that was changed between the parts, though the plan is the same.
    bench.write("lamp.st", &crate::project_folder::LAMP_ST.replace("T#500ms", "T#501ms"));
    test(&bench, &["--shard", "2/2", "--report", "other"]);
    refused(&["part1", "other"], &["error[R0162]", "the selection is"]);
    // A part that lost a case.
    let mut less = RunRecord::from_json(&bench.read("part1/record.json")).unwrap();
    less.cases.remove(0);
    less.totals = record::Totals::of(&less.cases);
    bench.write("less/record.json", &less.to_json());
    refused(&["less", "part2"], &["error[R0162]", "`less` has 3 cases"]);
    std::fs::remove_file(bench.path("part2/traces/slow.trace")).unwrap();
    refused(&["part1", "part2"], &["error[R0166]", "slow"]);
    for shard in ["0/2", "3/2", "x"] {
        bench.refused(&["test", "lamp.toml", "--shard", shard], &["error[R0161]", "1/3"]);
    }
}
