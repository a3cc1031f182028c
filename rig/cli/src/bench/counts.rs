//! `rig bench counts`.

use super::loopback_pair::LoopbackPairArgs;
use super::{INTERRUPT, board, interrupted, keep, measured};
use crate::bench_lock::BenchLockArgs;
use crate::exit::ExitStatus;
use crate::output::OutputFormat;
use crate::output::{self, refuse};
use clap::Args;
use document::Diagnostic;
use drivers::Board;
use runtime::instrument::figures::{COUNTS, CountingLimit, devices};
use runtime::instrument::{Train, counts, is_countable, names};
use serde_json::json;
use std::path::PathBuf;

/// Most trains of one frequency.
const MOST: u32 = 1_000;

/// `rig bench counts`.
#[derive(Debug, Args)]
pub struct CountsArgs {
    /// The board file. Its `[board] check` names the loop.
    #[arg(value_name = "BOARD")]
    board: PathBuf,
    /// Which loop.
    #[command(flatten)]
    looped: LoopbackPairArgs,
    /// How many trains of each frequency have to be counted without a loss.
    #[arg(long, value_name = "N", default_value_t = 5)]
    repeats: u32,
    /// How to print.
    #[arg(long, value_enum, default_value_t)]
    format: OutputFormat,
    /// What it does when somebody else is on the lines.
    #[command(flatten)]
    wait: BenchLockArgs,
}

/// Finds the fastest pulses that a board counts, and the fastest that it makes.
pub fn run(args: &CountsArgs) -> ExitStatus {
    try_run(args).unwrap_or_else(|exit| exit)
}

fn try_run(args: &CountsArgs) -> Result<ExitStatus, ExitStatus> {
    if args.repeats == 0 || args.repeats > MOST {
        let message = format!("--repeats {}: so many trains cannot be measured", args.repeats);
        return Err(refuse("R0250", message, &format!("from 1 to {MOST}")));
    }
    let (file, hardware) = board::open(&args.board, &args.wait)?;
    let mut board = hardware.lease();
    let looped = args.looped.find(&file, &args.board)?;
    let names = names(&board, looped);
    if is_countable(&board, looped).is_err() {
        let message = format!("no pulses can be counted from `{}` to `{}`", names[0], names[1]);
        let help =
            "name an output, or a line whose generator counts its pulses, and a digital input on its wire";
        return Err(refuse("R0254", message, help));
    }
    let mut settings = board::settings(&hardware);
    settings.push((String::from("loop"), names.join(" to ")));
    let promises = [looped.out, looped.input].map(|id| board.channels()[usize::from(id.0)].clone());
    let entered = hardware.enter();
    let found = counts(hardware.instrument(&mut board), looped, args.repeats, &INTERRUPT);
    drop(entered);
    let found = found.map_err(|fault| super::loopback::failed(&fault, &names))?;
    let came =
        CountingLimit { counted_hz: found.counted_hz, made_hz: found.made_hz, is_limit: found.is_limit };
    settings.extend(came.settings());
    let kept = keep(&measured(COUNTS, &devices(&file), settings, Vec::new()));
    let [_, input] = &promises;
    let broken = input.counts_hz.and_then(|hz| came.broken(&input.name, hz));
    let broken: Vec<Diagnostic> = broken.into_iter().collect();
    match args.format {
        OutputFormat::Table => {
            let mut text = format!("pulses from `{}` to `{}`\n", names[0], names[1]);
            found.trains.chunk_by(|a, b| a.wanted_hz == b.wanted_hz).for_each(|same| text += &line(same));
            text += &format!("counted without a loss: {}\n", came.counted());
            text += &format!("made: up to {} Hz\n", came.made_hz);
            kept.iter().for_each(|path| text += &format!("kept in {path}\n"));
            output::print(&text);
        }
        OutputFormat::Json => {
            let trains = found.trains.iter().map(|train| {
                json!({
                    "wanted_hz": train.wanted_hz,
                    "hz": train.hz,
                    "made": train.made,
                    "seen": train.seen,
                    "lost": train.lost,
                })
            });
            let all = json!({
                "loop": names,
                "counted_hz": came.counted_hz,
                "made_hz": came.made_hz,
                "is_limit": came.is_limit,
                "trains": trains.collect::<Vec<_>>(),
                "kept": kept,
            });
            output::print(&format!("{all}\n"));
        }
    }
    output::findings(&broken, &[]);
    Ok(if broken.is_empty() { interrupted() } else { ExitStatus::Inconclusive })
}

/// The trains of one frequency in a line.
fn line(same: &[Train]) -> String {
    let Some(first) = same.first() else { return String::new() };
    let slowest = same.iter().map(|train| train.hz).min().unwrap_or(0);
    let missing: u64 = same.iter().map(|train| u64::from(train.made.saturating_sub(train.seen))).sum();
    let lost: u64 = same.iter().map(|train| u64::from(train.lost)).sum();
    let edges: u64 = same.iter().map(|train| u64::from(train.made)).sum();
    let came = match (missing, lost) {
        (0, 0) => String::from("all seen"),
        (missing, lost) => format!("{missing} missing, {lost} reported as lost"),
    };
    let made = if slowest == first.wanted_hz { String::new() } else { format!(", made at {slowest} Hz") };
    format!("{:>9} Hz  {} times, {edges} edges: {came}{made}\n", first.wanted_hz, same.len())
}
