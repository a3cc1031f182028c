//! The record of a run: verdicts, claims, measurements, provenance. It is all that reports read.
//!
//! Goals: plain data with a fixed order of fields, so that two runs of one seed write the same bytes
//! (but for the facts of the host, see [`RunRecord::without_host_facts`]); a reader that refuses what it
//! cannot trust. Not goals: judging, drawing, storing the whole trace (a case carries bounded excerpts of
//! the signals that its claims look at).
//!
//! All instants are nanoseconds of the trace (0 = power-on of the case); a pair of them is
//! `[earliest, latest]` of one event.

mod case;
mod claim;
mod compact;
mod compare;
mod coverage;
mod figure;
mod instrument;
mod json;
mod lane;
mod machine;
mod number;
mod run;
mod statistics;
mod timing;
mod verdict;

pub use case::{
    CaseRecord, CaseStatus, FramesKept, Hashes, LogLine, MAX_LOG_LINES, Parameter, StepRecord, TaskFigures,
};
pub use claim::{Bounds, ClaimOrigin, ClaimRecord, GuardBand, MeasurementRecord, Window};
pub use compare::{
    COMPARISON_FORMAT, CaseChange, ClaimChange, Comparison, Erosion, GuardChange, Move, TextChange,
    Thresholds, compare,
};
pub use coverage::{FileCoverage, MAX_COVERED_FILES, MAX_LINE_RANGES};
pub use figure::Figure;
pub use instrument::{InstrumentRecord, InstrumentStatement};
pub use json::{MAX_CASES, MAX_JSON_BYTES, RecordError};
pub use lane::{Lane, LaneKind, LanePoint, LaneValue, MAX_LANE_POINTS};
pub use machine::{Durations, MACHINE_FORMAT, MAX_MACHINE_BYTES, MachineRecord};
pub use run::{
    ClauseFact, FORMAT, OLDEST_FORMAT, Provenance, RequirementFact, RunClock, RunRecord, Totals, Unguarded,
};
pub use statistics::{FigureOf, Repeated, RepeatedFigure, Statistics};
pub use timing::{LateWake, MAX_LATE_WAKES, RigTiming, Wakes};
pub use verdict::Verdict;
