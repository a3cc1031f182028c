//! Takes the short pulses out of a signal: `pulses-longer-than`, for every monitor that looks at edges or levels.
//!
//! A change of level counts once the new level has lasted for longer than that, and then from its own instant. A pulse
//! that may be short or long within its intervals leaves the level unknown for as long as it matters. So does what was
//! there when the signal was first known, which may have begun long before.
//!
//! Of a signal that is recorded at most every so often, what is not known between two values for no longer than that is
//! taken as between two samples: a level that is read before and after it lasted, and a change came somewhere in it.

use signal::Value;

use super::{TimedValue, Truth, ValueTest};

/// What the level of a value is.
#[derive(Clone, Debug)]
pub(crate) enum PulseLevel {
    /// Of a line: whether it is TRUE.
    Line,
    /// Whether it meets a condition, to within so much.
    Test(ValueTest, f64),
    /// None: every value of a number counts, and nothing but what is not known for a short time is left out.
    EveryValue,
}

impl PulseLevel {
    #[inline]
    fn of(&self, value: Value) -> Truth {
        match (self, value) {
            (_, Value::Unknown) => Truth::Unknown,
            (PulseLevel::Line, value) => Truth::of(matches!(value, Value::Bool(true))),
            (PulseLevel::Test(test, slack), value) => test.holds(value, *slack),
            (PulseLevel::EveryValue, _) => Truth::True,
        }
    }
}

/// Takes short pulses out of one signal.
#[derive(Clone, Debug)]
pub(crate) struct PulseFilter {
    level: PulseLevel,
    /// Pulses of at most this width do not count, nanoseconds; where the clock may be off, at the least and at the most.
    longest: (i64, i64),
    /// How far after the newest event of the trace one of this signal can begin, nanoseconds.
    lag: i64,
    /// The level that counts; unknown while it is open which one does.
    counts: Truth,
    /// The change that is not known yet to count.
    pending: Option<(TimedValue, Truth)>,
    /// Short times between two values in which the signal is not known are bridged.
    bridges: bool,
    /// Since when the signal is not known, where that may be a time to bridge.
    gap: Option<TimedValue>,
}

impl PulseFilter {
    pub(crate) fn new(level: PulseLevel, longest: (i64, i64), lag: i64) -> PulseFilter {
        PulseFilter { level, longest, lag, counts: Truth::Unknown, pending: None, bridges: false, gap: None }
    }

    /// For a signal that is recorded at most every so often.
    #[must_use]
    pub(crate) fn bridging(self) -> PulseFilter {
        PulseFilter { bridges: true, ..self }
    }

    /// How long a change is held back at most before it is known whether it counts, nanoseconds.
    pub(crate) fn holds_for(&self) -> i64 {
        if self.bridges { self.longest.1.saturating_mul(2) } else { self.longest.1 }
    }

    /// The next event of the signal; hands on what counts.
    pub(crate) fn see(&mut self, seen: &TimedValue, out: &mut impl FnMut(&TimedValue)) {
        if self.bridges && seen.value == Value::Unknown {
            self.gap.get_or_insert(*seen);
            return;
        }
        let Some(gap) = self.gap.take() else { return self.step(seen, out) };
        let before = self.pending.as_ref().map_or(self.counts, |(_, level)| *level);
        if seen.b.saturating_sub(gap.a) > self.longest.0 {
            self.step(&gap, out);
            self.step(seen, out);
        } else if !matches!(self.level, PulseLevel::EveryValue) && self.level.of(seen.value) == before {
            self.step(seen, out);
        } else {
            self.step(&TimedValue { a: gap.a, since: gap.since, ..*seen }, out);
        }
    }

    fn step(&mut self, seen: &TimedValue, out: &mut impl FnMut(&TimedValue)) {
        if matches!(self.level, PulseLevel::EveryValue) {
            return out(seen);
        }
        let level = self.level.of(seen.value);
        let Some((old, before)) = self.pending else {
            if level == self.counts && level != Truth::Unknown {
                out(seen);
            } else {
                self.pending = Some((*seen, level));
            }
            return;
        };
        if level == before {
            return;
        }
        let (least, most) = (seen.a.saturating_sub(old.b), seen.b.saturating_sub(old.a));
        if before != Truth::Unknown && least > self.longest.1 {
            out(&old);
            (self.counts, self.pending) = (before, Some((*seen, level)));
        } else if self.counts == Truth::Unknown {
            // Nothing has lasted for long enough.
            self.pending = Some((*seen, level));
        } else if level == self.counts {
            if most <= self.longest.0 {
                self.pending = None;
                // The level is what it was, a number may be another one.
                out(seen);
            } else {
                self.leave_open((old, before), (*seen, level), out);
            }
        } else if before == Truth::Unknown && most <= self.longest.0 {
            // Somewhere in what is not known it came to be the other level.
            self.pending = Some((TimedValue { a: old.a, since: old.since, ..*seen }, level));
        } else {
            self.leave_open((old, before), (*seen, level), out);
        }
    }

    /// Whether this stretch counts is not known.
    fn leave_open(
        &mut self,
        (old, level): (TimedValue, Truth),
        next: (TimedValue, Truth),
        out: &mut impl FnMut(&TimedValue),
    ) {
        out(&TimedValue { value: if level == Truth::Unknown { old.value } else { Value::Unknown }, ..old });
        (self.counts, self.pending) = (Truth::Unknown, Some(next));
    }

    /// The trace has come to `now`: hands on a change that has lasted long enough by then.
    pub(crate) fn settle(&mut self, now: i64, out: &mut impl FnMut(&TimedValue)) {
        if now <= self.due() {
            return;
        }
        if let Some(gap) = self.gap.take() {
            return self.step(&gap, out);
        }
        if let Some((old, level)) = self.pending.take() {
            out(&old);
            self.counts = level;
        }
    }

    /// After which instant of the trace a change is known to count; `i64::MAX` where none waits.
    pub(crate) fn due(&self) -> i64 {
        let waits = self.gap.as_ref().or(self.pending.as_ref().map(|(pending, _)| pending));
        let Some(pending) = waits else { return i64::MAX };
        pending.b.saturating_add(self.longest.1).saturating_add(self.lag)
    }

    /// Nothing comes any more; the case ended at `end`.
    pub(crate) fn finish(mut self, end: i64, out: &mut impl FnMut(&TimedValue)) {
        if let Some(gap) = self.gap.take() {
            self.step(&gap, out);
        }
        let Some((old, level)) = self.pending.take() else { return };
        let lasted = level == Truth::Unknown || end.saturating_sub(old.b) > self.longest.1;
        out(&TimedValue { value: if lasted { old.value } else { Value::Unknown }, ..old });
    }
}
