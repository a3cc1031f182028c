//! `period`: the distances of successive edges of one kind.
//!
//! ```toml
//! { period = { signal = "clock", edge = "rises", is = "1 ms", tolerance = "2 us", from = "run" } }
//! ```
//! Every distance between two edges of the window counts; with fewer than two edges the claim fails.

use std::sync::Arc;

use document::{Diagnostic, Fields, KeySpec, KeyType};
use record::Figure;
use signal::{SignalInfo, Span};

use super::common::{
    FROM, LONGER, PlanWindow, SIGNAL, SingleSpan, SpanLimits, UNTIL, delay_words, signal, span_range, spans,
    width,
};
use super::{ClaimDemand, ExpectVerb, ReadContext, TraceClaim};
use crate::codes;
use crate::lang::Anchor;
use crate::monitor::edges::{CountedEdge, EdgeFinder};
use crate::monitor::pulses::FigureChain;
use crate::monitor::{
    CaseTimeline, Finding, Monitor, NotJudged, PulseRule, TimedValue, TraceSignals, UncertainWindow, slack,
};

/// `period`.
pub(super) const PERIOD: ExpectVerb = ExpectVerb {
    name: "period",
    doc: "Successive edges of a signal are as far apart as they should be, all of a window",
    keys: &[
        SIGNAL,
        KeySpec::optional(
            "edge",
            KeyType::Choice(&["rises", "falls", "changes"]),
            "Which edges; `rises` if left out",
        ),
        KeySpec::required(
            "is",
            KeyType::Range,
            "The distance that is allowed: \"0.9 ms .. 1.1 ms\", or one duration",
        ),
        KeySpec::optional("tolerance", KeyType::Duration, "How far it may be from the duration `is`"),
        FROM,
        UNTIL,
        LONGER,
    ],
    read,
};

/// The claim.
#[derive(Clone, Debug)]
struct PeriodClaim {
    signal: String,
    edge: CountedEdge,
    limits: SpanLimits,
    between: PlanWindow,
    longer_than: Option<Span>,
}

fn read(fields: &Fields<'_>, cx: &mut ReadContext<'_>) -> Option<Arc<dyn TraceClaim>> {
    let signal = signal(fields, "signal", cx);
    let between = PlanWindow::read(fields, cx);
    let node = fields.get("is")?;
    let mut limits = spans(node, "is", SingleSpan::Exactly, cx)?;
    if fields.has("tolerance") {
        let tolerance = fields.duration("tolerance")?.as_nanos();
        if limits.0 != limits.1 {
            let help = "write one duration for `is`, or leave `tolerance` out";
            cx.out.bad(codes::CLAIM, node, "`is` is a range already: `tolerance` says it twice", help);
            return None;
        }
        limits = (limits.0.saturating_sub(tolerance).max(0), limits.1.saturating_add(tolerance));
    }
    let edge = match fields.text("edge") {
        Some("falls") => CountedEdge::Falls,
        Some("changes") => CountedEdge::Changes,
        _ => CountedEdge::Rises,
    };
    let longer_than = fields.duration(LONGER.name);
    Some(Arc::new(PeriodClaim { signal: signal?, edge, limits, between: between?, longer_than }))
}

impl PeriodClaim {
    fn noun(&self) -> &'static str {
        match self.edge {
            CountedEdge::Rises => "rises",
            CountedEdge::Falls => "falls",
            _ => "changes",
        }
    }
}

impl TraceClaim for PeriodClaim {
    fn expected(&self) -> String {
        let (noun, limits) = (self.noun(), span_range(self.limits));
        format!("successive {noun} of `{}` are {limits} apart{}", self.signal, self.between.words())
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
        // A limit in nanoseconds that is none is beyond all time.
        Some(1e9 / self.limits.1.max(1) as f64)
    }

    fn pulses(&self, _: &SignalInfo) -> PulseRule {
        PulseRule::decides(self.longer_than)
    }

    fn start(&self, scene: &CaseTimeline<'_>) -> Result<Box<dyn Monitor>, NotJudged> {
        let info = scene.signal(&self.signal)?;
        let window = scene.window(&self.between.from, &self.between.until)?;
        let claim = PeriodClaim { limits: scene.clock.spans(self.limits), ..self.clone() };
        Ok(Box::new(PeriodMonitor {
            finder: EdgeFinder::new(self.edge.clone(), slack(info)),
            chain: FigureChain::new(window, claim.limits),
            claim,
            info: info.clone(),
            window,
            open: scene.is_open(&self.between.until),
        }))
    }
}

/// The judge.
struct PeriodMonitor {
    claim: PeriodClaim,
    info: SignalInfo,
    window: UncertainWindow,
    finder: EdgeFinder,
    chain: FigureChain,
    open: bool,
}

impl Monitor for PeriodMonitor {
    #[inline]
    fn feed(&mut self, _slot: usize, seen: &TimedValue) {
        if self.open {
            self.chain.advance(seen.a);
        }
        match self.finder.see(seen) {
            Some(found) if found.certain => self.chain.edge(seen),
            Some(found) => self.chain.unknown(&found.seen),
            None => {}
        }
    }

    fn lost(&mut self, now: i64) -> bool {
        // A window that may still end where it begins is not judged at all.
        (!self.open || now > self.window.from.b) && self.chain.lost()
    }

    fn finish(mut self: Box<Self>) -> Finding {
        if let Some(rest) = self.finder.rest() {
            self.chain.unknown(&rest.seen);
        }
        let spread = self.chain.finish();
        let mut finding = Finding {
            can_hold: spread.can_hold,
            can_break: spread.can_break || spread.can_be_missing,
            beyond_help: spread.deciding.is_some_and(|found| found.extent.1 < self.claim.limits.0),
            window: Some(self.window.shown()),
            ..Finding::default()
        };
        let noun = self.claim.noun();
        let Some(deciding) = spread.deciding else {
            finding.observed = format!("fewer than two {noun}{}", self.claim.between.words());
            finding.reason = match spread.doubtful {
                true => format!("`{}` is not known for a part of the window", self.info.name),
                false => String::from("there is no distance to judge"),
            };
            return finding;
        };
        let extent = spread.extent.unwrap_or(deciding.extent);
        finding.observed = format!("{} distances, {}", spread.count, span_range(extent));
        finding.margin = deciding.margin.map(|margin| Figure::span(Span::from_nanos(margin)));
        finding.uncertainty = width(deciding.extent);
        let from = &self.window.from;
        let delay = (deciding.seen.a.saturating_sub(from.b), deciding.seen.b.saturating_sub(from.a));
        let when = delay_words(delay, &self.claim.between.from);
        finding.reason = match (spread.can_hold, spread.doubtful) {
            (false, _) => format!("a distance of {} that ends {when}", span_range(deciding.extent)),
            (true, true) => format!("`{}` is not known for a part of the window", self.info.name),
            (true, false) => String::from("the uncertainty of the instants reaches over a limit"),
        };
        finding.decided_by(&deciding.seen)
    }
}
