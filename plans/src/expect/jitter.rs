//! `jitter`: how far the edges of a pulse train come off an even grid, or how much its periods differ.
//!
//! ```toml
//! { jitter = { signal = "pulses", max = "200 ns", from = "train", until = "train.done" } }
//! { jitter = { signal = "pulses", compares = "periods", take = "rms", grid = "100 kHz", max = "50 ns" } }
//! ```
//! The figures are defined in [`crate::monitor::jitter`]. With fewer than three edges the claim fails.

use std::fmt;
use std::sync::Arc;

use document::{Diagnostic, Fields, KeySpec, KeyType};
use record::Figure;
use signal::{SignalInfo, Span};

use super::band::{FigureBand, IS_RANGE, NEVER_NEGATIVE, shown, spread};
use super::common::{FROM, LONGER, PlanWindow, SIGNAL, UNTIL, count_range, delay_words, signal};
use super::condition::{MAX, MIN};
use super::{ClaimDemand, ExpectVerb, ReadContext, TraceClaim};
use crate::codes;
use crate::lang::{Anchor, millihertz};
use crate::monitor::edges::CountedEdge;
use crate::monitor::jitter::{Grid, Jitter, JitterQuery, JitterReference, JitterResult};
use crate::monitor::{
    CaseTimeline, ClockLimits, ClockedFigure, Finding, Monitor, NotJudged, Number, NumberLimits, PulseRule,
    TimedValue, TraceSignals, UncertainWindow, slack,
};

/// What is compared.
pub(crate) const COMPARES: KeySpec = KeySpec::optional(
    "compares",
    KeyType::Choice(&["edges", "periods"]),
    "What jitter is measured from: the distances of edges from an even grid, or the lengths of periods; `edges` if left out",
);
/// The grid.
pub(crate) const GRID: KeySpec = KeySpec::optional(
    "grid",
    KeyType::Text,
    "The frequency or the period of the grid of `jitter`, as in \"100 kHz\" or \"10 us\"; what suits the edges best if left out",
);

/// `jitter`.
pub(super) const JITTER: ExpectVerb = ExpectVerb {
    name: "jitter",
    doc: "The edges of a signal keep to an even grid, or its periods have one length, to within limits",
    keys: &[
        SIGNAL,
        IS_RANGE,
        MIN,
        MAX,
        COMPARES,
        KeySpec::optional(
            "take",
            KeyType::Choice(&["span", "rms"]),
            "From the least to the greatest, or the root of the mean square; `span` if left out",
        ),
        GRID,
        KeySpec::optional(
            "edge",
            KeyType::Choice(&["rises", "falls", "changes"]),
            "Which edges; `rises` if left out",
        ),
        FROM,
        UNTIL,
        LONGER,
    ],
    read,
};

/// The claim.
#[derive(Clone, Debug)]
struct JitterClaim {
    signal: String,
    asked: JitterQuery,
    edge: CountedEdge,
    band: FigureBand,
    between: PlanWindow,
    longer_than: Option<Span>,
}

fn read(fields: &Fields<'_>, cx: &mut ReadContext<'_>) -> Option<Arc<dyn TraceClaim>> {
    let signal = signal(fields, "signal", cx);
    let between = PlanWindow::read(fields, cx);
    let asked = asked(fields, cx);
    let band = FigureBand::read(fields, "jitter", "ns", cx)?.of_kind(NEVER_NEGATIVE);
    let NumberLimits { min, max } = band.limits;
    let nothing_is_it = max.is_some_and(|max| max.is_below(Number::ZERO));
    if nothing_is_it || max.is_none() && min.is_none_or(|min| !min.is_above(Number::ZERO)) {
        let message = "a jitter is never below 0";
        cx.out.error(
            codes::CLAIM,
            cx.place.clone(),
            message,
            "say how large it may be, as in max = \"200 ns\"",
        );
        return None;
    }
    let edge = match fields.text("edge") {
        Some("falls") => CountedEdge::Falls,
        Some("changes") => CountedEdge::Changes,
        _ => CountedEdge::Rises,
    };
    let longer_than = fields.duration(LONGER.name);
    Some(Arc::new(JitterClaim { signal: signal?, asked: asked?, edge, band, between: between?, longer_than }))
}

/// Reads `compares`, `take` and `grid`.
pub(crate) fn asked(fields: &Fields<'_>, cx: &mut ReadContext<'_>) -> Option<JitterQuery> {
    let compared = match fields.text("compares") {
        Some("periods") => JitterReference::Periods,
        _ => JitterReference::Edges,
    };
    let rms = fields.text("take") == Some("rms");
    let Some(node) = fields.get("grid") else {
        return (!fields.has("grid")).then_some(JitterQuery { compared, rms, grid: None });
    };
    let grid = node.as_text().and_then(grid);
    let Some(grid) = grid else {
        let message = "`grid` is neither a frequency nor a period";
        cx.out.bad(codes::GRID, node, message, "write it as \"100 kHz\" or \"10 us\"");
        return None;
    };
    if compared == JitterReference::Periods && !rms {
        let message = "how far periods lie apart does not depend on a grid";
        cx.out.bad(codes::GRID, node, message, "remove `grid`, or take = \"rms\"");
        return None;
    }
    Some(JitterQuery { compared, rms, grid: Some(grid) })
}

