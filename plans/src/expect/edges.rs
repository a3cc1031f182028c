//! `edges`: a signal has so many rising and falling edges in a window.
//!
//! ```toml
//! { edges = { signal = "HSC0.out0", rising = 1, falling = "1 .. 2", from = "train" } }
//! ```
//! An edge at the very beginning of the window counts, one at its very end does not.

use std::sync::Arc;

use document::{Diagnostic, Fields, KeySpec, KeyType};
use record::Figure;
use signal::{SignalInfo, Value};

use super::common::{FROM, LONGER, PlanWindow, SIGNAL, UNTIL, count_margin, count_range, counts, signal};
use super::{ClaimDemand, ExpectVerb, ReadContext, TraceClaim};
use crate::codes;
use crate::lang::Anchor;
use crate::monitor::count::{CountResult, EdgeCounter};
use crate::monitor::edges::{CountedEdge, EdgeFinder};
use crate::monitor::{
    CaseTimeline, Finding, Monitor, NotJudged, PulseRule, TimedValue, TraceSignals, UncertainWindow, slack,
};

/// `edges`.
pub(super) const EDGES: ExpectVerb = ExpectVerb {
    name: "edges",
    doc: "A signal has so many rising and falling edges in a window",
    keys: &[
        SIGNAL,
        KeySpec::optional("rising", KeyType::Range, "How many rising edges: 1, or \"1 .. 3\", or \"2 ..\""),
        KeySpec::optional("falling", KeyType::Range, "How many falling edges, written like `rising`"),
        FROM,
        UNTIL,
        LONGER,
    ],
    read,
};

type Range = (u64, u64);

/// The claim.
#[derive(Clone, Debug)]
struct EdgesClaim {
    signal: String,
    rising: Option<Range>,
    falling: Option<Range>,
    between: PlanWindow,
    longer_than: Option<signal::Span>,
    /// The signal counts entries of a log.
    entries: bool,
}

fn read(fields: &Fields<'_>, cx: &mut ReadContext<'_>) -> Option<Arc<dyn TraceClaim>> {
    let signal = signal(fields, "signal", cx);
    let between = PlanWindow::read(fields, cx);
    let mut range = |key| match fields.get(key) {
        Some(node) => counts(node, key, cx).map(Some),
        None if fields.has(key) => None,
        None => Some(None),
    };
    let (rising, falling) = (range("rising"), range("falling"));
    let (rising, falling) = (rising?, falling?);
    if rising.is_none() && falling.is_none() {
        let message = "no number of edges is wanted: the claim can never fail";
        cx.out.error(codes::CLAIM, cx.place.clone(), message, "give `rising`, `falling` or both");
        return None;
    }
    let any = |range: Option<Range>| range.is_none_or(|range| range == (0, u64::MAX));
    if any(rising) && any(falling) {
        let node = fields.get("rising").or_else(|| fields.get("falling"))?;
        let message = "any number of edges is right: the claim can never fail";
        cx.out.bad(codes::CLAIM, node, message, "give a least or a greatest number");
        return None;
    }
    let longer_than = fields.duration(LONGER.name);
    let (signal, between) = (signal?, between?);
    Some(Arc::new(EdgesClaim { signal, rising, falling, between, longer_than, entries: false }))
}

/// Reads the window in which no entry of a log is added.
pub(super) fn read_none(
    fields: &Fields<'_>,
    signal: Option<String>,
    cx: &mut ReadContext<'_>,
) -> Option<Arc<dyn TraceClaim>> {
    let between = PlanWindow::read(fields, cx)?;
    let rising = Some((0, 0));
    let claim =
        EdgesClaim { signal: signal?, rising, falling: None, between, longer_than: None, entries: true };
    Some(Arc::new(claim))
}

impl TraceClaim for EdgesClaim {
    fn expected(&self) -> String {
        if self.entries {
            return format!("no `{}` is added{}", self.signal, self.between.words());
        }
        let part = |range: Option<Range>, word| range.map(|range| format!("{} {word}", count_range(range)));
        let parts = [part(self.rising, "rising"), part(self.falling, "falling")];
        let parts: Vec<String> = parts.into_iter().flatten().collect();
        format!("`{}` has edges: {}{}", self.signal, parts.join(" and "), self.between.words())
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
        let wanted = [self.rising, self.falling].into_iter().flatten().any(|range| range.0 > 0);
        let change = wanted.then_some(ClaimDemand::Change(&self.signal));
        change.into_iter().chain([self.between.demand()]).collect()
    }

    fn counts(&self) -> Option<f64> {
        // Entries of a log are no pulses.
        (!self.entries).then_some(0.0)
    }

    fn pulses(&self, _: &SignalInfo) -> PulseRule {
        PulseRule::decides(self.longer_than)
    }

    fn start(&self, scene: &CaseTimeline<'_>) -> Result<Box<dyn Monitor>, NotJudged> {
        let info = scene.signal(&self.signal)?;
        let window = scene.window(&self.between.from, &self.between.until)?;
        let finder = |edge| EdgeFinder::new(edge, slack(info));
        Ok(Box::new(EdgesMonitor {
            claim: self.clone(),
            window,
            rises: finder(CountedEdge::Rises),
            falls: finder(CountedEdge::Falls),
            counter: EdgeCounter::new(window),
            info: info.clone(),
            open: scene.is_open(&self.between.until),
            deciding: None,
            wanted: [(self.rising, 0), (self.falling, 0)],
        }))
    }
}

