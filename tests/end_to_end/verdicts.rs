//! Exit codes 0, 1, 3 and 4: what the cases came to.

use crate::project_folder::{LAMP, TestProject};

/// A board that makes trouble.
fn board(faults: &str) -> String {
    format!("format = 1\n[board]\nkind = \"simulated\"\n[faults]\n{faults}\n")
}

#[test]
fn all_passed_is_0() {
    let bench = TestProject::new();
    let ran = bench.expect(0, &["test", "lamp.toml"]);
    assert!(ran.out.contains("PASS") && ran.err.is_empty(), "{}{}", ran.out, ran.err);
    assert!(ran.out.contains("Summary: 1 passed, 0 failed, 0 inconclusive, 0 not applicable"));
}

#[test]
fn a_failed_case_is_1_whatever_else_passed() {
    let bench = TestProject::new();
    bench.write_lamp("slow.toml", "500 ms .. 550 ms", "490 ms .. 510 ms");
    let ran = bench.expect(1, &["test", "slow.toml", "lamp.toml"]);
    assert!(ran.out.contains("Summary: 1 passed, 1 failed"), "{}", ran.out);
}

#[test]
fn an_instrument_that_is_not_good_enough_is_3() {
    let bench = TestProject::new();
    // io:STD-HSC figures need pulses that no line of the simulated board emits.
    bench.write_lamp("fast.toml", "program =", "needs = [\"pulse >= 5000 MHz\"]\nprogram =");
    let ran = bench.expect(3, &["test", "fast.toml", "lamp.toml"]);
    assert!(
        ran.out.contains("INCONCLUSIVE") && ran.out.contains("the board emits pulses up to"),
        "{}",
        ran.out
    );
    assert!(ran.out.contains("Summary: 1 passed, 0 failed, 1 inconclusive"), "{}", ran.out);
}

#[test]
fn a_claim_finer_than_what_is_known_is_3() {
    let bench = TestProject::new();
    // Edges become known up to 40 ms late: neither inside nor outside of a window of 50 ms, 20 ms from its ends.
    bench.write("late.toml", &board("late = { chance = 1.0, by = \"40 ms\" }"));
    let ran = bench.expect(3, &["test", "lamp.toml", "--board", "late.toml"]);
    assert!(ran.out.contains("uncertainty") && !ran.out.contains("PASS"), "{}", ran.out);
    // The same instrument is good enough for a coarser claim.
    bench.write_lamp("coarse.toml", "500 ms .. 550 ms", "300 ms .. 900 ms");
    bench.write("coarse.toml", &bench.read("coarse.toml").replace("press + 500 ms", "press + 300 ms"));
    bench.expect(0, &["test", "coarse.toml", "--board", "late.toml"]);
}

#[test]
fn trouble_of_the_rig_is_4() {
    let bench = TestProject::new();
    for (faults, words) in [
        ("dropped = { chance = 1.0 }", "events of channel"),
        ("lost = { chance = 1.0, duration = \"10 ms\" }", "its device is gone"),
        ("failed-calls = { chance = 1.0 }", "failed"),
    ] {
        bench.write("bad.toml", &board(faults));
        let ran = bench.expect(4, &["test", "lamp.toml", "--board", "bad.toml"]);
        assert!(ran.out.contains("ERROR") && ran.out.contains(words), "{faults}\n{}", ran.out);
        assert!(ran.out.contains("0 passed") && ran.out.contains("1 error"), "{}", ran.out);
    }
}

#[test]
fn trouble_of_the_rig_outweighs_a_failure() {
    let bench = TestProject::new();
    bench.write("bad.toml", &board("dropped = { chance = 1.0 }"));
    bench.write_lamp("on-a-bad-board.toml", "program =", "board = \"bad.toml\"\nprogram =");
    bench.write_lamp("slow.toml", "500 ms .. 550 ms", "490 ms .. 510 ms");
    bench.expect(4, &["test", "slow.toml", "on-a-bad-board.toml", "lamp.toml"]);
}

#[test]
fn a_refused_command_and_a_case_without_end_are_4() {
    let bench = TestProject::new();
    let empty =
        LAMP.replace("program = \"lamp.st\"", "program = \"lamp.st\"\nsettings = { initial = \"empty\" }");
    let run = empty.replace("set = { signal = \"button\", value = true }", "command = \"run\"");
    bench.write("refused.toml", &run);
    let ran = bench.expect(4, &["test", "refused.toml"]);
    assert!(ran.out.contains("the command of step `press` was refused"), "{}", ran.out);
    bench.write_lamp("long.toml", "program =", "ends = \"start + 10 s\"\ntimeout = \"5 s\"\nprogram =");
    let ran = bench.expect(4, &["test", "long.toml"]);
    assert!(ran.out.contains("`timeout` of 5 s"), "{}", ran.out);
}

#[test]
fn what_does_not_apply_is_said_with_its_reason() {
    let bench = TestProject::new();
    bench.write_lamp("m251.toml", "program =", "profiles = [\"m251-2024\"]\nprogram =");
    bench.write(
        "board.toml",
        "format = 1\n[subject]\nprofile = \"m241-2014\"\n[board]\nkind = \"simulated\"\n",
    );
    let ran = bench.rig(&["test", "m251.toml", "lamp.toml", "--board", "board.toml"]);
    assert_eq!(ran.code, Some(0));
    assert!(ran.out.contains("holds for m251-2024, the controller is m241-2014"), "{}", ran.out);
    assert!(ran.out.contains("Summary: 1 passed, 0 failed, 0 inconclusive, 1 not applicable"), "{}", ran.out);
}
