//! `rig diff`: what changed between two runs.

use crate::project_folder::{LAMP_ST, TestProject};

/// Runs the lamp with this delay into a folder.
fn ran(bench: &TestProject, delay: &str, folder: &str) {
    bench.write("lamp.st", &LAMP_ST.replace("T#500ms", delay));
    bench.rig(&["test", "lamp.toml", "--report", folder]);
}

#[test]
fn a_run_differs_from_itself_in_nothing() {
    let bench = TestProject::new();
    ran(&bench, "T#500ms", "one");
    ran(&bench, "T#500ms", "two");
    let ran = bench.expect(0, &["diff", "one", "two"]);
    assert!(ran.out.ends_with(
        "Summary: not worse; 1 cases the same, 0 worse, 0 better, 0 missing, 0 new, 0 margins eroded\n"
    ));
    // But for what the user wrote: the folder.
    assert!(ran.out.starts_with("Facts that changed\n  arguments\n"), "{}", ran.out);
}

#[test]
fn margins_erode_before_a_claim_fails() {
    let bench = TestProject::new();
    bench.write_lamp("lamp.toml", "500 ms .. 550 ms", "400 ms .. 600 ms");
    ran(&bench, "T#500ms", "good");
    ran(&bench, "T#525ms", "late");
    ran(&bench, "T#600ms", "bad");
    let eroded = bench.expect(1, &["diff", "good", "late"]);
    assert!(
        eroded.out.starts_with(
            "Margins that eroded\n  lamp: `lamp` rises 400 ms .. 600 ms after press\n      \
             79.965 ms became 39.965 ms, 50.0 % lost\n"
        ),
        "{}",
        eroded.out
    );
    assert!(eroded.out.contains("Files that changed\n  program of lamp.toml\n"), "{}", eroded.out);
    bench.expect(0, &["diff", "good", "late", "--erosion", "60%"]);
    // The other way the lamp is nearer to the instant before which it must not light.
    bench.expect(1, &["diff", "late", "good"]);
    bench.expect(0, &["diff", "late", "good", "--erosion", "70"]);
    let failed = bench.expect(1, &["diff", "late", "bad"]);
    assert!(failed.out.starts_with("Worse\n  lamp: pass became fail\n"), "{}", failed.out);
    let better = bench.expect(0, &["diff", "bad", "late", "--erosion", "70"]);
    assert!(better.out.contains("Other changes of cases\n  lamp: fail became pass\n"), "{}", better.out);
}

#[test]
fn a_program_reads_it_as_json() {
    let bench = TestProject::new();
    ran(&bench, "T#500ms", "old");
    bench.write_lamp("other.toml", "half a second", "soon");
    bench.expect(0, &["test", "other.toml", "--report", "new"]);
    let found = bench.expect(1, &["diff", "old", "new/record.json", "--format", "json"]);
    let json: serde_json::Value = serde_json::from_str(&found.out).unwrap();
    assert_eq!((&json["format"], &json["worse"]), (&1.into(), &true.into()));
    let cases = json["cases"].as_array().unwrap();
    assert_eq!((&cases[0]["name"], &cases[0]["new"]), (&"lamp".into(), &serde_json::Value::Null));
    assert_eq!((&cases[1]["name"], &cases[1]["old"]), (&"other".into(), &serde_json::Value::Null));
    bench.expect(0, &["diff", "old", "new", "--allow-missing"]);
}

#[test]
fn what_is_no_run_is_refused() {
    let bench = TestProject::new();
    ran(&bench, "T#500ms", "old");
    bench.refused(&["diff", "old", "nowhere"], &["error[R0160]", "nowhere"]);
    bench.refused(&["diff", "old", "old", "--erosion", "x"], &["from 0 to 100"]);
    bench.refused(&["diff", "old"], &["<NEW>"]);
}

