//! The file: its tables, what is added, what is forgotten.
//!
//! A run is added in one transaction, so that a history never holds half of one. The rollback journal is kept, and not
//! the write-ahead log: the history stays one file, which a CI server can cache.

use document::Diagnostic;
use record::{CaseRecord, CaseStatus, RunRecord, Unguarded, Verdict};
use rusqlite::config::DbConfig;
use rusqlite::{
    Connection, ErrorCode, OpenFlags, OptionalExtension, Statement, ToSql, Transaction, TransactionBehavior,
    params,
};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Marks a file as a history of rig: "RigH".
const APPLICATION: i32 = 0x5269_6748;

/// Version of the tables.
const VERSION: i32 = 1;

/// How long another command may have the file.
const PATIENCE: Duration = Duration::from_secs(10);

const TABLES: &str = "
    CREATE TABLE run (
        id INTEGER PRIMARY KEY AUTOINCREMENT,
        sha256 TEXT NOT NULL UNIQUE,
        name TEXT NOT NULL,
        started TEXT NOT NULL,
        rig_version TEXT NOT NULL,
        binary_sha256 TEXT NOT NULL,
        kernel TEXT NOT NULL,
        clock TEXT NOT NULL,
        seed TEXT NOT NULL,
        verdict TEXT NOT NULL,
        passed INTEGER NOT NULL,
        others INTEGER NOT NULL
    );
    CREATE TABLE case_name (id INTEGER PRIMARY KEY, name TEXT NOT NULL UNIQUE);
    CREATE TABLE case_result (
        case_id INTEGER NOT NULL,
        run INTEGER NOT NULL,
        outcome TEXT NOT NULL,
        made_from TEXT NOT NULL,
        PRIMARY KEY (case_id, run)
    ) WITHOUT ROWID;
    CREATE TABLE figure_name (
        id INTEGER PRIMARY KEY,
        case_id INTEGER NOT NULL,
        measured INTEGER NOT NULL,
        name TEXT NOT NULL,
        turn INTEGER NOT NULL,
        unit TEXT NOT NULL,
        UNIQUE (case_id, measured, name, turn, unit)
    );
    CREATE TABLE figure (
        figure_id INTEGER NOT NULL,
        run INTEGER NOT NULL,
        low REAL,
        high REAL,
        margin REAL,
        PRIMARY KEY (figure_id, run)
    ) WITHOUT ROWID;
";

/// How many cases of a run were measured without a guard band. A table beside the others: rigs of before pass over it, and it is made
/// where it is not there.
const UNGUARDED: &str = "CREATE TABLE IF NOT EXISTS unguarded (run INTEGER PRIMARY KEY, cases INTEGER NOT NULL, by_middle INTEGER NOT NULL)";

/// What became of a run that was to be added.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum AddOutcome {
    /// It is new.
    New,
    /// It was there already.
    Known,
}

/// An open history.
#[derive(Debug)]
pub(super) struct HistoryDatabase {
    path: PathBuf,
    connection: Connection,
}

impl HistoryDatabase {
    /// Opens a history, or makes one where there is no file or an empty one.
    ///
    /// # Errors
    /// The file is no history, or cannot be used now.
    pub(super) fn open_or_make(path: &Path) -> Result<HistoryDatabase, Diagnostic> {
        let flags = OpenFlags::SQLITE_OPEN_READ_WRITE | OpenFlags::SQLITE_OPEN_CREATE;
        let mut database = HistoryDatabase::connect(path, flags)?;
        let said = |error| fault(path, &error);
        // Within a transaction: two commands may make the file at once.
        let make = |connection: &mut Connection| -> rusqlite::Result<()> {
            connection.pragma_update(None, "auto_vacuum", "FULL")?;
            let transaction = connection.transaction_with_behavior(TransactionBehavior::Immediate)?;
            if empty(&transaction)? {
                transaction.execute_batch(TABLES)?;
                transaction.pragma_update(None, "application_id", APPLICATION)?;
                transaction.pragma_update(None, "user_version", VERSION)?;
            }
            transaction.commit()
        };
        if empty(&database.connection).map_err(said)? {
            make(&mut database.connection).map_err(said)?;
        }
        database.checked()
    }

