//! A day of a controller in seconds: 24 hours of a MAST of 20 ms with every terminal recorded and thirty claims.
//!
//! `cargo bench -p scanrig-runtime --bench day` runs an hour and three times a day, each in a process of its own, and
//! compares the day of middle length with the goals; `-- --quick` runs the hour alone. The exit code is 1 where a goal is missed.
//! `-- --seconds N` is one run for a profiler.

#[path = "day/embedded.rs"]
mod embedded;
#[path = "day/figures.rs"]
mod figures;

use figures::{goal, measure, measure_apart, seconds_after};
use std::process::ExitCode;

/// Goals for the day: time on one core, recorded changes, memory above start, growth in percent from the hour to the day.
const MOST_SECONDS: f64 = 10.0;
const LEAST_CHANGES: u64 = 10_000_000;
const MOST_KILOBYTES: u64 = 64 << 10;
const MOST_GROWTH: f64 = 5.0;

/// The option of a run in this process.
const SECONDS: &str = "--seconds";

fn bench(quick: bool) -> Result<bool, String> {
    let hour = measure_apart(SECONDS, 1)?;
    if quick {
        return Ok(goal(hour.passed, "verdict pass"));
    }
    let mut days = [measure_apart(SECONDS, 24)?, measure_apart(SECONDS, 24)?, measure_apart(SECONDS, 24)?];
    days.sort_by(|a, b| a.busy.total_cmp(&b.busy));
    let [_, day, _] = days;
    let growth = (day.peak as f64 / hour.peak.max(1) as f64 - 1.0) * 100.0;
    let met = [
        goal(hour.passed && day.passed, "verdict pass"),
        goal(day.busy < MOST_SECONDS, &format!("24 h in less than {MOST_SECONDS} s of one core")),
        goal(day.changes >= LEAST_CHANGES, &format!("at least {LEAST_CHANGES} changes")),
        goal(day.above() <= MOST_KILOBYTES, &format!("at most {MOST_KILOBYTES} kB above start")),
        goal(
            growth <= MOST_GROWTH,
            &format!("peak grows by {growth:.1} % from 1 h to 24 h, at most {MOST_GROWTH} %"),
        ),
    ];
    Ok(met.iter().all(|met| *met))
}

fn main() -> ExitCode {
    let outcome = match seconds_after(SECONDS) {
        Some(seconds) => measure(embedded::files, seconds).map(|figures| {
            println!("figures {}", figures.line());
            true
        }),
        None => bench(std::env::args().any(|argument| argument == "--quick")),
    };
    match outcome {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}
