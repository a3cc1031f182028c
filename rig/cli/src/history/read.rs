//! The last runs of a history.

use super::database::HistoryDatabase;
use document::Diagnostic;
use record::Unguarded;
use rusqlite::params;
use std::collections::BTreeMap;

/// The most figures that are looked at.
const MOST_FIGURES: i64 = 5_000_000;

/// A run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct PastRun {
    /// Where it was added from.
    pub name: String,
    /// When it began; empty where that is not known.
    pub started: String,
    /// The rig's version.
    pub rig_version: String,
    /// What it came to.
    pub verdict: String,
    /// Cases that passed.
    pub passed: u64,
    /// Judged cases that did not.
    pub others: u64,
    /// Those that were measured without a guard band.
    pub unguarded: Unguarded,
}

/// What became of a case in a run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct PastResult {
    /// Place of the run.
    pub run: usize,
    /// A verdict, `skipped` or `not-applicable`.
    pub outcome: String,
    /// Digest of what it was made from.
    pub made_from: String,
}

/// A claim's margin or a measurement, run by run.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PastFigure {
    /// The case.
    pub case: String,
    /// Its name.
    pub name: String,
    /// A measurement; otherwise a claim.
    pub measured: bool,
    /// Unit of all its numbers.
    pub unit: String,
    /// Place of the run, the middle of what was measured, the margin.
    pub points: Vec<(usize, Option<f64>, Option<f64>)>,
}

/// The last runs, the oldest first.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct PastRuns {
    /// The runs.
    pub runs: Vec<PastRun>,
    /// Results of each case, in the order of names.
    pub cases: BTreeMap<String, Vec<PastResult>>,
    /// Figures, in the order of cases and names.
    pub figures: Vec<PastFigure>,
}

/// Reads the last runs, of the cases whose name holds a text.
///
/// # Errors
/// The file cannot be read.
pub(super) fn read(
    database: &HistoryDatabase,
    last: u32,
    only: Option<&str>,
) -> Result<PastRuns, Diagnostic> {
    query(database, last, only).map_err(|error| database.fault(&error))
}

fn query(database: &HistoryDatabase, last: u32, only: Option<&str>) -> rusqlite::Result<PastRuns> {
    // One moment for all that is read: another command may add a run meanwhile.
    let moment = database.connection().unchecked_transaction()?;
    let mut past = PastRuns::default();
    let mut places: BTreeMap<i64, usize> = BTreeMap::new();
    let mut statement = moment.prepare(
        "SELECT id, name, started, rig_version, verdict, passed, others
         FROM (SELECT * FROM run ORDER BY id DESC LIMIT ?1) ORDER BY id",
    )?;
    let mut rows = statement.query([i64::from(last)])?;
    while let Some(row) = rows.next()? {
        places.insert(row.get(0)?, past.runs.len());
        past.runs.push(PastRun {
            name: row.get(1)?,
            started: row.get(2)?,
            rig_version: row.get(3)?,
            verdict: row.get(4)?,
            passed: row.get::<_, i64>(5)?.unsigned_abs(),
            others: row.get::<_, i64>(6)?.unsigned_abs(),
            unguarded: Unguarded::default(),
        });
    }
    // A history that a rig of before wrote has no such table.
    let known = "SELECT count(*) > 0 FROM sqlite_schema WHERE name = 'unguarded'";
    if moment.query_row(known, [], |row| row.get(0))? {
        let mut statement = moment.prepare("SELECT run, cases, by_middle FROM unguarded")?;
        let mut rows = statement.query([])?;
        while let Some(row) = rows.next()? {
            let Some(run) = places.get(&row.get(0)?).and_then(|place| past.runs.get_mut(*place)) else {
                continue;
            };
            let [cases, by_middle] = [row.get::<_, i64>(1)?, row.get(2)?].map(i64::unsigned_abs);
            run.unguarded = Unguarded { cases, by_middle };
        }
    }
    let oldest = places.keys().next().copied().unwrap_or(0);
    let only = only.unwrap_or_default();
    let mut statement = moment.prepare(
        "SELECT case_name.name, run, outcome, made_from FROM case_result
         JOIN case_name ON case_name.id = case_id
         WHERE run >= ?1 AND instr(case_name.name, ?2) > 0 ORDER BY case_name.name, run",
    )?;
    let mut rows = statement.query(params![oldest, only])?;
    while let Some(row) = rows.next()? {
        let Some(run) = places.get(&row.get(1)?).copied() else { continue };
        let result = PastResult { run, outcome: row.get(2)?, made_from: row.get(3)? };
        past.cases.entry(row.get(0)?).or_default().push(result);
    }
    let mut statement = moment.prepare(
        "SELECT figure_id, case_name.name, figure_name.name, measured, unit, run, low, high, margin FROM figure
         JOIN figure_name ON figure_name.id = figure_id
         JOIN case_name ON case_name.id = case_id
         WHERE run >= ?1 AND instr(case_name.name, ?2) > 0
         ORDER BY case_name.name, measured, figure_name.name, figure_id, run LIMIT ?3",
    )?;
    let mut rows = statement.query(params![oldest, only, MOST_FIGURES])?;
    let mut current: Option<i64> = None;
    while let Some(row) = rows.next()? {
        let Some(run) = places.get(&row.get(5)?).copied() else { continue };
        let id: i64 = row.get(0)?;
        if current != Some(id) {
            current = Some(id);
            past.figures.push(PastFigure {
                case: row.get(1)?,
                name: row.get(2)?,
                measured: row.get(3)?,
                unit: row.get(4)?,
                points: Vec::new(),
            });
        }
        let (low, high): (Option<f64>, Option<f64>) = (row.get(6)?, row.get(7)?);
        let middle = low.zip(high).map(|(low, high)| low + (high - low) / 2.0);
        if let Some(figure) = past.figures.last_mut() {
            figure.points.push((run, middle, row.get(8)?));
        }
    }
    Ok(past)
}
