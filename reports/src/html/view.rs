//! What the template writes: the summary, and the cases that need attention with their reasons.

use crate::coverage::CoverageRow;
use crate::show::{self, ShownOutcome};
use record::{CaseRecord, ClaimRecord, MeasurementRecord, RunClock, RunRecord, Totals, Verdict};
use serde::Serialize;

/// The most cases that the summary lists; the script has them all.
const MOST_CASES: usize = 200;

/// The whole page without what the script draws.
#[derive(Serialize)]
pub(super) struct HtmlPage {
    verdict: &'static str,
    sign: &'static str,
    headline: String,
    /// What became of all cases, in a sentence.
    executed: String,
    counts: Vec<OutcomeCount>,
    facts: Vec<NamedFact>,
    attention: Vec<FailedCase>,
    /// Cases that need attention and found no room in the summary.
    unsaid: usize,
    coverage: Vec<CoverageRow>,
}

/// How many cases came to one outcome, with the stretch of the bar that stands for them.
#[derive(Serialize)]
struct OutcomeCount {
    word: &'static str,
    text: &'static str,
    sign: &'static str,
    n: u64,
    from: f64,
    width: f64,
}

/// A named fact; `full` is shown on request where `text` is shortened.
#[derive(Serialize)]
struct NamedFact {
    name: String,
    text: String,
    full: String,
    code: bool,
}

/// A case that did not pass.
#[derive(Serialize)]
struct FailedCase {
    word: &'static str,
    sign: &'static str,
    name: String,
    title: String,
    why: String,
    checks: Vec<FailedCheck>,
}

/// A claim or measurement of such a case that did not pass.
#[derive(Serialize)]
struct FailedCheck {
    word: &'static str,
    sign: &'static str,
    name: String,
    expected: String,
    observed: String,
    reason: String,
    margin: String,
    miss: String,
    writer: String,
    place: String,
}

impl HtmlPage {
    pub(super) fn of(run: &RunRecord) -> HtmlPage {
        let verdict = run.verdict();
        let (attention, unsaid) = attention(run);
        HtmlPage {
            verdict: verdict.word(),
            sign: show::sign(verdict),
            headline: headline(run),
            executed: executed(run),
            counts: counts(run.totals),
            facts: provenance(run),
            attention,
            unsaid,
            coverage: run.coverage.iter().map(CoverageRow::of).collect(),
        }
    }
}

fn headline(run: &RunRecord) -> String {
    let totals = run.totals;
    let judged = totals.judged();
    let of = |n: u64, what: &str| {
        format!("{n} of {judged} judged case{} {what}", if judged == 1 { "" } else { "s" })
    };
    match run.verdict() {
        Verdict::None => "Nothing was judged".to_owned(),
        Verdict::Pass if judged == 1 => "The one judged case passed".to_owned(),
        Verdict::Pass => format!("All {judged} judged cases passed"),
        Verdict::Inconclusive => of(totals.inconclusive, "inconclusive"),
        Verdict::Fail => of(totals.failed, "failed"),
        Verdict::Error if totals.failed > 0 => {
            format!("{}, {} failed", of(totals.errors, "with a fault of the rig itself"), totals.failed)
        }
        Verdict::Error => of(totals.errors, "with a fault of the rig itself"),
    }
}

/// A short list of results must not be read as a complete one: what was planned, and what was not executed.
fn executed(run: &RunRecord) -> String {
    let totals = run.totals;
    let there = totals.judged() + totals.skipped + totals.not_applicable;
    let planned = run.planned.max(there);
    let mut text = format!(
        "{planned} planned, {} executed, {} skipped, {} not applicable",
        totals.judged(),
        totals.skipped,
        totals.not_applicable
    );
    if planned > there {
        text.push_str(&format!(", {} without a record", planned - there));
    }
    text
}

fn counts(totals: Totals) -> Vec<OutcomeCount> {
    let judged = |verdict: Verdict| ShownOutcome::Judged(verdict);
    let errors = if totals.errors == 1 { "rig error" } else { "rig errors" };
    let all = [
        (judged(Verdict::Error), errors, totals.errors),
        (judged(Verdict::Fail), "failed", totals.failed),
        (judged(Verdict::Inconclusive), "inconclusive", totals.inconclusive),
        (judged(Verdict::None), "without verdict", totals.none),
        (judged(Verdict::Pass), "passed", totals.passed),
        (ShownOutcome::NotApplicable, "not applicable", totals.not_applicable),
        (ShownOutcome::Skipped, "skipped", totals.skipped),
    ];
    // The bar has 1000 units; whatever happened can be seen in it.
    const LEAST: f64 = 6.0;
    let sum = all.iter().map(|(.., n)| *n).sum::<u64>().max(1) as f64;
    let width = |n: u64| if n == 0 { 0.0 } else { LEAST.max(1000.0 * n as f64 / sum) };
    let scale = 1000.0 / all.iter().map(|(.., n)| width(*n)).sum::<f64>().max(1.0);
    let mut from = 0.0;
    let mut counts = Vec::new();
    for (outcome, text, n) in all {
        let width = width(n) * scale;
        if n > 0 {
            counts.push(OutcomeCount { word: outcome.word(), text, sign: outcome.sign(), n, from, width });
        }
        from += width;
    }
    counts
}

