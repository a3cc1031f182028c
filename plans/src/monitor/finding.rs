//! What a monitor found.

use record::{Figure, Verdict, Window as Shown};
use signal::{Cause, Time, When};

use super::{TimedValue, UncertainWindow};

/// What a claim came to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Finding {
    /// Some placement of the events inside their intervals fulfils the claim.
    pub can_hold: bool,
    /// Some placement does not.
    pub can_break: bool,
    /// It fails whatever more pulses there were: what was seen is too much already.
    pub beyond_help: bool,
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
    pub fn decided_by(mut self, seen: &TimedValue) -> Finding {
        self.deciding = Some(clipped(seen.a, seen.b));
        self.cause = Some(seen.cause);
        self
    }
}

/// How far inside its limits a time of this interval is in the worst placement, nanoseconds; negative outside. A time is never
/// below 0, so 0 is no least limit, and there may be no greatest one.
pub(crate) fn span_margin(extent: (i64, i64), limits: (i64, i64)) -> Option<i64> {
    let above = (limits.0 > 0).then(|| extent.0.saturating_sub(limits.0));
    let below = (limits.1 < i64::MAX).then(|| limits.1.saturating_sub(extent.1));
    above.into_iter().chain(below).min()
}

/// An interval for display: what is beyond all time is held at the origin of the trace or the known end.
pub(crate) fn clipped(a: i64, b: i64) -> When {
    let b = if b == i64::MIN { 0 } else { b };
    let a = if a == i64::MIN { 0.min(b) } else { a };
    let b = if b == i64::MAX { a } else { b };
    When::within(Time::from_nanos(a), Time::from_nanos(b))
}

impl UncertainWindow {
    /// The window as a report shows it.
    pub fn shown(&self) -> Shown {
        Shown {
            from_ns: [self.from.a, self.from.b],
            // An end that is still to come has no latest instant.
            until_ns: [self.until.a, if self.until.b == i64::MAX { self.until.a } else { self.until.b }],
            limit_from_ns: None,
            limit_until_ns: None,
        }
    }
}
