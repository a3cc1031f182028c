//! How late this machine wakes a thread up.

use crate::{Bell, Histogram, HostInstant};
use signal::Span;
use std::sync::atomic::{AtomicBool, Ordering};

/// What came of waiting many times.
#[derive(Clone, Debug)]
pub struct Wakeups {
    /// How late the waits ended, in nanoseconds.
    pub late: Histogram,
    /// Wake-ups that were left out, for the one before them ended later than they were due.
    pub missed: u64,
}

/// Waits `count` times on the bell, as the executor does, each time until an instant that lies `interval` after
/// the one before, whatever became of it: nothing drifts. An instant that is over already is left out and
/// counted. Ends early when `stop` becomes TRUE. Allocates before the first wait only.
pub fn wakeups(bell: &Bell, interval: Span, count: u64, stop: &AtomicBool) -> Wakeups {
    let interval = interval.max(Span::from_nanos(1));
    let mut wakeups = Wakeups { late: Histogram::new(), missed: 0 };
    let mut due = HostInstant::now() + interval;
    while wakeups.late.count() < count && !stop.load(Ordering::Relaxed) {
        bell.wait_until(due);
        let now = HostInstant::now();
        wakeups.late.note((now - due).as_nanos());
        due += interval;
        if now > due {
            let over = (now - due).as_nanos() / interval.as_nanos() + 1;
            wakeups.missed += over.unsigned_abs();
            due += interval * over;
        }
    }
    wakeups
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_wait_counts_once_and_none_ends_early() {
        let began = HostInstant::now();
        let found = wakeups(&Bell::new(), Span::from_micros(200), 50, &AtomicBool::new(false));
        let lasted = began.elapsed();
        assert_eq!(found.late.count(), 50);
        // The last wait was due this much after the first, and those left out lie between.
        assert!(lasted >= Span::from_micros(200) * i64::try_from(50 + found.missed).unwrap(), "{lasted}");
    }

    #[test]
    fn an_interval_that_no_machine_keeps_is_missed_and_not_made_up_for() {
        let found = wakeups(&Bell::new(), Span::from_nanos(1), 100, &AtomicBool::new(false));
        assert!(found.late.count() == 100 && found.missed > 100, "{}", found.missed);
    }

    #[test]
    fn whoever_wants_it_to_end_need_not_wait() {
        assert_eq!(wakeups(&Bell::new(), Span::from_secs(1), 10, &AtomicBool::new(true)).late.count(), 0);
    }
}
