//! `rig bench latency`.

use super::{INTERRUPT, board, interrupted, interval, keep, measured, show};
use crate::exit::ExitStatus;
use crate::output::OutputFormat;
use crate::output::{self, refuse};
use clap::Args;
use host::{Bell, Privilege, Processors, Punctual, Realtime, ThreadRole, Wakeups, wakeups};
use record::Durations;
use runtime::instrument::figures::durations;
use serde_json::json;
use signal::Span;

/// The most wake-ups of one measurement: eleven days of them, one a millisecond.
const MOST: u64 = 1_000_000_000;

/// `rig bench latency`.
#[derive(Debug, Args)]
pub struct LatencyArgs {
    /// Time between two wake-ups.
    #[arg(long, value_name = "TIME", default_value = "1 ms")]
    interval: String,
    /// How many wake-ups to measure.
    #[arg(long, value_name = "N", default_value_t = 10_000)]
    count: u64,
    /// SCHED_FIFO priority of the scan, 2 to 97; 0: none.
    #[arg(long, value_name = "N", default_value_t = 80)]
    priority: u8,
    /// Stay on these processors, as `cpus` below `[realtime]` makes a run do.
    #[arg(long, value_name = "N,...", value_delimiter = ',')]
    cpus: Vec<u16>,
    /// How to print.
    #[arg(long, value_enum, default_value_t)]
    format: OutputFormat,
}

/// Wakes up as the scan does, many times, and says how late.
pub fn run(args: &LatencyArgs) -> ExitStatus {
    let interval = match interval(&args.interval) {
        Ok(interval) => interval,
        Err(exit) => return exit,
    };
    if args.count == 0 || args.count > MOST {
        let message = format!("--count {}: so many wake-ups cannot be measured", args.count);
        return refuse("R0250", message, &format!("from 1 to {MOST}"));
    }
    let realtime = match args.priority {
        0 => Realtime::default(),
        2..=97 => Realtime::with_priority(args.priority),
        other => {
            let message = format!("--priority {other}: a scan cannot have it");
            return refuse("R0250", message, "from 2 to 97, or 0 for none");
        }
    };
    let realtime = Realtime { processors: Processors::new(args.cpus.iter().copied()), ..realtime };
    let mut refused = realtime.refused(ThreadRole::Scan);
    let missing = args.cpus.iter().any(|number| *number > Processors::MOST);
    if missing || refused.iter().any(|refused| refused.what == Privilege::Processors) {
        let message = format!("--cpus {:?}: the rig may not run there", args.cpus);
        return refuse(
            "R0250",
            message,
            "name processors that there are and that the rig may use: see `nproc`",
        );
    }
    // As a run on real lines does: the process first, then the thread.
    let punctual = Punctual::begin();
    let entered = realtime.enter_for_now(ThreadRole::Scan);
    let found = wakeups(&Bell::new(), interval, args.count, &INTERRUPT);
    let priority = if entered.refused.is_some() { None } else { realtime.priority };
    drop(entered);
    refused.extend(&punctual.refused);
    refused.iter().for_each(board::note);
    let Some(late) = durations("late by", &found.late) else {
        output::note("interrupted before the first wake-up");
        return ExitStatus::Interrupted;
    };
    let settings = vec![
        (String::from("processors"), realtime.processors.to_string()),
        (String::from("interval"), interval.to_string()),
        (
            String::from("priority"),
            priority.map_or_else(|| String::from("none"), |priority| priority.to_string()),
        ),
    ];
    let kept = keep(&measured("latency", "", settings, vec![late.clone()]));
    show(args.format, interval, priority, &found, &late, kept);
    interrupted()
}

fn show(
    format: OutputFormat,
    interval: Span,
    priority: Option<u8>,
    found: &Wakeups,
    late: &Durations,
    kept: Option<String>,
) {
    match format {
        OutputFormat::Table => {
            let how = priority.map_or_else(
                || String::from("without real-time priority"),
                |priority| format!("SCHED_FIFO {priority}"),
            );
            output::print(&format!(
                "{} wake-ups every {interval}, {how}\n{}\n",
                late.count,
                show::line(late)
            ));
            if found.missed > 0 {
                output::print(&format!(
                    "{} more were left out, for the one before was too late\n",
                    found.missed
                ));
            }
            if let Some(path) = kept {
                output::print(&format!("kept in {path}\n"));
            }
        }
        OutputFormat::Json => {
            let mut all = show::figures(late);
            all["interval_us"] = json!(interval.as_nanos() as f64 / 1_000.0);
            all["priority"] = json!(priority);
            all["missed"] = json!(found.missed);
            all["histogram"] = show::histogram(&found.late);
            all["machine"] = host::HostMachine::here()
                .identity()
                .into_iter()
                .map(|(name, text)| (name, json!(text)))
                .collect();
            all["kept"] = json!(kept);
            output::print(&format!("{all}\n"));
        }
    }
}
