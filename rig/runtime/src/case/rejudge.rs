//! Verdicts again from a recorded trace alone.

use crate::case::capture_import::{INSTRUMENT_NOTE, INSTRUMENT_TEXT_NOTE};
use crate::case::{lanes, verdict};
use crate::codes;
use crate::schedule::case_ending::CaseEnding;
use crate::suite::{board_instrument, describe, instrument_file};
use document::{Diagnostic, SourceFile};
use plans::judge::CaseJudge;
use plans::plan::{GlobalChecks, PlanText};
use record::{CaseRecord, StepRecord};
use signal::{SignalId, Time, Trace, ValueKind, When};

/// Judges a trace by its plan, which names no tables: the same verdicts as in the run that recorded it.
///
/// # Errors
/// Findings in the plan; a trace that is of no case of this plan.
pub fn judge(plan: &SourceFile, trace: &Trace) -> Result<CaseRecord, Vec<Diagnostic>> {
    judge_gathered(&plans::gather(plan, &mut |_| Err(String::from("no files can be included here")))?, trace)
}

/// Judges a trace by its plan with what it includes: the same verdicts as in the run that recorded it.
///
/// # Errors
/// Findings in the plan; a trace that is of no case of this plan.
pub fn judge_gathered(text: &PlanText, trace: &Trace) -> Result<CaseRecord, Vec<Diagnostic>> {
    let plan = text.file();
    let note = |key: &str| trace.note(key).unwrap_or_default();
    let seed = note("seed").parse().unwrap_or(1);
    let parameters: Vec<(String, String)> = trace
        .notes()
        .filter_map(|(key, value)| Some((key.strip_prefix("given:")?.to_owned(), value.to_owned())))
        .collect();
    // The cases are named by the plan's path, which may be another here than where the trace was recorded.
    let same = text.clone().named(note("plan"));
    let read = plans::read_gathered(&same, &parameters, seed).map_err(|mut found| {
        let labels = found.iter_mut().flat_map(|one| &mut one.labels);
        for label in labels.filter(|label| label.file == same.file().name) {
            label.file.clone_from(&plan.name);
        }
        found
    })?;
    let name = note("plan-case");
    let Some(mut case) = read.cases().find(|case| case.name == name) else {
        let message = format!("the trace is of the case `{name}`, which {} does not have", plan.name);
        return Err(vec![
            Diagnostic::error(codes::TRACE_OF_ANOTHER_PLAN, message)
                .help("judge it by the plan that it was recorded with"),
        ]);
    };
    for guards in guards_of(trace)? {
        guards.attach(&mut case)?;
    }
    let mut record = CaseRecord {
        name: note("case").to_owned(),
        plan: plan.name.clone(),
        title: case.title.clone(),
        proves: case.proves.clone(),
        tags: case.tags.clone(),
        profile: note("profile").to_owned(),
        reference: note("reference").to_owned(),
        model: note("model").to_owned(),
        instrument: match (trace.note(INSTRUMENT_NOTE), trace.note(INSTRUMENT_TEXT_NOTE)) {
            (Some(file), Some(text)) => Some(instrument_file::read(&SourceFile::new(file, text))?.record()),
            _ => board_instrument::read_from(trace),
        },
        hashes: describe::hashes_again(read.joined(), trace),
        seed,
        trace_sha256: describe::hex(&trace.digest()),
        ..CaseRecord::default()
    };
    let mut end = Time::ZERO;
    let mut closed = Time::ZERO;
    for (mark, place) in [("step:start", 0), ("step:end", 1), ("step:teardown.done", 2)] {
        let last = trace.find(mark).and_then(|signal| trace.last(signal));
        let Some(event) = last else { continue };
        let at = event.at.earliest;
        match place {
            0 => record.start_ns = at.as_nanos(),
            1 => end = at,
            _ => closed = at,
        }
    }
    record.end_ns = end.as_nanos();
    record.duration_ns = end.max(closed).as_nanos();
    let judge =
        CaseJudge::new(case.scenario(), trace.signals())?.by_clock(board_instrument::clock_error(trace));
    let outcome = judge.replay(When::exactly(end), trace).map_err(|error| error.to_string());
    verdict(&mut record, outcome, &CaseEnding::read_from(trace), &case.expected_states());
    let changed = trace.note("plan-sha256") != Some(describe::plan_hash(read.joined()).as_str());
    if changed {
        let reason = format!("{} (the plan has changed since the trace was recorded)", record.reason);
        record.reason = reason.trim().to_owned();
    }
    Ok(record)
}

/// Adds to the record what reports draw of the trace: excerpts of its signals, and when its steps came.
pub fn add_excerpts(record: &mut CaseRecord, trace: &Trace) {
    const ANCHORS: [&str; 5] = ["start", "main", "end", "teardown", "setup"];
    for (place, info) in trace.signals().iter().enumerate().filter(|(_, info)| info.kind == ValueKind::Mark) {
        let id = info.name.strip_prefix("step:").filter(|id| !id.contains('.') && !ANCHORS.contains(id));
        let Some(id) = id else { continue };
        let came = trace.last(SignalId(place as u32)).map(|event| event.at);
        let at_ns = came.map(|at| [at.earliest.as_nanos(), at.latest.as_nanos()]);
        record.steps.push(StepRecord { id: id.to_owned(), at_ns, ..StepRecord::default() });
    }
    record.lanes = lanes::excerpts(record, trace);
}

/// The invariants and alarms of suites and the board that the run held against its cases.
fn guards_of(trace: &Trace) -> Result<Vec<GlobalChecks>, Vec<Diagnostic>> {
    let mut list = Vec::new();
    for (key, text) in trace.notes() {
        let Some((_, named)) = key.strip_prefix("guards:").and_then(|key| key.split_once(':')) else {
            continue;
        };
        let Some((kind, name)) = named.split_once(':') else { continue };
        let file = SourceFile::new(name, text);
        list.push(if kind == "board" {
            GlobalChecks::of_board(&file)?
        } else {
            GlobalChecks::of_suite(&file)?
        });
    }
    Ok(list)
}
