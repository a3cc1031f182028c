//! What is measured of a line between two instants.

use super::store::TrendLine;
use control::Value;

/// Figures of a line between two instants. Where nothing was known, nothing is counted.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TrendFigures {
    /// The least and the greatest number.
    pub range: Option<(f64, f64)>,
    /// The mean over the time in which it was known.
    pub mean: Option<f64>,
    /// Changes from 0 or FALSE to another value, and back.
    pub rises: u64,
    /// See `rises`.
    pub falls: u64,
}

impl TrendFigures {
    /// Measures a line from an instant to a later one.
    pub fn of(line: &TrendLine, from: i64, to: i64) -> TrendFigures {
        let mut figures = TrendFigures::default();
        let (mut area, mut known) = (0.0, 0.0);
        let (mut since, mut value) = (from, line.at(from));
        let mut sum = |value: Value, from: i64, to: i64, figures: &mut TrendFigures| {
            let Some(number) = value.as_real().filter(|number| number.is_finite()) else { return };
            let (low, high) = figures.range.unwrap_or((number, number));
            figures.range = Some((low.min(number), high.max(number)));
            let time = to.saturating_sub(from) as f64;
            area += number * time;
            known += time;
        };
        for point in line.between(from, to) {
            sum(value, since, point.at, &mut figures);
            match (value.as_bool(), point.value.as_bool()) {
                (Some(false), Some(true)) => figures.rises += 1,
                (Some(true), Some(false)) => figures.falls += 1,
                _ => {}
            }
            (since, value) = (point.at, point.value);
        }
        sum(value, since, to, &mut figures);
        figures.mean = (known > 0.0).then(|| area / known);
        figures
    }
}

/// What a line was in a small part of the window.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bin {
    /// The least and the greatest number, with the one that it began with.
    pub range: Option<(f64, f64)>,
    /// It was not driven at some time.
    pub high_z: bool,
    /// Changes.
    pub changes: u32,
}

/// What a line was in each of `count` equal parts of a window.
pub fn bins(line: &TrendLine, from: i64, to: i64, count: usize) -> Vec<Bin> {
    let mut bins = vec![Bin::default(); count];
    if count == 0 {
        return bins;
    }
    let base = to.saturating_sub(from).max(1) as f64;
    let place = |at: i64| {
        let share = at.saturating_sub(from) as f64 / base;
        ((share * count as f64) as usize).min(count - 1)
    };
    let mut fill = |value: Value, begin: usize, end: usize| {
        for bin in bins.iter_mut().take(end + 1).skip(begin) {
            if value == Value::HighZ {
                bin.high_z = true;
            }
            if let Some(number) = value.as_real().filter(|number| number.is_finite()) {
                let (low, high) = bin.range.unwrap_or((number, number));
                bin.range = Some((low.min(number), high.max(number)));
            }
        }
    };
    let (mut since, mut value) = (0, line.at(from));
    let mut changed = Vec::new();
    for point in line.between(from, to) {
        let at = place(point.at);
        fill(value, since, at);
        changed.push(at);
        (since, value) = (at, point.value);
    }
    fill(value, since, count - 1);
    for at in changed {
        bins[at].changes += 1;
    }
    bins
}

#[cfg(test)]
mod tests {
    use super::super::store::{TrendPoint, TrendStore};
    use super::*;
    use crate::recording::RecordedSignal;
    use control::SignalKind;

    fn line(points: &[(i64, Value)]) -> TrendLine {
        let track = RecordedSignal {
            name: "a".to_owned(),
            unit: String::new(),
            kind: SignalKind::Real,
            labels: Vec::new(),
        };
        let mut store = TrendStore { lines: vec![TrendLine::new(track)], now: 0 };
        for (at, value) in points {
            store.push("a", TrendPoint { earliest: *at, at: *at, value: *value }, None);
        }
        store.lines.remove(0)
    }

    #[test]
    fn the_mean_is_of_the_time_that_is_known() {
        let line = line(&[(10, Value::Real(2.0)), (20, Value::Real(4.0)), (30, Value::Unknown)]);
        let figures = TrendFigures::of(&line, 0, 100);
        assert_eq!((figures.range, figures.mean), (Some((2.0, 4.0)), Some(3.0)));
        let figures = TrendFigures::of(&line, 15, 20);
        // The last instant belongs to it, though no time does.
        assert_eq!((figures.range, figures.mean), (Some((2.0, 4.0)), Some(2.0)));
        assert_eq!(TrendFigures::of(&line, 40, 50), TrendFigures::default());
    }

    #[test]
    fn edges_are_counted_between_values_that_are_known() {
        let line = line(&[
            (1, Value::Bool(true)),
            (2, Value::Bool(false)),
            (3, Value::HighZ),
            (4, Value::Bool(true)),
            (5, Value::Bool(false)),
            (6, Value::Bool(true)),
        ]);
        let figures = TrendFigures::of(&line, 0, 10);
        assert_eq!((figures.rises, figures.falls), (1, 2));
    }

    #[test]
    fn a_bin_has_what_it_began_with_and_all_that_came() {
        let line = line(&[
            (0, Value::Real(1.0)),
            (25, Value::Real(5.0)),
            (26, Value::Real(3.0)),
            (90, Value::HighZ),
        ]);
        let bins = bins(&line, 0, 100, 4);
        assert_eq!(bins[0], Bin { range: Some((1.0, 1.0)), high_z: false, changes: 0 });
        assert_eq!(bins[1], Bin { range: Some((1.0, 5.0)), high_z: false, changes: 2 });
        assert_eq!(bins[2], Bin { range: Some((3.0, 3.0)), high_z: false, changes: 0 });
        assert_eq!(bins[3], Bin { range: Some((3.0, 3.0)), high_z: true, changes: 1 });
        assert!(super::bins(&line, 0, 100, 0).is_empty());
    }
}
