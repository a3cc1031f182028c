//! Subscriptions: what waits to be reported, and when.

use std::collections::{BTreeMap, VecDeque};

use control::{SignalChange, Topic, WireValue};
use signal::{Span, Time, Value, When};

/// The least and the most time between two messages of a subscription, milliseconds.
const EVERY: (u32, u32) = (5, 3_600_000);

/// A subscription.
#[derive(Debug)]
pub(super) struct Subscription {
    /// What it brings.
    pub(super) of: Of,
    /// The least time between two messages.
    pub(super) every: Span,
    /// The earliest instant of the next message.
    pub(super) due: Time,
    /// Lines that were left out since the last one.
    pub(super) missed: u64,
}

/// What a subscription brings.
#[derive(Debug)]
pub(super) enum Of {
    /// Changes of these signals.
    Signals { numbers: Vec<u32>, waiting: Waiting },
    /// The status; which one was reported last, and when.
    Status { reported: Option<u64>, last: Time },
    /// The log.
    Log,
    /// Frames.
    Frames,
    /// Plans.
    Plan,
}

impl Subscription {
    /// A subscription whose first message is due at once.
    pub(super) fn new(topic: &Topic, numbers: Vec<u32>, changes: usize, now: Time) -> Subscription {
        let (of, every) = match *topic {
            Topic::Signals { every_ms, all, .. } => {
                let waiting = Waiting::new(if all { changes } else { 0 });
                (Of::Signals { numbers, waiting }, every_ms)
            }
            Topic::Status { every_ms } => (Of::Status { reported: None, last: now }, every_ms),
            Topic::Log => (Of::Log, 0),
            Topic::Frames => (Of::Frames, 0),
            Topic::Plan => (Of::Plan, 0),
        };
        let every = Span::from_millis(every.clamp(EVERY.0, EVERY.1).into());
        Subscription { of, every, due: now, missed: 0 }
    }

    /// The signals that it watches.
    pub(super) fn numbers(&self) -> &[u32] {
        match &self.of {
            Of::Signals { numbers, .. } => numbers,
            _ => &[],
        }
    }
}

/// Changes of a subscription that wait to be reported. The last change of each signal is never lost: a client that reads
/// slowly misses what was in between, and is not left with a value that has passed.
#[derive(Debug)]
pub(super) struct Waiting {
    /// Every change, where all are wanted, as many as fit.
    all: VecDeque<SignalChange>,
    room: usize,
    /// The last change of signals that did not fit or were not wanted one by one, with its place in the order.
    newest: BTreeMap<u32, (u64, SignalChange)>,
    place: u64,
    missed: u64,
}

impl Waiting {
    /// Room for so many changes; with none each signal's last change alone is kept.
    pub(super) fn new(room: usize) -> Waiting {
        Waiting { all: VecDeque::new(), room, newest: BTreeMap::new(), place: 0, missed: 0 }
    }

    /// Whether every change is wanted.
    pub(super) fn wants_all(&self) -> bool {
        self.room > 0
    }

    /// The next change would push another one out.
    pub(super) fn is_full(&self) -> bool {
        self.room > 0 && self.all.len() == self.room
    }

    /// A signal changed.
    pub(super) fn put(&mut self, signal: u32, at: When, value: Value) {
        let change = SignalChange(signal, at.earliest.as_nanos(), at.latest.as_nanos(), WireValue(value));
        if self.room == 0 {
            self.keep(change);
            return;
        }
        if self.all.len() == self.room
            && let Some(oldest) = self.all.pop_front()
            && self.keep(oldest)
        {
            self.missed += 1;
        }
        self.all.push_back(change);
    }

    /// Keeps the last change of a signal; reports whether another one had to give way.
    fn keep(&mut self, change: SignalChange) -> bool {
        self.place += 1;
        self.newest.insert(change.0, (self.place, change)).is_some()
    }

    /// Nothing waits.
    pub(super) fn is_empty(&self) -> bool {
        self.all.is_empty() && self.newest.is_empty()
    }

    /// The next message: at most so many changes in their order, and how many were missed before them.
    pub(super) fn take(&mut self, most: usize) -> (Vec<SignalChange>, u64) {
        let mut kept: Vec<(u64, SignalChange)> = self.newest.values().copied().collect();
        kept.sort_unstable_by_key(|(place, _)| *place);
        kept.truncate(most);
        for (_, change) in &kept {
            self.newest.remove(&change.0);
        }
        let mut changes: Vec<SignalChange> = kept.into_iter().map(|(_, change)| change).collect();
        // What was kept aside is older than all that waits one by one.
        let more = if self.newest.is_empty() { most - changes.len() } else { 0 };
        changes.extend(self.all.drain(..more.min(self.all.len())));
        if self.all.is_empty() {
            self.all = VecDeque::new();
        }
        (changes, std::mem::take(&mut self.missed))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn put(waiting: &mut Waiting, signal: u32, at: i64) {
        waiting.put(signal, When::exactly(Time::from_nanos(at)), Value::Int(at));
    }

    fn reported(changes: &[SignalChange]) -> Vec<(u32, i64)> {
        changes.iter().map(|change| (change.0, change.1)).collect()
    }

    #[test]
    fn only_the_last_change_of_each_signal_waits() {
        let mut waiting = Waiting::new(0);
        for (signal, at) in [(7, 1), (3, 2), (7, 3)] {
            put(&mut waiting, signal, at);
        }
        assert_eq!(waiting.take(1), (vec![SignalChange(3, 2, 2, WireValue(Value::Int(2)))], 0));
        assert_eq!(reported(&waiting.take(9).0), [(7, 3)]);
        assert!(waiting.is_empty());
    }

    #[test]
    fn what_does_not_fit_is_counted_but_never_a_signals_last_change() {
        let mut waiting = Waiting::new(2);
        for (signal, at) in [(1, 1), (2, 2), (2, 3), (2, 4), (2, 5)] {
            put(&mut waiting, signal, at);
        }
        let (changes, missed) = waiting.take(100);
        assert_eq!((reported(&changes), missed), (vec![(1, 1), (2, 3), (2, 4), (2, 5)], 1));
    }

    proptest! {
        #[test]
        fn every_change_is_told_or_counted_in_its_order(
            room in 1usize..8,
            steps in prop::collection::vec((0u32..4, prop::option::weighted(0.2, 1usize..6)), 0..100),
        ) {
            let (mut waiting, mut seen, mut missed) = (Waiting::new(room), Vec::new(), 0);
            let mut take = |waiting: &mut Waiting, most| {
                let (changes, lost) = waiting.take(most);
                assert!(changes.len() <= most);
                seen.extend(reported(&changes));
                missed += lost;
            };
            let mut last = BTreeMap::new();
            for (at, (signal, most)) in steps.iter().enumerate() {
                put(&mut waiting, *signal, at as i64);
                last.insert(*signal, at as i64);
                if let Some(most) = most {
                    take(&mut waiting, *most);
                }
            }
            while !waiting.is_empty() {
                take(&mut waiting, 3);
            }
            prop_assert!(seen.is_sorted_by_key(|(_, at)| *at));
            prop_assert_eq!(seen.len() as u64 + missed, steps.len() as u64);
            for (signal, at) in last {
                prop_assert!(seen.contains(&(signal, at)));
            }
        }
    }
}
