//! The lock: what was commissioned stays as it is until somebody unlocks it, even if the rig is started again.

use std::fs::{self, File};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};

use control::{Locked, RequestFault};

use super::decode::fault;
use crate::codes;

/// What the name of the file ends in; it begins as the socket's, so that several rigs may share a folder.
const ENDING: &str = ".lock.json";

/// The lock, and where it is kept.
#[derive(Debug)]
pub(super) struct Lock {
    now: Option<Locked>,
    file: Option<PathBuf>,
}

impl Lock {
    /// The lock as it was left, in a folder for what outlasts the rig of this socket. One that cannot be read counts as
    /// locked: somebody locked it.
    pub(super) fn read(folder: Option<&Path>, socket: &Path) -> Lock {
        let mut name = socket.file_stem().unwrap_or_default().to_os_string();
        name.push(ENDING);
        let file = folder.map(|folder| folder.join(name));
        let now = file.as_deref().and_then(|file| match fs::read(file) {
            Ok(bytes) => Some(serde_json::from_slice(&bytes).unwrap_or_else(|error| unreadable(&error))),
            Err(error) if error.kind() == ErrorKind::NotFound => None,
            Err(error) => Some(unreadable(&error)),
        });
        Lock { now, file }
    }

    /// Who locked the rig, if it is locked.
    pub(super) fn now(&self) -> Option<&Locked> {
        self.now.as_ref()
    }

    /// What is reported to whoever wants to change something.
    ///
    /// # Errors
    /// The rig is locked.
    pub(super) fn check(&self) -> Result<(), RequestFault> {
        let Some(Locked { by, note }) = &self.now else { return Ok(()) };
        let why = if note.is_empty() { String::new() } else { format!(": {note}") };
        let message = format!("the rig was locked by {by}{why}");
        Err(fault(codes::LOCKED, message, "unlock it, as with `rig ctl unlock`"))
    }

    /// Locks the rig, or ends that.
    ///
    /// # Errors
    /// The file of the lock cannot be written or removed; the lock is as it was.
    pub(super) fn set(&mut self, to: Option<Locked>) -> Result<(), RequestFault> {
        if let Some(file) = &self.file {
            let kept = match &to {
                Some(locked) => keep(file, locked),
                None => remove(file),
            };
            kept.map_err(|error| {
                let message = format!("the lock {} cannot be kept: {error}", file.display());
                fault(
                    codes::LOCK_FILE,
                    message,
                    "give the rig a folder that it may write to, as with `--state`",
                )
            })?;
        }
        self.now = to;
        Ok(())
    }
}

fn unreadable(error: &dyn std::error::Error) -> Locked {
    Locked { by: "somebody".into(), note: format!("the file of the lock cannot be read: {error}") }
}

/// Writes the file whole or not at all, also if the supply goes away meanwhile.
fn keep(file: &Path, locked: &Locked) -> io::Result<()> {
    let folder = file.parent().unwrap_or(Path::new("/"));
    fs::create_dir_all(folder)?;
    let half = file.with_extension("new");
    let mut written = File::create(&half)?;
    written.write_all(&serde_json::to_vec(locked)?)?;
    written.sync_all()?;
    fs::rename(&half, file)?;
    File::open(folder)?.sync_all()
}

fn remove(file: &Path) -> io::Result<()> {
    match fs::remove_file(file) {
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(()),
        Err(error) => Err(error),
        Ok(()) => File::open(file.parent().unwrap_or(Path::new("/")))?.sync_all(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lock_outlasts_the_rig_and_a_torn_file_is_a_lock() {
        let folder = tempfile::tempdir().expect("a folder");
        let state = folder.path().join("new");
        let read = || Lock::read(Some(&state), Path::new("/run/scanrig/bench.sock"));
        let by = Locked { by: "rig ctl".into(), note: "handed over".into() };
        assert!(read().check().is_ok());
        read().set(Some(by.clone())).expect("locked");
        assert_eq!(read().now(), Some(&by));
        let said = read().check().expect_err("locked").message;
        assert_eq!(said, "the rig was locked by rig ctl: handed over");
        fs::write(state.join("bench.lock.json"), "{\"by\": \"rig").expect("torn");
        assert!(read().check().is_err());
        assert!(Lock::read(Some(&state), Path::new("other.sock")).check().is_ok());
        read().set(None).expect("unlocked");
        assert!(read().check().is_ok());
        read().set(None).expect("unlocked twice");
    }

    #[test]
    fn a_lock_that_cannot_be_kept_is_none() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("file");
        fs::write(&file, "").expect("a file");
        let mut lock = Lock { now: None, file: Some(file.join("bench.lock.json")) };
        let refused = lock.set(Some(Locked { by: "a".into(), note: "b".into() })).expect_err("no folder");
        assert_eq!(refused.code, codes::LOCK_FILE);
        assert!(lock.check().is_ok());
    }
}
