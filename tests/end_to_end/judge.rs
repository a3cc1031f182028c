//! `rig judge`: every verdict again from the recorded trace alone.

use crate::project_folder::{LAMP, TestProject};

const BUS: &str = r#"format = 1
[board]
kind = "simulated"
[buses]
machine = { kind = "can", bitrate = 250_000 }
drive = { kind = "can", joins = "machine" }
"#;

/// A heartbeat that stops for a while, and what may be claimed of it.
const FRAMES: &str = r#"format = 1
title = "A heartbeat"
program = "lamp.st"
board = "bus.toml"
steps = [
  { id = "beats", at = "start + 100 ms", send = { bus = "drive", id = 0x701, data = "05", period = "50 ms", count = 10 } },
  { id = "more", at = "start + 800 ms", send = { bus = "drive", id = 0x701, data = "05", period = "50 ms", count = 4 } },
]
ends = "start + 1 s"
expect = [{ frames = { frame = "beat", count = "$count", cycle = "$cycle", max-gap = "$gap", from = "beats" } }]
[frames]
beat = { bus = "machine", id = 0x701 }
[rows]
right = { count = 14, cycle = "49 ms .. 260 ms", gap = "260 ms" }
more = { count = 15, cycle = "49 ms .. 260 ms", gap = "260 ms" }
even = { count = 14, cycle = "49 ms .. 51 ms", gap = "260 ms" }
always = { count = 14, cycle = "49 ms .. 260 ms", gap = "60 ms" }
"#;

#[test]
fn verdict_and_trace_hash_come_again() {
    let bench = TestProject::new();
    bench.write_lamp("slow.toml", "500 ms .. 550 ms", "490 ms .. 510 ms");
    bench.write(
        "drop.toml",
        "format = 1\n[board]\nkind = \"simulated\"\n[faults]\ndropped = { chance = 1.0 }\n",
    );
    bench.write_lamp("dropped.toml", "program =", "board = \"drop.toml\"\nprogram =");
    bench.write(
        "late.toml",
        "format = 1\n[board]\nkind = \"simulated\"\n[faults]\nlate = { chance = 1.0, by = \"40 ms\" }\n",
    );
    bench.write_lamp("unsure.toml", "program =", "board = \"late.toml\"\nprogram =");
    let text = LAMP.replace("\"500 ms .. 550 ms\"", "\"$limit\"");
    let rows = "[rows]\nwide = { limit = \"400 ms .. 600 ms\" }\nearly = { limit = \"1 ms .. 2 ms\" }\n";
    bench.write("rows.toml", &format!("{text}{rows}"));
    bench.write("bus.toml", BUS);
    bench.write("frames.toml", FRAMES);
    let plans = ["lamp.toml", "slow.toml", "dropped.toml", "unsure.toml", "rows.toml", "frames.toml"];
    let ran = bench.expect(4, &[&["test"], &plans[..], &["--report", "out"]].concat());
    let record = bench.json("out/record.json");
    let cases = record["cases"].as_array().unwrap();
    let verdicts: Vec<&str> = cases.iter().map(|case| case["verdict"].as_str().unwrap()).collect();
    let frames = ["pass", "fail", "fail", "fail"];
    assert_eq!(verdicts, [&["pass", "fail", "error", "inconclusive", "pass", "fail"], &frames[..]].concat());
    for case in cases {
        let (plan, trace) = (case["plan"].as_str().unwrap(), case["trace_file"].as_str().unwrap());
        let code = match case["verdict"].as_str().unwrap() {
            "pass" => 0,
            "fail" => 1,
            "inconclusive" => 3,
            _ => 4,
        };
        // The same words as in the run: claims, margins, nearest miss, last writer.
        let judged = bench.expect(code, &["judge", plan, &format!("out/{trace}")]);
        let reported: Vec<&str> = judged.out.lines().collect();
        assert!(reported[0].ends_with(case["name"].as_str().unwrap()), "{}", judged.out);
        if code != 0 {
            // All but the first line, in which the run numbers its cases.
            for line in reported[1..].iter().filter(|line| !line.starts_with("  trace ")) {
                assert!(ran.out.contains(line), "`{line}` was not reported by the run:\n{}", ran.out);
            }
        }
        let hash = case["trace_sha256"].as_str().unwrap();
        assert!(judged.out.contains(hash), "{hash} is missing in\n{}", judged.out);
    }
}

