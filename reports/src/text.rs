//! The summary of a run for a terminal or a CI log: a line a case, then what needs attention, then counts.

use crate::coverage::CoverageRow;
pub use crate::show::clean;
use crate::show::{self, ShownOutcome};
use record::{
    CaseRecord, ClaimRecord, FigureOf, FileCoverage, MeasurementRecord, RepeatedFigure, RunRecord, Totals,
    Verdict,
};
use std::fmt::Write;

/// How the text is dressed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Style {
    /// With ANSI colour sequences.
    pub color: bool,
    /// Without the lines of cases that passed, do not apply or were skipped.
    pub quiet: bool,
}

/// The whole summary: [`case_line`] of every case, [`details`] of every one that needs attention, [`coverage`] where
/// there is one, [`summary`].
pub fn render(run: &RunRecord, style: Style) -> String {
    let mut out = String::new();
    for case in &run.cases {
        if !(style.quiet && is_quiet(case)) {
            out.push_str(&case_line(case, style));
            out.push('\n');
        }
    }
    for case in run.cases.iter().filter(|case| !is_quiet(case)) {
        out.push('\n');
        out.push_str(&details(case, style));
    }
    out.push('\n');
    if !run.coverage.is_empty() {
        out.push_str(&coverage(&run.coverage));
        out.push('\n');
    }
    out.push_str(&repeats(run));
    out.push_str(&summary(run, style));
    out.push('\n');
    out
}

fn is_quiet(case: &CaseRecord) -> bool {
    !case.is_judged() || case.verdict == Verdict::Pass
}

/// One line, without its end: verdict, modelled time of the case in seconds, name, and that a measurement has no guard band or was
/// decided by its middle alone;
/// and the reason of a case that does not apply or was skipped.
pub fn case_line(case: &CaseRecord, style: Style) -> String {
    line_of(case, "", style)
}

/// As [`case_line`], with the case's number among all cases of the run before its name: `( 12/2389)`.
pub fn numbered_line(case: &CaseRecord, number: usize, total: usize, style: Style) -> String {
    let width = total.to_string().len();
    line_of(case, &format!("({number:>width$}/{total}) "), style)
}

fn line_of(case: &CaseRecord, number: &str, style: Style) -> String {
    let outcome = ShownOutcome::of(case);
    let word = match outcome {
        ShownOutcome::Judged(Verdict::Pass) => "PASS",
        ShownOutcome::Judged(Verdict::Fail) => "FAIL",
        ShownOutcome::Judged(Verdict::Inconclusive) => "INCONCLUSIVE",
        ShownOutcome::Judged(Verdict::Error) => "ERROR",
        ShownOutcome::Judged(Verdict::None) => "NO VERDICT",
        ShownOutcome::Skipped => "SKIP",
        ShownOutcome::NotApplicable => "N/A",
    };
    let name = clean(&case.name);
    let word = paint(&format!("{word:>12}"), outcome, style);
    if case.is_judged() {
        let guard = match (case.is_unguarded(), case.is_by_middle()) {
            (false, _) => "",
            (true, false) => " (guard none)",
            (true, true) => " (guard none, by its middle)",
        };
        format!("{word} [{:>10}] {number}{name}{guard}", seconds(case.duration_ns))
    } else {
        format!("{word} [{:>10}] {number}{name}: {}", "", clean(show::reason(case)))
    }
}

