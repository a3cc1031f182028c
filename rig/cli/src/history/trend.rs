//! What a row of numbers does from run to run, and which cases cannot be relied on.

use super::database::is_pass;
use super::read::PastResult;

/// The fewest points that make a trend.
const LEAST_POINTS: usize = 5;

/// A slope counts when it is this many times its own standard error.
const SURE: f64 = 3.0;

/// A row of numbers in short.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Trend {
    /// How many there are.
    pub count: usize,
    /// The latest.
    pub last: f64,
    /// Arithmetic mean.
    pub mean: f64,
    /// Least.
    pub min: f64,
    /// Greatest.
    pub max: f64,
    /// Standard deviation of the sample; 0 of one number.
    pub spread: f64,
    /// Change per run, by least squares, where it is more than chance.
    pub drift: Option<f64>,
}

impl Trend {
    /// Of points in the order of their runs: place of the run and number. Nothing of nothing.
    pub(super) fn of(points: &[(usize, f64)]) -> Option<Trend> {
        let points: Vec<(f64, f64)> =
            points.iter().filter(|(_, y)| y.is_finite()).map(|(x, y)| (*x as f64, *y)).collect();
        let (_, last) = *points.last()?;
        let count = points.len();
        let n = count as f64;
        let mean_of = |of: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / n;
        let (x_mean, mean) = (mean_of(&|p| p.0), mean_of(&|p| p.1));
        let sum =
            |of: &dyn Fn(f64, f64) -> f64| points.iter().map(|(x, y)| of(x - x_mean, y - mean)).sum::<f64>();
        let (xx, xy, yy) = (sum(&|x, _| x * x), sum(&|x, y| x * y), sum(&|_, y| y * y));
        let slope = xy / xx;
        // What the line leaves over says how sure its slope is.
        let rest = (yy - slope * xy).max(0.0);
        let error = (rest / (n - 2.0) / xx).sqrt();
        // Rounding makes a slope of equal numbers, too.
        let noise = 1e-9 * mean.abs().max(last.abs());
        let sure = count >= LEAST_POINTS && slope.abs() > SURE * error && slope.abs() * (n - 1.0) > noise;
        Some(Trend {
            count,
            last,
            mean,
            min: points.iter().map(|p| p.1).fold(f64::INFINITY, f64::min),
            max: points.iter().map(|p| p.1).fold(f64::NEG_INFINITY, f64::max),
            spread: if count > 1 { (yy / (n - 1.0)).sqrt() } else { 0.0 },
            drift: sure.then_some(slope),
        })
    }

    /// Of margins: after how many more runs there is none, if it goes on like this.
    pub(super) fn runs_left(&self) -> Option<f64> {
        let drift = self.drift.filter(|drift| *drift < 0.0)?;
        (self.last > 0.0).then(|| self.last / -drift)
    }
}

/// How a case's verdict changed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Stability {
    /// Runs in which it was judged.
    pub judged: usize,
    /// Those in which it passed.
    pub passed: usize,
    /// Changes from one judged run to the next.
    pub changes: usize,
    /// Those of them in which nothing that it is made from had changed.
    pub flaky: usize,
}

impl Stability {
    /// Of results in the order of their runs.
    pub(super) fn of(results: &[PastResult]) -> Stability {
        let judged: Vec<&PastResult> = results
            .iter()
            .filter(|result| !matches!(result.outcome.as_str(), "skipped" | "not-applicable" | "none"))
            .collect();
        let changed: Vec<bool> = judged
            .windows(2)
            .filter(|pair| pair[0].outcome != pair[1].outcome)
            .map(|pair| pair[0].made_from == pair[1].made_from)
            .collect();
        Stability {
            judged: judged.len(),
            passed: judged.iter().filter(|result| is_pass(&result.outcome)).count(),
            changes: changed.len(),
            flaky: changed.iter().filter(|flaky| **flaky).count(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trend(numbers: &[f64]) -> Trend {
        let points: Vec<(usize, f64)> = numbers.iter().copied().enumerate().collect();
        Trend::of(&points).unwrap()
    }

    #[test]
    fn numbers_in_short() {
        let found = trend(&[2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0]);
        assert_eq!((found.mean, found.min, found.max, found.last, found.count), (5.0, 2.0, 9.0, 9.0, 8));
        assert!((found.spread - 2.138_089_935).abs() < 1e-6);
        assert_eq!(trend(&[3.0]).spread, 0.0);
        assert!(Trend::of(&[]).is_none() && Trend::of(&[(0, f64::NAN)]).is_none());
    }

    #[test]
    fn only_what_is_more_than_chance_drifts() {
        let down: Vec<f64> = (0..10).map(|n| 100.0 - 5.0 * f64::from(n)).collect();
        let found = trend(&down);
        assert_eq!(found.drift.map(f64::round), Some(-5.0));
        assert_eq!(found.runs_left().map(f64::round), Some(11.0));
        assert_eq!(trend(&[0.1 + 0.2; 10]).drift, None);
        assert_eq!(trend(&[1.0, 9.0, 2.0, 8.0, 1.5, 9.5]).drift, None);
        // Three points are no trend, whatever they look like.
        assert_eq!(trend(&[3.0, 2.0, 1.0]).drift, None);
        // A margin that grows never ends.
        let up: Vec<f64> = (0..10).map(f64::from).collect();
        assert_eq!(trend(&up).runs_left(), None);
    }

    #[test]
    fn a_case_is_flaky_when_nothing_but_its_verdict_changed() {
        let result = |outcome: &str, made_from: &str| PastResult {
            run: 0,
            outcome: outcome.into(),
            made_from: made_from.into(),
        };
        let found = Stability::of(&[
            result("pass", "a"),
            result("fail", "a"),
            result("skipped", "a"),
            result("pass", "b"),
            result("pass", "b"),
            result("inconclusive", "b"),
        ]);
        assert_eq!(found, Stability { judged: 5, passed: 3, changes: 3, flaky: 2 });
    }
}
