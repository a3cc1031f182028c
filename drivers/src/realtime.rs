//! How punctual a run on real lines has to be.

use host::{Processors, Realtime};
use signal::Span;

/// What a board file says about it in `[realtime]`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RealtimeSettings {
    /// SCHED_FIFO priority of the scan loop, from 2 to 97; `None`: none.
    pub priority: Option<u8>,
    /// The processors that the threads of the run stay on.
    pub processors: Processors,
    /// The longest that the application may run ahead of the clock.
    pub horizon: Span,
    /// The longest that the rig may be late before its verdict is `error`; `None` leaves it to the command.
    pub late: Option<Span>,
}

impl Default for RealtimeSettings {
    /// Priority 80, any processor, 100 us.
    fn default() -> Self {
        RealtimeSettings {
            priority: Some(80),
            processors: Processors::default(),
            horizon: Span::from_micros(100),
            late: None,
        }
    }
}

impl RealtimeSettings {
    /// How the threads run.
    pub fn threads(&self) -> Realtime {
        Realtime { priority: self.priority, processors: self.processors }
    }
}
