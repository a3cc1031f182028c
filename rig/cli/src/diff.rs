//! `rig diff`: what changed between two runs.

use crate::exit::ExitStatus;
use crate::output::OutputFormat;
use crate::{output, saved_runs};
use clap::Args;
use record::{Thresholds, compare};
use reports::text::Style;
use std::path::PathBuf;

/// `rig diff`.
#[derive(Debug, Args)]
#[command(
    after_help = "The exit code is 1 where something got worse: a verdict, a margin that eroded, a case or claim that is missing."
)]
pub struct DiffArgs {
    /// The earlier run: the folder that `rig test --report` wrote, or the `record.json` in it.
    pub old: PathBuf,
    /// The later run.
    pub new: PathBuf,
    /// How much of a margin may be lost, in percent of what it was.
    #[arg(long, value_name = "PERCENT", default_value = "10", value_parser = percent)]
    pub erosion: f64,
    /// Cases and claims that are missing are not worse.
    #[arg(long)]
    pub allow_missing: bool,
    /// How to print.
    #[arg(long, value_enum, default_value_t)]
    pub format: OutputFormat,
}

fn percent(text: &str) -> Result<f64, String> {
    let number: Option<f64> = text.trim_end_matches('%').trim().parse().ok();
    number.filter(|n| (0.0..=100.0).contains(n)).ok_or_else(|| String::from("write a number from 0 to 100"))
}

/// Compares two runs.
pub fn run(args: &DiffArgs) -> ExitStatus {
    let (old, new) = match (saved_runs::load(&args.old), saved_runs::load(&args.new)) {
        (Ok(old), Ok(new)) => (old, new),
        (old, new) => {
            let found: Vec<_> = [old.err(), new.err()].into_iter().flatten().collect();
            output::findings(&found, &[]);
            return ExitStatus::UserFiles;
        }
    };
    let thresholds = Thresholds { erosion_percent: args.erosion, allow_missing: args.allow_missing };
    let found = compare(&old.record, &new.record, &thresholds);
    match args.format {
        OutputFormat::Table => {
            let style = Style { color: output::color_out(), quiet: false };
            output::print(&reports::diff::render(&found, style));
        }
        OutputFormat::Json => {
            let text = serde_json::to_string_pretty(&found).unwrap_or_default();
            output::print(&format!("{text}\n"));
        }
    }
    if found.worse { ExitStatus::Failed } else { ExitStatus::Passed }
}
