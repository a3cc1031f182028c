//! What a run writes: its reports, a summary, an entry of a history; and which part of the suite it is.

use crate::exit::ExitStatus;
use crate::saved_runs::report_folder::{ReportFolder, ReportFormat};
use crate::selection::shard::{self, Shard};
use crate::{files, history, output};
use clap::{Args, ValueEnum};
use document::Diagnostic;
use record::RunRecord;
use runtime::suite::{Job, LoadedPlan};
use std::path::PathBuf;

/// What the command line says of it.
#[derive(Clone, Debug, Args)]
pub struct ReportingArgs {
    /// Run only part K of N of the chosen cases; `rig report --merge` merges the parts.
    #[arg(long, value_name = "K/N")]
    pub shard: Option<String>,
    /// Write a summary in Markdown into this file: for a merge request, or for the job's page.
    #[arg(long, value_name = "FILE")]
    pub summary: Option<PathBuf>,
    /// Add the run to this history, for `rig history show`.
    #[arg(long, value_name = "FILE")]
    pub history: Option<PathBuf>,
}

impl ReportingArgs {
    /// Whether something of the run is kept beside its folder.
    pub fn writes(&self) -> bool {
        self.summary.is_some() || self.history.is_some()
    }

    /// Writes record and reports, the summary, and adds to the history; gives the path of the page.
    ///
    /// # Errors
    /// What cannot be written. What comes before it is.
    pub fn write_all(
        &self,
        run: &RunRecord,
        folder: Option<&ReportFolder>,
    ) -> Result<Option<String>, Diagnostic> {
        let unwritten = |why| Diagnostic::error("R0167", why);
        if let Some(folder) = folder {
            folder.record(run).map_err(unwritten)?;
            folder.reports(run, ReportFormat::value_variants()).map_err(unwritten)?;
        }
        if let Some(path) = &self.summary {
            files::write_text(path, &reports::markdown::render(run)).map_err(unwritten)?;
        }
        if let Some(path) = &self.history {
            let name = folder.map_or_else(String::new, |folder| folder.path(""));
            history::keep(path, &name, run)?;
        }
        Ok(folder.map(|folder| folder.path("index.html")))
    }
}

/// What the record says of the part.
#[derive(Clone, Debug)]
pub struct SuitePart {
    /// Part and number of parts, where it is not the whole.
    pub shard: Option<[u32; 2]>,
    /// Digest of the whole selection.
    pub selection_sha256: String,
}

impl SuitePart {
    /// The jobs of the part that the command line asks for.
    ///
    /// # Errors
    /// How the command ends; why is printed.
    pub fn of(
        args: &ReportingArgs,
        loaded: &[LoadedPlan],
        jobs: Vec<Job>,
    ) -> Result<(Vec<Job>, SuitePart), ExitStatus> {
        let shard = args.shard.as_deref().map(Shard::parse).transpose().map_err(|found| {
            output::findings(&[found], &[]);
            ExitStatus::UserFiles
        })?;
        let selection_sha256 = shard::sha256(loaded, &jobs);
        let part = SuitePart { shard: shard.map(Shard::record), selection_sha256 };
        let Some(shard) = shard else { return Ok((jobs, part)) };
        let taken = shard.take(jobs);
        if taken.is_empty() {
            output::note("there are fewer cases than parts: this part has none");
        }
        Ok((taken, part))
    }
}
