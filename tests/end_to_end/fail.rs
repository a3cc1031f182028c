//! What a failed case says: the figures, what came nearest, and who wrote the signal last.

use crate::project_folder::TestProject;

#[test]
fn a_failure_names_nearest_miss_and_last_writer() {
    let bench = TestProject::new();
    bench.write_lamp("slow.toml", "500 ms .. 550 ms", "490 ms .. 510 ms");
    let out = bench.expect(1, &["test", "slow.toml", "--report", "out"]).out;
    for words in [
        "10.035 ms too late",
        "margin        -10.035 ms",
        "nearest miss  the nearest time that it rose was 10.035 ms too late",
        // Task, file and line of the assignment.
        "last writer   MAST lamp.st:8",
        "in            slow.toml:10",
    ] {
        assert!(out.contains(words), "`{words}` is missing in\n{out}");
    }
    // The same facts for programs, on every way out.
    let claim = &bench.json("out/record.json")["cases"][0]["claims"][0];
    assert_eq!(claim["verdict"], "fail");
    assert_eq!(claim["last_writer"], "MAST lamp.st:8");
    assert_eq!(claim["line"], 10);
    assert!(claim["nearest_miss"].as_str().unwrap().contains("10.035 ms too late"));
    for report in ["out/junit.xml", "out/index.html"] {
        let text = bench.read(report);
        assert!(text.contains("10.035 ms too late") && text.contains("MAST lamp.st:8"), "{report}");
    }
}

#[test]
fn what_never_happened_is_not_a_pass() {
    let bench = TestProject::new();
    // The button is pressed for less than the delay: the lamp never lights.
    bench.write_lamp(
        "short.toml",
        "set = { signal = \"button\", value = true }",
        "pulse = { signal = \"button\", value = true, width = \"400 ms\" }",
    );
    let ran = bench.expect(1, &["test", "short.toml"]);
    assert!(ran.out.contains("did not rise"), "{}", ran.out);
}

#[test]
fn a_step_is_named_as_the_writer_of_what_it_drives() {
    let bench = TestProject::new();
    bench.write_lamp(
        "button.toml",
        "{ rises = { signal = \"lamp\", from = \"press\", within = \"500 ms .. 550 ms\" } }",
        "{ stays = { signal = \"button\", is = false, from = \"start\", until = \"end\" } }",
    );
    let ran = bench.expect(1, &["test", "button.toml"]);
    assert!(ran.out.contains("last writer   step press"), "{}", ran.out);
}
