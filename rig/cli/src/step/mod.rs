//! `rig step`: one case, step by step, in virtual time.

mod shell;

use crate::exit::ExitStatus;
use crate::output;
use crate::plan_files::load::{LoadRequest, load};
use crate::run_exit;
use crate::selection::{CaseFacts, Selection};
use clap::Args;
use document::Diagnostic;
use reports::text::{Style, case_line, details};
use runtime::case::step_case;
use runtime::suite::{Job, LoadedPlan};
use runtime::{ClockKind, RunOptions};
use shell::StepShell;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};

/// Set by the signal handler: the case ends with its outputs safe.
static INTERRUPT: AtomicBool = AtomicBool::new(false);

/// `rig step`.
#[derive(Debug, Args)]
#[command(after_help = shell::HELP)]
pub struct StepArgs {
    /// The plan.
    pub plan: PathBuf,
    /// The case, where the plan has several: an expression as for `rig test --only`.
    #[arg(long, value_name = "EXPR")]
    pub only: Option<String>,
    /// The board file to use in place of the plan's own.
    #[arg(long, value_name = "FILE")]
    pub board: Option<PathBuf>,
    /// Give a plan's parameter a value.
    #[arg(long = "param", value_name = "K=V")]
    pub params: Vec<String>,
    /// The seed of everything that is left to chance.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
}

/// Goes through a case.
pub fn run(args: &StepArgs) -> ExitStatus {
    try_run(args).unwrap_or_else(|exit| exit)
}

fn try_run(args: &StepArgs) -> Result<ExitStatus, ExitStatus> {
    let mut sources = Vec::new();
    let plans = [args.plan.clone()];
    let wanted =
        LoadRequest { plans: &plans, board: args.board.as_deref(), params: &args.params, seed: args.seed };
    let loaded = load(&wanted, &mut sources)?;
    let (plan, job) = choose(args, &loaded)?;
    let refuse = |found: Vec<Diagnostic>| {
        output::findings(&found, &sources);
        ExitStatus::UserFiles
    };
    let Some(case) = plan.plan.case(job.case) else { return Err(refuse(Vec::new())) };
    let files = plan.files(&case, &job).map_err(refuse)?;
    if let Err(error) = ctrlc::set_handler(|| INTERRUPT.store(true, Ordering::Relaxed)) {
        output::error(&format!("interrupts cannot be caught: {error}"));
        return Err(ExitStatus::Error);
    }
    let guarded = files.guarded(&case).map_err(refuse)?;
    let mut shell = StepShell::new(&guarded, &INTERRUPT).map_err(|error| {
        output::error(&format!("standard input cannot be read: {error}"));
        ExitStatus::Error
    })?;
    let options = RunOptions::new(ClockKind::Virtual, &INTERRUPT);
    let result = step_case(&case, &files, &options, Some(&mut shell)).map_err(refuse)?;
    if shell.has_quit() || INTERRUPT.load(Ordering::Relaxed) {
        output::print("quit: the outputs are safe\n");
        return Ok(ExitStatus::Interrupted);
    }
    let style = Style { color: output::color_out(), quiet: false };
    let (line, details) = (case_line(&result.record, style), details(&result.record, style));
    output::print(&format!("{}\n{details}  trace  {}\n", line.trim_end(), result.record.trace_sha256));
    if !result.record.is_judged() {
        return Ok(run_exit::none_judged(1, run_exit::REASONS_ARE_PRINTED));
    }
    Ok(ExitStatus::of(result.record.verdict))
}

/// The one case that is meant.
fn choose<'a>(args: &StepArgs, loaded: &'a [LoadedPlan]) -> Result<(&'a LoadedPlan, Job), ExitStatus> {
    let selection = match &args.only {
        None => Selection::All,
        Some(expression) => Selection::of(expression)?,
    };
    let jobs = loaded.iter().enumerate().flat_map(|(place, plan)| plan.jobs(place, args.seed, 1));
    let mut jobs: Vec<Job> = jobs.filter(|job| selection.matches(&CaseFacts::of(job))).collect();
    let names: Vec<&str> = jobs.iter().map(|job| job.name.as_str()).collect();
    let message = match names.len() {
        0 => format!("--only selects none of the cases of {}", args.plan.display()),
        1 => String::new(),
        n => format!("{n} cases are meant, and one is gone through at a time"),
    };
    if !message.is_empty() {
        const NAMED: usize = 8;
        let more = if names.len() > NAMED { ", ..." } else { "" };
        let list = names[..names.len().min(NAMED)].join(", ");
        let found = Diagnostic::error("R0175", message);
        let help = if names.is_empty() {
            String::from("`rig test PLAN --list` names the cases")
        } else {
            format!("say which with --only: {list}{more}")
        };
        output::findings(&[found.help(help)], &[]);
        return Err(ExitStatus::UserFiles);
    }
    let job = jobs.remove(0);
    Ok((&loaded[job.plan], job))
}
