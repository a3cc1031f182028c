//! The record of one case: one plan with one row or one point of a sweep.

use crate::{ClaimRecord, InstrumentRecord, Lane, MeasurementRecord, RigTiming, Verdict};
use serde::{Deserialize, Serialize};

/// The most lines that a case's log keeps; further ones are counted only.
pub const MAX_LOG_LINES: usize = 1_000;

/// Whether a case was judged at all.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "is", rename_all = "kebab-case")]
pub enum CaseStatus {
    /// It ran and has a verdict.
    #[default]
    Judged,
    /// It needs a power that this rig or this subject does not have. Never a pass.
    NotApplicable {
        /// Which power is missing and why.
        reason: String,
    },
    /// It was left out: by a filter, or because the run was stopped before it.
    Skipped {
        /// Why.
        reason: String,
    },
}

/// A parameter of a row, a sweep or the command line, as the user wrote its value.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Parameter {
    /// Its name.
    pub name: String,
    /// Its value, in text.
    pub value: String,
}

/// SHA-256 of the files that a case was made from, 64 hexadecimal digits each; empty where there is none.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Hashes {
    /// The plan file.
    pub plan: String,
    /// The board file.
    pub board: String,
    /// The program's sources.
    pub program: String,
    /// What `rig judge` judged: the capture, or the trace of an earlier run; empty for a case that ran.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub capture: String,
}

/// A step of the plan as it happened.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct StepRecord {
    /// Its id in the plan, or `start` and `end` for those anchors.
    pub id: String,
    /// `[earliest, latest]`, nanoseconds; nothing when it never came.
    pub at_ns: Option<[i64; 2]>,
    /// What it did: `overload MAST by 101 ms, once`.
    pub what: String,
    /// The part of the case that it belongs to: `setup`, `main` or `teardown`.
    #[serde(default = "main_phase")]
    pub phase: String,
}

/// The part that the steps of older records belong to.
fn main_phase() -> String {
    String::from("main")
}

/// What a task of the controller did, in modelled time.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct TaskFigures {
    /// Its name.
    pub name: String,
    /// Period of a cyclic task, nanoseconds; 0 for another kind.
    pub period_ns: i64,
    /// Completed cycles.
    pub cycles: u64,
    /// Shortest cycle, nanoseconds.
    pub cycle_min_ns: i64,
    /// Mean cycle, nanoseconds.
    pub cycle_mean_ns: i64,
    /// Longest cycle, nanoseconds.
    pub cycle_max_ns: i64,
    /// Cycles that outlasted the period.
    pub overruns: u64,
    /// Watchdog exceptions.
    pub watchdogs: u64,
}

/// A line of the case's log.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct LogLine {
    /// When, nanoseconds.
    pub at_ns: i64,
    /// The text.
    pub text: String,
}

/// The CAN frames of a case, beside its trace: `x.log` beside `x.trace`, as `candump -L` writes it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct FramesKept {
    /// How many there are.
    pub kept: u64,
    /// How many more there were, which found no room.
    pub more: u64,
}

