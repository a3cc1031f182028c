//! The one wait of the executor: absolute, and ended early by whoever rings.

use crate::HostInstant;
use rustix::io::Errno;
use rustix::thread::futex;
use rustix::time::Timespec;
use std::num::NonZeroU32;
use std::sync::atomic::{AtomicU32, Ordering};

/// Why a wait ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Woken {
    /// Somebody rang.
    Rung,
    /// It was due.
    Due,
}

/// What threads of a board ring when they have something to report. A ring while nobody waits ends the next wait
/// at once; several rings end one wait. Ringing never waits, and calls the kernel only when somebody may be waiting.
#[derive(Debug, Default)]
pub struct Bell {
    rung: AtomicU32,
}

impl Bell {
    /// A bell that nobody rang.
    pub fn new() -> Bell {
        Bell::default()
    }

    /// Ends the wait.
    pub fn ring(&self) {
        if self.rung.swap(1, Ordering::Release) == 0 {
            // Waking nobody is no failure, and a word of our own cannot be refused.
            let _ = futex::wake(&self.rung, futex::Flags::PRIVATE, 1);
        }
    }

    /// Whether somebody rang since a wait or this last reported so. Never waits.
    pub fn has_rung(&self) -> bool {
        self.rung.load(Ordering::Relaxed) != 0 && self.rung.swap(0, Ordering::Acquire) != 0
    }

    /// Waits until somebody rings, at most until then.
    pub fn wait_until(&self, due: HostInstant) -> Woken {
        let stamp = due.as_nanos().max(0);
        let due = Timespec { tv_sec: stamp / 1_000_000_000, tv_nsec: stamp % 1_000_000_000 };
        loop {
            if self.rung.swap(0, Ordering::Acquire) != 0 {
                return Woken::Rung;
            }
            let waited =
                futex::wait_bitset(&self.rung, futex::Flags::PRIVATE, 0, Some(&due), NonZeroU32::MAX);
            if waited == Err(Errno::TIMEDOUT) {
                return Woken::Due;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::TimeBase;
    use signal::{Span, Time};
    use std::sync::Arc;

    #[test]
    fn a_ring_before_the_wait_is_not_lost_and_ends_one_wait_only() {
        let (bell, base) = (Bell::new(), TimeBase::start());
        let far = base.stamp(Time::ZERO + Span::from_secs(3600));
        bell.ring();
        bell.ring();
        assert_eq!(bell.wait_until(far), Woken::Rung);
        assert_eq!(bell.wait_until(base.stamp(Time::ZERO)), Woken::Due);
        bell.ring();
        assert!(bell.has_rung() && !bell.has_rung());
    }

    #[test]
    fn a_wait_is_never_over_before_it_is_due_and_a_ring_from_elsewhere_ends_it() {
        let (bell, base) = (Arc::new(Bell::new()), TimeBase::start());
        let due = base.now() + Span::from_millis(2);
        assert_eq!(bell.wait_until(base.stamp(due)), Woken::Due);
        assert!(base.now() >= due);
        let other = bell.clone();
        let ringing = std::thread::spawn(move || other.ring());
        assert_eq!(bell.wait_until(base.stamp(due + Span::from_secs(3600))), Woken::Rung);
        ringing.join().unwrap();
    }
}
