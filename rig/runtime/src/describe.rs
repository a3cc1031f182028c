//! What a record and a trace say of where they come from.

use crate::case::{CaseFiles, hashes, parameters};
use crate::subject::{Model, Subject};
use plans::Case;
use plans::steps::{Command, FaultKind, Stimulus};
use record::{CaseRecord, StepRecord};
use sha2::{Digest, Sha256};
use signal::Trace;

/// Bytes as hexadecimal digits.
pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// SHA-256 as hexadecimal digits.
pub fn sha256(bytes: &[u8]) -> String {
    hex(&Sha256::digest(bytes))
}

/// The record of a case before it runs.
pub fn record_of(case: &Case, files: &CaseFiles) -> CaseRecord {
    CaseRecord {
        name: files.name.clone(),
        plan: files.plan.name.clone(),
        row: case.row.clone(),
        parameters: parameters(case),
        title: case.title.clone(),
        proves: case.proves.clone(),
        profile: files.profile.name().to_owned(),
        reference: files.reference.name.to_owned(),
        hashes: hashes(files),
        seed: files.seed,
        steps: case
            .steps
            .iter()
            .map(|step| StepRecord { id: step.id.clone(), at_ns: None, what: what(&step.stimulus) })
            .collect(),
        ..CaseRecord::default()
    }
}

/// Writes into the trace what judging it again needs, and whose names stand behind its numbers.
pub fn annotate(trace: &mut Trace, case: &Case, files: &CaseFiles, model: &Model, clock: &str) {
    trace.set_note("case", files.name.clone());
    trace.set_note("plan-case", case.name.clone());
    trace.set_note("plan", files.plan.name.clone());
    trace.set_note("plan-sha256", sha256(files.plan.text.as_bytes()));
    trace.set_note("profile", files.profile.name().to_owned());
    trace.set_note("reference", files.reference.name.to_owned());
    trace.set_note("seed", files.seed.to_string());
    trace.set_note("clock", clock.to_owned());
    for (name, value) in &case.parameters {
        trace.set_note(&format!("parameter:{name}"), value.clone());
    }
    for (name, value) in &files.given {
        trace.set_note(&format!("given:{name}"), value.clone());
    }
    for (place, (task, ..)) in model.figures().iter().enumerate() {
        trace.set_note(&format!("task:{place}"), task.clone());
    }
    for (place, source) in files.sources.iter().enumerate() {
        trace.set_note(&format!("file:{place}"), source.name.clone());
    }
}

/// A stimulus in words.
pub fn what(stimulus: &Stimulus) -> String {
    match stimulus {
        Stimulus::Set(list) => {
            let each: Vec<String> = list
                .iter()
                .map(|(signal, value)| format!("{signal} := {}", plans::show_literal(value)))
                .collect();
            each.join(", ")
        }
        Stimulus::Pulse { signal, value, width } => {
            format!("{signal} := {} for {width}", plans::show_literal(value))
        }
        Stimulus::Force { signal, value } => format!("force {signal} to {}", plans::show_literal(value)),
        Stimulus::Release { signal } => format!("release {signal}"),
        Stimulus::Write { of, value } => format!("write {of} := {}", plans::show_literal(value)),
        Stimulus::Command(command) => String::from(match command {
            Command::Run => "run",
            Command::Stop => "stop",
            Command::ResetWarm => "reset warm",
            Command::ResetCold => "reset cold",
        }),
        Stimulus::Download(_) => String::from("download the application"),
        Stimulus::PowerCut(lasts) => format!("cut the supply for {lasts}"),
        Stimulus::Power(true) => String::from("supply on"),
        Stimulus::Power(false) => String::from("supply off"),
        Stimulus::Overload { task, cycle, times: 1 } => format!("the next cycle of {task} takes {cycle}"),
        Stimulus::Overload { task, cycle, times } => {
            format!("the next {times} cycles of {task} take {cycle} each")
        }
        Stimulus::Fault { signal, kind, lasts } => {
            let kind = match kind {
                FaultKind::Stuck(value) => format!("stuck at {}", plans::show_literal(value)),
                FaultKind::Open => String::from("open"),
                FaultKind::ShortToGround => String::from("short to ground"),
                FaultKind::ShortToSupply => String::from("short to supply"),
                FaultKind::Glitch { value, width } => {
                    format!("glitch to {} for {width}", plans::show_literal(value))
                }
                FaultKind::Late(delay) => format!("{delay} late"),
                FaultKind::Lost => String::from("lost"),
            };
            let lasts = lasts.map_or_else(String::new, |lasts| format!(" for {lasts}"));
            format!("fault on {signal}: {kind}{lasts}")
        }
        Stimulus::Clear { signal } => format!("faults off {signal}"),
        Stimulus::Train(train) => format!("{} pulses on {}", train.count, train.signal),
        Stimulus::Mark => String::from("nothing"),
    }
}
