//! `order`: edges of several signals come in the order in which they are listed.
//!
//! ```toml
//! { order = { edges = ["main rises", "delta falls", "star rises"], from = "start-button" } }
//! ```
//! Each is the first edge of its kind at or after `from`. Edges at one instant are in order if the trace has
//! them so.

use std::sync::Arc;

use document::{Data, Diagnostic, Fields, KeySpec, KeyType, Node};
use record::Figure;
use signal::{SignalInfo, Span};

use super::common::{FROM, LONGER, anchor, delay_words};
use super::{ClaimDemand, ExpectVerb, ReadContext, TraceClaim};
use crate::codes;
use crate::lang::Anchor;
use crate::monitor::edges::{CountedEdge, Delay, EdgeFinder, FirstEdge};
use crate::monitor::{
    CaseTimeline, Finding, Monitor, NotJudged, PulseRule, TimedValue, TraceSignals, UncertainInstant, slack,
};

/// `order`.
pub(super) const ORDER: ExpectVerb = ExpectVerb {
    name: "order",
    doc: "Edges of several signals come in the order in which they are listed",
    keys: &[
        KeySpec::required(
            "edges",
            KeyType::List(&KeyType::Text),
            "Two or more of `signal rises`, `signal falls`, `signal changes`",
        ),
        FROM,
        LONGER,
    ],
    read,
};

/// Most edges in one claim.
const MOST: usize = 32;

/// The claim.
#[derive(Clone, Debug)]
struct OrderClaim {
    edges: Vec<(String, CountedEdge)>,
    from: Anchor,
    longer_than: Option<Span>,
}

fn read(fields: &Fields<'_>, cx: &mut ReadContext<'_>) -> Option<Arc<dyn TraceClaim>> {
    let from = anchor(fields, "from", Anchor::START, cx);
    let list = fields.each("edges");
    if !(2..=MOST).contains(&list.len()) {
        let node = fields.get("edges")?;
        cx.out.bad(
            codes::CLAIM,
            node,
            format!("an order takes 2 to {MOST} edges"),
            "write edges = [\"a rises\", \"b rises\"]",
        );
        return None;
    }
    let mut edges = Vec::new();
    for node in list {
        edges.push(read_edge(node, cx)?);
    }
    let longer_than = fields.duration(LONGER.name);
    Some(Arc::new(OrderClaim { edges, from: from?, longer_than }))
}

/// Reads `signal rises`.
fn read_edge(node: &Node, cx: &mut ReadContext<'_>) -> Option<(String, CountedEdge)> {
    let text = node.as_text()?;
    let edge = match text.rsplit_once(char::is_whitespace) {
        Some((name, "rises")) => Some((name, CountedEdge::Rises)),
        Some((name, "falls")) => Some((name, CountedEdge::Falls)),
        Some((name, "changes")) => Some((name, CountedEdge::Changes)),
        _ => None,
    };
    let Some((name, edge)) = edge else {
        let message = format!("`{text}` is no edge");
        cx.out.bad(codes::UNREADABLE, node, message, "write a signal and `rises`, `falls` or `changes`");
        return None;
    };
    let mut only = node.clone();
    only.data = Data::Text(name.trim().to_owned());
    Some((cx.names.signal(&only, cx.out)?, edge))
}

fn present(edge: &CountedEdge) -> &'static str {
    match edge {
        CountedEdge::Rises => "rises",
        CountedEdge::Falls => "falls",
        _ => "changes",
    }
}

impl TraceClaim for OrderClaim {
    fn expected(&self) -> String {
        let parts: Vec<String> =
            self.edges.iter().map(|(signal, edge)| format!("`{signal}` {}", present(edge))).collect();
        format!("after {}: {}", self.from, parts.join(", then "))
    }

    fn signals(&self) -> Vec<String> {
        self.edges.iter().map(|(signal, _)| signal.clone()).collect()
    }

    fn anchors(&self) -> Vec<&Anchor> {
        vec![&self.from]
    }

    fn check(&self, wiring: &TraceSignals<'_>, out: &mut Vec<Diagnostic>) {
        for (signal, _) in &self.edges {
            super::known(signal, wiring, out);
        }
    }

