//! Tables of values over time, as recorders and spreadsheets write them: CSV with a header.
//!
//! ```text
//! time [ms],level [V],door
//! 0,0,FALSE
//! 12.5,3.3,TRUE
//! 20,,Z
//! ```
//! Fields are parted by commas, semicolons or tabs: whichever the header has. After semicolons a number may have a
//! decimal comma. An empty field leaves what it stands for as it is. Lines that are empty or begin with `#` do not count.

use document::{Data, Diagnostic, Node, SourceFile};
use signal::{Decimal, Quantity, Span, Unit};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use crate::codes;

/// Most fields of a table.
const MOST_CELLS: usize = 1_000_000;
/// Most columns, that of the time aside.
const MOST_COLUMNS: usize = 64;
/// Findings in one table: further ones say the same.
const MOST_FINDINGS: usize = 10;
/// Most tables of a plan.
const MOST_TABLES: usize = 64;
/// What the path of a table ends with.
const ENDING: &str = ".csv";

/// A value of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cell {
    /// Whatever it was before.
    Kept,
    /// TRUE or FALSE.
    Level(bool),
    /// A number in the unit of its column.
    Number(Decimal),
    /// Nobody drives it.
    HighZ,
}

/// A column of a table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TableColumn {
    /// Its name in the header.
    pub name: String,
    /// Its unit there; [`Unit::NONE`] for plain numbers and levels.
    pub unit: Unit,
}

/// Values over time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ValueTable {
    /// Its file, as the user knows it.
    pub path: String,
    /// Its columns, that of the time aside.
    pub columns: Vec<TableColumn>,
    /// When each row comes after the beginning: at least one, from 0 up, each later than the one before.
    pub times: Vec<Span>,
    /// The line of each row, from 1.
    pub lines: Vec<u32>,
    /// Row by row, a cell for each column.
    cells: Vec<Cell>,
}

impl ValueTable {
    /// The cell of a row and column that the table has.
    pub fn cell(&self, row: usize, column: usize) -> Cell {
        self.cells.get(row * self.columns.len() + column).copied().unwrap_or(Cell::Kept)
    }

    /// From the beginning to the last row.
    pub fn length(&self) -> Span {
        self.times.last().copied().unwrap_or(Span::ZERO)
    }
}

/// The tables that a plan may name, each with what is wrong with it if it does not read.
#[derive(Clone, Debug, Default)]
pub struct ValueTables(BTreeMap<String, Result<Arc<ValueTable>, TableFault>>);

/// Why there is no table.
#[derive(Clone, Debug)]
pub(crate) enum TableFault {
    /// The file cannot be read.
    Unread(String),
    /// What is wrong in it.
    Wrong(Vec<Diagnostic>),
}

/// For where nothing names a table.
pub(crate) static NONE: ValueTables = ValueTables(BTreeMap::new());

impl ValueTables {
    /// Opens every table that a plan with these tables of TOML may name: all texts that end in `.csv`, wherever they
    /// stand, for a name may come out of a row or an argument. `open` gives the file of a name as it is written.
    pub fn gather<'t>(
        roots: impl Iterator<Item = &'t document::Table>,
        open: &mut dyn FnMut(&str) -> Result<SourceFile, String>,
    ) -> ValueTables {
        let mut names = Vec::new();
        let mut used = false;
        for root in roots {
            root.entries.iter().for_each(|entry| find(&entry.key, &entry.node, &mut used, &mut names));
        }
        let mut tables = ValueTables::default();
        for name in names.iter().filter(|_| used) {
            if tables.0.len() < MOST_TABLES && !tables.0.contains_key(name) {
                let table = open(name).map_err(TableFault::Unread);
                let table = table.and_then(|file| read(&file).map(Arc::new).map_err(TableFault::Wrong));
                tables.0.insert(name.clone(), table);
            }
        }
        tables
    }

    /// The table of this name.
    pub(crate) fn get(&self, name: &str) -> Result<Arc<ValueTable>, TableFault> {
        let unread =
            || Err(TableFault::Unread(format!("no file of a plan that ends in `{ENDING}` has this name")));
        self.0.get(name).cloned().unwrap_or_else(unread)
    }
}

/// The texts that may name a table, and whether anything uses one.
fn find(key: &str, node: &Node, used: &mut bool, names: &mut Vec<String>) {
    *used |= key == "sequence";
    match &node.data {
        Data::Text(text) if text.to_ascii_lowercase().ends_with(ENDING) => names.push(text.clone()),
        Data::Array(list) => list.iter().for_each(|node| find("", node, used, names)),
        Data::Table(table) => {
            table.entries.iter().for_each(|entry| find(&entry.key, &entry.node, used, names));
        }
        _ => {}
    }
}

/// Reads a table.
///
/// # Errors
/// What is wrong with it, with its places.
pub fn read(file: &SourceFile) -> Result<ValueTable, Vec<Diagnostic>> {
    let mut reader = CsvReader { file, separator: ',', found: Vec::new() };
    let table = reader.table();
    match table {
        Some(table) if reader.found.is_empty() => Ok(table),
        _ => Err(reader.found),
    }
}

