//! What changed between two runs: verdicts, margins, measured values, what the runs were made from.

mod claims;
#[cfg(test)]
mod tests;

use crate::{CaseRecord, CaseStatus, Figure, Hashes, RunRecord, Verdict};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// Version of the shape of a [`Comparison`] in JSON.
pub const COMPARISON_FORMAT: u32 = 1;

/// What counts as worse.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thresholds {
    /// A margin has eroded when it lost more than this part of what it was, in percent.
    pub erosion_percent: f64,
    /// Whether a case or claim that was judged may be missing.
    pub allow_missing: bool,
}

impl Default for Thresholds {
    fn default() -> Self {
        Thresholds { erosion_percent: 10.0, allow_missing: false }
    }
}

/// Something that was one text and is another; empty for nothing.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct TextChange {
    /// What.
    pub what: String,
    /// In the earlier run.
    pub old: String,
    /// In the later run.
    pub new: String,
}

/// A case that came to something else.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct CaseChange {
    /// Its name.
    pub name: String,
    /// What it came to in the earlier run: a verdict, `skipped`, `not-applicable`; nothing where it was not there.
    pub old: Option<&'static str>,
    /// The same of the later run.
    pub new: Option<&'static str>,
    /// Whether that is worse: evidence that is lost, too.
    pub worse: bool,
    /// Why it came to that in the later run, or in the earlier one where it is missing; may be empty.
    pub reason: String,
}

/// A claim or measurement that was there in a case and is not, or the reverse.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ClaimChange {
    /// The case.
    pub case: String,
    /// The claim's name.
    pub name: String,
    /// Whether it is missing in the later run; otherwise it is new.
    pub missing: bool,
}

/// A margin that eroded.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Erosion {
    /// The case.
    pub case: String,
    /// The claim's or measurement's name.
    pub name: String,
    /// In the earlier run.
    pub old: Figure,
    /// In the later run.
    pub new: Figure,
    /// How much of the earlier one is lost, percent.
    pub lost_percent: f64,
}

/// A measured value that moved: no value could have been measured in both runs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Move {
    /// The case.
    pub case: String,
    /// The measurement's name.
    pub name: String,
    /// `[low, high]` in the earlier run.
    pub old: [f64; 2],
    /// `[low, high]` in the later run.
    pub new: [f64; 2],
    /// Unit of both.
    pub unit: String,
}

/// A measurement whose limits have another guard band, or whose verdict the middle of its value alone decides in one of the runs.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct GuardChange {
    /// The case.
    pub case: String,
    /// The measurement's name.
    pub name: String,
    /// In the earlier run: `uncertainty`, `none`, or `none, by its middle`.
    pub old: &'static str,
    /// In the later run.
    pub new: &'static str,
    /// Whether a pass that was proven is accepted by its middle, since the guard band is gone.
    pub worse: bool,
}

/// What changed between two runs. Every list is in the order of the cases of the earlier run, then of the later one.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// [`COMPARISON_FORMAT`].
    pub format: u32,
    /// Whether anything got worse.
    pub worse: bool,
    /// Facts of the runs that differ: versions, hosts, seeds.
    pub facts: Vec<TextChange>,
    /// Plans whose files differ: the plan itself, its board, its program, the capture that was judged, the file of its instrument.
    pub files: Vec<TextChange>,
    /// Cases that came to something else, are missing or new.
    pub cases: Vec<CaseChange>,
    /// Claims and measurements of cases in both runs that are missing or new.
    pub claims: Vec<ClaimChange>,
    /// Margins that eroded, of claims that passed in both runs.
    pub eroded: Vec<Erosion>,
    /// Measured values that moved.
    pub moved: Vec<Move>,
    /// Measurements with another guard band.
    pub guards: Vec<GuardChange>,
    /// Cases whose traces differ though all files, parameters, seed and build of rig are the same. In virtual time
    /// there are none.
    pub traces: Vec<String>,
    /// Cases that are in both runs and came to the same.
    pub same: u64,
}

/// Compares two runs.
pub fn compare(old: &RunRecord, new: &RunRecord, thresholds: &Thresholds) -> Comparison {
    let mut found = Comparison {
        format: COMPARISON_FORMAT,
        worse: false,
        facts: facts(old, new),
        files: files(old, new),
        cases: Vec::new(),
        claims: Vec::new(),
        eroded: Vec::new(),
        moved: Vec::new(),
        guards: Vec::new(),
        traces: Vec::new(),
        same: 0,
    };
    let named = |run: &'_ RunRecord| -> BTreeMap<String, usize> {
        run.cases.iter().enumerate().map(|(place, case)| (case.name.clone(), place)).collect()
    };
    let (before, after) = (named(old), named(new));
    let one_build = !old.provenance.binary_sha256.is_empty()
        && old.provenance.binary_sha256 == new.provenance.binary_sha256;
    for was in &old.cases {
        let Some(is) = after.get(&was.name).and_then(|place| new.cases.get(*place)) else {
            found.cases.push(CaseChange {
                name: was.name.clone(),
                old: Some(word(was)),
                new: None,
                worse: was.is_judged() && !thresholds.allow_missing,
                reason: reason(was).to_owned(),
            });
            continue;
        };
        if word(was) == word(is) {
            found.same += 1;
        } else {
            found.cases.push(CaseChange {
                name: was.name.clone(),
                old: Some(word(was)),
                new: Some(word(is)),
                worse: rank(is) > rank(was),
                reason: reason(is).to_owned(),
            });
        }
        claims::compare(was, is, thresholds, &mut found);
        let made_from =
            |case: &'_ CaseRecord| (case.seed, hashes(case).map(str::to_owned), case.parameters.clone());
        // How a capture is laid out the command line says: which channel is what, where the start lies.
        let laid_alike =
            was.hashes.capture.is_empty() || old.provenance.arguments == new.provenance.arguments;
        let alike = one_build && laid_alike && made_from(was) == made_from(is);
        if alike && was.trace_sha256 != is.trace_sha256 {
            found.traces.push(was.name.clone());
        }
    }
    for is in new.cases.iter().filter(|case| !before.contains_key(&case.name)) {
        found.cases.push(CaseChange {
            name: is.name.clone(),
            old: None,
            new: Some(word(is)),
            worse: is.is_judged() && is.verdict > Verdict::Pass,
            reason: reason(is).to_owned(),
        });
    }
    let lost = found.claims.iter().any(|claim| claim.missing) && !thresholds.allow_missing;
    found.worse = lost
        || !found.eroded.is_empty()
        || found.cases.iter().any(|case| case.worse)
        || found.guards.iter().any(|guard| guard.worse);
    found
}

