//! `frames`: how many frames come on a bus, how far apart, and with which longest gap.
//!
//! ```toml
//! { frames = { frame = "heartbeat", count = "9 .. 11", cycle = "100 ms ± 5 ms", max-gap = "150 ms", from = "run" } }
//! ```
//! A name of `frames` counts those that were on their bus: every further one is one of the window. The gap is looked at
//! from the beginning of the window to its first frame and from its last frame to its end, too.

use std::sync::Arc;

use document::{Diagnostic, Fields, KeySpec, KeyType};
use record::Figure;
use signal::{SignalInfo, Span, ValueKind};

use super::common::{
    FROM, PlanWindow, SingleSpan, SpanLimits, UNTIL, count_margin, count_range, counts, signal, span_range,
    spans, width,
};
use super::{ClaimDemand, ExpectVerb, ReadContext, TraceClaim};
use crate::codes;
use crate::lang::Anchor;
use crate::monitor::count::EdgeCounter;
use crate::monitor::edges::{CountedEdge, EdgeFinder};
use crate::monitor::gaps::{GapResult, Gaps};
use crate::monitor::pulses::FigureChain;
use crate::monitor::{
    CaseTimeline, Finding, Monitor, NotJudged, PulseRule, TimedValue, TraceSignals, UncertainWindow, slack,
};

/// `frames`.
pub(super) const FRAMES: ExpectVerb = ExpectVerb {
    name: "frames",
    doc: "So many frames come on a bus in a window, so far apart, without a longer gap",
    keys: &[
        KeySpec::required("frame", KeyType::SignalRef, "The frames, a name of `frames`"),
        KeySpec::optional("count", KeyType::Range, "How many: 1, or \"1 .. 3\", or \"2 ..\""),
        KeySpec::optional(
            "cycle",
            KeyType::Range,
            "How far each is from the one before: \"100 ms ± 5 ms\", or one duration",
        ),
        KeySpec::optional(
            "max-gap",
            KeyType::Duration,
            "The longest time without one, the ends of the window included",
        )
        .was("gap"),
        FROM,
        UNTIL,
    ],
    read,
};

/// The claim.
#[derive(Clone, Debug)]
struct FramesClaim {
    signal: String,
    count: Option<(u64, u64)>,
    cycle: Option<SpanLimits>,
    gap: Option<i64>,
    between: PlanWindow,
}

fn read(fields: &Fields<'_>, cx: &mut ReadContext<'_>) -> Option<Arc<dyn TraceClaim>> {
    let signal = signal(fields, "frame", cx);
    let between = PlanWindow::read(fields, cx);
    let count = match fields.get("count") {
        Some(node) => Some(counts(node, "count", cx)?),
        None => None,
    };
    let cycle = match fields.get("cycle") {
        Some(node) => Some(spans(node, "cycle", SingleSpan::Exactly, cx)?),
        None => None,
    };
    let gap = fields.duration("max-gap").map(Span::as_nanos);
    if count.is_none() && cycle.is_none() && gap.is_none() {
        let help = "give `count`, `cycle`, `max-gap` or several of them";
        cx.out.error(codes::CLAIM, cx.place.clone(), "nothing is said of the frames", help);
        return None;
    }
    if let Some(node) = fields.get("count").filter(|_| count == Some((0, u64::MAX))) {
        let message = "any number of frames is right: the claim can never fail";
        cx.out.bad(codes::CLAIM, node, message, "give a least or a greatest number");
        return None;
    }
    let none = count == Some((0, 0));
    if let Some(node) = fields.get("cycle").or_else(|| fields.get("max-gap")).filter(|_| none) {
        let message = "no frame is wanted, so none has a distance from another";
        cx.out.bad(codes::CLAIM, node, message, "remove it, or allow frames");
        return None;
    }
    Some(Arc::new(FramesClaim { signal: signal?, count, cycle, gap, between: between? }))
}

impl TraceClaim for FramesClaim {
    fn expected(&self) -> String {
        let mut parts = Vec::new();
        if let Some(count) = self.count {
            parts.push(match count {
                (0, 0) => String::from("does not come"),
                (1, 1) => String::from("comes once"),
                count => format!("comes {} times", count_range(count)),
            });
        }
        if let Some(cycle) = self.cycle {
            let comes = if parts.is_empty() { "comes " } else { "" };
            parts.push(format!("{comes}every {}", span_range(cycle)));
        }
        if let Some(gap) = self.gap {
            let has = if parts.is_empty() { "has no gap" } else { "with no gap" };
            parts.push(format!("{has} over {}", Span::from_nanos(gap)));
        }
        format!("`{}` {}{}", self.signal, parts.join(", "), self.between.words())
    }

