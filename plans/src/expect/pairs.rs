//! `never` with `any-two`: no two of several signals are TRUE together.
//!
//! Every pair is judged for itself, as `all` of two signals; the pair that speaks most clearly against the claim
//! speaks for all.

use std::sync::Arc;

use document::{Diagnostic, Fields};
use signal::SignalInfo;

use super::common::{LONGER, PlanWindow};
use super::condition::ValueCondition;
use super::keeps::Keeps;
use super::{ClaimDemand, ReadContext, TraceClaim};
use crate::lang::Anchor;
use crate::monitor::{CaseTimeline, Finding, Monitor, NotJudged, PulseRule, TimedValue, TraceSignals};

/// The claim.
#[derive(Clone, Debug)]
struct PairsClaim {
    signals: Vec<String>,
    /// Places of the two signals, and the claim about them.
    pairs: Vec<(usize, usize, Keeps)>,
}

/// Makes the claim of signals that are known to be two or more, each once.
pub(super) fn claim(
    signals: Vec<String>,
    condition: Option<ValueCondition>,
    fields: &Fields<'_>,
    cx: &mut ReadContext<'_>,
) -> Option<Arc<dyn TraceClaim>> {
    let between = PlanWindow::read(fields, cx)?;
    let condition = condition?;
    let longer_than = fields.duration(LONGER.name);
    let mut pairs = Vec::new();
    for one in 0..signals.len() {
        for other in one + 1..signals.len() {
            let signals = vec![signals[one].clone(), signals[other].clone()];
            let (condition, between) = (condition.clone(), between.clone());
            pairs.push((one, other, Keeps { signals, condition, forbidden: true, between, longer_than }));
        }
    }
    Some(Arc::new(PairsClaim { signals, pairs }))
}

impl TraceClaim for PairsClaim {
    fn expected(&self) -> String {
        let quoted: Vec<String> = self.signals.iter().map(|name| format!("`{name}`")).collect();
        match self.pairs.first() {
            Some((_, _, pair)) => {
                let (condition, window) = (&pair.condition, pair.between.words());
                format!("no two of {} are {condition} together{window}", quoted.join(", "))
            }
            None => String::new(),
        }
    }

    fn signals(&self) -> Vec<String> {
        self.signals.clone()
    }

    fn anchors(&self) -> Vec<&Anchor> {
        self.pairs.first().map_or_else(Vec::new, |(_, _, pair)| pair.anchors())
    }

    fn check(&self, wiring: &TraceSignals<'_>, out: &mut Vec<Diagnostic>) {
        // One signal after another, so that nothing is said once for each pair.
        for at in 0..self.signals.len() {
            if let Some((one, _, pair)) = self.pairs.iter().find(|(one, other, _)| at == *one || at == *other)
            {
                pair.check_one(usize::from(*one != at), wiring, out);
            }
        }
    }

    fn demands(&self) -> Vec<ClaimDemand<'_>> {
        self.pairs.first().map_or_else(Vec::new, |(_, _, pair)| vec![pair.between.demand()])
    }

    fn pulses(&self, info: &SignalInfo) -> PulseRule {
        self.pairs.first().map_or(PulseRule::breaks(None), |(_, _, pair)| pair.pulses(info))
    }

    fn start(&self, scene: &CaseTimeline<'_>) -> Result<Box<dyn Monitor>, NotJudged> {
        let mut pairs = Vec::new();
        for (one, other, pair) in &self.pairs {
            let name = format!("`{}` and `{}`", self.signals[*one], self.signals[*other]);
            pairs.push(SignalPair { slots: [*one, *other], name, monitor: pair.start(scene)? });
        }
        Ok(Box::new(PairsMonitor { pairs }))
    }
}

/// Two of the signals.
struct SignalPair {
    slots: [usize; 2],
    name: String,
    monitor: Box<dyn Monitor>,
}

/// The judge.
struct PairsMonitor {
    pairs: Vec<SignalPair>,
}

impl Monitor for PairsMonitor {
    fn feed(&mut self, slot: usize, seen: &TimedValue) {
        for pair in &mut self.pairs {
            if let Some(own) = pair.slots.iter().position(|known| *known == slot) {
                pair.monitor.feed(own, seen);
            }
        }
    }

    fn lost(&mut self, now: i64) -> bool {
        self.pairs.iter_mut().any(|pair| pair.monitor.lost(now))
    }

    fn finish(self: Box<Self>) -> Finding {
        let mut worst: Option<(Finding, String, [usize; 2])> = None;
        let (mut can_hold, mut can_break) = (true, false);
        for SignalPair { slots, name, monitor } in self.pairs {
            let found = monitor.finish();
            can_hold &= found.can_hold;
            can_break |= found.can_break;
            let margin = |found: &Finding| found.margin.as_ref().map_or(f64::INFINITY, |margin| margin.value);
            let worse = worst.as_ref().is_none_or(|(known, ..)| {
                let (new, old) = (found.verdict(), known.verdict());
                new > old || new == old && margin(&found) < margin(known)
            });
            if worse {
                worst = Some((found, name, slots));
            }
        }
        let Some((mut finding, name, slots)) = worst else { return Finding::default() };
        if finding.can_break {
            let were = if finding.observed.starts_with("all ") { " were" } else { ":" };
            finding.observed = format!("{name}{were} {}", finding.observed);
        }
        finding.slot = slots[finding.slot.min(1)];
        (finding.can_hold, finding.can_break) = (can_hold, can_break);
        finding
    }
}
