//! `speed`: how fast a number without a unit changes over a window, in counts per second.
//!
//! ```toml
//! { speed = { signal = "shaft", is = "200 kHz ± 0.1 %", from = "run", until = "run + 1 s" } }
//! { speed = { signal = "shaft", max = "-10 kHz", from = "back", until = "back.done" } }
//! ```
//! It is by how much the number differs between the two ends, over the time between them; below 0 where it shrank. What
//! it did in between is not asked. With a count that is read now and then, each end is known to within what it counts
//! between two readings, so a longer window is more exact.

use std::sync::Arc;

use document::{Diagnostic, Fields};
use record::Figure;
use signal::{SignalInfo, ValueKind};

use super::band::{FigureBand, IS_RANGE, shown, spread};
use super::common::{FROM, PlanWindow, SIGNAL, UNTIL, signal};
use super::condition::{MAX, MIN};
use super::{ClaimDemand, ExpectVerb, ReadContext, TraceClaim};
use crate::lang::Anchor;
use crate::monitor::speed::SpeedFollower;
use crate::monitor::{
    CaseTimeline, Finding, Monitor, NotJudged, PulseRule, TimedValue, TraceSignals, UncertainWindow, slack,
};

/// Its unit.
pub(crate) const UNIT: &str = "Hz";

/// `speed`.
pub(super) const SPEED: ExpectVerb = ExpectVerb {
    name: "speed",
    doc: "The change of a number over a window, per second, is within limits",
    keys: &[SIGNAL, IS_RANGE, MIN, MAX, FROM, UNTIL],
    read,
};

/// The claim.
#[derive(Clone, Debug)]
struct SpeedClaim {
    signal: String,
    band: FigureBand,
    between: PlanWindow,
}

fn read(fields: &Fields<'_>, cx: &mut ReadContext<'_>) -> Option<Arc<dyn TraceClaim>> {
    let signal = signal(fields, "signal", cx);
    let between = PlanWindow::read(fields, cx);
    let band = FigureBand::read(fields, "speed", UNIT, cx)?;
    Some(Arc::new(SpeedClaim { signal: signal?, band, between: between? }))
}

/// Whether a signal is a number that can be counted.
///
/// # Errors
/// Why it is not, one sentence.
pub(crate) fn countable(info: &SignalInfo) -> Result<(), String> {
    match info.kind {
        ValueKind::Int | ValueKind::Word if info.unit.is_empty() => Ok(()),
        _ => Err(format!("`{}` is no count: a speed is that of a whole number without a unit", info.name)),
    }
}

impl TraceClaim for SpeedClaim {
    fn expected(&self) -> String {
        format!("the speed of `{}` is {}{}", self.signal, self.band, self.between.words())
    }

    fn signals(&self) -> Vec<String> {
        vec![self.signal.clone()]
    }

    fn anchors(&self) -> Vec<&Anchor> {
        self.between.anchors()
    }

    fn check(&self, wiring: &TraceSignals<'_>, out: &mut Vec<Diagnostic>) {
        if let Some(info) = super::known(&self.signal, wiring, out) {
            super::meant(countable(info), "name a variable that counts, or measure `value-of`", out);
        }
    }

    fn demands(&self) -> Vec<ClaimDemand<'_>> {
        vec![self.between.demand()]
    }

    fn pulses(&self, _: &SignalInfo) -> PulseRule {
        PulseRule::SEEN
    }

    fn start(&self, scene: &CaseTimeline<'_>) -> Result<Box<dyn Monitor>, NotJudged> {
        let info = scene.signal(&self.signal)?;
        countable(info).map_err(NotJudged::NoMeaning)?;
        let window = scene.window(&self.between.from, &self.between.until)?;
        // While the trace grows an end is still to come, and nothing is asked.
        let length = scene.time_between(&self.between.from, &self.between.until).unwrap_or((0, i64::MAX));
        let speed = SpeedFollower::new(window, length);
        Ok(Box::new(SpeedMonitor { claim: self.clone(), slack: slack(info), window, speed }))
    }
}

/// The judge.
struct SpeedMonitor {
    claim: SpeedClaim,
    slack: f64,
    window: UncertainWindow,
    speed: SpeedFollower,
}

impl Monitor for SpeedMonitor {
    #[inline]
    fn feed(&mut self, _slot: usize, seen: &TimedValue) {
        self.speed.see(seen);
    }

    fn finish(self: Box<Self>) -> Finding {
        let SpeedMonitor { claim, slack, window, speed } = *self;
        let mut finding = Finding { window: Some(window.shown()), ..Finding::default() };
        let Some(found) = speed.finish(slack) else {
            (finding.can_hold, finding.can_break) = (true, true);
            finding.observed = String::from("not known");
            finding.reason = format!("`{}` is not known at both ends of the window", claim.signal);
            return finding;
        };
        let band = &claim.band;
        (finding.can_hold, finding.can_break) = band.hold(found.speed);
        finding.observed = format!("{}, {} in all", shown(found.speed, UNIT), shown(found.change, ""));
        finding.margin = band.margin(found.speed).map(|margin| Figure::new(margin, UNIT));
        finding.uncertainty = spread(found.speed, UNIT);
        finding.reason = match finding.can_hold {
            true => String::from("the uncertainty of both ends reaches over a limit"),
            false => band.miss(found.speed),
        };
        match found.last {
            Some(seen) => finding.decided_by(&seen),
            None => finding,
        }
    }
}