/// The judge.
struct EdgesMonitor {
    claim: EdgesClaim,
    info: SignalInfo,
    window: UncertainWindow,
    rises: EdgeFinder,
    falls: EdgeFinder,
    counter: EdgeCounter,
    /// The end of the window is still to come.
    open: bool,
    /// The edge that is one too many, else the last one.
    deciding: Option<TimedValue>,
    /// What is wanted, and how many possible ones there were.
    wanted: [(Option<Range>, u64); 2],
}

impl EdgesMonitor {
    fn note(&mut self, rising: bool, seen: &TimedValue) {
        if !self.window.can_hold(seen) {
            return;
        }
        let over = self.wanted.iter().any(|(range, seen)| range.is_some_and(|range| *seen > range.1));
        let (range, count) = &mut self.wanted[usize::from(!rising)];
        *count += 1;
        if range.is_some() && !over {
            self.deciding = Some(*seen);
        }
    }
}

impl Monitor for EdgesMonitor {
    #[inline]
    fn feed(&mut self, _slot: usize, seen: &TimedValue) {
        if self.open {
            self.counter.advance(seen.a);
        }
        let rose = self.rises.see(seen);
        let fell = self.falls.see(seen);
        match (rose, fell) {
            (Some(found), _) | (_, Some(found)) if !found.certain => self.counter.unknown(&found.seen),
            (Some(_), _) => {
                self.counter.edge(true, seen);
                self.note(true, seen);
            }
            (_, Some(_)) => {
                self.counter.edge(false, seen);
                self.note(false, seen);
            }
            _ => {}
        }
    }

    fn lost(&mut self, now: i64) -> bool {
        // A window that may still end where it begins is not judged at all.
        if self.open && now <= self.window.from.b {
            return false;
        }
        let certain = self.counter.certain();
        let over = |range: Option<Range>, count| range.is_some_and(|range| count > range.1);
        over(self.claim.rising, certain.0) || over(self.claim.falling, certain.1)
    }

    fn finish(mut self: Box<Self>) -> Finding {
        if let Some(rest) = self.rises.rest() {
            self.counter.unknown(&rest.seen);
        }
        let counted = std::mem::replace(&mut self.counter, EdgeCounter::new(self.window)).finish();
        self.finding(&counted)
    }
}

impl EdgesMonitor {
    fn finding(self, counted: &CountResult) -> Finding {
        let inside =
            |range: Option<Range>, n: u64| range.is_none_or(|(least, most)| (least..=most).contains(&n));
        let below = |range: Option<Range>, n: u64| range.is_none_or(|(_, most)| n <= most);
        let right = |&(rising, falling): &(u64, u64)| {
            inside(self.claim.rising, rising) && inside(self.claim.falling, falling)
        };
        let may_be = |&(rising, falling): &(u64, u64)| {
            below(self.claim.rising, rising) && below(self.claim.falling, falling)
        };
        let column = |pick: fn(&(u64, u64)) -> u64| {
            let least = counted.counts.iter().map(pick).min().unwrap_or(0);
            (least, counted.counts.iter().map(pick).max().unwrap_or(0))
        };
        let (rising, falling) = (column(|counts| counts.0), column(|counts| counts.1));
        let overlaps = |range: Option<Range>, seen: Range| {
            range.is_none_or(|range| range.0 <= seen.1 && seen.0 <= range.1)
        };
        // Unseen pulses can only add edges.
        let few_enough = counted.counts.iter().any(may_be);
        let can_hold = match (counted.hidden, counted.exact) {
            (true, _) => few_enough,
            (false, true) => counted.counts.iter().any(right),
            (false, false) => overlaps(self.claim.rising, rising) && overlaps(self.claim.falling, falling),
        };
        let can_break = counted.hidden || !counted.exact || !counted.counts.iter().all(right);
        let part =
            |wanted: bool, seen: Range, word: &str| wanted.then(|| format!("{} {word}", count_range(seen)));
        let risen = if self.claim.entries { "added" } else { "rising" };
        let parts = [
            part(self.claim.rising.is_some(), rising, risen),
            part(self.claim.falling.is_some(), falling, "falling"),
        ];
        let parts: Vec<String> = parts.into_iter().flatten().collect();
        let margin = |range: Option<Range>, seen: Range| count_margin(seen, range?);
        let margins = [margin(self.claim.rising, rising), margin(self.claim.falling, falling)];
        let margin = margins.into_iter().flatten().reduce(f64::min);
        let spread = (rising.1 - rising.0).max(falling.1 - falling.0);
        let noun = if self.claim.entries { "entries" } else { "edges" };
        let mut finding = Finding {
            can_hold,
            can_break,
            beyond_help: !few_enough,
            observed: parts.join(" and "),
            margin: margin.map(|margin| Figure::new(margin, noun)),
            uncertainty: (spread > 0).then(|| Figure::new(spread as f64, noun)),
            window: Some(self.window.shown()),
            ..Finding::default()
        };
        finding.reason = match (can_hold, counted.hidden) {
            (false, _) => format!("there were {}", parts.join(" and ")),
            (true, true) => format!("`{}` is not known for a part of the window", self.info.name),
            (true, false) => {
                String::from("which edges lie in the window is open within the uncertainty of the instants")
            }
        };
        let shown = self.rises.value().map(|value: Value| self.info.show(value));
        if let (Some(value), true) = (shown, counted.counts.iter().all(|counts| *counts == (0, 0))) {
            finding.nearest_miss = Some((format!("`{}` was {value} at the end", self.info.name), None));
        }
        match self.deciding {
            Some(seen) => finding.decided_by(&seen),
            None => finding,
        }
    }
}
