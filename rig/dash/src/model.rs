//! What the dashboard knows of the rig: the mirror that messages fill and views draw from.

use control::{Description, ForcedPoint, FrameSeen, PlanEvent, PlanStatus, Status, TimeSource, WireValue};
use std::collections::{BTreeMap, VecDeque};

/// Lines of the log, and frames, that are kept.
pub const KEPT: usize = 2_000;

/// Events of a plan that are kept; a plan of very many cases loses its first ones.
const KEPT_OF_PLAN: usize = 20_000;

/// The mirror of the rig.
#[derive(Clone, Debug, Default)]
pub struct RigModel {
    /// What it is.
    pub description: Description,
    /// How it is.
    pub status: Status,
    /// The instant that is drawn, nanoseconds since the rig began: that of the status, and what passed since it came.
    pub now: i64,
    /// The last value of every signal that is subscribed to, by its name, with its instant.
    pub values: BTreeMap<String, (i64, WireValue)>,
    /// Its log, oldest first.
    pub log: VecDeque<(i64, String)>,
    /// Frames of its buses, oldest first.
    pub frames: VecDeque<FrameSeen>,
    /// What the plan that runs, or ran last, reported.
    pub plan: Vec<PlanEvent>,
    /// The cases that it can run, once it was asked ([`control::RequestOperation::Plans`]).
    pub plans: Option<Vec<String>>,
    /// Why there is nothing new: the connection is lost.
    pub gone: Option<String>,
}

impl RigModel {
    /// What is forced at an address.
    pub fn forced(&self, address: &str) -> Option<&ForcedPoint> {
        self.status.forced.iter().find(|forced| forced.address == address)
    }

    /// A status came.
    pub(crate) fn take_status(&mut self, status: Status) {
        self.now = status.at;
        self.status = status;
    }

    /// So much time passed since the status came.
    pub(crate) fn pass(&mut self, nanos: i64) {
        if self.description.clock == TimeSource::Real && self.gone.is_none() {
            self.now = self.status.at.saturating_add(nanos);
        }
    }

    /// A line of the log came.
    pub(crate) fn take_log(&mut self, at: i64, text: String) {
        keep(&mut self.log, (at, text));
    }

    /// A frame came.
    pub(crate) fn take_frame(&mut self, frame: FrameSeen) {
        keep(&mut self.frames, frame);
    }

    /// A plan goes on now. Its status comes later.
    pub(crate) fn plan_event(&mut self, event: PlanEvent) {
        match &event {
            PlanEvent::Case { name, place, .. } => {
                self.status.plan = Some(PlanStatus::of(name, *place));
            }
            PlanEvent::Over { .. } => self.status.plan = None,
            PlanEvent::Step { .. } | PlanEvent::Verdict { .. } => {}
        }
        self.take_plan_event(event);
    }

    /// An event of a plan. Those of an earlier one go when the next begins.
    pub(crate) fn take_plan_event(&mut self, event: PlanEvent) {
        let first = matches!(event, PlanEvent::Case { place: (1, _), .. });
        let over = matches!(self.plan.last(), Some(PlanEvent::Over { .. }));
        if first || over {
            self.plan.clear();
        }
        if self.plan.len() == KEPT_OF_PLAN {
            self.plan.drain(..KEPT_OF_PLAN / 2);
        }
        self.plan.push(event);
    }
}

fn keep<T>(kept: &mut VecDeque<T>, one: T) {
    if kept.len() == KEPT {
        kept.pop_front();
    }
    kept.push_back(one);
}
