//! What a monitor found, and what a case came to.

use record::{ClaimRecord, Figure, MeasurementRecord, Verdict, Window as Shown};
use signal::{Cause, Time, When};

use super::{Seen, Window};
use crate::alarm;

/// What a claim came to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Finding {
    /// Some placement of the events inside their intervals fulfils the claim.
    pub can_hold: bool,
    /// Some placement does not.
    pub can_break: bool,
    /// Why it is not a plain pass, one sentence; may be empty.
    pub reason: String,
    /// What was observed: `fell 100.2 ms after busy`.
    pub observed: String,
    /// Distance to the nearest limit in the worst placement; negative where it is exceeded.
    pub margin: Option<Figure>,
    /// How well the deciding figure is known.
    pub uncertainty: Option<Figure>,
    /// When the claim looks.
    pub window: Option<Shown>,
    /// The values that the claim allows, where it has limits for them.
    pub bounds: Option<record::Bounds>,
    /// The instant that decided.
    pub deciding: Option<When>,
    /// The signal that is the evidence, by its place among the claim's signals.
    pub slot: usize,
    /// Who made the deciding change.
    pub cause: Option<Cause>,
    /// What came closest to what was wanted, and who made it.
    pub nearest_miss: Option<(String, Option<Cause>)>,
}

impl Finding {
    /// The verdict: pass if it holds in every placement, fail if in none, else inconclusive.
    pub fn verdict(&self) -> Verdict {
        match (self.can_hold, self.can_break) {
            (true, false) => Verdict::Pass,
            (false, _) => Verdict::Fail,
            (true, true) => Verdict::Inconclusive,
        }
    }

    /// The same with the deciding event.
    #[must_use]
    pub fn decided_by(mut self, seen: &Seen) -> Finding {
        self.deciding = Some(clipped(seen.a, seen.b));
        self.cause = Some(seen.cause);
        self
    }
}

/// An interval for display: what is beyond all time is held at the origin of the trace or the known end.
pub(crate) fn clipped(a: i64, b: i64) -> When {
    let b = if b == i64::MIN { 0 } else { b };
    let a = if a == i64::MIN { 0.min(b) } else { a };
    let b = if b == i64::MAX { a } else { b };
    When::within(Time::from_nanos(a), Time::from_nanos(b))
}

impl Window {
    /// The window as a report shows it.
    pub fn shown(&self) -> Shown {
        Shown {
            from_ns: [self.from.a, self.from.b],
            until_ns: [self.until.a, self.until.b],
            limit_from_ns: None,
            limit_until_ns: None,
        }
    }
}

/// What a case came to by its trace.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outcome {
    /// The expectations in the plan's order, then the steps that had to happen.
    pub claims: Vec<ClaimRecord>,
    /// The measurements in the plan's order.
    pub measurements: Vec<MeasurementRecord>,
    /// The greatest verdict of all.
    pub verdict: Verdict,
    /// Why, one sentence: the first claim or measurement that has this verdict; empty for a pass.
    pub reason: String,
}

impl Outcome {
    /// Combines claims and measurements.
    pub fn of(claims: Vec<ClaimRecord>, measurements: Vec<MeasurementRecord>) -> Outcome {
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
        Outcome { claims, measurements, verdict, reason }
    }
}
