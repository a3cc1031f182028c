//! A case that was ended because a claim was lost: which claims those are, and which others were not finished by then.
//!
//! The note of the trace names the lost claims by their places, so that a trace that is judged again comes to the same. All
//! instants that those depend on have come, so that they fail as they would have later. Of the others, those that depend on what did not come any more are not judged: whether they would have held nobody knows.

use record::{ClaimRecord, MeasurementRecord, Verdict};

use crate::expect::TraceClaim;
use crate::lang::{Anchor, AnchorBase};
use crate::monitor::CaseTimeline;

/// The note of a trace that says which claims were lost when its case was ended.
pub const LOST_NOTE: &str = "lost-claims";

/// Why a claim is not judged.
const NOT_JUDGED: &str = "not judged: the case was ended when another claim was lost";

/// What is known of a case that was ended at a lost claim.
#[derive(Clone, Debug, Default)]
pub(super) struct EarlyEnd {
    /// The places of the lost claims; `None` in a case that ran to its end.
    lost: Option<Vec<usize>>,
}

impl EarlyEnd {
    /// By the notes of a trace.
    pub(super) fn of(note: &dyn Fn(&str) -> Option<String>) -> EarlyEnd {
        let places = |text: String| text.split(',').filter_map(|place| place.trim().parse().ok()).collect();
        EarlyEnd { lost: note(LOST_NOTE).map(places) }
    }

    /// The words of the note.
    pub(super) fn words(lost: &[usize]) -> String {
        lost.iter().map(usize::to_string).collect::<Vec<_>>().join(",")
    }

    /// Whether the claim at this place was lost.
    pub(super) fn is_lost(&self, place: usize) -> bool {
        self.lost.as_ref().is_some_and(|lost| lost.contains(&place))
    }

    /// The same claim, not judged if it was not finished.
    pub(super) fn claim(
        &self,
        place: usize,
        claim: &dyn TraceClaim,
        scene: &CaseTimeline<'_>,
        mut record: ClaimRecord,
    ) -> ClaimRecord {
        if self.lost.is_none() || self.is_lost(place) {
            return record;
        }
        let end = scene.earliest_end();
        let limit = record.window.map(|window| window.limit_until_ns.unwrap_or(window.until_ns[1]));
        let limited = record.window.is_some_and(|window| window.limit_until_ns.is_some());
        let over = limit.is_some_and(|limit| limit <= end) && (limited || !claim.is_open_ended());
        if depends_on_end(&claim.anchors(), scene) || record.verdict != Verdict::Pass && !over {
            record.verdict = Verdict::Inconclusive;
            record.reason = String::from(NOT_JUDGED);
            (record.margin, record.nearest_miss) = (None, None);
        }
        record
    }

    /// The same measurement, not taken if it was not finished.
    pub(super) fn measurement(
        &self,
        anchors: &[&Anchor],
        scene: &CaseTimeline<'_>,
        mut record: MeasurementRecord,
    ) -> MeasurementRecord {
        let unfinished = record.value.is_none() || depends_on_end(anchors, scene);
        if self.lost.is_some() && unfinished {
            record.verdict = Verdict::Inconclusive;
            record.by_middle = false;
            record.reason = String::from(NOT_JUDGED);
            record.margin = None;
        }
        record
    }
}

/// Whether an instant is the end of the case, or did not come before it.
fn depends_on_end(anchors: &[&Anchor], scene: &CaseTimeline<'_>) -> bool {
    anchors.iter().any(|anchor| anchor.base == AnchorBase::End || scene.point(anchor).is_err())
}
