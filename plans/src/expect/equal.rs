//! `equal`: two values agree, each at its own instant. `value` that is `near` another signal is the same claim.
//!
//! ```toml
//! { equal = { left = "n", right = "m", when = "back" } }
//! { equal = { left = "n @ cut", right = "n", when = "back", tolerance = 1 } }
//! ```

use std::sync::Arc;

use document::{Diagnostic, Fields, KeySpec, KeyType};
use record::Figure;
use signal::{SignalInfo, Value};

use super::common::{WHEN, anchor};
use super::condition::literal;
use super::value::{instant, observed, unknown};
use super::{ClaimDemand, ExpectVerb, ReadContext, TraceClaim};
use crate::lang::{Anchor, Literal};
use crate::meaning::{number, what_to_write};
use crate::monitor::reading::{Candidate, ValueReader};
use crate::monitor::{
    CaseTimeline, Finding, Monitor, NotJudged, Number, PulseRule, TimedValue, TraceSignals, Truth,
    UncertainInstant, differs_at_most, distance, slack,
};

/// `equal`.
pub(super) const EQUAL: ExpectVerb = ExpectVerb {
    name: "equal",
    doc: "Two values agree, each at its own instant",
    keys: &[
        KeySpec::required("left", KeyType::SignalRef, "A signal, or `signal @ instant`"),
        KeySpec::required("right", KeyType::SignalRef, "Another signal, or `signal @ instant`"),
        KeySpec::optional("tolerance", KeyType::Value, "How far apart they may be; 0 if left out"),
        WHEN,
    ],
    read,
};

/// A signal at an instant.
#[derive(Clone, Debug)]
pub(super) struct EqualOperand {
    pub(super) signal: String,
    pub(super) at: Anchor,
}

/// The claim.
#[derive(Clone, Debug)]
struct EqualClaim {
    left: EqualOperand,
    right: EqualOperand,
    tolerance: Option<Literal>,
}

fn read(fields: &Fields<'_>, cx: &mut ReadContext<'_>) -> Option<Arc<dyn TraceClaim>> {
    let when = anchor(fields, "when", Anchor::END, cx)?;
    let (signal, at) = cx.names.at_value(fields.get("left")?, cx.out)?;
    let left = EqualOperand { signal, at: at.unwrap_or_else(|| when.clone()) };
    read_pair(left, fields, "right", when, cx)
}

/// Reads what the left value is compared with.
pub(super) fn read_pair(
    left: EqualOperand,
    fields: &Fields<'_>,
    key: &str,
    when: Anchor,
    cx: &mut ReadContext<'_>,
) -> Option<Arc<dyn TraceClaim>> {
    let node = fields.get(key)?;
    let (signal, at) = cx.names.at_value(node, cx.out)?;
    let right = EqualOperand { signal, at: at.unwrap_or(when) };
    let tolerance = match fields.get("tolerance") {
        Some(node) => Some(literal(node, cx)?),
        None => None,
    };
    if right.signal == left.signal && right.at == left.at {
        let message = format!("`{}` is compared with itself at {}", left.signal, left.at);
        cx.out.bad(crate::codes::CLAIM, node, message, "name another signal or another instant");
        return None;
    }
    Some(Arc::new(EqualClaim { left, right, tolerance }))
}

impl EqualClaim {
    fn limit(&self, info: &SignalInfo) -> Result<Number, String> {
        match &self.tolerance {
            Some(tolerance) => match number(tolerance, info)? {
                negative if negative.is_below(Number::ZERO) => {
                    Err(format!("a tolerance of {} can never be met", tolerance))
                }
                limit => Ok(limit),
            },
            None => Ok(Number::ZERO),
        }
    }
}

impl TraceClaim for EqualClaim {
    fn expected(&self) -> String {
        let left = format!("`{}` at {}", self.left.signal, self.left.at);
        let right = format!("`{}` at {}", self.right.signal, self.right.at);
        match &self.tolerance {
            Some(tolerance) => format!("{left} is within {} of {right}", tolerance),
            None => format!("{left} equals {right}"),
        }
    }

    fn signals(&self) -> Vec<String> {
        vec![self.left.signal.clone(), self.right.signal.clone()]
    }

    fn anchors(&self) -> Vec<&Anchor> {
        vec![&self.left.at, &self.right.at]
    }

    fn check(&self, wiring: &TraceSignals<'_>, out: &mut Vec<Diagnostic>) {
        if let Some(info) = super::known(&self.left.signal, wiring, out) {
            super::meant(self.limit(info).map(drop), &what_to_write(info), out);
        }
        super::known(&self.right.signal, wiring, out);
    }

