//! The time of a run on the kernel's monotonic clock.

use crate::HostInstant;
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
        TimeBase { origin: Arc::new(AtomicI64::new(HostInstant::now().as_nanos())) }
    }

    /// Time 0 is now, for everybody who shares this base.
    pub fn restart(&self) {
        self.origin.store(HostInstant::now().as_nanos(), Ordering::Release);
    }

    /// Now.
    pub fn now(&self) -> Time {
        self.at(HostInstant::now())
    }

    /// The instant of the run at this instant of the host.
    pub fn at(&self, stamp: HostInstant) -> Time {
        Time::from_nanos(stamp.as_nanos().saturating_sub(self.origin.load(Ordering::Acquire)))
    }

    /// The instant of the host at this instant of the run.
    pub fn stamp(&self, at: Time) -> HostInstant {
        HostInstant::from_nanos(self.origin.load(Ordering::Acquire).saturating_add(at.as_nanos()))
    }

    /// Time stood still for this long.
    pub fn stood_still(&self, lasted: Span) {
        self.origin.fetch_add(lasted.as_nanos(), Ordering::AcqRel);
    }
}

/// What the monotonic clock shows when the wall clock shows 0: an instant between these.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bracket {
    /// At the earliest.
    low: HostInstant,
    /// At the latest.
    high: HostInstant,
}

impl Bracket {
    /// As it is now: the wall clock is read between two readings of the monotonic one, and the closest of a few tries
    /// counts.
    pub fn measure() -> Bracket {
        let once = || {
            let before = HostInstant::now();
            let wall = clock_gettime(ClockId::Realtime);
            let after = HostInstant::now();
            let wall =
                Span::from_nanos(wall.tv_sec.saturating_mul(1_000_000_000).saturating_add(wall.tv_nsec));
            Bracket { low: before - wall, high: after - wall }
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

    /// The instants between which the wall clock showed this: nanoseconds since 1970.
    pub fn instants(self, wall: i64) -> (HostInstant, HostInstant) {
        let wall = Span::from_nanos(wall);
        (self.low + wall, self.high + wall)
    }

    /// What holds whether it is this or the other: between two measurements somebody may have set the wall clock.
    #[must_use]
    pub fn or(self, other: Bracket) -> Bracket {
        Bracket { low: self.low.min(other.low), high: self.high.max(other.high) }
    }
}

/// How far apart the instants are at which a wait can end: 1 ns where the kernel has high-resolution timers, else its
/// tick.
pub fn resolution() -> Span {
    let step = clock_getres(ClockId::Monotonic);
    Span::from_nanos(step.tv_sec.saturating_mul(1_000_000_000).saturating_add(step.tv_nsec))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stamps_and_instants_are_one_clock_for_all_who_share_it() {
        let base = TimeBase::start();
        let other = base.clone();
        let stamp = HostInstant::now();
        assert_eq!(base.stamp(other.at(stamp)), stamp);
        let before = base.at(stamp);
        base.stood_still(Span::from_millis(5));
        assert_eq!(before - other.at(stamp), Span::from_millis(5));
        base.restart();
        assert!(other.at(stamp) <= Time::ZERO);
    }
}
