//! `frequency` and `duty`: how often a signal comes, and how much of the time it is TRUE, over the whole cycles of a
//! window.
//!
//! ```toml
//! { frequency = { signal = "pulses", is = "50 Hz ± 0.5 %", from = "run" } }
//! { duty = { signal = "pulses", is = "25 % ± 1 %", from = "run", until = "run + 10 s" } }
//! ```
//! Both are means from the first to the last edge in the window; each cycle for itself is judged by `period` and
//! `pulse`. With fewer than two edges the claim fails.

use std::sync::Arc;

use document::{Diagnostic, Fields, KeySpec, KeyType};
use record::Figure;
use signal::{SignalInfo, Span};

use super::band::{FigureBand, IS_RANGE, NEVER_NEGATIVE, WHOLE_PART, shown, spread};
use super::common::{FROM, LONGER, PlanWindow, SIGNAL, UNTIL, signal};
use super::condition::{MAX, MIN};
use super::{ClaimDemand, ExpectVerb, ReadContext, TraceClaim};
use crate::lang::Anchor;
use crate::monitor::cycles::{CycleResult, CycleSpan, Cycles};
use crate::monitor::{
    CaseTimeline, ClockedFigure, Extent, Finding, Monitor, NotJudged, Number, PulseRule, TimedValue,
    TraceSignals, UncertainWindow, slack, widened,
};

/// Which edges begin a cycle.
const EDGE: KeySpec = KeySpec::optional(
    "edge",
    KeyType::Choice(&["rises", "falls"]),
    "Which edges begin a cycle; `rises` if left out",
);

const KEYS: &[KeySpec] = &[SIGNAL, IS_RANGE, MIN, MAX, EDGE, FROM, UNTIL, LONGER];

/// `frequency`.
pub(super) const FREQUENCY: ExpectVerb = ExpectVerb {
    name: "frequency",
    doc: "The mean frequency of a signal over a window is within limits",
    keys: KEYS,
    read: |fields, cx| read(fields, RateKind::Frequency, cx),
};

/// `duty`.
pub(super) const DUTY: ExpectVerb = ExpectVerb {
    name: "duty",
    doc: "The part of the time in which a signal is TRUE, over the whole cycles of a window, is within limits",
    keys: KEYS,
    read: |fields, cx| read(fields, RateKind::Duty, cx),
};

/// What is asked of the cycles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum RateKind {
    Frequency,
    Duty,
}

impl RateKind {
    fn noun(self) -> &'static str {
        match self {
            RateKind::Frequency => "frequency",
            RateKind::Duty => "duty",
        }
    }

    fn unit(self) -> &'static str {
        match self {
            RateKind::Frequency => "Hz",
            RateKind::Duty => "%",
        }
    }

    fn of(self, stretch: &CycleSpan) -> Extent {
        match self {
            RateKind::Frequency => stretch.rate(),
            RateKind::Duty => stretch.duty(),
        }
    }
}

/// The claim.
#[derive(Clone, Debug)]
struct Rate {
    signal: String,
    kind: RateKind,
    by_falls: bool,
    band: FigureBand,
    between: PlanWindow,
    longer_than: Option<Span>,
}

fn read(fields: &Fields<'_>, kind: RateKind, cx: &mut ReadContext<'_>) -> Option<Arc<dyn TraceClaim>> {
    let signal = signal(fields, "signal", cx);
    let between = PlanWindow::read(fields, cx);
    let band = FigureBand::read(fields, kind.noun(), kind.unit(), cx)?.of_kind(match kind {
        RateKind::Frequency => NEVER_NEGATIVE,
        RateKind::Duty => WHOLE_PART,
    });
    let by_falls = fields.text("edge") == Some("falls");
    let longer_than = fields.duration(LONGER.name);
    Some(Arc::new(Rate { signal: signal?, kind, by_falls, band, between: between?, longer_than }))
}

impl TraceClaim for Rate {
    fn expected(&self) -> String {
        format!("the {} of `{}` is {}{}", self.kind.noun(), self.signal, self.band, self.between.words())
    }

