//! Files as users, services and the application reach them: who may, and what follows (controller: section 5).

use super::Controller;
use crate::probes::class;
use crate::{APPLICATION_FILE, Effects, FileError, FileProbe, FileUser, Probe, files::Files};
use signal::{Cause, Time};

impl Controller {
    /// Writes a file whole (controller:MEM-05: what runs is not touched by it), where its extension sends it.
    ///
    /// # Errors
    /// [`FileError`]; nothing is written then.
    pub fn put_file(
        &mut self,
        now: Time,
        path: &str,
        bytes: &[u8],
        user: FileUser,
        fx: &mut Effects,
    ) -> Result<(), FileError> {
        Files::admit(path, user, true, self.state)?;
        let place = self.files.put(path, bytes)?;
        self.touched(&place, now, fx);
        Ok(())
    }

    /// Appends an entry to a log of the application; one that does not fit is lost and counted, and the application
    /// goes on (controller:NV-06).
    ///
    /// # Errors
    /// [`FileError`]; [`FileError::Full`] where the entry was lost.
    pub fn log_data(
        &mut self,
        now: Time,
        path: &str,
        entry: &str,
        fx: &mut Effects,
    ) -> Result<(), FileError> {
        Files::admit(path, FileUser::Application, true, self.state)?;
        let appended = self.files.append(path, entry);
        if matches!(appended, Ok(()) | Err(FileError::Full)) {
            self.files_changed(now, fx);
        }
        appended
    }

    /// Removes a file.
    ///
    /// # Errors
    /// [`FileError`].
    pub fn remove_file(
        &mut self,
        now: Time,
        path: &str,
        user: FileUser,
        fx: &mut Effects,
    ) -> Result<(), FileError> {
        Files::admit(path, user, true, self.state)?;
        if let Some(place) = self.files.remove(path)? {
            self.touched(&place, now, fx);
        }
        self.files_changed(now, fx);
        Ok(())
    }

    /// The bytes of a file.
    ///
    /// # Errors
    /// [`FileError`].
    pub fn read_file(&self, path: &str, user: FileUser) -> Result<Vec<u8>, FileError> {
        Files::admit(path, user, false, self.state)?;
        self.files.content(path).ok_or(FileError::NotFound)
    }

    /// Whether a file or a folder is there, in any case of letters.
    pub fn file_exists(&self, path: &str) -> bool {
        self.files.exists(path)
    }

    /// A system error leaves a record for the vendor's support (controller:NV-03).
    pub(super) fn record_crash(&mut self) {
        let record = format!("system error {:04X}\n", self.system.error.code());
        self.files.store_mut().write(self.config.profile.crash_record(), record.as_bytes());
    }

    /// A file was written or removed: the boot application may be another one now (controller:STATE-15).
    fn touched(&mut self, place: &str, now: Time, fx: &mut Effects) {
        if place == APPLICATION_FILE {
            self.power.creating = None;
            self.boot_file_changed();
            self.observe(class::STATE, now, Cause::Controller, fx);
        }
        self.files_changed(now, fx);
    }

    /// Reports what changed of the facts that are observed.
    fn files_changed(&mut self, now: Time, fx: &mut Effects) {
        self.observe(class::FILE, now, Cause::Controller, fx);
    }

    /// Asks for a fact of files or of the log.
    pub fn file_probe(&mut self, probe: FileProbe) -> Probe {
        Probe::File(self.files.add_probe(probe))
    }

    /// A line of the controller's log, in words (controller:NV-09).
    pub fn log_line(&mut self, at: Time, text: &str, fx: &mut Effects) {
        self.files.log(at, text);
        self.files_changed(at, fx);
    }
}
