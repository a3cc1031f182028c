//! What goes wrong inside the controller, and the HALT that only a power cycle ends (controller:WD-14).

use super::Controller;
use crate::probes::class;
use crate::{CommandError, Effects, InternalError, LogEntry, State};
use profile::{ApplicationError, StopCause};
use signal::{Cause, Time};

impl Controller {
    /// An error inside the controller at `now`. Where no application is in memory, or it stands in STOPPED, one that
    /// halts the application has nothing to halt.
    pub(super) fn fail(&mut self, now: Time, error: InternalError, fx: &mut Effects) {
        let (cause, code) = match error {
            InternalError::HardwareWatchdog => {
                (StopCause::HardwareWatchdog, ApplicationError::SystemWatchdog)
            }
            InternalError::Firmware | InternalError::FirmwareException => {
                (StopCause::Exception, ApplicationError::Undefined)
            }
        };
        match (error, self.state) {
            (
                InternalError::FirmwareException,
                State::Stopped | State::Running | State::Breakpoint | State::Halt,
            ) => {
                self.log_entry(now, LogEntry::InternalError(error), fx);
                self.system_error(now, cause, code, fx);
            }
            (InternalError::FirmwareException, _) => {}
            (_, State::Running | State::Breakpoint) => {
                self.log_entry(now, LogEntry::InternalError(error), fx);
                self.halt(now, cause, code, fx);
                self.power.needs_power_cycle = true;
            }
            (_, State::Halt) => {
                self.log_entry(now, LogEntry::InternalError(error), fx);
                (self.system.stop_cause, self.system.error) = (cause, code);
                self.power.needs_power_cycle = true;
                self.observe(class::STATE, now, Cause::Controller, fx);
            }
            _ => {}
        }
    }

    /// Refuses what would leave a HALT that only a power cycle ends (controller:WD-14, controller:TR-13).
    pub(super) const fn check_recoverable(&self) -> Result<(), CommandError> {
        if self.power.needs_power_cycle { Err(CommandError::NeedsPowerCycle) } else { Ok(()) }
    }
}
