//! A history as text for a person and as JSON for a program.

use super::read::{PastFigure, PastResult, PastRuns};
use super::trend::{Stability, Trend};
use record::{Figure, Unguarded};
use serde_json::{Value, json};
use std::fmt::Write;

/// Version of the JSON.
const FORMAT: u32 = 1;

/// Runs, cases and figures that are listed without `--only`.
const RUNS: usize = 10;
const CASES: usize = 30;
const FIGURES: usize = 20;

/// Results that a case's row shows.
const MARKS: usize = 40;

/// Trends of a figure: of its value and of its margin.
struct Trends<'a> {
    figure: &'a PastFigure,
    value: Option<Trend>,
    margin: Option<Trend>,
}

impl<'a> Trends<'a> {
    fn of(figure: &'a PastFigure) -> Trends<'a> {
        let values: Vec<(usize, f64)> =
            figure.points.iter().filter_map(|(run, value, _)| Some((*run, (*value)?))).collect();
        let margins: Vec<(usize, f64)> =
            figure.points.iter().filter_map(|(run, _, margin)| Some((*run, (*margin)?))).collect();
        Trends { figure, value: Trend::of(&values), margin: Trend::of(&margins) }
    }

    /// The sooner a margin is gone, the less.
    fn urgency(&self) -> f64 {
        self.margin.and_then(|margin| margin.runs_left()).unwrap_or(f64::INFINITY)
    }

    fn drifts(&self) -> bool {
        [self.value, self.margin].into_iter().flatten().any(|trend| trend.drift.is_some())
    }
}

/// Columns for a person; with `all`, every case and figure, otherwise those that need attention.
pub(super) fn table(past: &PastRuns, all: bool) -> String {
    let mut out = String::new();
    // Writing to a String cannot fail.
    let _ = writeln!(out, "Runs ({})", past.runs.len());
    for run in past.runs.iter().rev().take(RUNS).rev() {
        let (started, version) = (&run.started, &run.rig_version);
        let _ = writeln!(
            out,
            "  {started:20}  rig {version:8}  {:12}  {} passed, {} not{}  {}",
            run.verdict,
            run.passed,
            run.others,
            unguarded(run.unguarded),
            run.name
        );
    }
    cases(&mut out, past, all);
    figures(&mut out, past, all);
    out
}

/// What of a run was measured without a guard band, after its counts.
fn unguarded(found: Unguarded) -> String {
    match reports::unguarded_words(found) {
        said if said.is_empty() => said,
        said => format!(", {said}"),
    }
}

fn cases(out: &mut String, past: &PastRuns, all: bool) {
    let mut rows: Vec<(&String, Stability, &[PastResult])> =
        past.cases.iter().map(|(name, results)| (name, Stability::of(results), results.as_slice())).collect();
    rows.retain(|(_, found, _)| all || found.changes > 0 || found.passed < found.judged);
    rows.sort_by_key(|(_, found, _)| {
        std::cmp::Reverse((found.flaky, found.changes, found.judged - found.passed))
    });
    let title = if all { "Cases" } else { "Cases that did not always pass" };
    let _ = writeln!(out, "\n{title} ({} of {})", rows.len(), past.cases.len());
    for (name, found, results) in rows.iter().take(if all { usize::MAX } else { CASES }) {
        let flaky = match (found.flaky, found.changes) {
            (0, 0) => String::new(),
            (0, changes) => format!(", changed {changes} times with its files"),
            (flaky, _) => format!(", flaky: changed {flaky} times by itself"),
        };
        let _ =
            writeln!(out, "  {}  {} of {} passed{flaky}", marks(past, results), found.passed, found.judged);
        let _ = writeln!(out, "      {name}");
    }
    more(out, rows.len(), all, CASES);
}

/// A sign for each of the last runs.
fn marks(past: &PastRuns, results: &[PastResult]) -> String {
    let mut marks = vec![' '; past.runs.len()];
    for result in results {
        if let Some(mark) = marks.get_mut(result.run) {
            *mark = match result.outcome.as_str() {
                "pass" => '.',
                "fail" => 'F',
                "inconclusive" => '?',
                "error" => 'E',
                _ => '-',
            };
        }
    }
    marks[marks.len().saturating_sub(MARKS)..].iter().collect()
}

fn figures(out: &mut String, past: &PastRuns, all: bool) {
    let mut rows: Vec<Trends<'_>> = past.figures.iter().map(Trends::of).collect();
    rows.retain(|row| all || row.drifts());
    if !all {
        rows.sort_by(|left, right| left.urgency().total_cmp(&right.urgency()));
    }
    let title = if all { "Figures" } else { "Figures that drift" };
    let _ = writeln!(out, "\n{title} ({} of {})", rows.len(), past.figures.len());
    for row in rows.iter().take(if all { usize::MAX } else { FIGURES }) {
        let _ = writeln!(out, "  {}: {}", row.figure.case, row.figure.name);
        for (what, trend) in [("value", row.value), ("margin", row.margin)] {
            if let Some(trend) = trend {
                let _ =
                    writeln!(out, "      {what:6}  {}", words(&trend, &row.figure.unit, what == "margin"));
            }
        }
    }
    more(out, rows.len(), all, FIGURES);
}

fn more(out: &mut String, count: usize, all: bool, most: usize) {
    if !all && count > most {
        let _ = writeln!(out, "  and {} more (`--only TEXT` and `--format json` show all)", count - most);
    }
}

fn words(trend: &Trend, unit: &str, margin: bool) -> String {
    // Whole nanoseconds read as durations.
    let figure = |value: f64| Figure::new(if unit == "ns" { value.round() } else { value }, unit).to_string();
    let mut words = format!(
        "last {}, mean {}, {} .. {}, spread {}, {} runs",
        figure(trend.last),
        figure(trend.mean),
        figure(trend.min),
        figure(trend.max),
        figure(trend.spread),
        trend.count
    );
    if let Some(drift) = trend.drift {
        let sign = if drift > 0.0 { "+" } else { "" };
        let _ = write!(words, ", drifts {sign}{} a run", figure(drift));
    }
    if let Some(left) = trend.runs_left().filter(|_| margin) {
        let _ = write!(words, ", gone in {left:.0} runs");
    }
    words
}

/// Everything, for a program.
pub(super) fn json(past: &PastRuns) -> String {
    let runs: Vec<Value> = past
        .runs
        .iter()
        .map(|run| {
            json!({
                "name": run.name, "started": run.started, "rig_version": run.rig_version,
                "verdict": run.verdict, "passed": run.passed, "others": run.others, "unguarded": run.unguarded,
            })
        })
        .collect();
    let cases: Vec<Value> = past
        .cases
        .iter()
        .map(|(name, results)| {
            let found = Stability::of(results);
            let results: Vec<Value> = results
                .iter()
                .map(|result| json!({ "run": result.run, "outcome": result.outcome }))
                .collect();
            json!({
                "name": name, "judged": found.judged, "passed": found.passed, "changes": found.changes,
                "flaky": found.flaky, "results": results,
            })
        })
        .collect();
    let figures: Vec<Value> = past
        .figures
        .iter()
        .map(|figure| {
            let trends = Trends::of(figure);
            json!({
                "case": figure.case, "name": figure.name, "unit": figure.unit,
                "kind": if figure.measured { "measurement" } else { "claim" },
                "value": trends.value.map(trend), "margin": trends.margin.map(trend),
                "runs_left": trends.margin.and_then(|margin| margin.runs_left()),
            })
        })
        .collect();
    let all = json!({ "format": FORMAT, "runs": runs, "cases": cases, "figures": figures });
    format!("{}\n", serde_json::to_string_pretty(&all).unwrap_or_default())
}

fn trend(trend: Trend) -> Value {
    let Trend { count, last, mean, min, max, spread, drift } = trend;
    json!({ "count": count, "last": last, "mean": mean, "min": min, "max": max, "spread": spread, "drift": drift })
}
