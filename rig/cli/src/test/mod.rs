//! `rig test`: plans are loaded, cases chosen and run, and an observer tells the user.

mod args;
mod choose;
mod estimate;
mod events;
mod execute;
mod leave;
mod lines;
mod look;
mod observe;
mod screen;

use crate::exit::Exit;
use crate::output;
use crate::plan_files::load::{self, Wanted};
pub use args::TestArgs;
use events::Events;
use leave::Part;
use lines::Lines;
use look::{Output, Progress};
use observe::Observer;
use runtime::suite::Job;
use std::sync::atomic::{AtomicBool, Ordering};

/// Set by the signal handler: the running cases end with their outputs safe.
static INTERRUPT: AtomicBool = AtomicBool::new(false);

/// Runs plans.
pub fn run(args: &TestArgs) -> Exit {
    try_run(args).unwrap_or_else(|exit| exit)
}

fn try_run(args: &TestArgs) -> Result<Exit, Exit> {
    let mut sources = Vec::new();
    let wanted =
        Wanted { plans: &args.plans, board: args.board.as_deref(), params: &args.params, seed: args.seed };
    let loaded = load::load(&wanted, &mut sources)?;
    let chosen = choose::choose(args, &loaded)?;
    let (jobs, part) = Part::of(&args.leave, &loaded, chosen)?;
    if args.list {
        list(&jobs, args.look.format);
        return Ok(Exit::Passed);
    }
    if let Err(error) = ctrlc::set_handler(|| INTERRUPT.store(true, Ordering::Relaxed)) {
        output::complain(&format!("interrupts cannot be caught: {error}"));
        return Err(Exit::Error);
    }
    let mut look = args.look.clone();
    if jobs.iter().any(|job| job.asks) {
        // A bar and a question would write over each other.
        look.progress = Progress::None;
    }
    let mut observer: Box<dyn Observer> = match args.look.format {
        Output::Text => Box::new(Lines::new(&look)),
        Output::Json => Box::new(Events),
    };
    execute::execute(args, &loaded, &jobs, part, &sources, &mut *observer)
}

fn list(jobs: &[Job], format: Output) {
    for job in jobs {
        match format {
            Output::Text => output::print(&format!("{}  {}\n", job.name, job.title)),
            Output::Json => events::listed(job),
        }
    }
}
