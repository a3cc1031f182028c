//! `position`: by how much a pulse train went forwards.
//!
//! ```toml
//! { position = { signal = "A", direction = "B", is = 4000, from = "go" } }
//! { position = { signal = "A", quadrature = "B", is = "-48 ± 1", from = "back", until = "back.done" } }
//! ```
//! Counts up less counts down, from one instant to another.

use std::sync::Arc;

use document::{Diagnostic, Fields};
use record::Figure;
use signal::SignalInfo;

use super::band::{FigureBand, IS_RANGE, shown, spread};
use super::common::{FROM, LONGER, PlanWindow, UNTIL};
use super::condition::{MAX, MIN};
use super::train::{BACKWARDS, DIRECTION, INVERTED, PULSES, QUADRATURE, TrainLines};
use super::{ClaimDemand, ExpectVerb, ReadContext, TraceClaim};
use crate::lang::Anchor;
use crate::monitor::track::{PositionTrack, TrackStep};
use crate::monitor::{
    CaseTimeline, Extent, Finding, Monitor, NotJudged, Number, PulseRule, TimedValue, TraceSignals,
    UncertainWindow,
};

/// The keys that `position` and its measurement share.
pub(crate) const KEYS: &[document::KeySpec] = &[PULSES, DIRECTION, INVERTED, BACKWARDS, QUADRATURE, LONGER];

/// `position`.
pub(super) const POSITION: ExpectVerb = ExpectVerb {
    name: "position",
    doc: "Counts of a pulse train up less those down, over a window, are within limits",
    keys: &[PULSES, DIRECTION, INVERTED, BACKWARDS, QUADRATURE, IS_RANGE, MIN, MAX, FROM, UNTIL, LONGER],
    read,
};

/// The claim.
#[derive(Clone, Debug)]
struct PositionClaim {
    train: TrainLines,
    band: FigureBand,
    between: PlanWindow,
}

fn read(fields: &Fields<'_>, cx: &mut ReadContext<'_>) -> Option<Arc<dyn TraceClaim>> {
    let train = TrainLines::read(fields, cx);
    let between = PlanWindow::read(fields, cx);
    let band = FigureBand::read(fields, "position", "", cx)?;
    Some(Arc::new(PositionClaim { train: train?, band, between: between? }))
}

impl TraceClaim for PositionClaim {
    fn expected(&self) -> String {
        format!("the position of {} changes by {}{}", self.train.words(), self.band, self.between.words())
    }

    fn signals(&self) -> Vec<String> {
        self.train.signals()
    }

    fn anchors(&self) -> Vec<&Anchor> {
        self.between.anchors()
    }

    fn check(&self, wiring: &TraceSignals<'_>, out: &mut Vec<Diagnostic>) {
        self.train.check(wiring, out);
    }

    fn demands(&self) -> Vec<ClaimDemand<'_>> {
        let mut demands = self.train.demands();
        demands.push(self.between.demand());
        demands
    }

    fn counts(&self) -> Option<f64> {
        Some(0.0)
    }

    fn pulses(&self, info: &SignalInfo) -> PulseRule {
        self.train.pulses(info)
    }

    fn start(&self, scene: &CaseTimeline<'_>) -> Result<Box<dyn Monitor>, NotJudged> {
        let counting = PositionCounter::new(&self.train, scene, &self.between.from, &self.between.until)?;
        Ok(Box::new(PositionMonitor { claim: self.clone(), counting }))
    }
}

/// Counts the counts of a window.
#[derive(Debug)]
pub struct PositionCounter {
    track: PositionTrack,
    window: UncertainWindow,
    sum: PositionSum,
}

/// What was counted.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PositionSum {
    /// Least and greatest position of all placements.
    extent: (i128, i128),
    pub(crate) doubtful: bool,
    last: Option<TimedValue>,
}

impl PositionCounter {
    pub(crate) fn new(
        train: &TrainLines,
        scene: &CaseTimeline<'_>,
        from: &Anchor,
        until: &Anchor,
    ) -> Result<PositionCounter, NotJudged> {
        let window = scene.window(from, until)?;
        let track = train.track(scene)?;
        Ok(PositionCounter { track, window, sum: PositionSum::default() })
    }

    /// The next event of a line.
    #[inline]
    pub(crate) fn see(&mut self, slot: usize, seen: &TimedValue) {
        let PositionCounter { track, window, sum, .. } = self;
        track.see(slot, seen, |step| sum.take(window, &step));
    }

    /// What was counted, and the window.
    pub(crate) fn finish(mut self) -> (PositionSum, UncertainWindow) {
        let PositionCounter { track, window, sum, .. } = &mut self;
        track.finish(|step| sum.take(window, &step));
        (self.sum, self.window)
    }
}

impl PositionSum {
    /// Least and greatest position of all placements.
    pub(crate) fn figure(&self) -> Extent {
        (Number::Int(self.extent.0), Number::Int(self.extent.1))
    }

    fn take(&mut self, window: &UncertainWindow, step: &TrackStep) {
        let count = match step {
            TrackStep::Count(count) => count,
            TrackStep::Unknown(seen) => {
                self.doubtful |= window.can_hold(seen);
                return;
            }
        };
        if !window.can_hold(&count.seen) {
            return;
        }
        let by = |up: u64, down: u64| i128::from(up) - i128::from(down);
        let (mut least, mut most) = (by(count.up.0, count.down.1), by(count.up.1, count.down.0));
        if !window.must_hold(&count.seen) {
            (least, most) = (least.min(0), most.max(0));
        }
        self.extent = (self.extent.0.saturating_add(least), self.extent.1.saturating_add(most));
        self.last = Some(count.seen);
    }
}

/// The judge.
struct PositionMonitor {
    claim: PositionClaim,
    counting: PositionCounter,
}

impl Monitor for PositionMonitor {
    #[inline]
    fn feed(&mut self, slot: usize, seen: &TimedValue) {
        self.counting.see(slot, seen);
    }

    fn finish(self: Box<Self>) -> Finding {
        let PositionMonitor { claim, counting } = *self;
        let (sum, window) = counting.finish();
        let extent = sum.figure();
        let (can_hold, can_break) = claim.band.hold(extent);
        let open = sum.doubtful;
        let mut finding = Finding {
            can_hold: open || can_hold,
            can_break: open || can_break,
            observed: format!("changed by {}", shown(extent, "")),
            margin: claim.band.margin(extent).map(|margin| Figure::new(margin, "")),
            uncertainty: spread(extent, ""),
            window: Some(window.shown()),
            ..Finding::default()
        };
        finding.reason = match finding.can_hold {
            true if sum.doubtful => String::from("a signal is not known for a part of the window"),
            true => String::from("which counts lie in the window, or their direction, is not certain"),
            false => {
                let (apart, above) = claim.band.beyond(extent);
                format!("{apart} {}", if above { "too many" } else { "too few" })
            }
        };
        match sum.last {
            Some(seen) => finding.decided_by(&seen),
            None => finding,
        }
    }
}
