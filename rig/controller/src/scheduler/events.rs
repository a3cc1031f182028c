//! The rate at which events may come, and events on their way to tasks.

use profile::EVENT_WINDOW;
use signal::Time;

/// The instants of the last events: one more than the limit within the window is too many.
#[derive(Clone, Copy, Debug)]
pub(super) struct EventRate {
    last: [Time; 6],
    next: usize,
}

impl EventRate {
    pub(super) const fn new() -> EventRate {
        EventRate { last: [Time::MIN; 6], next: 0 }
    }

    /// Counts an event at `now`; whether it is the one that exceeds `limit` within [`EVENT_WINDOW`]
    /// (controller:TASK-31). Events a whole window apart are not in one window.
    pub(super) fn exceeded(&mut self, now: Time, limit: usize) -> bool {
        let limit = limit.clamp(1, self.last.len());
        let place = self.next % limit;
        let before = std::mem::replace(&mut self.last[place], now);
        self.next = (place + 1) % limit;
        before != Time::MIN && before.saturating_add(EVENT_WINDOW) > now
    }
}

/// Events on their way to the tasks that they release, oldest first: all take the same time.
#[derive(Clone, Copy, Debug)]
pub(super) struct EventQueue {
    list: [(Time, usize); 32],
    first: usize,
    count: usize,
}

impl EventQueue {
    pub(super) const fn new() -> EventQueue {
        EventQueue { list: [(Time::MAX, 0); 32], first: 0, count: 0 }
    }

    /// When the next one arrives; [`Time::MAX`] for none.
    #[inline]
    pub(super) fn next(&self) -> Time {
        if self.count == 0 { Time::MAX } else { self.list[self.first].0 }
    }

    /// FALSE where there is no room: the event is lost.
    pub(super) fn put(&mut self, at: Time, rank: usize) -> bool {
        if self.count == self.list.len() {
            return false;
        }
        self.list[(self.first + self.count) % self.list.len()] = (at, rank);
        self.count += 1;
        true
    }

    /// The rank of the task whose event has arrived by `now`.
    pub(super) fn take(&mut self, now: Time) -> Option<usize> {
        if self.next() > now {
            return None;
        }
        let (_, rank) = self.list[self.first];
        self.first = (self.first + 1) % self.list.len();
        self.count -= 1;
        Some(rank)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // controller:TASK-31
    #[test]
    fn one_event_more_than_the_limit_in_a_window() {
        let us = |n: i64| Time::from_nanos(n * 1_000);
        let exceeded = |times: &[i64], limit| {
            let mut rate = EventRate::new();
            times.iter().map(|at| rate.exceeded(us(*at), limit)).collect::<Vec<_>>()
        };
        assert_eq!(exceeded(&[0, 1, 2, 3, 4, 5], 5), [false, false, false, false, false, true]);
        assert_eq!(exceeded(&[0, 1, 2, 3, 4, 5, 999], 6), [false, false, false, false, false, false, true]);
        assert_eq!(exceeded(&[0, 1, 2, 3, 4, 5, 1000], 6), [false; 7]);
        // One at the very beginning of time is an event like any other.
        assert_eq!(exceeded(&[0, 0, 0], 2), [false, false, true]);
    }
}
