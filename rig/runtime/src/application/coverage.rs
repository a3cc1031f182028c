//! What of a program ran, added up over applications and cases.

use program::{Coverage, Program};
use record::{FileCoverage, MAX_COVERED_FILES, MAX_LINE_RANGES};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

/// Where the applications of a case leave what of them ran: a controller that boots again makes a new one.
#[derive(Clone, Debug, Default)]
pub struct Collector(Arc<Mutex<BTreeMap<[u8; 32], Coverage>>>);

impl Collector {
    /// Adds what ran of an application of the program with this digest.
    pub fn add(&self, digest: [u8; 32], coverage: Coverage) {
        let mut sums = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let sum = sums.entry(digest).or_default();
        if sum.statements.len() != coverage.statements.len() {
            *sum = coverage;
            return;
        }
        for (sum, ran) in sum.statements.iter_mut().zip(coverage.statements) {
            sum.executed |= ran.executed;
        }
        for (sum, ran) in sum.branches.iter_mut().zip(coverage.branches) {
            sum.taken |= ran.taken;
            sum.passed |= ran.passed;
        }
    }

    /// What was added of a program, file by file.
    pub fn take(&self, program: &Program) -> Vec<CoveredFile> {
        let sums = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        sums.get(&program.digest()).map_or_else(Vec::new, |coverage| by_file(program, coverage))
    }
}

/// A place of the source with what of it ran.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct CoveredPlace {
    line: u32,
    /// Ways that it can go, and those that it went: one for a statement, two for a condition.
    ways: [bool; 2],
}

/// What of a source file ran.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct CoveredFile {
    file: String,
    statements: Vec<CoveredPlace>,
    branches: Vec<CoveredPlace>,
}

/// The coverage of a program, file by file in the order of the sources.
pub fn by_file(program: &Program, coverage: &Coverage) -> Vec<CoveredFile> {
    let named = |name: &String| CoveredFile { file: name.clone(), ..CoveredFile::default() };
    let mut files: Vec<CoveredFile> = program.files().iter().map(named).collect();
    for statement in &coverage.statements {
        if let Some(file) = files.get_mut(usize::from(statement.file)) {
            file.statements.push(CoveredPlace { line: statement.line, ways: [statement.executed; 2] });
        }
    }
    for branch in &coverage.branches {
        if let Some(file) = files.get_mut(usize::from(branch.file)) {
            file.branches.push(CoveredPlace { line: branch.line, ways: [branch.taken, branch.passed] });
        }
    }
    files.retain(|file| !file.statements.is_empty());
    files
}

/// The coverage of a whole run: cases that ran the same file add up.
#[derive(Clone, Debug, Default)]
pub struct CoverageTotal {
    files: Vec<CoveredFile>,
}

impl CoverageTotal {
    /// Adds what a case ran. A file that reads otherwise than an earlier one of its name stands for itself.
    pub fn add(&mut self, files: Vec<CoveredFile>) {
        for file in files {
            if let Some(known) = self.files.iter_mut().find(|known| known.is_like(&file)) {
                known.merge(&file);
            } else if self.files.len() < MAX_COVERED_FILES {
                self.files.push(file);
            }
        }
    }

    /// As the record has it.
    pub fn record(&self) -> Vec<FileCoverage> {
        self.files.iter().map(CoveredFile::record).collect()
    }

    /// As the record of a part of a suite has it: with every statement, so that parts add up.
    pub fn part(&self) -> Vec<FileCoverage> {
        self.files.iter().map(CoveredFile::part).collect()
    }

    /// Adds what [`CoverageTotal::part`] gave; false when it lacks the statements.
    #[must_use]
    pub fn add_part(&mut self, files: &[FileCoverage]) -> bool {
        let parts: Option<Vec<CoveredFile>> = files.iter().map(CoveredFile::of_part).collect();
        let whole = parts.is_some();
        self.add(parts.unwrap_or_default());
        whole
    }
}

fn same_lines(left: &[CoveredPlace], right: &[CoveredPlace]) -> bool {
    left.iter().map(|ran| ran.line).eq(right.iter().map(|ran| ran.line))
}

impl CoveredFile {
    fn is_like(&self, other: &CoveredFile) -> bool {
        self.file == other.file
            && same_lines(&self.statements, &other.statements)
            && same_lines(&self.branches, &other.branches)
    }

    fn merge(&mut self, other: &CoveredFile) {
        let lists = [(&mut self.statements, &other.statements), (&mut self.branches, &other.branches)];
        for (sum, more) in lists.into_iter().flat_map(|(sum, more)| sum.iter_mut().zip(more)) {
            sum.ways = [sum.ways[0] | more.ways[0], sum.ways[1] | more.ways[1]];
        }
    }

