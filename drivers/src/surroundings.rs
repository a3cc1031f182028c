//! What a real board lives in.

use host::{Bell, Realtime, TimeBase};
use signal::Span;
use std::sync::Arc;

/// The time, the bell and the priorities that the threads of a real board share with the executor.
#[derive(Clone, Debug)]
pub struct Surroundings {
    /// The time of the run.
    pub time: TimeBase,
    /// Is rung when the board has something to report.
    pub bell: Arc<Bell>,
    /// How the board's threads run.
    pub realtime: Realtime,
    /// How long before its stamp an edge may have happened, as far as this machine was measured.
    pub resolution: Span,
}

impl Surroundings {
    /// Time 0 is now; nobody has rung.
    pub fn new(realtime: Realtime) -> Surroundings {
        Surroundings {
            time: TimeBase::start(),
            bell: Arc::new(Bell::new()),
            realtime,
            resolution: Span::ZERO,
        }
    }
}
