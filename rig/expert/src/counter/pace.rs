//! How fast a counter is driven (io:STD-HSC-16).

use signal::{Span, Time};

/// Periods by which pulses that filters swallow may be ahead of the highest frequency: so many come of a contact that
/// bounces.
const BURST: i64 = 32;

/// Looks for pulses beyond those that the highest frequency allows.
///
/// Pulse by pulse an instant is kept before which none is due; it moves by a period with each pulse that is within the
/// limit. Pulses may come up to half a period early, so that a train at the highest frequency may have jitter, and those
/// that come sooner are more than there can be at that frequency.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pace {
    period: Span,
    slack: Span,
    /// When the next pulse is due at the soonest.
    due: Time,
    swallowed: Swallowed,
}

/// All pulses at the terminal, of which the filters swallow some, at a schedule of their own.
#[derive(Clone, Copy, Debug)]
struct Swallowed {
    due: Time,
    /// Those that were swallowed since the schedule was kept, and were not told.
    pulses: u64,
    /// The schedule was left behind by more than a burst.
    over: bool,
}

impl Swallowed {
    const NONE: Swallowed = Swallowed { due: Time::MIN, pulses: 0, over: false };

    #[inline]
    fn pass(&mut self, at: Time, period: Span) {
        if at >= self.due {
            *self = Swallowed { due: at, ..Swallowed::NONE };
        }
        self.due = self.due.saturating_add(period);
        self.over |= self.due - at > period * BURST;
    }
}

impl Pace {
    /// Nothing came yet; `highest` in hertz.
    pub fn new(highest: u32) -> Pace {
        let period = 1_000_000_000 / i64::from(highest.max(1));
        Pace {
            period: Span::from_nanos(period),
            slack: Span::from_nanos(period / 2),
            due: Time::MIN,
            swallowed: Swallowed::NONE,
        }
    }

    /// A pulse came. Whether it is one too many.
    #[inline]
    pub fn is_excess(&mut self, at: Time) -> bool {
        self.swallowed.pass(at, self.period);
        let excess = at < self.due - self.slack;
        if !excess {
            self.due = self.due.max(at).saturating_add(self.period);
        }
        excess
    }

    /// A pulse came that filters swallowed. How many to tell: once pulses come faster than the limit for longer than a
    /// burst, all of them.
    pub fn swallow(&mut self, at: Time) -> u64 {
        self.swallowed.pass(at, self.period);
        self.swallowed.pulses += 1;
        if self.swallowed.over { std::mem::take(&mut self.swallowed.pulses) } else { 0 }
    }
}
