//! Reset origin and reset origin device (controller: sections 14.6, 14.7).

use super::CommandError;
use crate::store::{
    APPLICATION_FOLDER, CERTIFICATES_FOLDER, CONFIGURATION_FOLDER, LOG_FOLDER, POST_CONFIGURATION_FILE,
    RETAIN_MAP, RIGHTS_FILE, SYSTEM_LOG_FOLDER, USER_FOLDER, VISUALISATION_FOLDER,
};
use crate::{Controller, Effects, RETAIN_FILES, State};
use profile::{Family, Profile, StopCause};
use signal::Time;

/// What reset origin device resets, each for itself (controller:ROD-01).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DeviceReset {
    /// Users and groups return to their defaults.
    pub user_management: bool,
    /// Application, its files and the remanent variables.
    pub plc_logic: bool,
    /// Certificates of the Web and FTP servers.
    pub certificates: bool,
}

impl Controller {
    /// Reset origin (controller:RO-01): the application and the user's files are erased.
    pub(crate) fn command_reset_origin(&mut self, now: Time, fx: &mut Effects) -> Result<(), CommandError> {
        self.erase_application(now)?;
        let profile = self.config.profile;
        for folder in [APPLICATION_FOLDER, LOG_FOLDER] {
            self.erase(folder, None);
        }
        self.store.remove(POST_CONFIGURATION_FILE);
        if profile != Profile::M241_2014 {
            // controller:RO-02
            self.erase(VISUALISATION_FOLDER, None);
        }
        if profile == Profile::M251_2024 {
            self.erase(USER_FOLDER, Some(SYSTEM_LOG_FOLDER));
            self.boot_file_changed();
            self.boot(now, fx);
        } else {
            self.boot_file_changed();
            if profile == Profile::M241_2014 {
                // Initialization values, and no word of those of the hardware (io:OUT-28).
                self.write_outputs_of(!0, now, fx);
            }
            self.rest_at_defaults(now);
            self.enter(State::Empty, now, fx);
        }
        Ok(())
    }

    /// Reset origin device (controller:ROD-01), which only the M251 has.
    pub(crate) fn command_reset_origin_device(
        &mut self,
        reset: DeviceReset,
        now: Time,
        fx: &mut Effects,
    ) -> Result<(), CommandError> {
        if self.config.reference.family != Family::M251 {
            return Err(CommandError::NoSuchCommand);
        }
        if reset.plc_logic {
            self.erase_application(now)?;
            // Recipes, data logs and the logs of the system stay (controller:ROD-03, controller:ROD-04).
            for folder in [APPLICATION_FOLDER, VISUALISATION_FOLDER] {
                self.erase(folder, None);
            }
            self.store.remove(POST_CONFIGURATION_FILE);
            self.boot_file_changed();
        } else if !matches!(self.state, State::Running | State::Breakpoint | State::Stopped | State::Halt) {
            return Err(CommandError::State(self.state));
        }
        if reset.user_management {
            self.store.remove(RIGHTS_FILE);
        }
        if reset.certificates {
            self.erase(CERTIFICATES_FOLDER, None);
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
        let runs = matches!(self.state, State::Running | State::Breakpoint);
        let cause = if runs { StopCause::Reset } else { StopCause::Unknown };
        self.clear_diagnostics(cause);
        self.unload(now);
        for file in RETAIN_FILES {
            self.store.remove(file);
        }
        self.store.remove(RETAIN_MAP);
        Ok(())
    }

    /// What a firmware update deletes (controller:FW-02).
    pub(crate) fn erase_for_firmware(&mut self) {
        self.erase(APPLICATION_FOLDER, None);
        if self.config.profile == Profile::M251_2024 {
            self.erase(CONFIGURATION_FOLDER, None);
        }
    }

    /// Removes the files of a folder, but for those of another one inside it.
    fn erase(&mut self, folder: &str, except: Option<&str>) {
        let below = |name: &str, folder: &str| {
            name.get(..folder.len()).is_some_and(|begin| begin.eq_ignore_ascii_case(folder))
        };
        let mut names = Vec::new();
        self.store.list(&mut |name, _| {
            if below(name, folder) && !except.is_some_and(|spared| below(name, spared)) {
                names.push(name.to_owned());
            }
        });
        for name in names {
            self.store.remove(&name);
        }
    }
}
