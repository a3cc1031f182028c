//! What a case came to.

use record::{ClaimRecord, MeasurementRecord, Verdict};

use crate::alarm;

/// What a case came to by its trace.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JudgedCase {
    /// The expectations in the plan's order, then the steps that had to happen.
    pub claims: Vec<ClaimRecord>,
    /// The measurements in the plan's order.
    pub measurements: Vec<MeasurementRecord>,
    /// The greatest verdict of all.
    pub verdict: Verdict,
    /// Why, one sentence: the first claim or measurement that has this verdict; empty for a pass.
    pub reason: String,
}

impl JudgedCase {
    /// Combines claims and measurements.
    pub fn of(claims: Vec<ClaimRecord>, measurements: Vec<MeasurementRecord>) -> JudgedCase {
        let parts = || {
            let claims = claims.iter().map(|claim| (claim.verdict, &claim.name, &claim.reason));
            claims.chain(measurements.iter().map(|taken| (taken.verdict, &taken.name, &taken.reason)))
        };
        let verdict = Verdict::fold(parts().map(|(verdict, ..)| verdict));
        // An alarm may have ended the case: what other claims lack is then for its sake.
        let alarm = claims.iter().find(|claim| claim.verb == alarm::VERB && claim.verdict == Verdict::Fail);
        let alarm = alarm.map(|claim| (claim.verdict, &claim.name, &claim.reason));
        let reason = match alarm
            .into_iter()
            .chain(parts())
            .find(|(each, ..)| *each == verdict && verdict > Verdict::Pass)
        {
            Some((_, name, reason)) if reason.is_empty() => name.clone(),
            Some((_, name, reason)) => format!("{name}: {reason}"),
            None => String::new(),
        };
        JudgedCase { claims, measurements, verdict, reason }
    }
}
