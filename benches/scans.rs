//! Scans without end: a million, or as many as `-- --scans N` asks for, in virtual time and in one case.
//!
//! Behind the first tenth nothing is allocated and memory does not grow, however many scans there are; and every edge
//! that an output made is one that an input saw, or one that was reported lost. `cargo bench -p scanrig-runtime
//! --bench scans`; the exit code is 1 where one of these does not hold.

#[path = "../rig/runtime/tests/common/texts.rs"]
mod texts;

use controller::TaskKind;
use counting::Counting;
use scanrig_runtime::executor::clock::Clock;
use scanrig_runtime::subject::{Subject, SubjectExt};
use signal::{Span, Time, Value};
use std::process::ExitCode;
use std::time::Instant;
use texts::Texts;

#[global_allocator]
static COUNTING: Counting = Counting;

/// An output that turns in each cycle, wired back to an input whose edges are counted.
const PROGRAM: &str = "PROGRAM MAIN
VAR
    out AT %QX0.0 : BOOL;
    back AT %IX0.0 : BOOL;
    made : DINT;
    seen : DINT;
    level : INT;
    rise : R_TRIG;
    fall : F_TRIG;
    delay : TON;
    parts : CTU;
END_VAR
rise(CLK := back);
fall(CLK := back);
IF rise.Q OR fall.Q THEN seen := seen + 1; END_IF;
out := NOT out;
made := made + 1;
level := (level + 7) MOD 300;
delay(IN := NOT delay.Q, PT := T#100ms);
parts(CU := delay.Q, RESET := parts.Q, PV := 5);
END_PROGRAM
";

const BOARD: &str = "format = 1
title = \"An output wired back to an input\"
[board]
kind = \"simulated\"
[[wires]]
from = \"Q0\"
to = \"I0\"
delay = \"1 ms\"
";

/// Time between two scans: longer than wire and filter of the input together.
const INTERVAL: Span = Span::from_millis(10);

/// The most that the memory may grow behind the first tenth, in kB.
const MOST_GROWTH: u64 = 256;

fn kilobytes(field: &str) -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix(field)?.strip_prefix(':'));
    line.and_then(|line| line.split_whitespace().next()?.parse().ok()).unwrap_or_default()
}

/// What it takes to read how large the memory is.
const LOOKING: u64 = 8;

/// What was found at an instant.
#[derive(Clone, Copy, Debug, Default)]
struct Found {
    allocations: u64,
    resident: u64,
}

/// Virtual time that looks at allocations and memory at some of its instants.
struct Looking {
    now: Time,
    at: [Time; 2],
    found: [Option<Found>; 2],
}

impl Clock for Looking {
    fn wait_until(&mut self, due: Time) -> Time {
        self.now = self.now.max(due);
        for (at, found) in self.at.iter().zip(&mut self.found) {
            if found.is_none() && self.now >= *at {
                let allocations = counting::of_all_threads();
                *found = Some(Found { allocations, resident: kilobytes("VmRSS") });
            }
        }
        self.now
    }

    fn now(&mut self) -> Time {
        self.now
    }

    fn is_exact(&self) -> bool {
        true
    }

    fn name(&self) -> &'static str {
        "looking"
    }
}

fn goal(met: bool, words: &str) -> bool {
    println!("{} {words}", if met { "met   " } else { "MISSED" });
    met
}

fn number(subject: &dyn Subject, name: &str) -> i64 {
    let probe = subject.observable(name).map(|found| found.probe);
    match probe.map(|probe| subject.read(&probe)) {
        Some(Value::Int(number)) => number,
        _ => 0,
    }
}

fn bench(scans: i64) -> bool {
    let lasts = Span::from_nanos(INTERVAL.as_nanos() * scans);
    let seconds = lasts.as_nanos() / 1_000_000_000;
    let plan = format!(
        "format = 1
title = \"Scans without end\"
program = \"scans.st\"
board = \"board.toml\"
signals = {{ made = {{ path = \"MAIN.made\", at-most-every = \"1 h\" }}, seen = {{ path = \"MAIN.seen\", at-most-every = \"1 h\" }} }}
ends = \"start + {seconds} s\"
timeout = \"{} s\"
expect = [{{ state = {{ stays = \"RUNNING\", from = \"start\", until = \"end\" }} }}]
",
        seconds + 60
    );
    let files = [("plan.toml", plan.as_str()), ("scans.st", PROGRAM), ("board.toml", BOARD)];
    let faster =
        |config: &mut controller::Config| config.tasks[0].kind = TaskKind::Cyclic { interval: INTERVAL };
    let (mut model, mut parts) = Texts(&files).parts_with(1, faster);
    let instant = |tenths: i64| Time::ZERO + Span::from_nanos(lasts.as_nanos() / 10 * tenths);
    let mut clock = Looking { now: Time::ZERO, at: [instant(1), instant(10)], found: [None; 2] };
    let began = Instant::now();
    let ran = parts.run(&mut clock, &mut model);
    let wall = began.elapsed();
    let cycles: u64 = model.figures().iter().map(|(_, _, figures)| figures.cycles).sum();
    println!(
        "{cycles} scans in {:.2} s, {} ns each",
        wall.as_secs_f64(),
        wall.as_nanos() / u128::from(cycles.max(1))
    );
    let [Some(first), Some(last)] = clock.found else { return goal(false, "the case lasts to its end") };
    let (made, seen) = (number(&model, "MAIN.made"), number(&model, "MAIN.seen"));
    let under_way = made - seen - ran.dropped as i64;
    let allocated = last.allocations - first.allocations;
    let grown = last.resident.saturating_sub(first.resident);
    let all = [
        goal(ran.fault.is_none(), &format!("no trouble: {:?}", ran.fault)),
        goal(cycles >= scans as u64, &format!("at least {scans} scans")),
        goal(
            allocated <= LOOKING,
            &format!(
                "{allocated} allocations behind the first tenth, at most {LOOKING} to look at the memory"
            ),
        ),
        goal(
            grown <= MOST_GROWTH,
            &format!("{grown} kB more memory behind the first tenth, {MOST_GROWTH} at most"),
        ),
        goal(
            (0..=1).contains(&under_way),
            &format!("{made} edges made, {seen} seen, {} reported lost, {under_way} under way", ran.dropped),
        ),
    ];
    all.iter().all(|met| *met)
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().collect();
    let scans = arguments.iter().position(|argument| argument == "--scans");
    let scans = scans.and_then(|at| arguments.get(at + 1)?.parse().ok());
    if bench(scans.unwrap_or(1_000_000)) { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
