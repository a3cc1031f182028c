//! Whatever a file says is read, or refused: nothing of it is passed over while the run is green.

use crate::project_folder::{LAMP, TestProject};

const BOARD: &str =
    "format = 1\n[board]\nkind = \"simulated\"\n[buses]\nmachine = { kind = \"can\", bitrate = 250_000 }\n";

/// A plan that sends a frame on a bus of its board.
fn frames(bus: &str) -> String {
    let send = format!(
        "{{ id = \"frame\", at = \"press + 1 s\", send = {{ bus = \"{bus}\", id = 0x181, data = \"01\" }} }}"
    );
    LAMP.replace("program =", "board = \"bench.toml\"\nprogram =")
        .replace("value = true } },\n]", &format!("value = true }} }},\n  {send},\n]"))
}

#[test]
fn a_bus_that_the_plans_own_board_lacks_is_an_error() {
    let bench = TestProject::new();
    bench.write("bench.toml", BOARD);
    bench.write("right.toml", &frames("machine"));
    bench.expect(0, &["test", "right.toml"]);
    bench.write("wrong.toml", &frames("machin"));
    for command in ["test", "check"] {
        let ran = bench.expect(2, &[command, "wrong.toml", "lamp.toml"]);
        for word in ["R0272", "the board has no bus `machin`", "did you mean `machine`?", "wrong.toml:"] {
            assert!(ran.err.contains(word), "{command}: `{word}` is missing in\n{}", ran.err);
        }
    }
    // Another bench may lack a bus: there the case does not apply.
    bench.write("other.toml", "format = 1\n[board]\nkind = \"simulated\"\n");
    let ran = bench.expect(0, &["test", "right.toml", "lamp.toml", "--board", "other.toml"]);
    assert!(ran.out.contains("1 passed") && ran.out.contains("1 not applicable"), "{}", ran.out);
}

#[test]
fn a_run_in_which_no_case_was_judged_is_no_pass() {
    let bench = TestProject::new();
    bench.write_lamp("other.toml", "format = 1", "format = 1\nprofiles = [\"m251-2024\"]");
    bench.write(
        "m241.toml",
        "format = 1\n[board]\nkind = \"simulated\"\n[subject]\nprofile = \"m241-2019\"\n",
    );
    let ran = bench.expect(2, &["test", "other.toml", "--board", "m241.toml", "--report", "out"]);
    assert!(ran.err.contains("R0231") && ran.out.contains("1 not applicable"), "{}{}", ran.out, ran.err);
    // A case that is judged beside it is enough.
    bench.expect(0, &["test", "other.toml", "lamp.toml", "--board", "m241.toml"]);
    bench.expect(2, &["test", "other.toml", "lamp.toml", "--board", "m241.toml", "--only", "other"]);
    // A part may have no case that is judged, and none at all: the merged run decides.
    for (part, code) in [("1/3", 0), ("2/3", 0), ("3/3", 0)] {
        let place = format!("out{}", &part[..1]);
        let args =
            ["test", "other.toml", "lamp.toml", "--board", "m241.toml", "--shard", part, "--report", &place];
        bench.expect(code, &args);
    }
    bench.expect(0, &["report", "--merge", "--out", "whole", "out1", "out2", "out3"]);
    bench.expect(0, &["test", "other.toml", "--board", "m241.toml", "--shard", "1/1", "--report", "alone"]);
    let merged = bench.expect(2, &["report", "--merge", "--out", "one", "alone"]);
    assert!(merged.err.contains("R0231"), "{}", merged.err);
}

#[test]
fn a_need_of_an_operator_counts_without_a_question() {
    let bench = TestProject::new();
    bench.write_lamp("watched.toml", "format = 1", "format = 1\nneeds = [\"operator\"]");
    let ran = bench.expect(0, &["test", "watched.toml", "lamp.toml", "--status-level", "all"]);
    assert!(ran.out.contains("nobody can be asked") && ran.out.contains("1 not applicable"), "{}", ran.out);
}

#[test]
fn a_channel_is_not_taken_by_a_name_that_several_have() {
    let bench = TestProject::new();
    let rows = "time [s],button,lamp,lamp\n0,0,0,0\n1,1,0,0\n1.5,1,1,0\n3,1,1,0\n";
    bench.write("two.csv", rows);
    let place = ["judge", "lamp.toml", "two.csv", "--at", "press=button rises", "--period", "1 ms"];
    bench.refused(&place, &["R0179", "2 channels of the capture have the name `lamp`", "lamp, lamp_2"]);
    // Whoever says which one is meant is believed: the second one never rises.
    let said = |map| bench.rig(&[&place[..], &["--map", map]].concat());
    assert!(said("lamp=lamp").code != Some(2), "{}", said("lamp=lamp").err);
    assert_eq!(said("lamp_2=lamp").code, Some(1), "{}", said("lamp_2=lamp").out);
}
