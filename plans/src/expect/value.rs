//! `value`: what a signal is at an instant.
//!
//! ```toml
//! { value = { of = "PLC_R.i_wLastApplicationError", is = "16#0010", when = "end" } }
//! { value = { of = "n", near = "n @ cut", tolerance = 1, when = "back" } }
//! ```
//! At the instant of a step itself, what the trace has before the step counts.

use std::sync::Arc;

use document::{Data, Diagnostic, Fields, KeySpec, KeyType};
use record::Figure;
use signal::{SignalInfo, Value};

use super::common::{WHEN, anchor};
use super::condition::{IS, MAX, MIN, ONE_OF, ValueCondition, literal};
use super::equal::{EqualOperand, read_pair};
use super::{ClaimDemand, ExpectVerb, ReadContext, TraceClaim};
use crate::codes;
use crate::lang::{Anchor, Literal};
use crate::meaning::what_to_write;
use crate::monitor::reading::{Candidate, ValueReader};
use crate::monitor::{
    CaseTimeline, Finding, Monitor, NotJudged, PulseRule, TimedValue, TraceSignals, Truth, UncertainInstant,
    ValueTest, slack,
};

/// `value`.
pub(super) const VALUE: ExpectVerb = ExpectVerb {
    name: "value",
    doc: "A signal has a value, one within limits, or one near another, at an instant",
    keys: &[
        KeySpec::required("of", KeyType::SignalRef, "The signal, or `signal @ instant`"),
        IS,
        ONE_OF,
        MIN,
        MAX,
        KeySpec::optional(
            "near",
            KeyType::Value,
            "A number, or another signal's value as in `n @ cut`, that it is within `tolerance` of",
        ),
        KeySpec::optional(
            "tolerance",
            KeyType::Value,
            "How far it may be from `near`, or which part of it, as in \"10 %\", if `near` is a number; 0 if left out",
        ),
        WHEN,
    ],
    read,
};

/// The claim.
#[derive(Clone, Debug)]
struct ValueClaim {
    signal: String,
    condition: ValueCondition,
    when: Anchor,
}

/// The claim that a signal meets a condition at an instant.
pub(super) fn at_instant(signal: String, condition: ValueCondition, when: Anchor) -> Arc<dyn TraceClaim> {
    Arc::new(ValueClaim { signal, condition, when })
}

fn read(fields: &Fields<'_>, cx: &mut ReadContext<'_>) -> Option<Arc<dyn TraceClaim>> {
    let when = anchor(fields, "when", Anchor::END, cx);
    let (signal, at) = cx.names.at_value(fields.get("of")?, cx.out)?;
    if let (Some(_), Some(node)) = (&at, fields.get("when")) {
        let message = "the instant is given twice, after `@` and as `when`";
        cx.out.bad(codes::CLAIM, node, message, "leave one of them out");
        return None;
    }
    let when = at.or(when)?;
    if !fields.has("near") {
        if let Some(node) = fields.get("tolerance") {
            cx.out.bad(
                codes::CLAIM,
                node,
                "`tolerance` has no meaning without `near`",
                "write near = VALUE beside it, or remove it",
            );
            return None;
        }
        let condition = ValueCondition::read(fields, None, cx)?;
        return Some(at_instant(signal, condition, when));
    }
    if let Some(key) = ["is", "one-of", "min", "max"].into_iter().find(|key| fields.has(key)) {
        let node = fields.get(key)?;
        cx.out.bad(
            codes::CLAIM,
            node,
            format!("a value is wanted in two ways: `near` and `{key}`"),
            "remove one of them",
        );
        return None;
    }
    let node = fields.get("near")?;
    // A word is the name of a signal here: labels of states are not near anything.
    if let (Data::Text(_), Ok(Literal::Label(_)) | Err(_)) = (&node.data, Literal::of(node)) {
        return read_pair(EqualOperand { signal, at: when.clone() }, fields, "near", when, cx);
    }
    let middle = literal(node, cx)?;
    let condition = match fields.get("tolerance") {
        Some(node) => ValueCondition::Near { middle, tolerance: literal(node, cx)? },
        None => ValueCondition::OneOf(vec![middle]),
    };
    Some(at_instant(signal, condition, when))
}

impl TraceClaim for ValueClaim {
    fn expected(&self) -> String {
        format!("`{}` is {} at {}", self.signal, self.condition, self.when)
    }

    fn signals(&self) -> Vec<String> {
        vec![self.signal.clone()]
    }

    fn anchors(&self) -> Vec<&Anchor> {
        vec![&self.when]
    }

