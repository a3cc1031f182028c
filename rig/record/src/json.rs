//! The record as JSON, and a reader that refuses what it cannot trust.

use crate::{
    CaseRecord, FORMAT, FileCoverage, MAX_COVERED_FILES, MAX_LANE_POINTS, MAX_LINE_RANGES, MAX_LOG_LINES,
    OLDEST_FORMAT, RunRecord, Totals, compact::Compact,
};
use serde::{Deserialize, Serialize};
use serde_json::ser::Formatter;
use std::{fmt, io};

/// The longest JSON text that is read.
pub const MAX_JSON_BYTES: usize = 256 << 20;

/// The most cases of one record.
pub const MAX_CASES: usize = 100_000;

/// Why a text is no record of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RecordError {
    /// R0401: longer than [`MAX_JSON_BYTES`].
    TooLong {
        /// Its length in bytes.
        bytes: usize,
    },
    /// R0402: not JSON, at this place.
    Syntax {
        /// Line from 1.
        line: usize,
        /// Column from 1.
        column: usize,
    },
    /// R0403: JSON, but not of the shape of a record, at this place.
    Shape {
        /// Line from 1.
        line: usize,
        /// Column from 1.
        column: usize,
    },
    /// R0404: written by another version.
    Format {
        /// The version found.
        found: u64,
    },
    /// R0405: more cases, lane points or log lines than a record may hold.
    TooMany {
        /// Place of the case, from 0.
        case: usize,
    },
    /// R0406: two cases have the same name.
    DuplicateCase {
        /// Place of the second one, from 0.
        case: usize,
    },
    /// R0407: the totals are not those of the cases.
    Totals,
    /// R0408: an interval of time runs backwards.
    Backwards {
        /// Place of the case, from 0.
        case: usize,
    },
    /// R0409: a coverage that cannot be: more that ran than there is, lines that run backwards, too much of it.
    Coverage {
        /// Place of the file, from 0.
        file: usize,
    },
    /// R0411: a part of a suite that cannot be: the third of two.
    Shard,
}

impl RecordError {
    /// The code that has a page.
    pub const fn code(self) -> &'static str {
        match self {
            Self::TooLong { .. } => "R0401",
            Self::Syntax { .. } => "R0402",
            Self::Shape { .. } => "R0403",
            Self::Format { .. } => "R0404",
            Self::TooMany { .. } => "R0405",
            Self::DuplicateCase { .. } => "R0406",
            Self::Totals => "R0407",
            Self::Backwards { .. } => "R0408",
            Self::Coverage { .. } => "R0409",
            Self::Shard => "R0411",
        }
    }
}

impl fmt::Display for RecordError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooLong { bytes } => {
                write!(f, "the record has {bytes} bytes; at most {MAX_JSON_BYTES} are read")
            }
            Self::Syntax { line, column } => write!(f, "not JSON at line {line}, column {column}"),
            Self::Shape { line, column } => {
                write!(f, "not the record of a run: wrong field or type at line {line}, column {column}")
            }
            Self::Format { found } => {
                write!(
                    f,
                    "the record has format {found}; this version of rig reads formats {OLDEST_FORMAT} to {FORMAT}"
                )
            }
            Self::TooMany { case } => write!(f, "more data than a record may hold, at case {case}"),
            Self::DuplicateCase { case } => {
                write!(f, "case {case} has the name of an earlier one")
            }
            Self::Totals => f.write_str("the totals do not agree with the cases: the record was edited"),
            Self::Backwards { case } => write!(f, "an interval of time runs backwards in case {case}"),
            Self::Coverage { file } => {
                write!(f, "the coverage of source file {file} cannot be: the record was edited")
            }
            Self::Shard => f.write_str("its part of the suite cannot be: the record was edited"),
        }
    }
}

impl std::error::Error for RecordError {}

impl RunRecord {
    /// The record as JSON: fields in the order of their declaration without the empty ones, a line for each case, a
    /// final newline.
    pub fn to_json(&self) -> String {
        let mut out = Vec::new();
        let mut writer = serde_json::Serializer::with_formatter(&mut out, Lines { depth: 0 });
        // Every map key is a string and every number finite or written as a word, so this cannot fail.
        let _ = Compact(self).serialize(&mut writer);
        out.push(b'\n');
        String::from_utf8(out).unwrap_or_default()
    }