    fn part(&self) -> FileCoverage {
        FileCoverage {
            statements_at: self.statements.iter().map(|ran| (ran.line, ran.ways[0])).collect(),
            branches_at: self.branches.iter().map(|ran| (ran.line, ran.ways[0], ran.ways[1])).collect(),
            ..self.record()
        }
    }

    fn of_part(file: &FileCoverage) -> Option<CoveredFile> {
        let statement = |(line, ran): &(u32, bool)| CoveredPlace { line: *line, ways: [*ran; 2] };
        let branch =
            |(line, one, other): &(u32, bool, bool)| CoveredPlace { line: *line, ways: [*one, *other] };
        (file.statements_at.len() as u64 == file.statements).then(|| CoveredFile {
            file: file.file.clone(),
            statements: file.statements_at.iter().map(statement).collect(),
            branches: file.branches_at.iter().map(branch).collect(),
        })
    }

    /// As the record has it.
    pub fn record(&self) -> FileCoverage {
        let missed = |ran: &CoveredPlace| ran.ways == [false; 2];
        let ways: usize = self.branches.iter().map(|ran| ran.ways.iter().filter(|went| **went).count()).sum();
        let mut one_way: Vec<u32> =
            self.branches.iter().filter(|ran| ran.ways[0] != ran.ways[1]).map(|ran| ran.line).collect();
        one_way.sort_unstable();
        // A range of these goes on only from one line to the next: lines between them say something else.
        let one_way = ranges(&one_way, |last, line| line - last <= 1);
        let mut lines: Vec<(u32, bool)> = self.statements.iter().map(|ran| (ran.line, missed(ran))).collect();
        lines.sort_unstable();
        let missing: Vec<u32> = lines.iter().filter(|(_, missed)| *missed).map(|(line, _)| *line).collect();
        let mut ran: Vec<u32> = lines.iter().filter(|(_, missed)| !missed).map(|(line, _)| *line).collect();
        ran.dedup();
        let between = |last: u32, line: u32| {
            let after = ran.partition_point(|ran| *ran <= last);
            ran.get(after).is_none_or(|next| *next >= line) && ran.binary_search(&last).is_err()
        };
        FileCoverage {
            file: self.file.clone(),
            statements: self.statements.len() as u64,
            statements_run: self.statements.iter().filter(|ran| !missed(ran)).count() as u64,
            branches: 2 * self.branches.len() as u64,
            branches_run: ways as u64,
            lines_missed: ranges(&missing, between),
            lines_one_way: one_way,
            ..FileCoverage::default()
        }
    }
}

/// Lines in order as ranges; `joins` says whether a line goes on from the last one.
fn ranges(lines: &[u32], joins: impl Fn(u32, u32) -> bool) -> Vec<[u32; 2]> {
    let mut ranges: Vec<[u32; 2]> = Vec::new();
    for line in lines {
        if let Some([_, last]) = ranges.last_mut()
            && (last == line || joins(*last, *line))
        {
            *last = *line;
        } else if ranges.len() < MAX_LINE_RANGES {
            ranges.push([*line, *line]);
        } else {
            break;
        }
    }
    ranges
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(statements: &[(u32, bool)], branches: &[(u32, bool, bool)]) -> CoveredFile {
        CoveredFile {
            file: String::from("a.st"),
            statements: statements
                .iter()
                .map(|(line, ran)| CoveredPlace { line: *line, ways: [*ran; 2] })
                .collect(),
            branches: branches
                .iter()
                .map(|(line, a, b)| CoveredPlace { line: *line, ways: [*a, *b] })
                .collect(),
        }
    }

    #[test]
    fn lines_that_follow_each_other_are_a_range() {
        let covered = file(
            &[
                (3, true),
                (4, false),
                (9, false),
                (10, true),
                (12, false),
                (13, true),
                (13, false),
                (14, false),
            ],
            &[(3, true, false), (10, true, true), (12, false, false)],
        );
        let record = covered.record();
        assert_eq!((record.statements, record.statements_run), (8, 3));
        assert_eq!((record.branches, record.branches_run), (6, 3));
        assert_eq!(record.lines_missed, [[4, 9], [12, 13], [14, 14]]);
        assert_eq!(record.lines_one_way, [[3, 3]]);
    }

    #[test]
    fn cases_add_up() {
        let mut total = CoverageTotal::default();
        total.add(vec![file(&[(1, true), (2, false)], &[(1, true, false)])]);
        total.add(vec![file(&[(1, false), (2, true)], &[(1, false, true)])]);
        // Another text under the same name.
        total.add(vec![file(&[(1, false)], &[])]);
        let files = total.record();
        assert_eq!(files.len(), 2);
        assert_eq!((files[0].statements_run, files[0].branches_run), (2, 2));
        assert_eq!((files[1].statements_run, files[1].lines_missed.as_slice()), (0, &[[1, 1]][..]));
    }
}
