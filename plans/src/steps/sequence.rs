//! `sequence`: values over time out of a table.

use std::sync::Arc;

use document::{Data, Findings, KeySpec, KeyType, Node};
use signal::Span;

use super::drive::above_zero;
use super::{MAX_PULSES, StepVerb, Stimulus};
use super::{StepNames, table_fields};
use crate::codes;
use crate::table::{Cell, TableFault, ValueTable};

const KEYS: &[KeySpec] = &[
    KeySpec::required(
        "file",
        KeyType::Text,
        "The table, a CSV file relative to the plan, as in \"drive.csv\".",
    ),
    KeySpec::optional(
        "columns",
        KeyType::Map(&KeyType::SignalRef),
        "The columns that are used, and the signals that they drive; all, by their names, if left out.",
    ),
    KeySpec::optional(
        "times",
        KeyType::Integer(1, MAX_PULSES as i64),
        "How many times it comes; 1 if left out.",
    ),
    KeySpec::optional(
        "interpolate",
        KeyType::Bool,
        "Numbers go evenly from row to row; FALSE if left out: each stays until the next one.",
    ),
    KeySpec::optional(
        "sample",
        KeyType::Duration,
        "Time from one value to the next where numbers go evenly; 1 ms if left out.",
    ),
];

pub(super) const SEQUENCE: StepVerb = StepVerb {
    name: "sequence",
    doc: "Drives lines and channels with the values of a table.",
    value: KeyType::Table(KEYS),
    needs: &[],
    read,
};

/// Values over time out of a table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sequence {
    /// The table.
    pub table: Arc<ValueTable>,
    /// Places of columns, and the signals that they drive.
    pub columns: Vec<(usize, String)>,
    /// How many times it comes, from 1.
    pub times: u32,
    /// From one value to the next where numbers go evenly from row to row, above 0; `None`: they do not.
    pub sample: Option<Span>,
}

impl Sequence {
    /// From the step to its last row.
    pub fn length(&self) -> Span {
        Span::from_nanos(self.table.length().as_nanos().saturating_mul(i64::from(self.times)))
    }

    /// How many instants lie between this row and the next one, that of the row included.
    pub fn instants(&self, row: usize) -> u64 {
        let distance = self.table.times.get(row + 1).map(|next| (*next - self.table.times[row]).as_nanos());
        match (self.sample, distance) {
            (Some(sample), Some(distance)) => {
                distance.unsigned_abs().div_ceil(sample.as_nanos().unsigned_abs())
            }
            _ => 1,
        }
    }
}

fn read(node: &Node, scope: &dyn StepNames, out: &mut Findings) -> Option<Stimulus> {
    let fields = table_fields(node, KEYS)?;
    let place = fields.get("file")?;
    let name = place.as_text()?;
    let table = match scope.table(name) {
        Ok(table) => table,
        Err(TableFault::Unread(why)) => {
            let message = format!("`{name}` cannot be read: {why}");
            out.bad(codes::TABLE_FILE, place, message, "name a file beside the plan, as in \"drive.csv\"");
            return None;
        }
        Err(TableFault::Wrong(found)) => {
            found.into_iter().for_each(|one| out.push(one));
            return None;
        }
    };
    let columns = columns(&fields, place, &table, scope, out)?;
    let times = fields.integer("times").map_or(1, |times| u32::try_from(times).unwrap_or(MAX_PULSES));
    let even = fields.boolean("interpolate").unwrap_or(false);
    if let (false, Some(sample)) = (even, fields.get("sample")) {
        let help = "add interpolate = true, or remove `sample`";
        out.bad(codes::STIMULUS, sample, "`sample` has no meaning without `interpolate`", help);
        return None;
    }
    let sample = match (even, fields.has("sample")) {
        (false, _) => None,
        (true, false) => Some(Span::from_millis(1)),
        (true, true) => Some(above_zero(&fields, "sample", out)?),
    };
    let sequence = Sequence { table, columns, times, sample };
    if times > 1 && sequence.table.length() == Span::ZERO {
        let message = "a table of one instant cannot come several times";
        out.bad(codes::STIMULUS, fields.get("times")?, message, "add a row for where it ends");
        return None;
    }
    let rows = 0..sequence.table.times.len();
    let instants = rows.map(|row| sequence.instants(row)).fold(0, u64::saturating_add);
    if instants.saturating_mul(u64::from(times)) > u64::from(MAX_PULSES) || sequence.length() == Span::MAX {
        let message = format!("the sequence has more than {MAX_PULSES} instants, or lasts too long");
        out.bad(codes::SAMPLES, place, message, "lengthen `sample`, or lower `times`");
        return None;
    }
    Some(Stimulus::Sequence(sequence))
}

/// The columns that are used and what they drive.
fn columns(
    fields: &document::Fields<'_>,
    file: &Node,
    table: &ValueTable,
    scope: &dyn StepNames,
    out: &mut Findings,
) -> Option<Vec<(usize, String)>> {
    let mut columns: Vec<(usize, String)> = Vec::new();
    match fields.get("columns").and_then(Node::as_table) {
        None => {
            for (place, column) in table.columns.iter().enumerate() {
                // The name at the place of the file, for what is wrong with it.
                let mut name = Node::new(file.span.clone(), Data::Text(column.name.clone()));
                name.origin = file.origin.clone();
                columns.push((place, scope.signal(&name, out)?));
            }
        }
        Some(given) => {
            for entry in &given.entries {
                let Some(place) = table.columns.iter().position(|column| column.name == entry.key) else {
                    let names = table.columns.iter().map(|column| column.name.as_str());
                    let help = match document::suggest(&entry.key, names.clone()) {
                        Some(meant) => format!("did you mean `{meant}`?"),
                        None => format!("it has {}", names.collect::<Vec<_>>().join(", ")),
                    };
                    let message = format!("{} has no column `{}`", table.path, entry.key);
                    out.error(codes::COLUMN, entry.key_span.clone(), message, help);
                    return None;
                };
                columns.push((place, scope.signal(&entry.node, out)?));
            }
        }
    }
    let twice = (1..columns.len()).find(|at| columns[..*at].iter().any(|(_, name)| *name == columns[*at].1));
    if let Some(at) = twice {
        let message = format!("two columns drive `{}`", columns[at].1);
        out.bad(codes::COLUMN, fields.get("columns").unwrap_or(file), message, "leave one of them out");
        return None;
    }
    let empty = columns
        .iter()
        .find(|(column, _)| (0..table.times.len()).all(|row| table.cell(row, *column) == Cell::Kept));
    if let Some((column, _)) = empty {
        let message = format!("column `{}` of {} has no value", table.columns[*column].name, table.path);
        out.bad(codes::COLUMN, fields.get("columns").unwrap_or(file), message, "leave it out of `columns`");
        return None;
    }
    if columns.is_empty() {
        let help = "as in columns = { level = \"level\" }";
        out.bad(codes::COLUMN, fields.get("columns").unwrap_or(file), "no column is used", help);
        return None;
    }
    Some(columns)
}
