//! `rises`, `falls`, `changes`: the first such edge at or after an instant comes within its limits.
//!
//! ```toml
//! { falls = { signal = "lamp", from = "busy", within = "100 ms .. 100.3 ms" } }
//! ```
//! An earlier edge of the same kind fails the claim: it is the first one that counts. Without `within` any
//! delay up to the end of the case is right.

use std::sync::Arc;

use document::{Diagnostic, Fields, KeySpec, KeyType};
use record::Figure;
use signal::{SignalInfo, Span, Value};

use super::common::{
    FROM, LONGER, SIGNAL, SingleSpan, SpanLimits, anchor, delay_words, signal, span_range, spans, width,
};
use super::condition::ValueCondition;
use super::{ClaimDemand, ExpectVerb, ReadContext, TraceClaim};
use crate::lang::Anchor;
use crate::meaning::what_to_write;
use crate::monitor::edges::{CountedEdge, Delay, EdgeFinder, FirstEdge, FoundEdge, LAST};
use crate::monitor::{
    CaseTimeline, Finding, Monitor, NotJudged, PulseRule, TimedValue, TraceSignals, UncertainInstant,
    UnseenPulses, slack, span_margin,
};

/// How late the edge may be.
pub(super) const WITHIN: KeySpec = KeySpec::optional(
    "within",
    KeyType::Range,
    "The delay from `from` that is allowed, both limits included: \"100 ms .. 100.3 ms\", or \"5 ms\" for at most that",
);

const KEYS: &[KeySpec] = &[SIGNAL, FROM, WITHIN, LONGER];

/// `rises`.
pub(super) const RISES: ExpectVerb = ExpectVerb {
    name: "rises",
    doc: "The first rise of a signal at or after an instant comes within its limits",
    keys: KEYS,
    read: |fields, cx| read(fields, FirstEdgeKind::Rises, cx),
};
/// `falls`.
pub(super) const FALLS: ExpectVerb = ExpectVerb {
    name: "falls",
    doc: "The first fall of a signal at or after an instant comes within its limits",
    keys: KEYS,
    read: |fields, cx| read(fields, FirstEdgeKind::Falls, cx),
};
/// `changes`.
pub(super) const CHANGES: ExpectVerb = ExpectVerb {
    name: "changes",
    doc: "The first change of a signal at or after an instant comes within its limits",
    keys: KEYS,
    read: |fields, cx| read(fields, FirstEdgeKind::Changes, cx),
};

/// What the edge is, before the signal is known.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum FirstEdgeKind {
    Rises,
    Falls,
    Changes,
    /// The count of a log's entries grows.
    Added,
    Becomes(ValueCondition),
}

impl FirstEdgeKind {
    fn bind(&self, info: &SignalInfo) -> Result<CountedEdge, String> {
        Ok(match self {
            FirstEdgeKind::Rises | FirstEdgeKind::Added => CountedEdge::Rises,
            FirstEdgeKind::Falls => CountedEdge::Falls,
            FirstEdgeKind::Changes => CountedEdge::Changes,
            FirstEdgeKind::Becomes(condition) => CountedEdge::Becomes(condition.bind(info)?),
        })
    }

    fn present(&self) -> String {
        match self {
            FirstEdgeKind::Rises => "rises".into(),
            FirstEdgeKind::Falls => "falls".into(),
            FirstEdgeKind::Changes => "changes".into(),
            FirstEdgeKind::Added => "is added".into(),
            FirstEdgeKind::Becomes(condition) => format!("becomes {condition}"),
        }
    }

    fn past(&self) -> String {
        match self {
            FirstEdgeKind::Rises => "rose".into(),
            FirstEdgeKind::Falls => "fell".into(),
            FirstEdgeKind::Changes => "changed".into(),
            FirstEdgeKind::Added => "was added".into(),
            FirstEdgeKind::Becomes(condition) => format!("became {condition}"),
        }
    }

    /// `did not rise`.
    fn missing(&self) -> String {
        match self {
            FirstEdgeKind::Added => "was not added".into(),
            kind => format!("did not {}", kind.infinitive()),
        }
    }

    fn infinitive(&self) -> String {
        match self {
            FirstEdgeKind::Rises => "rise".into(),
            FirstEdgeKind::Falls => "fall".into(),
            FirstEdgeKind::Changes => "change".into(),
            FirstEdgeKind::Added => "be added".into(),
            FirstEdgeKind::Becomes(condition) => format!("become {condition}"),
        }
    }
}

/// The claim.
#[derive(Clone, Debug)]
pub(super) struct FirstEdgeClaim {
    pub(super) signal: String,
    pub(super) kind: FirstEdgeKind,
    pub(super) from: Anchor,
    pub(super) within: Option<SpanLimits>,
    pub(super) longer_than: Option<Span>,
}

