//! Reset origin and reset origin device (controller: sections 14.6, 14.7).

use crate::controller::Controller;
use crate::store::{
    APPLICATION_FOLDER, CERTIFICATES_FOLDER, CONFIGURATION_FOLDER, POST_CONFIGURATION_FILE, RETAIN_MAP,
    RIGHTS_FILE, SYSTEM_LOG_FOLDER, USER_FOLDER, VISUALISATION_FOLDER,
};
use crate::{CommandError, DeviceReset};
use crate::{Effects, RETAIN_FILES, State};
use profile::{Family, Profile, StopCause};
use signal::Time;

impl Controller {
    /// Reset origin (controller:RO-01): the application and the user's files are erased.
    pub(in crate::controller) fn command_reset_origin(
        &mut self,
        now: Time,
        fx: &mut Effects,
    ) -> Result<(), CommandError> {
        self.check_recoverable()?;
        self.erase_application(now)?;
        let profile = self.config.profile;
        // All files of the user (controller:RO-02). The documents of the M241 name neither user rights nor certificates
        // among them, that of 2014 no web visualisation either; the logs of the system are nobody's files.
        let kept: &[&str] = match profile {
            Profile::M241_2014 => {
                &[SYSTEM_LOG_FOLDER, RIGHTS_FILE, CERTIFICATES_FOLDER, VISUALISATION_FOLDER]
            }
            Profile::M241_2019 => &[SYSTEM_LOG_FOLDER, RIGHTS_FILE, CERTIFICATES_FOLDER],
            Profile::M251_2024 => &[SYSTEM_LOG_FOLDER],
        };
        self.files.erase(USER_FOLDER, kept);
        if profile == Profile::M251_2024 {
            self.boot_file_changed();
            self.save_last_state(State::Empty);
            self.boot(now, fx);
        } else {
            self.boot_file_changed();
            if profile == Profile::M241_2014 {
                // Initialization values, and no word of those of the hardware (io:OUT-28).
                self.exchange_outputs(None, now, fx);
            }
            self.io.rest_at_defaults(now);
            self.enter(State::Empty, now, fx);
        }
        Ok(())
    }

    /// Reset origin device (controller:ROD-01), which only the M251 has.
    pub(in crate::controller) fn command_reset_origin_device(
        &mut self,
        reset: DeviceReset,
        now: Time,
        fx: &mut Effects,
    ) -> Result<(), CommandError> {
        if self.config.reference.family != Family::M251 {
            return Err(CommandError::NoSuchCommand);
        }
        self.check_recoverable()?;
        if reset.plc_logic {
            self.erase_application(now)?;
            // Recipes, data logs and the logs of the system stay (controller:ROD-03, controller:ROD-04).
            for folder in [APPLICATION_FOLDER, VISUALISATION_FOLDER] {
                self.files.erase(folder, &[]);
            }
            self.files.store_mut().remove(POST_CONFIGURATION_FILE);
            self.boot_file_changed();
        } else if !matches!(self.state, State::Running | State::Breakpoint | State::Stopped | State::Halt) {
            return Err(CommandError::State(self.state));
        }
        if reset.user_management {
            self.files.store_mut().remove(RIGHTS_FILE);
        }
        if reset.certificates {
            self.files.erase(CERTIFICATES_FOLDER, &[]);
        }
        if reset.plc_logic {
            self.enter(State::Empty, now, fx);
        }
        Ok(())
    }

    /// The application goes, and with it forcing, indications of errors, memory and the remanent variables.
    fn erase_application(&mut self, now: Time) -> Result<(), CommandError> {
        if !matches!(self.state, State::Running | State::Breakpoint | State::Stopped | State::Halt) {
            return Err(CommandError::State(self.state));
        }
        self.clear_diagnostics(self.stopped_by(StopCause::Reset));
        self.unload(now);
        for file in RETAIN_FILES {
            self.files.store_mut().remove(file);
        }
        self.files.store_mut().remove(RETAIN_MAP);
        Ok(())
    }

    /// What a firmware update deletes (controller:FW-02).
    pub(in crate::controller) fn erase_for_firmware(&mut self) {
        self.files.erase(APPLICATION_FOLDER, &[]);
        if self.config.profile == Profile::M251_2024 {
            self.files.erase(CONFIGURATION_FOLDER, &[]);
        }
    }
}