    /// Opens a history for reading.
    ///
    /// # Errors
    /// The file is not there, no history, or cannot be used now.
    pub(super) fn open(path: &Path) -> Result<HistoryDatabase, Diagnostic> {
        if !path.is_file() {
            return Err(Diagnostic::error("R0168", format!("there is no history `{}`", path.display()))
                .help("`rig history add RUN` makes one; `--file` names it"));
        }
        HistoryDatabase::connect(path, OpenFlags::SQLITE_OPEN_READ_ONLY)?.checked()
    }

    fn connect(path: &Path, flags: OpenFlags) -> Result<HistoryDatabase, Diagnostic> {
        // SQLite opens a pipe, and waits.
        if std::fs::metadata(path).is_ok_and(|found| !found.is_file()) {
            return Err(foreign(path, "it is no regular file"));
        }
        let flags = flags | OpenFlags::SQLITE_OPEN_NO_MUTEX;
        let connection = Connection::open_with_flags(path, flags).map_err(|error| fault(path, &error))?;
        let settings = || -> rusqlite::Result<()> {
            connection.busy_timeout(PATIENCE)?;
            connection.pragma_update(None, "synchronous", "FULL")?;
            // Nothing in the file is run as code, whoever wrote it.
            for (config, on) in [
                (DbConfig::SQLITE_DBCONFIG_DEFENSIVE, true),
                (DbConfig::SQLITE_DBCONFIG_TRUSTED_SCHEMA, false),
                (DbConfig::SQLITE_DBCONFIG_ENABLE_TRIGGER, false),
                (DbConfig::SQLITE_DBCONFIG_ENABLE_VIEW, false),
            ] {
                connection.set_db_config(config, on)?;
            }
            Ok(())
        };
        settings().map_err(|error| fault(path, &error))?;
        Ok(HistoryDatabase { path: path.to_owned(), connection })
    }

    /// The same, if it is a history that this version knows.
    fn checked(self) -> Result<HistoryDatabase, Diagnostic> {
        let number = |name: &str| -> Result<i32, Diagnostic> {
            self.connection
                .pragma_query_value(None, name, |row| row.get(0))
                .map_err(|error| self.fault(&error))
        };
        if number("application_id")? != APPLICATION {
            return Err(foreign(&self.path, "it is a database of another program"));
        }
        match number("user_version")? {
            VERSION => {
                // A view in place of a table, or a trigger, is of somebody else.
                let sql =
                    "SELECT type, name FROM sqlite_schema WHERE type NOT IN ('table', 'index') ORDER BY name";
                let other: rusqlite::Result<Option<(String, String)>> =
                    self.connection.query_row(sql, [], |row| Ok((row.get(0)?, row.get(1)?))).optional();
                match other.map_err(|error| self.fault(&error))? {
                    None => Ok(self),
                    Some((kind, name)) => {
                        Err(foreign(&self.path, &format!("it has a {kind} `{name}`, which no history has")))
                    }
                }
            }
            other => Err(Diagnostic::error(
                "R0169",
                format!(
                    "`{}` is a history of version {other}; this rig reads version {VERSION}",
                    self.path.display()
                ),
            )
            .help("use the `rig` that wrote it, or begin a new history")),
        }
    }

    /// The connection, for reading.
    pub(super) const fn connection(&self) -> &Connection {
        &self.connection
    }

    /// What went wrong, as a finding.
    pub(super) fn fault(&self, error: &rusqlite::Error) -> Diagnostic {
        fault(&self.path, error)
    }

    /// How many runs there are.
    ///
    /// # Errors
    /// The file cannot be read.
    pub(super) fn count(&self) -> Result<u64, Diagnostic> {
        let count: rusqlite::Result<i64> =
            self.connection.query_row("SELECT count(*) FROM run", [], |row| row.get(0));
        count.map(|count| count.unsigned_abs()).map_err(|error| self.fault(&error))
    }

    /// Adds a run and forgets the oldest ones, so that `keep` are left.
    ///
    /// # Errors
    /// The file cannot be written; then nothing of the run is in it.
    pub(super) fn add(&mut self, name: &str, run: &RunRecord, keep: u32) -> Result<AddOutcome, Diagnostic> {
        let sha256 = runtime::suite::describe::sha256(run.to_json().as_bytes());
        let path = self.path.clone();
        let mut write = || -> rusqlite::Result<AddOutcome> {
            let transaction = self.connection.transaction_with_behavior(TransactionBehavior::Immediate)?;
            let known: Option<i64> = transaction
                .query_row("SELECT id FROM run WHERE sha256 = ?1", [&sha256], |row| row.get(0))
                .optional()?;
            if known.is_some() {
                return Ok(AddOutcome::Known);
            }
            insert(&transaction, name, &sha256, run)?;
            forget(&transaction, keep)?;
            transaction.commit()?;
            Ok(AddOutcome::New)
        };
        write().map_err(|error| fault(&path, &error))
    }
}