    fn check(&self, wiring: &TraceSignals<'_>, out: &mut Vec<Diagnostic>) {
        if let Some(info) = super::known(&self.signal, wiring, out) {
            super::meant(self.condition.bind(info).map(drop), &what_to_write(info), out);
        }
    }

    fn demands(&self) -> Vec<ClaimDemand<'_>> {
        let (signal, condition) = (&self.signal, &self.condition);
        vec![ClaimDemand::Value { signal, condition, forbidden: false }, ClaimDemand::At(&self.when)]
    }

    fn pulses(&self, _: &SignalInfo) -> PulseRule {
        PulseRule::SEEN
    }

    fn start(&self, scene: &CaseTimeline<'_>) -> Result<Box<dyn Monitor>, NotJudged> {
        let info = scene.signal(&self.signal)?;
        let point = scene.point(&self.when)?;
        let test = self.condition.bind(info).map_err(NotJudged::NoMeaning)?;
        let reader = ValueReader::new(point);
        Ok(Box::new(ValueMonitor { claim: self.clone(), info: info.clone(), test, point, reader }))
    }
}

/// The judge.
struct ValueMonitor {
    claim: ValueClaim,
    info: SignalInfo,
    test: ValueTest,
    point: UncertainInstant,
    reader: ValueReader,
}

impl Monitor for ValueMonitor {
    #[inline]
    fn feed(&mut self, _slot: usize, seen: &TimedValue) {
        self.reader.see(seen);
    }

    fn lost(&mut self, now: i64) -> bool {
        now > self.point.b
            && self
                .reader
                .clone()
                .finish()
                .iter()
                .all(|candidate| self.test.holds(candidate.seen.value, slack(&self.info)) == Truth::False)
    }

    fn finish(self: Box<Self>) -> Finding {
        let (slack, candidates) = (slack(&self.info), self.reader.finish());
        let holds = |candidate: &Candidate| self.test.holds(candidate.seen.value, slack);
        let mut finding = Finding {
            can_hold: candidates.iter().any(|candidate| holds(candidate).possible()),
            can_break: candidates.iter().any(|candidate| holds(candidate).not().possible()),
            observed: observed(&candidates, &self.info),
            window: Some(instant(&self.point)),
            bounds: self.test.bounds(),
            ..Finding::default()
        };
        let margins = candidates.iter().filter_map(|candidate| self.test.margin(candidate.seen.value));
        let margin = margins.reduce(f64::min).map(|margin| margin - slack);
        finding.margin = margin.map(|margin| Figure::new(margin, self.info.unit.clone()));
        let known = candidates.iter().map(|candidate| candidate.seen.value.uncertainty()).reduce(f64::max);
        finding.uncertainty = known.and_then(|known| super::common::within(known, slack, &self.info));
        finding.reason = match (finding.can_hold, unknown(&candidates)) {
            (false, _) => format!("it was {}", observed(&candidates, &self.info)),
            (true, true) => format!("the value is not known at {}", self.claim.when),
            (true, false) if candidates.len() > 1 => format!("it changes at about {}", self.claim.when),
            (true, false) => String::from("the value is nearer to the limit than the trace is exact"),
        };
        // The value that speaks against the claim is the one to look at.
        let worst = candidates.iter().find(|candidate| holds(candidate) != Truth::True).or(candidates.last());
        match worst {
            Some(worst) if !matches!(worst.seen.value, Value::Unknown) => finding.decided_by(&worst.seen),
            _ => finding,
        }
    }
}

/// Whether some placement reads an unknown value.
pub(super) fn unknown(candidates: &[Candidate]) -> bool {
    candidates.iter().any(|candidate| matches!(candidate.seen.value, Value::Unknown))
}

/// The values that were read, in the user's words.
pub(super) fn observed(candidates: &[Candidate], info: &SignalInfo) -> String {
    let mut shown: Vec<String> = Vec::new();
    for candidate in candidates {
        let value = info.show(candidate.seen.value);
        if !shown.contains(&value) {
            shown.push(value);
        }
    }
    if shown.len() > 4 {
        let more = shown.len() - 3;
        shown.truncate(3);
        shown.push(format!("{more} more"));
    }
    shown.join(" or ")
}

/// An instant as a window without length.
pub(super) fn instant(point: &UncertainInstant) -> record::Window {
    record::Window {
        from_ns: [point.a, point.b],
        until_ns: [point.a, point.b],
        limit_from_ns: None,
        limit_until_ns: None,
    }
}
