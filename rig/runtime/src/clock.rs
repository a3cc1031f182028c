//! The clocks that an executor can run on: virtual, virtual with seeded lateness, and the host's.

use signal::{Random, Span, Time};
use std::time::Instant;

/// What wakes the executor. Time only moves forward.
pub trait Clock: Send {
    /// Waits until `due` and returns the instant at which the wait really ended, never before `due`.
    fn wait_until(&mut self, due: Time) -> Time;

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

/// The host's monotonic clock, without real-time priority: waits sleep and end late by what the host is late.
#[derive(Clone, Copy, Debug)]
pub struct HostClock {
    origin: Instant,
}

impl HostClock {
    /// Trace time 0 is the moment of this call.
    pub fn start() -> Self {
        HostClock { origin: Instant::now() }
    }
}

impl Clock for HostClock {
    fn wait_until(&mut self, due: Time) -> Time {
        loop {
            let now = self.now();
            if now >= due {
                return now;
            }
            std::thread::sleep(std::time::Duration::from_nanos((due - now).as_nanos() as u64));
        }
    }

    fn now(&mut self) -> Time {
        Time::from_nanos(i64::try_from(self.origin.elapsed().as_nanos()).unwrap_or(i64::MAX))
    }

    fn stood_still(&mut self, at: Time) {
        let passed = u64::try_from((self.now() - at).as_nanos()).unwrap_or(0);
        self.origin += std::time::Duration::from_nanos(passed);
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
}
