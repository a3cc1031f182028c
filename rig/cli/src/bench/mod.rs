//! `rig bench`: what this machine and its board can do, in figures that are kept for the runs that follow.

mod board;
mod counts;
mod latency;
mod loopback;
mod loopback_pair;
mod scan;
mod show;

use crate::exit::ExitStatus;
use crate::output::{self, refuse};
use clap::Subcommand;
use counts::CountsArgs;
use document::Diagnostic;
use host::HostMachine;
use latency::LatencyArgs;
use loopback::LoopbackArgs;
use record::{Durations, MACHINE_FORMAT, MachineRecord};
use runtime::instrument::figures::{self, ENOUGH};
use scan::BenchScanArgs;
use signal::Span;
use signal::calendar::rfc3339;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{SystemTime, UNIX_EPOCH};

/// Set by SIGINT, SIGTERM and SIGHUP: what was measured so far is shown.
static INTERRUPT: AtomicBool = AtomicBool::new(false);

/// `rig bench`.
#[derive(Debug, Subcommand)]
pub enum BenchCommand {
    /// Measure how late this machine wakes up the scan.
    Latency(LatencyArgs),
    /// Measure what the phases of a scan take on a board.
    Scan(BenchScanArgs),
    /// Measure how long an edge takes from an output to the input that it is wired to.
    Loopback(LoopbackArgs),
    /// Measure how fast pulses can be for a board to count every one, and how fast it makes them.
    Counts(CountsArgs),
}

/// Measures.
pub fn run(command: &BenchCommand) -> ExitStatus {
    if let Err(error) = ctrlc::set_handler(|| INTERRUPT.store(true, Ordering::Relaxed)) {
        output::note(&format!("the run cannot be interrupted cleanly: {error}"));
    }
    match command {
        BenchCommand::Latency(args) => latency::run(args),
        BenchCommand::Scan(args) => scan::run(args),
        BenchCommand::Loopback(args) => loopback::run(args),
        BenchCommand::Counts(args) => counts::run(args),
    }
}

/// The longest time between two wake-ups: more than any task of a controller has.
const LONGEST: Span = Span::from_secs(60);

/// The time between two wake-ups or scans.
fn interval(text: &str) -> Result<Span, ExitStatus> {
    match Span::parse(text) {
        Ok(span) if span > Span::ZERO && span <= LONGEST => Ok(span),
        _ => {
            let message = format!("--interval {text}: not a time between two wake-ups");
            Err(refuse("R0250", message, &format!("above 0 and up to {LONGEST}, as in `1 ms`")))
        }
    }
}

/// The exit of a measurement that was made, or cut short.
fn interrupted() -> ExitStatus {
    if INTERRUPT.load(Ordering::Relaxed) { ExitStatus::Interrupted } else { ExitStatus::Passed }
}

/// A measurement that ends now.
fn measured(
    kind: &str,
    board_sha256: &str,
    settings: Vec<(String, String)>,
    figures: Vec<Durations>,
) -> MachineRecord {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
    MachineRecord {
        format: MACHINE_FORMAT,
        kind: kind.to_owned(),
        measured: rfc3339(since),
        machine: HostMachine::here().identity(),
        board_sha256: board_sha256.to_owned(),
        settings,
        figures,
    }
}

/// Keeps figures for the runs that follow, where they are many enough, and says where; else says why not.
fn keep(record: &MachineRecord) -> Option<String> {
    if record.figures.iter().any(|figure| figure.count < ENOUGH) {
        output::note(&format!("not kept: less than {ENOUGH} say nothing about one of 10 000"));
        return None;
    }
    let Some(folder) = figures::folder() else {
        output::note("not kept: neither XDG_STATE_HOME nor HOME names a folder");
        return None;
    };
    match figures::keep(&folder, record) {
        Ok(path) => Some(path.display().to_string()),
        Err(error) => {
            let message = format!("the figures cannot be kept in `{}`: {error}", folder.display());
            let help = "give XDG_STATE_HOME a folder that you may write to";
            output::findings(&[Diagnostic::warning("R0251", message).help(help)], &[]);
            None
        }
    }
}
