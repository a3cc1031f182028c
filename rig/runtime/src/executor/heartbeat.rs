//! The sign of life that an executor gives to whoever guards its outputs.

use guard::{GuardError, GuardHandle, HeartbeatState};
use signal::Span;

/// Shows that the executor goes on turning: whoever misses it makes the outputs safe.
pub trait Heartbeat: Sync + std::fmt::Debug {
    /// From now on it beats.
    ///
    /// # Errors
    /// Nobody watches.
    fn begin(&self) -> Result<(), GuardError>;

    /// It turns.
    ///
    /// # Errors
    /// Nobody watches any more, or the outputs were made safe already.
    fn beat(&self) -> Result<(), GuardError>;

    /// The longest that it may be silent.
    fn every(&self) -> Span;

    /// The outputs are safe, and it beats no more.
    ///
    /// # Errors
    /// They are not.
    fn end(&self) -> Result<(), GuardError>;

    /// Nobody drives any more, and devices are about to be given back: from then on nothing of them can be looked at.
    ///
    /// # Errors
    /// Outputs are not safe.
    fn close(&self) -> Result<(), GuardError> {
        Ok(())
    }
}

impl Heartbeat for GuardHandle {
    fn begin(&self) -> Result<(), GuardError> {
        self.arm()
    }

    fn beat(&self) -> Result<(), GuardError> {
        match GuardHandle::beat(self) {
            HeartbeatState::Kept => Ok(()),
            HeartbeatState::Latched(reason) => Err(GuardError::Latched(reason)),
            HeartbeatState::Unguarded => Err(GuardError::Gone),
        }
    }

    fn every(&self) -> Span {
        self.beat_every()
    }

    fn end(&self) -> Result<(), GuardError> {
        self.disarm()
    }

    fn close(&self) -> Result<(), GuardError> {
        GuardHandle::close(self)
    }
}
