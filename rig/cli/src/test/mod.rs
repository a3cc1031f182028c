//! `rig test`: plans are loaded, cases chosen and run, and an observer reports to the user.

mod args;
mod choose;
mod display;
mod estimate;
mod execute;
mod json_events;
mod observer;
mod progress_display;
mod reporting;
mod text_output;

use crate::exit::ExitStatus;
use crate::output;
use crate::plan_files::load::{self, LoadRequest};
use crate::plan_files::project;
pub use args::TestArgs;
use display::{ProgressMode, TestOutput};
use json_events::JsonEvents;
use observer::RunObserver;
use reporting::SuitePart;
use runtime::suite::Job;
use std::sync::atomic::{AtomicBool, Ordering};
use text_output::TextOutput;

/// Set by the signal handler, and when nobody reads the lines any more: the running cases end with their outputs safe.
static INTERRUPT: AtomicBool = AtomicBool::new(false);

/// Runs plans.
pub fn run(args: &TestArgs) -> ExitStatus {
    try_run(args).unwrap_or_else(|exit| exit)
}

fn try_run(args: &TestArgs) -> Result<ExitStatus, ExitStatus> {
    let mut sources = Vec::new();
    let own: Vec<_> = match args.plans.is_empty() && !args.shipped {
        true => project::folder().into_iter().collect(),
        false => args.plans.clone(),
    };
    let wanted =
        LoadRequest { plans: &own, board: args.board.as_deref(), params: &args.params, seed: args.seed };
    let loaded = load::load(&wanted, &mut sources)?;
    let chosen = choose::choose(args, &loaded)?;
    let (jobs, part) = SuitePart::of(&args.reporting, &loaded, chosen)?;
    if args.list {
        list(&jobs, args.display.format);
        return Ok(ExitStatus::Passed);
    }
    if let Err(error) = ctrlc::set_handler(|| INTERRUPT.store(true, Ordering::Relaxed)) {
        output::error(&format!("interrupts cannot be caught: {error}"));
        return Err(ExitStatus::Error);
    }
    // What is written into files is wanted whoever reads the lines.
    let ends_unread = args.report.is_none() && !args.reporting.writes();
    if let Err(error) = output::wait_until(&INTERRUPT, ends_unread) {
        output::error(&format!("no thread can be started for what is printed: {error}"));
        return Err(ExitStatus::Error);
    }
    let mut display = args.display.clone();
    if jobs.iter().any(|job| job.asks) {
        // A bar and a question would write over each other.
        display.progress = ProgressMode::None;
    }
    let mut observer: Box<dyn RunObserver> = match args.display.format {
        TestOutput::Text => Box::new(TextOutput::new(&display)),
        TestOutput::Json => Box::new(JsonEvents),
    };
    execute::execute(args, &loaded, &jobs, part, &sources, &mut *observer)
}

fn list(jobs: &[Job], format: TestOutput) {
    for job in jobs {
        match format {
            TestOutput::Text => output::print(&format!("{}  {}\n", job.name, job.title)),
            TestOutput::Json => json_events::listed(job),
        }
    }
}
