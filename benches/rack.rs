//! A day of a controller with a rack of modules in seconds: 24 hours of a MAST of 20 ms with 14 modules of 200 channels, 40 of
//! them analogue and each at a plant, and eight level loops.
//!
//! `cargo bench -p scanrig-runtime --bench rack` runs an hour and three times a day, each in a process of its own, compares the
//! day of middle length with the goals, and sets it against a day without modules, that of `benches/day.rs`; `-- --quick` runs
//! the hour alone. The exit code is 1 where a goal is missed. `-- --seconds N` is one run for a profiler, `-- --files` prints
//! the files of the case.
//!
//! The figures of decision 92 are those of the release profile, which `cargo bench` has. `--profile dist` is what packages ship:
//! it takes nearly a fifth less.

#[path = "day/embedded.rs"]
mod embedded;
#[path = "day/figures.rs"]
mod figures;
#[path = "day/rack.rs"]
mod rack;

use figures::{goal, measure, measure_apart, seconds_after};
use std::process::ExitCode;

/// Goals for the day: time on one core, memory above start.
const MOST_SECONDS: f64 = 20.0;
const MOST_KILOBYTES: u64 = 64 << 10;

/// The options of a run in this process: the rack, and the controller without modules.
const SECONDS: &str = "--seconds";
const EMBEDDED: &str = "--embedded";

fn bench(quick: bool) -> Result<bool, String> {
    let hour = measure_apart(SECONDS, 1)?;
    if quick {
        return Ok(goal(hour.passed, "verdict pass"));
    }
    let mut days = [measure_apart(SECONDS, 24)?, measure_apart(SECONDS, 24)?, measure_apart(SECONDS, 24)?];
    days.sort_by(|a, b| a.busy.total_cmp(&b.busy));
    let [_, day, _] = days;
    println!("without modules:");
    let embedded = measure_apart(EMBEDDED, 24)?;
    println!("the rack takes {:.2} times as long", day.busy / embedded.busy);
    let met = [
        goal(hour.passed && day.passed && embedded.passed, "verdict pass"),
        goal(day.busy < MOST_SECONDS, &format!("24 h in less than {MOST_SECONDS} s of one core")),
        goal(day.above() <= MOST_KILOBYTES, &format!("at most {MOST_KILOBYTES} kB above start")),
    ];
    Ok(met.iter().all(|met| *met))
}

fn main() -> ExitCode {
    if std::env::args().any(|argument| argument == "--files") {
        for (name, text) in rack::files(60) {
            println!("# {name}\n{text}");
        }
        return ExitCode::SUCCESS;
    }
    let runs: [(&str, figures::Files); 2] = [(SECONDS, rack::files), (EMBEDDED, embedded::files)];
    let run = runs.iter().find_map(|(option, files)| Some((files, seconds_after(option)?)));
    let outcome = match run {
        Some((files, seconds)) => measure(*files, seconds).map(|figures| {
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