    /// Reads what [`RunRecord::to_json`] writes.
    ///
    /// # Errors
    /// [`RecordError`], with the place; never panics, whatever the text.
    pub fn from_json(text: &str) -> Result<RunRecord, RecordError> {
        if text.len() > MAX_JSON_BYTES {
            return Err(RecordError::TooLong { bytes: text.len() });
        }
        // The version first: the shape of another version is not an error of shape.
        #[derive(Deserialize)]
        struct Versioned {
            format: u64,
        }
        let versioned: Versioned = serde_json::from_str(text).map_err(located)?;
        if !(u64::from(OLDEST_FORMAT)..=u64::from(FORMAT)).contains(&versioned.format) {
            return Err(RecordError::Format { found: versioned.format });
        }
        let record: RunRecord = serde_json::from_str(text).map_err(located)?;
        record.check()?;
        Ok(record)
    }

    /// Checks bounds, names, totals, the order of interval ends and what coverage there is.
    ///
    /// # Errors
    /// The first of [`RecordError`] that applies.
    pub fn check(&self) -> Result<(), RecordError> {
        if self.cases.len() > MAX_CASES {
            return Err(RecordError::TooMany { case: MAX_CASES });
        }
        let mut names = std::collections::BTreeSet::new();
        for (place, case) in self.cases.iter().enumerate() {
            if !names.insert(case.name.as_str()) {
                return Err(RecordError::DuplicateCase { case: place });
            }
            if case.log.len() > MAX_LOG_LINES || case.lanes.iter().any(|l| l.points.len() > MAX_LANE_POINTS) {
                return Err(RecordError::TooMany { case: place });
            }
            if intervals(case).any(|[earliest, latest]| earliest > latest) {
                return Err(RecordError::Backwards { case: place });
            }
        }
        let impossible = |file: &FileCoverage| {
            let lines = [&file.lines_missed, &file.lines_one_way];
            let detailed = !file.statements_at.is_empty();
            file.statements_run > file.statements
                || detailed && file.statements_at.len() as u64 != file.statements
                || detailed && 2 * file.branches_at.len() as u64 != file.branches
                || file.branches_run > file.branches
                || lines.iter().any(|list| list.len() > MAX_LINE_RANGES)
                || lines.into_iter().flatten().any(|[first, last]| first > last)
        };
        if self.coverage.len() > MAX_COVERED_FILES {
            return Err(RecordError::Coverage { file: MAX_COVERED_FILES });
        }
        if let Some(file) = self.coverage.iter().position(impossible) {
            return Err(RecordError::Coverage { file });
        }
        if self.shard.is_some_and(|[part, of]| part == 0 || part > of) {
            return Err(RecordError::Shard);
        }
        if self.totals == Totals::of(&self.cases) { Ok(()) } else { Err(RecordError::Totals) }
    }
}

/// JSON without blanks, but for a line end before each element of the outermost lists: tools for text then find and
/// compare cases.
struct Lines {
    /// Brackets that are open.
    depth: usize,
}

impl Formatter for Lines {
    fn begin_array<W: io::Write + ?Sized>(&mut self, writer: &mut W) -> io::Result<()> {
        self.depth += 1;
        writer.write_all(b"[")
    }
    fn end_array<W: io::Write + ?Sized>(&mut self, writer: &mut W) -> io::Result<()> {
        self.depth -= 1;
        writer.write_all(b"]")
    }
    fn begin_array_value<W: io::Write + ?Sized>(&mut self, writer: &mut W, first: bool) -> io::Result<()> {
        writer.write_all(match (self.depth, first) {
            (2, true) => b"\n",
            (2, false) => b",\n",
            (_, true) => b"",
            (_, false) => b",",
        })
    }
    fn begin_object<W: io::Write + ?Sized>(&mut self, writer: &mut W) -> io::Result<()> {
        self.depth += 1;
        writer.write_all(b"{")
    }
    fn end_object<W: io::Write + ?Sized>(&mut self, writer: &mut W) -> io::Result<()> {
        self.depth -= 1;
        writer.write_all(b"}")
    }
}

fn intervals(case: &CaseRecord) -> impl Iterator<Item = [i64; 2]> {
    let claims = case.claims.iter().flat_map(|claim| {
        let window = claim.window.iter().flat_map(|w| [w.from_ns, w.until_ns]);
        claim.deciding_ns.into_iter().chain(window)
    });
    let measurements = case.measurements.iter().flat_map(|m| m.from_ns.into_iter().chain(m.to_ns));
    let steps = case.steps.iter().filter_map(|s| s.at_ns);
    let lanes = case.lanes.iter().flat_map(|l| l.points.iter().map(|p| p.at));
    claims.chain(measurements).chain(steps).chain(lanes)
}

fn located(error: serde_json::Error) -> RecordError {
    let (line, column) = (error.line(), error.column());
    match error.classify() {
        serde_json::error::Category::Data => RecordError::Shape { line, column },
        _ => RecordError::Syntax { line, column },
    }
}
