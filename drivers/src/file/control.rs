//! What a board file says of the control socket: `[control]`.

use std::path::PathBuf;

use document::{Fields, Findings};

use super::codes;

/// What happens when the connection to a client is lost that had forced something.
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

/// How the control socket of a rig that is kept running is served.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ControlSettings {
    /// The socket; the usual one if none is named.
    pub socket: Option<PathBuf>,
    /// The group whose members may use it.
    pub group: Option<String>,
    /// What happens when a client is lost.
    pub on_disconnect: OnDisconnect,
    /// How many clients there may be at once; the usual number if left out.
    pub clients: Option<u16>,
}

/// Reads the table.
pub(super) fn read(fields: Option<Fields>, out: &mut Findings) -> ControlSettings {
    let Some(fields) = fields else { return ControlSettings::default() };
    let socket = fields.text("socket");
    if let Some((path, node)) = socket.zip(fields.get("socket"))
        && !path.starts_with('/')
    {
        let message = format!("\"{path}\" is no whole path");
        out.bad(codes::DOCUMENT.unreadable, node, message, "write as in \"/run/scanrig/rig.sock\"");
    }
    ControlSettings {
        socket: socket.map(PathBuf::from),
        group: fields.text("group").map(str::to_owned),
        on_disconnect: match fields.text("on-disconnect") {
            Some("release") => OnDisconnect::Release,
            Some("stop") => OnDisconnect::Stop,
            _ => OnDisconnect::Keep,
        },
        clients: fields.integer("clients").and_then(|clients| u16::try_from(clients).ok()),
    }
}
