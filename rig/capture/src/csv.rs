//! Tables: a column of instants, and a column for each channel.
//!
//! The header names the unit of the first column: `time [ms]`, `t (us)`, `Time/s`, `microseconds`. Rows at even
//! distances are samples. Between uneven rows a change lies anywhere, unless the user says the time between samples.

use crate::builder::{CaptureBuilder, FEWER, too_many_changes, too_many_channels};
use crate::time::nanos;
use crate::{Capture, CaptureError, ChannelType, Knowledge};
use signal::{Decimal, Span, Time, Value, When};

/// The separators that a header is tried with.
const SEPARATORS: [char; 3] = ['\t', ';', ','];

/// Reads a table.
///
/// # Errors
/// [`CaptureError`] with the line.
pub fn read(bytes: &[u8], period: Option<Span>) -> Result<Capture, CaptureError> {
    let text = std::str::from_utf8(bytes).map_err(|error| {
        let line = bytes[..error.valid_up_to()].iter().filter(|byte| **byte == b'\n').count() as u64 + 1;
        CaptureError::line(line, "no UTF-8 text", "write the table as UTF-8")
    })?;
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut named = None;
    let mut lines = (1..).zip(text.lines()).filter(|(_, line)| {
        let comment = line.starts_with(';') || line.starts_with('#');
        if comment {
            named = channels_of_comment(line).or(named.take());
        }
        !comment && !line.trim().is_empty()
    });
    let Some((at, header)) = lines.next() else {
        return Err(CaptureError::whole(
            "the table has no header",
            "begin with a line such as `time [s],lamp`",
        ));
    };
    let mut table = CsvTable::new(at, header)?;
    let rows: Vec<(u64, &str)> = lines.collect();
    if let Some(names) = named
        && names.len() == table.names.len()
    {
        table.names = names.into_iter().map(|name| (name, String::new())).collect();
    }
    table.read(&rows, period)
}

/// The names in sigrok's comment: `; Channels (3/8): D0, D1, D2`.
fn channels_of_comment(line: &str) -> Option<Vec<String>> {
    let rest = line.trim_start_matches([';', '#', ' ']).strip_prefix("Channels (")?;
    let (_, names) = rest.split_once("): ")?;
    Some(names.split(',').map(|name| name.trim().to_owned()).collect())
}

/// A column's name and the unit after it: `level [V]`.
fn name_and_unit(column: &str) -> (String, String) {
    let column = column.trim().trim_matches('"').trim();
    for (open, close) in [('[', ']'), ('(', ')')] {
        if let Some((name, unit)) = column.strip_suffix(close).and_then(|rest| rest.rsplit_once(open))
            && !name.trim().is_empty()
        {
            return (name.trim().to_owned(), unit.trim().to_owned());
        }
    }
    (column.to_owned(), String::new())
}

/// The power of ten of the unit of the column of instants.
fn power(column: &str) -> Option<i32> {
    let (name, unit) = name_and_unit(column);
    let behind = name.rsplit(['/', '_', ' ']).next().unwrap_or_default().to_owned();
    let word = if unit.is_empty() { behind } else { unit };
    match word.as_str() {
        "s" | "sec" | "S" | "seconds" | "Seconds" => Some(0),
        "ms" | "milliseconds" => Some(-3),
        "us" | "µs" | "μs" | "microseconds" => Some(-6),
        "ns" | "nanoseconds" => Some(-9),
        "ps" | "picoseconds" => Some(-12),
        _ => None,
    }
}

struct CsvTable {
    separator: char,
    power: i32,
    /// Name and unit of each column after the first.
    names: Vec<(String, String)>,
}

impl CsvTable {
    fn new(at: u64, header: &str) -> Result<CsvTable, CaptureError> {
        let separator = SEPARATORS.into_iter().find(|separator| header.contains(*separator));
        let Some(separator) = separator else {
            let fix = "the first column is the time, each further one a channel, with commas between";
            return Err(CaptureError::line(at, "the header has one column only", fix));
        };
        let mut columns = header.split(separator);
        let first = columns.next().unwrap_or_default();
        let Some(power) = power(first) else {
            let what = format!("the first column, `{}`, names no unit of time", first.trim());
            return Err(CaptureError::line(at, what, "write `time [s]`, with s, ms, us, ns or ps"));
        };
        Ok(CsvTable { separator, power, names: columns.map(name_and_unit).collect() })
    }

    fn read(&self, rows: &[(u64, &str)], period: Option<Span>) -> Result<Capture, CaptureError> {
        let mut builder = CaptureBuilder::default();
        for (name, unit) in &self.names {
            let added = builder.channel(name, unit, ChannelType::Bit);
            added.ok_or_else(|| CaptureError::whole(too_many_channels(), "leave columns out"))?;
        }
        let mut before: Option<(i64, i64)> = None;
        let mut first = None;
        let (mut steps, mut written) = (Steps::default(), 0);
        for (at, row) in rows {
            let mut cells = row.split(self.separator);
            let stamp = self.plain(cells.next().unwrap_or_default());
            let now = self.instant(*at, &stamp)?;
            written = written.max(decimals(&stamp));
            if before.is_some_and(|before| now.0 < before.0) {
                return Err(CaptureError::line(*at, "time runs backwards", "put the rows in order of time"));
            }
            steps.step(before, now);
            first.get_or_insert(now.0);
            for (column, cell) in (0u32..).zip(cells) {
                if column as usize >= self.names.len() {
                    let what = format!("more than the {} columns of the header", self.names.len() + 1);
                    return Err(CaptureError::line(*at, what, "give each column a name"));
                }
                self.cell(&mut builder, column, cell, (before, now), (*at, period))?;
            }
            before = Some(now);
        }
        let (Some(first), Some(last)) = (first, before) else {
            return Err(CaptureError::whole("the table has no rows", "a capture has one row at least"));
        };
        shape(&mut builder);
        let CaptureBuilder { channels, mut changes, .. } = builder;
        if steps.none {
            // Two rows of one instant say that instants are rounded to what is written of them.
            let unit = unit_of(self.power, written);
            for change in changes.iter_mut().filter(|change| change.at.latest.as_nanos() > first) {
                let earliest = change.at.earliest.saturating_add(-unit);
                change.at = When::within(
                    earliest.max(Time::from_nanos(first)),
                    change.at.latest.saturating_add(unit),
                );
            }
        }
        let knowledge = Knowledge::Sampled(period.unwrap_or(Span::from_nanos(steps.widest)));
        let span = [Time::from_nanos(first), Time::from_nanos(last.1)];
        Ok(Capture { channels, changes, knowledge, span, end: When::exactly(span[1]), notes: Vec::new() })
    }

