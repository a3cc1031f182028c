//! The board as the instrument of a case: what its file states of the errors of what it sees, for the record, and in the notes
//! of the trace, so that a judgement of the trace alone says the same.

use crate::suite::case_files::CaseFiles;
use crate::suite::describe::board_hash;
use crate::suite::instrument_file::recorded;
use record::{InstrumentRecord, InstrumentStatement};
use signal::{ClockError, Trace};

/// The note that names the board file. One of a capture that was read by an instrument file is another.
const FILE: &str = "board-instrument";
/// Its title.
const TITLE: &str = "board-instrument-title";
/// Its hash.
const SHA256: &str = "board-instrument-sha256";
/// The notes of the statements, before their numbers.
const STATEMENT: &str = "board-instrument:";

/// The note of what the clock of the board may be off, in parts of 10^12.
const CLOCK_ERROR: &str = "clock-error";

/// The board of a case, where its file states an error.
pub(crate) fn of(files: &CaseFiles) -> Option<InstrumentRecord> {
    let board = &files.board;
    (!board.statements.is_empty()).then(|| InstrumentRecord {
        file: board.name.clone(),
        title: board.title.clone(),
        sha256: board_hash(files),
        statements: board.statements.iter().cloned().map(recorded).collect(),
    })
}

/// Writes it into the notes of a trace.
pub(crate) fn annotate(trace: &mut Trace, board: &InstrumentRecord) {
    trace.set_note(FILE, board.file.clone());
    trace.set_note(TITLE, board.title.clone());
    trace.set_note(SHA256, board.sha256.clone());
    for (place, InstrumentStatement { of, key, value }) in board.statements.iter().enumerate() {
        trace.set_note(&format!("{STATEMENT}{place:05}"), format!("{of}\t{key}\t{value}"));
    }
}

/// Writes into a trace what the clock that stamps it may be off.
pub(crate) fn annotate_clock(trace: &mut Trace, error: ClockError) {
    if !error.is_none() {
        trace.set_note(CLOCK_ERROR, error.parts().to_string());
    }
}

/// What the clock that stamped a trace may be off, by its notes.
pub fn clock_error(trace: &Trace) -> ClockError {
    let parts = trace.note(CLOCK_ERROR).and_then(|parts| parts.parse().ok());
    parts.and_then(ClockError::from_parts).unwrap_or_default()
}

/// The same out of the notes of a trace.
pub(crate) fn read_from(trace: &Trace) -> Option<InstrumentRecord> {
    let note = |key: &str| trace.note(key).unwrap_or_default().to_owned();
    let statement = |(key, text): (&str, &str)| {
        key.strip_prefix(STATEMENT)?;
        let mut parts = text.splitn(3, '\t').map(str::to_owned);
        Some(InstrumentStatement { of: parts.next()?, key: parts.next()?, value: parts.next()? })
    };
    trace.note(FILE).map(|file| InstrumentRecord {
        file: file.to_owned(),
        title: note(TITLE),
        sha256: note(SHA256),
        statements: trace.notes().filter_map(statement).collect(),
    })
}
