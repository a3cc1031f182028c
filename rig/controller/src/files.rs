//! The files of the non-volatile store as users, services and the application reach them (controller: section 5).

use crate::state::State;
use crate::store::{APPLICATION_FILE, NonVolatile};
use crate::system_log::SystemLog;
use profile::{Profile, Reference, TreeEntry, USER_DISK_BYTES};
use signal::{Time, Value};
use std::cell::Cell;
use thiserror::Error;

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
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum FileError {
    /// No service answers in this state (controller:MEM-03).
    #[error("no service answers in state {0}")]
    State(State),
    /// The path is none: it begins with `/` and a disk, and has no empty or dotted parts.
    #[error("no path of a file: write it as in /usr/Rcp/mix.rcp")]
    Path,
    /// There is no such file.
    #[error("there is no such file")]
    NotFound,
    /// The path is closed to whoever asks (controller:NV-10), or the controller keeps the file itself.
    #[error("the path is closed")]
    Denied,
    /// There is no card in the slot.
    #[error("there is no card")]
    NoCard,
    /// The file does not fit on the disk; a log loses the entry (controller:NV-06).
    #[error("the disk is full")]
    Full,
}

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

/// The files: the store, the controller's own log, and what is asked of them.
pub(crate) struct Files {
    profile: Profile,
    reference: &'static Reference,
    store: Box<dyn NonVolatile>,
    log: SystemLog,
    /// What is asked, by the number in [`crate::Probe::File`].
    probes: Vec<FileProbe>,
    /// Entries that logs lost.
    lost: Vec<(String, u64)>,
    /// What the files of the store take of /usr, while it is known: to look for it means to list them all.
    used: Cell<Option<u64>>,
}

impl Files {
    /// The files of a store.
    pub(crate) fn new(profile: Profile, reference: &'static Reference, store: Box<dyn NonVolatile>) -> Files {
        Files {
            profile,
            reference,
            store,
            log: SystemLog::default(),
            probes: Vec::new(),
            lost: Vec::new(),
            used: Cell::new(None),
        }
    }

    /// The store.
    pub(crate) fn store(&self) -> &dyn NonVolatile {
        &*self.store
    }

    /// The store, to be written.
    pub(crate) fn store_mut(&mut self) -> &mut dyn NonVolatile {
        self.used.set(None);
        &mut *self.store
    }