fn grid(text: &str) -> Option<Grid> {
    const NANOS_IN_A_MILLIHERTZ: u64 = 1_000_000_000_000;
    if let Some(rate) = millihertz(text).filter(|rate| *rate > 0) {
        let divisor = common_divisor(NANOS_IN_A_MILLIHERTZ, rate);
        return Some(Grid { nanos: NANOS_IN_A_MILLIHERTZ / divisor, parts: rate / divisor });
    }
    let period = Span::parse(text).ok().and_then(|period| u64::try_from(period.as_nanos()).ok());
    period.filter(|nanos| *nanos > 0).map(|nanos| Grid { nanos, parts: 1 })
}

const fn common_divisor(mut a: u64, mut b: u64) -> u64 {
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a
}

impl fmt::Display for JitterQuery {
    /// `rms jitter of the periods`, `peak-to-peak jitter of the edges`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.rms { "rms jitter of the " } else { "peak-to-peak jitter of the " })?;
        f.write_str(match self.compared {
            JitterReference::Edges => "edges",
            JitterReference::Periods => "periods",
        })
    }
}

impl TraceClaim for JitterClaim {
    fn expected(&self) -> String {
        format!("the {} of `{}` is {}{}", self.asked, self.signal, self.band, self.between.words())
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
        Some(0.0)
    }

    fn pulses(&self, _: &SignalInfo) -> PulseRule {
        PulseRule::decides(self.longer_than)
    }

    fn start(&self, scene: &CaseTimeline<'_>) -> Result<Box<dyn Monitor>, NotJudged> {
        let info = scene.signal(&self.signal)?;
        let window = scene.window(&self.between.from, &self.between.until)?;
        Ok(Box::new(JitterMonitor {
            claim: self.clone(),
            info: info.clone(),
            clock: scene.clock,
            window,
            jitter: Jitter::new(self.asked, self.edge.clone(), window, slack(info)),
        }))
    }
}

/// The judge.
struct JitterMonitor {
    claim: JitterClaim,
    info: SignalInfo,
    clock: ClockLimits,
    window: UncertainWindow,
    jitter: Jitter,
}

impl Monitor for JitterMonitor {
    #[inline]
    fn feed(&mut self, _slot: usize, seen: &TimedValue) {
        self.jitter.see(seen);
    }

    fn finish(self: Box<Self>) -> Finding {
        let JitterMonitor { mut claim, info, clock, window, jitter } = *self;
        let found = jitter.finish();
        // A given grid is true time, against which the edges wander; any other is one of the same clock.
        claim.band = match claim.asked.grid {
            Some(_) => claim.band.by_true_grid(clock, found.wanders_over),
            None => claim.band.by_clock(clock, ClockedFigure::Time),
        };
        finding(&claim, &info, &window, &found)
    }
}

fn finding(
    claim: &JitterClaim,
    info: &SignalInfo,
    window: &UncertainWindow,
    found: &JitterResult,
) -> Finding {
    // Edges that are hidden can make any figure.
    let open = found.doubtful;
    let mut finding = Finding {
        can_hold: open,
        can_break: open || found.can_be_missing,
        window: Some(window.shown()),
        ..Finding::default()
    };
    let unclear = || match found.doubtful {
        true => format!("`{}` is not known for a part of the window", info.name),
        false => String::from("the uncertainty of the instants reaches over a limit"),
    };
    let Some(extent) = found.extent else {
        finding.observed = format!("fewer than three edges{}", claim.between.words());
        finding.reason = match finding.can_hold {
            true => unclear(),
            false => format!("`{}` has fewer than three edges in the window", info.name),
        };
        return finding;
    };
    let (can_hold, can_break) = claim.band.hold(extent);
    finding.can_hold |= can_hold;
    finding.can_break |= can_break;
    let edges = count_range(found.edges);
    finding.observed = format!("{} over {edges} edges", shown(extent, claim.band.unit));
    finding.margin = claim.band.margin(extent).map(|margin| Figure::new(margin, claim.band.unit));
    finding.uncertainty = spread(extent, claim.band.unit);
    finding.reason = if finding.can_hold { unclear() } else { claim.band.miss(extent) };
    let Some((late, early)) = found.farthest else { return finding };
    if !finding.can_hold {
        let from = &window.from;
        let words = |seen: &TimedValue| {
            delay_words((seen.a.saturating_sub(from.b), seen.b.saturating_sub(from.a)), &claim.between.from)
        };
        finding.reason = match claim.asked.compared {
            JitterReference::Edges => format!(
                "{}: the latest edge against the grid came {}, the earliest {}",
                finding.reason,
                words(&late),
                words(&early)
            ),
            JitterReference::Periods => format!(
                "{}: the longest period ended {}, the shortest {}",
                finding.reason,
                words(&late),
                words(&early)
            ),
        };
    }
    finding.decided_by(&late)
}