fn empty(connection: &Connection) -> rusqlite::Result<bool> {
    connection.query_row("SELECT count(*) = 0 FROM sqlite_schema", [], |row| row.get(0))
}

fn insert(transaction: &Transaction<'_>, name: &str, sha256: &str, run: &RunRecord) -> rusqlite::Result<()> {
    let facts = &run.provenance;
    let started = facts.started.clone().unwrap_or_default();
    let passed = i64::try_from(run.totals.passed).unwrap_or(i64::MAX);
    let others = i64::try_from(run.totals.judged() - run.totals.passed).unwrap_or(i64::MAX);
    transaction.execute(
        "INSERT INTO run (sha256, name, started, rig_version, binary_sha256, kernel, clock, seed, verdict, passed, others)
         VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11)",
        params![
            sha256,
            name,
            started,
            run.rig_version,
            facts.binary_sha256,
            facts.kernel,
            facts.clock.word(),
            facts.seed.to_string(),
            run.verdict().word(),
            passed,
            others
        ],
    )?;
    let id = transaction.last_insert_rowid();
    let Unguarded { cases, by_middle } = run.unguarded();
    transaction.execute_batch(UNGUARDED)?;
    transaction.execute(
        "INSERT OR REPLACE INTO unguarded (run, cases, by_middle) VALUES (?1, ?2, ?3)",
        params![id, cases.cast_signed(), by_middle.cast_signed()],
    )?;
    let mut tables = Inserts::of(transaction)?;
    for case in &run.cases {
        let case_id = tables.case_name.id(params![case.name])?;
        tables.result.execute(params![case_id, id, outcome(case), made_from(case, &facts.binary_sha256)])?;
        tables.figures(id, case_id, case)?;
    }
    Ok(())
}

/// A table of names, each once.
struct RowIds<'a> {
    insert: Statement<'a>,
    select: Statement<'a>,
}

impl RowIds<'_> {
    /// The number of a name, which is new or known.
    fn id(&mut self, key: &[&dyn ToSql]) -> rusqlite::Result<i64> {
        self.insert.execute(key)?;
        self.select.query_row(key, |row| row.get(0))
    }
}

/// The tables that the cases of a run go into.
struct Inserts<'a> {
    case_name: RowIds<'a>,
    result: Statement<'a>,
    figure_name: RowIds<'a>,
    figure: Statement<'a>,
}

