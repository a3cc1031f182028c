//! What the template shows, in the words that it shows.

use crate::coverage::Row;
use crate::show::{self, Outcome};
use crate::svg;
use minijinja::value::Value;
use record::{CaseRecord, ClaimRecord, MeasurementRecord, RunRecord, Verdict};
use serde::Serialize;

/// The whole page.
#[derive(Serialize)]
pub(super) struct Page {
    style: Value,
    script: Value,
    verdict: &'static str,
    sign: &'static str,
    headline: String,
    counts: Vec<Count>,
    facts: Vec<Fact>,
    attention: Vec<Attention>,
    folders: Vec<Folder>,
    requirements: Vec<Requirement>,
    coverage: Vec<Row>,
}

/// How many cases came to one outcome.
#[derive(Serialize)]
struct Count {
    word: &'static str,
    text: &'static str,
    sign: &'static str,
    n: u64,
}

/// A named fact; `full` is shown on request where `text` is shortened.
#[derive(Serialize)]
struct Fact {
    name: &'static str,
    text: String,
    full: String,
    code: bool,
}

/// A case that did not pass, with the reason in one line.
#[derive(Serialize)]
struct Attention {
    number: usize,
    word: &'static str,
    sign: &'static str,
    name: String,
    why: String,
}

/// The cases of one folder of plans.
#[derive(Serialize)]
struct Folder {
    name: String,
    cases: Vec<Case>,
}

#[derive(Serialize)]
struct Case {
    number: usize,
    word: &'static str,
    sign: &'static str,
    name: String,
    title: String,
    reason: String,
    judged: bool,
    open: bool,
    modelled: String,
    margin: String,
    checks: String,
    proves: Vec<String>,
    parameters: Vec<Fact>,
    diagram: Option<Value>,
    claims: Vec<Claim>,
    measurements: Vec<Measurement>,
    steps: Vec<Step>,
    tasks: Vec<Task>,
    evidence: Vec<Fact>,
    log: Vec<Step>,
    log_dropped: u64,
}

#[derive(Serialize)]
struct Claim {
    number: usize,
    word: &'static str,
    sign: &'static str,
    name: String,
    verb: String,
    expected: String,
    observed: String,
    reason: String,
    margin: String,
    uncertainty: String,
    at: String,
    miss: String,
    writer: String,
    place: String,
}

#[derive(Serialize)]
struct Measurement {
    word: &'static str,
    sign: &'static str,
    name: String,
    value: String,
    limits: String,
    margin: String,
    reason: String,
    bar: Option<Value>,
}

#[derive(Serialize)]
struct Step {
    id: String,
    at: String,
    what: String,
}

#[derive(Serialize)]
struct Task {
    name: String,
    period: String,
    cycles: u64,
    min: String,
    mean: String,
    max: String,
    overruns: u64,
    watchdogs: u64,
}

#[derive(Serialize)]
struct Requirement {
    id: String,
    word: &'static str,
    sign: &'static str,
    cases: Vec<Attention>,
}

impl Page {
    pub(super) fn of(run: &RunRecord) -> Page {
        let totals = run.totals;
        let judged = |verdict: Verdict| Outcome::Judged(verdict);
        let counts = [
            (judged(Verdict::Pass), "passed", totals.passed),
            (judged(Verdict::Fail), "failed", totals.failed),
            (judged(Verdict::Inconclusive), "inconclusive", totals.inconclusive),
            (
                judged(Verdict::Error),
                if totals.errors == 1 { "rig error" } else { "rig errors" },
                totals.errors,
            ),
            (judged(Verdict::None), "without verdict", totals.none),
            (Outcome::NotApplicable, "not applicable", totals.not_applicable),
            (Outcome::Skipped, "skipped", totals.skipped),
        ];
        let always = [judged(Verdict::Pass), judged(Verdict::Fail), judged(Verdict::Inconclusive)];
        let counts = counts.into_iter().filter(|(outcome, _, n)| *n > 0 || always.contains(outcome));
        let verdict = run.verdict();
        Page {
            style: Value::from_safe_string(include_str!("page.css").to_owned()),
            script: Value::from_safe_string(include_str!("page.js").to_owned()),
            verdict: verdict.word(),
            sign: show::sign(verdict),
            headline: headline(run),
            counts: counts
                .map(|(outcome, text, n)| Count { word: outcome.word(), text, sign: outcome.sign(), n })
                .collect(),
            facts: provenance(run),
            attention: attention(run),
            folders: folders(run),
            requirements: requirements(run),
            coverage: run.coverage.iter().map(Row::of).collect(),
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
            format!("{}, {} failed", of(totals.errors, "with trouble of the rig itself"), totals.failed)
        }
        Verdict::Error => of(totals.errors, "with trouble of the rig itself"),
    }
}

