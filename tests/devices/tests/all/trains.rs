//! Pulses on real lines as a plan analyses them: position, profile and jitter, held against who made them and against the
//! counter of the model behind the same lines.

use devices::{Lab, MAIN, PATIENCE, rig, wait_for};
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

const BOARD: &str = r#"format = 1
title = "Pulses with a direction"
[board]
kind = "real"
unresponsive-after = "5 s"
[chips]
main = { label = "rig-gpio" }
[channels]
I0 = { kind = "digital", line = 0 }
I1 = { kind = "digital", line = 1 }
I2 = { kind = "digital", line = 2 }
Q0 = { kind = "digital", line = 8 }
Q1 = { kind = "digital", line = 9 }
[guard]
limit = "5 s"
[realtime]
late = "10 s"
"#;

/// A counter takes pulses while its second line is 1 as counts down.
const PLAN: &str = r#"format = 1
title = "12 pulses forwards and 4 back"
board = "board.toml"
program-text = """
PROGRAM MAIN
VAR counter : HSCMain_M241; ready AT %QX0.0, seen AT %QX0.1, line AT %IX0.0 : BOOL; END_VAR
counter(HSC_REF_IN := HSC0, F_Enable := TRUE, F_Preset := TRUE);
ready := counter.Validity;
seen := line;
END_PROGRAM
"""
settings = { filter = "0 ms", expert = { HSC0 = { kind = "main-dual", a = "%IX0.0", b = "%IX0.1", inputs = "pulse-direction", mode = "free-large", preset = 0 } } }
signals = { pulses = "%IX0.0", back = "%IX0.1", over = "%IX0.2" }
steps = [
  { id = "first", when = { signal = "pulses", edge = "rises", from = "start", within = "60 s" } },
  { id = "turned", when = { signal = "back", edge = "rises", from = "first", within = "60 s" } },
  { id = "over", when = { signal = "over", edge = "rises", from = "turned", within = "60 s" } },
]
ends = "over + 100 ms"
expect = [
  { position = { signal = "pulses", direction = "back", inverted = true, is = 12, from = "start", until = "turned" } },
  { position = { signal = "pulses", direction = "back", inverted = true, is = 8, from = "start" } },
  { position = { signal = "HSC0.value", is = 8, from = "start" } },
]
measure = [
  { name = "grid", jitter-of = "pulses", from = "start", until = "turned" },
  { name = "periods", jitter-of = "pulses", compares = "periods", from = "start", until = "turned" },
  { name = "position", position-of = { signal = "pulses", direction = "back", inverted = true }, from = "turned", nominal = -4, tolerance = 0 },
  { name = "profile", profile-of = { signal = "pulses", points = [{ at = "0 ms", frequency = "25 Hz" }] }, from = "first", until = "turned - 1 s" },
]
"#;

/// Between pulses and what has to come certainly before or after them.
const QUIET: Duration = Duration::from_millis(1_000);

/// A pulse, and between which instants it began, in seconds. Each edge waits until the controller has seen the one before: a
/// chip that is simulated may take two for one.
fn pulse(since: Instant) -> (f64, f64) {
    let before = since.elapsed();
    MAIN.line(0).pull(true);
    let after = since.elapsed();
    wait_for("the pulse is seen", PATIENCE, || MAIN.line(9).value());
    MAIN.line(0).pull(false);
    wait_for("its end is seen", PATIENCE, || !MAIN.line(9).value());
    (before.as_secs_f64(), after.as_secs_f64())
}

/// From the greatest to the least.
fn span(all: &[f64]) -> f64 {
    all.iter().copied().fold(f64::MIN, f64::max) - all.iter().copied().fold(f64::MAX, f64::min)
}

/// The narrowest band around an even grid: its slope is that of the way between some two edges.
fn band(edges: &[f64]) -> f64 {
    let mut least = f64::INFINITY;
    for i in 0..edges.len() {
        for j in i + 1..edges.len() {
            let period = (edges[j] - edges[i]) / (j - i) as f64;
            let away: Vec<f64> = edges.iter().enumerate().map(|(n, at)| at - n as f64 * period).collect();
            least = least.min(span(&away));
        }
    }
    least
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn position_profile_and_jitter_of_real_edges_are_what_was_done() {
    let _lab = Lab::enter();
    let folder = PathBuf::from("/tmp/trains");
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("board.toml"), BOARD).unwrap();
    std::fs::write(folder.join("plan.toml"), PLAN).unwrap();
    let mut ran = Command::new(rig())
        .args(["test", "plan.toml", "--report", "report"])
        .current_dir(&folder)
        .env("XDG_STATE_HOME", &folder)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    wait_for("the counter counts", PATIENCE * 2, || {
        MAIN.line(8).value() || ran.try_wait().unwrap().is_some()
    });
    let since = Instant::now();
    let forwards: Vec<(f64, f64)> = (0..12).map(|_| pulse(since)).collect();
    // On a busy machine it is known of an edge to within a fifth of a second when it came.
    std::thread::sleep(QUIET);
    MAIN.line(1).pull(true);
    std::thread::sleep(QUIET);
    for _ in 0..4 {
        pulse(since);
    }
    std::thread::sleep(QUIET);
    MAIN.line(2).pull(true);
    let ran = ran.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&ran.stdout).into_owned() + &String::from_utf8_lossy(&ran.stderr);
    assert_eq!(ran.status.code(), Some(0), "{said}");

    // An edge was stamped while its line was pulled, so that each is known to within that.
    let unsure = forwards.iter().map(|(before, after)| after - before).fold(0.0, f64::max);
    let edges: Vec<f64> = forwards.iter().map(|(before, _)| *before).collect();
    let periods: Vec<f64> = edges.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let record = std::fs::read_to_string(folder.join("report/record.json")).unwrap();
    let record: serde_json::Value = serde_json::from_str(&record).unwrap();
    let taken = |name: &str| {
        let taken = record["cases"][0]["measurements"].as_array().unwrap();
        let taken = taken.iter().find(|taken| taken["name"] == name).unwrap();
        [0, 1].map(|end| taken["value"][end].as_f64().unwrap_or(f64::INFINITY))
    };
    // Nobody follows a steady frequency that stops: at least the gap is seen.
    let [low, high] = taken("profile");
    println!("figure: off a steady 25 Hz by {low:.3} .. {high:.3} Hz");
    assert!(low <= high && high > 1.0, "{low} .. {high}");
    for (name, own) in [("grid", band(&edges)), ("periods", span(&periods))] {
        let [low, high] = taken(name).map(|nanos| nanos / 1e9);
        println!(
            "figure: jitter of {name} {:.3} ms, made {:.3} ms, known to {:.3} ms",
            high * 1e3,
            own * 1e3,
            unsure * 1e3
        );
        let near = 2.0 * unsure + 1e-6;
        assert!(low <= own + near && high >= own - near, "{name}: {low} .. {high} and not {own} ± {near}");
    }
}
