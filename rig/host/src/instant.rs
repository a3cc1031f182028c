//! Instants of the kernel's monotonic clock.

use rustix::time::{ClockId, clock_gettime};
use signal::Span;
use std::ops::{Add, AddAssign, Sub};
use std::sync::atomic::{AtomicI64, Ordering};

/// An instant of the host: nanoseconds of CLOCK_MONOTONIC, on which the kernel stamps edges and threads wait.
///
/// Another instant than [`signal::Time`], which counts from the origin of a trace: only [`TimeBase`](crate::TimeBase)
/// makes one of the other. Arithmetic stops at the ends of the range. There is none for "never happened": that is an
/// `Option`, and [`AtomicInstant`] where threads share it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct HostInstant(i64);

impl HostInstant {
    /// Later than every instant that comes: a wait until then ends by a ring alone.
    pub const NEVER: HostInstant = HostInstant(i64::MAX);

    /// When the clock began: before all that happens in a process.
    pub const BOOT: HostInstant = HostInstant(0);

    /// Now.
    pub fn now() -> HostInstant {
        let now = clock_gettime(ClockId::Monotonic);
        HostInstant(now.tv_sec.saturating_mul(1_000_000_000).saturating_add(now.tv_nsec))
    }

    /// The instant that the clock shows as so many nanoseconds.
    pub const fn from_nanos(nanos: i64) -> HostInstant {
        HostInstant(nanos)
    }

    /// The instant that the kernel wrote as so many nanoseconds, at the end of the range if it lies beyond.
    pub fn of_kernel(nanos: u64) -> HostInstant {
        HostInstant(i64::try_from(nanos).unwrap_or(i64::MAX))
    }

    /// What the clock shows then, in nanoseconds.
    pub const fn as_nanos(self) -> i64 {
        self.0
    }

    /// From now until then, 0 where it is over.
    pub fn remaining(self) -> Span {
        (self - HostInstant::now()).max(Span::ZERO)
    }

    /// From then until now, 0 where it lies ahead.
    pub fn elapsed(self) -> Span {
        (HostInstant::now() - self).max(Span::ZERO)
    }
}

impl Add<Span> for HostInstant {
    type Output = HostInstant;
    fn add(self, span: Span) -> HostInstant {
        HostInstant(self.0.saturating_add(span.as_nanos()))
    }
}

impl AddAssign<Span> for HostInstant {
    fn add_assign(&mut self, span: Span) {
        *self = *self + span;
    }
}

impl Sub<Span> for HostInstant {
    type Output = HostInstant;
    fn sub(self, span: Span) -> HostInstant {
        HostInstant(self.0.saturating_sub(span.as_nanos()))
    }
}

impl Sub for HostInstant {
    type Output = Span;
    fn sub(self, earlier: HostInstant) -> Span {
        Span::from_nanos(self.0.saturating_sub(earlier.0))
    }
}

/// An instant that threads share, or none. Whoever sees one sees what was written before it.
///
/// In memory 0 is none: the clock starts with the machine, so no process reads 0; an instant of 0 is kept as 1 ns.
/// Memory that was never written therefore holds none.
#[derive(Debug, Default)]
#[repr(transparent)]
pub struct AtomicInstant(AtomicI64);

impl AtomicInstant {
    /// None.
    pub const fn none() -> AtomicInstant {
        AtomicInstant(AtomicI64::new(0))
    }

    /// This instant.
    pub fn at(instant: HostInstant) -> AtomicInstant {
        AtomicInstant(AtomicI64::new(encode(instant)))
    }

    /// The instant, if there is one.
    pub fn get(&self) -> Option<HostInstant> {
        decode(self.0.load(Ordering::Acquire))
    }

    /// Sets it, or none.
    pub fn set(&self, instant: impl Into<Option<HostInstant>>) {
        self.0.store(instant.into().map_or(0, encode), Ordering::Release);
    }

    /// Sets it, and gives what it was.
    pub fn replace(&self, instant: HostInstant) -> Option<HostInstant> {
        decode(self.0.swap(encode(instant), Ordering::AcqRel))
    }

    /// Sets it, unless there is one.
    pub fn set_first(&self, instant: HostInstant) {
        let _ = self.0.compare_exchange(0, encode(instant), Ordering::AcqRel, Ordering::Acquire);
    }

    /// None from now on.
    pub fn clear(&self) {
        self.0.store(0, Ordering::Release);
    }
}

const fn encode(instant: HostInstant) -> i64 {
    if instant.0 == 0 { 1 } else { instant.0 }
}

const fn decode(nanos: i64) -> Option<HostInstant> {
    if nanos == 0 { None } else { Some(HostInstant(nanos)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arithmetic_stops_at_the_ends_and_what_is_over_has_nothing_left() {
        assert_eq!(HostInstant::NEVER + Span::from_nanos(1), HostInstant::NEVER);
        assert_eq!(HostInstant::NEVER - HostInstant::from_nanos(i64::MIN), Span::MAX);
        let then = HostInstant::now();
        assert_eq!(then.remaining(), Span::ZERO);
        assert_eq!((then + Span::from_secs(3600)).elapsed(), Span::ZERO);
        assert!((then + Span::from_secs(3600)).remaining() > Span::from_secs(3000));
    }

    #[test]
    fn memory_that_was_never_written_holds_no_instant_and_no_instant_is_taken_for_none() {
        let shared = AtomicInstant::default();
        assert_eq!(shared.get(), None);
        shared.set(HostInstant::from_nanos(7));
        assert_eq!(shared.get(), Some(HostInstant::from_nanos(7)));
        shared.set(HostInstant::from_nanos(0));
        assert_eq!(shared.get(), Some(HostInstant::from_nanos(1)));
        shared.set_first(HostInstant::from_nanos(8));
        assert_eq!(shared.replace(HostInstant::from_nanos(9)), Some(HostInstant::from_nanos(1)));
        shared.clear();
        assert_eq!(shared.get(), None);
        shared.set_first(HostInstant::from_nanos(8));
        assert_eq!(shared.get(), Some(HostInstant::from_nanos(8)));
    }
}
