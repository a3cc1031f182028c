//! Those who follow a signal without its short pulses.

use crate::monitor::{PulseFilter, TimedValue};

/// Filters, each with whom it is for.
#[derive(Debug)]
pub(super) struct ShortPulses<T> {
    filters: Vec<(PulseFilter, T)>,
    /// After which instant of the trace the first change that waits is known to count.
    due: i64,
}

impl<T: Copy> ShortPulses<T> {
    pub(super) fn new() -> ShortPulses<T> {
        ShortPulses { filters: Vec::new(), due: i64::MAX }
    }

    /// Adds one; its place.
    pub(super) fn add(&mut self, filter: PulseFilter, whom: T) -> usize {
        self.filters.push((filter, whom));
        self.filters.len() - 1
    }

    /// The next event of the signal of the filter at this place.
    pub(super) fn see(&mut self, place: usize, seen: &TimedValue, mut out: impl FnMut(T, &TimedValue)) {
        let Some((filter, whom)) = self.filters.get_mut(place) else { return };
        filter.see(seen, &mut |seen| out(*whom, seen));
        self.due = self.due.min(filter.due());
    }

    /// The trace has come to `now`.
    #[inline]
    pub(super) fn settle(&mut self, now: i64, mut out: impl FnMut(T, &TimedValue)) {
        if now <= self.due {
            return;
        }
        for (filter, whom) in &mut self.filters {
            filter.settle(now, &mut |seen| out(*whom, seen));
        }
        self.due = self.filters.iter().map(|(filter, _)| filter.due()).min().unwrap_or(i64::MAX);
    }

    /// Nothing comes any more; `end` says when the case ended for somebody.
    pub(super) fn finish(self, end: impl Fn(T) -> i64, mut out: impl FnMut(T, &TimedValue)) {
        for (filter, whom) in self.filters {
            filter.finish(end(whom), &mut |seen| out(whom, seen));
        }
    }
}
