//! The run as Markdown for a merge request or a job's summary: the verdict, what did not pass, the smallest margins.
//!
//! Bounded, so that it fits into a comment; what was left out is said. Whatever comes from a user's file stands as
//! code, so that no name becomes a link, a mention or markup.

use crate::brief::{self, DecidingResult};
use crate::matrix;
use crate::show::{self, ShownOutcome, clean, sign};
use record::{CaseRecord, Figure, GuardBand, RunRecord, Totals, Verdict};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

/// The longest summary in bytes: a comment on GitHub takes 65 536 characters.
pub const MAX_BYTES: usize = 60_000;

/// Cases that did not pass which are listed with their claims; further ones by name and message.
const WITH_CLAIMS: usize = 20;
/// Cases that did not pass which are named at all.
const NAMED: usize = 100;
/// Claims of one case that are listed.
const CLAIMS: usize = 10;
/// Rows of the tables of margins and measurements.
const ROWS: usize = 10;
/// Longest text of a cell, bytes.
const CELL: usize = 300;

/// The summary, of at most [`MAX_BYTES`].
pub fn render(run: &RunRecord) -> String {
    let mut page = BoundedText { out: String::new(), full: false };
    head(&mut page, run);
    attention(&mut page, run);
    by_middle(&mut page, run);
    margins(&mut page, run);
    requirements(&mut page, run);
    environment(&mut page, run);
    if page.full {
        page.out.push_str("\n*The rest is left out here: see the report.*\n");
    }
    page.out
}

/// Text with a bound.
struct BoundedText {
    out: String,
    /// Something found no room; nothing is added any more.
    full: bool,
}

impl BoundedText {
    /// Adds a whole block, or nothing.
    fn add(&mut self, block: &str) {
        self.full |= self.out.len() + block.len() > MAX_BYTES - 100;
        if !self.full {
            self.out.push_str(block);
        }
    }
}

fn head(page: &mut BoundedText, run: &RunRecord) {
    let Totals { passed, none, inconclusive, failed, errors, not_applicable, skipped } = run.totals;
    let verdict = run.verdict();
    let word = match verdict {
        Verdict::Pass => "passed",
        Verdict::Fail => "failed",
        Verdict::Inconclusive => "inconclusive",
        Verdict::Error => "error of the rig",
        Verdict::None => "nothing was judged",
    };
    let counts = [
        (passed, "passed"),
        (failed, "failed"),
        (inconclusive, "inconclusive"),
        (errors, if errors == 1 { "error" } else { "errors" }),
        (none, "without verdict"),
        (not_applicable, "not applicable"),
        (skipped, "skipped"),
    ];
    let counts: Vec<String> =
        counts.iter().filter(|(n, _)| *n > 0).map(|(n, word)| format!("**{n}** {word}")).collect();
    let mut facts =
        vec![format!("{} time", run.provenance.clock.word()), format!("seed {}", run.provenance.seed)];
    if let Some([part, of]) = run.shard {
        facts.push(format!("part {part} of {of}"));
    }
    if run.host_ms > 0 {
        facts.push(format!("{}.{:01} s on the host", run.host_ms / 1000, run.host_ms % 1000 / 100));
    }
    facts.extend(Some(show::unguarded(run)).filter(|said| !said.is_empty()));
    let counts = if counts.is_empty() { "No cases".to_owned() } else { counts.join(", ") };
    page.add(&format!(
        "## {} rig: {word}\n\n{counts} of {} cases; {}.\n",
        sign(verdict),
        run.cases.len(),
        facts.join(", ")
    ));
}

/// Cases that did not pass, the worst first.
fn attention(page: &mut BoundedText, run: &RunRecord) {
    let mut cases: Vec<&CaseRecord> =
        run.cases.iter().filter(|case| case.is_judged() && case.verdict != Verdict::Pass).collect();
    if cases.is_empty() {
        return;
    }
    cases.sort_by_key(|case| std::cmp::Reverse(case.verdict));
    page.add("\n### What did not pass\n");
    for (place, case) in cases.iter().take(NAMED).enumerate() {
        if place < WITH_CLAIMS {
            page.add(&with_claims(case));
        } else {
            let lead = if place == WITH_CLAIMS { "\n" } else { "" };
            page.add(&format!(
                "{lead}- {} {}: {}\n",
                outcome(case),
                code(&case.name),
                code(&brief::message(case))
            ));
        }
    }
    if cases.len() > NAMED {
        page.add(&format!("\nand {} more.\n", cases.len() - NAMED));
    }
}

