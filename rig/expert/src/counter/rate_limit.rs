//! How fast a counter is driven (io:STD-HSC-16).

use signal::{Span, Time};

/// Periods by which pulses that filters suppress may be ahead of the highest frequency: so many come of a contact that
/// bounces.
const BURST: i64 = 32;

/// Looks for pulses beyond those that the highest frequency allows.
///
/// Pulse by pulse an instant is kept before which none is due; it moves by a period with each pulse that is within the
/// limit. Pulses may come up to half a period early, so that a train at the highest frequency may have jitter, and those
/// that come sooner are more than there can be at that frequency.
#[derive(Clone, Copy, Debug)]
pub(super) struct PulseRateLimit {
    period: Span,
    slack: Span,
    /// When the next pulse is due at the soonest.
    due: Time,
    suppressed: SuppressedPulses,
}

/// All pulses at the terminal, of which the filters suppress some, at a schedule of their own.
#[derive(Clone, Copy, Debug)]
struct SuppressedPulses {
    due: Time,
    /// Those that were suppressed since the schedule was kept, and were not reported.
    pulses: u64,
    /// The schedule was left behind by more than a burst.
    over: bool,
}

impl SuppressedPulses {
    const NONE: SuppressedPulses = SuppressedPulses { due: Time::MIN, pulses: 0, over: false };

    #[inline]
    fn pass(&mut self, at: Time, period: Span) {
        if at >= self.due {
            *self = SuppressedPulses { due: at, ..SuppressedPulses::NONE };
        }
        self.due = self.due.saturating_add(period);
        self.over |= self.due - at > period * BURST;
    }
}

impl PulseRateLimit {
    /// Nothing came yet; `highest` in hertz.
    pub fn new(highest: u32) -> PulseRateLimit {
        let period = 1_000_000_000 / i64::from(highest.max(1));
        PulseRateLimit {
            period: Span::from_nanos(period),
            slack: Span::from_nanos(period / 2),
            due: Time::MIN,
            suppressed: SuppressedPulses::NONE,
        }
    }

    /// A pulse came. Whether it is one too many.
    #[inline]
    pub fn is_excess(&mut self, at: Time) -> bool {
        self.suppressed.pass(at, self.period);
        let excess = at < self.due - self.slack;
        if !excess {
            self.due = self.due.max(at).saturating_add(self.period);
        }
        excess
    }

    /// A pulse came that filters suppressed. How many to report: once pulses come faster than the limit for longer than a
    /// burst, all of them.
    pub fn report_suppressed_pulse(&mut self, at: Time) -> u64 {
        self.suppressed.pass(at, self.period);
        self.suppressed.pulses += 1;
        if self.suppressed.over { std::mem::take(&mut self.suppressed.pulses) } else { 0 }
    }
}