/// What needs attention in a case: every claim and measurement that did not pass, with its figures. Ends
/// with a line end.
pub fn details(case: &CaseRecord, style: Style) -> String {
    let mut out = String::new();
    let outcome = ShownOutcome::of(case);
    let head = format!("{} {}", outcome.sign(), clean(&case.name));
    line(&mut out, 0, &paint(&head, outcome, style), &clean(&case.title));
    if !case.reason.is_empty() {
        line(&mut out, 2, "why", &clean(&case.reason));
    }
    for claim in case.claims.iter().filter(|claim| claim.verdict != Verdict::Pass) {
        claim_details(&mut out, case, claim, style);
    }
    let attention = |m: &&MeasurementRecord| !matches!(m.verdict, Verdict::Pass | Verdict::None);
    for measurement in case.measurements.iter().filter(attention) {
        measurement_details(&mut out, case, measurement, style);
    }
    if let Some(instrument) = &case.instrument {
        line(&mut out, 2, "instrument", &clean(&format!("{} {}", instrument.file, instrument.title)));
        for (of, stated) in show::instrument(instrument) {
            line(&mut out, 6, &clean(of), &clean(&stated));
        }
    }
    let model = if case.model.is_empty() { String::new() } else { format!(", model {}", clean(&case.model)) };
    let origin = format!("{}seed {}, {}{model}", place(case, 0, ", "), case.seed, clean(&case.profile));
    line(&mut out, 2, "case", origin.trim_end_matches([',', ' ']));
    out
}

fn claim_details(out: &mut String, case: &CaseRecord, claim: &ClaimRecord, style: Style) {
    let head = format!("{} {}", show::sign(claim.verdict), clean(&claim.name));
    line(out, 2, &paint(&head, ShownOutcome::Judged(claim.verdict), style), "");
    facts(
        out,
        &[
            // A claim without a name of its own is headed by what it expects.
            ("expected", if claim.expected == claim.name { String::new() } else { claim.expected.clone() }),
            ("observed", claim.observed.clone()),
            ("why", claim.reason.clone()),
            (
                "at",
                claim
                    .deciding_ns
                    .map_or(String::new(), |at| format!("start {}", show::relative(at, case.start_ns))),
            ),
            ("margin", claim.margin.as_ref().map_or(String::new(), ToString::to_string)),
            (
                "uncertainty",
                claim
                    .uncertainty
                    .as_ref()
                    .filter(|u| u.value != 0.0)
                    .map_or(String::new(), ToString::to_string),
            ),
            ("nearest miss", claim.nearest_miss.clone().unwrap_or_default()),
            ("last writer", claim.last_writer.clone().unwrap_or_default()),
            ("in", claim_place(case, claim)),
        ],
    );
}

/// Where a claim stands: in its plan, or in the suite or board file that claims it of every case.
fn claim_place(case: &CaseRecord, claim: &ClaimRecord) -> String {
    match &claim.place_file {
        Some(file) => format!("{}:{}", clean(file), claim.line),
        None => place(case, claim.line, ""),
    }
}

fn measurement_details(out: &mut String, case: &CaseRecord, measurement: &MeasurementRecord, style: Style) {
    let head = format!("{} {}", show::sign(measurement.verdict), clean(&measurement.name));
    line(out, 2, &paint(&head, ShownOutcome::Judged(measurement.verdict), style), "");
    facts(
        out,
        &[
            ("limits", show::limits(measurement)),
            ("measured", show::value(measurement)),
            ("coverage", measurement.coverage.clone()),
            ("why", measurement.reason.clone()),
            ("margin", measurement.margin.as_ref().map_or(String::new(), ToString::to_string)),
            ("in", place(case, measurement.line, "")),
        ],
    );
}

/// `plan:line` as editors and CI logs link it, then `after`; empty when there is no plan.
fn place(case: &CaseRecord, line: u32, after: &str) -> String {
    match (case.plan.as_str(), line) {
        ("", _) => String::new(),
        (plan, 0) => format!("{}{after}", clean(plan)),
        (plan, line) => format!("{}:{line}{after}", clean(plan)),
    }
}

fn facts(out: &mut String, facts: &[(&str, String)]) {
    for (label, text) in facts.iter().filter(|(_, text)| !text.is_empty()) {
        line(out, 6, label, &clean(text));
    }
}

/// A label padded to a column, then the text.
fn line(out: &mut String, indent: usize, label: &str, text: &str) {
    let width = if indent == 6 { 12 } else { 0 };
    let whole = format!("{:indent$}{label:<width$}  {text}", "");
    out.push_str(whole.trim_end());
    out.push('\n');
}

