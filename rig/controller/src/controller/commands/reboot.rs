//! Reboot without a power cycle, and what invalid firmware and its repair do (controller: sections 14.8, 22).

use crate::CommandError;
use crate::controller::Controller;
use crate::{Effects, State};
use profile::StopCause;
use signal::Time;

impl Controller {
    /// Reboot by script (controller:RB-01): the end is orderly, so what a save had begun becomes whole, and forcing
    /// stays (controller:FRC-07).
    pub(in crate::controller) fn command_reboot(
        &mut self,
        now: Time,
        fx: &mut Effects,
    ) -> Result<(), CommandError> {
        self.check_recoverable()?;
        if matches!(self.state, State::Off | State::Booting) {
            return Err(CommandError::State(self.state));
        }
        self.complete_saves();
        self.clear_errors(self.stopped_by(StopCause::Unknown));
        self.power.script = true;
        self.boot(now, fx);
        Ok(())
    }

    /// Whatever is to be saved is saved at once. Half a cycle is never saved (controller:REM-07).
    fn complete_saves(&mut self) {
        self.complete_boot_application();
        self.remanent.complete(self.files.store_mut());
        let Some(application) = &mut self.application else { return };
        let dirty = application.retained_dirty() | self.memory.take_remanent_dirty() | self.remanent.dirty;
        if dirty && self.scheduler.is_between_cycles() && self.state != State::Halt {
            self.remanent.save_now(&**application, &self.memory, self.files.store_mut());
        }
    }

    /// The firmware in non-volatile memory is damaged: the next boot finds out (controller:TR-02).
    pub fn damage_firmware(&mut self) {
        self.power.firmware = false;
    }

    /// The firmware in non-volatile memory is damaged, or replaced from an SD card, which deletes the application
    /// (controller:FW-02). The next boot finds out (controller:TR-02, controller:TR-25).
    pub(in crate::controller) fn command_firmware(&mut self, valid: bool) -> Result<(), CommandError> {
        if valid && matches!(self.state, State::Off | State::Booting) {
            return Err(CommandError::State(self.state));
        }
        self.power.firmware = valid;
        if valid {
            self.power.creating = None;
            self.erase_for_firmware();
            self.boot_file_changed();
        }
        Ok(())
    }
}
