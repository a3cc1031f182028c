//! Parts of a suite, put together to the run that they are parts of.

use super::waves;
use crate::requirements;
use crate::saved_runs::SavedRun;
use crate::saved_runs::report_folder::ReportFolder;
use document::Diagnostic;
use record::{CaseRecord, Provenance, RunRecord};
use runtime::application::coverage::CoverageTotal;
use std::path::{Path, PathBuf};

/// The whole, whose traces are still where the parts left them.
#[derive(Debug)]
pub(super) struct MergedRun {
    run: RunRecord,
    /// The folder of each case.
    folders: Vec<PathBuf>,
}

/// Puts parts together. The cases come in the order in which one machine would have run them.
///
/// # Errors
/// What keeps the runs from being the parts of one suite, all of it.
pub(super) fn merge(mut parts: Vec<SavedRun>) -> Result<MergedRun, Vec<Diagnostic>> {
    let mut found = parts_of_other_runs(&parts);
    if found.is_empty() {
        found = places(&parts);
    }
    if !found.is_empty() {
        return Err(found);
    }
    parts.sort_by_key(|part| part.record.shard);
    let count = parts.iter().map(|part| part.record.cases.len()).sum::<usize>();
    let Some(first) = parts.first() else { return Err(Vec::new()) };
    let mut whole = MergedRun {
        run: RunRecord {
            shard: None,
            planned: parts.iter().map(|part| part.record.planned).sum(),
            host_ms: parts.iter().map(|part| part.record.host_ms).max().unwrap_or(0),
            selection_sha256: first.record.selection_sha256.clone(),
            ..RunRecord::new(first.record.rig_version.clone(), provenance(&parts))
        },
        folders: Vec::with_capacity(count),
    };
    let mut coverage = CoverageTotal::default();
    for part in &parts {
        if !coverage.add_part(&part.record.coverage) {
            let message = format!("the coverage of `{}` lacks its statements", part.name);
            return Err(vec![Diagnostic::error("R0162", message).help("run the part again with this rig")]);
        }
    }
    whole.run.coverage = coverage.record();
    let mut queues: Vec<_> =
        parts.into_iter().map(|part| (part.folder, part.record.cases.into_iter())).collect();
    // Round the parts, as they were dealt.
    let of = queues.len();
    for place in 0..count {
        let (folder, cases) = &mut queues[place % of];
        if let Some(case) = cases.next() {
            whole.run.push(case);
            whole.folders.push(folder.clone());
        }
    }
    whole.run.requirements = requirements::facts(&whole.run);
    match whole.run.check() {
        Ok(()) => Ok(whole),
        Err(error) => Err(vec![Diagnostic::error(error.code(), format!("the parts together: {error}"))]),
    }
}

/// Runs that are no parts, or of another suite than the first.
fn parts_of_other_runs(parts: &[SavedRun]) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    for part in parts.iter().filter(|part| part.record.shard.is_none()) {
        found.push(
            Diagnostic::error("R0165", format!("`{}` is not a part of a suite", part.name))
                .help("parts are what `rig test --shard K/N` ran"),
        );
    }
    let Some(first) = parts.first().filter(|_| found.is_empty()) else { return found };
    let known = facts(first);
    for part in &parts[1..] {
        let others: Vec<String> = facts(part)
            .iter()
            .zip(&known)
            .filter(|((_, own), (_, wanted))| own != wanted)
            .map(|((name, own), (_, wanted))| format!("{name} is {own} and not {wanted}"))
            .collect();
        if !others.is_empty() {
            found.push(
                Diagnostic::error(
                    "R0162",
                    format!(
                        "`{}` is of another suite than `{}`: {}",
                        part.name,
                        first.name,
                        others.join(", ")
                    ),
                )
                .help("run all parts with one build of rig, one seed and the same files and options"),
            );
        }
    }
    found
}

/// What parts of one suite have in common.
fn facts(part: &SavedRun) -> Vec<(&'static str, String)> {
    let RunRecord { rig_version, provenance, shard, selection_sha256, .. } = &part.record;
    let short = |hash: &str| hash.get(..12).unwrap_or("unknown").to_owned();
    vec![
        ("the version of rig", rig_version.clone()),
        ("the build of rig", short(&provenance.binary_sha256)),
        ("the seed", provenance.seed.to_string()),
        ("the clock", provenance.clock.word().to_owned()),
        ("the number of parts", shard.map_or(0, |[_, of]| of).to_string()),
        ("the selection", short(selection_sha256)),
    ]
}

