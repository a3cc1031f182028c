//! How much of the programs under test ran.

use serde::{Deserialize, Serialize};

/// The most source files that a record has coverage of.
pub const MAX_COVERED_FILES: usize = 10_000;

/// The most ranges of lines that a file's coverage lists; further ones are left out.
pub const MAX_LINE_RANGES: usize = 10_000;

/// What of a source file ran, over all cases that ran it.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct FileCoverage {
    /// The file as the plan or the command line names it.
    pub file: String,
    /// Its statements.
    pub statements: u64,
    /// Those that ran.
    pub statements_run: u64,
    /// The ways that its conditions can go: two for each.
    pub branches: u64,
    /// Those that were gone.
    pub branches_run: u64,
    /// Lines with a statement that did not run: first and last, from 1, in order. Lines without a statement between
    /// two such lines are in the range.
    pub lines_missed: Vec<[u32; 2]>,
    /// Lines that ran with a condition that went one way only, in the same form.
    pub lines_one_way: Vec<[u32; 2]>,
    /// In a part of a suite, so that parts add up: the line of every statement, and whether it ran.
    pub statements_at: Vec<(u32, bool)>,
    /// In a part of a suite: the line of every condition, and which of its two ways were gone.
    pub branches_at: Vec<(u32, bool, bool)>,
}

impl FileCoverage {
    /// The part of the statements that ran, in tenths of a percent, rounded down so that only all of them are 1000.
    /// All of none.
    pub const fn statement_permille(&self) -> u64 {
        permille(self.statements_run, self.statements)
    }

    /// The same of the branches.
    pub const fn branch_permille(&self) -> u64 {
        permille(self.branches_run, self.branches)
    }
}

const fn permille(part: u64, all: u64) -> u64 {
    match part.saturating_mul(1000).checked_div(all) {
        Some(permille) => permille,
        None => 1000,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_all_is_all() {
        let file = FileCoverage { statements: 10_000, statements_run: 9_999, ..FileCoverage::default() };
        assert_eq!((file.statement_permille(), file.branch_permille()), (999, 1000));
        assert_eq!(FileCoverage { statements_run: 10_000, ..file }.statement_permille(), 1000);
    }
}
