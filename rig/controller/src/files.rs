//! The files of the non-volatile store as users, services and the application reach them (controller: section 5).

use crate::watch::class;
use crate::{APPLICATION_FILE, Controller, Effects, NonVolatile, State};
use profile::{TreeEntry, USER_DISK_BYTES};
use signal::{Cause, Time, Value};
use std::fmt;

/// Longest path of a file, in bytes (rig definition).
pub const LONGEST_PATH: usize = 255;

/// Files that are there as long as the boot application is (controller:NV-03).
const COMPANIONS: [&str; 2] = ["/usr/App/Application.crc", "/usr/App/Application.map"];

/// Who asks for a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum FileUser {
    /// A user by a tool, the web site or FTP (controller:MEM-03).
    #[default]
    Service,
    /// The application: /usr and /sd0 only (controller:NV-10).
    Application,
}

/// Why a file was not reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileError {
    /// No service answers in this state (controller:MEM-03).
    State(State),
    /// The path is none: it begins with `/` and a disk, and has no empty or dotted parts.
    Path,
    /// There is no such file.
    NotFound,
    /// The path is closed to whoever asks (controller:NV-10), or the controller keeps the file itself.
    Denied,
    /// There is no card in the slot.
    NoCard,
    /// The file does not fit on the disk; a log loses the entry (controller:NV-06).
    Full,
}

impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            FileError::State(state) => write!(f, "no service answers in state {state}"),
            FileError::Path => f.write_str("no path of a file: write it as in /usr/Rcp/mix.rcp"),
            FileError::NotFound => f.write_str("there is no such file"),
            FileError::Denied => f.write_str("the path is closed"),
            FileError::NoCard => f.write_str("there is no card"),
            FileError::Full => f.write_str("the disk is full"),
        }
    }
}

impl std::error::Error for FileError {}

/// What can be asked of files and of the log.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FileProbe {
    /// Whether a file or folder is there.
    Exists(String),
    /// Whether a file holds a text.
    Holds(String, String),
    /// Bytes of a file; unknown where there is none.
    Size(String),
    /// Entries of a log that were lost because the disk was full.
    Lost(String),
    /// Entries of the controller's log that hold a text.
    Log(String),
}

/// What the controller keeps of its files besides the store.
#[derive(Debug, Default)]
pub(crate) struct Files {
    /// What is asked, by the number in [`crate::Probe::File`].
    pub facts: Vec<FileProbe>,
    /// Entries that logs lost.
    lost: Vec<(String, u64)>,
}

/// A path taken apart.
struct Path<'a> {
    folder: &'a str,
    name: &'a str,
}

fn split(path: &str) -> Result<Path<'_>, FileError> {
    let parts = path.strip_prefix('/').ok_or(FileError::Path)?;
    let sound = |part: &str| !part.is_empty() && part != "." && part != "..";
    if path.len() > LONGEST_PATH || !parts.split('/').all(sound) || parts.split('/').count() < 2 {
        return Err(FileError::Path);
    }
    let (folder, name) = path.rsplit_once('/').ok_or(FileError::Path)?;
    Ok(Path { folder, name })
}

/// The disk of a path in lower case.
fn disk(path: &str) -> Option<&'static str> {
    let first = path.split('/').nth(1)?;
    ["sys", "usr", "data", "sd0"].into_iter().find(|disk| disk.eq_ignore_ascii_case(first))
}

/// The spelling under which the store has a file (controller:NV-04).
fn stored(store: &dyn NonVolatile, path: &str) -> Option<String> {
    let mut found = None;
    store.list(&mut |name, _| {
        if found.is_none() && name.eq_ignore_ascii_case(path) {
            found = Some(name.to_owned());
        }
    });
    found
}

