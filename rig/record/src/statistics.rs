//! Statistics over the turns of `--repeat`: what a measurement, or the margin of a claim, came to turn by turn.

use crate::{CaseRecord, Figure, RunRecord, Verdict};
use serde::{Deserialize, Serialize};

/// How a figure moved from turn to turn. Each turn counts with the middle of its interval.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Statistics {
    /// Turns that have the figure.
    pub count: u64,
    /// The least.
    #[serde(with = "crate::number::real")]
    pub min: f64,
    /// The mean.
    #[serde(with = "crate::number::real")]
    pub mean: f64,
    /// The greatest.
    #[serde(with = "crate::number::real")]
    pub max: f64,
    /// The standard deviation of the turns as a sample (divided by their number less one); 0 for a single one.
    #[serde(with = "crate::number::real")]
    pub spread: f64,
    /// The slope of the straight line that fits best, per turn; 0 for a single one.
    #[serde(with = "crate::number::real")]
    pub drift: f64,
}

impl Statistics {
    /// Of figures with the numbers of their turns; `None` without any that is finite.
    pub fn of(figures: &[(u32, f64)]) -> Option<Statistics> {
        let finite: Vec<(f64, f64)> = figures
            .iter()
            .filter(|(_, value)| value.is_finite())
            .map(|(turn, value)| (f64::from(*turn), *value))
            .collect();
        let count = finite.len() as f64;
        let first = finite.first()?.1;
        // Sums of distances from the first figure: large figures that hardly differ keep their digits.
        let mean_of = |part: &dyn Fn(&(f64, f64)) -> f64| finite.iter().map(part).sum::<f64>() / count;
        let turn = mean_of(&|(turn, _)| *turn);
        let above = mean_of(&|(_, value)| value - first);
        let squares: f64 = finite.iter().map(|(_, value)| (value - first - above).powi(2)).sum();
        let turns: f64 = finite.iter().map(|(at, _)| (at - turn).powi(2)).sum();
        let both: f64 = finite.iter().map(|(at, value)| (at - turn) * (value - first - above)).sum();
        Some(Statistics {
            count: finite.len() as u64,
            min: finite.iter().map(|(_, value)| *value).fold(f64::INFINITY, f64::min),
            mean: first + above,
            max: finite.iter().map(|(_, value)| *value).fold(f64::NEG_INFINITY, f64::max),
            spread: if count > 1.0 { (squares / (count - 1.0)).sqrt() } else { 0.0 },
            drift: if turns > 0.0 { both / turns } else { 0.0 },
        })
    }
}

/// What a figure is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FigureOf {
    /// The value of a measurement.
    Measurement,
    /// The margin of a claim.
    Margin,
}

/// One figure over all turns of a case.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RepeatedFigure {
    /// What it is of.
    pub of: FigureOf,
    /// Name of the measurement or claim.
    pub name: String,
    /// Unit of all its numbers; durations are in `ns`.
    pub unit: String,
    /// Its line in the plan, by which figures of one name are told apart.
    pub line: u32,
    /// The numbers.
    pub statistics: Statistics,
}

/// A case that ran several times.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Repeated {
    /// Its name, without the turn.
    pub case: String,
    /// Turns that were judged.
    pub turns: u64,
    /// Those of them that passed.
    pub passed: u64,
    /// The greatest verdict of all turns: the case holds if each of its turns does.
    pub verdict: Verdict,
    /// Measurements in the plan's order, then the margins of claims.
    pub figures: Vec<RepeatedFigure>,
}

impl RunRecord {
    /// The cases that ran several times, in the order of their first turns.
    pub fn repeated(&self) -> Vec<Repeated> {
        let mut first: Vec<(&str, Vec<&CaseRecord>)> = Vec::new();
        let mut places: std::collections::BTreeMap<&str, usize> = std::collections::BTreeMap::new();
        for case in self.cases.iter().filter(|case| case.turn.is_some() && case.is_judged()) {
            let place = *places.entry(case.base_name()).or_insert_with(|| {
                first.push((case.base_name(), Vec::new()));
                first.len() - 1
            });
            first[place].1.push(case);
        }
        first.into_iter().map(|(name, turns)| repeated(name, &turns)).collect()
    }
}

