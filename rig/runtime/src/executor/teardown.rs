//! What comes after a case, however it ended.

use super::Executor;
use crate::executor::rig_fault::RigFault;

/// Calls of the board that fail at one instant of a teardown before it is given up.
const MOST_FAILURES: usize = 1_000;

impl Executor<'_> {
    /// The teardown: every step of it that can come does, whatever ended the case. A fault of the rig does not keep the steps after
    /// it from coming, as far as the board answers.
    pub(super) fn tear_down(&mut self) {
        // Nothing of the case comes any more, an interrupt apart: that has been obeyed.
        (self.over, self.same) = (false, 0);
        self.end_waves();
        if !self.parts.schedule.begin_teardown(self.now) {
            return;
        }
        if let Some(mark) = self.parts.wiring.teardown {
            self.parts.recorder.mark(mark, self.seen(self.now));
        }
        let limit = self.now.saturating_add(self.limits.teardown);
        let (mut failures, mut since) = (0, self.now);
        while !self.parts.schedule.is_torn_down() {
            let fault = match self.turn(limit) {
                Ok(true) => continue,
                Ok(false) if self.parts.schedule.is_torn_down() => break,
                Ok(false) => RigFault::Timeout { limit: self.limits.teardown },
                Err(fault) => fault,
            };
            let last = matches!(
                fault,
                RigFault::Timeout { .. } | RigFault::Stuck { .. } | RigFault::Simultaneous { .. }
            );
            self.report.fault.get_or_insert(fault);
            failures = if self.now > since { 1 } else { failures + 1 };
            since = self.now;
            // A board that answers no call would keep the time from moving for ever.
            if last || failures > MOST_FAILURES {
                break;
            }
        }
        self.see_all_windows();
        if let Some(mark) = self.parts.wiring.closed {
            self.parts.recorder.mark(mark, self.seen(self.now));
        }
    }
}
