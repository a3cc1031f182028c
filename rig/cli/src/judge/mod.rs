//! `rig judge`: a trace of the rig's own, or what another instrument recorded.

mod foreign;
mod instant;
mod mapping;

use crate::exit::ExitStatus;
use crate::output;
use crate::saved_runs::provenance;
use crate::saved_runs::report_folder::{ReportFolder, ReportFormat};
use clap::{Args, ValueEnum};
use document::file::{self, FileFault};
use document::{Diagnostic, SourceFile};
use record::{CaseRecord, RunClock, RunRecord};
use reports::text::{Style, case_line, details};
use runtime::case::rejudge;
use runtime::suite::{self, Disk};
use signal::{LoadLimits, Trace};
use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};

/// `rig judge`.
#[derive(Debug, Args)]
pub struct JudgeArgs {
    /// The plan.
    pub plan: PathBuf,
    /// The trace that a run recorded (`--report DIR` writes it to `DIR/traces`), or a capture of another instrument:
    /// a value change dump, a table (`.csv`, `.tsv`) or a sigrok session (`.sr`).
    pub trace: PathBuf,
    /// Leave the reports in this folder, as `rig test` does.
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
    /// How to read a capture.
    #[command(flatten)]
    pub capture: CaptureArgs,
}

/// What has to be said of a capture.
#[derive(Debug, Args)]
#[command(next_help_heading = "For captures of other instruments")]
pub struct CaptureArgs {
    /// The case of a plan with several: its name, or its row alone.
    #[arg(long, value_name = "NAME")]
    pub case: Option<String>,
    /// A channel of the capture is a signal of the plan; `CHANNEL=SIGNAL@2.5` where it is TRUE above 2.5. Channels
    /// with the name of a signal need no word.
    #[arg(long, value_name = "CHANNEL=SIGNAL")]
    pub map: Vec<String>,
    /// Where the plan's `start` lies: a time of the capture (`1.5 s`), or an edge (`button rises`, `lamp falls 2` for
    /// the second).
    #[arg(long, value_name = "TIME|EDGE", allow_hyphen_values = true)]
    pub start: Option<String>,
    /// Where a step of the plan lies, if not where the plan has it. Without --start the start is counted back from it.
    #[arg(long, value_name = "STEP=TIME|EDGE")]
    pub at: Vec<String>,
    /// The time between two samples, where the capture does not say it or says it wrongly.
    #[arg(long, value_name = "TIME")]
    pub period: Option<String>,
    /// The file that says what the clock and the channels of the instrument may be off.
    #[arg(long, value_name = "FILE")]
    pub instrument: Option<PathBuf>,
    /// The board file that says what the signals are, in place of the plan's own.
    #[arg(long, value_name = "FILE")]
    pub board: Option<PathBuf>,
    /// Give a plan's parameter a value.
    #[arg(long = "param", value_name = "K=V")]
    pub params: Vec<String>,
}

impl CaptureArgs {
    /// Whether something is said that a trace of the rig's own says itself.
    fn is_given(&self) -> bool {
        let words = [&self.case, &self.start, &self.period];
        let lists = [&self.map, &self.at, &self.params];
        words.iter().any(|word| word.is_some())
            || lists.iter().any(|list| !list.is_empty())
            || self.board.is_some()
            || self.instrument.is_some()
    }
}

/// A trace that cannot be judged as it is given.
const NOT_JUDGED: &str = "R0204";

/// Judges a recorded trace again.
pub fn run(args: &JudgeArgs) -> ExitStatus {
    try_run(args).unwrap_or_else(|exit| exit)
}

fn try_run(args: &JudgeArgs) -> Result<ExitStatus, ExitStatus> {
    let path = args.trace.display();
    let unreadable = |fault: FileFault| {
        let help = "name a trace of a case, as reports keep them below `traces`, or a capture";
        output::refuse("R0201", format!("`{path}` cannot be read: {fault}"), help)
    };
    let head = file::read_start(&args.trace, 64).map_err(unreadable)?;
    let mut sources = Vec::new();
    let judged = match capture::CaptureFormat::of(&head, &args.trace.to_string_lossy()) {
        Some(format) => foreign::judge(args, format, &mut sources),
        None => {
            let trace = load(file::open(&args.trace).map_err(unreadable)?).map_err(|why| {
                let help = "take a trace as the rig wrote it, or a capture: a VCD, CSV or sigrok file";
                output::refuse(NOT_JUDGED, format!("{path} is not a complete trace: {why}"), help)
            })?;
            if args.capture.is_given() {
                let what =
                    format!("{path} is a trace of the rig's own, which says its case, signals and instants");
                let help = "leave out what describes a capture: --case, --map, --start, --at, --period, --instrument, --board, --param";
                return Err(output::refuse(NOT_JUDGED, what, help));
            }
            own(&args.plan, &trace, &mut sources).map(|record| (record, trace))
        }
    };
    let (record, trace) = judged.map_err(|found| {
        output::findings(&found, &sources);
        ExitStatus::UserFiles
    })?;
    let style = Style { color: output::color_out(), quiet: false };
    let (line, details) = (case_line(&record, style), details(&record, style));
    output::print(&format!("{}\n{details}  trace  {}\n", line.trim_end(), record.trace_sha256));
    let exit = ExitStatus::of(record.verdict);
    if let Some(folder) = &args.report {
        let page = report(folder, record, &trace)
            .map_err(|why| output::refuse("R0167", why, "name a folder that can be written to"))?;
        output::print(&format!("  report {page}\n"));
    }
    Ok(exit)
}

/// Leaves record, trace and reports in a folder; gives the path of the page.
fn report(folder: &Path, mut record: CaseRecord, trace: &Trace) -> Result<String, String> {
    let mut folder = ReportFolder::new(folder)?;
    rejudge::add_excerpts(&mut record, trace);
    record.trace_file = Some(folder.trace(&record, trace, true)?);
    let clock = if trace.note("clock") == Some("real") { RunClock::Real } else { RunClock::Virtual };
    let mut run = RunRecord::new(env!("CARGO_PKG_VERSION"), provenance::now(record.seed, clock));
    run.planned = 1;
    run.push(record);
    folder.record(&run)?;
    folder.reports(&run, ReportFormat::value_variants())?;
    Ok(folder.path("index.html"))
}

fn load(file: File) -> Result<Trace, String> {
    let mut file = BufReader::new(file);
    let trace = Trace::load(&mut file, LoadLimits::default()).map_err(|error| error.to_string())?;
    // A trace says where it ends; what follows it is not of the trace.
    match file.fill_buf().is_ok_and(<[u8]>::is_empty) {
        true => Ok(trace),
        false => Err("something follows its end".to_owned()),
    }
}

fn own(plan: &Path, trace: &Trace, sources: &mut Vec<SourceFile>) -> Result<CaseRecord, Vec<Diagnostic>> {
    rejudge::judge_gathered(&suite::gather(&Disk, &plan.to_string_lossy(), sources)?, trace)
}