    fn signals(&self) -> Vec<String> {
        vec![self.signal.clone()]
    }

    fn anchors(&self) -> Vec<&Anchor> {
        self.between.anchors()
    }

    fn check(&self, wiring: &TraceSignals<'_>, out: &mut Vec<Diagnostic>) {
        let Some(info) = super::known(&self.signal, wiring, out) else { return };
        let counts = matches!(info.kind, ValueKind::Int | ValueKind::Word);
        let why = || format!("`{}` does not count anything: name frames without `signal`", info.name);
        super::meant(
            if counts { Ok(()) } else { Err(why()) },
            "name the frames: frames = { bus = \"machine\", id = 0x181 }",
            out,
        );
    }

    fn demands(&self) -> Vec<ClaimDemand<'_>> {
        let wanted = self.count.is_some_and(|count| count.0 > 0) || self.cycle.is_some();
        let change = wanted.then_some(ClaimDemand::Change(&self.signal));
        change.into_iter().chain([self.between.demand()]).collect()
    }

    fn pulses(&self, _: &SignalInfo) -> PulseRule {
        PulseRule::decides(None)
    }

    fn start(&self, scene: &CaseTimeline<'_>) -> Result<Box<dyn Monitor>, NotJudged> {
        let info = scene.signal(&self.signal)?;
        let window = scene.window(&self.between.from, &self.between.until)?;
        Ok(Box::new(FramesMonitor {
            finder: EdgeFinder::new(CountedEdge::Rises, slack(info)),
            counter: EdgeCounter::new(window),
            chain: self.cycle.map(|cycle| FigureChain::new(window, scene.clock.spans(cycle))),
            gaps: self.gap.map(|gap| Gaps::new(window, scene.clock.most(gap))),
            claim: self.clone(),
            info: info.clone(),
            window,
            open: scene.is_open(&self.between.until),
            last: None,
            excess: None,
            seen: 0,
        }))
    }
}

/// The judge.
struct FramesMonitor {
    claim: FramesClaim,
    info: SignalInfo,
    window: UncertainWindow,
    finder: EdgeFinder,
    counter: EdgeCounter,
    chain: Option<FigureChain>,
    gaps: Option<Gaps>,
    open: bool,
    /// The last frame that may be in the window, the first that is one too many, and how many there were.
    last: Option<TimedValue>,
    excess: Option<TimedValue>,
    seen: u64,
}

impl FramesMonitor {
    fn frame(&mut self, seen: &TimedValue) {
        self.counter.edge(true, seen);
        if let Some(chain) = &mut self.chain {
            chain.edge(seen);
        }
        if let Some(gaps) = &mut self.gaps {
            gaps.frame(seen);
        }
        if self.window.can_hold(seen) {
            self.seen += 1;
            self.last = Some(*seen);
            if self.excess.is_none() && self.claim.count.is_some_and(|count| self.seen > count.1) {
                self.excess = Some(*seen);
            }
        }
    }

    fn unknown(&mut self, seen: &TimedValue) {
        self.counter.unknown(seen);
        if let Some(chain) = &mut self.chain {
            chain.unknown(seen);
        }
        if let Some(gaps) = &mut self.gaps {
            gaps.unknown(seen);
        }
    }
}

impl Monitor for FramesMonitor {
    #[inline]
    fn feed(&mut self, _slot: usize, seen: &TimedValue) {
        if self.open {
            self.counter.advance(seen.a);
            if let Some(chain) = &mut self.chain {
                chain.advance(seen.a);
            }
            if let Some(gaps) = &mut self.gaps {
                gaps.advance(seen.a);
            }
        }
        match self.finder.see(seen) {
            Some(found) if found.certain => self.frame(seen),
            Some(found) => self.unknown(&found.seen),
            None => {}
        }
    }

    fn lost(&mut self, now: i64) -> bool {
        // A window that may still end where it begins is not judged at all.
        if self.open && now <= self.window.from.b {
            return false;
        }
        let over = self.claim.count.is_some_and(|count| self.counter.certain().0 > count.1);
        over || self.chain.as_ref().is_some_and(FigureChain::lost)
            || self.gaps.as_ref().is_some_and(Gaps::lost)
    }