#[test]
fn traces_of_the_library_are_judged_alike() {
    let bench = TestProject::new();
    let library = crate::project_folder::root().join("plans/library");
    let only = "fallback or filter or oven or reset or default-mast or alarms or invariants or buses";
    bench.expect(0, &["test", library.to_str().unwrap(), "--only", only, "--report", "out"]);
    let record = bench.json("out/record.json");
    let cases = record["cases"].as_array().unwrap();
    // A case that is refused at check, as its plan says, has no trace.
    let traced: Vec<_> = cases.iter().filter_map(|case| Some((case, case["trace_file"].as_str()?))).collect();
    assert!(traced.len() > 10);
    for (case, trace) in traced {
        let trace = format!("out/{trace}");
        let judged = bench.expect(0, &["judge", case["plan"].as_str().unwrap(), &trace]);
        assert!(judged.out.contains(case["trace_sha256"].as_str().unwrap()), "{}", judged.out);
        // The dump beside it says as much.
        let dump = trace.replace(".trace", ".vcd");
        bench.expect(0, &["judge", case["plan"].as_str().unwrap(), &dump]);
    }
}

#[test]
fn a_changed_plan_is_judged_and_said_to_have_changed() {
    let bench = TestProject::new();
    bench.expect(0, &["test", "lamp.toml", "--report", "out"]);
    bench.write_lamp("lamp.toml", "500 ms .. 550 ms", "490 ms .. 510 ms");
    let judged = bench.expect(1, &["judge", "lamp.toml", "out/traces/lamp.trace"]);
    assert!(
        judged.out.contains("10.035 ms too late") && judged.out.contains("the plan has changed"),
        "{}",
        judged.out
    );
}

#[test]
fn traces_of_other_plans_are_refused() {
    let bench = TestProject::new();
    bench.expect(0, &["test", "lamp.toml", "--report", "out"]);
    // Its cases are rows: none has this trace's name.
    let text = LAMP.replace("\"500 ms .. 550 ms\"", "\"$limit\"");
    bench.write("rows.toml", &format!("{text}[rows]\nwide = {{ limit = \"400 ms .. 600 ms\" }}\n"));
    bench.refused(&["judge", "rows.toml", "out/traces/lamp.trace"], &["R0203", "lamp", "rows.toml"]);
    // It claims something of a signal that this trace does not have.
    bench.write_lamp("other.toml", "lamp = \"%QX0.4\"", "lamp = \"%QX0.4\", horn = \"%QX0.5\"");
    bench.write(
        "other.toml",
        &bench.read("other.toml").replace("{ stays = { signal = \"lamp\"", "{ stays = { signal = \"horn\""),
    );
    bench.refused(&["judge", "other.toml", "out/traces/lamp.trace"], &["P0505", "horn"]);
}

#[test]
fn damaged_traces_are_refused() {
    let bench = TestProject::new();
    bench.expect(0, &["test", "lamp.toml", "--report", "out"]);
    let whole = std::fs::read(bench.path("out/traces/lamp.trace")).unwrap();
    let judge = |bytes: &[u8]| {
        std::fs::write(bench.path("damaged.trace"), bytes).unwrap();
        bench.refused(&["judge", "lamp.toml", "damaged.trace"], &["damaged.trace is not a complete trace"]);
    };
    judge(b"");
    judge(LAMP.as_bytes());
    for length in [1, 9, 10, 100, whole.len() / 2, whole.len() - 1] {
        judge(&whole[..length]);
    }
    for place in (0..whole.len()).step_by(whole.len() / 40) {
        let mut bytes = whole.clone();
        bytes[place] ^= 0x10;
        judge(&bytes);
    }
    let mut longer = whole.clone();
    longer.push(0);
    judge(&longer);
    judge(&[&whole[..], &whole[..]].concat());
}