    fn demands(&self) -> Vec<ClaimDemand<'_>> {
        let changes = self.edges.iter().map(|(signal, _)| ClaimDemand::Change(signal));
        changes.chain([ClaimDemand::At(&self.from)]).collect()
    }

    fn is_open_ended(&self) -> bool {
        true
    }

    fn pulses(&self, _: &SignalInfo) -> PulseRule {
        PulseRule::breaks(self.longer_than)
    }

    fn start(&self, scene: &CaseTimeline<'_>) -> Result<Box<dyn Monitor>, NotJudged> {
        let point = scene.point(&self.from)?;
        let mut sides = Vec::new();
        for (name, edge) in &self.edges {
            let info = scene.signal(name)?;
            let finder = EdgeFinder::new(edge.clone(), slack(info));
            sides.push(OrderedEdge { finder, first: FirstEdge::new(point, 0, i64::MAX).until(scene.end()) });
        }
        Ok(Box::new(OrderMonitor { claim: self.clone(), point, sides }))
    }
}

/// One of the edges.
struct OrderedEdge {
    finder: EdgeFinder,
    first: FirstEdge,
}

/// The judge.
struct OrderMonitor {
    claim: OrderClaim,
    point: UncertainInstant,
    sides: Vec<OrderedEdge>,
}

impl Monitor for OrderMonitor {
    #[inline]
    fn feed(&mut self, slot: usize, seen: &TimedValue) {
        let side = &mut self.sides[slot];
        if let Some(found) = side.finder.see(seen) {
            side.first.see(&found);
        }
    }

    fn finish(self: Box<Self>) -> Finding {
        let mut delays = Vec::new();
        for mut side in self.sides {
            if let Some(rest) = side.finder.rest() {
                side.first.see(&rest);
            }
            delays.push(side.first.finish());
        }
        finding(&self.claim, &self.point, &delays)
    }
}

fn finding(claim: &OrderClaim, point: &UncertainInstant, delays: &[Delay]) -> Finding {
    let mut finding = Finding { can_hold: true, ..Finding::default() };
    let mut shown = Vec::new();
    for ((signal, edge), delay) in claim.edges.iter().zip(delays) {
        let Some(extent) = delay.delay else {
            finding.can_break = true;
            finding.can_hold &= delay.doubtful;
            if finding.reason.is_empty() {
                finding.reason = match delay.doubtful {
                    true => format!("`{signal}` is not known at a time when the edge may have come"),
                    false => format!("`{signal}` never {}", edge.past()),
                };
            }
            shown.push(format!("`{signal}` did not"));
            continue;
        };
        finding.can_break |= delay.can_be_missing || delay.doubtful;
        shown.push(format!("`{signal}` {} {}", edge.past(), delay_words(extent, &claim.from)));
    }
    finding.observed = shown.join(", ");
    let mut least: Option<i64> = None;
    // The earliest instant that the chain can have reached.
    let mut reached = i64::MIN;
    for (at, pair) in delays.windows(2).enumerate() {
        let (Some(before), Some(after)) = (pair[0].delay, pair[1].delay) else { continue };
        let place = |delay: &Delay| delay.deciding.map_or(0, |found| found.seen.place);
        let recorded_so = place(&pair[0]) < place(&pair[1]);
        if !pair[0].doubtful {
            reached = reached.max(before.0);
        }
        let bound = reached.saturating_add(i64::from(!recorded_so));
        let margin = after.0.saturating_sub(before.1);
        let certain = if recorded_so { margin >= 0 } else { margin > 0 };
        finding.can_break |= !certain;
        if after.1 < bound && !pair[0].doubtful && !pair[1].doubtful {
            finding.can_hold = false;
        }
        if least.is_none_or(|least| margin < least) {
            least = Some(margin);
            finding.slot = at + 1;
            if let Some(found) = pair[1].deciding {
                finding = finding.decided_by(&found.seen);
            }
        }
    }
    if finding.reason.is_empty() {
        let signal = &claim.edges[finding.slot].0;
        finding.reason = match finding.can_hold {
            false => format!("the edge of `{signal}` came out of order"),
            true => format!("whether the edge of `{signal}` came in order lies within the uncertainty"),
        };
    }
    finding.margin = least.map(|least| Figure::span(Span::from_nanos(least)));
    finding.window = Some(super::value::instant(point));
    finding
}
