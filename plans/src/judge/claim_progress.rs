//! How far the claims of a case are while its trace still grows: for a person who watches.

use record::Verdict;
use signal::{ClockError, Time, Trace, When};

use super::{CaseJudge, JudgeError, Scenario};
use crate::lang::Anchor;

/// How far a claim is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ClaimProgress {
    /// The claim's own name, or what it expects.
    pub name: String,
    /// What it came to, if nothing that comes can change that.
    pub verdict: Option<Verdict>,
}

impl ClaimProgress {
    /// The claims by what the trace has up to `now`, stamped by a clock that may be off by `error`. Reads the whole trace.
    ///
    /// # Errors
    /// [`JudgeError`] if the trace cannot be read, or lacks a signal that the claims look at.
    pub fn of(
        scenario: &Scenario,
        trace: &Trace,
        error: ClockError,
        now: Time,
    ) -> Result<Vec<ClaimProgress>, JudgeError> {
        let unfit = |_| JudgeError::MissingSignal;
        let judge = CaseJudge::new(scenario.clone(), trace.signals()).map_err(unfit)?;
        let mut judge = judge.by_clock(error);
        for event in trace.events() {
            judge.feed(&event?);
        }
        let lost = judge.lost();
        // What is awaited stands after the claims of the plan; its window is that of its wait.
        let at_end: Vec<bool> =
            scenario.expectations.iter().map(|each| each.claim.anchors().contains(&&Anchor::END)).collect();
        let outcome = judge.finish(When::exactly(now), trace)?;
        let standings = outcome.claims.into_iter().enumerate().map(|(place, claim)| {
            let over = claim.window.is_some_and(|window| {
                let until = window.limit_until_ns.unwrap_or(window.until_ns[1]);
                until <= now.as_nanos()
            });
            // Invariants and alarms hold to the end, whatever was seen.
            let is_open = claim.guard || at_end.get(place).copied().unwrap_or(false);
            let verdict = match lost.get(place) {
                Some(true) => Some(Verdict::Fail),
                _ if over && !is_open => Some(claim.verdict),
                _ => None,
            };
            ClaimProgress { name: claim.name, verdict }
        });
        Ok(standings.collect())
    }
}
