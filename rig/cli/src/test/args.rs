//! The arguments of `rig test`.

use super::display::DisplayArgs;
use super::reporting::ReportingArgs;
use crate::bench_lock::BenchLockArgs;
use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// Which clock a run keeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ClockChoice {
    /// Jump from event to event: a day of scans in seconds, the same every time.
    Virtual,
    /// The host's clock.
    Real,
}

/// `rig test`.
#[derive(Debug, Args)]
pub struct TestArgs {
    /// Plan files, or folders that are searched for plans [default: the project in the current folder; the plans that ship
    /// where that is none].
    #[arg(value_name = "PLAN|DIR")]
    pub plans: Vec<PathBuf>,
    /// Run the plans that ship with the rig, also in the folder of a project.
    #[arg(long, conflicts_with = "plans")]
    pub shipped: bool,
    /// The board file to use in place of each plan's own.
    #[arg(long, value_name = "FILE")]
    pub board: Option<PathBuf>,
    /// The clock to run on [default: virtual; real on a board with real lines].
    #[arg(long, value_enum)]
    pub clock: Option<ClockChoice>,
    /// Write the record, the reports and the traces into this folder.
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
    /// Cases to run at once in virtual time [default: the number of cores].
    #[arg(long, value_name = "N")]
    pub jobs: Option<std::num::NonZeroUsize>,
    /// Run only the cases that this expression selects: words that the case's name holds, `title:WORD`,
    /// `proves:ID`, `tag:WORD`, `profile:NAME`, joined by `and`, `or`, `not`, with brackets.
    #[arg(long, value_name = "EXPR")]
    pub only: Option<String>,
    /// Give a plan's parameter a value.
    #[arg(long = "param", value_name = "K=V")]
    pub params: Vec<String>,
    /// The seed of all random choices.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Run every case this many times, each with a seed of its own.
    #[arg(long, value_name = "N", default_value = "1")]
    pub repeat: std::num::NonZeroU32,
    /// Start no further case after the first that did not pass.
    #[arg(long)]
    pub fail_fast: bool,
    /// List the cases and run none.
    #[arg(long)]
    pub list: bool,
    /// Record which statements and branches of the programs ran.
    #[arg(long)]
    pub coverage: bool,
    /// What a run on real lines does while another run uses them.
    #[command(flatten)]
    pub wait: BenchLockArgs,
    /// How the run is shown.
    #[command(flatten)]
    pub display: DisplayArgs,
    /// What the run writes.
    #[command(flatten)]
    pub reporting: ReportingArgs,
}