    fn instant(&self, at: u64, cell: &str) -> Result<(i64, i64), CaptureError> {
        let found = match Decimal::split(cell) {
            Ok((number, "")) => nanos(number, self.power),
            _ => None,
        };
        found.ok_or_else(|| {
            CaptureError::line(at, format!("`{cell}` is no time"), "write a number of the header's unit")
        })
    }

    /// A cell without blanks and quotes, and with a point where it has a decimal comma.
    fn plain(&self, cell: &str) -> String {
        let cell = cell.trim().trim_matches('"').trim();
        if self.separator == ',' { cell.to_owned() } else { cell.replace(',', ".") }
    }

    fn cell(
        &self,
        builder: &mut CaptureBuilder,
        column: u32,
        cell: &str,
        (before, now): (Option<(i64, i64)>, (i64, i64)),
        (at, period): (u64, Option<Span>),
    ) -> Result<(), CaptureError> {
        let cell = self.plain(cell);
        // Nothing new of this channel.
        if cell.is_empty() {
            return Ok(());
        }
        let Some(value) = value(&cell) else {
            let fix = "write a number, TRUE, FALSE, z or x";
            return Err(CaptureError::line(at, format!("`{cell}` is no value"), fix));
        };
        let since = match (period, before) {
            _ if !builder.is_known(column) => now.0,
            (Some(period), _) => now.0.saturating_sub(period.as_nanos()),
            (None, Some(before)) => before.0,
            (None, None) => now.0,
        };
        let when = When::within(Time::from_nanos(since), Time::from_nanos(now.1));
        if builder.change(column, when, value) {
            return Ok(());
        }
        Err(CaptureError::line(at, too_many_changes(), FEWER))
    }
}

/// The distances of the rows.
#[derive(Default)]
struct Steps {
    widest: i64,
    /// Two rows have one instant.
    none: bool,
}

impl Steps {
    fn step(&mut self, before: Option<(i64, i64)>, now: (i64, i64)) {
        if let Some(before) = before {
            self.widest = self.widest.max(now.1.saturating_sub(before.0));
            self.none |= now == before;
        }
    }
}

/// How many digits a number has after its point.
fn decimals(number: &str) -> u32 {
    let digits = number.split_once('.').map_or("", |(_, digits)| digits);
    digits.chars().take_while(char::is_ascii_digit).count() as u32
}

/// One unit of the last of so many decimals, where whole ones are `10^power` seconds.
fn unit_of(power: i32, decimals: u32) -> Span {
    let digits = power + 9 - i32::try_from(decimals).unwrap_or(i32::MAX).min(100);
    Span::from_nanos(u32::try_from(digits).map_or(1, |digits| 10_i64.saturating_pow(digits)))
}

fn value(cell: &str) -> Option<Value> {
    match cell.to_ascii_lowercase().as_str() {
        "true" | "high" => return Some(Value::Bool(true)),
        "false" | "low" => return Some(Value::Bool(false)),
        "z" => return Some(Value::HighZ),
        "x" | "nan" | "inf" | "-inf" => return Some(Value::Unknown),
        _ => {}
    }
    let (number, rest) = Decimal::split(cell).ok()?;
    if !rest.is_empty() {
        return None;
    }
    // `1.0` is a real number that happens to be whole: what the column is, its other cells say.
    let whole = number.as_whole().filter(|_| !cell.contains('.'));
    let signed = whole.and_then(|whole| i64::try_from(whole).ok()).map(Value::Int);
    let unsigned = || whole.and_then(|whole| u64::try_from(whole).ok()).map(Value::Word);
    Some(signed.or_else(unsigned).unwrap_or_else(|| Value::Real(number.as_f64())))
}

/// Gives every column the shape that all its values have, and its values that shape.
fn shape(builder: &mut CaptureBuilder) {
    for change in &builder.changes {
        let shape = match change.value {
            Value::Real(_) => ChannelType::Real,
            Value::Int(n) if n != 0 && n != 1 => ChannelType::Whole,
            Value::Word(_) => ChannelType::Whole,
            _ => ChannelType::Bit,
        };
        let known = &mut builder.channels[change.channel as usize].shape;
        if *known == ChannelType::Bit || shape == ChannelType::Real {
            *known = shape;
        }
    }
    for change in &mut builder.changes {
        change.value = match (builder.channels[change.channel as usize].shape, change.value) {
            (ChannelType::Bit, Value::Int(n)) => Value::Bool(n == 1),
            (ChannelType::Real, value) => value.as_real().map_or(value, Value::Real),
            (_, value) => value,
        };
    }
}