/// What a case came to.
const fn word(case: &CaseRecord) -> &'static str {
    match case.status {
        CaseStatus::Judged => case.verdict.word(),
        CaseStatus::NotApplicable { .. } => "not-applicable",
        CaseStatus::Skipped { .. } => "skipped",
    }
}

fn reason(case: &CaseRecord) -> &str {
    match &case.status {
        CaseStatus::Judged => &case.reason,
        CaseStatus::NotApplicable { reason } | CaseStatus::Skipped { reason } => reason,
    }
}

/// How bad that is: without a verdict there is no evidence, which is worse than a pass and no fault yet.
fn rank(case: &CaseRecord) -> Verdict {
    match (&case.status, case.verdict) {
        (CaseStatus::Judged, Verdict::Pass) => Verdict::None,
        (CaseStatus::Judged, verdict) => verdict.max(Verdict::Pass),
        _ => Verdict::Pass,
    }
}

fn facts(old: &RunRecord, new: &RunRecord) -> Vec<TextChange> {
    let mut known: Vec<(&str, String, String)> = Vec::new();
    let mut add = |what, of: &dyn Fn(&RunRecord) -> String| known.push((what, of(old), of(new)));
    add("version of rig", &|run| run.rig_version.clone());
    add("build of rig", &|run| run.provenance.binary_sha256.clone());
    add("kernel", &|run| run.provenance.kernel.clone());
    add("processor", &|run| run.provenance.host_cpu.clone().unwrap_or_default());
    add("clock", &|run| run.provenance.clock.word().to_owned());
    add("seed", &|run| run.provenance.seed.to_string());
    add("profiles", &|run| run.provenance.profiles.join(" "));
    add("arguments", &|run| run.provenance.arguments.join(" "));
    add("part", &|run| run.shard.map_or(String::new(), |[part, of]| format!("{part}/{of}")));
    let names = [old, new].into_iter().flat_map(|run| &run.provenance.environment).map(|(name, _)| name);
    for name in names.collect::<BTreeSet<&String>>() {
        add(name, &|run| {
            let fact = run.provenance.environment.iter().find(|(known, _)| known == name);
            fact.map_or(String::new(), |(_, value)| value.clone())
        });
    }
    let differ = known.into_iter().filter(|(_, old, new)| old != new);
    differ.map(|(what, old, new)| TextChange { what: what.to_owned(), old, new }).collect()
}

/// What [`hashes`] are of.
const FILES: [&str; 5] = ["plan", "board", "program", "capture", "instrument"];

/// Of the files that a case was made from, and a capture judged with.
fn hashes(case: &CaseRecord) -> [&str; 5] {
    let Hashes { plan, board, program, capture } = &case.hashes;
    let instrument = case.instrument.as_ref().map_or("", |instrument| instrument.sha256.as_str());
    [plan, board, program, capture, instrument]
}

/// Of each plan in both runs, which of its files changed.
fn files(old: &RunRecord, new: &RunRecord) -> Vec<TextChange> {
    type Sets<'a> = BTreeMap<&'a str, [BTreeSet<&'a str>; 5]>;
    fn of(run: &RunRecord) -> Sets<'_> {
        let mut all = Sets::new();
        for case in run.cases.iter().filter(|case| !case.hashes.plan.is_empty()) {
            let sets = all.entry(case.plan.as_str()).or_default();
            for (set, hash) in sets.iter_mut().zip(hashes(case)) {
                set.insert(hash);
            }
        }
        all
    }
    let (before, after) = (of(old), of(new));
    let mut changes = Vec::new();
    for (plan, was) in &before {
        let Some(is) = after.get(plan) else { continue };
        for ((kind, was), is) in FILES.into_iter().zip(was).zip(is) {
            if was != is {
                let list = |set: &BTreeSet<&str>| set.iter().copied().collect::<Vec<&str>>().join(" ");
                changes.push(TextChange { what: format!("{kind} of {plan}"), old: list(was), new: list(is) });
            }
        }
    }
    changes
}
