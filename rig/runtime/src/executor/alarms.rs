//! The alarms of a case while it runs.

use super::Executor;
use crate::schedule::EndReason;
use signal::{SignalId, Time, Value, When};

impl Executor<'_> {
    /// The case begins: from now on alarms count.
    pub(super) fn arm(&mut self) {
        let now = self.now;
        for alarm in self.parts.alarms.iter_mut() {
            alarm.watch.start(now);
        }
    }

    /// When the next alarm will be raised if nothing changes.
    #[inline]
    pub(super) fn next_alarm(&self) -> Option<Time> {
        self.parts.alarms.iter().filter_map(|alarm| alarm.watch.due()).min()
    }

    /// A signal has a value that was recorded.
    #[inline]
    pub(super) fn alarmed(&mut self, signal: SignalId, at: When, value: Value) {
        for place in 0..self.parts.alarms.len() {
            let alarm = &mut self.parts.alarms[place];
            // One without a delay is raised by the change itself.
            let raised = alarm.signal == signal && (alarm.watch.see(at, value) | alarm.watch.pass(at.latest));
            if raised {
                self.raise(place);
            }
        }
    }

    /// Raises the alarms whose conditions have lasted long enough by now.
    pub(super) fn raise_due(&mut self) {
        for place in 0..self.parts.alarms.len() {
            if self.parts.alarms[place].watch.pass(self.now) {
                self.raise(place);
            }
        }
    }

    /// An alarm is raised: it is marked in the trace, and the case ends by it if it says so. What the alarm comes to
    /// is judged from the trace.
    fn raise(&mut self, place: usize) {
        let mark = self.parts.alarms[place].mark;
        self.parts.recorder.mark(mark, self.seen(self.now));
        if self.parts.alarms[place].ends {
            self.parts.schedule.end_early(EndReason::Alarm, self.now);
        }
    }
}
