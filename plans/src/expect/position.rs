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

use super::band::{Band, IS_RANGE, shown};
use super::common::{Between, FROM, LONGER, UNTIL};
use super::condition::{MAX, MIN};
use super::train::{BACKWARDS, DIRECTION, INVERTED, PULSES, QUADRATURE, Train};
use super::{Claim, Context, Demand, Verb};
use crate::lang::Anchor;
use crate::monitor::track::{Step, Track};
use crate::monitor::{Finding, Monitor, NotJudged, Scene, Seen, Window, Wiring};

/// The keys that `position` and its measurement share.
pub(crate) const KEYS: &[document::KeySpec] = &[PULSES, DIRECTION, INVERTED, BACKWARDS, QUADRATURE, LONGER];

/// `position`.
pub(super) const POSITION: Verb = Verb {
    name: "position",
    doc: "Counts of a pulse train up less those down, over a window, are within limits",
    keys: &[PULSES, DIRECTION, INVERTED, BACKWARDS, QUADRATURE, IS_RANGE, MIN, MAX, FROM, UNTIL, LONGER],
    read,
};

/// The claim.
#[derive(Clone, Debug)]
struct Position {
    train: Train,
    band: Band,
    between: Between,
}

fn read(fields: &Fields<'_>, cx: &mut Context<'_>) -> Option<Arc<dyn Claim>> {
    let train = Train::read(fields, cx);
    let between = Between::read(fields, cx);
    let band = Band::read(fields, "position", "", cx)?;
    Some(Arc::new(Position { train: train?, band, between: between? }))
}

impl Claim for Position {
    fn expected(&self) -> String {
        format!("the position of {} changes by {}{}", self.train.words(), self.band, self.between.words())
    }

    fn signals(&self) -> Vec<String> {
        self.train.signals()
    }

    fn anchors(&self) -> Vec<&Anchor> {
        self.between.anchors()
    }

    fn check(&self, wiring: &Wiring<'_>, out: &mut Vec<Diagnostic>) {
        self.train.check(wiring, out);
    }

    fn demands(&self) -> Vec<Demand<'_>> {
        vec![self.between.demand()]
    }

    fn counts(&self) -> Option<f64> {
        Some(0.0)
    }

    fn start(&self, scene: &Scene<'_>) -> Result<Box<dyn Monitor>, NotJudged> {
        let counting = Counting::new(&self.train, scene, &self.between.from, &self.between.until)?;
        Ok(Box::new(Follow { claim: self.clone(), counting }))
    }
}

/// Counts the counts of a window.
#[derive(Debug)]
pub struct Counting {
    track: Track,
    window: Window,
    missed: Option<String>,
    sum: Sum,
}

/// What was counted.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sum {
    /// Least and greatest position of all placements.
    pub(crate) extent: (i64, i64),
    pub(crate) doubtful: bool,
    last: Option<Seen>,
}

impl Counting {
    pub(crate) fn new(
        train: &Train,
        scene: &Scene<'_>,
        from: &Anchor,
        until: &Anchor,
    ) -> Result<Counting, NotJudged> {
        let window = scene.window(from, until)?;
        let (track, missed) = train.track(scene)?;
        Ok(Counting { track, window, missed, sum: Sum::default() })
    }

    /// The next event of a line.
    #[inline]
    pub(crate) fn see(&mut self, slot: usize, seen: &Seen) {
        let Counting { track, window, sum, .. } = self;
        track.see(slot, seen, |step| sum.take(window, &step));
    }

    /// What was counted, the window, and which line can hide pulses.
    pub(crate) fn finish(mut self) -> (Sum, Window, Option<String>) {
        let Counting { track, window, sum, .. } = &mut self;
        track.finish(|step| sum.take(window, &step));
        (self.sum, self.window, self.missed)
    }
}

impl Sum {
    fn take(&mut self, window: &Window, step: &Step) {
        let count = match step {
            Step::Count(count) => count,
            Step::Unknown(seen) => {
                self.doubtful |= window.can_hold(seen);
                return;
            }
        };
        if !window.can_hold(&count.seen) {
            return;
        }
        let by = |up: u64, down: u64| {
            let number = |n: u64| i64::try_from(n).unwrap_or(i64::MAX);
            number(up).saturating_sub(number(down))
        };
        let (mut least, mut most) = (by(count.up.0, count.down.1), by(count.up.1, count.down.0));
        if !window.must_hold(&count.seen) {
            (least, most) = (least.min(0), most.max(0));
        }
        self.extent = (self.extent.0.saturating_add(least), self.extent.1.saturating_add(most));
        self.last = Some(count.seen);
    }
}

/// The judge.
struct Follow {
    claim: Position,
    counting: Counting,
}

impl Monitor for Follow {
    #[inline]
    fn feed(&mut self, slot: usize, seen: &Seen) {
        self.counting.see(slot, seen);
    }

    fn finish(self: Box<Self>) -> Finding {
        let Follow { claim, counting } = *self;
        let (sum, window, missed) = counting.finish();
        let extent = (sum.extent.0 as f64, sum.extent.1 as f64);
        let (can_hold, can_break) = claim.band.hold(extent);
        let open = sum.doubtful || missed.is_some();
        let mut finding = Finding {
            can_hold: open || can_hold,
            can_break: open || can_break,
            observed: format!("changed by {}", shown(extent, "")),
            margin: Some(Figure::new(claim.band.margin(extent), "")),
            uncertainty: (extent.0 < extent.1).then(|| Figure::new(extent.1 - extent.0, "")),
            window: Some(window.shown()),
            ..Finding::default()
        };
        finding.reason = match (finding.can_hold, missed) {
            (true, _) if sum.doubtful => String::from("a signal is not known for a part of the window"),
            (true, Some(missed)) => missed,
            (true, None) => {
                String::from("which counts lie in the window, or their direction, is not certain")
            }
            (false, _) => {
                let (apart, word) = match extent.0 > claim.band.max {
                    true => (extent.0 - claim.band.max, "too many"),
                    false => (claim.band.min - extent.1, "too few"),
                };
                format!("{} {word}", Figure::new(apart, ""))
            }
        };
        match sum.last {
            Some(seen) => finding.decided_by(&seen),
            None => finding,
        }
    }
}