fn with_claims(case: &CaseRecord) -> String {
    let mut out = format!("\n#### {} {}\n\n", outcome(case), code(&case.name));
    if !case.title.is_empty() {
        out.push_str(&format!("{}\n", code(&case.title)));
    }
    if let DecidingResult::Reason(reason) = DecidingResult::of(case) {
        let _ = writeln!(out, "\n{}", code(if reason.is_empty() { case.verdict.word() } else { reason }));
        if show::exception(case).is_none() {
            return out;
        }
    }
    let figure = |figure: Option<&Figure>| figure.map_or(String::new(), Figure::to_string);
    let claims = case.claims.iter().filter(|claim| claim.verdict != Verdict::Pass).map(|claim| {
        let observed = match &claim.nearest_miss {
            Some(miss) => format!("{} ({miss})", claim.observed),
            None => claim.observed.clone(),
        };
        let cells = [claim.expected.clone(), observed, figure(claim.margin.as_ref())];
        (claim.verdict, cells, claim.line)
    });
    let measurements = case.measurements.iter().filter(|m| m.verdict > Verdict::Pass).map(|m| {
        let wanted = format!("{} {}", m.name, show::limits(m));
        let observed = match show::by_middle(m) {
            "" => show::covered(m),
            reason => format!("{} ({reason})", show::covered(m)),
        };
        (m.verdict, [wanted, observed, figure(m.margin.as_ref())], m.line)
    });
    let all: Vec<_> = claims.chain(measurements).collect();
    if all.is_empty() {
        return out;
    }
    out.push_str("\n| | expected | observed | margin | in |\n| --- | --- | --- | --- | --- |\n");
    for (verdict, cells, line) in all.iter().take(CLAIMS) {
        let place = if *line == 0 { case.plan.clone() } else { format!("{}:{line}", case.plan) };
        let [expected, observed, margin] = cells.each_ref().map(|cell| code(cell));
        let _ =
            writeln!(out, "| {} | {expected} | {observed} | {margin} | {} |", sign(*verdict), code(&place));
    }
    if all.len() > CLAIMS {
        let _ = writeln!(out, "\nand {} more claims.", all.len() - CLAIMS);
    }
    out
}

/// What passed by the middle of its value alone: accepted, and not proven.
fn by_middle(page: &mut BoundedText, run: &RunRecord) {
    let cases = run.cases.iter().filter(|case| case.is_judged());
    let all: Vec<_> = cases
        .flat_map(|case| case.measurements.iter().map(move |m| (case, m)))
        .filter(|(_, m)| m.by_middle && m.verdict == Verdict::Pass)
        .collect();
    if all.is_empty() {
        return;
    }
    let mut out = String::from(
        "\n### Accepted and not proven\n\n| limits | observed | why | measurement | case |\n| --- | --- | --- | --- | --- |\n",
    );
    for (case, m) in all.iter().take(ROWS) {
        let cells = [&show::limits(m), &show::covered(m), show::by_middle(m), &m.name, &case.name];
        let _ = writeln!(out, "| {} |", cells.map(code).join(" | "));
    }
    if all.len() > ROWS {
        let _ = writeln!(out, "\nand {} more.", all.len() - ROWS);
    }
    page.add(&out);
}

/// What passed most narrowly: the margin as a part of what the limits leave on either side; of a claim in many rows,
/// points and profiles the narrowest.
fn margins(page: &mut BoundedText, run: &RunRecord) {
    let mut rows: Vec<NarrowMargin<'_>> = Vec::new();
    for case in run.cases.iter().filter(|case| case.is_judged()) {
        for claim in case.claims.iter().filter(|claim| claim.verdict == Verdict::Pass) {
            let limits = claim.window.and_then(|w| Some((w.limit_from_ns?, w.limit_until_ns?)));
            if let (Some(margin), Some((from, until))) = (&claim.margin, limits)
                && margin.unit == "ns"
            {
                let half = until.saturating_sub(from) as f64 / 2.0;
                let observed = claim.observed.clone();
                rows.push(NarrowMargin {
                    part: margin.value / half,
                    case,
                    name: &claim.name,
                    observed,
                    margin,
                });
            }
        }
        for m in case.measurements.iter().filter(|m| m.verdict == Verdict::Pass) {
            let (min, max) = show::bounds(m);
            if let (Some(margin), Some(min), Some(max)) = (&m.margin, min, max) {
                let half = (max - min) / 2.0;
                rows.push(NarrowMargin {
                    part: margin.value / half,
                    case,
                    name: &m.name,
                    observed: match m.guard_band {
                        GuardBand::Uncertainty => show::covered(m),
                        GuardBand::None => format!("{}, guard none", show::covered(m)),
                    },
                    margin,
                });
            }
        }
    }
    // A window without width has no nearer and no farther.
    rows.retain(|row| row.part.is_finite());
    rows.sort_by(|left, right| left.part.total_cmp(&right.part));
    let mut seen = BTreeSet::new();
    rows.retain(|row| seen.insert((&row.case.plan, row.name)));
    if rows.is_empty() {
        return;
    }
    let mut out = String::from(
        "\n### Smallest margins\n\n| of the tolerance | margin | observed | claim | case |\n| ---: | ---: | --- | --- | --- |\n",
    );
    for NarrowMargin { part, case, name, observed, margin } in rows.iter().take(ROWS) {
        let (margin, observed) = (code(&margin.to_string()), code(observed));
        let (name, case) = (code(name), code(&case.name));
        let _ = writeln!(out, "| {:.1} % | {margin} | {observed} | {name} | {case} |", 100.0 * part);
    }
    page.add(&out);
}

