//! The lock: what was commissioned stays as it is until somebody unlocks it, even if the rig is started again.

use std::fs::{self, File};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use control::{Locked, RequestFault};
use document::file::FileFault;
use host::{BackgroundTask, TaskProgress};

use super::decode::fault;
use crate::codes;

/// Most bytes of the file: far above what a name and a note have.
const MOST_BYTES: u64 = 1 << 20;

/// What the name of the file ends in; it begins as the socket's, so that several rigs may share a folder.
const ENDING: &str = ".lock.json";

/// How long the disk may take that the file is on.
const LIMIT: Duration = Duration::from_secs(5);

/// The lock, and where it is kept.
#[derive(Debug)]
pub(super) struct Lock {
    now: Option<Locked>,
    file: Option<PathBuf>,
    /// What it is about to be, once its file is written.
    next: Option<(Option<Locked>, BackgroundTask<io::Result<()>>)>,
}

impl Lock {
    /// The lock as it was left, in a folder for what outlasts the rig of this socket. One that cannot be read counts as
    /// locked: somebody locked it.
    pub(super) fn read(folder: Option<&Path>, socket: &Path) -> Lock {
        let mut name = socket.file_stem().unwrap_or_default().to_os_string();
        name.push(ENDING);
        let file = folder.map(|folder| folder.join(name));
        let now = file.clone().and_then(|file| {
            let late = || Err(io::Error::from(ErrorKind::TimedOut).into());
            let task = BackgroundTask::start("lock", LIMIT, move |_| document::file::read(&file, MOST_BYTES))
                .map_err(FileFault::from);
            match task.and_then(|task| task.wait().unwrap_or_else(late)) {
                Ok(bytes) => Some(serde_json::from_slice(&bytes).unwrap_or_else(|error| unreadable(&error))),
                Err(fault) if fault.is_not_found() => None,
                Err(fault) => Some(unreadable(&fault)),
            }
        });
        Lock { now, file, next: None }
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

    /// Locks the rig, or ends that: at once where the lock is kept nowhere, else once its file is written, which is not waited
    /// for. TRUE where it is done; [`Lock::poll`] reports it otherwise.
    ///
    /// # Errors
    /// The file is being written for somebody else, or the machine has no room for a thread.
    pub(super) fn set(&mut self, to: Option<Locked>) -> Result<bool, RequestFault> {
        let Some(file) = self.file.clone() else {
            self.now = to;
            return Ok(true);
        };
        if self.next.is_some() {
            let message = format!("the lock {} is being written", file.display());
            return Err(fault(codes::LOCK_FILE, message, "ask again in some seconds"));
        }
        let locked = to.clone();
        let write = move |_: &_| match &locked {
            Some(locked) => keep(&file, locked),
            None => remove(&file),
        };
        match BackgroundTask::start("lock", LIMIT, write) {
            Ok(task) => self.next = Some((to, task)),
            Err(error) => return Err(self.not_kept(&error)),
        }
        Ok(false)
    }

    /// Whether the file of the lock is being written.
    pub(super) fn is_busy(&self) -> bool {
        self.next.is_some()
    }

    /// What came of the last [`Lock::set`], once that is known: the lock is as it was where its file was not written.
    pub(super) fn poll(&mut self) -> Option<Result<(), RequestFault>> {
        let (to, task) = self.next.take()?;
        let written = match task.progress() {
            TaskProgress::Running => {
                self.next = Some((to, task));
                return None;
            }
            TaskProgress::Done(written) => written,
            TaskProgress::GivenUp => Err(ErrorKind::TimedOut.into()),
        };
        Some(match written {
            Ok(()) => {
                self.now = to;
                Ok(())
            }
            Err(error) => Err(self.not_kept(&error)),
        })
    }

    fn not_kept(&self, error: &io::Error) -> RequestFault {
        let file = self.file.as_deref().unwrap_or(Path::new(""));
        let message = format!("the lock {} cannot be kept: {error}", file.display());
        fault(codes::LOCK_FILE, message, "give the rig a folder that it may write to, as with `--state`")
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

    /// Sets a lock and waits until it is kept.
    fn set(lock: &mut Lock, to: Option<Locked>) -> Result<(), RequestFault> {
        if lock.set(to)? {
            return Ok(());
        }
        loop {
            if let Some(result) = lock.poll() {
                return result;
            }
            std::thread::yield_now();
        }
    }

    #[test]
    fn a_lock_outlasts_the_rig_and_a_torn_file_is_a_lock() {
        let folder = tempfile::tempdir().expect("a folder");
        let state = folder.path().join("new");
        let read = || Lock::read(Some(&state), Path::new("/run/scanrig/bench.sock"));
        let by = Locked { by: "rig ctl".into(), note: "handed over".into() };
        assert!(read().check().is_ok());
        set(&mut read(), Some(by.clone())).expect("locked");
        assert_eq!(read().now(), Some(&by));
        let said = read().check().expect_err("locked").message;
        assert_eq!(said, "the rig was locked by rig ctl: handed over");
        fs::write(state.join("bench.lock.json"), "{\"by\": \"rig").expect("torn");
        assert!(read().check().is_err());
        assert!(Lock::read(Some(&state), Path::new("other.sock")).check().is_ok());
        set(&mut read(), None).expect("unlocked");
        assert!(read().check().is_ok());
        set(&mut read(), None).expect("unlocked twice");
    }

    #[test]
    fn a_lock_that_cannot_be_kept_is_none() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("file");
        fs::write(&file, "").expect("a file");
        let mut lock = Lock { now: None, file: Some(file.join("bench.lock.json")), next: None };
        let by = Locked { by: "a".into(), note: "b".into() };
        let refused = set(&mut lock, Some(by)).expect_err("no folder");
        assert_eq!(refused.code, codes::LOCK_FILE);
        assert!(lock.check().is_ok());
    }
}