/// Parts that are missing, given twice, or not of the size that they must have.
fn places(parts: &[SavedRun]) -> Vec<Diagnostic> {
    let of = parts.first().and_then(|part| part.record.shard).map_or(0, |[_, of]| of);
    let mut found = Vec::new();
    let mut missing = Vec::new();
    for number in 1..=of {
        let mine: Vec<&SavedRun> =
            parts.iter().filter(|part| part.record.shard.is_some_and(|[own, _]| own == number)).collect();
        match mine.as_slice() {
            [] if missing.len() < 20 => missing.push(format!("{number}/{of}")),
            [] | [_] => {}
            [one, two, ..] => found.push(
                Diagnostic::error(
                    "R0164",
                    format!("`{}` and `{}` are both part {number}/{of}", one.name, two.name),
                )
                .help("give each part once"),
            ),
        }
    }
    if !missing.is_empty() {
        found.push(
            Diagnostic::error("R0163", format!("the parts {} are missing", missing.join(", ")))
                .help("give every part; run again those that are lost"),
        );
    }
    if found.is_empty() {
        found = parts.iter().filter_map(|part| size(part, parts)).collect();
    }
    found
}

/// A part that lost cases, or has more than were planned.
fn size(part: &SavedRun, parts: &[SavedRun]) -> Option<Diagnostic> {
    let count = |part: &SavedRun| part.record.cases.len();
    let [number, of] = part.record.shard.unwrap_or([1, 1]).map(|n| n as usize);
    let all = parts.iter().map(count).sum::<usize>();
    let (has, share, planned) = (count(part), (all + of - number) / of, part.record.planned);
    (has != share || has as u64 != planned).then(|| {
        let message = format!(
            "`{}` has {has} cases; it planned {planned}, and of {all} its part is {share}",
            part.name
        );
        Diagnostic::error("R0162", message).help("run the part again: its record was cut or edited")
    })
}

/// Texts, each once.
fn listed(facts: impl IntoIterator<Item = String>) -> String {
    let mut seen: Vec<String> = Vec::new();
    for fact in facts {
        if !fact.is_empty() && !seen.contains(&fact) {
            seen.push(fact);
        }
    }
    seen.join("; ")
}

/// Facts of the hosts, those of one name together.
fn environment(parts: &[SavedRun]) -> Vec<(String, String)> {
    let facts = || parts.iter().flat_map(|part| &part.record.provenance.environment);
    let mut all: Vec<(String, String)> = Vec::new();
    for (name, _) in facts() {
        if all.iter().all(|(known, _)| known != name) {
            let values = facts().filter(|(other, _)| other == name).map(|(_, value)| value.clone());
            all.push((name.clone(), listed(values)));
        }
    }
    all
}

/// Where the whole came from: what the hosts differ in is listed.
fn provenance(parts: &[SavedRun]) -> Provenance {
    let all = || parts.iter().map(|part| &part.record.provenance);
    let cpus = listed(all().filter_map(|facts| facts.host_cpu.clone()));
    let first = all().next().cloned().unwrap_or_default();
    Provenance {
        kernel: listed(all().map(|facts| facts.kernel.clone())),
        host_cpu: (!cpus.is_empty()).then_some(cpus),
        arguments: without_shard(&first.arguments),
        started: all().filter_map(|facts| facts.started.clone()).min(),
        // In the order of their first use, as the cases are pushed.
        profiles: Vec::new(),
        environment: environment(parts),
        ..first
    }
}

/// A command line without `--shard`.
fn without_shard(arguments: &[String]) -> Vec<String> {
    let mut kept = Vec::new();
    let mut rest = arguments.iter();
    while let Some(argument) = rest.next() {
        if argument == "--shard" {
            rest.next();
        } else if !argument.starts_with("--shard=") {
            kept.push(argument.clone());
        }
    }
    kept
}

impl MergedRun {
    /// Copies the traces, and hands the record on with their new places.
    ///
    /// # Errors
    /// Traces that are not there; a folder that cannot be written.
    pub(super) fn adopt(mut self, store: &mut ReportFolder) -> Result<RunRecord, Vec<Diagnostic>> {
        let has_trace = |case: &CaseRecord| case.trace_file.is_some();
        if self.run.cases.iter().any(has_trace) {
            store.traces().map_err(super::unwritten)?;
        }
        let mut lost = Vec::new();
        for (case, folder) in self.run.cases.iter_mut().zip(&self.folders) {
            if !has_trace(case) {
                continue;
            }
            match adopt(case, folder, store) {
                Ok(path) => case.trace_file = Some(path),
                Err(why) => lost.push(format!("{}: {why}", case.name)),
            }
        }
        waves::finding(&lost).map_or(Ok(self.run), |found| Err(vec![found]))
    }
}

fn adopt(case: &CaseRecord, folder: &Path, store: &mut ReportFolder) -> Result<String, String> {
    store.adopt(case, &waves::path(folder, case)?)
}
