//! What a real board lives in.

use crate::OutputClaim;
use host::{Bell, Realtime, TimeBase};
use signal::Span;
use std::fmt::Debug;
use std::sync::{Arc, Weak};

/// Whoever makes output lines safe when the rig cannot.
pub trait OutputGuard: Debug + Send + Sync {
    /// Takes these lines into its charge, in place of those of a device that is gone. They must be safe; they may be
    /// driven when this returns. It may wait.
    ///
    /// # Errors
    /// Why it cannot, in words.
    fn replace(&self, device: &str, lines: Vec<OutputClaim>) -> Result<(), String>;
}

/// The time, the bell and the priorities that the threads of a real board share with the executor.
#[derive(Clone, Debug)]
pub struct BoardContext {
    /// The time of the run.
    pub time: TimeBase,
    /// Is rung when the board has something to report.
    pub bell: Arc<Bell>,
    /// How the board's threads run.
    pub realtime: Realtime,
    /// How long before its stamp an edge may have happened, as far as this machine was measured.
    pub resolution: Span,
    /// Who keeps the lines of a device that came back, as long as somebody does.
    pub output_guard: Option<Weak<dyn OutputGuard>>,
}

impl BoardContext {
    /// Time 0 is now; nobody has rung.
    pub fn new(realtime: Realtime) -> BoardContext {
        BoardContext {
            time: TimeBase::start(),
            bell: Arc::new(Bell::new()),
            realtime,
            resolution: Span::ZERO,
            output_guard: None,
        }
    }
}
