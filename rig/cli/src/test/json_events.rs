//! The events of a run for a program that reads standard output: one JSON object a line (`docs/terminal.md`).

use super::observer::RunObserver;
use crate::output;
use document::{Diagnostic, SourceFile};
use record::{CaseRecord, RunRecord};
use runtime::suite::Job;
use serde_json::{Value, json};

/// Version of the events. A new event or a new member is no new version: readers pass over what they do not know.
const FORMAT: u32 = 1;

/// Prints events.
#[derive(Debug)]
pub struct JsonEvents;

fn print(event: &Value) {
    output::print(&format!("{event}\n"));
}

/// A case that would run.
pub fn listed(job: &Job) {
    print(&json!({
        "event": "case-listed",
        "format": FORMAT,
        "case": job.name,
        "title": job.title,
        "profile": job.profile.name(),
        "proves": job.proves,
        "seed": job.seed,
    }));
}

impl RunObserver for JsonEvents {
    fn run_started(&mut self, run: &RunRecord, at_once: usize) {
        print(&json!({
            "event": "run-started",
            "format": FORMAT,
            "rig_version": run.rig_version,
            "planned": run.planned,
            "at_once": at_once,
            "provenance": run.provenance,
        }));
    }

    fn case_started(&mut self, place: usize, job: &Job) {
        print(&json!({ "event": "case-started", "place": place + 1, "case": job.name, "title": job.title }));
    }

    fn found(&mut self, found: &[Diagnostic], sources: &[SourceFile]) {
        output::findings(found, sources);
    }

    fn case_finished(&mut self, place: usize, record: &CaseRecord) {
        print(&json!({
            "event": "case-finished",
            "place": place + 1,
            "case": record.name,
            "plan": record.plan,
            "title": record.title,
            "profile": record.profile,
            "seed": record.seed,
            "status": record.status,
            "verdict": record.verdict,
            "reason": record.reason,
            "proves": record.proves,
            "parameters": record.parameters,
            "start_ns": record.start_ns,
            "duration_ns": record.duration_ns,
            "host_ms": record.host_ms,
            "claims": record.claims,
            "measurements": record.measurements,
            "trace_sha256": record.trace_sha256,
            "trace_file": record.trace_file,
        }));
    }

    fn run_finished(&mut self, run: &RunRecord, page: Option<&str>) {
        print(&json!({
            "event": "run-finished",
            "planned": run.planned,
            "totals": run.totals,
            "unguarded": run.unguarded(),
            "verdict": run.verdict(),
            "coverage": run.coverage,
            "repeated": run.repeated(),
            "page": page,
        }));
    }
}
