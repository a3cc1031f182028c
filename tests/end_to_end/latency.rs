//! `rig bench latency`: figures that are shown, and kept for the runs that follow.

use crate::project_folder::TestProject;
use serde_json::Value as Json;

fn bench(state: &TestProject, args: &[&str]) -> crate::project_folder::CommandOutput {
    let mut command = state.command(&[&["bench", "latency"], args].concat());
    command.env("XDG_STATE_HOME", state.path("state"));
    crate::project_folder::run(command)
}

#[test]
fn figures_for_a_program() {
    let state = TestProject::new();
    let ran = bench(&state, &["--interval", "200 us", "--count", "300", "--format", "json"]);
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    let json: Json = serde_json::from_str(&ran.out).unwrap();
    assert_eq!((&json["count"], &json["interval_us"]), (&300.into(), &200.0.into()));
    let of = |name: &str| json[name].as_f64().unwrap_or_else(|| panic!("{name}: {json}"));
    assert!(of("min_us") >= 0.0 && of("min_us") <= of("p50_us") && of("p50_us") <= of("p99_us"), "{json}");
    assert!(of("p99_us") <= of("p99_99_us") && of("p99_99_us") <= of("max_us"), "{json}");
    let classes = json["histogram"].as_array().unwrap();
    let sum: u64 = classes.iter().map(|class| class[1].as_u64().unwrap()).sum();
    assert_eq!(sum, 300);
    assert!(classes.is_sorted_by_key(|class| class[0].as_u64().unwrap()), "{json}");
    assert!((classes[0][0].as_f64().unwrap() - of("min_us")).abs() <= 1.0, "{json}");
    // So few say nothing about the worst of 10 000.
    assert_eq!(json["kept"], Json::Null);
    assert!(ran.err.contains("note: not kept: less than 10000"), "{}", ran.err);
    assert!(!state.path("state").exists());
}

#[test]
fn figures_are_kept_with_the_machine_that_they_are_of() {
    let state = TestProject::new();
    let ran = bench(&state, &["--interval", "50 us", "--count", "10000", "--priority", "0"]);
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    assert!(
        ran.out.starts_with("10000 wake-ups every 50 us, without real-time priority\nlate by: p50 "),
        "{ran:?}"
    );
    assert!(ran.out.contains("state/rig/latency.json"), "{}", ran.out);
    let kept = state.json("state/rig/latency.json");
    assert_eq!((&kept["kind"], &kept["figures"][0]["count"]), (&"latency".into(), &10_000.into()));
    assert_eq!(kept["machine"][0][0], "kernel");
    assert!(kept["machine"][0][1].as_str().unwrap().starts_with("Linux "), "{kept}");
    // The doctor reports them, and that they are no longer those of this machine.
    let doctor = |state: &TestProject| {
        let mut command = state.command(&["doctor"]);
        command.env("XDG_STATE_HOME", state.path("state"));
        crate::project_folder::run(command).out
    };
    assert!(doctor(&state).contains("good  wake-up latency   p99 "), "{}", doctor(&state));
    let was = state.read("state/rig/latency.json");
    state.write("state/rig/latency.json", &was.replace("\"Linux ", "\"Linux 2.6, not "));
    assert!(doctor(&state).contains("-     wake-up latency   measured when the kernel was `Linux 2.6, not "));
    state.write("state/rig/latency.json", &was[..was.len() / 2]);
    assert!(doctor(&state).contains("the figures cannot be read"));
}

#[test]
fn what_cannot_be_measured_is_refused() {
    let state = TestProject::new();
    for args in [
        ["--interval", "0 s"],
        ["--interval", "soon"],
        ["--interval", "61 s"],
        ["--count", "0"],
        ["--count", "1000000001"],
        ["--priority", "1"],
        ["--priority", "98"],
        ["--cpus", "1023"],
        ["--cpus", "0,1024"],
    ] {
        state.refused(&[&["bench", "latency"], &args[..]].concat(), &["error[R0250]", args[0]]);
    }
}

#[test]
fn without_the_devices_of_a_board_nothing_is_measured() {
    let state = TestProject::new();
    state.write("simulated.toml", "format = 1\n[board]\nkind = \"simulated\"\n");
    state.write(
        "gpio.toml",
        "format = 1\n[board]\nkind = \"real\"\ncheck = { out = \"a\", in = \"b\" }\n[chips]\nmain = { label = \"no such chip\" }\n\
         [channels]\na = { kind = \"digital\", line = 0, drives = true }\nb = { kind = \"digital\", line = 1 }\n",
    );
    for what in ["scan", "loopback"] {
        let refused = |file: &str, words: &str| state.refused(&["bench", what, "--board", file], &[words]);
        refused("simulated.toml", "error[R0253]: `simulated.toml` has no real lines");
        refused("gpio.toml", "error[B0170]: no GPIO chip has the label \"no such chip\"");
        refused("missing.toml", "error[R0201]");
    }
}