impl Controller {
    fn tree(&self) -> impl Iterator<Item = &'static TreeEntry> {
        self.config.profile.file_tree(self.config.reference)
    }

    /// The spelling of a path that the store has or would give a new file (controller:NV-04).
    fn spelt(&self, path: &str) -> Result<String, FileError> {
        if let Some(known) = stored(&*self.store, path) {
            return Ok(known);
        }
        if let Some(known) = self.config.profile.spelling(path) {
            return Ok(known.to_owned());
        }
        let Path { folder, name } = split(path)?;
        let known = self.tree().find(|entry| entry.folder && entry.path.eq_ignore_ascii_case(folder));
        Ok(format!("{}/{name}", known.map_or(folder, |entry| entry.path)))
    }

    /// Where a file that is created under this path comes to lie (controller:NV-05).
    fn redirected(&self, path: &str) -> Result<String, FileError> {
        let Path { name, .. } = split(path)?;
        let extension = name.rsplit_once('.').map_or("", |(_, extension)| extension);
        match self.config.profile.redirection(extension).filter(|_| disk(path) == Some("usr")) {
            Some(folder) => self.spelt(&format!("{folder}/{name}")),
            None => self.spelt(path),
        }
    }

    /// Whether this user may open the path, `writing` or not.
    fn admit(&self, path: &str, user: FileUser, writing: bool) -> Result<(), FileError> {
        if self.state.status().is_none() {
            return Err(FileError::State(self.state));
        }
        split(path)?;
        match (disk(path), user) {
            (Some("usr"), _) => Ok(()),
            (Some("sd0"), _) => Err(FileError::NoCard),
            (Some(_), FileUser::Service) if !writing => Ok(()),
            (Some(_), _) => Err(FileError::Denied),
            (None, _) => Err(FileError::Path),
        }
    }

    /// Whether the path is the controller's own log.
    fn is_log(&self, path: &str) -> bool {
        path.eq_ignore_ascii_case(self.config.profile.system_log())
    }

    /// Free bytes of /usr.
    pub(crate) fn free_bytes(&self) -> u64 {
        let mut used = self.log.len() as u64;
        self.store.list(&mut |name, bytes| {
            used += if disk(name) == Some("usr") { bytes } else { 0 };
        });
        USER_DISK_BYTES.saturating_sub(used)
    }

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
        self.admit(path, user, true)?;
        if self.is_log(path) {
            return Err(FileError::Denied);
        }
        let place = self.redirected(path)?;
        let old = self.store.read(&place).map_or(0, |old| old.len() as u64);
        if bytes.len() as u64 > self.free_bytes() + old {
            return Err(FileError::Full);
        }
        self.store.write(&place, bytes);
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
        self.admit(path, FileUser::Application, true)?;
        let place = self.redirected(path)?;
        if entry.len() as u64 + 1 > self.free_bytes() {
            match self.files.lost.iter_mut().find(|(name, _)| name.eq_ignore_ascii_case(&place)) {
                Some((_, count)) => *count += 1,
                None => self.files.lost.push((place, 1)),
            }
            self.files_changed(now, fx);
            return Err(FileError::Full);
        }
        let mut bytes = self.store.read(&place).unwrap_or_default();
        bytes.extend_from_slice(entry.as_bytes());
        bytes.push(b'\n');
        self.store.write(&place, &bytes);
        self.files_changed(now, fx);
        Ok(())
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
        self.admit(path, user, true)?;
        if self.is_log(path) {
            self.log.clear();
        } else {
            let place = stored(&*self.store, path).ok_or(FileError::NotFound)?;
            self.store.remove(&place);
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
        self.admit(path, user, false)?;
        self.content(path).ok_or(FileError::NotFound)
    }

    fn content(&self, path: &str) -> Option<Vec<u8>> {
        if self.is_log(path) {
            return (self.log.len() > 0).then(|| self.log.bytes());
        }
        stored(&*self.store, path).and_then(|place| self.store.read(&place))
    }

    /// Whether a file or a folder is there, in any case of letters.
    pub fn file_exists(&self, path: &str) -> bool {
        let companion = COMPANIONS.iter().any(|file| file.eq_ignore_ascii_case(path));
        self.tree().any(|entry| entry.path.eq_ignore_ascii_case(path))
            || (companion && self.store.read(APPLICATION_FILE).is_some())
            || (self.is_log(path) && self.log.len() > 0)
            || stored(&*self.store, path).is_some()
    }

    /// A system error leaves a record for the vendor's support (controller:NV-03).
    pub(crate) fn record_crash(&mut self) {
        let record = format!("system error {:04X}\n", self.system.error.code());
        self.store.write(self.config.profile.crash_record(), record.as_bytes());
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
    pub(crate) fn files_changed(&mut self, now: Time, fx: &mut Effects) {
        self.observe(class::FILE, now, Cause::Controller, fx);
    }

    /// What a fact is now.
    pub(crate) fn read_file_probe(&self, place: u16) -> Value {
        match self.files.facts.get(usize::from(place)) {
            None => Value::Unknown,
            Some(FileProbe::Exists(path)) => Value::Bool(self.file_exists(path)),
            Some(FileProbe::Holds(path, text)) => {
                let holds =
                    |bytes: &[u8]| bytes.windows(text.len().max(1)).any(|part| part == text.as_bytes());
                Value::Bool(self.content(path).is_some_and(|bytes| holds(&bytes)))
            }
            Some(FileProbe::Size(path)) => {
                self.content(path).map_or(Value::Unknown, |bytes| Value::Int(bytes.len() as i64))
            }
            Some(FileProbe::Lost(path)) => {
                let found = self.files.lost.iter().find(|(name, _)| name.eq_ignore_ascii_case(path));
                Value::Int(found.map_or(0, |(_, count)| *count as i64))
            }
            Some(FileProbe::Log(text)) => Value::Int(self.log.count(text)),
        }
    }

    /// Asks for a fact; the number of it in [`crate::Probe::File`].
    pub fn file_probe(&mut self, fact: FileProbe) -> crate::Probe {
        let known = self.files.facts.iter().position(|known| *known == fact);
        let place = known.unwrap_or_else(|| {
            self.files.facts.push(fact);
            self.files.facts.len() - 1
        });
        crate::Probe::File(u16::try_from(place).unwrap_or(u16::MAX))
    }

    /// A line of the controller's log, in words (controller:NV-09).
    pub fn log_line(&mut self, at: Time, text: &str, fx: &mut Effects) {
        self.log.append(at, text);
        self.files_changed(at, fx);
    }
}