/// The record of one case.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct CaseRecord {
    /// Its name: `watchdog/fallback[over]`; unique in the run.
    pub name: String,
    /// The plan's path as the user gave it.
    pub plan: String,
    /// The row's name, where the plan has rows.
    pub row: Option<String>,
    /// Parameters of the row, the sweep and the command line, in the plan's order.
    pub parameters: Vec<Parameter>,
    /// The plan's title.
    pub title: String,
    /// Whether it was judged.
    pub status: CaseStatus,
    /// The combination of its claims and measurements, and of the rig's own trouble.
    pub verdict: Verdict,
    /// Why the verdict, in one sentence; empty for a plain pass.
    pub reason: String,
    /// Why the case ended before its end; empty for one that did not.
    #[serde(default)]
    pub ended: String,
    /// That the application was stopped by an exception of which the plan does not speak: state, instant and cause.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub exception: String,
    /// Requirements that the plan proves: `controller:WD-04`.
    pub proves: Vec<String>,
    /// Words of the plan that cases are chosen and filtered by.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub tags: Vec<String>,
    /// Profile of the controller: `m241-2019`.
    pub profile: String,
    /// Reference of the controller: `TM241CE24T`.
    pub reference: String,
    /// What the delays of a modelled controller mean: `worst case`; empty where an edge comes when its delay is over.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub model: String,
    /// The board as the user named it; empty for the default board.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub board: String,
    /// The instrument that recorded it, where it has a file that states an error: another than the rig, or the board.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub instrument: Option<InstrumentRecord>,
    /// What it was made from.
    pub hashes: Hashes,
    /// Seed of everything random in it.
    pub seed: u64,
    /// Which turn of the case it is, from 1, where it runs several times.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub turn: Option<u32>,
    /// The plan's anchor `start`, nanoseconds of the trace; 0 when the case never got there.
    pub start_ns: i64,
    /// The plan's anchor `end`, nanoseconds of the trace; the last instant when the case was cut short.
    pub end_ns: i64,
    /// Modelled time that the case took from power-on, nanoseconds.
    pub duration_ns: i64,
    /// Time that it took on the host, milliseconds.
    pub host_ms: u64,
    /// SHA-256 of the trace, 64 hexadecimal digits; empty when there is none.
    pub trace_sha256: String,
    /// Where the trace was kept, relative to the record.
    pub trace_file: Option<String>,
    /// CAN frames that are kept beside the trace; `None` where there were none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frames: Option<FramesKept>,
    /// Expectations, in the plan's order.
    pub claims: Vec<ClaimRecord>,
    /// Measurements, in the plan's order.
    pub measurements: Vec<MeasurementRecord>,
    /// Steps, in the plan's order.
    pub steps: Vec<StepRecord>,
    /// How well the rig kept time.
    pub timing: RigTiming,
    /// The controller's tasks.
    pub tasks: Vec<TaskFigures>,
    /// The log, at most [`MAX_LOG_LINES`].
    pub log: Vec<LogLine>,
    /// Log lines that found no room.
    pub log_dropped: u64,
    /// Excerpts of the signals that the claims look at.
    pub lanes: Vec<Lane>,
}

impl CaseRecord {
    /// A case that needs a power that is not there.
    pub fn not_applicable(name: impl Into<String>, reason: impl Into<String>) -> Self {
        CaseRecord {
            name: name.into(),
            status: CaseStatus::NotApplicable { reason: reason.into() },
            ..CaseRecord::default()
        }
    }

    /// A case that was left out.
    pub fn skipped(name: impl Into<String>, reason: impl Into<String>) -> Self {
        CaseRecord {
            name: name.into(),
            status: CaseStatus::Skipped { reason: reason.into() },
            ..CaseRecord::default()
        }
    }

    /// Appends to the log, or counts the line when there is no room.
    pub fn log_line(&mut self, at_ns: i64, text: impl Into<String>) {
        if self.log.len() < MAX_LOG_LINES {
            self.log.push(LogLine { at_ns, text: text.into() });
        } else {
            self.log_dropped += 1;
        }
    }

    /// Whether something was measured whose limits have no guard band, so that a pass may be accepted and not proven.
    pub fn is_unguarded(&self) -> bool {
        self.is_judged() && self.measurements.iter().any(|m| !m.guard_band.is_uncertainty())
    }

    /// Whether the middle of a value alone decided something, which its interval would have left open.
    pub fn is_by_middle(&self) -> bool {
        self.is_judged() && self.measurements.iter().any(|m| m.by_middle)
    }

    /// The greatest verdict of the claims and the measurements.
    pub fn folded(&self) -> Verdict {
        let claims = self.claims.iter().map(|c| c.verdict);
        Verdict::fold(claims.chain(self.measurements.iter().map(|m| m.verdict)))
    }

    /// Whether the case was judged, so that its verdict counts.
    pub fn is_judged(&self) -> bool {
        self.status == CaseStatus::Judged
    }

    /// Its name without the turn: `watchdog/fallback[over]` of `watchdog/fallback[over]#2`.
    pub fn base_name(&self) -> &str {
        let turn = self.turn.filter(|turn| *turn > 1).map(|turn| format!("#{turn}"));
        turn.and_then(|turn| self.name.strip_suffix(&turn)).unwrap_or(&self.name)
    }

    /// Folder of the plan, as reports group by it: `watchdog` of `watchdog/fallback[over]`; empty for none.
    ///
    /// Only the part before the first `[` counts: a row's name may hold slashes.
    pub fn folder(&self) -> &str {
        let plan = self.name.split('[').next().unwrap_or_default();
        plan.rfind('/').map_or("", |at| &self.name[..at])
    }
}