    fn demands(&self) -> Vec<ClaimDemand<'_>> {
        let mut demands = vec![ClaimDemand::At(&self.left.at), ClaimDemand::At(&self.right.at)];
        if self.left.at == self.right.at {
            demands.push(ClaimDemand::Differ(&self.left.signal, &self.right.signal));
        }
        demands
    }

    fn pulses(&self, _: &SignalInfo) -> PulseRule {
        PulseRule::SEEN
    }

    fn start(&self, scene: &CaseTimeline<'_>) -> Result<Box<dyn Monitor>, NotJudged> {
        let info = scene.signal(&self.left.signal)?;
        let limit = self.limit(info).map_err(NotJudged::NoMeaning)?;
        let left = EqualSide::new(&self.left, scene)?;
        let right = EqualSide::new(&self.right, scene)?;
        Ok(Box::new(EqualMonitor { left, right, limit }))
    }
}

/// One of the two values.
struct EqualSide {
    info: SignalInfo,
    point: UncertainInstant,
    reader: ValueReader,
}

impl EqualSide {
    fn new(operand: &EqualOperand, scene: &CaseTimeline<'_>) -> Result<EqualSide, NotJudged> {
        let info = scene.signal(&operand.signal)?.clone();
        let point = scene.point(&operand.at)?;
        Ok(EqualSide { info, point, reader: ValueReader::new(point) })
    }
}

/// The judge.
struct EqualMonitor {
    left: EqualSide,
    right: EqualSide,
    limit: Number,
}

impl Monitor for EqualMonitor {
    #[inline]
    fn feed(&mut self, slot: usize, seen: &TimedValue) {
        let side = if slot == 0 { &mut self.left } else { &mut self.right };
        side.reader.see(seen);
    }

    fn finish(self: Box<Self>) -> Finding {
        let link = self.left.point.link(&self.right.point);
        let (left, right) = (self.left.reader.finish(), self.right.reader.finish());
        let mut finding = Finding { window: Some(instant(&self.left.point)), ..Finding::default() };
        let mut least = f64::INFINITY;
        let slack = slack(&self.left.info) + slack(&self.right.info);
        let pairs = left.iter().flat_map(|a| right.iter().map(move |b| (a, b)));
        for (a, b) in pairs.filter(|(a, b)| together(a, b, link)) {
            let (a, b) = (a.seen.value, b.seen.value);
            let truth = match (Number::of(a), Number::of(b)) {
                (Some(x), Some(y)) => {
                    let known = a.uncertainty() + b.uncertainty();
                    let (apart, truth) = close(x, y, self.limit, slack + known);
                    least = least.min(distance(apart, self.limit) - known);
                    truth
                }
                _ if matches!(a, Value::Unknown) || matches!(b, Value::Unknown) => Truth::Unknown,
                // A line that nobody drives equals another such line, and no number.
                _ => Truth::of(b == a),
            };
            finding.can_hold |= truth.possible();
            finding.can_break |= truth.not().possible();
        }
        finding.observed =
            format!("{} and {}", observed(&left, &self.left.info), observed(&right, &self.right.info));
        let open = unknown(&left) || unknown(&right);
        let changes = left.len() + right.len() > 2;
        finding.reason = match (finding.can_hold, open) {
            (false, _) => format!("they are {}", finding.observed),
            (true, true) => String::from("a value is not known at its instant"),
            (true, false) if !changes => {
                String::from("they are nearer to the tolerance than they are known to be")
            }
            (true, false) => String::from("a value changes at about its instant"),
        };
        finding.margin = least.is_finite().then(|| Figure::new(least, self.left.info.unit.clone()));
        match left.last().filter(|last| !matches!(last.seen.value, Value::Unknown)) {
            Some(last) => finding.decided_by(&last.seen),
            None => finding,
        }
    }
}

/// Whether two readings can be placed at once: instants that depend on one event move together.
fn together(left: &Candidate, right: &Candidate, link: Option<i64>) -> bool {
    link.is_none_or(|link| {
        let low = left.low.saturating_add(link).max(right.low);
        low <= left.high.saturating_add(link).min(right.high)
    })
}

/// How far apart two numbers are, and whether that is within the limit.
pub(super) fn close(a: Number, b: Number, limit: Number, slack: f64) -> (Number, Truth) {
    let within = |off: f64| differs_at_most(a, b, off, limit) && differs_at_most(b, a, off, limit);
    let truth = match (within(slack), slack > 0.0 && within(-slack)) {
        (true, _) => Truth::True,
        (false, true) => Truth::Unknown,
        (false, false) => Truth::False,
    };
    let exact = |rough: f64| (rough - limit.as_real()).abs() <= (rough + limit.as_real()) * 1e-9;
    let apart = match (a, b, distance(a, b).abs()) {
        // Of decimals that are far from the limit nobody asks for the last digit.
        (Number::Real(_), Number::Real(_), rough) if !exact(rough) => Number::Real(rough),
        _ => a.apart(b),
    };
    (apart, truth)
}
