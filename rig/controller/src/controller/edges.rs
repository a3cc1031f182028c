//! What edges at the embedded inputs do: the Run/Stop input (controller: section 13) and events.

use super::Controller;
use crate::io::InputEvent;
use crate::probes::class;
use crate::{CommandError, Effects, ExternalEventSource, LogEntry};
use profile::StopCause;
use signal::{Cause, Time};

impl Controller {
    /// Lets the inputs act that turn at `now`: events, and the Run/Stop input whatever is updated in STOPPED
    /// (controller:RS-05).
    pub(super) fn fire_inputs(&mut self, now: Time, fx: &mut Effects) {
        if !self.io.fire_inputs(now) {
            return;
        }
        let mut place = 0;
        while let Some(event) = self.io.take_input_event(place) {
            place += 1;
            match event {
                InputEvent::Event(input) => {
                    self.system.events = self.system.events.wrapping_add(1);
                    self.observe(class::STATE, now, Cause::Board, fx);
                    self.external_event(ExternalEventSource::Input(input), now, fx);
                }
                InputEvent::RunStop(high) => self.turn_run_stop(high, now, fx),
                InputEvent::Overdriven(input) => self.log_entry(now, LogEntry::Overdriven { input }, fx),
            }
        }
        self.observe(class::INPUT, now, Cause::Board, fx);
    }

    /// controller:RS-04: a rise is a Run command, a fall a Stop command. An edge that the state does not take, or a
    /// rise while the switch is at Stop, is no error: only the level stays.
    fn turn_run_stop(&mut self, high: bool, now: Time, fx: &mut Effects) {
        let _ = if high { self.command_run(now, fx) } else { self.command_stop(StopCause::Input, now, fx) };
    }

    /// Whether switch and Run/Stop input let a Run command pass (controller:RS-04, controller:RS-06).
    ///
    /// # Errors
    /// The one that does not.
    pub(super) fn may_run(&mut self, now: Time) -> Result<(), CommandError> {
        if !self.power.switch_at_run {
            return Err(CommandError::SwitchAtStop);
        }
        match self.io.run_stop(now) {
            Some(false) => Err(CommandError::RunStopInput),
            _ => Ok(()),
        }
    }
}
