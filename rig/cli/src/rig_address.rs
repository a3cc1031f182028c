//! Which of the running rigs a client connects to.

use clap::Args;
use control::client::{PATIENCE, by_name, only};
use control::{ClientError, ControlClient};
use runtime::suite::{self, Disk};
use signal::Span;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// How often a rig that is waited for is looked for.
const POLL: Duration = Duration::from_millis(20);

/// The rig that the command line names; the only one that runs where it names none.
#[derive(Clone, Debug, Default, Args)]
pub struct RigAddress {
    /// The rig at this socket.
    #[arg(long, value_name = "PATH", global = true)]
    pub socket: Option<PathBuf>,
    /// The rig of this board: its file, or the file's name without `.toml`.
    #[arg(long, value_name = "FILE|NAME", global = true, conflicts_with = "socket")]
    pub board: Option<PathBuf>,
    /// Wait at most this long for the rig to start.
    #[arg(long, value_name = "TIME", global = true, value_parser = crate::duration::above_zero)]
    pub wait: Option<Span>,
}

impl RigAddress {
    /// Connects under a name, once the rig is there if it may be waited for.
    ///
    /// # Errors
    /// See [`ControlClient::connect`]; and nobody said which rig, and there is none or more than one.
    pub fn connect(&self, name: &str) -> Result<ControlClient, ClientError> {
        let mut client = self.open()?;
        client.hello(name)?;
        Ok(client)
    }

    /// Connects as [`RigAddress::connect`] does, without a greeting.
    ///
    /// # Errors
    /// See [`RigAddress::connect`].
    pub fn open(&self) -> Result<ControlClient, ClientError> {
        let patience =
            self.wait.map_or(Duration::ZERO, |wait| Duration::from_nanos(wait.as_nanos().unsigned_abs()));
        let until = Instant::now() + patience;
        loop {
            match self.now() {
                Err(error) if may_come(&error) && Instant::now() < until => std::thread::sleep(POLL),
                met => return met,
            }
        }
    }

    fn now(&self) -> Result<ControlClient, ClientError> {
        match (&self.socket, &self.board) {
            (Some(socket), _) => ControlClient::meet(socket, PATIENCE),
            (None, Some(board)) => ControlClient::meet(&socket_of_board(board), PATIENCE),
            (None, None) => only(),
        }
    }
}

/// Whether trying again may help: the rig has not started yet.
fn may_come(error: &ClientError) -> bool {
    match error {
        ClientError::NoRig(_) => true,
        ClientError::Unreachable(_, kind) => {
            matches!(kind, ErrorKind::NotFound | ErrorKind::ConnectionRefused)
        }
        _ => false,
    }
}

/// The socket of a board: the one that its file names, if that can be read and does; else the usual one.
fn socket_of_board(board: &Path) -> PathBuf {
    let named = if board.is_file() {
        let read = suite::load_board(&Disk, &board.to_string_lossy(), &mut Vec::new());
        read.ok().and_then(|(file, _)| file.control.socket)
    } else {
        None
    };
    named.unwrap_or_else(|| by_name(board))
}