/// A claim or measurement that passed.
struct NarrowMargin<'a> {
    /// Its margin as a part of half its tolerance: 1 in the middle, 0 at a limit.
    part: f64,
    case: &'a CaseRecord,
    name: &'a str,
    observed: String,
    margin: &'a Figure,
}

fn requirements(page: &mut BoundedText, run: &RunRecord) {
    let rows = matrix::requirements(run);
    if rows.is_empty() {
        return;
    }
    let mut out = String::from("\n### Requirements\n\n");
    let _ = match statuses(run).as_slice() {
        // A record of a rig that did not say how far they are proven.
        [] => {
            let pass = rows.iter().filter(|row| row.verdict == Verdict::Pass).count();
            write!(out, "Cases of **{pass}** of {} pass.", rows.len())
        }
        statuses => write!(out, "{} cited: {}.", run.requirements.len(), statuses.join(", ")),
    };
    let others: Vec<String> = rows
        .iter()
        .filter(|row| row.verdict != Verdict::Pass)
        .map(|row| format!("{} {}", sign(row.verdict), code(&row.id)))
        .collect();
    if !others.is_empty() {
        let more = others.len().saturating_sub(NAMED);
        let _ = write!(out, " Not: {}", others[..others.len() - more].join(", "));
        if more > 0 {
            let _ = write!(out, " and {more} more");
        }
        out.push('.');
    }
    out.push('\n');
    page.add(&out);
}

/// How many of the requirements that the cases cite came to what, the most frequent first: `**12** in part`.
fn statuses(run: &RunRecord) -> Vec<String> {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for fact in run.requirements.iter().filter(|fact| !fact.status.is_empty()) {
        *counts.entry(&fact.status).or_insert(0) += 1;
    }
    let mut counts: Vec<(&str, usize)> = counts.into_iter().collect();
    counts.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    counts.into_iter().map(|(status, count)| format!("**{count}** {status}")).collect()
}

fn environment(page: &mut BoundedText, run: &RunRecord) {
    let facts = &run.provenance;
    let mut out = String::from("\n<details><summary>Environment</summary>\n\n| | |\n| --- | --- |\n");
    for (name, value) in [
        ("rig", run.rig_version.as_str()),
        ("binary", &facts.binary_sha256),
        ("kernel", &facts.kernel),
        ("processor", facts.host_cpu.as_deref().unwrap_or_default()),
        ("profiles", &facts.profiles.join(" ")),
        ("command", &format!("rig {}", facts.arguments.join(" "))),
        ("started", facts.started.as_deref().unwrap_or_default()),
    ] {
        if !value.is_empty() {
            let _ = writeln!(out, "| {name} | {} |", code(value));
        }
    }
    for (name, value) in &facts.environment {
        let _ = writeln!(out, "| {} | {} |", code(name), code(value));
    }
    out.push_str("\n</details>\n");
    page.add(&out);
}

fn outcome(case: &CaseRecord) -> String {
    format!("{} {}", ShownOutcome::of(case).sign(), ShownOutcome::of(case).word())
}

/// A text as code in a line or in a cell of a table, not too long; nothing where it is empty.
fn code(text: &str) -> String {
    let text = clean(text.trim());
    if text.is_empty() {
        return String::new();
    }
    let text = brief::cut(&text, CELL).replace('|', "\\|");
    // The fence is longer than every run of its sign inside.
    let longest = text.split(|c| c != '`').map(str::len).max().unwrap_or(0);
    let fence = "`".repeat(longest + 1);
    let pad = if text.starts_with('`') || text.ends_with('`') { " " } else { "" };
    format!("{fence}{pad}{text}{pad}{fence}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use record::{ClaimRecord, Provenance};

    #[test]
    fn what_users_write_stays_code() {
        assert_eq!(code("a|b @all <b>"), "`a\\|b @all <b>`");
        assert_eq!(code("`x` ``y"), "``` `x` ``y ```");
        assert_eq!(code(" \n"), "");
    }

    #[test]
    fn a_summary_is_bounded_and_says_so() {
        let mut run = RunRecord::new("0.1.0", Provenance::default());
        for number in 0..500 {
            let claim = ClaimRecord {
                verdict: Verdict::Fail,
                expected: "long ".repeat(200),
                observed: "longer ".repeat(200),
                ..ClaimRecord::default()
            };
            run.push(CaseRecord {
                name: format!("case {number}"),
                verdict: if number == 499 { Verdict::Error } else { Verdict::Fail },
                claims: vec![claim; 40],
                ..CaseRecord::default()
            });
        }
        let text = render(&run);
        assert!(text.len() <= MAX_BYTES, "{}", text.len());
        // The worst comes first, and what is missing is said.
        let order = ["case 499", "case 0", "and 30 more claims", "The rest is left out"];
        let places = order.map(|part| text.find(part).unwrap_or_else(|| panic!("{part}: {text}")));
        assert!(places.is_sorted(), "{places:?}");
    }
}
