//! How a socket is served.

use std::path::PathBuf;
use std::time::Duration;

/// What happens when the connection to a client is lost that had forced something and said nothing of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OnDisconnect {
    /// Its forces stay.
    #[default]
    Keep,
    /// They end.
    Release,
    /// They end, and the application is stopped.
    Stop,
}

impl OnDisconnect {
    /// Each of them, by its name in a board file.
    pub const NAMES: [(&str, OnDisconnect); 3] =
        [("keep", OnDisconnect::Keep), ("release", OnDisconnect::Release), ("stop", OnDisconnect::Stop)];

    /// Its name in a board file.
    pub fn name(self) -> &'static str {
        Self::NAMES.iter().find(|(_, one)| *one == self).map_or("", |(name, _)| name)
    }
}

/// How a socket is served.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SocketSettings {
    /// The socket.
    pub socket: PathBuf,
    /// The group whose members may use it; that of the process if none is named.
    pub group: Option<String>,
    /// What happens when a client is lost.
    pub on_disconnect: OnDisconnect,
    /// The folder in which the lock outlasts the rig; without one it ends with it.
    pub state: Option<PathBuf>,
    /// How much clients may ask for.
    pub limits: ClientLimits,
}

impl SocketSettings {
    /// The socket with everything else as it is when nobody says otherwise.
    pub fn of(socket: PathBuf) -> SocketSettings {
        SocketSettings {
            socket,
            group: None,
            on_disconnect: OnDisconnect::default(),
            state: None,
            limits: ClientLimits::default(),
        }
    }
}

/// How much clients may ask for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ClientLimits {
    /// Clients at once.
    pub clients: usize,
    /// Subscriptions of one client.
    pub subscriptions: usize,
    /// Signals in all subscriptions of one client, and names in one request.
    pub names: usize,
    /// Changes of a subscription to every change that wait for a client.
    pub changes: usize,
    /// Bytes that wait for a client before it is sent nothing more, and before its next request is looked at.
    pub queue: usize,
    /// How long a client may leave an answer unread before it is cut off.
    pub patience: Duration,
}

impl Default for ClientLimits {
    fn default() -> Self {
        ClientLimits {
            clients: 64,
            subscriptions: 32,
            names: 2_000,
            changes: 4_096,
            queue: 64 * 1024,
            patience: Duration::from_secs(5),
        }
    }
}
