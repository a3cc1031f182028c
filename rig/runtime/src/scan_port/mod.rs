//! The scan's end of a rig that is kept running: requests of clients come in, events and snapshots go out, by queues of a
//! fixed size.

mod port;
mod queues;
mod snapshot;

pub use port::{ExecutorRole, PortLimits, ScanPort};
pub use queues::{
    HandleEnd, ObservedSource, OrderOutcome, ScanCommand, ScanCommandError, ScanEnd, ScanEvent, ScanRequest,
    queues,
};
pub use snapshot::{BusCounts, LineCounts, Snapshot, counts};

use std::sync::{Mutex, MutexGuard, PoisonError};

/// What a lock holds, whoever panicked with it.
pub(crate) fn lock<T>(lock: &Mutex<T>) -> MutexGuard<'_, T> {
    lock.lock().unwrap_or_else(PoisonError::into_inner)
}
