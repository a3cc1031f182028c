//! `happens`: a step that waits for an event came.
//!
//! ```toml
//! { happens = { step = "back", within = "2 s", from = "cut" } }
//! ```
//! Every step with `when` is claimed to happen without being asked for.

use std::sync::Arc;

use document::{Diagnostic, Fields, KeySpec, KeyType};
use record::Figure;
use signal::{SignalInfo, Span, Value};

use super::common::{FROM, SingleSpan, SpanLimits, anchor, delay_words, span_range, spans, width};
use super::first_edge::WITHIN;
use super::{ExpectVerb, Expectation, FilePlace, ReadContext, TraceClaim};
use crate::lang::{Anchor, AnchorBase};
use crate::monitor::edges::{FirstEdge, FoundEdge};
use crate::monitor::{
    CaseTimeline, Finding, Monitor, NotJudged, PulseRule, TimedValue, TraceSignals, UncertainInstant,
    span_margin,
};

/// `happens`.
pub(super) const HAPPENS: ExpectVerb = ExpectVerb {
    name: "happens",
    doc: "A step that waits for an event came, and in time",
    keys: &[KeySpec::required("step", KeyType::Anchor, "The id of the step"), FROM, WITHIN],
    read,
};

/// The claim.
#[derive(Clone, Debug)]
struct HappensClaim {
    step: Anchor,
    from: Option<Anchor>,
    within: Option<SpanLimits>,
    /// The longest wait of a step that nobody asked about.
    wait: Option<Span>,
}

fn read(fields: &Fields<'_>, cx: &mut ReadContext<'_>) -> Option<Arc<dyn TraceClaim>> {
    let node = fields.get("step")?;
    let step = cx.names.anchor(node, cx.out)?;
    if !matches!(step.base, AnchorBase::Step(_)) || step.offset != Span::ZERO {
        let message = format!("`{step}` is not a step");
        cx.out.bad(crate::codes::CLAIM, node, message, "write the id of a step alone");
        return None;
    }
    let from = anchor(fields, "from", Anchor::START, cx)?;
    let within = match fields.get("within") {
        Some(node) => Some(spans(node, "within", SingleSpan::Most, cx)?),
        None => None,
    };
    Some(Arc::new(HappensClaim { step, from: Some(from), within, wait: None }))
}

/// The claim that a step which waits for an event came.
pub(crate) fn implied(step: &str, wait: Span, line: u32) -> Expectation {
    let id = Anchor { base: AnchorBase::Step(step.to_owned()), offset: Span::ZERO };
    Expectation {
        name: String::new(),
        verb: "happens",
        claim: Arc::new(HappensClaim { step: id, from: None, within: None, wait: Some(wait) }),
        place: Some(FilePlace { file: Arc::from(""), span: 0..0, line }),
    }
}

impl HappensClaim {
    fn id(&self) -> &str {
        self.step.base.step().unwrap_or_default()
    }
}

impl TraceClaim for HappensClaim {
    fn expected(&self) -> String {
        let id = self.id();
        match (&self.from, self.within, self.wait) {
            (Some(from), Some(limits), _) => format!("step {id} comes {} after {from}", span_range(limits)),
            (.., Some(wait)) => format!("step {id} comes within {wait} of waiting"),
            _ => format!("step {id} comes"),
        }
    }

    fn signals(&self) -> Vec<String> {
        vec![format!("step:{}", self.id())]
    }

    fn anchors(&self) -> Vec<&Anchor> {
        self.from.iter().collect()
    }

    fn check(&self, wiring: &TraceSignals<'_>, out: &mut Vec<Diagnostic>) {
        super::known(&self.signals()[0], wiring, out);
    }

    fn is_open_ended(&self) -> bool {
        true
    }

    fn pulses(&self, _: &SignalInfo) -> PulseRule {
        PulseRule::SEEN
    }

    fn start(&self, scene: &CaseTimeline<'_>) -> Result<Box<dyn Monitor>, NotJudged> {
        let from = match &self.from {
            Some(from) => scene.point(from)?,
            None => UncertainInstant { a: i64::MIN, b: i64::MIN, place: 0, base: u32::MAX, offset: 0 },
        };
        let limits = scene.clock.spans(self.within.unwrap_or((0, i64::MAX)));
        Ok(Box::new(HappensMonitor {
            claim: self.clone(),
            from,
            limits,
            came: None,
            open: false,
            late: false,
        }))
    }
}

/// The judge.
struct HappensMonitor {
    claim: HappensClaim,
    from: UncertainInstant,
    limits: SpanLimits,
    came: Option<TimedValue>,
    /// Nobody knows whether it came: its mark has a value that is not known.
    open: bool,
    /// Nobody knows whether it came in time: its value is not known any more after it came.
    late: bool,
}

impl Monitor for HappensMonitor {
    fn feed(&mut self, _slot: usize, seen: &TimedValue) {
        match seen.value {
            Value::Unknown if self.came.is_some() => self.late = true,
            Value::Unknown => self.open = true,
            _ => {
                self.came.get_or_insert(*seen);
            }
        }
    }

    fn finish(self: Box<Self>) -> Finding {
        let id = self.claim.id();
        let Some(came) = self.came else {
            if self.open {
                let reason = format!("whether step {id} came in time is not known");
                let observed = String::from("it may have come");
                return Finding { can_hold: true, can_break: true, observed, reason, ..Finding::default() };
            }
            let reason = format!("step {id} never came");
            return Finding { observed: String::from("it never came"), reason, ..Finding::default() };
        };
        let mut finding =
            Finding { can_hold: true, can_break: self.late, ..Finding::default() }.decided_by(&came);
        finding.reason = match self.late {
            true => format!("whether step {id} came in time lies within what the clock may be off"),
            false => String::new(),
        };
        let (Some(from), Some(_)) = (&self.claim.from, self.claim.within) else {
            finding.observed = String::from("it came");
            return finding;
        };
        let found = FoundEdge { seen: came, certain: true };
        let mut first = FirstEdge::new(self.from, self.limits.0, self.limits.1);
        first.see(&found);
        let delay = first.finish();
        let between = (came.a.saturating_sub(self.from.b), came.b.saturating_sub(self.from.a));
        finding.observed = format!("it came {}", delay_words(between, from));
        (finding.can_hold, finding.can_break) = (delay.can_hold, delay.can_break() || self.late);
        let margin = span_margin(between, self.limits);
        finding.margin = margin.map(|margin| Figure::span(Span::from_nanos(margin)));
        finding.uncertainty = width(between);
        finding.reason = match finding.can_hold {
            true if self.late => finding.reason,
            true => String::from("the uncertainty of the instants reaches over a limit"),
            false => String::from("outside the limits"),
        };
        finding
    }
}