    fn signals(&self) -> Vec<String> {
        vec![self.signal.clone()]
    }

    fn anchors(&self) -> Vec<&Anchor> {
        self.between.anchors()
    }

    fn check(&self, wiring: &TraceSignals<'_>, out: &mut Vec<Diagnostic>) {
        super::known(&self.signal, wiring, out);
    }

    fn demands(&self) -> Vec<ClaimDemand<'_>> {
        vec![ClaimDemand::Change(&self.signal), self.between.demand()]
    }

    fn counts(&self) -> Option<f64> {
        let least = self.band.limits.min.filter(|_| self.kind == RateKind::Frequency);
        Some(least.map_or(0.0, Number::as_real).max(0.0))
    }

    fn pulses(&self, _: &SignalInfo) -> PulseRule {
        PulseRule::decides(self.longer_than)
    }

    fn start(&self, scene: &CaseTimeline<'_>) -> Result<Box<dyn Monitor>, NotJudged> {
        let info = scene.signal(&self.signal)?;
        let window = scene.window(&self.between.from, &self.between.until)?;
        // A part of the time is the same by every clock.
        let band = match self.kind {
            RateKind::Frequency => self.band.clone().by_clock(scene.clock, ClockedFigure::Rate),
            RateKind::Duty => self.band.clone(),
        };
        Ok(Box::new(RateMonitor {
            claim: Rate { band, ..self.clone() },
            info: info.clone(),
            window,
            cycles: Cycles::new(window, self.by_falls, slack(info)),
        }))
    }
}

/// The judge.
struct RateMonitor {
    claim: Rate,
    info: SignalInfo,
    window: UncertainWindow,
    cycles: Cycles,
}

impl Monitor for RateMonitor {
    #[inline]
    fn feed(&mut self, _slot: usize, seen: &TimedValue) {
        self.cycles.see(seen);
    }

    fn finish(self: Box<Self>) -> Finding {
        let RateMonitor { claim, info, window, cycles } = *self;
        finding(&claim, &info, &window, cycles.finish())
    }
}

fn finding(claim: &Rate, info: &SignalInfo, window: &UncertainWindow, found: CycleResult) -> Finding {
    // Edges that are hidden can make any figure.
    let open = found.doubtful;
    let mut finding = Finding {
        can_hold: open,
        can_break: open || found.can_be_missing,
        window: Some(window.shown()),
        ..Finding::default()
    };
    let mut extent: Option<Extent> = None;
    let mut cycles = (u64::MAX, 0);
    for stretch in &found.stretches {
        let figure = claim.kind.of(stretch);
        let (can_hold, can_break) = claim.band.hold(figure);
        finding.can_hold |= can_hold;
        finding.can_break |= can_break;
        cycles = (cycles.0.min(stretch.cycles), cycles.1.max(stretch.cycles));
        extent = Some(widened(extent, figure));
    }
    let unclear = || match found.doubtful {
        true => format!("`{}` is not known for a part of the window", info.name),
        false => String::from("the uncertainty of the instants reaches over a limit"),
    };
    let Some(extent) = extent else {
        finding.observed = format!("no whole cycle{}", claim.between.words());
        finding.reason = match finding.can_hold {
            true => unclear(),
            false => format!("`{}` has fewer than two edges in the window", info.name),
        };
        return finding;
    };
    let count = super::common::count_range(cycles);
    let noun = if cycles.1 == 1 { "cycle" } else { "cycles" };
    finding.observed = format!("{} over {count} {noun}", shown(extent, claim.band.unit));
    finding.margin = claim.band.margin(extent).map(|margin| Figure::new(margin, claim.band.unit));
    finding.uncertainty = spread(extent, claim.band.unit);
    finding.reason = if finding.can_hold { unclear() } else { claim.band.miss(extent) };
    match found.last {
        Some(seen) => finding.decided_by(&seen),
        None => finding,
    }
}
