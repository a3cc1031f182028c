//! The cases that run, out of all that the plans have.

use super::args::TestArgs;
use crate::exit::ExitStatus;
use crate::output;
use crate::selection::{CaseFacts, Selection};
use runtime::suite::{Job, LoadedPlan};

/// Cases that a selection is made from.
const MOST_CASES: u64 = 10 * record::MAX_CASES as u64;

/// The jobs that the command line selects, at least one.
///
/// # Errors
/// How the command ends; why is printed.
pub fn choose(args: &TestArgs, loaded: &[LoadedPlan]) -> Result<Vec<Job>, ExitStatus> {
    let selection = match &args.only {
        None => Selection::All,
        Some(expression) => Selection::of(expression)?,
    };
    // Those that are looked through, and those that run: each within what the memory and a record hold.
    let all: u64 = loaded.iter().map(|plan| plan.plan.turns()).sum();
    if all.saturating_mul(u64::from(args.repeat.get())) > MOST_CASES {
        return Err(too_many());
    }
    let mut jobs = Vec::new();
    for (place, plan) in loaded.iter().enumerate() {
        let all = plan.jobs(place, args.seed, args.repeat.get()).into_iter();
        jobs.extend(all.filter(|job| selection.matches(&CaseFacts::of(job))));
    }
    if jobs.is_empty() {
        let help = "`rig test --list` with the same files and without --only prints the names that there are";
        return Err(output::refuse("R0228", "no case is selected", help));
    }
    if jobs.len() > record::MAX_CASES {
        return Err(too_many());
    }
    let mut names: Vec<&str> = jobs.iter().map(|job| job.name.as_str()).collect();
    names.sort_unstable();
    if let Some(twice) = names.windows(2).find(|pair| pair[0] == pair[1]) {
        let message = format!("two cases have the name {}: a plan is given twice", twice[0]);
        return Err(output::refuse(
            "R0233",
            message,
            "name each plan once, and no folder beside a plan that is in it",
        ));
    }
    Ok(jobs)
}

fn too_many() -> ExitStatus {
    let message = format!("these are more than {} cases", record::MAX_CASES);
    output::refuse("R0233", message, "select fewer with --only, or repeat them less often")
}