    fn finish(mut self: Box<Self>) -> Finding {
        if let Some(rest) = self.finder.rest() {
            self.unknown(&rest.seen);
        }
        let mut parts = Vec::new();
        if let Some(count) = self.claim.count {
            let counter = std::mem::replace(&mut self.counter, EdgeCounter::new(self.window));
            parts.push(self.counted(count, counter));
        }
        if let Some(chain) = self.chain.take() {
            parts.push(self.spread(chain));
        }
        if let Some(gaps) = self.gaps.take() {
            parts.push(self.gap(gaps.finish()));
        }
        let observed: Vec<&str> = parts.iter().map(|part| part.observed.as_str()).collect();
        let observed = observed.join(", ");
        let (can_hold, can_break) =
            (parts.iter().all(|part| part.can_hold), parts.iter().any(|part| part.can_break));
        // The worst part speaks for all of them, the first of several.
        let worst = parts.into_iter().rev().max_by_key(Finding::verdict).unwrap_or_default();
        Finding { can_hold, can_break, observed, window: Some(self.window.shown()), ..worst }
    }
}

impl FramesMonitor {
    /// Why a part is not known.
    fn hidden(&self) -> String {
        format!("`{}` is not known for a part of the window", self.info.name)
    }

    fn counted(&self, (least, most): (u64, u64), counter: EdgeCounter) -> Finding {
        let counted = counter.finish();
        let numbers = counted.counts.iter().map(|counts| counts.0);
        let seen = (numbers.clone().min().unwrap_or(0), numbers.max().unwrap_or(0));
        // Hidden frames can only be more.
        let can_hold = match counted.hidden {
            true => seen.0 <= most,
            false if counted.exact => counted.counts.iter().any(|(n, _)| (least..=most).contains(n)),
            false => least <= seen.1 && seen.0 <= most,
        };
        let inside = counted.counts.iter().all(|(n, _)| (least..=most).contains(n));
        let noun = if seen == (1, 1) { "frame" } else { "frames" };
        let observed = format!("{} {noun}", count_range(seen));
        let finding = Finding {
            can_hold,
            can_break: counted.hidden || !counted.exact || !inside,
            reason: match (can_hold, counted.hidden) {
                (false, _) => format!("there were {observed}"),
                (true, true) => self.hidden(),
                (true, false) => String::from(
                    "which frames lie in the window is open within the uncertainty of the instants",
                ),
            },
            observed,
            margin: count_margin(seen, (least, most)).map(|margin| Figure::new(margin, "frames")),
            uncertainty: (seen.0 < seen.1).then(|| Figure::new((seen.1 - seen.0) as f64, "frames")),
            ..Finding::default()
        };
        match self.excess.or(self.last) {
            Some(seen) => finding.decided_by(&seen),
            None => finding,
        }
    }

    fn spread(&self, chain: FigureChain) -> Finding {
        let spread = chain.finish();
        let mut finding = Finding {
            can_hold: spread.can_hold,
            can_break: spread.can_break || spread.can_be_missing,
            ..Finding::default()
        };
        let Some(deciding) = spread.deciding else {
            finding.observed = String::from("fewer than two frames");
            finding.reason = match spread.doubtful {
                true => self.hidden(),
                false => String::from("there is no distance to judge"),
            };
            return finding;
        };
        let extent = spread.extent.unwrap_or(deciding.extent);
        let noun = if spread.count == 1 { "distance" } else { "distances" };
        finding.observed = format!("{} {noun}, {}", spread.count, span_range(extent));
        finding.margin = deciding.margin.map(|margin| Figure::span(Span::from_nanos(margin)));
        finding.uncertainty = width(deciding.extent);
        finding.reason = match (spread.can_hold, spread.doubtful) {
            (false, _) => format!("a distance of {}", span_range(deciding.extent)),
            (true, true) => self.hidden(),
            (true, false) => String::from("the uncertainty of the instants reaches over a limit"),
        };
        finding.decided_by(&deciding.seen)
    }

    fn gap(&self, gap: GapResult) -> Finding {
        let longest = span_range(gap.longest);
        let finding = Finding {
            can_hold: gap.can_hold,
            can_break: gap.can_break,
            observed: format!("longest gap {longest}"),
            margin: Some(Figure::span(Span::from_nanos(gap.limit.saturating_sub(gap.longest.1)))),
            uncertainty: width(gap.longest),
            reason: match (gap.can_hold, gap.doubtful) {
                (false, _) => format!("a gap of {longest}"),
                (true, true) => self.hidden(),
                (true, false) => String::from("the uncertainty of the instants reaches over the limit"),
            },
            ..Finding::default()
        };
        match gap.after {
            Some(seen) => finding.decided_by(&seen),
            None => finding,
        }
    }
}