#[test]
fn judged_captures_differ_in_their_files_and_not_in_nothing() {
    let bench = TestProject::new();
    let columns = |rise: &str| format!("time [s],button,lamp\n0,0,0\n1,1,0\n{rise},1,1\n3,1,1\n");
    bench.write("one.csv", &columns("1.52"));
    bench.write("two.csv", &columns("1.53"));
    bench.write("scope.toml", "format = 1\n[timebase]\nresolution = \"1 us\"\n");
    let judge = |capture: &str, folder: &str, more: &[&str]| {
        let args = ["judge", "lamp.toml", capture, "--start", "0 s", "--report", folder];
        bench.rig(&[&args[..], more].concat());
    };
    judge("one.csv", "one", &[]);
    judge("two.csv", "two", &[]);
    judge("one.csv", "scope", &["--instrument", "scope.toml"]);
    let case = &bench.json("one/record.json")["cases"][0];
    for file in ["plan", "program", "capture"] {
        assert_eq!(case["hashes"][file].as_str().map(str::len), Some(64), "{file}: {case}");
    }
    for (new, what) in [("two", "capture"), ("scope", "instrument")] {
        let ran = bench.rig(&["diff", "one", new]);
        assert!(!ran.out.contains("though nothing else does"), "{}", ran.out);
        assert!(ran.out.contains(&format!("Files that changed\n  {what} of lamp.toml\n")), "{}", ran.out);
    }
    // The trace of a capture says from what it was made.
    let trace = "one/traces/lamp.trace";
    bench.rig(&["judge", "lamp.toml", trace, "--report", "again"]);
    assert_eq!(bench.json("again/record.json")["cases"][0]["hashes"], case["hashes"]);
    let ran = bench.rig(&["diff", "one", "again"]);
    assert!(!ran.out.contains("Files that changed"), "{}", ran.out);
}

#[test]
fn a_guard_band_that_is_gone_is_said() {
    let bench = TestProject::new();
    // The lamp is sampled every 10 ms, so that its delay is known to within 20 ms: 500 ms .. 520 ms.
    let mut rows = String::from("time [ms],button,lamp\n");
    for at in (0..=3_000).step_by(10) {
        rows += &format!("{at},{},{}\n", u8::from(at >= 1_000), u8::from(at >= 1_510));
    }
    bench.write("one.csv", &rows);
    let judge = |guard: &str, max: u32, folder: &str| {
        let measure = format!(
            "measure = [{{ name = \"delay\", from = \"press\", to = {{ signal = \"lamp\", edge = \"rises\" }}, max = \"{max} ms\", \
             guard = \"{guard}\", pulses-longer-than = \"20 ms\" }}]\nsignals ="
        );
        bench.write_lamp("lamp.toml", "signals =", &measure);
        let args = ["judge", "lamp.toml", "one.csv", "--start", "0 s", "--at", "press=button rises"];
        bench.rig(&[&args[..], &["--report", folder]].concat());
        bench.json(&format!("{folder}/record.json"))["cases"][0]["measurements"][0].clone()
    };
    let proven = judge("uncertainty", 530, "proven");
    assert_eq!(
        (&proven["verdict"], &proven["by_middle"]),
        (&"pass".into(), &serde_json::Value::Null),
        "{proven}"
    );
    let accepted = judge("none", 515, "accepted");
    assert_eq!((&accepted["verdict"], &accepted["by_middle"]), (&"pass".into(), &true.into()), "{accepted}");
    let ran = bench.expect(1, &["diff", "proven", "accepted"]);
    let said = "Proven before, now accepted by its middle\n  lamp: delay\n      guard uncertainty became none, by its middle\n";
    assert!(ran.out.contains(said), "{}", ran.out);
    let ran = bench.rig(&["diff", "accepted", "proven"]);
    assert!(ran.out.contains("Guard bands that changed\n  lamp: delay\n"), "{}", ran.out);
    bench.expect(0, &["history", "add", "proven", "accepted"]);
    let ran = bench.expect(0, &["history", "show"]);
    assert_eq!(
        ran.out.matches("1 case measured without a guard band, 1 of them decided by a middle").count(),
        1
    );
}

#[test]
fn the_last_event_counts_cases_without_a_guard_band() {
    let bench = TestProject::new();
    let measure = "measure = [{ name = \"delay\", from = \"press\", to = { signal = \"lamp\", edge = \"rises\" }, max = \"1 s\", \
                   guard = \"none\" }]\nsignals =";
    bench.write_lamp("lamp.toml", "signals =", measure);
    let ran = bench.expect(0, &["test", "lamp.toml", "--format", "json"]);
    let last: serde_json::Value = serde_json::from_str(ran.out.lines().last().unwrap()).unwrap();
    assert_eq!(last["unguarded"], serde_json::json!({ "cases": 1, "by_middle": 0 }));
}