fn provenance(run: &RunRecord) -> Vec<NamedFact> {
    let p = &run.provenance;
    let plural = if p.profiles.len() > 1 { "Profiles" } else { "Profile" };
    let command =
        if p.arguments.is_empty() { String::new() } else { format!("rig {}", p.arguments.join(" ")) };
    let fact = |name: &str, full: String, code: bool| {
        let text = if name == "rig SHA-256" { full.chars().take(12).collect() } else { full.clone() };
        NamedFact { name: name.to_owned(), text, full, code }
    };
    let mut facts = vec![
        fact(plural, p.profiles.join(", "), false),
        fact("Clock", p.clock.word().to_owned(), false),
        fact("Rig timing", quality(run), false),
        fact("Part", part(run), false),
        fact("Guard bands", show::unguarded(run), false),
        fact("Seed", p.seed.to_string(), true),
        fact("Started", p.started.clone().unwrap_or_default(), false),
        fact("rig", run.rig_version.clone(), false),
        fact("rig SHA-256", p.binary_sha256.clone(), true),
        fact("Kernel", p.kernel.clone(), false),
        fact("Host", p.host_cpu.clone().unwrap_or_default(), false),
    ];
    facts.extend(p.environment.iter().map(|(name, text)| fact(name, text.clone(), false)));
    facts.push(fact("Command", command, true));
    facts.retain(|fact| !fact.full.is_empty());
    facts
}

/// A part of a suite that was spread over several machines is not the whole of it.
fn part(run: &RunRecord) -> String {
    run.shard.map_or(String::new(), |[part, of]| format!("{part} of {of}"))
}

/// How well the rig kept time on the host's clock, over all cases: what every figure of such a run depends on.
fn quality(run: &RunRecord) -> String {
    if run.provenance.clock == RunClock::Virtual {
        return String::new();
    }
    let timing = run.cases.iter().map(|case| &case.timing);
    let (late, overruns, dropped) = timing.fold((0, 0u64, 0u64), |(late, overruns, dropped), t| {
        (t.late_max_ns.max(late), overruns.saturating_add(t.overruns), dropped.saturating_add(t.dropped))
    });
    format!("at most {} late, {overruns} overruns, {dropped} events dropped", show::span(late))
}

/// The judged cases without a pass, the worst first, and how many more there are.
fn attention(run: &RunRecord) -> (Vec<FailedCase>, usize) {
    let mut bad: Vec<&CaseRecord> =
        run.cases.iter().filter(|case| case.is_judged() && case.verdict != Verdict::Pass).collect();
    bad.sort_by_key(|case| std::cmp::Reverse(case.verdict));
    let unsaid = bad.len().saturating_sub(MOST_CASES);
    (bad.into_iter().take(MOST_CASES).map(FailedCase::of).collect(), unsaid)
}

impl FailedCase {
    fn of(case: &CaseRecord) -> FailedCase {
        let outcome = ShownOutcome::of(case);
        let claims = case.claims.iter().filter(|claim| claim.verdict > Verdict::Pass);
        let measurements = case.measurements.iter().filter(|m| m.verdict > Verdict::Pass);
        FailedCase {
            word: outcome.word(),
            sign: outcome.sign(),
            name: case.name.clone(),
            title: case.title.clone(),
            why: show::reason(case).to_owned(),
            checks: claims
                .map(|claim| FailedCheck::claim(case, claim))
                .chain(measurements.map(|m| FailedCheck::measurement(case, m)))
                .collect(),
        }
    }
}

impl FailedCheck {
    fn claim(case: &CaseRecord, claim: &ClaimRecord) -> FailedCheck {
        FailedCheck {
            word: claim.verdict.word(),
            sign: show::sign(claim.verdict),
            name: claim.name.clone(),
            expected: if claim.expected == claim.name { String::new() } else { claim.expected.clone() },
            observed: claim.observed.clone(),
            reason: claim.reason.clone(),
            margin: claim.margin.as_ref().map_or(String::new(), ToString::to_string),
            miss: claim.nearest_miss.clone().unwrap_or_default(),
            writer: claim.last_writer.clone().unwrap_or_default(),
            place: place(claim.place_file.as_deref().unwrap_or(&case.plan), claim.line),
        }
    }

    fn measurement(case: &CaseRecord, measurement: &MeasurementRecord) -> FailedCheck {
        FailedCheck {
            word: measurement.verdict.word(),
            sign: show::sign(measurement.verdict),
            name: measurement.name.clone(),
            expected: show::limits(measurement),
            observed: show::covered(measurement),
            reason: measurement.reason.clone(),
            margin: measurement.margin.as_ref().map_or(String::new(), ToString::to_string),
            miss: String::new(),
            writer: String::new(),
            place: place(&case.plan, measurement.line),
        }
    }
}

fn place(file: &str, line: u32) -> String {
    if line == 0 { String::new() } else { format!("{file}:{line}") }
}
