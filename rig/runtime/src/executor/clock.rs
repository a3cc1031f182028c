//! The clocks that an executor can run on: virtual, virtual with seeded lateness, and the host's.

use drivers::BoardContext;
use host::{Bell, TimeBase, Woken};
use signal::{Random, Span, Time};
use std::sync::Arc;

/// What wakes the executor. Time only moves forward.
pub trait Clock: Send {
    /// Time 0 is now: a case begins.
    fn begin(&mut self) {}

    /// Waits until `due` and returns the instant at which the wait really ended, never before `due`.
    fn wait_until(&mut self, due: Time) -> Time;

    /// As [`Clock::wait_until`], and ends early when the board has something to report.
    fn wait(&mut self, due: Time) -> Time {
        self.wait_until(due)
    }

    /// Whether the board said that it has something to report, since this was last asked.
    fn rung(&mut self) -> bool {
        false
    }

    /// The instant now, where asking matters: after a call that takes host time.
    fn now(&mut self) -> Time;

    /// Time stood still for a while: it goes on from `at`.
    fn stood_still(&mut self, _at: Time) {}

    /// Whether waits end exactly when they are due, so that events are known to the nanosecond.
    fn is_exact(&self) -> bool;

    /// What the record of the run calls this clock.
    fn name(&self) -> &'static str;
}

/// Virtual time: every wait ends at once and exactly.
#[derive(Clone, Copy, Debug, Default)]
pub struct VirtualClock {
    now: Time,
}

impl Clock for VirtualClock {
    fn wait_until(&mut self, due: Time) -> Time {
        self.now = self.now.max(due);
        self.now
    }

    fn now(&mut self) -> Time {
        self.now
    }

    fn is_exact(&self) -> bool {
        true
    }

    fn name(&self) -> &'static str {
        "virtual"
    }
}

/// Virtual time whose waits end late by a seeded amount: the real-time executor's logic under test without
/// a real clock.
#[derive(Clone, Copy, Debug)]
pub struct LateClock {
    now: Time,
    worst: Span,
    random: Random,
}

impl LateClock {
    /// Waits that end up to `worst` late, drawn from `seed`.
    pub fn new(seed: u64, worst: Span) -> Self {
        LateClock { now: Time::ZERO, worst, random: Random::new(seed) }
    }
}

impl Clock for LateClock {
    fn wait_until(&mut self, due: Time) -> Time {
        if due > self.now {
            let late = self.random.below(self.worst.as_nanos().max(0) as u64 + 1);
            self.now = due + Span::from_nanos(late as i64);
        }
        self.now
    }

    fn now(&mut self) -> Time {
        self.now
    }

    fn is_exact(&self) -> bool {
        false
    }

    fn name(&self) -> &'static str {
        "late"
    }
}

/// The host's monotonic clock. A wait ends late by what the host is late.
#[derive(Clone, Debug)]
pub struct HostClock {
    base: TimeBase,
    bell: Arc<Bell>,
    rung: bool,
}

impl HostClock {
    /// A clock of its own; time 0 is the moment of this call.
    pub fn start() -> Self {
        HostClock { base: TimeBase::start(), bell: Arc::default(), rung: false }
    }

    /// The clock of a board: its time, and whoever rings its bell ends a wait.
    pub fn of(surroundings: &BoardContext) -> Self {
        HostClock { base: surroundings.time.clone(), bell: surroundings.bell.clone(), rung: false }
    }
}

impl Clock for HostClock {
    fn begin(&mut self) {
        self.base.restart();
        // Whoever rang did so for what was before.
        self.rung();
    }

    fn wait_until(&mut self, due: Time) -> Time {
        loop {
            let now = self.now();
            if now >= due {
                return now;
            }
            self.rung |= self.bell.wait_until(self.base.stamp(due)) == Woken::Rung;
        }
    }

    fn wait(&mut self, due: Time) -> Time {
        if !self.rung {
            self.rung = self.bell.wait_until(self.base.stamp(due)) == Woken::Rung;
        }
        self.now()
    }

    fn rung(&mut self) -> bool {
        std::mem::take(&mut self.rung) | self.bell.has_rung()
    }

    fn now(&mut self) -> Time {
        self.base.now()
    }

    fn stood_still(&mut self, at: Time) {
        let passed = self.now() - at;
        if !passed.is_negative() {
            self.base.stood_still(passed);
        }
    }

    fn is_exact(&self) -> bool {
        false
    }

    fn name(&self) -> &'static str {
        "real"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lateness_comes_from_the_seed_and_stays_within_its_bound() {
        let worst = Span::from_micros(50);
        let walk = |seed| {
            let mut clock = LateClock::new(seed, worst);
            (1..200)
                .map(|n| {
                    let due = Time::from_nanos(n * 1_000_000);
                    let late = clock.wait_until(due) - due;
                    assert!(!late.is_negative() && late <= worst);
                    late
                })
                .collect::<Vec<_>>()
        };
        assert_eq!(walk(7), walk(7));
        assert_ne!(walk(7), walk(8));
    }

    #[test]
    fn a_ring_ends_a_wait_early_and_is_told_once() {
        let lives = BoardContext::new(host::Realtime::default());
        let mut clock = HostClock::of(&lives);
        let far = clock.now() + Span::from_secs(3600);
        lives.bell.ring();
        assert!(clock.wait(far) < far);
        assert!(clock.rung() && !clock.rung());
        // One that must last lasts, and what rang meanwhile is not forgotten.
        lives.bell.ring();
        let soon = clock.now() + Span::from_millis(1);
        assert!(clock.wait_until(soon) >= soon);
        assert!(clock.rung());
    }

    #[test]
    fn time_that_stood_still_does_not_count() {
        let mut clock = HostClock::start();
        let at = clock.now();
        clock.wait_until(at + Span::from_millis(20));
        clock.stood_still(at);
        assert!(clock.now() < at + Span::from_millis(20));
        clock.begin();
        assert!(clock.now() < at + Span::from_millis(20));
    }
}
