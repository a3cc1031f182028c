//! The socket's file: who may open it, whose it is, and what of a dead rig.

use std::fs::{self, DirBuilder, File, Permissions};
use std::io::{self, ErrorKind};
use std::os::unix::fs::{DirBuilderExt, FileTypeExt, MetadataExt, PermissionsExt};
use std::os::unix::net::UnixListener;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use control::{Connection, RequestFault, connect};
use host::LONGEST_SOCKET_PATH;
use nix::unistd::Group;
use rustix::fs::{FlockOperation, Gid, chown, flock};
use rustix::io::Errno;

use super::decode::fault;
use crate::codes;

/// Who may do what with the socket: the owner and the group may connect, which is to write to it.
const SOCKET_MODE: u32 = 0o660;
/// The same of a folder that is made for it.
const FOLDER_MODE: u32 = 0o750;
/// How long another program may hold the lock on the socket's folder: a rig that starts or ends needs it for milliseconds.
const TURN: Duration = Duration::from_secs(2);
/// How often the lock is asked for: the kernel has no wait for it with a limit.
const ASK: Duration = Duration::from_millis(10);

/// A socket that listens. Its file goes when this does, if it is still its own.
#[derive(Debug)]
pub(super) struct Socket {
    path: PathBuf,
    /// The file: device and number.
    file: (u64, u64),
}

impl Socket {
    /// Makes the socket. One that a dead rig left is taken over; one that a rig still serves is not, nor is any other
    /// file.
    ///
    /// # Errors
    /// Somebody serves it; it cannot be made; the group does not exist or cannot be given to it.
    pub(super) fn bind(path: &Path, group: Option<&str>) -> Result<(Socket, UnixListener), RequestFault> {
        let path = std::path::absolute(path).map_err(|error| refused(path, &error))?;
        let group = group.map(group_of).transpose()?;
        let folder = path.parent().unwrap_or(Path::new("/"));
        if path.file_name().is_none() {
            return Err(refused(&path, &io::Error::from(ErrorKind::IsADirectory)));
        }
        // Made under another name, with its permissions, and then renamed: nobody can connect before they are right,
        // and there is no instant without a socket.
        let half = folder.join(format!(".rig-{}", std::process::id()));
        for path in [&path, &half] {
            if path.as_os_str().len() > LONGEST_SOCKET_PATH {
                let message =
                    format!("the path of the socket {} is longer than the kernel takes", path.display());
                let help = "name a shorter `socket` under `[control]`, as in \"/run/scanrig/rig.sock\"";
                return Err(fault(codes::SOCKET, message, help));
            }
        }
        make_folder(folder, group).map_err(|error| refused(&path, &error))?;
        let _turn = Turn::take(folder).map_err(|error| match error.kind() {
            ErrorKind::WouldBlock => held(&path, folder),
            _ => refused(&path, &error),
        })?;
        unserved(&path)?;
        let (listener, file) = make(&half, &path, group).map_err(|error| {
            let _ = fs::remove_file(&half);
            refused(&path, &error)
        })?;
        Ok((Socket { path, file }, listener))
    }

    /// Where it is.
    pub(super) fn path(&self) -> &Path {
        &self.path
    }
}

impl Drop for Socket {
    fn drop(&mut self) {
        let Some(folder) = self.path.parent() else { return };
        let Ok(_turn) = Turn::take(folder) else { return };
        // Without the turn the file stays: the next rig takes over a socket that nobody serves.
        // Another rig may have taken its place, where somebody removed the file meanwhile.
        if fs::symlink_metadata(&self.path).is_ok_and(|found| (found.dev(), found.ino()) == self.file) {
            let _ = fs::remove_file(&self.path);
        }
    }
}

