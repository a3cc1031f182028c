//! `rig history`: verdicts, margins and measurements of past runs in one SQLite file.

mod database;
mod read;
mod show;
mod trend;

use crate::exit::ExitStatus;
use crate::output::OutputFormat;
use crate::{output, saved_runs};
use clap::{Args, Subcommand};
use database::{AddOutcome, HistoryDatabase};
use document::Diagnostic;
use record::RunRecord;
use std::num::NonZeroU32;
use std::path::{Path, PathBuf};

/// How many runs a history keeps when nothing else is said.
const KEEP: u32 = 200;

/// `rig history`.
#[derive(Debug, Subcommand)]
pub enum HistoryCommand {
    /// Add runs, the oldest first; one that is there already stays as it is.
    Add(AddArgs),
    /// Show which cases are flaky, and where margins and measurements drift to.
    Show(ShowArgs),
}

/// The file.
#[derive(Debug, Args)]
pub struct FileArgs {
    /// The history.
    #[arg(long, value_name = "FILE", default_value = "rig-history.sqlite")]
    pub file: PathBuf,
}

/// `rig history add`.
#[derive(Debug, Args)]
pub struct AddArgs {
    /// Folders that `rig test --report` wrote, or the `record.json` in them.
    #[arg(value_name = "RUN", required = true)]
    pub runs: Vec<PathBuf>,
    /// The file.
    #[command(flatten)]
    pub file: FileArgs,
    /// Keep this many runs, and forget older ones.
    #[arg(long, value_name = "N", default_value_t = NonZeroU32::new(KEEP).unwrap_or(NonZeroU32::MIN))]
    pub keep: NonZeroU32,
}

/// `rig history show`.
#[derive(Debug, Args)]
pub struct ShowArgs {
    /// The file.
    #[command(flatten)]
    pub file: FileArgs,
    /// Only cases whose name holds this text; shows all of their figures.
    #[arg(long, value_name = "TEXT")]
    pub only: Option<String>,
    /// Look at the last N runs.
    #[arg(long, value_name = "N", default_value_t = NonZeroU32::new(50).unwrap_or(NonZeroU32::MIN))]
    pub last: NonZeroU32,
    /// How to print.
    #[arg(long, value_enum, default_value_t)]
    pub format: OutputFormat,
}

/// Adds to a history or shows it.
pub fn run(command: &HistoryCommand) -> ExitStatus {
    let done = match command {
        HistoryCommand::Add(args) => add(args),
        HistoryCommand::Show(args) => show(args),
    };
    match done {
        Ok(()) => ExitStatus::Passed,
        Err(found) => {
            output::findings(&[found], &[]);
            ExitStatus::UserFiles
        }
    }
}

/// Adds the run that just ended.
///
/// # Errors
/// Why the history cannot be used.
pub fn keep(path: &Path, name: &str, run: &RunRecord) -> Result<(), Diagnostic> {
    HistoryDatabase::open_or_make(path)?.add(name, run, KEEP).map(drop)
}

fn add(args: &AddArgs) -> Result<(), Diagnostic> {
    let path = &args.file.file;
    // All are read before the first is written.
    let runs: Vec<saved_runs::SavedRun> =
        args.runs.iter().map(|run| saved_runs::load(run)).collect::<Result<_, _>>()?;
    let mut database = HistoryDatabase::open_or_make(path)?;
    for run in &runs {
        let said = match database.add(&run.name, &run.record, args.keep.get())? {
            AddOutcome::New => "added",
            AddOutcome::Known => "is there already",
        };
        output::print(&format!("{} {said}\n", run.name));
    }
    output::print(&format!("{}: {} runs\n", path.display(), database.count()?));
    Ok(())
}

fn show(args: &ShowArgs) -> Result<(), Diagnostic> {
    let database = HistoryDatabase::open(&args.file.file)?;
    let past = read::read(&database, args.last.get(), args.only.as_deref())?;
    output::print(&match args.format {
        OutputFormat::Table => show::table(&past, args.only.is_some()),
        OutputFormat::Json => show::json(&past),
    });
    Ok(())
}
