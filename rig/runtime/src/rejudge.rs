//! Verdicts again from a recorded trace alone.

use crate::case::verdict;
use crate::describe;
use document::{Diagnostic, SourceFile};
use plans::judge::Judge;
use record::CaseRecord;
use signal::{Time, Trace, When};

/// Judges a trace by its plan: the same verdicts as in the run that recorded it.
///
/// # Errors
/// Findings in the plan; a trace that is of no case of this plan.
pub fn judge(plan: &SourceFile, trace: &Trace) -> Result<CaseRecord, Vec<Diagnostic>> {
    let note = |key: &str| trace.note(key).unwrap_or_default();
    let seed = note("seed").parse().unwrap_or(1);
    let parameters: Vec<(String, String)> = trace
        .notes()
        .filter_map(|(key, value)| Some((key.strip_prefix("given:")?.to_owned(), value.to_owned())))
        .collect();
    // The cases are named by the plan's path, which may be another here than where the trace was recorded.
    let same = SourceFile::new(note("plan"), plan.text.clone());
    let read = plans::read(&same, &parameters, seed).map_err(|mut found| {
        for label in found.iter_mut().flat_map(|one| &mut one.labels) {
            label.file.clone_from(&plan.name);
        }
        found
    })?;
    let name = note("plan-case");
    let Some(case) = read.cases().find(|case| case.name == name) else {
        let message = format!("the trace is of the case `{name}`, which {} does not have", plan.name);
        return Err(vec![
            Diagnostic::error("R0203", message).help("judge it by the plan that it was recorded with"),
        ]);
    };
    let mut record = CaseRecord {
        name: note("case").to_owned(),
        plan: plan.name.clone(),
        title: case.title.clone(),
        proves: case.proves.clone(),
        profile: note("profile").to_owned(),
        reference: note("reference").to_owned(),
        seed,
        trace_sha256: describe::hex(&trace.digest()),
        ..CaseRecord::default()
    };
    let mut end = Time::ZERO;
    for (mark, place) in [("step:start", 0), ("step:end", 1)] {
        let last = trace.find(mark).and_then(|signal| trace.last(signal));
        let Some(event) = last else { continue };
        let at = event.at.earliest;
        if place == 0 {
            record.start_ns = at.as_nanos();
        } else {
            end = at;
        }
    }
    record.end_ns = end.as_nanos();
    record.duration_ns = record.end_ns;
    let judge = Judge::new(case.scenario(), trace.signals())?;
    let outcome = judge.replay(When::exactly(end), trace).map_err(|error| error.to_string());
    verdict(&mut record, outcome, trace);
    let changed = trace.note("plan-sha256") != Some(describe::sha256(plan.text.as_bytes()).as_str());
    if changed {
        let reason = format!("{} (the plan has changed since the trace was recorded)", record.reason);
        record.reason = reason.trim().to_owned();
    }
    Ok(record)
}
