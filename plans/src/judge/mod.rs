//! The judge: verdicts out of a trace and nothing else.
//!
//! The judge follows the trace as it grows, to know the instants that claims hang on and, where a case may end
//! early, to notice that a claim is lost; at the end of the case it reads the trace once more, now with every instant known, and
//! that reading alone decides. So `rig judge` on a recorded trace repeats every verdict.
//!
//! Goals: exact answers for events that are known to within intervals (`docs/decisions/0002-interval-verdicts.md`),
//! memory that does not grow with the trace, margins and evidence for the reader of a report. Not goals:
//! knowing what a verb means (that is [`crate::expect`]'s), running anything.

mod anchors;
mod case;
pub mod count;
mod counting;
pub mod course;
pub mod cycles;
pub mod edges;
pub mod extremes;
pub mod gaps;
mod hull;
pub mod jitter;
pub mod levels;
mod live;
mod order;
mod outcome;
mod point;
pub mod pulses;
pub mod reading;
mod scene;
pub mod segments;
pub mod shape;
pub mod speed;
mod standing;
mod test;
mod told;
pub mod track;
mod unknown;

pub use case::{Guard, Judge, JudgeError, Scenario, StepFacts};
pub use counting::note_of as counts_note;
pub(crate) use outcome::clipped;
pub use outcome::{Finding, Outcome};
pub use point::{Point, Seen, Window};
pub use scene::{NotJudged, Scene, Wiring, blind};
pub use standing::Standing;
pub use test::{Number, Test, Truth, slack};

/// Follows the signals of one claim and comes to a finding.
pub trait Monitor {
    /// The next event of the signal at place `slot` of [`crate::expect::Claim::signals`].
    fn feed(&mut self, slot: usize, seen: &Seen);

    /// Whether the claim is lost whatever comes, when every event before `now` (nanoseconds) is known.
    /// A claim that cannot tell before the end says no.
    fn lost(&mut self, _now: i64) -> bool {
        false
    }

    /// The finding when nothing comes any more.
    fn finish(self: Box<Self>) -> Finding;
}