impl<'a> Inserts<'a> {
    fn of(transaction: &'a Transaction<'_>) -> rusqlite::Result<Inserts<'a>> {
        let sql = |text: &str| transaction.prepare(text);
        Ok(Inserts {
            case_name: RowIds {
                insert: sql("INSERT INTO case_name (name) VALUES (?1) ON CONFLICT DO NOTHING")?,
                select: sql("SELECT id FROM case_name WHERE name = ?1")?,
            },
            result: sql(
                "INSERT INTO case_result (case_id, run, outcome, made_from) VALUES (?1, ?2, ?3, ?4)",
            )?,
            figure_name: RowIds {
                insert: sql("INSERT INTO figure_name (case_id, measured, name, turn, unit)
                     VALUES (?1, ?2, ?3, ?4, ?5) ON CONFLICT DO NOTHING")?,
                select: sql("SELECT id FROM figure_name
                     WHERE case_id = ?1 AND measured = ?2 AND name = ?3 AND turn = ?4 AND unit = ?5")?,
            },
            figure: sql(
                "INSERT INTO figure (figure_id, run, low, high, margin) VALUES (?1, ?2, ?3, ?4, ?5)",
            )?,
        })
    }

    /// Adds everything of a case that has a figure: claims with a margin, measurements.
    fn figures(&mut self, run: i64, case_id: i64, case: &CaseRecord) -> rusqlite::Result<()> {
        let mut turns: BTreeMap<(bool, &str), i64> = BTreeMap::new();
        let claims = case.claims.iter().filter_map(|claim| {
            let margin = claim.margin.as_ref()?;
            Some((false, claim.name.as_str(), margin.unit.as_str(), None, Some(margin.value)))
        });
        let measurements = case.measurements.iter().map(|m| {
            let margin = m.margin.as_ref().map(|margin| margin.value);
            (true, m.name.as_str(), m.unit.as_str(), m.value, margin)
        });
        for (measured, name, unit, value, margin) in claims.chain(measurements) {
            let turn = turns.entry((measured, name)).or_default();
            *turn += 1;
            let figure_id = self.figure_name.id(params![case_id, measured, name, *turn, unit])?;
            let [low, high] = value.map_or([None, None], |[low, high]| [Some(low), Some(high)]);
            self.figure.execute(params![figure_id, run, low, high, margin])?;
        }
        Ok(())
    }
}

/// Leaves the newest `keep` runs, and no names that nobody uses.
fn forget(transaction: &Transaction<'_>, keep: u32) -> rusqlite::Result<()> {
    let gone = transaction.execute(
        "DELETE FROM run WHERE id NOT IN (SELECT id FROM run ORDER BY id DESC LIMIT ?1)",
        [i64::from(keep)],
    )?;
    if gone > 0 {
        transaction.execute_batch(
            "DELETE FROM case_result WHERE run < (SELECT min(id) FROM run);
             DELETE FROM unguarded WHERE run < (SELECT min(id) FROM run);
             DELETE FROM figure WHERE run < (SELECT min(id) FROM run);
             DELETE FROM figure_name WHERE id NOT IN (SELECT figure_id FROM figure);
             DELETE FROM case_name WHERE id NOT IN (SELECT case_id FROM case_result);",
        )?;
    }
    Ok(())
}

/// What a case came to.
fn outcome(case: &CaseRecord) -> &'static str {
    match case.status {
        CaseStatus::Judged => case.verdict.word(),
        CaseStatus::NotApplicable { .. } => "not-applicable",
        CaseStatus::Skipped { .. } => "skipped",
    }
}

/// A digest of all that a case's verdict follows from but the wires: when it stays and the verdict changes, the case
/// is flaky.
fn made_from(case: &CaseRecord, binary: &str) -> String {
    let hashes = &case.hashes;
    let mut text = format!("{} {} {} {} {binary}", hashes.plan, hashes.board, hashes.program, case.seed);
    let instrument = case.instrument.as_ref().map_or("", |instrument| instrument.sha256.as_str());
    if !(hashes.capture.is_empty() && instrument.is_empty()) {
        text.push_str(&format!(" {} {instrument}", hashes.capture));
    }
    runtime::suite::describe::sha256(text.as_bytes())[..16].to_owned()
}

/// Whether a word is that of a pass.
pub(super) fn is_pass(outcome: &str) -> bool {
    outcome == Verdict::Pass.word()
}

fn foreign(path: &Path, why: &str) -> Diagnostic {
    Diagnostic::error("R0168", format!("`{}` is no history of runs: {why}", path.display()))
        .help("name a file that is not there yet, or one that `rig history add` made")
}

/// What SQLite says of a file, as a finding.
fn fault(path: &Path, error: &rusqlite::Error) -> Diagnostic {
    let shown = path.display();
    let (why, help) = match error.sqlite_error_code() {
        Some(ErrorCode::NotADatabase) => return foreign(path, "it is no database"),
        Some(ErrorCode::DatabaseBusy | ErrorCode::DatabaseLocked) => {
            ("another command uses it".to_owned(), "try again when that has ended")
        }
        Some(ErrorCode::DatabaseCorrupt) => {
            ("it is damaged".to_owned(), "restore it, or begin a new history")
        }
        Some(ErrorCode::DiskFull) => ("the disk is full".to_owned(), "make room; nothing was added"),
        Some(ErrorCode::ReadOnly | ErrorCode::PermissionDenied | ErrorCode::CannotOpen) => {
            ("it cannot be opened or written".to_owned(), "correct the path or the rights of its folder")
        }
        _ => (error.to_string(), "begin a new history if this one is damaged"),
    };
    Diagnostic::error("R0169", format!("the history `{shown}` cannot be used: {why}")).help(help)
}
