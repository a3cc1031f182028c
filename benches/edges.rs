//! Edges of a fast counter in virtual time: a quadrature of 100 kHz on two lines, each edge of which is recorded, filtered
//! and counted, while the program runs its scans.
//!
//! `cargo bench -p scanrig-runtime --bench edges`; `-- --seconds N` for another length. The exit code is 1 where a goal is
//! missed. Time is that of the processor: a busy host makes the wall's longer.

#[path = "../rig/runtime/tests/common/texts.rs"]
mod texts;

use record::Verdict;
use scanrig_runtime::{ClockKind, RunOptions};
use std::process::ExitCode;
use std::sync::atomic::AtomicBool;
use std::time::Instant;
use texts::Texts;

/// Edges a second of the processor's time that the rig takes at least.
const LEAST: f64 = 2_000_000.0;

/// Edges a second of modelled time: four in each period of 100 kHz.
const RATE: u64 = 400_000;

const PROGRAM: &str = "PROGRAM MAIN
VAR
    hsc : HSCMain_M241;
END_VAR
hsc(HSC_REF_IN := HSC0, F_Enable := TRUE, F_Preset := TRUE, EN_Compare := TRUE, EN_Out0 := TRUE);
END_PROGRAM
";

/// The processor's time of this process, in seconds.
fn processor() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields = stat.rsplit(')').next().unwrap_or_default().split_whitespace();
    // User and system, in the kernel's ticks of 10 ms.
    let ticks: u64 = fields.skip(11).take(2).filter_map(|field| field.parse::<u64>().ok()).sum();
    ticks as f64 / 100.0
}

fn bench(seconds: u64) -> bool {
    let counts = RATE * seconds;
    let plan = format!(
        "format = 1
title = \"A quadrature of 100 kHz\"
program = \"count.st\"
signals = {{ A = \"%IX0.0\", B = \"%IX0.1\", value = \"MAIN.hsc.CurrentValue\" }}
ends = \"start + {} s\"
timeout = \"{} s\"
steps = [{{ id = \"turn\", at = \"start + 1 s\", encoder = {{ a = \"A\", b = \"B\", lines = 1000, moves = [{{ by = {counts}, speed = \"{RATE} Hz\" }}] }} }}]
expect = [{{ value = {{ of = \"value\", is = {counts}, when = \"end\" }} }}]
[settings.expert]
HSC0 = {{ kind = \"main-dual\", a = \"%IX0.0\", b = \"%IX0.1\", inputs = \"quadrature-x4\", mode = \"free-large\", thresholds = [100_000, 200_000, 300_000, 400_000], reflex0 = \"%QX0.0\", reflex0-zones = [1, 3] }}
",
        seconds + 3,
        seconds + 60
    );
    let files = [("plan.toml", plan.as_str()), ("count.st", PROGRAM)];
    let interrupt = AtomicBool::new(false);
    let options = RunOptions::new(ClockKind::Virtual, &interrupt);
    let (wall, before) = (Instant::now(), processor());
    let result = Texts(&files).run(1, &options);
    let (took, passed) = (processor() - before, result.record.verdict == Verdict::Pass);
    let rate = counts as f64 / took.max(0.01);
    println!(
        "{counts} edges in {took:.2} s of the processor, {:.2} s of the wall: {rate:.0} a second",
        wall.elapsed().as_secs_f64()
    );
    let all = [(passed, "every edge is counted"), (rate >= LEAST, "at least 2,000,000 edges a second")];
    for (met, words) in all {
        println!("{} {words}", if met { "met   " } else { "MISSED" });
    }
    all.iter().all(|(met, _)| *met)
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().collect();
    let seconds = arguments.iter().position(|argument| argument == "--seconds");
    let seconds = seconds.and_then(|at| arguments.get(at + 1)?.parse().ok());
    if bench(seconds.unwrap_or(10)) { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