/// Alone with a folder: of two rigs that start at once, one sees the other's socket.
struct Turn(#[expect(dead_code, reason = "the lock ends when the file is closed")] File);

impl Turn {
    /// Waits for the turn, no longer than [`TURN`]: anybody who may open the folder may lock it, and for good.
    fn take(folder: &Path) -> io::Result<Turn> {
        let folder = File::open(folder)?;
        let until = Instant::now() + TURN;
        loop {
            match flock(&folder, FlockOperation::NonBlockingLockExclusive) {
                Ok(()) => return Ok(Turn(folder)),
                Err(Errno::INTR) => {}
                Err(Errno::WOULDBLOCK) if Instant::now() < until => std::thread::sleep(ASK),
                Err(error) => return Err(error.into()),
            }
        }
    }
}

fn make_folder(folder: &Path, group: Option<Gid>) -> io::Result<()> {
    if folder.is_dir() {
        return Ok(());
    }
    DirBuilder::new().recursive(true).mode(FOLDER_MODE).create(folder)?;
    if let Some(group) = group {
        chown(folder, None, Some(group))?;
    }
    Ok(())
}

/// Refuses what is there, unless it is a socket that nobody serves.
fn unserved(path: &Path) -> Result<(), RequestFault> {
    match fs::symlink_metadata(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(()),
        Err(error) => return Err(refused(path, &error)),
        Ok(found) if !found.file_type().is_socket() => {
            let message = format!("{} is there, and is no socket", path.display());
            return Err(fault(codes::SOCKET, message, "name another `socket`, or remove the file"));
        }
        Ok(_) => {}
    }
    match connect(path, Duration::ZERO) {
        Err(error) if error.kind() == ErrorKind::ConnectionRefused => Ok(()),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(()),
        Err(error) => Err(refused(path, &error)),
        // A rig that stands still takes no connection, and has its socket all the same.
        Ok(Connection::Open(_) | Connection::NotTaken) => {
            let message = format!("a rig that runs serves {}", path.display());
            Err(fault(codes::SERVED, message, "end it, or give this rig another `socket`"))
        }
    }
}

fn make(half: &Path, path: &Path, group: Option<Gid>) -> io::Result<(UnixListener, (u64, u64))> {
    match fs::remove_file(half) {
        Err(error) if error.kind() != ErrorKind::NotFound => return Err(error),
        _ => {}
    }
    let listener = UnixListener::bind(half)?;
    if let Some(group) = group {
        chown(half, None, Some(group))?;
    }
    fs::set_permissions(half, Permissions::from_mode(SOCKET_MODE))?;
    let made = fs::symlink_metadata(half)?;
    fs::rename(half, path)?;
    listener.set_nonblocking(true)?;
    Ok((listener, (made.dev(), made.ino())))
}

/// Whether this machine has a group of this name.
///
/// # Errors
/// It has none, or cannot say.
pub fn check_group(name: &str) -> Result<(), RequestFault> {
    group_of(name).map(drop)
}

fn group_of(name: &str) -> Result<Gid, RequestFault> {
    let help = "make it, as with `sudo groupadd --system scanrig`, or name another `group` under `[control]`";
    match Group::from_name(name) {
        Ok(Some(group)) => Ok(Gid::from_raw(group.gid.as_raw())),
        Ok(None) => Err(fault(codes::GROUP, format!("the machine has no group {name}"), help)),
        Err(error) => {
            Err(fault(codes::GROUP, format!("the group {name} cannot be looked up: {error}"), help))
        }
    }
}

fn held(path: &Path, folder: &Path) -> RequestFault {
    let message = format!(
        "the socket {} cannot be made: another program has had the folder {} locked for {} s",
        path.display(),
        folder.display(),
        TURN.as_secs()
    );
    fault(
        codes::SOCKET,
        message,
        "end that program (`lslocks` lists who holds what), or name a `socket` elsewhere",
    )
}

fn refused(path: &Path, error: &io::Error) -> RequestFault {
    let message = format!("the socket {} cannot be made: {error}", path.display());
    fault(codes::SOCKET, message, "name a `socket` in a folder that the rig may write to")
}
