//! The exit codes, a contract with scripts and CI.

use record::Verdict;
use std::process::ExitCode;

/// The exit codes, as `--help` and the README list them.
pub const EXIT_CODES: &str = "Exit codes: 0 all passed, 1 a case failed, 2 something is wrong with your files or \
arguments (an empty selection, or no case that was judged, too), 3 inconclusive at worst, 4 an error of the rig itself, 130 interrupted after a \
clean teardown, 141 ended early because nobody reads standard output any more.";

/// How a command ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExitStatus {
    /// All passed.
    Passed,
    /// A case failed.
    Failed,
    /// Something is wrong with the user's files or arguments; nothing selected, and no case judged, too.
    UserFiles,
    /// Inconclusive at worst.
    Inconclusive,
    /// An error of the rig itself.
    Error,
    /// Interrupted by the user, after a clean teardown.
    Interrupted,
    /// Ended early, after a clean teardown: whoever read standard output closed it. The number that a shell gives a command
    /// that SIGPIPE ended.
    Unread,
}

impl ExitStatus {
    /// The number that the shell sees.
    pub const fn code(self) -> u8 {
        match self {
            ExitStatus::Passed => 0,
            ExitStatus::Failed => 1,
            ExitStatus::UserFiles => 2,
            ExitStatus::Inconclusive => 3,
            ExitStatus::Error => 4,
            ExitStatus::Interrupted => 130,
            ExitStatus::Unread => 141,
        }
    }

    /// The exit of what came to this.
    pub const fn of(verdict: Verdict) -> ExitStatus {
        match verdict {
            Verdict::Pass | Verdict::None => ExitStatus::Passed,
            Verdict::Inconclusive => ExitStatus::Inconclusive,
            Verdict::Fail => ExitStatus::Failed,
            Verdict::Error => ExitStatus::Error,
        }
    }
}

impl From<ExitStatus> for ExitCode {
    fn from(exit: ExitStatus) -> Self {
        ExitCode::from(exit.code())
    }
}