fn repeated(name: &str, turns: &[&CaseRecord]) -> Repeated {
    // Two claims of a case can have one name, but not one line too.
    type Key<'a> = (FigureOf, u32, &'a str, &'a str);
    let mut figures: Vec<(Key<'_>, Vec<(u32, f64)>)> = Vec::new();
    let mut note = |key, turn, value| match figures.iter_mut().find(|(known, _)| *known == key) {
        Some((_, values)) => values.push((turn, value)),
        None => figures.push((key, vec![(turn, value)])),
    };
    for case in turns {
        let turn = case.turn.unwrap_or_default();
        for taken in &case.measurements {
            if let Some([low, high]) = taken.value {
                let key = (FigureOf::Measurement, taken.line, taken.name.as_str(), taken.unit.as_str());
                note(key, turn, low + (high - low) / 2.0);
            }
        }
    }
    for case in turns {
        let turn = case.turn.unwrap_or_default();
        for claim in &case.claims {
            if let Some(Figure { value, unit }) = &claim.margin {
                note((FigureOf::Margin, claim.line, claim.name.as_str(), unit.as_str()), turn, *value);
            }
        }
    }
    Repeated {
        case: name.to_owned(),
        turns: turns.len() as u64,
        passed: turns.iter().filter(|case| case.verdict == Verdict::Pass).count() as u64,
        verdict: Verdict::fold(turns.iter().map(|case| case.verdict)),
        figures: figures
            .into_iter()
            .filter_map(|((of, line, name, unit), values)| {
                let (name, unit) = (name.to_owned(), unit.to_owned());
                Some(RepeatedFigure { of, name, unit, line, statistics: Statistics::of(&values)? })
            })
            .collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::MeasurementRecord;

    #[test]
    fn a_straight_line_drifts_and_has_its_spread() {
        let found = Statistics::of(&[(1, 10.0), (2, 12.0), (3, 14.0), (4, 16.0)]).unwrap();
        assert_eq!((found.count, found.min, found.mean, found.max, found.drift), (4, 10.0, 13.0, 16.0, 2.0));
        // The sum of squares is 20, of four turns.
        assert!((found.spread - (20.0f64 / 3.0).sqrt()).abs() < 1e-12);
        // The order in which they come does not matter, their turns do.
        assert_eq!(Statistics::of(&[(3, 14.0), (1, 10.0), (4, 16.0), (2, 12.0)]), Some(found));
    }

    #[test]
    fn large_figures_that_hardly_differ_keep_their_spread() {
        let found = Statistics::of(&[(1, 1e15 + 1.0), (2, 1e15 + 2.0), (3, 1e15 + 3.0)]).unwrap();
        assert_eq!((found.spread, found.drift), (1.0, 1.0));
    }

    #[test]
    fn one_turn_has_no_spread_and_none_has_nothing() {
        let found = Statistics::of(&[(1, 5.0), (2, f64::INFINITY)]).unwrap();
        assert_eq!((found.count, found.spread, found.drift), (1, 0.0, 0.0));
        assert_eq!(Statistics::of(&[]), None);
        assert_eq!(Statistics::of(&[(1, f64::NAN)]), None);
    }

    #[test]
    fn turns_of_a_case_belong_together() {
        let mut run = RunRecord::default();
        for (turn, name) in [(1, "a[x]"), (2, "a[x]#2"), (3, "a[x]#3")] {
            for plan in ["", "b/"] {
                let taken = MeasurementRecord {
                    name: "t".into(),
                    unit: "ns".into(),
                    value: Some([f64::from(turn) * 10.0, f64::from(turn) * 10.0 + 2.0]),
                    ..MeasurementRecord::default()
                };
                let verdict = if turn == 2 { Verdict::Fail } else { Verdict::Pass };
                run.push(CaseRecord {
                    name: format!("{plan}{name}"),
                    turn: Some(turn),
                    verdict,
                    measurements: vec![taken],
                    ..CaseRecord::default()
                });
            }
        }
        run.push(CaseRecord { name: "once".into(), ..CaseRecord::default() });
        let found = run.repeated();
        let names: Vec<&str> = found.iter().map(|one| one.case.as_str()).collect();
        assert_eq!(names, ["a[x]", "b/a[x]"]);
        assert_eq!((found[0].turns, found[0].passed, found[0].verdict), (3, 2, Verdict::Fail));
        assert_eq!(found[0].figures[0].statistics.mean, 21.0);
    }
}
