//! Connecting to a socket without a wait that nobody ends.

use rustix::io::Errno;
use rustix::net::{AddressFamily, SocketAddrUnix, SocketFlags, SocketType, connect as ask, socket_with};
use std::io;
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::time::{Duration, Instant};

/// How often a connection is asked for: the kernel has no wait for it with a limit that all its versions keep.
const ASK: Duration = Duration::from_millis(10);

/// What became of a wish to connect.
#[derive(Debug)]
pub enum Connection {
    /// It is open.
    Open(UnixStream),
    /// Somebody listens, but took no connection in this time: its backlog is full, as that of a process that stands still.
    NotTaken,
}

/// Connects to the socket of a path, and waits for a place in its backlog no longer than `patience`.
///
/// # Errors
/// What the kernel says: no such socket, nobody who listens, or no permission.
pub fn connect(path: &Path, patience: Duration) -> io::Result<Connection> {
    let address = SocketAddrUnix::new(path)?;
    let until = Instant::now() + patience;
    loop {
        let flags = SocketFlags::CLOEXEC | SocketFlags::NONBLOCK;
        let socket = socket_with(AddressFamily::UNIX, SocketType::STREAM, flags, None)?;
        match ask(&socket, &address) {
            Ok(()) => {
                let stream = UnixStream::from(socket);
                stream.set_nonblocking(false)?;
                return Ok(Connection::Open(stream));
            }
            Err(Errno::INTR) => {}
            Err(Errno::AGAIN) if Instant::now() < until => std::thread::sleep(ASK),
            Err(Errno::AGAIN) => return Ok(Connection::NotTaken),
            Err(error) => return Err(error.into()),
        }
    }
}
