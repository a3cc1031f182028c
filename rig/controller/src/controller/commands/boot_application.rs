//! The boot application: how it is created, placed, compared and removed (controller:STATE-12, controller:STATE-13,
//! controller:STATE-15, controller:SYS-01).

use crate::CommandError;
use crate::controller::Controller;
use crate::probes::class;
use crate::{APPLICATION_FILE, Effects, State};
use profile::{BOOT_APPLICATION_SAVE, BootProjectStatus, StopCause};
use signal::{Cause, Time};

impl Controller {
    /// Whether the application in memory will be replaced at the next power cycle (controller:STATE-15).
    pub fn application_differs(&self) -> bool {
        let saved =
            matches!(self.system.boot_project, BootProjectStatus::Valid | BootProjectStatus::Creating);
        self.application.is_some() && !saved
    }

    /// Create boot application: only in STOPPED (controller:STATE-13).
    pub(in crate::controller) fn command_create_boot_application(
        &mut self,
        now: Time,
        fx: &mut Effects,
    ) -> Result<(), CommandError> {
        if self.state != State::Stopped || self.application.is_none() {
            return Err(CommandError::State(self.state));
        }
        self.create_boot_application(now);
        self.remanent.adopt_parent();
        self.save_if_dirty(now);
        self.observe(class::ALL, now, Cause::Controller, fx);
        Ok(())
    }

    /// Begins to save the application in memory. Until it is done the old file is the boot application.
    pub(in crate::controller) fn create_boot_application(&mut self, now: Time) {
        self.power.creating = Some(now.saturating_add(BOOT_APPLICATION_SAVE));
        self.system.boot_project = BootProjectStatus::Creating;
    }

    /// The save of the boot application is complete.
    pub(in crate::controller) fn complete_boot_application(&mut self) {
        if self.power.creating.take().is_some() {
            self.files.store_mut().write(APPLICATION_FILE, &self.bundle);
            self.boot_file_changed();
        }
    }

    /// A boot application comes by SD card or FTP: nothing else changes before the next reboot (controller:DL-03,
    /// controller:MEM-05).
    pub(in crate::controller) fn command_place_boot_application(
        &mut self,
        bundle: &[u8],
        now: Time,
        fx: &mut Effects,
    ) -> Result<(), CommandError> {
        // controller:MEM-03
        if self.state.status().is_none() {
            return Err(CommandError::State(self.state));
        }
        self.power.creating = None;
        self.files.store_mut().write(APPLICATION_FILE, bundle);
        self.boot_file_changed();
        self.observe(class::ALL, now, Cause::Controller, fx);
        Ok(())
    }

    /// Compares the boot application with the one in memory: to be called when its file may have changed.
    pub(in crate::controller) fn boot_file_changed(&mut self) {
        self.system.boot_project = match self.files.store().read(APPLICATION_FILE) {
            None => BootProjectStatus::None,
            Some(file) if self.application.is_some() && file == self.bundle => BootProjectStatus::Valid,
            Some(_) => BootProjectStatus::Different,
        };
    }

    /// Delete application (controller:TR-27): from memory, and its boot application, which would bring it back.
    pub(in crate::controller) fn command_delete_application(
        &mut self,
        now: Time,
        fx: &mut Effects,
    ) -> Result<(), CommandError> {
        if !matches!(self.state, State::Running | State::Breakpoint | State::Stopped) {
            return Err(CommandError::State(self.state));
        }
        self.system.stop_cause = StopCause::Delete;
        self.unload(now);
        self.files.store_mut().remove(APPLICATION_FILE);
        self.boot_file_changed();
        self.enter(State::Empty, now, fx);
        Ok(())
    }
}