    fn tree(&self) -> impl Iterator<Item = &'static TreeEntry> {
        self.profile.file_tree(self.reference)
    }

    /// The spelling of a path that the store has or would give a new file (controller:NV-04).
    fn spelt(&self, path: &str) -> Result<String, FileError> {
        if let Some(known) = stored(&*self.store, path) {
            return Ok(known);
        }
        if let Some(known) = self.profile.spelling(path) {
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
        match self.profile.redirection(extension).filter(|_| disk(path) == Some("usr")) {
            Some(folder) => self.spelt(&format!("{folder}/{name}")),
            None => self.spelt(path),
        }
    }

    /// Whether this user may open the path in this state, `writing` or not.
    ///
    /// # Errors
    /// [`FileError`].
    pub(crate) fn admit(path: &str, user: FileUser, writing: bool, state: State) -> Result<(), FileError> {
        if state.status().is_none() {
            return Err(FileError::State(state));
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
        path.eq_ignore_ascii_case(self.profile.system_log())
    }

    /// Free bytes of /usr.
    pub(crate) fn free_bytes(&self) -> u64 {
        let used = self.used.get().unwrap_or_else(|| {
            let mut used = 0;
            self.store.list(&mut |name, bytes| {
                used += if disk(name) == Some("usr") { bytes } else { 0 };
            });
            self.used.set(Some(used));
            used
        });
        USER_DISK_BYTES.saturating_sub(used + self.log.len() as u64)
    }

    /// Writes a file whole where its extension sends it: where that is.
    ///
    /// # Errors
    /// [`FileError`]; nothing is written then.
    pub(crate) fn put(&mut self, path: &str, bytes: &[u8]) -> Result<String, FileError> {
        if self.is_log(path) {
            return Err(FileError::Denied);
        }
        let place = self.redirected(path)?;
        let old = self.store.read(&place).map_or(0, |old| old.len() as u64);
        if bytes.len() as u64 > self.free_bytes() + old {
            return Err(FileError::Full);
        }
        self.store_mut().write(&place, bytes);
        Ok(place)
    }

    /// Appends an entry to a log of the application; one that does not fit is lost and counted (controller:NV-06).
    ///
    /// # Errors
    /// [`FileError`]; [`FileError::Full`] where the entry was lost.
    pub(crate) fn append(&mut self, path: &str, entry: &str) -> Result<(), FileError> {
        let place = self.redirected(path)?;
        if entry.len() as u64 + 1 > self.free_bytes() {
            match self.lost.iter_mut().find(|(name, _)| name.eq_ignore_ascii_case(&place)) {
                Some((_, count)) => *count += 1,
                None => self.lost.push((place, 1)),
            }
            return Err(FileError::Full);
        }
        let mut bytes = self.store.read(&place).unwrap_or_default();
        bytes.extend_from_slice(entry.as_bytes());
        bytes.push(b'\n');
        self.store_mut().write(&place, &bytes);
        Ok(())
    }

    /// Removes a file, or empties the controller's log: which file of the store that was.
    ///
    /// # Errors
    /// [`FileError`].
    pub(crate) fn remove(&mut self, path: &str) -> Result<Option<String>, FileError> {
        if self.is_log(path) {
            self.log.clear();
            return Ok(None);
        }
        let place = stored(&*self.store, path).ok_or(FileError::NotFound)?;
        self.store_mut().remove(&place);
        Ok(Some(place))
    }

    /// The bytes of a file.
    pub(crate) fn content(&self, path: &str) -> Option<Vec<u8>> {
        if self.is_log(path) {
            return (self.log.len() > 0).then(|| self.log.bytes());
        }
        stored(&*self.store, path).and_then(|place| self.store.read(&place))
    }

    /// Whether a file or a folder is there, in any case of letters.
    pub(crate) fn exists(&self, path: &str) -> bool {
        let companion = COMPANIONS.iter().any(|file| file.eq_ignore_ascii_case(path));
        self.tree().any(|entry| entry.path.eq_ignore_ascii_case(path))
            || (companion && self.store.read(APPLICATION_FILE).is_some())
            || (self.is_log(path) && self.log.len() > 0)
            || stored(&*self.store, path).is_some()
    }

    /// Removes the files of a folder, but for those that `kept` names: files, and folders with all that is in them.
    pub(crate) fn erase(&mut self, folder: &str, kept: &[&str]) {
        let below = |name: &str, folder: &str| {
            name.get(..folder.len()).is_some_and(|begin| begin.eq_ignore_ascii_case(folder))
        };
        let mut names = Vec::new();
        self.store.list(&mut |name, _| {
            if below(name, folder) && !kept.iter().any(|kept| below(name, kept)) {
                names.push(name.to_owned());
            }
        });
        for name in names {
            self.store_mut().remove(&name);
        }
    }

    /// Appends a line to the controller's log.
    pub(crate) fn log(&mut self, at: Time, text: &str) {
        self.log.append(at, text);
    }

    /// Asks for a fact of files or of the log; its number.
    pub(crate) fn add_probe(&mut self, probe: FileProbe) -> u16 {
        let known = self.probes.iter().position(|known| *known == probe);
        let place = known.unwrap_or_else(|| {
            self.probes.push(probe);
            self.probes.len() - 1
        });
        u16::try_from(place).unwrap_or(u16::MAX)
    }

    /// What is asked by this number, now.
    pub(crate) fn read_probe(&self, place: u16) -> Value {
        match self.probes.get(usize::from(place)) {
            None => Value::Unknown,
            Some(FileProbe::Exists(path)) => Value::Bool(self.exists(path)),
            Some(FileProbe::Holds(path, text)) => {
                let holds =
                    |bytes: &[u8]| bytes.windows(text.len().max(1)).any(|part| part == text.as_bytes());
                Value::Bool(self.content(path).is_some_and(|bytes| holds(&bytes)))
            }
            Some(FileProbe::Size(path)) => {
                self.content(path).map_or(Value::Unknown, |bytes| Value::Int(bytes.len() as i64))
            }
            Some(FileProbe::Lost(path)) => {
                let found = self.lost.iter().find(|(name, _)| name.eq_ignore_ascii_case(path));
                Value::Int(found.map_or(0, |(_, count)| *count as i64))
            }
            Some(FileProbe::Log(text)) => Value::Int(self.log.count(text)),
        }
    }
}