fn read(fields: &Fields<'_>, kind: FirstEdgeKind, cx: &mut ReadContext<'_>) -> Option<Arc<dyn TraceClaim>> {
    let signal = signal(fields, "signal", cx);
    read_delay(fields, signal, kind, cx)
}

/// Reads `from` and `within` of a claim on this signal.
pub(super) fn read_delay(
    fields: &Fields<'_>,
    signal: Option<String>,
    kind: FirstEdgeKind,
    cx: &mut ReadContext<'_>,
) -> Option<Arc<dyn TraceClaim>> {
    let from = anchor(fields, "from", Anchor::START, cx);
    let within = match fields.get("within") {
        Some(node) => Some(spans(node, "within", SingleSpan::Most, cx)?),
        None if fields.has("within") => return None,
        None => None,
    };
    let longer_than = fields.duration(LONGER.name);
    Some(Arc::new(FirstEdgeClaim { signal: signal?, kind, from: from?, within, longer_than }))
}

impl TraceClaim for FirstEdgeClaim {
    fn expected(&self) -> String {
        let (signal, what) = (&self.signal, self.kind.present());
        match self.within {
            Some((0, most)) if most != i64::MAX => {
                format!("`{signal}` {what} within {} after {}", Span::from_nanos(most), self.from)
            }
            Some(limits) => format!("`{signal}` {what} {} after {}", span_range(limits), self.from),
            None => format!("`{signal}` {what} after {}", self.from),
        }
    }

    fn signals(&self) -> Vec<String> {
        vec![self.signal.clone()]
    }

    fn anchors(&self) -> Vec<&Anchor> {
        vec![&self.from]
    }

    fn check(&self, wiring: &TraceSignals<'_>, out: &mut Vec<Diagnostic>) {
        if let Some(info) = super::known(&self.signal, wiring, out) {
            super::meant(self.kind.bind(info).map(drop), &what_to_write(info), out);
        }
    }

    fn demands(&self) -> Vec<ClaimDemand<'_>> {
        let limits = self.within.unwrap_or((0, i64::MAX));
        let mut demands = vec![
            ClaimDemand::Change(&self.signal),
            ClaimDemand::Delay { from: &self.from, limits, signal: &self.signal },
        ];
        if let FirstEdgeKind::Becomes(condition) = &self.kind {
            demands.push(ClaimDemand::Value { signal: &self.signal, condition, forbidden: false });
        }
        demands
    }

    fn is_open_ended(&self) -> bool {
        true
    }

    fn pulses(&self, info: &SignalInfo) -> PulseRule {
        let level = match self.kind.bind(info) {
            Ok(CountedEdge::Becomes(test)) => Some(test),
            _ => None,
        };
        // An edge that nobody saw could have come first: too early, where there is a least delay.
        let early = self.within.is_some_and(|(least, _)| least > 0);
        let unseen = if early { UnseenPulses::Break } else { UnseenPulses::Nothing };
        PulseRule { unseen, ..PulseRule::breaks(self.longer_than) }.of_level(level)
    }

    fn start(&self, scene: &CaseTimeline<'_>) -> Result<Box<dyn Monitor>, NotJudged> {
        let info = scene.signal(&self.signal)?;
        let point = scene.point(&self.from)?;
        let limits = scene.clock.spans(self.within.unwrap_or((0, i64::MAX)));
        let edge = self.kind.bind(info).map_err(NotJudged::NoMeaning)?;
        Ok(Box::new(FirstEdgeMonitor {
            claim: self.clone(),
            info: info.clone(),
            finder: EdgeFinder::new(edge, slack(info)),
            first: FirstEdge::new(point, limits.0, limits.1).until(scene.end()),
            point,
            limits,
            end: scene.end(),
            nearest: None,
            last: None,
        }))
    }
}

/// The judge of one edge.
struct FirstEdgeMonitor {
    claim: FirstEdgeClaim,
    info: SignalInfo,
    finder: EdgeFinder,
    first: FirstEdge,
    point: UncertainInstant,
    limits: SpanLimits,
    end: i64,
    /// The edge that came closest to the limits: distance, and the edge.
    nearest: Option<(i64, TimedValue)>,
    last: Option<Value>,
}

impl Monitor for FirstEdgeMonitor {
    #[inline]
    fn feed(&mut self, _slot: usize, seen: &TimedValue) {
        self.last = Some(seen.value);
        let Some(found) = self.finder.see(seen) else { return };
        self.first.see(&found);
        if found.certain {
            self.note(seen);
        }
    }

    fn lost(&mut self, now: i64) -> bool {
        // What is not known now may hide the edge.
        self.finder.rest().is_none() && self.first.lost(now)
    }

