//! Tables of values over time: which row comes when, and what lies between two of them.

use super::Band;
use drivers::ChannelId;
use plans::steps::Sequence;
use signal::{Decimal, Span, Value};

/// A value that a row gives a channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TableValue {
    /// As the channel takes it.
    pub value: Value,
    /// The number, where it is one: numbers may go evenly from row to row.
    pub number: Option<Decimal>,
}

/// A value of a channel at an instant of the table.
#[derive(Clone, Copy, Debug)]
struct SequencePoint {
    /// When it comes, in nanoseconds.
    at: i64,
    /// What it is.
    value: Value,
    /// From here to the next one, where numbers go evenly.
    to_next: Option<Band>,
}

/// A table with its values in the units of its channels.
#[derive(Clone, Debug)]
pub struct Rows {
    /// When each row comes, in nanoseconds.
    times: Vec<i64>,
    /// How many acts come before each row, and after them how many there are.
    before: Vec<u64>,
    /// Each channel with its points.
    columns: Vec<(ChannelId, Vec<SequencePoint>)>,
    passes: u64,
    sample: i64,
}

impl Rows {
    /// The rows of a sequence. `columns` has each channel with what every row gives it, if anything.
    pub fn new(sequence: &Sequence, columns: Vec<(ChannelId, Vec<Option<TableValue>>)>) -> Rows {
        let times: Vec<i64> = sequence.table.times.iter().map(|time| time.as_nanos()).collect();
        let mut before = vec![0];
        for row in 0..times.len() {
            before.push(before[row] + sequence.instants(row));
        }
        let points = |values: Vec<Option<TableValue>>| -> Vec<SequencePoint> {
            let given = times.iter().zip(values);
            let given: Vec<(i64, TableValue)> = given.filter_map(|(at, value)| Some((*at, value?))).collect();
            let point = |place: usize| {
                let (at, TableValue { value, number }) = given[place];
                let next = given.get(place + 1).and_then(|(_, next)| next.number);
                let even = number.zip(next).filter(|_| sequence.sample.is_some());
                SequencePoint { at, value, to_next: even.map(|(from, to)| Band::new(from, to)) }
            };
            (0..given.len()).map(point).collect()
        };
        let columns = columns.into_iter().map(|(channel, values)| (channel, points(values))).collect();
        let sample = sequence.sample.map_or(1, Span::as_nanos);
        Rows { times, before, columns, passes: u64::from(sequence.times), sample }
    }

    /// The channels that it drives.
    pub fn channels(&self) -> impl Iterator<Item = ChannelId> {
        self.columns.iter().map(|(channel, _)| *channel)
    }

    /// How many times the table was gone through before act `n`, and when in the table it comes; `None` after the
    /// last.
    fn place(&self, n: u64) -> Option<(i64, i64)> {
        let all = self.before.last().copied().filter(|all| *all > 0)?;
        let (pass, within) = (n / all, n % all);
        let row = self.before.partition_point(|before| *before <= within).checked_sub(1)?;
        let at = self.times.get(row)? + i64::try_from(within - self.before[row]).ok()? * self.sample;
        Some((i64::try_from(pass).ok().filter(|_| pass < self.passes)?, at))
    }

    /// How long after the beginning act `n` from 0 comes; `None` after the last.
    pub fn after(&self, n: u64) -> Option<Span> {
        let (pass, at) = self.place(n)?;
        Some(Span::from_nanos(pass * self.times.last()? + at))
    }

    /// What act `n` writes.
    pub fn writes(&self, n: u64, out: &mut Vec<(ChannelId, Value)>) {
        let Some((_, at)) = self.place(n) else { return };
        for (channel, points) in &self.columns {
            let place = points.partition_point(|point| point.at <= at).checked_sub(1);
            let Some((point, next)) = place.map(|place| (&points[place], points.get(place + 1))) else {
                continue;
            };
            match (point.to_next, next) {
                _ if point.at == at => out.push((*channel, point.value)),
                (Some(band), Some(next)) => {
                    let part = |span: i64| u128::from(span.unsigned_abs());
                    out.push((*channel, Value::Real(band.at(part(at - point.at), part(next.at - point.at)))));
                }
                _ => {}
            }
        }
    }
}
