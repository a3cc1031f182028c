//! Events of one signal keep their order: each interval is cut down to what its neighbours leave possible.
//!
//! After this, both ends of the intervals of one signal never run backwards, and every instant that is left
//! in an interval belongs to some consistent placement of all of them. Every judgement relies on that.
//!
//! Channels as they are built give intervals whose ends never run backwards. A signal for which the first
//! reading saw otherwise is held back in the last one: an event waits until no later one can cut it down.

use std::collections::VecDeque;

use signal::Event;

use crate::monitor::TimedValue;

/// Most events of one signal that wait for a successor. Beyond it the oldest passes with the interval it has:
/// wider than need be, so that a verdict can become inconclusive by it but never wrong.
const WAITING: usize = 256;

/// The events of one signal on their way to the monitors.
#[derive(Clone, Debug, Default)]
pub(crate) struct Orderer {
    waiting: VecDeque<TimedValue>,
    last: Option<(i64, i64)>,
    hold: bool,
    disordered: bool,
}

impl Orderer {
    /// For a signal whose intervals are known to run backwards (`hold`), or not known to.
    pub(crate) fn new(hold: bool) -> Self {
        Orderer { hold, ..Orderer::default() }
    }

    /// Whether an interval ended before its predecessor's.
    pub(crate) fn is_disordered(&self) -> bool {
        self.disordered
    }

    /// Takes the next event of the signal and hands on those whose intervals are final.
    #[inline]
    pub(crate) fn push(&mut self, event: &Event, place: u64, mut out: impl FnMut(&TimedValue)) {
        let (before, ended) = self.last.unwrap_or((i64::MIN, i64::MIN));
        let a = event.at.earliest.as_nanos().max(before);
        let mut b = event.at.latest.as_nanos().max(a);
        self.disordered |= b < ended;
        if !self.hold {
            // The predecessor is gone with the later end: a wider interval is the safe side.
            b = b.max(ended);
            self.last = Some((a, b));
            out(&TimedValue::of(event, a, b, place));
            return;
        }
        self.last = Some((a, b));
        // What can end after `b` cannot: this one comes later and ends at `b`.
        for earlier in self.waiting.iter_mut().rev().take_while(|earlier| earlier.b > b) {
            earlier.b = b.max(earlier.a);
        }
        self.waiting.push_back(TimedValue::of(event, a, b, place));
        // Whatever comes next begins at `a` or later, so an event that ends by then is final.
        while self.waiting.front().is_some_and(|first| first.b <= a) || self.waiting.len() > WAITING {
            if let Some(first) = self.waiting.pop_front() {
                out(&first);
            }
        }
    }

    /// Hands on what still waits: nothing comes any more.
    pub(crate) fn drain(&mut self, mut out: impl FnMut(&TimedValue)) {
        for seen in self.waiting.drain(..) {
            out(&seen);
        }
    }
}
