//! Steps that wait, where the clock may be off: whether they came in time by every clock.
//!
//! A run does what the clock of its rig says, and so do the marks of its trace: what comes after the limit of a wait is missed, and
//! what came before the wait began does not count. The times of the plan are true time. So a step that came may have been
//! late, or its event too early, and one that was missed may have come in time. What claims something of such a step
//! is open.

use signal::{Event, Value};

use super::case::{Scenario, StepFacts};
use crate::monitor::edges::{FirstEdge, FoundEdge};
use crate::monitor::{CaseTimeline, ClockLimits, LimitEnd, TimedValue, TraceSignals, UncertainInstant};
use crate::steps::{AwaitedChange, CasePart};

/// The waits of a case.
#[derive(Debug, Default)]
pub(super) struct ClockedWaits {
    waits: Vec<ClockedWait>,
    /// By place of the signal: the waits that look at it.
    lookers: Vec<Vec<usize>>,
    /// By place of the signal: the step whose mark it is.
    marks: Vec<Option<usize>>,
    /// Whether each step came.
    came: Vec<bool>,
}

/// One wait.
#[derive(Debug)]
struct ClockedWait {
    /// Place of the step.
    step: usize,
    event: AwaitedChange,
    before: Option<Value>,
    /// Where it began and where it was over, by the clock of the rig.
    own: (UncertainInstant, i64),
    /// Where it is over at the latest.
    latest: i64,
    /// The first event, in time at the strictest.
    strictest: FirstEdge,
    /// The first of those that the rig took for too early or too late, in time at the loosest.
    loosest: FirstEdge,
}

impl ClockedWaits {
    /// Those of a case; none where the clock is right.
    pub(super) fn new(steps: &[StepFacts], scene: &CaseTimeline<'_>) -> ClockedWaits {
        let mut this = ClockedWaits::default();
        if scene.clock.error.is_none() {
            return this;
        }
        let place_of = |name: &str| scene.signals.iter().position(|info| info.name == name);
        this.lookers = vec![Vec::new(); scene.signals.len()];
        this.marks = vec![None; scene.signals.len()];
        this.came = vec![false; steps.len()];
        for (step, facts) in steps.iter().enumerate() {
            if let Some(mark) = place_of(&format!("step:{}", facts.id)) {
                this.marks[mark] = Some(step);
            }
            if let Some((signal, wait)) = ClockedWait::new(step, facts, scene) {
                this.lookers[signal].push(this.waits.len());
                this.waits.push(wait);
            }
        }
        this
    }

    /// The next event of the trace.
    #[inline]
    pub(super) fn see(&mut self, event: &Event, place: u64) {
        let signal = event.signal.0 as usize;
        let Some(lookers) = self.lookers.get(signal) else { return };
        for at in lookers {
            self.waits[*at].see(event, place);
        }
        if let (Some(step), false) = (self.marks[signal], matches!(event.value, Value::Unknown)) {
            self.came[step] = true;
        }
    }

    /// The marks of the steps of which nobody knows whether they came in time, and of those that come only after them.
    pub(super) fn open(&self, scenario: &Scenario, scene: &CaseTimeline<'_>) -> Vec<usize> {
        let mut open = vec![false; self.came.len()];
        for wait in &self.waits {
            let watched = scenario.steps[wait.step].part != CasePart::Setup;
            open[wait.step] = wait.is_open(self.came[wait.step], watched.then(|| scene.end()));
        }
        // A step may count from one that stands after it.
        loop {
            let depends = |step: &usize| {
                let from = scenario.steps[*step].counts_from;
                !open[*step] && !self.came[*step] && from.is_some_and(|from| open[from] && !self.came[from])
            };
            let more: Vec<usize> = (0..open.len()).filter(depends).collect();
            if more.is_empty() {
                break;
            }
            more.into_iter().for_each(|step| open[step] = true);
        }
        let is_open = |mark: &usize| self.marks[*mark].is_some_and(|step| open[step]);
        (0..self.marks.len()).filter(is_open).collect()
    }
}

impl ClockedWait {
    /// The wait of a step, with the place of the signal that it looks at; `None` where it never began.
    fn new(step: usize, facts: &StepFacts, scene: &CaseTimeline<'_>) -> Option<(usize, ClockedWait)> {
        let wait = facts.awaited.as_ref()?;
        let signal = scene.signals.iter().position(|info| info.name == wait.signal)?;
        let info = TraceSignals { signals: scene.signals }.find(&wait.signal)?;
        let began = scene.anchors.resolve(&wait.from)?;
        // The rig waited from one instant on, whatever else is known of it: only the clock is in doubt here.
        let own = UncertainInstant { a: began.b, ..began };
        let from = own.by_clock(scene.clock.error);
        let within = wait.within.as_nanos();
        let most = |end| ClockLimits { end, ..scene.clock }.most(within);
        let (strictest, loosest) = (most(LimitEnd::Strictest), most(LimitEnd::Loosest));
        let wait = ClockedWait {
            step,
            event: wait.awaits.bind(info)?,
            before: None,
            own: (own, own.b.saturating_add(within)),
            latest: from.b.saturating_add(loosest),
            strictest: FirstEdge::new(from, 0, strictest),
            loosest: FirstEdge::new(from, 0, loosest),
        };
        Some((signal, wait))
    }

    fn see(&mut self, event: &Event, place: u64) {
        let before = self.before.replace(event.value);
        if !self.event.met(before, event.value) {
            return;
        }
        let (own, limit) = self.own;
        let after = own.offset == 0 && place >= own.place;
        let at = event.at.latest.as_nanos();
        // What stands after the beginning of the wait came after it, however well both are known.
        let at = if after { at.max(own.b) } else { at };
        let found = FoundEdge { seen: TimedValue::of(event, at, at, place), certain: true };
        self.strictest.see(&found);
        let counted = if own.offset == 0 { after } else { at >= own.b };
        if !counted || at > limit {
            self.loosest.see(&found);
        }
    }

    /// Whether the step may be late though it `came`, or may have come though it did not. Up to `seen` its signal was watched
    /// after the wait, too; a missed step of the setup ends the case, so that nothing more is known of it.
    fn is_open(&self, came: bool, seen: Option<i64>) -> bool {
        if came {
            return self.strictest.finish().can_break();
        }
        let (_, limit) = self.own;
        self.loosest.finish().can_hold || seen.is_some_and(|end| limit <= end && end < self.latest)
    }
}
