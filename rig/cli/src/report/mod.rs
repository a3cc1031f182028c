//! `rig report`: draws the reports of a run again from its record, or puts the parts of a suite together.

mod merge;
mod waves;

use crate::exit::ExitStatus;
use crate::saved_runs::report_folder::{ReportFolder, ReportFormat};
use crate::saved_runs::{self, SavedRun};
use crate::{output, run_exit};
use clap::{Args, ValueEnum};
use document::Diagnostic;
use std::path::{Path, PathBuf};

/// `rig report`.
#[derive(Debug, Args)]
pub struct ReportArgs {
    /// Folders that `rig test --report` wrote, or the `record.json` in them; one without `--merge`.
    #[arg(value_name = "RUN", required = true)]
    pub runs: Vec<PathBuf>,
    /// Put the parts that `rig test --shard K/N` ran together to the run that they are parts of. The exit code is
    /// that of the whole run.
    #[arg(long, requires = "out")]
    pub merge: bool,
    /// Write into this folder in place of the run's own.
    #[arg(long, visible_alias = "report", value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Which reports to draw, separated by commas [default: all].
    #[arg(long, value_enum, value_delimiter = ',', value_name = "FORM,...")]
    pub format: Vec<ReportFormat>,
}

/// Draws reports.
pub fn run(args: &ReportArgs) -> ExitStatus {
    draw(args).unwrap_or_else(|found| {
        output::findings(&found, &[]);
        ExitStatus::UserFiles
    })
}

fn draw(args: &ReportArgs) -> Result<ExitStatus, Vec<Diagnostic>> {
    let forms = if args.format.is_empty() { ReportFormat::value_variants() } else { &args.format };
    if args.merge {
        return merge_all(args, forms);
    }
    let [path] = args.runs.as_slice() else {
        return Err(vec![
            Diagnostic::error("R0165", format!("{} runs are given", args.runs.len()))
                .help("give one run, or put the parts of a suite together with `--merge`"),
        ]);
    };
    let mut run = saved_runs::load(path).map_err(one)?;
    let target = args.out.as_deref().unwrap_or(&run.folder);
    let mut store = ReportFolder::without_traces(target).map_err(unwritten)?;
    if forms.contains(&ReportFormat::Vcd) {
        let own = same(target, &run.folder);
        waves::draw(&mut run, &mut store, own, !args.format.is_empty())?;
    }
    if args.format.is_empty() && args.out.is_some() {
        store.record(&run.record).map_err(unwritten)?;
    }
    store.reports(&run.record, forms).map_err(unwritten)?;
    print_written(&store, forms);
    Ok(ExitStatus::Passed)
}

fn merge_all(args: &ReportArgs, forms: &[ReportFormat]) -> Result<ExitStatus, Vec<Diagnostic>> {
    let mut found = Vec::new();
    let mut parts: Vec<SavedRun> = Vec::new();
    for path in &args.runs {
        match saved_runs::load(path) {
            Ok(run) => parts.push(run),
            Err(error) => found.push(error),
        }
    }
    if !found.is_empty() {
        return Err(found);
    }
    // clap asks for it beside `--merge`.
    let target = args.out.as_deref().unwrap_or(Path::new("."));
    let whole = merge::merge(parts)?;
    let mut store = ReportFolder::without_traces(target).map_err(unwritten)?;
    let whole = whole.adopt(&mut store)?;
    store.record(&whole).map_err(unwritten)?;
    store.reports(&whole, forms).map_err(unwritten)?;
    let style = reports::text::Style { color: output::color_out(), quiet: false };
    output::print(&format!("{}\n", reports::text::summary(&whole, style).trim_end()));
    print_written(&store, forms);
    Ok(run_exit::of(&whole))
}

/// Says where the page is, or whatever was drawn first.
fn print_written(store: &ReportFolder, forms: &[ReportFormat]) {
    let name = forms.first().map_or("", |form| match form {
        ReportFormat::Html => "index.html",
        ReportFormat::Junit => "junit.xml",
        ReportFormat::Ctrf => "ctrf.json",
        ReportFormat::Md => "summary.md",
        ReportFormat::Csv => "measurements.csv",
        ReportFormat::Vcd => "traces",
    });
    output::print(&format!("Report: {}\n", store.path(name)));
}

/// Whether two paths are one folder.
fn same(left: &Path, right: &Path) -> bool {
    let real =
        |path: &Path| std::fs::canonicalize(if path.as_os_str().is_empty() { Path::new(".") } else { path });
    match (real(left), real(right)) {
        (Ok(left), Ok(right)) => left == right,
        _ => false,
    }
}

fn one(found: Diagnostic) -> Vec<Diagnostic> {
    vec![found]
}

fn unwritten(why: String) -> Vec<Diagnostic> {
    vec![Diagnostic::error("R0167", why)]
}
