//! Coverage in words: `12 of 14 (85.7 %)`, `3, 7-9`.

use record::FileCoverage;
use serde::Serialize;

/// The most ranges of lines that are written out.
const MOST_RANGES: usize = 40;

/// What is shown of a source file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub(crate) struct CoverageRow {
    pub file: String,
    pub statements: String,
    pub branches: String,
    pub missed: String,
    pub one_way: String,
}

impl CoverageRow {
    pub fn of(file: &FileCoverage) -> CoverageRow {
        CoverageRow {
            file: file.file.clone(),
            statements: part(file.statements_run, file.statements, file.statement_permille()),
            branches: part(file.branches_run, file.branches, file.branch_permille()),
            missed: lines(&file.lines_missed),
            one_way: lines(&file.lines_one_way),
        }
    }
}

fn part(part: u64, all: u64, permille: u64) -> String {
    if all == 0 {
        return String::from("none");
    }
    format!("{part} of {all} ({}.{} %)", permille / 10, permille % 10)
}

fn lines(ranges: &[[u32; 2]]) -> String {
    let mut words: Vec<String> = ranges
        .iter()
        .take(MOST_RANGES)
        .map(|[first, last]| if first == last { first.to_string() } else { format!("{first}-{last}") })
        .collect();
    if ranges.len() > MOST_RANGES {
        words.push(format!("and {} more", ranges.len() - MOST_RANGES));
    }
    words.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_in_words() {
        let file = FileCoverage {
            file: String::from("lamp.st"),
            statements: 14,
            statements_run: 12,
            lines_missed: vec![[3, 3], [7, 9]],
            lines_one_way: (0..50).map(|n| [2 * n, 2 * n]).collect(),
            ..FileCoverage::default()
        };
        let row = CoverageRow::of(&file);
        assert_eq!((row.statements.as_str(), row.branches.as_str()), ("12 of 14 (85.7 %)", "none"));
        assert_eq!(row.missed, "3, 7-9");
        assert!(row.one_way.ends_with("78, and 10 more"), "{}", row.one_way);
    }
}
