//! Monitors: what follows the signals of one claim through the trace, and what they are made of.
//!
//! A [`Monitor`] is fed with the events of its signals, each with the interval in which it happened, and comes to a
//! [`Finding`]: can the claim hold in some placement of the events, and can it break? [`CaseTimeline`] gives it the signals and
//! instants that it starts from. The modules are the ways of looking that several verbs share: edges, pulses, segments of
//! values, values at instants, counts.
//!
//! Nothing here knows a verb (those are in [`crate::expect`] and [`crate::measure`]) or a case ([`crate::judge`]).

mod anchors;
mod clock_limits;
pub mod count;
pub mod cycles;
pub mod edges;
pub mod extremes;
mod finding;
pub mod gaps;
mod hull;
mod instants;
pub mod jitter;
pub mod levels;
mod limits;
mod means;
mod number;
mod pulse_filter;
pub mod pulses;
pub mod reading;
pub mod segments;
pub mod shape;
pub mod shape_follower;
pub mod speed;
mod timeline;
pub mod track;
mod unseen;
mod value_test;

pub(crate) use anchors::Anchors;
pub use clock_limits::ClockLimits;
pub(crate) use clock_limits::{BothEnds, ClockedFigure, LimitEnd, true_figure};
pub use finding::Finding;
pub(crate) use finding::{clipped, span_margin};
pub use instants::{TimedValue, UncertainInstant, UncertainWindow};
pub use limits::NumberLimits;
pub(crate) use limits::{Extent, widened};
pub use number::Number;
pub(crate) use number::{differs_at_most, distance};
pub(crate) use pulse_filter::PulseFilter;
pub use timeline::{CaseTimeline, NotJudged, TraceSignals};
pub(crate) use timeline::{EventOrder, lag};
pub use unseen::{PulseRule, UnseenPulses};
pub use value_test::{Truth, ValueTest, slack};

/// Follows the signals of one claim and comes to a finding.
pub trait Monitor {
    /// The next event of the signal at place `slot` of [`crate::expect::TraceClaim::signals`].
    fn feed(&mut self, slot: usize, seen: &TimedValue);

    /// Whether the claim is lost whatever comes, when every event before `now` (nanoseconds) is known.
    /// A claim that cannot tell before the end says no.
    fn lost(&mut self, _now: i64) -> bool {
        false
    }

    /// The finding when nothing comes any more.
    fn finish(self: Box<Self>) -> Finding;
}