/// The counts, in one line without its end. Counts of errors, of cases without verdict and of skipped cases
/// appear when they are not 0, and that the
/// run ended early is said.
pub fn summary(run: &RunRecord, style: Style) -> String {
    let Totals { passed, none, inconclusive, failed, errors, not_applicable, skipped } = run.totals;
    let count = |n: u64, word: &str, outcome: ShownOutcome| {
        let text = format!("{n} {word}");
        if n == 0 { text } else { paint(&text, outcome, style) }
    };
    let mut parts = vec![
        count(passed, "passed", ShownOutcome::Judged(Verdict::Pass)),
        count(failed, "failed", ShownOutcome::Judged(Verdict::Fail)),
        count(inconclusive, "inconclusive", ShownOutcome::Judged(Verdict::Inconclusive)),
        count(not_applicable, "not applicable", ShownOutcome::NotApplicable),
    ];
    for (n, word, outcome) in [
        (errors, if errors == 1 { "error" } else { "errors" }, ShownOutcome::Judged(Verdict::Error)),
        (none, "without verdict", ShownOutcome::Judged(Verdict::None)),
        (skipped, "skipped", ShownOutcome::Skipped),
    ] {
        if n > 0 {
            parts.push(count(n, word, outcome));
        }
    }
    let ran = run.totals.judged() + not_applicable;
    let planned = run.planned.max(ran + skipped);
    let part = if ran < planned { format!("; {ran} of {planned} planned cases ran") } else { String::new() };
    let unguarded = Some(show::unguarded(run)).filter(|said| !said.is_empty());
    let unguarded = unguarded.map_or(String::new(), |said| format!("; {said}"));
    format!("Summary: {}{part}{unguarded}", parts.join(", "))
}

/// What of each source file ran: statements, branches, the lines that were missed. Ends with a line end.
pub fn coverage(files: &[FileCoverage]) -> String {
    let mut out = String::from("Coverage\n");
    for row in files.iter().map(CoverageRow::of) {
        let CoverageRow { file, statements, branches, missed, one_way } = row;
        line(&mut out, 2, &clean(&file), "");
        facts(
            &mut out,
            &[
                ("statements", statements),
                ("branches", branches),
                ("not run", missed),
                ("one way only", one_way),
            ],
        );
    }
    out
}

/// What the turns of cases that ran several times came to: how many passed, and how each figure moved. Empty without
/// such cases; else it ends with an empty line.
pub fn repeats(run: &RunRecord) -> String {
    let mut out = String::new();
    for case in run.repeated() {
        if out.is_empty() {
            out.push_str("Repeats\n");
        }
        let passed = format!("{} of {} passed", case.passed, case.turns);
        line(&mut out, 2, &clean(&case.case), &passed);
        for RepeatedFigure { of, name, unit, statistics, .. } in &case.figures {
            let name = match of {
                FigureOf::Measurement => clean(name).into_owned(),
                FigureOf::Margin => format!("margin of {}", clean(name)),
            };
            line(&mut out, 4, &format!("{name}:"), &show::statistics(statistics, unit));
        }
    }
    if !out.is_empty() {
        out.push('\n');
    }
    out
}

fn paint(text: &str, outcome: ShownOutcome, style: Style) -> String {
    if !style.color {
        return text.to_owned();
    }
    let code = match outcome {
        ShownOutcome::Judged(Verdict::Pass) => "32;1",
        ShownOutcome::Judged(Verdict::Fail) => "31;1",
        ShownOutcome::Judged(Verdict::Inconclusive) => "33;1",
        ShownOutcome::Judged(Verdict::Error) => "35;1",
        ShownOutcome::Judged(Verdict::None) | ShownOutcome::Skipped | ShownOutcome::NotApplicable => "2",
    };
    format!("\u{1b}[{code}m{text}\u{1b}[0m")
}

/// Seconds to the millisecond, cut and not rounded: `2.340 s`.
fn seconds(ns: i64) -> String {
    let mut out = String::new();
    let magnitude = ns.unsigned_abs();
    let sign = if ns < 0 { "-" } else { "" };
    // Writing to a String cannot fail.
    let _ = write!(out, "{sign}{}.{:03} s", magnitude / 1_000_000_000, magnitude / 1_000_000 % 1_000);
    out
}