fn provenance(run: &RunRecord) -> Vec<Fact> {
    let p = &run.provenance;
    let plural = if p.profiles.len() > 1 { "Profiles" } else { "Profile" };
    facts([
        (plural, p.profiles.join(", "), false),
        ("Clock", p.clock.word().to_owned(), false),
        ("Seed", p.seed.to_string(), true),
        ("Started", p.started.clone().unwrap_or_default(), false),
        ("rig", run.rig_version.clone(), false),
        ("rig SHA-256", p.binary_sha256.clone(), true),
        ("Kernel", p.kernel.clone(), false),
        ("Host", p.host_cpu.clone().unwrap_or_default(), false),
        (
            "Command",
            if p.arguments.is_empty() { String::new() } else { format!("rig {}", p.arguments.join(" ")) },
            true,
        ),
    ])
}

/// Facts that are not empty; digests are shortened to twelve digits.
fn facts<const N: usize>(all: [(&'static str, String, bool); N]) -> Vec<Fact> {
    let shorten = |name: &str, text: &str| match name.contains("SHA-256") || name == "Trace" {
        true => text.chars().take(12).collect(),
        false => text.to_owned(),
    };
    let all = all.into_iter().filter(|(_, text, _)| !text.is_empty());
    all.map(|(name, full, code)| Fact { name, text: shorten(name, &full), full, code }).collect()
}

fn attention(run: &RunRecord) -> Vec<Attention> {
    let mut rows: Vec<(Verdict, Attention)> = Vec::new();
    for (place, case) in run.cases.iter().enumerate() {
        if !case.is_judged() || case.verdict == Verdict::Pass {
            continue;
        }
        let claim = case.claims.iter().find(|c| c.verdict == case.verdict);
        let measurement = case.measurements.iter().find(|m| m.verdict == case.verdict);
        let why = match (claim, measurement) {
            (Some(c), _) if !c.observed.is_empty() => format!("{}: {}", c.name, c.observed),
            (Some(c), _) => format!("{}: {}", c.name, c.reason),
            (None, Some(m)) => format!("{}: {} (limits {})", m.name, show::value(m), show::limits(m)),
            (None, None) => case.reason.clone(),
        };
        rows.push((case.verdict, Attention { why, ..link(place, case) }));
    }
    rows.sort_by_key(|(verdict, row)| (std::cmp::Reverse(*verdict), row.number));
    rows.into_iter().map(|(_, row)| row).collect()
}

fn link(place: usize, case: &CaseRecord) -> Attention {
    let outcome = Outcome::of(case);
    let why = show::reason(case).to_owned();
    Attention { number: place + 1, word: outcome.word(), sign: outcome.sign(), name: case.name.clone(), why }
}

fn folders(run: &RunRecord) -> Vec<Folder> {
    let mut folders: Vec<Folder> = Vec::new();
    for (place, case) in run.cases.iter().enumerate() {
        let name = case.folder();
        let view = Case::of(place + 1, case, run.cases.len() == 1);
        match folders.iter_mut().find(|folder| folder.name == name) {
            Some(folder) => folder.cases.push(view),
            None => folders.push(Folder { name: name.to_owned(), cases: vec![view] }),
        }
    }
    folders
}

fn requirements(run: &RunRecord) -> Vec<Requirement> {
    let row = |row: crate::RequirementRow| Requirement {
        id: row.id,
        word: row.verdict.word(),
        sign: show::sign(row.verdict),
        cases: row.cases.iter().map(|&place| link(place, &run.cases[place])).collect(),
    };
    crate::requirements(run).into_iter().map(row).collect()
}

impl Case {
    fn of(number: usize, case: &CaseRecord, alone: bool) -> Case {
        let outcome = Outcome::of(case);
        let bad = case.is_judged() && case.verdict >= Verdict::Inconclusive;
        let checks = case.claims.len() + case.measurements.len();
        let passed = case.claims.iter().filter(|c| c.verdict == Verdict::Pass).count()
            + case.measurements.iter().filter(|m| m.verdict == Verdict::Pass).count();
        let parameter = |p: &record::Parameter| format!("{} = {}", p.name, p.value);
        let parameters = case.parameters.iter().map(parameter).collect::<Vec<_>>().join(", ");
        Case {
            number,
            word: outcome.word(),
            sign: outcome.sign(),
            name: case.name.clone(),
            title: case.title.clone(),
            reason: show::reason(case).to_owned(),
            judged: case.is_judged(),
            open: bad || alone,
            modelled: if case.is_judged() {
                show::span(case.duration_ns / 1_000_000 * 1_000_000)
            } else {
                String::new()
            },
            margin: tightest(case),
            checks: if case.is_judged() { format!("{passed}/{checks}") } else { String::new() },
            proves: case.proves.clone(),
            parameters: facts([("Parameters", parameters, true)]),
            diagram: svg::diagram(case, number).map(Value::from_safe_string),
            claims: case
                .claims
                .iter()
                .enumerate()
                .map(|(at, claim)| Claim::of(at + 1, case, claim))
                .collect(),
            measurements: case.measurements.iter().map(Measurement::of).collect(),
            steps: steps(case),
            tasks: tasks(case),
            evidence: evidence(case),
            log: case
                .log
                .iter()
                .map(|line| Step {
                    id: String::new(),
                    at: show::relative([line.at_ns; 2], case.start_ns),
                    what: line.text.clone(),
                })
                .collect(),
            log_dropped: case.log_dropped,
        }
    }
}

/// The least margin of the case in time: how near it came to another verdict.
fn tightest(case: &CaseRecord) -> String {
    let margins = case.claims.iter().filter_map(|c| c.margin.as_ref());
    let margins = margins.chain(case.measurements.iter().filter_map(|m| m.margin.as_ref()));
    let spans = margins.filter_map(record::Figure::as_span);
    spans.min().map_or(String::new(), |span| span.to_string())
}

/// What was expected, where the claim's name does not say it already.
fn own_words(claim: &ClaimRecord) -> String {
    if claim.expected == claim.name { String::new() } else { claim.expected.clone() }
}

impl Claim {
    fn of(number: usize, case: &CaseRecord, claim: &ClaimRecord) -> Claim {
        let place = match (case.plan.as_str(), claim.line) {
            ("", _) | (_, 0) => String::new(),
            (plan, line) => format!("{plan}:{line}"),
        };
        Claim {
            number,
            word: claim.verdict.word(),
            sign: show::sign(claim.verdict),
            name: claim.name.clone(),
            verb: claim.verb.clone(),
            expected: own_words(claim),
            observed: claim.observed.clone(),
            reason: claim.reason.clone(),
            margin: claim.margin.as_ref().map_or(String::new(), ToString::to_string),
            uncertainty: claim.uncertainty.as_ref().map_or(String::new(), ToString::to_string),
            at: claim.deciding_ns.map_or(String::new(), |at| show::relative(at, case.start_ns)),
            miss: claim.nearest_miss.clone().unwrap_or_default(),
            writer: claim.last_writer.clone().unwrap_or_default(),
            place,
        }
    }
}

impl Measurement {
    fn of(measurement: &MeasurementRecord) -> Measurement {
        Measurement {
            word: measurement.verdict.word(),
            sign: show::sign(measurement.verdict),
            name: measurement.name.clone(),
            value: show::value(measurement),
            limits: show::limits(measurement),
            margin: measurement.margin.as_ref().map_or(String::new(), ToString::to_string),
            reason: measurement.reason.clone(),
            bar: svg::limit_bar(measurement).map(Value::from_safe_string),
        }
    }
}

fn steps(case: &CaseRecord) -> Vec<Step> {
    let at =
        |at: Option<[i64; 2]>| at.map_or("never came".to_owned(), |at| show::relative(at, case.start_ns));
    case.steps.iter().map(|s| Step { id: s.id.clone(), at: at(s.at_ns), what: s.what.clone() }).collect()
}

fn tasks(case: &CaseRecord) -> Vec<Task> {
    let task = |t: &record::TaskFigures| Task {
        name: t.name.clone(),
        period: if t.period_ns > 0 { show::span(t.period_ns) } else { "–".to_owned() },
        cycles: t.cycles,
        min: show::span(t.cycle_min_ns),
        mean: show::span(t.cycle_mean_ns),
        max: show::span(t.cycle_max_ns),
        overruns: t.overruns,
        watchdogs: t.watchdogs,
    };
    case.tasks.iter().map(task).collect()
}

fn evidence(case: &CaseRecord) -> Vec<Fact> {
    let timing = case.timing;
    let rig = if timing == record::RigTiming::default() {
        String::new()
    } else {
        format!(
            "latest {}, {} overruns, {} events dropped, horizon {}",
            show::span(timing.late_max_ns),
            timing.overruns,
            timing.dropped,
            show::span(timing.horizon_ns)
        )
    };
    facts([
        ("Plan", case.plan.clone(), true),
        ("Profile", case.profile.clone(), false),
        ("Reference", case.reference.clone(), false),
        ("Seed", case.seed.to_string(), true),
        ("Host time", format!("{} ms", case.host_ms), false),
        ("Rig timing", rig, false),
        ("Plan SHA-256", case.hashes.plan.clone(), true),
        ("Board SHA-256", case.hashes.board.clone(), true),
        ("Program SHA-256", case.hashes.program.clone(), true),
        ("Trace SHA-256", case.trace_sha256.clone(), true),
        ("Trace file", case.trace_file.clone().unwrap_or_default(), true),
    ])
}