struct CsvReader<'f> {
    file: &'f SourceFile,
    separator: char,
    found: Vec<Diagnostic>,
}

/// A field with its place in the file.
struct CsvField<'f> {
    text: &'f str,
    span: Range<usize>,
}

impl<'f> CsvReader<'f> {
    fn bad(&mut self, code: &'static str, span: Range<usize>, message: impl Into<String>, help: &str) {
        if self.found.len() < MOST_FINDINGS {
            self.found.push(Diagnostic::error(code, message).at(&self.file.name, span, "").help(help));
        }
    }

    fn table(&mut self) -> Option<ValueTable> {
        let text: &'f str = &self.file.text;
        let mut at = if text.starts_with('\u{feff}') { '\u{feff}'.len_utf8() } else { 0 };
        let mut lines = Vec::new();
        for (number, line) in (1u32..).zip(text[at..].split('\n')) {
            let content = line.trim_end_matches('\r');
            if !content.trim().is_empty() && !content.starts_with('#') {
                lines.push((number, at, content));
            }
            at += line.len() + 1;
        }
        let Some((_, at, header)) = lines.first() else {
            let help = "begin with a header such as: time [ms],level [V]";
            self.bad(codes::TABLE, 0..0, "the table is empty", help);
            return None;
        };
        self.separator = [';', '\t'].into_iter().find(|one| header.contains(*one)).unwrap_or(',');
        let (unit, columns) = self.header(*at, header)?;
        let mut table = ValueTable {
            path: self.file.name.clone(),
            columns,
            times: Vec::new(),
            lines: Vec::new(),
            cells: Vec::new(),
        };
        for (number, at, line) in &lines[1..] {
            if self.found.len() >= MOST_FINDINGS {
                break;
            }
            if table.cells.len() + table.columns.len() > MOST_CELLS {
                let message = format!("the table has more than {MOST_CELLS} fields");
                self.bad(codes::TABLE, *at..at + line.len(), message, "take fewer rows or columns");
                break;
            }
            self.row(*at, line, &unit, &mut table);
            table.lines.push(*number);
        }
        if table.times.is_empty() && self.found.is_empty() {
            let help = "write a row for each instant, as in: 12.5,3.3";
            self.bad(codes::TABLE, *at..at + header.len(), "the table has no rows", help);
        }
        Some(table)
    }

    /// The unit of the time, and the columns.
    fn header(&mut self, at: usize, line: &'f str) -> Option<(Unit, Vec<TableColumn>)> {
        let mut fields = self.fields(at, line).into_iter().map(|field| (named(field.text), field));
        let (time, place) = fields.next()?;
        let unit = time.unit;
        if (Quantity { number: Decimal::from(1), unit: unit.clone() }).as_span().is_none() {
            let help = "the first column is the time, with its unit, as in: time [ms]";
            self.bad(codes::TABLE, place.span, "the first column has no unit of time", help);
            return None;
        }
        let mut columns: Vec<TableColumn> = Vec::new();
        for (column, field) in fields {
            if column.name.is_empty() || columns.iter().any(|known| known.name == column.name) {
                let help = "name each column once, by its signal, as in: level [V]";
                self.bad(codes::TABLE, field.span, "a column without a name of its own", help);
                return None;
            }
            columns.push(column);
        }
        if columns.is_empty() || columns.len() > MOST_COLUMNS {
            let message = format!("a table has 1 to {MOST_COLUMNS} columns beside the time");
            self.bad(codes::TABLE, at..at + line.len(), message, "as in: time [ms],level [V]");
            return None;
        }
        Some((unit, columns))
    }

    fn row(&mut self, at: usize, line: &'f str, unit: &Unit, table: &mut ValueTable) {
        let fields = self.fields(at, line);
        if fields.len() != table.columns.len() + 1 {
            let message = format!("{} fields, and {} columns", fields.len(), table.columns.len() + 1);
            let help = "every row has a field for each column; leave one empty where nothing changes";
            self.bad(codes::TABLE, at..at + line.len(), message, help);
            return;
        }
        let time = self.number(fields[0].text);
        let time = time.and_then(|number| Quantity { number, unit: unit.clone() }.as_span());
        let last = table.times.last().copied();
        match time.filter(|time| !time.is_negative()) {
            None => {
                let help = "a number from 0 up, in the unit of the column, to the nanosecond";
                self.bad(codes::TABLE, fields[0].span.clone(), "no time", help);
            }
            Some(time) if last.is_some_and(|last| time <= last) => {
                let message = "the time does not grow from row to row";
                self.bad(
                    codes::TABLE,
                    fields[0].span.clone(),
                    message,
                    "put the rows in order, each instant once",
                );
            }
            Some(time) => table.times.push(time),
        }
        for field in &fields[1..] {
            let cell = match field.text {
                "" => Some(Cell::Kept),
                word if word.eq_ignore_ascii_case("true") => Some(Cell::Level(true)),
                word if word.eq_ignore_ascii_case("false") => Some(Cell::Level(false)),
                "Z" | "z" => Some(Cell::HighZ),
                number => self.number(number).map(Cell::Number),
            };
            if cell.is_none() {
                let message = format!("`{}` is no value", field.text.chars().take(40).collect::<String>());
                let help = "a number, TRUE, FALSE, Z, or nothing where it stays as it is";
                self.bad(codes::TABLE, field.span.clone(), message, help);
            }
            table.cells.push(cell.unwrap_or(Cell::Kept));
        }
    }

