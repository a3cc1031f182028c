//! How far executors have come, for whoever has to know that they go on.

use std::sync::atomic::{AtomicU64, Ordering};

/// Counts the turns of an executor, of one after the other. On the host's clock no turn lasts longer than what it waits
/// for, the slice of its options at most: where the count stands still for longer, the executor hangs.
#[derive(Debug, Default)]
pub struct LoopCounter(AtomicU64);

impl LoopCounter {
    /// None so far.
    pub const fn new() -> LoopCounter {
        LoopCounter(AtomicU64::new(0))
    }

    /// One turn more.
    #[inline]
    pub fn add(&self) {
        self.0.fetch_add(1, Ordering::Relaxed);
    }

    /// How many there were.
    pub fn count(&self) -> u64 {
        self.0.load(Ordering::Relaxed)
    }
}
