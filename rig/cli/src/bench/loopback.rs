//! `rig bench loopback`.

use super::loopback_pair::LoopbackPairArgs;
use super::{INTERRUPT, board, interrupted, keep, measured, show};
use crate::bench_lock::BenchLockArgs;
use crate::exit::ExitStatus;
use crate::output::OutputFormat;
use crate::output::{self, refuse};
use clap::Args;
use record::Durations;
use runtime::instrument::figures::{devices, durations};
use runtime::instrument::{LoopFault, loopback, names};
use serde_json::json;
use std::path::PathBuf;

/// The most edges of one measurement.
const MOST: u64 = 100_000_000;

/// `rig bench loopback`.
#[derive(Debug, Args)]
pub struct LoopbackArgs {
    /// The board file. Its `[board] check` names the loop.
    #[arg(long, value_name = "FILE")]
    board: PathBuf,
    /// Which loop.
    #[command(flatten)]
    looped: LoopbackPairArgs,
    /// How many edges to measure.
    #[arg(long, value_name = "N", default_value_t = 10_000)]
    count: u64,
    /// How to print.
    #[arg(long, value_enum, default_value_t)]
    format: OutputFormat,
    /// What it does when somebody else is on the lines.
    #[command(flatten)]
    wait: BenchLockArgs,
}

/// Lets a loop drive itself and says how long its edges take.
pub fn run(args: &LoopbackArgs) -> ExitStatus {
    try_run(args).unwrap_or_else(|exit| exit)
}

fn try_run(args: &LoopbackArgs) -> Result<ExitStatus, ExitStatus> {
    if args.count == 0 || args.count > MOST {
        let message = format!("--count {}: so many edges cannot be measured", args.count);
        return Err(refuse("R0250", message, &format!("from 1 to {MOST}")));
    }
    let (file, hardware) = board::open(&args.board, &args.wait)?;
    let mut board = hardware.lease();
    let looped = args.looped.find(&file, &args.board)?;
    let names = names(&board, looped);
    let mut settings = board::settings(&hardware);
    settings.push((String::from("loop"), names.join(" to ")));
    let entered = hardware.enter();
    let found = loopback(hardware.instrument(&mut board), looped, args.count, &INTERRUPT);
    drop(entered);
    let found = found.map_err(|fault| failed(&fault, &names))?;
    let histograms = [
        ("call to stamp", &found.call_to_stamp),
        ("stamp to seen", &found.stamp_to_seen),
        ("asked to call", &found.asked_to_call),
    ];
    let figures: Vec<Durations> =
        histograms.iter().filter_map(|(name, histogram)| durations(name, histogram)).collect();
    let Some(turn) = found.turn() else {
        output::note("interrupted before the first edge");
        return Ok(ExitStatus::Interrupted);
    };
    let kept = keep(&measured("loopback", &devices(&file), settings, figures.clone()));
    match args.format {
        OutputFormat::Table => {
            let mut text = format!("{} edges from `{}` to `{}`\n", found.turns, names[0], names[1]);
            figures.iter().for_each(|figure| text += &format!("{}\n", show::line(figure)));
            text += &format!("a turn by counting alone, 1/(2f): {turn}\n");
            kept.iter().for_each(|path| text += &format!("kept in {path}\n"));
            output::print(&text);
        }
        OutputFormat::Json => {
            let mut all = json!({ "loop": names, "turns": found.turns, "kept": kept });
            all["devices"] = json!(devices(&file));
            all["turn_us"] = json!(turn.as_nanos() as f64 / 1_000.0);
            for (figure, (_, histogram)) in figures.iter().zip(&histograms) {
                let mut one = show::figures(figure);
                one["histogram"] = show::histogram(histogram);
                all[figure.name.replace(' ', "_")] = one;
            }
            output::print(&format!("{all}\n"));
        }
    }
    Ok(interrupted())
}

/// A board that is no instrument.
pub fn failed(fault: &LoopFault, names: &[String; 2]) -> ExitStatus {
    if *fault == LoopFault::Interrupted {
        return ExitStatus::Interrupted;
    }
    output::findings(&[fault.finding(names)], &[]);
    ExitStatus::Error
}