    /// The fields of a line that begins at a byte.
    fn fields(&self, at: usize, line: &'f str) -> Vec<CsvField<'f>> {
        let mut from = at;
        let field = |part: &'f str| {
            let before = part.len() - part.trim_start().len();
            let text = part.trim();
            let plain = text.strip_prefix('"').and_then(|text| text.strip_suffix('"')).unwrap_or(text);
            let field = CsvField { text: plain.trim(), span: from + before..from + before + text.len() };
            from += part.len() + self.separator.len_utf8();
            field
        };
        line.split(self.separator).map(field).collect()
    }

    fn number(&self, text: &str) -> Option<Decimal> {
        let text = match self.separator {
            ';' => Cow::Owned(text.replace(',', ".")),
            _ => Cow::Borrowed(text),
        };
        Decimal::split(&text).ok().filter(|(_, rest)| rest.is_empty()).map(|(number, _)| number)
    }
}

/// A name with the unit after it: `level [V]`, `level (V)`.
fn named(text: &str) -> TableColumn {
    for (open, close) in [('[', ']'), ('(', ')')] {
        if let Some((name, unit)) = text.strip_suffix(close).and_then(|text| text.rsplit_once(open)) {
            return TableColumn { name: name.trim().to_owned(), unit: Unit::new(unit) };
        }
    }
    TableColumn { name: text.to_owned(), unit: Unit::NONE }
}

#[cfg(test)]
mod tests {
    use super::*;
    use document::line_col;
    use proptest::prelude::*;

    fn table(text: &str) -> Result<ValueTable, Vec<Diagnostic>> {
        read(&SourceFile::new("drive.csv", text))
    }

    #[test]
    fn a_table_reads() {
        let read =
            table("time [ms],level [V],door\n# by hand\n0,0.5,FALSE\n\n12.5,,TRUE\r\n20,-3,Z\n").unwrap();
        assert_eq!(read.times, [0, 12_500, 20_000].map(Span::from_micros));
        assert_eq!(read.lines, [3, 5, 6]);
        assert_eq!((read.columns[0].name.as_str(), &read.columns[0].unit), ("level", &Unit::new("V")));
        assert_eq!(read.cell(0, 0), Cell::Number(Decimal::new(5, -1)));
        assert_eq!((read.cell(1, 0), read.cell(1, 1)), (Cell::Kept, Cell::Level(true)));
        assert_eq!(read.cell(2, 1), Cell::HighZ);
    }

    #[test]
    fn what_a_spreadsheet_writes_reads_the_same() {
        let plain = table("t [s],level [V]\n0,0.5\n1.5,2\n").unwrap();
        let european = table("\u{feff}\"t (s)\";\"level (V)\"\r\n0;0,5\r\n1,5;2,0\r\n").unwrap();
        let tabbed = table("t [s]\tlevel [V]\n0\t0.5\n1.5\t2").unwrap();
        assert_eq!((&plain.times, &plain.cells), (&european.times, &european.cells));
        assert_eq!((&plain.times, &plain.cells), (&tabbed.times, &tabbed.cells));
    }

    #[test]
    fn what_is_wrong_has_its_place() {
        let places = |text: &str| -> Vec<(usize, usize)> {
            let found = table(text).unwrap_err();
            assert!(found.iter().all(|one| one.code == codes::TABLE));
            found.iter().map(|one| line_col(text, one.labels[0].span.start)).collect()
        };
        assert_eq!(places(""), [(1, 1)]);
        assert_eq!(places("time,level\n0,1\n"), [(1, 1)]);
        assert_eq!(places("time [V],level\n0,1\n"), [(1, 1)]);
        assert_eq!(places("time [ms]\n0\n"), [(1, 1)]);
        assert_eq!(places("time [ms],a,a\n0,1,2\n"), [(1, 13)]);
        assert_eq!(places("time [ms],a\n"), [(1, 1)]);
        assert_eq!(
            places("time [ms],a\n0,1,2\n1,x\n-1,2\n5,1\n5,2\n0.0000001,1\n"),
            [(2, 1), (3, 3), (4, 1), (6, 1), (7, 1)]
        );
    }

    proptest! {
        #[test]
        fn no_text_panics(text in "\\PC*", near in "(time \\[ms\\]|,|;|\n|\"|[0-9.]{1,5}|TRUE|Z|#|é){0,20}") {
            let _ = (table(&text), table(&near));
            let _ = table(&format!("time [ms],a\n{near}"));
        }
    }
}
