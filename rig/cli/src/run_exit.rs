//! How a command ends that ran cases, or put their records together.

use crate::exit::ExitStatus;
use crate::output;
use record::RunRecord;

/// The exit of a run. One in which no case was judged says nothing of the controller: that is no pass, but for a part of
/// a suite, whose other parts have the cases. Why is printed.
pub fn of(run: &RunRecord) -> ExitStatus {
    let totals = &run.totals;
    if totals.judged() > 0 {
        return ExitStatus::of(run.verdict());
    }
    if run.shard.is_some() {
        output::note(
            "no case of this part was judged: `rig report --merge` ends by the verdict of all parts",
        );
        return ExitStatus::Passed;
    }
    let why = "`--status-level all` prints why each does not apply; select other cases, or name a board that has what they need";
    none_judged(totals.not_applicable, why)
}

/// The exit of cases that all do not apply, which is printed with what to do.
pub fn none_judged(cases: u64, help: &str) -> ExitStatus {
    let message = match cases {
        1 => String::from("no case was judged: the only one does not apply here"),
        count => format!("no case was judged: none of {count} applies here"),
    };
    output::refuse("R0231", message, help)
}

/// What to do where the reasons are printed already.
pub const REASONS_ARE_PRINTED: &str = "choose another case, or a board that has what this one needs";
