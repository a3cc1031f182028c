//! The judge: verdicts out of a trace and nothing else.
//!
//! The judge follows the trace as it grows, to know the instants that claims depend on and, where a case may end
//! early, to notice that a claim is lost; at the end of the case it reads the trace once more, now with every instant known, and
//! that reading alone decides. So `rig judge` on a recorded trace repeats every verdict.
//!
//! Goals: exact answers for events that are known to within intervals (`docs/decisions/0002-interval-verdicts.md`),
//! memory that does not grow with the trace, margins and evidence for the reader of a report. Not goals:
//! knowing what a verb means (that is [`crate::expect`]'s), running anything.

mod answer;
mod case;
mod claim_progress;
mod claim_record;
mod coverage;
mod early_end;
mod judged_case;
mod live;
mod order;
mod pulse_limits;
mod short_pulses;
mod unknown;
mod waits;

pub use case::{CaseJudge, JudgeError, Scenario, StepFacts};
pub use claim_progress::ClaimProgress;
pub use coverage::{INSTANTS_NOTE as INSTANTS_COVERAGE_NOTE, note_of as coverage_note};
pub use early_end::LOST_NOTE;
pub use judged_case::JudgedCase;
pub use pulse_limits::note_of as counts_note;
