//! The time of a run on the kernel's monotonic clock.

use rustix::time::{ClockId, clock_getres, clock_gettime};
use signal::{Span, Time};
use std::sync::Arc;
use std::sync::atomic::{AtomicI64, Ordering};

/// Where on the kernel's monotonic clock time 0 of a run lies. All who share it see one time: the clock that wakes
/// the executor, the kernel's stamps of edges, the threads of a board.
#[derive(Clone, Debug)]
pub struct TimeBase {
    origin: Arc<AtomicI64>,
}

impl TimeBase {
    /// Time 0 is the moment of this call.
    pub fn start() -> TimeBase {
        TimeBase { origin: Arc::new(AtomicI64::new(monotonic())) }
    }

    /// Time 0 is now, for everybody who shares this base.
    pub fn restart(&self) {
        self.origin.store(monotonic(), Ordering::Release);
    }

    /// Now.
    pub fn now(&self) -> Time {
        self.at(monotonic())
    }

    /// The instant of a stamp of the monotonic clock, in nanoseconds.
    pub fn at(&self, stamp: i64) -> Time {
        Time::from_nanos(stamp.saturating_sub(self.origin.load(Ordering::Acquire)))
    }

    /// The stamp of an instant on the monotonic clock, in nanoseconds.
    pub fn stamp(&self, at: Time) -> i64 {
        self.origin.load(Ordering::Acquire).saturating_add(at.as_nanos())
    }

    /// Time stood still for this long.
    pub fn stood_still(&self, lasted: Span) {
        self.origin.fetch_add(lasted.as_nanos(), Ordering::AcqRel);
    }
}

/// The stamp of now on the monotonic clock, in nanoseconds.
pub fn monotonic() -> i64 {
    let now = clock_gettime(ClockId::Monotonic);
    now.tv_sec.saturating_mul(1_000_000_000).saturating_add(now.tv_nsec)
}

/// What has to be added to a stamp of the wall clock to have one of the monotonic clock: a number between these, in
/// nanoseconds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bracket {
    /// At least.
    pub low: i64,
    /// At most.
    pub high: i64,
}

impl Bracket {
    /// As it is now: the wall clock is read between two readings of the monotonic one, and the closest of a few tries
    /// counts.
    pub fn measure() -> Bracket {
        let once = || {
            let before = monotonic();
            let wall = clock_gettime(ClockId::Realtime);
            let after = monotonic();
            let wall = wall.tv_sec.saturating_mul(1_000_000_000).saturating_add(wall.tv_nsec);
            Bracket { low: before.saturating_sub(wall), high: after.saturating_sub(wall) }
        };
        let mut best = once();
        for _ in 0..2 {
            let next = once();
            if next.high - next.low < best.high - best.low {
                best = next;
            }
        }
        best
    }

    /// What holds whether it is this or the other: between two measurements somebody may have set the wall clock.
    #[must_use]
    pub fn or(self, other: Bracket) -> Bracket {
        Bracket { low: self.low.min(other.low), high: self.high.max(other.high) }
    }
}

/// How far apart the instants are at which a wait can end, in nanoseconds: 1 where the kernel has high-resolution
/// timers, else its tick.
pub fn resolution() -> i64 {
    let step = clock_getres(ClockId::Monotonic);
    step.tv_sec.saturating_mul(1_000_000_000).saturating_add(step.tv_nsec)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stamps_and_instants_are_one_clock_for_all_who_share_it() {
        let base = TimeBase::start();
        let other = base.clone();
        let stamp = monotonic();
        assert_eq!(base.stamp(other.at(stamp)), stamp);
        let before = base.at(stamp);
        base.stood_still(Span::from_millis(5));
        assert_eq!(before - other.at(stamp), Span::from_millis(5));
        base.restart();
        assert!(other.at(stamp) <= Time::ZERO);
    }
}