    fn finish(mut self: Box<Self>) -> Finding {
        if let Some(rest) = self.finder.rest() {
            self.first.see(&rest);
        }
        // What comes after the end of the case is not known: a window that reaches beyond it stays open.
        let cut_short = self.claim.within.is_some_and(|(_, most)| most != i64::MAX)
            && self.point.b.saturating_add(self.limits.1) > self.end;
        if cut_short {
            let seen =
                TimedValue { a: self.end, b: i64::MAX, place: LAST, since: LAST, ..TimedValue::NOTHING };
            self.first.see(&FoundEdge { seen, certain: false });
        }
        self.finding(self.first.finish(), cut_short)
    }
}

impl FirstEdgeMonitor {
    /// Keeps the edge if it is closer to the limits than those before it.
    fn note(&mut self, seen: &TimedValue) {
        let early = self.point.a.saturating_add(self.limits.0).saturating_sub(seen.b);
        let late = seen.a.saturating_sub(self.point.b.saturating_add(self.limits.1));
        let distance = early.max(late).max(0);
        if self.nearest.is_none_or(|(least, _)| distance < least) {
            self.nearest = Some((distance, *seen));
        }
    }

    fn finding(&self, delay: Delay, cut_short: bool) -> Finding {
        let mut finding = Finding {
            can_hold: delay.can_hold,
            can_break: delay.can_break(),
            window: Some(self.window()),
            ..Finding::default()
        };
        let (past, from) = (self.claim.kind.past(), &self.claim.from);
        finding.observed = match delay.delay {
            Some(delay) => format!("{past} {}", delay_words(delay, from)),
            None => {
                let stayed = match self.last.filter(|_| self.claim.kind != FirstEdgeKind::Added) {
                    Some(value) => format!("; it was {} at the end", self.info.show(value)),
                    None => String::new(),
                };
                format!("{} after {from}{stayed}", self.claim.kind.missing())
            }
        };
        if let Some((least, most)) = delay.delay {
            let margin = self.claim.within.and_then(|_| span_margin((least, most), self.limits));
            finding.margin = margin.map(|margin| Figure::span(Span::from_nanos(margin)));
            finding.uncertainty = width((least, most));
        }
        if let Some(found) = delay.deciding.filter(|found| found.certain) {
            finding = finding.decided_by(&found.seen);
        }
        finding.reason = self.reason(&delay, cut_short, finding.can_hold);
        finding.nearest_miss = self.nearest_miss(delay.delay.is_none());
        finding
    }

    /// The allowed part of time, for a drawing.
    fn window(&self) -> record::Window {
        let until = self.end.max(self.point.b);
        let limit = |delay: i64, at: i64| {
            (self.claim.within.is_some() && delay != i64::MAX).then(|| at.saturating_add(delay))
        };
        record::Window {
            from_ns: [self.point.a, self.point.b],
            until_ns: [until, until],
            limit_from_ns: limit(self.limits.0, self.point.a),
            limit_until_ns: limit(self.limits.1, self.point.b),
        }
    }

    fn reason(&self, delay: &Delay, cut_short: bool, can_hold: bool) -> String {
        let what = self.claim.kind.infinitive();
        if !can_hold {
            return match delay.delay {
                Some((least, _)) if delay.can_be_late && !delay.can_be_early => {
                    format!("{} too late", Span::from_nanos(least.saturating_sub(self.limits.1)))
                }
                Some((_, most)) if delay.can_be_early && !delay.can_be_late => {
                    format!("{} too early", Span::from_nanos(self.limits.0.saturating_sub(most)))
                }
                Some(_) => String::from("outside the limits in every placement"),
                None => format!("it {}", self.claim.kind.missing()),
            };
        }
        if delay.doubtful && delay.deciding.is_none_or(|found| !found.certain) {
            let after_end = |found: FoundEdge| found.seen.place != LAST && found.seen.b > self.end;
            return match cut_short {
                true => String::from("the case ended before the window closed"),
                false if delay.deciding.is_some_and(after_end) => {
                    format!("the case may have ended before it did {what}")
                }
                false => format!("the value is not known at a time when it may {what}"),
            };
        }
        if delay.doubtful {
            return format!("the value is not known at a time when it may {what} first");
        }
        format!("the uncertainty of the instants reaches over a limit: whether it did {what} in time is open")
    }

    fn nearest_miss(&self, missing: bool) -> Option<(String, Option<signal::Cause>)> {
        let (distance, seen) = self.nearest?;
        let (least, most) = (seen.a.saturating_sub(self.point.b), seen.b.saturating_sub(self.point.a));
        let when = delay_words((least, most), &self.claim.from);
        let distance = Span::from_nanos(distance);
        let early = most < self.limits.0 || missing;
        let word = match (distance, early) {
            (Span::ZERO, _) => String::from("within reach of the limits"),
            (distance, true) => format!("{distance} too early"),
            (distance, false) => format!("{distance} too late"),
        };
        Some((
            format!("the nearest time that it {} was {word}, {when}", self.claim.kind.past()),
            Some(seen.cause),
        ))
    }
}
