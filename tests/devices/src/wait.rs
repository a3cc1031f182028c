//! Waiting for conditions.

use std::thread;
use std::time::{Duration, Instant};

/// How long a test waits for what should come at once: the lab is emulated, and may run beside a compiler.
pub const PATIENCE: Duration = Duration::from_secs(20);

/// Waits until the condition is true.
///
/// # Panics
/// When it is not true in time; `what` says what was waited for.
pub fn wait_for(what: &str, patience: Duration, mut condition: impl FnMut() -> bool) {
    let deadline = Instant::now() + patience;
    while !condition() {
        assert!(Instant::now() < deadline, "waited {patience:?} in vain: {what}");
        thread::sleep(Duration::from_millis(1));
    }
}
